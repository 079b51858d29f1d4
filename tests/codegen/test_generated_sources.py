"""The checked-in sources are what the generator writes; specs with bad names never get that far."""

from __future__ import annotations

import json
from importlib import import_module, resources
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bladesmith.codegen.algebra.loader import STOCK, algebra_from_data
from bladesmith.codegen.algebra.members import NumericSource, sample
from bladesmith.codegen.algebra.schema import load_spec, stock_spec_path
from bladesmith.codegen.build.flags import compiled_files, source_hash, unit_file
from bladesmith.codegen.build.installed import is_fresh, linked_units
from bladesmith.codegen.compiler import bind_library
from bladesmith.codegen.declarations import declared_kernels, omissions, plain_spec
from bladesmith.codegen.errors import BladesmithError, SpecError
from bladesmith.codegen.generator import generate, generate_programs
from bladesmith.codegen.targets.c.printer import symbol
from bladesmith.codegen.trace.trace import trace
from bladesmith.core.registry import stock_algebra

GENERATED = Path(str(resources.files("bladesmith.generated")))
TEMPLATES = Path(str(resources.files("bladesmith.templates")))
LARGEST = algebra_from_data(plain_spec(5, 0, 0, "largest"))  # of plain algebras with all kernels


@pytest.mark.slow
@pytest.mark.parametrize("name", STOCK)
def test_regenerating_gives_the_same_bytes(name: str) -> None:
    folder = GENERATED / name
    files = generate(load_spec(stock_spec_path(name)), json.loads((folder / "variants.json").read_text("utf-8")))
    for file, text in files.items():
        assert (folder / file).read_text("utf-8") == text, f"{name}/{file} differs: run `bladesmith generate`"


@pytest.mark.slow
def test_general_programs_are_up_to_date() -> None:
    for name, files in generate_programs().items():
        for file, text in files.items():
            assert (GENERATED / name / file).read_text("utf-8") == text, f"{name}/{file}: run `bladesmith generate`"


@pytest.mark.parametrize("name", STOCK)
def test_installed_extensions_are_of_these_sources(name: str) -> None:
    module = import_module(f"bladesmith.generated.{name}._kernels")
    assert is_fresh(module, GENERATED / name)
    units = linked_units(module)
    if name == "cga3d":  # others are compiled at first use
        assert {"products", "conformal"} <= {unit[0] for unit in units}
    for formulas, instance, made_of in units:
        texts = compiled_files(GENERATED / name, TEMPLATES / "c", [unit_file(formulas)])
        assert made_of == source_hash(texts), f"{formulas} for {instance}"


def test_generated_files_stay_small() -> None:
    """Loops of registration, merging, the tracer's tree and roots are among them, printed from algorithms."""
    assert sum(p.stat().st_size for p in GENERATED.rglob("*") if p.suffix in (".c", ".h", ".py", ".json")) < 6_250_000


@pytest.mark.slow
@pytest.mark.parametrize("pqr", [(2, 0, 1), (1, 3, 0), (4, 2, 0)])
def test_a_plain_signature_generates(pqr: tuple[int, int, int]) -> None:
    files = generate(plain_spec(*pqr, "plain"))
    assert "plain_geometric_vector_vector" in files["kernels/products.c"]
    assert json.loads(files["manifest.json"])["algebra"]["name"] == "plain"


BAD: list[dict[str, Any]] = [
    {"name": "a b"},
    {"name": "x\n#include <evil>"},
    {"vectors": ["1", "1"]},
    {"vectors": ["1", "e;"]},
    {"metric": [["1", "7", 1]]},
    {"kinds": {"my kind": {"grades": [1]}}},
    {"kinds": {"k": {"grades": [1], "constraints": ["x * x - 1"]}}},
    {"kinds": {"k": {"blades": ["e99"]}}},
    {"kinds": {"k": {}}},
    {"kernels": [{"formula": "os.system", "operands": [["vector"]]}]},
    {"kernels": [{"formula": "products.nothing", "operands": [["vector", "vector"]]}]},
    {"kernels": [{"formula": "products.Multivector", "operands": [["vector", "vector"]]}]},
    {"kernels": [{"formula": "products.geometric", "operands": [["vectr", "vector"]]}]},
    {"kernels": [{"formula": "products.geometric", "operands": [["vector", "vector"]], "name": "a-b"}]},
    {"kernels": [{"formula": "products.geometric", "operands": [["vector", "vector"], ["vector", "vector"]]}]},
    {"kernels": [{"formula": "../products.geometric", "operands": [["vector", "vector"]]}]},
]


