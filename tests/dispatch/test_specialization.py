"""Products and formulas that are specialised, compiled or refused by size and use; stock kernels; algebras on disk."""

from __future__ import annotations

import logging
import pickle
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import bladesmith as bs
from bladesmith.codegen.build.toolchain import compiler
from bladesmith.codegen.execute.bound_kernels import BoundKernel
from bladesmith.dispatch import formulas, plans, specialization, stock_kernels


def test_fifteen_dimensions_typed() -> None:
    start = time.process_time()
    alg = bs.algebra(9, 6)
    random = np.random.default_rng(0)
    vectors = alg.multivector(random.normal(size=(10, 15)), grades=[1])
    planes = alg.multivector(random.normal(size=(10, 105)), grades=[2])
    solids = vectors * planes
    assert solids.grades == (1, 3)
    again = vectors * vectors * planes
    assert again.isclose((vectors * vectors) * planes).all()
    square = planes * planes
    assert square.grades == (0, 2, 4)
    squares = vectors.values**2
    assert (vectors * vectors)["1"] == pytest.approx(squares[:, :9].sum(-1) - squares[:, 9:].sum(-1))
    assert time.process_time() - start <= 2.0


def test_too_many_terms_are_refused() -> None:
    alg = bs.algebra(9, 6)
    x = alg.multivector(np.ones(6435), grades=[7])
    with pytest.raises(bs.errors.SignatureError, match="too many terms"):
        x * x


def test_a_combination_used_much_is_specialised(monkeypatch: pytest.MonkeyPatch, caplog: Any) -> None:
    if compiler() is None:
        pytest.skip("no compiler")
    monkeypatch.setattr(specialization, "HOT_ITEMS", 1000)
    monkeypatch.delenv(specialization.SPECIALISE_VARIABLE, raising=False)
    alg = bs.algebra(2, 0, 2)
    x, y = (alg.multivector(np.random.default_rng(i).normal(size=(600, 6)), grades=[2]) for i in range(2))
    first = x * y
    with caplog.at_level(logging.INFO, "bladesmith"):
        second = x * y
        third = x * y
    lines = [r.getMessage() for r in caplog.records if "specialised" in r.getMessage()]
    assert len(lines) == 1 and "after 1200 items" in lines[0]
    assert second.kind == first.kind and second.isclose(first, rtol=1e-14).all()
    assert third.isclose(first, rtol=1e-14).all()


def test_specialisation_can_be_switched_off(monkeypatch: pytest.MonkeyPatch, caplog: Any) -> None:
    monkeypatch.setattr(specialization, "HOT_ITEMS", 10)
    monkeypatch.setenv(specialization.SPECIALISE_VARIABLE, "0")
    alg = bs.algebra(1, 1, 2)
    x = alg.multivector(np.ones((50, 4)), grades=[3])
    with caplog.at_level(logging.INFO, "bladesmith"):
        x * x
    assert not [r for r in caplog.records if "specialised" in r.getMessage()]


def test_a_formula_used_much_is_compiled(monkeypatch: pytest.MonkeyPatch, caplog: Any) -> None:
    if compiler() is None:
        pytest.skip("no compiler")
    cga = bs.cga3d
    monkeypatch.setattr(formulas, "WORTH_COMPILING", 150)
    monkeypatch.setattr(cga, "targets", {})
    mirror = cga.circle([0.0, 0.0, 1.0], [0.0, 0.0, 1.0], 2.0)
    points = cga.point(np.random.default_rng(0).normal(size=(100, 3)))
    entries = cga.stock.entries.get("versors.reflect", ()) if cga.stock else ()
    assert all(e.inputs != (points.kind, mirror.kind) for e in entries)
    first = points.reflect(mirror)
    with caplog.at_level(logging.INFO, "bladesmith"):
        second = points.reflect(mirror)
    assert any("compiling" in r.getMessage() for r in caplog.records)
    assert second.kind == first.kind and second.isclose(first, rtol=1e-12).all()


