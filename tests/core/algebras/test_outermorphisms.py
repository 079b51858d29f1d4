"""Linear maps of vectors, extended to blades: against exact expansion, and by their laws."""

from __future__ import annotations

from fractions import Fraction
from itertools import permutations
from math import prod
from typing import Any

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import cga3d
from bladesmith.codegen.algebra.multivector import Multivector
from bladesmith.codegen.rings.protocol import RationalRing

RANDOM = np.random.default_rng(8)


def exact_image(algebra: Any, matrix: Any, blade: int) -> dict[int, Fraction]:
    """Outer product of the columns, in fractions."""
    total = Multivector(algebra, RationalRing(), {0: Fraction(1)})
    for j in range(algebra.dimension):
        if blade >> j & 1:
            column = {1 << i: Fraction(float(row[j])) for i, row in enumerate(matrix) if row[j]}
            total = total ^ Multivector(algebra, RationalRing(), column)
    return dict(total.terms)


@pytest.mark.parametrize("scale", [1.0, 1e150, 1e-30])
def test_images_of_blades_are_the_exact_ones(scale: float) -> None:
    algebra = bs.algebra(metric=[[2, 1, 0, 0], [1, -1, 0, 0], [0, 0, 0, 0], [0, 0, 0, 1]])
    matrix = RANDOM.normal(size=(4, 4))
    matrix[:, 3] = matrix[:, 0] * (1 + 1e-12)  # the determinant is a difference of large terms
    matrix[0] *= scale
    f = algebra.outermorphism(matrix)
    for blade in algebra.blades:
        exact = exact_image(algebra, matrix, blade)
        ours = f.apply(algebra.multivector({blade: 1.0}))
        columns = [j for j in range(4) if blade >> j & 1]
        for other in algebra.blades:
            rows = [i for i in range(4) if other >> i & 1]
            orders = permutations(rows) if len(rows) == len(columns) else ()
            size = sum(prod(abs(matrix[i, j]) for i, j in zip(order, columns, strict=True)) for order in orders)
            difference = Fraction(float(ours[other])) - exact.get(int(other), Fraction(0))
            assert abs(float(difference)) <= 8 * 2.0**-53 * size


def test_laws() -> None:
    a, b = (bs.algebra(3).outermorphism(RANDOM.normal(size=(3, 3))) for _ in range(2))
    x, y = (bs.algebra(3).random(n=50, seed=seed) for seed in (1, 2))
    assert a(x ^ y).isclose(a(x) ^ a(y), rtol=1e-12).all() and (a @ b)(x).isclose(a(b(x)), rtol=1e-12).all()
    assert a.inverse()(a(x)).isclose(x, rtol=1e-11).all() and a(bs.algebra(3).I).isclose(
        a.determinant * bs.algebra(3).I
    )
    assert a(x.astype("float32")).dtype == np.float32 and a(x[0]).shape == ()
    one, batch = a(x[7]), a(x)
    assert np.array_equal(one.values, batch.values[7])  # the same bits alone and in a batch


@pytest.mark.parametrize("algebra", [bs.algebra(2, 2), cga3d, bs.algebra(metric=[[2, 1], [1, "1/3"]])])
def test_adjoints(algebra: Any) -> None:
    f = algebra.outermorphism(RANDOM.normal(size=(algebra.dimension,) * 2))
    u, v = (algebra.random("vector", 20, seed) for seed in (1, 2))
    assert np.allclose((f(u) | v)["1"], (u | f.adjoint()(v))["1"], rtol=1e-11, atol=1e-11)
    x, y = (algebra.random(n=20, seed=seed) for seed in (3, 4))
    assert np.allclose(f(x).scalar_product(y)["1"], x.scalar_product(f.adjoint()(y))["1"], rtol=1e-9, atol=1e-9)


def test_versors_and_functions() -> None:
    motor, x = cga3d.random("motor", seed=4), cga3d.random(n=5, seed=5)
    assert cga3d.outermorphism(motor)(x).isclose(motor >> x, rtol=1e-11).all()
    assert cga3d.outermorphism(2.0 * motor)(x).isclose(motor >> x, rtol=1e-11).all()
    plane = bs.algebra(3)
    assert plane.outermorphism(plane.e1)(plane.vector([1, 2, 3])).isclose(plane.vector([-1, 2, 3]))
    assert plane.outermorphism(lambda v: 2 * v)(plane.e12).isclose(4 * plane.e12)
    assert plane.outermorphism(np.zeros((3, 3)))(plane.e12).isclose(0) and repr(plane.outermorphism(plane.e1)).endswith(
        "-1>"
    )


@pytest.mark.parametrize(
    ("given", "error", "message"),
    [
        (np.eye(2), bs.errors.ShapeError, "matrix"),
        ([[np.nan, 0, 0]] * 3, bs.errors.InputError, "finite"),
        (lambda v: 3, bs.errors.InputError, "no vector"),
        (lambda v: v ^ bs.algebra(3).e3, bs.errors.KindError, "e13"),
        (bs.algebra(3).e1 + 1, bs.errors.GradeError, "even and odd"),
        (0 * bs.algebra(3).e1, bs.errors.NotInvertibleError, "inverse"),
        (cga3d.e1, bs.errors.AlgebraMismatchError, "cga3d"),
        (bs.algebra(3).vector(np.eye(3)), bs.errors.ShapeError, "made of one"),
        ("abc", bs.errors.InputError, "matrix"),
    ],
)
def test_what_is_no_map(given: Any, error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        bs.algebra(3).outermorphism(given)


def test_what_maps_do_not_have() -> None:
    with pytest.raises(bs.errors.SignatureError, match="degenerate"):
        bs.pga3d.outermorphism(np.eye(4)).adjoint()
    with pytest.raises(bs.errors.SingularError, match="no inverse"):
        bs.algebra(2).outermorphism([[1, 2], [2, 4]]).inverse()
    with pytest.raises(bs.errors.GradeError, match="no versor"):
        bs.algebra(4).outermorphism(1 + 2 * bs.algebra(4).I)
    f = bs.algebra(2).outermorphism(np.eye(2))
    with pytest.raises(bs.errors.AlgebraMismatchError):
        f.apply(cga3d.e1)
    with pytest.raises(bs.errors.AlgebraMismatchError):
        f @ cga3d.outermorphism(np.eye(5))
    with pytest.raises(bs.errors.InputError):
        f.apply(3)


def test_empty_frames_and_frames_without_finite_reciprocals() -> None:
    space = bs.algebra(3)
    for shape in ((0, 3), (5, 0, 3)):
        with pytest.raises(bs.errors.ShapeError, match="1 to 3 vectors"):
            space.reciprocal_frame(space.vector(np.zeros(shape)))
    for frame in (space.vector(np.eye(3) * 1e-310), space.vector(np.eye(3) * 1e-42, dtype=np.float32)):
        found = space.reciprocal_frame(frame)
        assert (found.status == bs.Status.INVALID).all() and np.isnan(found.values).all()


def test_adjoint_without_vectors() -> None:
    assert bs.algebra(0).outermorphism(np.zeros((0, 0))).adjoint().matrix.shape == (0, 0)
