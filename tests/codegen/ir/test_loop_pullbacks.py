"""Reverse derivatives of algorithms: against differences of the text with sixty digits, and refusals."""

from __future__ import annotations

import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import codegen, errors
from bladesmith.codegen import algorithm
from bladesmith.codegen.algorithms import dense
from bladesmith.codegen.build import extension
from bladesmith.codegen.language import (
    InOut,
    Int,
    IntVector,
    Matrix,
    Out,
    Real,
    Reals,
    Rows,
    Static,
    Vector,
    atan2,
    cos,
    empty,
    exp,
    int_zeros,
    log,
    sin,
    sqrt,
    zeros,
)  # fmt: skip
from bladesmith.codegen.trace.outputs import status

from ...support.export.drivers import WARNINGS
from ...support.targets.derivatives import differences, precise

cga = bs.cga3d
pytestmark = pytest.mark.skipif(extension.compiler() is None, reason="no C compiler")
rng = np.random.default_rng(11)


@algorithm
def operators(x: Vector[3], y: Real, out: Out[Vector[2]]) -> Real:
    """Every operator and function, numbers that are replaced, and branches."""
    a = sin(x[0]) * cos(y) - exp(-x[1] * x[1]) / (2.0 + y * y)
    a = a * a - (x[2] - a) / (1.0 + abs(a))
    b = atan2(x[0], y) + log(1.0 + y * y) - sqrt(3.0 + x[2] * x[2])
    b += min(x[0], x[1]) * max(a, y)
    out[0] = b if a < b else -b * x[0]
    if x[0] < x[1]:
        out[1] = x[0] * x[1]
    else:
        out[1] = y
    out[1] *= a
    return -a / b


@algorithm
def first_above(v: InOut[Vector[3]], limit: Real) -> tuple[Real, Int]:
    """Loops that are left by break, continue and return, and what they have changed by then."""
    total = limit
    for i in range(4):
        for j in range(i, 3):
            if v[j] < limit - 3.0:
                continue
            total += v[j] * total
            v[j] -= 0.1 * total * total
            if j + i == 3 and total > 4.0:
                break
            if total > 9.0:
                return total * v[0], i
        total = sin(total) + limit
    return total, -1


@algorithm
def left_in_branches(x: Vector[3], n: Int) -> Real:
    """Loops that are left, in branches that are not."""
    total = x[0]
    if x[0] + x[1] > -1.0:
        for i in range(6):
            if total * total > 2.0:
                break
            if i % 2 == 1:
                continue
            total = total * total + x[i % 3] * total + 0.4
    else:
        for i in range(n, n + 3):
            total += sin(total) * x[i % 3]
            break
    return total * x[2]


@algorithm
def in_place(x: InOut[Vector[4]], a: InOut[Matrix[3, 3]], n: InOut[IntVector[4]], m: Int) -> Real:
    """Indices that are read from an array that changes, swaps, arrays made anew, loops of no steps."""
    k = 0
    s = x[0]
    for i in range(7, -2, -3):
        n[n[0] % 4] = (n[1] + i) % 4
        work = zeros(2)
        work[i % 2] = s * x[n[0] % 4]
        x[n[2] % 4], x[1] = x[1], work[0] - work[1] * s
        for _ in range(k, k - 1):
            s = 100.0
        s += x[k % 4] * a[k % 3, 1]
        a[(i + m) % 3][:] = (s, x[2], a[1, k % 3] * s)
        k += 1
    while k < 9 and s * s < 50.0:
        k += 2
        s = 1.1 * s + x[k % 4]
    return s / (1.0 + x[0] * x[0])


@algorithm
def scale(source: Vector[3], target: InOut[Vector[3]], by: Real) -> None:
    """Target plus by times source, where both may be one array."""
    for i in range(3):
        target[i] += by * source[2 - i] * source[i]


@codegen.kernel(codegen.numbers(3), codegen.numbers(3), codegen.scalar, algebra=cga)
def cross(a, b, s):
    return codegen.row([s * a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0] * s])


