"""Algebras by squares, by any exact metric, and by names of vectors."""

from __future__ import annotations

import itertools
import pickle
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
import sympy

import bladesmith as bs


def test_one_algebra_for_one_metric() -> None:
    assert bs.algebra(signature=[0, 1, 1]) is bs.algebra(2, 0, 1)
    assert bs.algebra(signature=(1, 1, -1)) is bs.algebra(2, 1) is bs.algebra(metric=np.diag([1, 1, -1]))
    assert bs.algebra(signature=[0, 1, 1, 1]) is bs.pga3d
    null = bs.algebra(metric={"no|ni": -1}, vectors="e1 e2 no ni")
    assert null is bs.algebra(metric=[[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, -1], [0, 0, -1, 0]], vectors="e1,e2,no,ni")
    assert null is pickle.loads(pickle.dumps(null)) and null.signature == (3, 1, 0)
    last = bs.algebra(signature=[1, 1, 0])
    assert last is not bs.algebra(2, 0, 1) and [str(b) for b in last.blades[1:4]] == ["e1", "e2", "e3"]


def test_products_of_a_null_basis_are_those_of_cga() -> None:
    own, cga = bs.algebra(metric={"no|ni": -1}, vectors="e1 e2 e3 no ni"), bs.cga3d
    a, b = np.random.default_rng(3).normal(size=(2, 20, 32))
    ours, theirs = own.multivector(a) * own.multivector(b), cga.multivector(a) * cga.multivector(b)
    assert np.allclose(ours.values, theirs.values, rtol=0, atol=1e-12)


def test_products_of_any_metric_satisfy_its_equation() -> None:
    """x y + y x = 2 g(x, y) for vectors, and products are associative."""
    metric = [[2, 1, 0], [1, Fraction(1, 3), "-1/2"], [0, -0.5, sympy.Rational(5, 7)]]
    alg = bs.algebra(metric=metric)
    g = np.array([[2, 1, 0], [1, 1 / 3, -0.5], [0, -0.5, 5 / 7]])
    x, y = np.random.default_rng(4).normal(size=(2, 10, 3))
    twice = alg.vector(x) * alg.vector(y) + alg.vector(y) * alg.vector(x)
    assert np.allclose(twice["1"], 2 * np.einsum("ni,ij,nj->n", x, g, y), rtol=1e-14)
    assert np.allclose(twice["e12"], 0, atol=1e-14)
    a, b, c = (alg.random(n=10, seed=seed) for seed in range(3))
    assert ((a * b) * c).isclose(a * (b * c), rtol=1e-13).all()


def test_names_of_vectors() -> None:
    plane = bs.algebra(2, vectors="x y")
    assert plane.xy["yx"] == -1 and (plane.x * plane.y).isclose(plane.xy)
    wide = bs.algebra(13, vectors=[*(f"e{i}" for i in range(1, 12)), "x", "y"])
    names = [str(b) for b in wide.multivector({"e1_11xy": 1.0, "yx": 2.0, "e11_1": 3.0}).blades]
    assert names == ["e1_11", "x_y", "e1_11_x_y"]
    assert all(wide.blade_name(wide.parse_blade(name)[0]) == name for name in names)
    long = bs.algebra(2, vectors=["ex", "ey"])  # names that begin with the letter of numbered ones
    assert long.exey["eyex"] == -1


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"metric": [[0.1]]}, r"entry \(0, 0\) of the metric is 0\.1, which is rounded.*'1/10'"),
        ({"metric": [[1e-300]]}, "1e-300, which is rounded.*'p/q'"),
        ({"metric": [[1, 2], [3, 4]]}, "not symmetric: entry"),
        ({"metric": [[1, 2]]}, "not square: 1 rows, of 2"),
        ({"metric": [[float("nan")]]}, "is nan"),
        ({"metric": [[1j]]}, "whole number or a fraction"),
        ({"metric": 3}, "it is a square matrix"),
        ({"metric": [["1e99"]]}, "'1e99'"),
        ({"metric": {"no|ni": -1}}, "vectors="),
        ({"metric": {"no|nj": -1}, "vectors": "no ni"}, "'nj'"),
        ({"metric": {"a|b": 1, "b|a": 2}, "vectors": "a b"}, "twice: 1 and 2"),
        ({"metric": {"a|a|a": 1}, "vectors": "a"}, "no product of vectors"),
        ({"signature": [3, 0, 1]}, r"entry 0 of the signature is 3.*algebra\(p, q, r\)"),
        ({"signature": [0.5]}, "1, -1 or 0"),
        ({"signature": [1] * 25}, "24 dimensions"),
        ({"p": 2, "vectors": "a ab"}, "cannot be told apart"),
        ({"p": 2, "vectors": "a a"}, "a twice"),
        ({"p": 2, "vectors": "a"}, "1 names of vectors and 2"),
        ({"p": 1, "vectors": "lambda"}, "lambda"),
        ({"p": 1, "vectors": "kinds"}, "attribute"),
        ({"p": 1, "vectors": ["a b"]}, "a letter followed by"),
        ({"p": 1, "vectors": 7}, "a text such as"),
        ({"p": 1, "signature": [1]}, "one of"),
        ({}, "one of"),
        ({"metric": [[1]], "q": 1}, "one of"),
    ],
)
def test_what_is_no_metric(given: dict[str, Any], message: str) -> None:
    with pytest.raises(bs.errors.SignatureError, match=message):
        bs.algebra(**given)


