"""Multivectors of a grade, blades by name, tables of products, random members, powers, printing."""

from __future__ import annotations

import pickle
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import cga3d, pga3d

STOCK = (bs.cga3d, bs.pga3d, bs.cga2d, bs.algebra(2, 1))


def test_grades() -> None:
    alg = bs.algebra(3)
    assert alg.vector([1, 2, 3]).isclose(alg.e1 + 2 * alg.e2 + 3 * alg.e3)
    assert alg.bivector({"e31": [1.0, 2.0]}).isclose(np.array([1.0, 2.0]) * alg.e31).all()
    assert alg.trivector([2.0]).isclose(2 * alg.I) and alg.pseudoscalar([1.0, 2.0]).shape == (2,)
    assert cga3d.vector([1, 2, 3, 4, 5], dtype="float32").dtype == np.float32
    for alg in STOCK:
        assert (alg.e1 ^ alg.e1.dual()).isclose(alg.I) or not alg.is_degenerate
        assert alg.scalar(2.0).dual().isclose(2 * alg.I)
    with pytest.raises(bs.errors.InputError, match="e1 is not of grade 2"):
        alg.bivector({"e1": 1.0})


def test_blades_by_name() -> None:
    assert cga3d.blades["e21"].isclose(-cga3d.e12) and cga3d.blades[1] == 1 and str(cga3d.blades[-1]) == "e123noni"
    assert {"e1", "no", "e123noni"} <= set(dir(cga3d)) and "e1" not in dir(bs.algebra(9))
    space: dict[str, Any] = {}
    space.update(bs.algebra(2).blades)
    assert sorted(space) == ["e1", "e12", "e2"] and space["e12"].isclose(bs.algebra(2).e12)
    assert pickle.loads(pickle.dumps(cga3d.blades)) is cga3d.blades
    with pytest.raises(bs.errors.BladeError, match="e9"):
        cga3d.blades["e9"]


@pytest.mark.parametrize("operation", ["geometric", "outer", "inner", "right_contraction", "regressive"])
def test_cayley_tables_are_the_products(operation: str) -> None:
    for alg in (bs.algebra(2, 0, 1), bs.algebra(metric=[[2, 1], [1, -1]])):
        table = alg.cayley(operation)
        everything = alg.multivector(np.eye(len(alg.blades)))
        expected = getattr(everything[:, None], {"geometric": "__mul__"}.get(operation, operation))(everything)
        dense = expected.as_kind(alg.layout("multivector")).values
        assert np.array_equal(table.to_array(), dense)


def test_cayley_tables_print() -> None:
    lines = str(bs.algebra(2).cayley()).splitlines()
    assert [line.split() for line in lines[1:]] == [
        ["1", "1", "e1", "e2", "e12"],
        ["e1", "e1", "1", "e12", "e2"],
        ["e2", "e2", "-e12", "1", "-e1"],
        ["e12", "e12", "-e2", "e1", "-1"],
    ]
    assert "<td>-e1</td>" in bs.algebra(2).cayley()._repr_html_()
    assert bs.algebra(metric=[[2, 1], [1, -1]]).cayley()._cells()[3][2] == "1 - e12"
    with pytest.raises(bs.errors.SignatureError, match="go to 8"):
        bs.algebra(9).cayley()
    with pytest.raises(bs.errors.InputError, match="geometric"):
        bs.algebra(2).cayley("cross")


def test_random_members() -> None:
    for alg in STOCK:
        for name, kind in alg.kinds.items():
            x = alg.random(name, (3, 40), seed=1)
            assert x.shape == (3, 40) and x.kind == kind and np.isfinite(x.values).all()
            assert x.as_kind(kind.layout).as_kind(name).kind == kind  # the constraints hold
    x = cga3d.random("motor", seed=np.random.default_rng(1))
    assert x.shape == () and x.isclose(cga3d.random("motor", seed=1)) and not x.isclose(cga3d.random("motor", seed=2))
    assert cga3d.random("point", 0).shape == (0,) and cga3d.random("point", dtype="float32").dtype == np.float32
    assert not cga3d.random().isclose(cga3d.random())
    with pytest.raises(bs.errors.ShapeError, match="n is -1"):
        cga3d.random("point", -1)
    for seed in (-1, "x", 0.5):
        with pytest.raises(bs.errors.InputError, match="seed"):
            cga3d.random("point", seed=seed)
    with pytest.raises(bs.errors.KindError, match="circle"):
        cga3d.random("circel")