@algorithm
def calls(a: Matrix[3, 3], b: Vector[3], s: Real, x: Out[Vector[3]]) -> Real:
    """Kernels, algorithms with and without a declared derivative, of one array twice."""
    factor = empty(3, 3)
    factor[:] = a
    x[:] = b
    for _ in range(2):
        x[:] = cross(b, x, s * x[0])
        scale(x, x, s)
        scale(b, x, x[0])
    dense.cholesky(factor)
    dense.solve_cholesky(factor, x)
    return x[0] * factor[1, 1]


@algorithm
def of_any_size(x: Vector, shift: Static) -> Real:
    """A loss of neighbours."""
    total = 0.0
    for i in range(len(x) - 1):
        rest = x[i + 1] - x[i] * x[i] + shift
        total += rest * rest * rest
    return total


@algorithm
def of_rows(rows: Rows[2], weights: Reals, sums: Out[Vector[2]]) -> Real:
    """Rows whose number is known at a call; integers that are no index."""
    seen = int_zeros(1)
    best = 1.0
    for i in range(len(rows)):
        row = rows[i]
        best = best * cos(row[0] * weights[i]) + row[1]
        sums[0] += row[0] * best
        seen[0] += 1
    sums[1] = best * float(seen[0])
    return best


def positive(count: int) -> Any:
    a = rng.normal(size=(count, 3, 3))
    return a @ a.transpose(0, 2, 1) + np.eye(3)


N = 8
CASES: list[tuple[Any, tuple[Any, ...], tuple[str, ...]]] = [
    (operators, (rng.normal(size=(N, 3)), rng.normal(size=N)), ("x", "y")),
    (first_above, (rng.normal(size=(N, 3)), rng.normal(size=N)), ("v", "limit")),
    (first_above, (rng.normal(size=(N, 3)) * 2.0, rng.normal(size=N)), ("limit",)),
    (
        in_place,
        (rng.normal(size=(N, 4)), rng.normal(size=(N, 3, 3)), rng.integers(0, 9, (N, 4)), np.arange(N)),
        ("x", "a"),
    ),
    (left_in_branches, (rng.normal(size=(N, 3)), np.arange(N)), ("x",)),
    (calls, (positive(N), rng.normal(size=(N, 3)), rng.normal(size=N)), ("a", "b", "s")),
    (calls, (positive(N), rng.normal(size=(N, 3)), rng.normal(size=N)), ("s",)),
    (of_rows, (rng.normal(size=(N, 5, 2)), rng.normal(size=(N, 5))), ("rows", "weights")),
]
IDS = [f"{case[0].name}_{'_'.join(case[2])}" for case in CASES]


def cotangents(function: Any, arguments: Any) -> list[Any]:
    """Random cotangents of the real results, in their order."""
    results = function(*arguments)
    results = results if isinstance(results, tuple) else (results,)
    return [rng.normal(size=np.shape(r)) for r in results if r.dtype.kind == "f"]


@pytest.mark.parametrize("case", CASES, ids=IDS)
def test_cotangents_are_those_of_the_text(case: Any) -> None:
    """Paired with a direction, they are the tangents of the text paired with the cotangents of the results."""
    function, arguments, wrt = case
    names = [p.name for p in function.text.parameters if p.access != "out"]
    given = cotangents(function, arguments)
    found = function.vjp(*arguments, wrt=wrt)(*given)
    assert [f.shape for f in found] == [np.shape(arguments[names.index(name)]) for name in wrt]
    results = function(*arguments)
    results = results if isinstance(results, tuple) else (results,)
    context = precise()
    for i in range(N):
        own = {name: rng.normal(size=f[i].shape) for name, f in zip(wrt, found, strict=True)}
        item = [a[i] for a in arguments]
        sizes = np.cumsum([np.size(r[i]) for r in results])[:-1]
        parts = np.split(np.array(differences(function, item, own, context)), sizes)
        reals = [p for p, r in zip(parts, results, strict=True) if r.dtype.kind == "f"]
        expected = [np.ravel(c[i]) * p for c, p in zip(given, reals, strict=True)]
        computed = [np.ravel(f[i] * own[name]) for name, f in zip(wrt, found, strict=True)]
        size = sum(np.abs(v).sum() for v in (*expected, *computed)) + 1e-300
        assert abs(sum(v.sum() for v in expected) - sum(v.sum() for v in computed)) < 1e-13 * size


