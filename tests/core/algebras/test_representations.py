"""Matrices that stand for multivectors, and reciprocal frames."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import cga3d, pga3d

SIGNATURES = [(0,), (1,), (0, 1), (3,), (0, 3), (2, 1), (1, 3), (4, 2), (5,), (0, 0, 2), (3, 0, 1)]
ALGEBRAS = [*(bs.algebra(*s) for s in SIGNATURES), cga3d, bs.algebra(metric=[[2, 1], [1, "-1/3"]])]


@pytest.mark.parametrize("algebra", ALGEBRAS, ids=lambda a: a.name)
@pytest.mark.parametrize("representation", ["left", "right", "complex"])
def test_products_of_matrices_are_matrices_of_products(algebra: Any, representation: str) -> None:
    x, y = (algebra.random(n=(2, 3), seed=seed) for seed in (1, 2))
    if representation == "complex" and (algebra.is_degenerate or not algebra.is_diagonal and algebra is not cga3d):
        with pytest.raises(bs.errors.SignatureError):
            x.to_matrix(representation)
        return
    a, b = x.to_matrix(representation), y.to_matrix(representation)
    product = b @ a if representation == "right" else a @ b
    assert np.allclose(product, (x * y).to_matrix(representation), rtol=0, atol=1e-12)
    assert algebra.from_matrix(a, representation).isclose(x, rtol=1e-13).all()
    assert algebra.scalar(1.0).to_matrix(representation).tolist() == np.eye(a.shape[-1]).tolist()


def test_sizes_are_the_smallest() -> None:
    signatures = [(1,), (0, 1), (3,), (0, 3), (1, 3), (4, 1), (5,)]
    sizes = [bs.algebra(*signature).e1.to_matrix("complex").shape[-1] for signature in signatures]
    assert sizes == [2, 1, 2, 4, 4, 4, 8]
    pauli = [bs.algebra(3).blades[name].to_matrix("complex").tolist() for name in ("e1", "e2", "e3")]
    assert pauli == [[[0, 1], [1, 0]], [[0, -1j], [1j, 0]], [[1, 0], [0, -1]]]


def test_motors_are_homogeneous_matrices_by_default() -> None:
    motor = pga3d.random("motor", 3, seed=1)
    back = pga3d.from_matrix(motor.to_matrix())
    assert (back.isclose(motor) | back.isclose(-motor)).all()
    with pytest.raises(bs.errors.GradeError, match="cga3d and pga3d"):
        bs.algebra(2).from_matrix(np.eye(3))


@pytest.mark.parametrize(
    ("call", "error", "message"),
    [
        (lambda: bs.algebra(2).from_matrix(np.ones((4, 4)), "left"), bs.errors.InputError, "no multivector"),
        (lambda: bs.algebra(2).from_matrix(np.full((2, 4, 4), np.nan), "left"), bs.errors.InputError, "matrix 0"),
        (lambda: bs.algebra(2).from_matrix(np.eye(3), "left"), bs.errors.ShapeError, r"\(4, 4\)"),
        (lambda: bs.algebra(1).from_matrix([[1, 1], [0, 1]], "complex"), bs.errors.InputError, "no multivector"),
        (lambda: bs.algebra(2).from_matrix(1j * np.eye(4), "left"), bs.errors.InputError, "complex"),
        (lambda: bs.algebra(9).e1.to_matrix("left"), bs.errors.SignatureError, "go to 8"),
        (lambda: bs.algebra(2).e1.to_matrix(), bs.errors.GradeError, "representation='left'"),
        (lambda: bs.algebra(2).from_matrix(np.eye(4)), bs.errors.GradeError, "representation='left'"),
        (lambda: cga3d.e1.to_matrix("spinor"), bs.errors.InputError, "representation"),
        (lambda: bs.algebra(2).from_matrix("abc", "left"), bs.errors.BladesmithError, "matrix"),
    ],
)
def test_what_is_no_matrix(call: Any, error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()


@pytest.mark.parametrize("algebra", [bs.algebra(3), cga3d, bs.algebra(2, 2)], ids=lambda a: a.name)
@pytest.mark.parametrize("scale", [1.0, 1e-200, 1e200])
def test_reciprocal_frames(algebra: Any, scale: float) -> None:
    for k in range(1, algebra.dimension + 1):
        rows = np.random.default_rng(k).normal(size=(6, k, algebra.dimension))
        frame, plain = algebra.vector(scale * rows), algebra.vector(rows)
        other = algebra.reciprocal_frame(frame)
        assert (other.status == bs.Status.OK).all() and other.shape == (6, k)
        scaled = algebra.vector(other.values * scale)
        assert np.allclose((plain[:, :, None] | scaled[:, None, :])["1"], np.eye(k), rtol=0, atol=1e-12)
        coefficients = np.linalg.lstsq(np.swapaxes(rows[0], 0, 1), scaled.values[0].T, rcond=None)[0]
        assert np.allclose(rows[0].T @ coefficients, scaled.values[0].T, atol=1e-11)  # in the span


def test_frames_without_a_reciprocal() -> None:
    e1, e2 = np.eye(5)[:2]
    frames = cga3d.vector([[e1, 2 * e1], [e1, np.nan * e1], [e1, e2]])
    found = cga3d.reciprocal_frame(frames)
    assert found.status[:, 0].tolist() == [bs.Status.SINGULAR, bs.Status.INVALID, bs.Status.OK]
    assert np.isnan(found.values[:2]).all() and np.isfinite(found.values[2]).all()
    assert cga3d.reciprocal_frame(cga3d.vector([[0, 0, 0, 1, 0]])).status[0] == bs.Status.SINGULAR  # no is null
    with pytest.raises(bs.errors.SingularError):
        cga3d.reciprocal_frame(frames, strict=True)
    with pytest.raises(bs.errors.ShapeError):
        cga3d.reciprocal_frame(cga3d.e1)
    with pytest.raises(bs.errors.KindError):
        cga3d.reciprocal_frame(cga3d.bivector(np.ones((2, 10))))


@pytest.mark.parametrize("representation", ["left", "right", "complex"])
def test_empty_batches(representation: str) -> None:
    space = bs.algebra(3)
    made = space.random(n=(2, 0)).to_matrix(representation)
    assert made.shape[:2] == (2, 0) and space.from_matrix(made, representation).shape == (2, 0)