def test_many_dimensions() -> None:
    """24 vectors: what is not named costs nothing, and what would be all blades is refused."""
    alg = bs.algebra(23, 1)
    x, y = np.random.default_rng(5).normal(size=(2, 24))
    squares = np.array([1.0] * 23 + [-1.0])
    product = alg.vector(x) * alg.vector(y)
    assert np.isclose(product["1"], (x * y * squares).sum())
    assert np.isclose(product["e24_1"], x[23] * y[0] - x[0] * y[23])
    assert (~product).isclose(alg.vector(y) * alg.vector(x)) and alg.kind("bivector").size == 276
    assert (alg.I * alg.I).isclose((-1) ** (24 * 23 // 2) * -1)
    for call in (lambda: alg.blades, lambda: alg.multivector(np.ones(5)), lambda: alg.random()):
        with pytest.raises((bs.errors.SignatureError, bs.errors.KindError)):
            call()


@pytest.mark.parametrize("vectors", ["e1 x e2", "x e1 y", "x e10 e2", "e12 x_ e1", "xe ye e1", "x1 y e1"])
def test_names_of_blades_read_back_whatever_the_order_of_numbers_and_letters(vectors: str) -> None:
    algebra = bs.algebra(3, vectors=vectors)
    for blade in algebra.blades[1:]:
        named = algebra.blades[blade.name]
        assert named.blades == (blade,) and named.values.tolist() == [1.0]


@pytest.mark.parametrize("name", ["name", "metric", "vectors", "stock", "pseudoscalar_sign"])
def test_vectors_are_not_called_like_what_each_algebra_holds(name: str) -> None:
    with pytest.raises(bs.errors.SignatureError, match=f"{name} cannot be the name"):
        bs.algebra(2, vectors=f"{name} x")
    with pytest.raises(bs.errors.SignatureError, match="a word of Python"):
        bs.algebra(2, vectors="for x")


def test_endless_iterables_are_refused() -> None:
    with pytest.raises(bs.errors.SignatureError, match="24 dimensions"):
        bs.algebra(signature=itertools.repeat(1))
    with pytest.raises(bs.errors.SignatureError, match="24 dimensions"):
        bs.algebra(2, vectors=itertools.repeat("x"))


@pytest.mark.parametrize("algebra", [bs.algebra(24), bs.qcga], ids=["24", "qcga"])
def test_powers_of_many_vectors_are_refused_at_once(algebra: Any) -> None:
    v = algebra.random("vector", seed=1)
    for call in (v.exp, v.inverse, lambda: v**-1, lambda: algebra.random("bivector", seed=1).inverse()):
        with pytest.raises(bs.errors.SignatureError, match="goes to 12"):
            call()
    few = algebra.vector({"e1": 3.0, "e2": 4.0})
    assert (few * few.inverse()).isclose(1.0) and (few**-1).isclose(few / 25)
    plane = algebra.basis_blade("e12" if algebra is bs.qcga else "e1_2")
    assert (0.5 * plane).exp().isclose(np.cos(0.5) + np.sin(0.5) * plane)


def test_exponentials_of_many_vectors_are_refused_before_products_of_thousands_of_blades() -> None:
    with pytest.raises(bs.errors.SignatureError, match="goes to 12"):
        bs.algebra(18).bivector(np.ones(153)).exp()  # the square of B^2 has 9 million products
    space = bs.algebra(13, 0, 1)
    motor = (space.e1 * space.e2 + space.e0 * space.vector(np.ones(14))).exp()
    assert (motor * ~motor).isclose(1.0)