@pytest.mark.compiles
@pytest.mark.peers
@pytest.mark.parametrize("case", CASES[2:4], ids=IDS[2:4])
def test_numba_has_the_same_bits(case: Any) -> None:
    function, arguments, wrt = case
    given = cotangents(function, arguments)
    made = function.pullback(*wrt)
    by_c, by_numba = made(*arguments, *given), made.on("numba")(*arguments, *given)
    for a, b in zip(np.atleast_1d(by_c), np.atleast_1d(by_numba), strict=True) if len(wrt) == 1 else zip(
        by_c, by_numba, strict=True
    ):  # fmt: skip
        assert np.array_equal(a, b)


@pytest.mark.parametrize("n", [2, 50])
def test_a_loss_of_many_numbers(n: int) -> None:
    """Against its gradient, written by hand."""
    x = rng.normal(size=n)
    (found,) = of_any_size.vjp(x, 0.25, wrt=["x"])(2.0)
    rest = x[1:] - x[:-1] ** 2 + 0.25
    expected = np.zeros(n)
    expected[1:] += 6.0 * rest**2
    expected[:-1] -= 12.0 * rest**2 * x[:-1]
    assert np.allclose(found, expected, rtol=1e-13)


def test_single_precision() -> None:
    x = rng.normal(size=(5, 20)).astype(np.float32)
    (found,) = of_any_size.vjp(x, 0.25)(np.ones(5, np.float32))
    (expected,) = of_any_size.vjp(x.astype(float), 0.25)(np.ones(5))
    assert found.dtype == np.float32
    assert np.abs(found - expected).max() < 1e-5 * np.abs(expected).max()


# -- batches -----------------------------------------------------------------------------------------------------------


def test_what_items_share_has_the_sum() -> None:
    x, y, w = rng.normal(size=(5, 3)), rng.normal(size=(4, 1)), rng.normal(size=(4, 5))
    dx, dy = operators.vjp(x, y)(np.ones(2), w)
    each_x, each_y = operators.vjp(np.broadcast_to(x, (4, 5, 3)), np.broadcast_to(y, (4, 5)))(np.ones((4, 5, 2)), w)
    assert dx.shape == (5, 3) and dy.shape == (4, 1)
    assert np.allclose(dx, each_x.sum(0), rtol=1e-13) and np.allclose(dy, each_y.sum(1, keepdims=True), rtol=1e-13)


def test_one_parameter_by_its_name() -> None:
    assert len(operators.vjp(np.ones(3), 0.5, wrt="y")(np.zeros(2), 1.0)) == 1
    with pytest.raises(errors.InputError, match="'xy'; there are: x, y"):
        operators.vjp(np.ones(3), 0.5, wrt="xy")


def test_one_item_and_none() -> None:
    dx, dy = operators.vjp(np.ones(3), 0.5)(np.zeros(2), 1.0)
    assert dx.shape == (3,) and dy.shape == ()
    dx, dy = operators.vjp(np.ones((0, 3)), 0.5)(np.zeros((0, 2)), np.zeros(0))
    assert dx.shape == (0, 3) and dy == 0.0


def test_rows_that_are_not_there() -> None:
    d_rows, d_weights = of_rows.vjp(np.zeros((0, 2)), np.zeros(0))(np.ones(2), 1.0)
    assert d_rows.shape == (0, 2) and d_weights.shape == (0,)


