"""What quick starts of geometric algebra show, each in a few lines of a user."""

import numpy as np
import pytest
import sympy

import bladesmith as bs
from bladesmith import codegen
from bladesmith.errors import InputError

# -- what users of other packages missed: at most five lines each -----------------------------------------------------


def test_a_vector_to_a_power():
    alg = bs.algebra(2, 1)
    assert (alg.e1**2).isclose(1) and (alg.e3**2).isclose(-1) and (alg.e1**-1).isclose(alg.e1)


def test_an_algebra_of_any_metric():
    alg = bs.algebra(metric=[[2, 1], [1, "1/3"]])
    assert (alg.e1**2).isclose(2) and (alg.e1 | alg.e2).isclose(1) and (alg.e2**2).isclose(1 / 3)


def test_a_symbol_as_a_coefficient():
    a, b = sympy.symbols("a b")
    x = bs.algebra(3).multivector({"e1": a, "e2": b})
    assert (x * x).expressions == {"1": a**2 + b**2} and x.diff(a).expressions == {"e1": 1}


def test_blade_products_of_null_and_oblique_vectors():
    null = bs.algebra(metric={"no|ni": -1}, vectors="e1 e2 no ni")
    oblique = bs.algebra(metric=[[1, 1], [1, 3]])
    assert (null.no * null.no).isclose(0) and (null.no * null.ni + null.ni * null.no).isclose(-2)
    assert (oblique.e1 * oblique.e2).isclose(1 + oblique.e12) and (oblique.e12**2).isclose(1 - 3)


# -- space, as the quick start of `clifford` goes ---------------------------------------------------------------------


def test_blades_as_names_and_products():
    alg = bs.algebra(3)
    scope = dict(alg.blades)
    e1, e2, e3, e12 = (scope[name] for name in ("e1", "e2", "e3", "e12"))
    assert (e1 * e2).isclose(e12) and (e1 ^ e1).isclose(0) and (e1 | e1).isclose(1) and (e2 * e1).isclose(-e12)
    a = 1 + 2 * e1 + 3 * e12
    assert a.grade(2).isclose(3 * e12) and (~a).isclose(1 + 2 * e1 - 3 * e12) and a["e12"] == 3
    assert a.values.tolist() == [1, 2, 3] and [str(b) for b in a.blades] == ["1", "e1", "e12"]


def test_norms_inverses_and_duals():
    alg = bs.algebra(3)
    a, x = alg.random(seed=1), alg.vector([3, 0, 4])
    assert abs(x) == x.norm() == 5 and x.normalized().isclose(x / 5)
    assert (a * a.inverse()).isclose(1) and (x * x**-1).isclose(1)
    assert alg.e1.dual().isclose(alg.e23) and alg.e1.dual().undual().isclose(alg.e1)
    assert alg.random("vector", n=4, seed=2).shape == (4,)


def test_reflections_and_rotors():
    alg = bs.algebra(3)
    mirror, x = alg.e1, alg.vector([1.0, 2.0, 3.0])
    assert (-mirror * x * mirror**-1).isclose(alg.vector([-1, 2, 3]))
    R = np.e ** (-np.pi / 4 * alg.e12)
    assert R.isclose((-np.pi / 4 * alg.e12).exp()) and (2.0 ** (-alg.e12)).isclose((-np.log(2) * alg.e12).exp())
    for base in (-1.0, 0.0, np.nan):
        with pytest.raises(InputError, match="positive numbers"):
            base**alg.e12
    assert (R >> alg.e1).isclose(alg.e2) and (R * alg.e1 * ~R).isclose(alg.e2) and abs(R) == pytest.approx(1)


def test_points_of_conformal_geometry():
    cga = bs.cga3d
    a, b = cga.point([1.0, 2.0, 3.0]), cga.point([4.0, 6.0, 3.0])
    assert (a | a).isclose(0) and np.isclose((-2 * (a | b))["1"], 25)
    moved = cga.translator([1, 0, 0]) * cga.dilator(2.0) >> a
    assert np.allclose(moved.parameters().xyz, [3, 4, 6]) and (cga.no | cga.ni).isclose(-1)


# -- projective space, as the README of `kingdon` goes ----------------------------------------------------------------


def test_coefficients_by_name_and_their_names():
    alg = bs.algebra(3, 0, 1)
    x = alg.multivector(e1=1.0, e12=[2.0, 3.0])
    assert x.isclose(alg.multivector({"e1": 1.0, "e12": [2.0, 3.0]})).all() and x.shape == (2,)
    assert dict(zip(map(str, x.blades), x.values[1].tolist(), strict=True)) == {"e1": 1.0, "e12": 3.0}
    assert alg.multivector(e1=sympy.Symbol("a")).expressions == {"e1": sympy.Symbol("a")}
    assert alg.bivector(e12=2.0, e03=1.0).isclose(2 * alg.e12 + alg.e03) and alg.vector(name="u").grades == (1,)
    for wrong in (lambda: alg.vector(e12=1.0), lambda: alg.vector([1.0], name="u"), lambda: alg.vector([1.0], e1=2.0)):
        with pytest.raises(InputError):
            wrong()
    for wrong in ({}, {"values": [1.0], "e1": 2.0}):
        with pytest.raises(InputError, match=r"Write multivector\(e1=2.0\)"):
            alg.multivector(**wrong)
    with pytest.raises(bs.errors.BladeError, match="'e9'"):
        alg.multivector(e9=1.0)


def test_symbolic_and_numeric_operators():
    alg = bs.algebra(3, 0, 1)
    p, q = (alg.symbols(name, kind="point") for name in "pq")
    line = p & q
    numbers = {s: float(i + 1) for i, s in enumerate(sorted(line.free_symbols, key=str))}
    values = [alg.multivector({n: float(e.subs(numbers)) for n, e in x.expressions.items()}) for x in (p, q)]
    joined = alg.multivector({n: float(e.subs(numbers)) for n, e in line.expressions.items()})
    assert joined.isclose(values[0] & values[1])
    for x, y in (
        (alg.e1 ^ alg.e2, alg.e12),
        (alg.e12 | alg.e12, -1),
        (~alg.e12, -alg.e12),
        (alg.e12 >> alg.e1, -alg.e1),
    ):
        assert x.isclose(y)


def test_arrays_of_multivectors_and_compiled_functions():
    alg = bs.algebra(3, 0, 1)
    motors, points = alg.random("motor", n=5, seed=1)[:, None], alg.random("point", n=7, seed=2)

    @codegen.kernel(alg.kind("motor"), alg.kind("point"))
    def move(m, x):
        return m * x * ~m

    assert move(motors, points).shape == (5, 7) and move(motors, points).isclose(motors >> points).all()
