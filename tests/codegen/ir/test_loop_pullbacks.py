"""Reverse derivatives of algorithms: against differences of the text with sixty digits, and what is infinite."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import codegen, errors
from bladesmith.codegen import algorithm
from bladesmith.codegen.build import extension
from bladesmith.codegen.language import (
    Real,
    Vector,
    atan2,
    exp,
    sqrt,
)  # fmt: skip
from bladesmith.codegen.trace.outputs import status

from ...support.targets.derivatives import differences, precise
from ...support.targets.pullbacks import calls, first_above, in_place, left_in_branches, of_any_size, of_rows, operators

cga = bs.cga3d
pytestmark = pytest.mark.skipif(extension.compiler() is None, reason="no C compiler")
rng = np.random.default_rng(11)


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
    along = [roots_that_exist.derivative("x")(np.array([1.0, -2.0, 4.0]), 3.0, d) for d in np.eye(3)]
    assert np.allclose([value for value, _ in along], 6.0) and np.allclose([d for _, d in along], dx, rtol=1e-15)


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