# -- kinks and poles ---------------------------------------------------------------------------------------------------


@algorithm
def kinks(x: Vector[2]) -> Real:
    """At zero all are kinks."""
    return 2.0 * abs(x[0]) + 3.0 * min(x[0], x[1]) + 5.0 * max(x[0], x[1]) + (7.0 * x[1] if x[0] > 0.0 else x[0])


@algorithm
def root_unless_zero(x: Real, y: Real) -> Real:
    """A root whose infinite derivative does not count."""
    root = sqrt(x) / y
    return root if y > 1.0 else x


@codegen.kernel(codegen.scalar, codegen.scalar, algebra=cga)
def checked_root(a, b):
    return codegen.sqrt(a) * b, status(codegen.select(a >= 0, a.constant(0), a.constant(6)))


@algorithm
def roots_that_exist(x: Vector[3], y: Real) -> Real:
    """Roots by a kernel with a status, NaN where it is not OK; and what is computed but not selected."""
    total = y
    for i in range(3):
        root, code = checked_root(x[i], total)
        if code == 0.0:
            total = root
        large = exp(1000.0 * x[i])
        square = large * large * total
        invalid = sqrt(-1.0 - x[i] * x[i]) * total
        total = square if x[i] < -100.0 else total
        total = invalid if x[i] > 100.0 else total
    return total


@algorithm
def angle(y: Real, x: Real) -> Real:
    """The angle of a point."""
    return atan2(y, x)


def test_kinks_are_those_of_tangents() -> None:
    (found,) = kinks.vjp(np.zeros(2))(1.0)
    expected = [kinks.derivative("x")(np.zeros(2), d)[1] for d in np.eye(2)]
    assert found.tolist() == expected == [11.0, 0.0]


def test_what_does_not_count_has_no_infinite_share() -> None:
    dx, dy = root_unless_zero.vjp(0.0, 0.0)(1.0)
    assert dx == 1.0 and dy == 0.0


def test_what_is_not_selected_may_be_infinite_or_nan() -> None:
    """By hand: the total is y times roots of 1 and 4."""
    dx, dy = roots_that_exist.vjp(np.array([1.0, -2.0, 4.0]), 3.0)(1.0)
    assert np.allclose(dx, [3.0, 0.0, 0.75], rtol=1e-15) and dy == 2.0


@pytest.mark.parametrize("scale", [1e-300, 1e-200, 1.0, 1e200, 2e307])
def test_angles_of_points_near_and_far(scale: float) -> None:
    """Against partial derivatives with many digits; squares of the coordinates leave the range of numbers."""
    y, x = 3.0 * scale, 4.0 * scale
    context = precise()
    square = context.mpf(x) ** 2 + context.mpf(y) ** 2
    expected = [float(context.mpf(x) / square), float(-context.mpf(y) / square)]
    found = [float(d) for d in angle.vjp(y, x)(1.0)]
    along = [float(angle.derivative(name)(y, x, 1.0)[1]) for name in "yx"]
    assert np.allclose([found, along], expected, rtol=1e-15, atol=1e-323)


# -- export ------------------------------------------------------------------------------------------------------------


@algorithm
def unread(x: Real, out: Out[Vector[2]]) -> Real:
    """An array whose values the reverse sweep does not need."""
    out[0] = 2.0 * x
    out[1] = x
    return x * x


