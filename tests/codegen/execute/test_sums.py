"""Kernels that sum over all items: against exact sums of what the same kernel gives for single items."""

import math
import tracemalloc

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import Status, cga3d, codegen
from bladesmith.codegen.execute.reductions.sums import BLOCK, LANES, sum_items
from bladesmith.codegen.trace.outputs import status
from bladesmith.common import parallel
from bladesmith.errors import InputError, TraceError

UNIT = 2.0**-53
POINT, MOTOR, NUMBER = cga3d.kind("point"), cga3d.kind("motor"), codegen.scalar
SIZES = [0, 1, 2, LANES - 1, LANES + 1, BLOCK - 3, BLOCK, 3 * BLOCK + 5 * LANES + 1]


def squared_distance(m, x, y):
    d = m * x * ~m - y
    return d | d


loss = codegen.kernel(MOTOR, POINT, POINT, reduce="sum", name="loss")(squared_distance)
distance = codegen.kernel(MOTOR, POINT, POINT, name="distance")(squared_distance)


def multiple(x, t):
    return t * x


total = codegen.kernel(cga3d.layout("bivector"), NUMBER, reduce="sum", name="total")(multiple)
multiples = codegen.kernel(cga3d.layout("bivector"), NUMBER, name="multiples")(multiple)


