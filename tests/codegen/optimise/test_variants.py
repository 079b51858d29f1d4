"""Forms: each equals the formula, the cheap one is taken only when it is as accurate, records bring it back."""

from __future__ import annotations

import numpy as np
import pytest

from bladesmith.codegen.algebra.loader import algebra_from_data
from bladesmith.codegen.algebra.members import NumericSource, sample
from bladesmith.codegen.algebra.multivector import Multivector, sqrt
from bladesmith.codegen.algebra.schema import load_spec, stock_spec_path
from bladesmith.codegen.errors import SpecError
from bladesmith.codegen.ir.graph import evaluate
from bladesmith.codegen.optimise.accuracy import error_ratio
from bladesmith.codegen.optimise.variants import (
    ADMITTED_RATIO,
    as_written,
    select_variant,
    variants,
)
from bladesmith.codegen.rings.error_bound import BoundRing
from bladesmith.codegen.trace.kernel import Kernel
from bladesmith.codegen.trace.trace import trace

from ...support.formulas import sandwich

CGA = algebra_from_data(load_spec(stock_spec_path("cga3d")))
PGA = algebra_from_data(load_spec(stock_spec_path("pga3d")))


def move_point() -> Kernel:
    return trace(sandwich, [CGA.kind("motor"), CGA.kind("point")], name="move")


def test_every_form_has_the_value_of_the_formula() -> None:
    kernel = move_point()
    source = NumericSource(100, 1)
    values = {
        (i, j): v
        for i, item in enumerate(kernel.inputs)
        for j, v in enumerate(item.kind.values(sample(item.kind, source)))
    }
    written = np.stack([np.broadcast_to(v, 100) for v in evaluate(kernel.roots, values, source.ring)], -1)
    seen = []
    for form in variants(kernel):
        own = np.stack([np.broadcast_to(v, 100) for v in evaluate(form.roots, values, source.ring)], -1)
        np.testing.assert_allclose(own, written, rtol=1e-11, atol=1e-11)
        seen.append(form.name)
    assert seen[:3] == ["as_written", "local", "greedy"] and any(name.startswith("reduced") for name in seen)


def test_operation_counts_beat_the_formula_as_written() -> None:
    """The figures that the prototype reached: 46 + 28 for a motor on a point, 34 + 18 in PGA."""
    assert as_written(move_point()).operations.total == 76 + 59
    assert select_variant(move_point(), quick=True).operations.total <= 46 + 28
    pga = trace(sandwich, [PGA.kind("motor"), PGA.kind("point")], name="move")
    assert select_variant(pga, quick=True).operations.total <= 34 + 18


def test_a_cheaper_but_unstable_form_is_not_taken() -> None:
    """|x - y|^2 of near points: multiplied out it loses everything, and it is cheaper on unit vectors."""

    def squared_distance(x: Multivector, y: Multivector) -> Multivector:
        difference = x - y
        return difference.scalar_product(difference)

    kernel = trace(squared_distance, [PGA.kind("plane"), PGA.kind("plane")], name="distance")
    chosen = select_variant(kernel, quick=True)
    assert error_ratio(kernel, chosen.roots) <= ADMITTED_RATIO
    rejected = [f.name for f in variants(kernel) if error_ratio(kernel, f.roots) > ADMITTED_RATIO]
    assert rejected, "the unstable form was not even tried"


def test_bounds_contain_the_errors() -> None:
    kernel = move_point()
    source = NumericSource(200, 3, scale=1e3)
    rows = [item.kind.values(sample(item.kind, source)) for item in kernel.inputs]
    values = {(i, j): v for i, row in enumerate(rows) for j, v in enumerate(row)}
    double = evaluate(kernel.roots, values, source.ring)
    exact = evaluate(
        kernel.roots,
        {k: np.asarray(v, np.longdouble) for k, v in values.items()},
        NumericSource(1, 1, dtype=np.longdouble).ring,
    )
    bounds = evaluate(kernel.roots, {k: (v, 0.0) for k, v in values.items()}, BoundRing())
    for a, b, (_, limit) in zip(double, exact, bounds, strict=True):
        assert np.all(np.abs(a - b) <= limit * 2.0**-53 * 1.01)


def test_records_restore_the_form_and_refuse_another_formula() -> None:
    kernel = move_point()
    chosen = select_variant(kernel, quick=True)
    again = move_point()
    restored = select_variant(again, chosen.record())
    assert (restored.name, restored.operations) == (chosen.name, chosen.operations)
    other = trace(sandwich, [CGA.kind("motor"), CGA.kind("line")], name="move")
    with pytest.raises(SpecError, match="generate with --search"):
        select_variant(other, chosen.record())
    with pytest.raises(SpecError, match="damaged"):
        select_variant(move_point(), {**chosen.record(), "nodes": [["+", 5, "1"]]})


def test_a_shared_sum_may_be_an_output() -> None:
    def both(x: Multivector) -> tuple[Multivector, Multivector]:
        total = (x * x).grade(0) + 1
        return total, sqrt(total) + total * total

    kernel = trace(both, [PGA.layout("motor")], name="both")
    assert [f.name for f in variants(kernel)][:2] == ["as_written", "local"]
