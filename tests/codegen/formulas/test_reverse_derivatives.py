"""Reverse derivatives of stock kernels: against dual numbers with 50 digits, to the bound of their own rounding, finite
where forward derivatives are, and of at most four times the kernel's operations.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from functools import cache
from typing import Any

import numpy as np
import pytest

from bladesmith.codegen.algebra.members import sample
from bladesmith.codegen.api import KernelFunction
from bladesmith.codegen.checks.errors import compare, exact_rows
from bladesmith.codegen.checks.exact_items import ColumnRing
from bladesmith.codegen.checks.operands import operand_cases
from bladesmith.codegen.errors import TraceError
from bladesmith.codegen.rings.dual import DualRing
from bladesmith.codegen.rings.protocol import NumericRing, PrecisionRing, Ring
from bladesmith.codegen.trace.kernel import Kernel, operand, value_layouts
from bladesmith.codegen.trace.outputs import as_outputs

from ...support.effort import FULL
from ...support.targets.stock_kernels import all_kernels, declared

#: Most operations of a reverse derivative, in those of the kernel.
MOST = 4.0
DIGITS = 50
ITEMS = 12 if FULL else 6
#: What 50 digits leave of the pairing of tangents and cotangents, relative to its terms.
PAIRED = 1e-36
EXACT_ITEMS = 3


class ExactSource:
    """Numbers with 50 digits, from short random fractions: members hold their constraints to 50 digits."""

    def __init__(self, ring: ColumnRing, seed: int) -> None:
        self.ring, self.random = ring, np.random.default_rng(seed)

    def scalar(self) -> Any:
        return [self.ring.ring.constant(Fraction(float(x))) for x in self.random.normal(size=self.ring.items)]


@cache
def kernel_of(algebra: str, name: str) -> KernelFunction:
    formula, kinds, own, home = declared(algebra)[name]
    return KernelFunction(formula, kinds, None, own, home)


def numbers_like(counts: Sequence[int], source: ExactSource) -> list[list[Any]]:
    return [[source.scalar() for _ in range(count)] for count in counts]


def paired(rows: Sequence[Sequence[Any]], others: Sequence[Sequence[Any]], item: int) -> tuple[Any, Any]:
    """The sum of products of coefficients, and that of their sizes."""
    products = [
        a[item] * b[item] for row, other in zip(rows, others, strict=True) for a, b in zip(row, other, strict=True)
    ]
    return sum(products), sum(map(abs, products))


def forward_tangents(
    kernel: KernelFunction, ring: Ring, given: Sequence[Sequence[Any]], directions: Sequence[Sequence[Any]]
) -> list[list[Any]]:
    """Tangents of the values, from the formula on dual numbers."""
    dual = DualRing(ring)
    operands = [
        operand(i.kind, dual, list(zip(row, along, strict=True)), i.row)
        for i, row, along in zip(kernel.traced.inputs, given, directions, strict=True)
    ]
    zero = ring.constant(Fraction(0))
    results = [r for r in as_outputs(kernel.formula(*operands)) if r.role != "status"]
    tangents = []
    for result, layout in zip(results, value_layouts(kernel.outputs), strict=True):
        values = [v.scalar() for v in result.values] if layout.form == "numbers" else layout.values(result.value)
        tangents.append([zero if v[1] is None else v[1] for v in values])
    return tangents


def check_exactly(kernel: KernelFunction) -> None:
    """A tangent from dual numbers, paired with a cotangent, is its direction paired with what is pulled back."""
    ring = ColumnRing(PrecisionRing(DIGITS), EXACT_ITEMS)
    source, kinds = ExactSource(ring, 1), kernel.kinds
    given = [
        [source.scalar() for _ in range(k.size)] if k.form != "multivector" else k.values(sample(k, source))
        for k in kinds
    ]
    layouts = value_layouts(kernel.outputs)
    directions, cotangents = (numbers_like([k.size for k in each], source) for each in (kinds, layouts))
    tangents = forward_tangents(kernel, ring, given, directions)
    pulled = kernel.pullback().traced.evaluate_flat([v for row in (*given, *cotangents) for v in row], ring)
    for item in range(EXACT_ITEMS):
        forward, size = paired(tangents, cotangents, item)
        reverse, other = paired(pulled, directions, item)
        if forward == forward:  # no number of a root that is held at zero: the derivative of the zero is zero
            assert abs(forward - reverse) <= PAIRED * max(size, other)


def units(kernel: Kernel, members: Sequence[np.ndarray]) -> list[np.ndarray]:
    """The members, but versors are 1 and -1 in turn, and with them plain numbers 1 and 0."""
    found, signs = list(members), np.resize([1.0, -1.0], ITEMS)
    for n, (item, rows) in enumerate(zip(kernel.inputs, members, strict=True)):
        kind = item.kind
        if kind.form != "multivector":
            found[n] = (np.reshape(signs, (-1,) + (1,) * (rows.ndim - 1)) + 1) / 2 + np.zeros_like(rows)
        elif kind.blades[0] == 0 and not kind.is_layout:
            own = np.abs(signs) if any("x['1']" in text for text in kind.constraints) else signs
            found[n] = np.eye(kind.size)[:1] * own[:, None]
    return found


def check_rounding(kernel: KernelFunction) -> None:
    """Cotangents are as near to those with 50 digits as their formula's bound allows, and finite where tangents are."""
    pullback = kernel.pullback()
    traced, rng = pullback.traced, np.random.default_rng(2)
    run, reduced = pullback.on("numpy"), pullback.variant.name.startswith("reduced")
    cases = list(operand_cases(traced, np.float64, ITEMS))
    for case, arrays in (*cases, ("versors 1 and -1", units(traced, cases[0][1]))):
        found = run(*arrays)
        exact = exact_rows(traced, arrays)
        fault = compare(traced, arrays, found, exact, reduced).fault
        assert not fault, f"{case}, {fault}"
        given = [list(np.reshape(a, (ITEMS, -1)).T) for a in arrays[: len(kernel.kinds)]]
        directions = [list(rng.normal(size=(len(row), ITEMS))) for row in given]
        with np.errstate(all="ignore"):
            tangents = forward_tangents(kernel, NumericRing(), given, directions)
        forward = np.all([np.broadcast_to(np.isfinite(t), ITEMS) for row in tangents for t in row], axis=0)
        for values in found if isinstance(found, tuple) else (found,):
            assert np.isfinite(values[forward]).all(), f"{case}: not finite, and the forward derivative is"