def cancelling(n, seed):
    """Rows of bivectors whose sums are 1e-12 of their terms, and numbers to multiply them by."""
    rng = np.random.default_rng(seed)
    rows = rng.normal(size=(n, 10)) * 10.0 ** rng.integers(-3, 8, (n, 1))
    rows[n // 2 : n // 2 * 2] = -rows[: n // 2] * (1 + 1e-12 * rng.normal(size=(n // 2, 1)))
    return rng.permutation(rows), np.full(n, 1.0)


def check_against_exact(result, items):
    """A rounding of the exact sum, and what the errors of errors are: (n u)^2 of the sum of absolute values."""
    unit = float(np.finfo(items.dtype).eps) / 2 + UNIT  # fsum rounds, too
    for found, column in zip(np.ravel(result), items.astype(float).T, strict=True):
        allowed = unit * abs(math.fsum(column)) + (len(items) * UNIT) ** 2 * float(np.abs(column).sum())
        assert abs(float(found) - math.fsum(column)) <= allowed


@pytest.mark.parametrize("n", SIZES)
def test_sums_with_cancellation(n):
    x, t = cancelling(n, 1)
    result = total(x, t)
    assert result.shape == (10,)
    check_against_exact(result, multiples(x, t))
    naive = np.abs(multiples(x, t).sum(0) - [math.fsum(c) for c in multiples(x, t).T]).max() if n > BLOCK else 1
    assert naive > 0  # NumPy's pairwise sum is off here


def test_sums_in_single_precision_are_added_in_double():
    x, t = (a.astype(np.float32) for a in cancelling(70_000, 2))
    result = total(x, t)
    assert result.dtype == np.float32
    check_against_exact(result, multiples(x, t))


def test_a_loss_against_fifty_digits():
    rng = np.random.default_rng(3)
    m, x, y = cga3d.random("motor", seed=4), *(cga3d.point(rng.normal(size=(40, 3))) for _ in range(2))
    (precise,) = loss.reference(m, x, y, digits=50)
    summed = sum(distance.reference(m, a, b, digits=50)[0] for a, b in zip(x, y, strict=True))
    assert abs(precise - summed) < 1e-45
    result = loss(m, x, y)
    assert result.shape == () and result.kind.name == "scalar"
    assert abs(float(result.values[0]) - precise) < 1e-14 * precise
    assert loss.reference(m, x, y).isclose(result)


def test_leading_axes_broadcast_and_are_all_summed():
    rng = np.random.default_rng(5)
    motors = cga3d.random("motor", n=7, seed=6)[:, None]
    x, y = (cga3d.point(rng.normal(size=(11, 3))) for _ in range(2))
    single = distance(motors, x, y)
    assert single.shape == (7, 11)
    check_against_exact(loss(motors, x, y).values, single.values.reshape(-1, 1))


def test_sums_of_a_kind_are_of_its_layout():
    copies = codegen.kernel(MOTOR, reduce="sum", name="copies")(lambda x: ~x)
    motors = cga3d.random("motor", n=5, seed=7)
    assert copies(motors).kind == cga3d.layout("motor")
    with pytest.raises(InputError, match="a sum of motors is none"):
        codegen.kernel(MOTOR, returns=MOTOR, reduce="sum")(lambda x: ~x)


@pytest.mark.parametrize("target", ["numpy", pytest.param("numba", marks=pytest.mark.slow)])
def test_targets_give_the_same_bits(target):
    pytest.importorskip("numba") if target == "numba" else None
    x, t = cancelling(2 * BLOCK + 333, 8)
    assert np.array_equal(total.on(target)(x, t), total(x, t))
    single = x.astype(np.float32), t.astype(np.float32)
    assert np.array_equal(total.on(target)(*single), total(*single))
    assert np.array_equal(total.on(target)(x[:0], t[:0]), np.zeros(10))


def test_threads_give_the_same_bits(monkeypatch):
    x, t = cancelling(40 * BLOCK + 1, 9)
    alone = total(x, t)
    shared, run_threaded = [], parallel._run_threaded

    def noted(part, ranges, *rest):
        def whole_blocks(begin, end):
            assert begin % BLOCK == 0
            part(begin, end)

        shared.append(ranges.n)
        run_threaded(whole_blocks, ranges, *rest)

    monkeypatch.setattr(parallel, "_run_threaded", noted)
    bs.set_threads(2)
    try:
        assert np.array_equal(total(x, t), alone)
    finally:
        bs.set_threads(1)
    assert shared == [len(x)]  # not blocks, which would be too few to be shared


def test_numbers_that_are_not_finite():
    x, t = np.ones((BLOCK + 2, 10)), np.ones(BLOCK + 2)
    x[5, 0], x[BLOCK + 1, 1], x[7, 2], x[8, 2], x[9, 3] = np.inf, -np.inf, np.inf, -np.inf, np.nan
    for target in ("c", "numpy"):
        found = total.on(target)(x, t)
        assert found[0] == np.inf and found[1] == -np.inf and np.isnan(found[2:4]).all()
        assert (found[4:] == BLOCK + 2).all()


def test_sums_of_few_wide_rows_need_no_more_memory_than_they_have():
    values = np.random.default_rng(11).normal(size=(3, 200_000))
    tracemalloc.start()
    found = sum_items(values)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 3 * values.nbytes
    assert found[:99].tolist() == [math.fsum(column) for column in values[:, :99].T]


@pytest.mark.filterwarnings("error")
def test_a_sum_beyond_single_precision_is_infinite():
    assert total(np.full((2, 10), 3e38, np.float32), np.ones(2, np.float32)).tolist() == [np.inf] * 10


def test_the_status_of_a_sum():
    def root(x):
        code = codegen.select(x < -1, x.constant(Status.INVALID), x.constant(Status.IMAGINARY))
        code = codegen.select(x > 1, x.constant(Status.OK), codegen.select(x < 0, code, x.constant(Status.NOT_UNIQUE)))
        return codegen.sqrt(x), status(code)

    roots = codegen.kernel(NUMBER, algebra=cga3d, reduce="sum")(root)
    for values, code in (
        ([4.0, 9.0], Status.OK),
        ([4.0, 0.25, 9.0], Status.NOT_UNIQUE),
        ([4.0, 0.25, -0.5, -2.0], Status.IMAGINARY),
        ([-2.0, 0.25, -0.5], Status.INVALID),
        (np.r_[np.full(BLOCK, 4.0), 0.25, -2.0, -0.5], Status.INVALID),
        ([], Status.OK),
    ):
        for target in ("c", "numpy"):
            value, found = roots.on(target)(np.array(values))
            assert found == code
            assert np.isnan(value[0]) if min(values, default=0) < 0 else value[0] == np.sqrt(values).sum()


def test_the_derivative_of_a_sum_is_the_sum_of_derivatives():
    slope = codegen.kernel(NUMBER, NUMBER, algebra=cga3d, reduce="sum", name="slope")(
        lambda a, x: (a * x - 1) * (a * x - 1)
    )
    x = np.random.default_rng(10).normal(size=1000)
    assert slope.derivative("a")(0.3, x)[0] == pytest.approx(math.fsum(2 * x * (0.3 * x - 1)), rel=1e-14)


def test_sums_are_refused_where_items_are_needed(tmp_path):
    with pytest.raises(InputError, match="reduce is 'mean'; it is \"sum\""):
        codegen.kernel(POINT, reduce="mean")
    with pytest.raises(TraceError, match="loss sums over all items, and a plan's result is that of single ones"):
        loss.plan(cga3d.random("motor", seed=1), cga3d.point([0, 0, 0]), cga3d.point([0, 0, 0]))
    twice = codegen.kernel(MOTOR, POINT, POINT, name="twice")(lambda m, x, y: 2 * loss(m, x, y))
    with pytest.raises(TraceError, match="what a formula calls"):
        _ = twice.traced
    with pytest.raises(TraceError, match="what an algorithm calls"):
        _ = loss.kernel_signature
    with pytest.raises(TraceError, match="what is exported"):
        loss.export("c99", tmp_path)
