"""Directions of weighted rows: NumPy as oracle; zeros that are skipped, and numba, give the same bits."""

# Annotations are evaluated here: sizes of records are those of each call of `solver`.
import mpmath
import numpy as np
import pytest

from bladesmith.codegen import algorithm
from bladesmith.codegen.algorithms.weighted_rows import weighted_rows
from bladesmith.codegen.build import extension
from bladesmith.codegen.language import InOut, Int, Real, Vector

pytestmark = pytest.mark.skipif(extension.compiler() is None, reason="no C compiler")
ROWS, SIZE, SAMPLES = 14, 18, 60
DENSE, SPARSE = (weighted_rows(ROWS, SIZE, most) for most in (SIZE, 0))


def solver(which):
    """Directions, then the least change."""
    numbers, indices, find, change = which.numbers, which.integers, which.find_directions, which.least_change

    @algorithm
    def solved(
        s: InOut[numbers], p: InOut[indices], count: Int, weights: Vector[SIZE], tolerance: Real, limit: Int,
        values: Vector[ROWS], x: InOut[Vector[SIZE]],
    ) -> None:  # fmt: skip
        """Directions of rows, and the least change."""
        find(s, p, count, SIZE, weights, tolerance, limit)
        change(s, p, SIZE, weights, values, x)

    return solved


SOLVERS = {which: solver(which) for which in (DENSE, SPARSE)}


def systems(seed=5):
    """Rows on one or two blocks of six columns; of every other system some depend on each other, or are rounding."""
    rng = np.random.default_rng(seed)
    matrix = np.zeros((SAMPLES, ROWS, SIZE))
    for one in matrix:
        for row in one:
            for block in rng.integers(0, 3, 2):
                row[6 * block : 6 * block + 6] = rng.normal(size=6) * (rng.random(6) < 0.7)
    matrix[::2, 4] = matrix[::2, 1] - 2 * matrix[::2, 2]
    matrix[::2, 5] = 0
    matrix[::4, 6] *= 1e-14
    numbers = DENSE.numbers.zeros(SAMPLES)
    numbers.matrix = matrix
    numbers.sizes = rng.random((SAMPLES, ROWS))
    noise = np.zeros((SAMPLES, ROWS))
    noise[::4, 7] = 10.0  # more than the row: it counts as zero
    numbers.noise = noise
    return np.asarray(numbers), rng.uniform(0.3, 3.0, (SAMPLES, SIZE)), rng.normal(size=(SAMPLES, ROWS))


def solution(which, target=None, limit=0):
    numbers, weights, values = systems()
    integers = np.asarray(which.integers.zeros(SAMPLES))
    run = SOLVERS[which].on(target) if target else SOLVERS[which]
    start = np.zeros((SAMPLES, SIZE))
    numbers, integers, x = run(numbers, integers, ROWS, weights, 1e-7, limit, values, start)
    return which.numbers.view(numbers), which.integers.view(integers), weights, values, x


def test_directions_are_those_of_the_rows() -> None:
    numbers, integers, weights, values, x = solution(DENSE)
    for i in range(SAMPLES):
        used = np.array(numbers.matrix[i])
        used[numbers.noise[i] > 0] = 0
        used[6] = used[6] * (i % 4 != 0)
        rank = int(integers.rank[i])
        assert rank == np.linalg.matrix_rank(used * weights[i], tol=1e-9)
        q = np.asarray(numbers.direction[i][:rank])
        assert np.abs(q @ q.T - np.eye(rank)).max() < 1e-14
        order = np.asarray(integers.order[i][:rank])
        assert np.abs(used[order] @ x[i] - values[i][order]).max() < 1e-9
        least = weights[i] * np.linalg.lstsq(used[order] * weights[i], values[i][order], rcond=None)[0]
        assert np.abs(least - x[i]).max() < 1e-9 * (1 + np.abs(least).max())


@pytest.mark.peers
@pytest.mark.parametrize(("which", "target"), [(SPARSE, None), (SPARSE, "numba"), (DENSE, "numba")])
@pytest.mark.parametrize("limit", [0, 9])
def test_the_same_bits(which, target, limit) -> None:
    if target:
        pytest.importorskip("numba")
    first, expected, *_, x = solution(DENSE, limit=limit)
    second, found, *_, y = solution(which, target, limit)
    assert x.tobytes() == y.tobytes()
    assert np.array_equal(found.rank, expected.rank) and np.array_equal(found.order, expected.order)
    assert np.array_equal(found.excess, expected.excess)
    assert limit == 0 or (expected.rank == limit).all() and expected.excess.any()
    assert np.array_equal(first.direction, second.direction) and np.array_equal(first.upper, second.upper)


def test_the_reference_finds_the_same() -> None:
    numbers, weights, values = systems()
    start = DENSE.integers.zeros(), np.zeros(SIZE)
    _, found, x = SOLVERS[DENSE].reference(numbers[0], start[0], ROWS, weights[0], 1e-7, 0, values[0], start[1])
    _, expected, *_, y = solution(DENSE)
    assert np.array_equal(found.order, expected.order[0]) and np.array_equal(x, y[0])


@pytest.mark.compiles
def test_tangents_of_the_least_change() -> None:
    """Against differences of x0 + G A^T (A G A^T)^-1 (b - A x0) at 50 digits."""
    rng, count = np.random.default_rng(8), 5
    matrix, d_matrix = rng.normal(size=(2, ROWS, SIZE))
    weights, d_weights = rng.uniform(0.3, 3.0, (2, SIZE))
    values, d_values = rng.normal(size=(2, ROWS))
    start, d_start = rng.normal(size=(2, SIZE))

    def least(e: mpmath.mpf) -> mpmath.matrix:
        a, w, b, x = (
            mpmath.matrix(p.tolist()) + e * mpmath.matrix(d.tolist())
            for p, d in ((matrix[:count], d_matrix[:count]), (weights, d_weights), (values[:count], d_values[:count]),
                         (start, d_start))
        )  # fmt: skip
        g = mpmath.diag([v * v for v in w])
        return x + g * a.T * mpmath.lu_solve(a * g * a.T, b - a * x)

    with mpmath.workdps(50):
        h = mpmath.mpf(10) ** -18
        expected = np.array([float(v) for v in (least(h) - least(-h)) / (2 * h)])
    numbers, along = DENSE.numbers.zeros(1)[0], DENSE.numbers.zeros(1)[0]
    numbers.matrix, along.matrix = matrix, d_matrix
    numbers.sizes = 1.0
    integers = np.asarray(DENSE.integers.zeros(1))[0]
    derivative = SOLVERS[DENSE].derivative("s", "weights", "values", "x")
    found = derivative(
        np.asarray(numbers), integers, count, weights, 1e-7, 0, values, start, np.asarray(along), d_weights, d_values,
        d_start,
    )  # fmt: skip
    assert np.abs(found[-1] - expected).max() < 1e-12 * np.abs(expected).max()