def test_stock_kernels_serve_their_kinds() -> None:
    cga = bs.cga3d
    if cga.stock is None or cga.stock.library is None:
        pytest.skip("the stock kernels are not built")
    motor, point = cga.kind("motor"), cga.kind("point")
    found = plans._stock("sandwich", cga.type_of(motor, np.dtype(float)), cga.type_of(point, np.dtype(float)))
    assert found is not None and found[1].inputs == (motor, point) and found[1].outputs[0].kind == point
    assert isinstance(found[0].bound(found[1]), BoundKernel)


def test_stock_kernels_run_without_their_extension(monkeypatch: pytest.MonkeyPatch) -> None:
    cga = bs.cga3d
    if cga.stock is None:
        pytest.skip("the stock kernels are not generated")
    compiled = cga.rotor([1.0, 2.0, 3.0], 0.3), cga.sphere(np.ones((5, 3)), [1.0, 2.0, -1.0, 3.0, 4.0])
    plain = stock_kernels.StockKernels(cga, cga.stock.folder, stock_kernels.read_manifest(cga.stock.folder))
    monkeypatch.setattr(stock_kernels.StockKernels, "library", None)
    monkeypatch.setattr(cga, "stock", plain)
    monkeypatch.setattr(cga, "targets", {})
    monkeypatch.setattr(plans, "PLANS", {})
    monkeypatch.setattr("bladesmith.core.operators.PLANS", plans.PLANS)
    slow = cga.rotor([1.0, 2.0, 3.0], 0.3), cga.sphere(np.ones((5, 3)), [1.0, 2.0, -1.0, 3.0, 4.0])
    assert isinstance(plain.bound(plain.entries["conformal.sphere"][0]), stock_kernels.PlainKernel)
    for a, b in zip(compiled, slow, strict=True):
        assert a.kind == b.kind and np.array_equal(a.status, b.status)
        assert np.array_equal(a.values, b.values, equal_nan=True)
    moved = slow[0] >> slow[1]
    assert moved.kind == cga.kind("sphere") and moved.shape == (5,) and np.isnan(moved.values[2]).all()


def test_algebras_of_one_name_are_kept_apart() -> None:
    """Their kinds compare equal; nothing that is remembered of one may serve the other."""
    made = []
    for square in (1, -1):
        data = {
            "name": "twin", "vectors": ["1", "2"], "metric": [["1", "1", square], ["2", "2", square]],
            "kinds": {"turn": {"grades": [0, 2], "constraints": ["x * ~x - 1"], "member": "unit(e1, e2) * e1"}},
        }  # fmt: skip
        if square == -1:
            data["kinds"]["turn"]["member"] = "-(unit(e1, e2) * e1)"  # type: ignore[index]
        made.append(bs.Algebra.from_data(data))
    for alg, square in zip(made, (1, -1), strict=True):
        x = alg.multivector({"1": 0.6, "e12": 0.8}, kind="turn")
        assert (x * x).kind.name == "turn" and (alg.e1 * alg.e1)["1"] == square
        assert (x >> alg.e1)["e1"] == pytest.approx(0.6**2 - 0.8**2)


def test_a_generated_folder_is_an_algebra(tmp_path: Path) -> None:
    if compiler() is None:
        pytest.skip("no compiler")
    from bladesmith.codegen.declarations import plain_spec
    from bladesmith.codegen.generator import generate

    spec = plain_spec(2, 0, 1, "pga2d_test")
    spec["kernels"] = [{"formula": "products.geometric", "operands": [["vector", "vector"]]}]
    for name, text in generate(spec).items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text, encoding="utf-8")
    alg = bs.load_algebra(tmp_path)
    assert alg is bs.load_algebra(tmp_path) and alg.stock is not None and alg.stock.library is not None
    x, y = (alg.multivector(np.random.default_rng(i).normal(size=(9, 3)), grades=[1]) for i in range(2))
    plain = bs.algebra(2, 0, 1)
    assert plain.multivector(x * y).isclose(plain.multivector(x) * plain.multivector(y)).all()
    assert pickle.loads(pickle.dumps(x)).algebra is alg
    with pytest.raises(bs.errors.SpecError, match="manifest.json"):
        bs.load_algebra(tmp_path / "nowhere")
    (tmp_path / "manifest.json").write_text("[]")
    with pytest.raises(bs.errors.SpecError, match="not a manifest"):
        stock_kernels.read_manifest(tmp_path)