def test_powers() -> None:
    R = cga3d.random("motor", 5, seed=3)
    assert (R**3).isclose(R * R * R).all() and (R**3).kind == cga3d.kind("motor")
    assert (R**-2).isclose(~R * ~R).all() and (R**0).isclose(1).all() and (R**1.0).isclose(R).all()
    assert (R**0.5).isclose(R.sqrt()).all() and ((R ** (1 / 3)) ** 3).isclose(R, rtol=1e-12).all()
    steps = R[0] ** np.linspace(0, 1, 4)
    assert steps.shape == (4,) and (steps[1] * steps[2]).isclose(R[0], rtol=1e-12)
    x = bs.algebra(3).random(n=4, seed=5)
    assert (x**5).isclose(x * x * x * x * x, rtol=1e-12).all() and (x**-1 * x).isclose(1, rtol=1e-9, atol=1e-9).all()
    assert (pga3d.e0**-1).status == bs.Status.SINGULAR and (pga3d.e0**-2).status == bs.Status.SINGULAR
    with pytest.raises(bs.errors.SingularError):
        pga3d.e0.power(-1, strict=True)
    for bad in (True, "a", None, 1j, 10**9):
        with pytest.raises(bs.errors.InputError):
            R**bad


def test_contractions() -> None:
    alg = bs.algebra(metric=[[2, 1, 0], [1, -1, 0], [0, 0, 1]])
    for a in alg.blades:
        for b in alg.blades:
            x, y = alg.multivector({a: 1.0}), alg.multivector({b: 1.0})
            right = (x * y).grade(a.grade - b.grade) if a.grade >= b.grade else alg.scalar(0.0)
            assert x.right_contraction(y).isclose(right)
            assert (~x.right_contraction(y)).isclose((~y).left_contraction(~x))


def test_printing() -> None:
    point = cga3d.point([1 / 3, 2, 3])
    with bs.print_options(unicode=True, digits=2):
        assert str(point) == "point of cga3d: 0.33 e\u2081 + 2 e\u2082 + 3 e\u2083 + 1 n\u2092 + 6.6 n\u221e"
        assert str(bs.algebra(12).e1_12).endswith("1 e\u2081e\u2081\u2082")
        assert "n\u2092n\u221e" in str(bs.algebra(metric={"no|ni": -1}, vectors="no ni").cayley())
        with bs.print_options(terms=1, edge=1):
            assert "..." in str(point) and str(cga3d.point(np.zeros((3, 3)))).count("\n") == 3
    assert str(point) == "point of cga3d: 0.333333 e1 + 2 e2 + 3 e3 + 1 no + 6.55556 ni"
    assert r"\mathbf{x\_1}" in bs.algebra(1, vectors="x_1").x_1._repr_latex_()
    try:
        bs.set_print_options(digits=3)
        assert "0.333 e1" in str(point)
    finally:
        bs.set_print_options(digits=6)
    for bad in ({"digits": 0}, {"digits": 18}, {"unicode": 1}, {"terms": "a"}, {"edge": 0}):
        with pytest.raises(bs.errors.InputError, match=next(iter(bad))):
            bs.set_print_options(**bad)


def test_logarithms_and_roots_of_numbers_that_are_no_rotors() -> None:
    x = bs.algebra(3).scalar([4.0, 1.0, -1.0])
    for found in (x.log(), x.sqrt(), x**0.5):
        assert list(found.status == bs.Status.OK) == [False, True, False]
        assert list(np.isnan(found.values[:, 0])) == [True, False, True]
    assert bs.algebra(3).scalar(4.0).log().status is bs.Status.INVALID
    with pytest.raises(bs.errors.NotARotorError):
        bs.algebra(0).scalar(2.0).log()


def test_whole_powers_in_other_types() -> None:
    v = bs.algebra(3).vector([1.0, 2.0, 3.0])
    for two in (np.float32(2), Fraction(2), np.int8(2), 2.0):
        assert (v**two).isclose(v * v)