#: Kernels of so few operations, because constraints hide what they depend on, that reverse derivatives take more.
EXCEPTIONS = {
    "cga3d_anchor_plane": 6.0,
    "pga3d_motor_to_matrix_translator": 6.0,
}


def check(algebra: str, name: str) -> None:
    kernel = kernel_of(algebra, name)
    check_exactly(kernel)
    check_rounding(kernel)
    assert kernel.pullback().operations.total <= EXCEPTIONS.get(name, MOST) * kernel.operations.total


@pytest.mark.slow
@pytest.mark.parametrize(("algebra", "name"), all_kernels()[:: 1 if FULL else 12], ids=lambda v: str(v))
def test_stock_kernel(algebra: str, name: str) -> None:
    check(algebra, name)


@pytest.mark.parametrize(
    "name", ["exp_bivector_twist", "log_motor_motor", "rotor_between_line_line", "bortz_rate_world_twist_twist"]
)
def test_some_kernels(name: str) -> None:
    check("cga3d", f"cga3d_{name}")


@pytest.mark.slow
@pytest.mark.parametrize(("algebra", "name"), all_kernels()[:: 1 if FULL else 80], ids=lambda v: str(v))
def test_reverse_derivative_of_a_reverse_derivative(algebra: str, name: str) -> None:
    pullback = kernel_of(algebra, name).pullback()
    if any(node.op in ("stumpff6", "stumpff7") for node in pullback.traced.graph.nodes):  # these have no derivatives
        with pytest.raises(TraceError, match="beyond stumpff7"):
            check_exactly(pullback)
        return
    check_exactly(pullback)
    check_rounding(pullback)
