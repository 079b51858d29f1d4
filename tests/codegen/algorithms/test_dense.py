"""Dense linear algebra: the text with 50 digits and NumPy as oracles."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest

from bladesmith.codegen import algorithm
from bladesmith.codegen.algorithms import dense
from bladesmith.codegen.build import extension
from bladesmith.codegen.language import InOut, Int, Matrix, Out, Real, Vector, empty

pytestmark = pytest.mark.skipif(extension.compiler() is None, reason="no C compiler")


@algorithm
def solved(a: InOut[Matrix[6, 6]], b: InOut[Vector[6]]) -> None:
    """Solve by Cholesky."""
    dense.cholesky(a)
    dense.solve_cholesky(a, b)


@algorithm
def eliminated(a: InOut[Matrix[6, 6]], b: InOut[Vector[6]]) -> None:
    """Solve by elimination."""
    order = empty(6)
    scales = empty(6)
    dense.factor(a, 6, order, scales)
    dense.solve_factored(a, 6, order, scales, b)


@algorithm
def eigen(a: InOut[Matrix[4, 4]], v: Out[Matrix[4, 4]]) -> None:
    """All eigenvectors."""
    dense.diagonalize(a, v, 4)


@algorithm
def least(a: Matrix[4, 4], x: Out[Vector[4]]) -> tuple[Real, Real]:
    """The least eigenvalue, its vector, and the distance to the next."""
    own = empty(4, 4)
    own[:] = a
    value, gap = dense.least_eigenvector(own, x)
    return value, gap


@algorithm
def ranked(x: InOut[Vector[9]], rank: Int) -> Real:
    """The value of a rank."""
    value = dense.select_rank(x, rank)
    return value


@algorithm
def damped(a: Matrix[6, 9], n: Int, b: Vector[6], damping: Real, x: Out[Vector[9]]) -> Real:
    """Damped least squares in the first n columns."""
    left = dense.solve_damped(a, n, b, damping, x)
    return left


@algorithm
def rank(a: InOut[Matrix[6, 9]], n: Int) -> Int:
    """Rank of the first n columns."""
    found = dense.rank_of(a, n, 1e-7)
    return found


def symmetric(n: int, count: int, spread: float, seed: int) -> np.ndarray:
    """Symmetric positive matrices with eigenvalues over some powers of ten."""
    rng = np.random.default_rng(seed)
    q, _ = np.linalg.qr(rng.normal(size=(count, n, n)))
    values = 10.0 ** rng.uniform(-spread, spread, (count, n))
    a = q * values[:, None, :] @ q.transpose(0, 2, 1)
    return (a + a.transpose(0, 2, 1)) / 2


@pytest.mark.parametrize("spread", [0.0, 2.0, 6.0])
def test_solutions_are_off_by_their_condition(spread: float) -> None:
    a, b = symmetric(6, 200, spread, 1), np.random.default_rng(2).normal(size=(200, 6))
    _, x = solved(a, b)
    residual = np.abs(np.einsum("nij,nj->ni", a, x) - b).max(1)
    assert (residual < 1e-14 * np.abs(a).max((1, 2)) * np.abs(x).max(1) * 6).all()


def test_a_semidefinite_matrix_gives_zeros_and_no_infinity() -> None:
    direction = np.array([1.0, 2, 0, 0, 0, 0])
    a = np.outer(direction, direction)
    factor, x = solved(a, a @ np.ones(6))
    assert np.isfinite(factor).all() and np.isfinite(x).all()
    assert np.abs(a @ x - a @ np.ones(6)).max() < 1e-14


@pytest.mark.parametrize("rows", [0.0, 8.0])
def test_elimination_is_blind_to_the_sizes_of_rows(rows: float) -> None:
    """Errors are those of the matrix without its scales."""
    rng = np.random.default_rng(5)
    plain, x = rng.normal(size=(200, 6, 6)), rng.normal(size=(200, 6))
    plain[::2] *= rng.random((6, 6)) < 0.7  # pivots that are zero
    plain[:, range(6), range(5, -1, -1)] += 4.0
    a = 10.0 ** rng.uniform(-rows, rows, (200, 6))[:, :, None] * plain
    _, found = eliminated(a, np.einsum("nij,nj->ni", a, x))
    assert (np.abs(found - x).max(1) < 1e-14 * np.linalg.cond(plain) * np.abs(x).max(1)).all()


@pytest.mark.parametrize("spread", [0.0, 3.0])
def test_eigenvectors(spread: float) -> None:
    a = symmetric(4, 300, spread, 3)
    diagonal, v = eigen(a)
    size = np.abs(a).max((1, 2))
    assert np.abs(v.transpose(0, 2, 1) @ v - np.eye(4)).max() < 1e-14
    values = np.diagonal(diagonal, axis1=1, axis2=2)
    assert (np.abs(a @ v - v * values[:, None, :]).max((1, 2)) < 1e-14 * size).all()
    assert (np.abs(np.sort(values) - np.linalg.eigvalsh(a)).max(1) < 1e-14 * size).all()


def test_the_least_eigenvalue_with_fifty_digits() -> None:
    context = mpmath.mp.clone()
    context.dps = 60
    for a in symmetric(4, 5, 1.0, 4):
        x, value, gap = least.reference(a, numbers=context)
        exact = context.matrix(a.tolist())
        residual = exact * context.matrix(list(x)) - value * context.matrix(list(x))
        assert context.norm(residual) < 1e-16 * np.abs(a).max()  # the sweeps end at 1e-34 of the squares
        vector, found, distance = least(a)
        assert abs(found - float(value)) < 1e-14 * np.abs(a).max()
        assert abs(distance - float(gap)) < 1e-13 * np.abs(a).max()
        assert abs(abs(vector @ np.array([float(v) for v in x])) - 1) < 1e-13


def test_ranks() -> None:
    rng = np.random.default_rng(6)
    x = rng.integers(0, 5, (500, 9)).astype(float)
    ranks = rng.integers(0, 9, 500)
    order, found = ranked(x, ranks)
    assert np.array_equal(found, np.sort(x)[np.arange(500), ranks])
    assert np.array_equal(np.sort(order), np.sort(x))


@pytest.mark.parametrize("n", [2, 6, 9])
@pytest.mark.parametrize("damping", [1.0, 1e-3])
def test_damped_least_squares(n: int, damping: float) -> None:
    rng = np.random.default_rng(n)
    a, b = rng.normal(size=(50, 6, 9)), rng.normal(size=(50, 6))
    x, left = damped(a, n, b, damping)
    for k in range(50):
        system = np.concatenate([a[k, :, :n], damping * np.eye(n)])
        expected = np.linalg.lstsq(system, np.concatenate([b[k], np.zeros(n)]), rcond=None)[0]
        share = 1e-13 / damping**2  # where there are fewer columns than rows, these differ by the damping alone
        assert np.abs(x[k, :n] - expected).max() < share * np.abs(expected).max() and not x[k, n:].any()
        assert abs(left[k] - ((b[k] - a[k, :, :n] @ x[k, :n]) ** 2).sum()) < 1e-12
    with mpmath.workdps(50):
        precise, rest = damped.reference(a[0], n, b[0], damping, numbers=mpmath.mp)
    assert (
        max(abs(float(p - v)) for p, v in zip(precise[:n], x[0], strict=False)) < 1e-8 and abs(rest - left[0]) < 1e-12
    )


@pytest.mark.parametrize("n", [1, 5, 9])
def test_ranks_of_columns(n: int) -> None:
    rng = np.random.default_rng(n)
    for expected in range(min(n, 6) + 1):
        a = np.zeros((40, 6, 9))
        a[:, :, :n] = rng.normal(size=(40, 6, expected)) @ rng.normal(size=(40, expected, n))
        _, found = rank(10.0 ** rng.uniform(-9, 9, (40, 1, 1)) * a, n)
        assert found.tolist() == [expected] * 40
