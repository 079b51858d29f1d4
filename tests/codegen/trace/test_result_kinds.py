"""The kind of a product is the one that exact points prove, whichever kernel serves it."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import bladesmith as bs
from bladesmith.codegen.algebra.algebra import Kind
from bladesmith.codegen.generator import generate
from bladesmith.common.dtypes import F64
from bladesmith.core.registry import load_algebra
from bladesmith.dispatch import plans
from bladesmith.dispatch.specialization import operation_formula

STOCK = ["cga3d", "cga2d", "pga3d"]
#: The example of docs/algebra/specs.md, and one whose kernel on layouts has blades that vanish for members.
SPEC = """
name = "pga2d"
vectors = ["0", "1", "2"]
metric = [["1", "1", 1], ["2", "2", 1]]
pseudoscalar = "e120"

[kinds.line]
grades = [1]
constraints = ["x * x - 1"]
member = "unit(e1, e2) + scalar() * e0"

[kinds.motor]
grades = [0, 2]
constraints = ["x * ~x - 1"]
member = "(unit(e1, e2) + scalar() * e0) * (unit(e1, e2) + scalar() * e0)"

[[kernels]]
formula = "products.geometric"
operands = [["motor", "motor"], ["layout line", "line"]]

[[kernels]]
formula = "products.sandwich"
operands = [["layout line", "layout line"], ["motor", "layout line"]]
"""


def operands(algebra: Any) -> list[Kind]:
    """All kinds, and the layouts of those that have constraints."""
    kinds = list(algebra.kinds.values())
    return list(dict.fromkeys([*kinds, *(k.layout for k in kinds)]))


def served(algebra: Any) -> Iterator[tuple[str, Any, Any]]:
    """Operations and types that a generated kernel serves, of rotors as motors too."""
    for operation in plans.FORMULAS:
        for a in operands(algebra):
            for b in operands(algebra):
                types = algebra.type_of(a, F64), algebra.type_of(b, F64)
                held = operation == "sandwich" and plans._sandwich_via_superkind(*types) is not None
                if plans._stock(operation, *types) or held:
                    yield operation, *types


def ones(kind: Any) -> Any:
    return kind.algebra.wrap(kind.kind, np.ones(kind.size))


def wrong(algebra: Any, pairs: Any) -> list[Any]:
    """Products whose type is not that of the proof."""
    found = []
    for operation, a, b in pairs:
        proved = algebra.result_kind(operation_formula(operation), (a.kind, b.kind))
        with np.errstate(all="ignore"):
            result = plans.plan(operation, ones(a), ones(b))(ones(a), ones(b))
        if result._type is not algebra.type_of(proved, F64):
            found.append((operation, a, b, result.kind, proved))
    return found


@pytest.mark.parametrize("name", STOCK)
def test_kernels_say_what_the_proof_says(name: str) -> None:
    algebra = getattr(bs, name)
    pairs = list(served(algebra))
    assert len(pairs) > 15 and not wrong(algebra, pairs)


@pytest.mark.parametrize("name", STOCK)
def test_all_other_products_too(name: str) -> None:
    algebra = getattr(bs, name)
    random = np.random.default_rng(0)
    kinds = [k for k in operands(algebra) if k.size <= 16]
    pairs = [
        (operation, *(algebra.type_of(kinds[i], F64) for i in random.integers(0, len(kinds), 2)))
        for operation in plans.FORMULAS
        for _ in range(12)
    ]
    assert not wrong(algebra, pairs)


def test_stock_results_are_recorded() -> None:
    """No proof is made at the first call of a product that a stock kernel serves."""
    for name in STOCK:
        for formula, entries in getattr(bs, name).stock.entries.items():
            module, _, operation = formula.partition(".")
            if module == "products" and len(entries[0].inputs) == 2 and operation in (*plans.FORMULAS,):
                assert all(entry.results is not None for entry in entries)


def test_rotors_of_conformal_space_stay_rotors() -> None:
    cga = bs.cga3d
    r = (cga.dilator(2.0) * cga.translator([1.0, 2.0, 3.0])).as_kind("rotor_conformal")
    product = r * r
    assert product.kind == cga.kind("rotor_conformal") and (product * ~product).isclose(1.0, rtol=1e-14)


@pytest.fixture(scope="module", params=[True, False])
def plane(request: Any, tmp_path_factory: Any) -> Any:
    """The algebra of the documented example, with the results that its manifest records and without."""
    folder: Path = tmp_path_factory.mktemp("generated") / "pga2d"
    folder.mkdir()
    for file, text in generate(tomllib.loads(SPEC)).items():
        (folder / file).parent.mkdir(exist_ok=True)
        (folder / file).write_text(text if request.param else text.replace('"results"', '"elsewhere"'))
    return load_algebra(folder)


def test_a_weaker_kernel_does_not_weaken_the_kind(plane: Any) -> None:
    random = np.random.default_rng(1)
    angle, offset = random.normal(size=(2, 2, 50))
    rows = np.stack([offset, np.cos(angle), np.sin(angle)], -1)
    a, b = (plane.multivector(r, blades=["e0", "e1", "e2"]).as_kind("line") for r in rows)
    assert (a * b).kind == plane.kind("motor") and ((a * b) * (a * b)).kind == plane.kind("motor")
    free = a.copy()
    assert (free * b).kind.is_layout and (free * b).isclose(a * b, rtol=1e-14).all()
    assert (a >> b).kind == plane.kind("line") and ((a * b) >> a).kind == plane.kind("line")
    assert (free >> b).kind.is_layout  # with blades that vanish for lines
    assert (a >> b).isclose((free >> b), rtol=1e-14, atol=1e-14).all()
    assert not wrong(plane, served(plane))