@pytest.mark.parametrize("change", BAD, ids=str)
def test_bad_specs_are_refused(change: dict[str, Any]) -> None:
    good = {"name": "good", "vectors": ["1", "2"], "metric": [["1", "1", 1]]}
    generate(good)
    with pytest.raises(BladesmithError) as caught:
        generate({**good, **change})
    assert str(caught.value).endswith((".", "?"))


def test_a_spec_file_is_checked_with_line_and_key(tmp_path: Path) -> None:
    path = tmp_path / "bad.toml"
    path.write_text('name = "a"\nvectors = ["1"]\n\n[kinds.k]\ngradez = [1]\n')
    with pytest.raises(SpecError, match=r"line 5.*gradez.*grades"):
        load_spec(path)


@pytest.mark.parametrize(("algebra", "kind", "blade"), [("cga3d", "point", "e1"), ("pga3d", "point", "e012")])
def test_reduced_kernels_off_the_constraint(algebra: str, kind: str, blade: str) -> None:
    """With |M ~M - 1| = d, a reduced kernel is off by at most 4 d |M|^2 |x| (largest coefficients)."""
    spec = load_spec(stock_spec_path(algebra))
    home = algebra_from_data(spec)
    declared = next(d for d in declared_kernels(home, spec["kernels"]) if d.name == f"sandwich_motor_{kind}")
    kinds = declared.kinds
    kernel = trace(declared.formula, kinds, declared.name, algebra=home)
    stock = stock_algebra(algebra).stock
    assert stock is not None and stock.library is not None
    compiled = bind_library(stock.library, kernel, symbol(kernel))
    source = NumericSource(500, 11)
    motor, x = (np.stack([np.broadcast_to(v, (500,)) for v in k.values(sample(k, source))], -1) for k in kinds)
    for size in (1e-12, 1e-9, 1e-6, 1e-3):
        off = motor * (1 + size * np.random.default_rng(1).normal(size=(500, 1)))
        written = np.stack(kernel.reference(source.ring, [list(off.T), list(x.T)])[0], -1)
        squares = off * off
        away = np.abs(_square(home, kinds[0].blades, squares) - 1)
        scale = np.abs(off).max(-1) ** 2 * np.abs(x).max(-1)
        error = np.abs(compiled(off, x) - written).max(-1)
        assert np.all(error <= 4 * (away + 1e-13) * scale), f"{size}: {np.max(error / (away * scale))}"


def _square(home: Any, blades: tuple[int, ...], squares: np.ndarray) -> np.ndarray:
    """<M ~M>_0 from squared coefficients; blades with a null vector do not count."""
    total = np.zeros(len(squares))
    for j, b in enumerate(blades):
        sign = sum(w for c, w in home.product(b, b) if c == 0)
        total += float(sign) * (-1 if b.bit_count() & 2 else 1) * squares[:, j]
    return total


@pytest.mark.parametrize("pqr", [(1, 0, 0), (2, 0, 1), (3, 1, 0), (5, 0, 0), (6, 0, 0), (9, 0, 2)], ids=str)
def test_what_a_signature_leaves_out_is_what_is_not_there(pqr: tuple[int, int, int]) -> None:
    """Everything that some plain algebra has is either generated or named, with its reason, and never both."""
    spec = plain_spec(*pqr, "plain")
    algebra = algebra_from_data(spec)
    found = {
        "kernels": {d.name for d in declared_kernels(algebra, spec["kernels"])},
        "kinds": {name for name in algebra.kinds if not name.startswith("grade")},
    }
    *named, geometry = omissions(*pqr)
    for what, everything in (
        ("kernels", {d.name for d in declared_kernels(LARGEST, plain_spec(5, 0, 0, "largest")["kernels"])}),
        ("kinds", set(LARGEST.kinds)),
    ):
        absent = {name for each in named if each.what == what for name in each.names}
        assert absent | found[what] == everything and not absent & found[what]
    assert all(each.reason for each in named) and not set(geometry.names) & found["kinds"]
    texts = [str(each) for each in (*named, geometry)]
    presets = {(2, 0, 1): "bladesmith.pga2d has them", (3, 1, 0): "bladesmith.cga2d has them"}
    assert presets.get(pqr, "declare them in a spec") in texts[-1]
    if sum(pqr) > 5:
        assert "geometric_multivector_multivector" in texts[0] and "by table" in texts[0]