@pytest.mark.compiles
def test_exported_c_compiles_without_a_warning(tmp_path: Path) -> None:
    x, limit, given = np.array([0.5, -0.2, 1.5]), 0.7, np.array([1.0, 2.0, 3.0])
    made = first_above.pullback("v", "limit")
    expected = made(x, limit, given, 0.5)
    made.export("c99", tmp_path, name="above")
    in_place.pullback("x", "a").export("c99", tmp_path, name="places")
    unread.pullback().export("c99", tmp_path, name="unread")
    (tmp_path / "main.c").write_text("""
        #include <stdio.h>
        #include "above.h"
        #include "places.h"
        #include "unread.h"
        int main(void) {
          double x[3] = {0.5, -0.2, 1.5}, given[3] = {1.0, 2.0, 3.0}, bar[3];
          double limit = above_first_above_vjp_v_limit(x, 0.7, given, 0.5, bar);
          printf("%.17g %.17g %.17g %.17g\\n", bar[0], bar[1], bar[2], limit);
          return 0;
        }
    """)
    command = ["gcc", "-std=c99", *WARNINGS, "-O2", "-ffp-contract=off", "main.c", "-o", "main", "-lm"]
    subprocess.run(command, cwd=tmp_path, check=True)
    printed = subprocess.run(["./main"], cwd=tmp_path, check=True, capture_output=True, text=True).stdout.split()
    assert [float(v) for v in printed] == [*expected[0], expected[1]]


# -- refusals ----------------------------------------------------------------------------------------------------------


@algorithm
def until_small(x: Real) -> Real:
    """A loop of any number of steps, each of which counts."""
    while x > 1e-3:
        x = sin(x) * x
    return x


@algorithm
def of_count(x: Real, n: Int) -> Real:
    """The same, of as many as a caller says."""
    for _ in range(n):
        x = sin(x)
    return x


@algorithm
def with_bound(x: Real, n: Int) -> Real:
    """The same, bounded."""
    for _ in range(min(n, 20)):
        x = sin(x)
    return x


@algorithm
def without_need(x: Real, n: Int) -> Real:
    """A loop of any number of steps that needs nothing kept."""
    total = 0.0
    for k in range(n):
        total += x * float(k)
    return total


@algorithm
def too_long(x: Real) -> Real:
    """More than is kept."""
    for _ in range(200000):
        x = sin(x)
    return x


def test_memory_is_bounded() -> None:
    place = rf"test_loop_pullbacks.py:{until_small.text.first + 3}: .* each step of this loop.*derivative\(\.\.\.\)"
    with pytest.raises(errors.AlgorithmError, match=place):
        until_small.vjp(1.0)(1.0)
    with pytest.raises(errors.AlgorithmError, match=r"range\(min\(n, 100\)\)"):
        of_count.vjp(1.0, 3)(1.0)
    with pytest.raises(errors.AlgorithmError, match=r"keeps 200000 numbers, .* 131072 fit"):
        too_long.vjp(1.0)(1.0)
    assert np.isclose(with_bound.vjp(1.0, 3)(1.0)[0], with_bound.derivative("x")(1.0, 3, 1.0)[1], rtol=1e-15)
    assert with_bound.vjp(0.3, -2)(1.5) == (1.5,)
    assert without_need.vjp(2.0, 1000)(1.0) == (499500.0,)


@pytest.mark.parametrize(
    ("call", "error", "message"),
    [
        (lambda: operators.vjp(np.ones(3)), errors.InputError, "takes 2 arguments"),
        (lambda: operators.vjp(np.ones(3), 1.0)(1.0), errors.InputError, "2 cotangents .out_bar, result_bar., not 3"),
        (lambda: operators.vjp(np.ones(3), 1.0)(np.ones(3), 1.0), errors.ShapeError, r"out_bar has shape \(3,\)"),
        (lambda: operators.vjp(np.ones(3), 1.0)(np.ones((2, 2)), 1.0), errors.ShapeError, "more than there are"),
        (lambda: operators.vjp(np.ones(3), 1.0)(np.ones(2), "a"), errors.InputError, "result_bar"),
        (lambda: operators.vjp(np.ones(3), 1.0, wrt=["z"]), errors.InputError, "there are: x, y"),
        (lambda: in_place.pullback("n"), errors.InputError, "no parameter of real numbers 'n'"),
        (lambda: of_any_size.pullback("x").source(), errors.InputError, "give the arguments of a call"),
    ],
)
def test_what_is_refused(call: Any, error: Any, message: str) -> None:
    with pytest.raises(error, match=message):
        call()
