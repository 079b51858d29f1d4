"""Poses at 50 digits from power series of dual quaternions, and errors in units of roundoff times the condition number.

A dual quaternion is (real, dual), d = p r/2 with the position p; no geometric algebra in here.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import mpmath

from .dual_quaternions import MP, Dual, conjugate, exponential, hamilton, times

ROUNDING = MP.mpf(2) ** -53
#: Numbers that belong together: w and v of a twist, real and dual part of a pose.
TWIST_PARTS, POSE_PARTS = ((0, 1, 2), (3, 4, 5)), ((0, 1, 2, 3), (4, 5, 6, 7))
Row = Sequence[Any]


def exact(row: Row) -> list[Any]:
    return [MP.mpf(float(x)) for x in row]


def exp(twist: Row) -> list[Any]:
    """The dual quaternion (8) of the exponential of a twist (w, v)."""
    w, v = ([MP.mpf(0), *(x / 2 for x in part)] for part in (twist[:3], twist[3:]))
    real, dual = exponential((w, v))
    return [*real, *dual]


def pair(row: Row) -> Dual:
    return list(row[:4]), list(row[4:])


def position(row: Row) -> list[Any]:
    real, dual = pair(row)
    return [2 * x for x in hamilton(dual, conjugate((real, dual))[0])[1:]]


def matrix(row: Row) -> list[list[Any]]:
    """The homogeneous matrix of a dual quaternion, from images of the axes."""
    real, back = list(row[:4]), conjugate(pair(row))[0]
    images = [hamilton(hamilton(real, [0, *(MP.mpf(int(i == j)) for i in range(3))]), back)[1:] for j in range(3)]
    columns = [*images, position(row)]
    return [[columns[j][i] for j in range(4)] for i in range(3)] + [[0, 0, 0, 1]]


def unit(row: Row) -> list[Any]:
    """The nearest unit dual quaternion."""
    real, dual = pair(row)
    length = MP.sqrt(sum(x * x for x in real))
    off = sum(x * y for x, y in zip(real, dual, strict=True)) / length**2
    return [*(x / length for x in real), *((y - off * x) / length for x, y in zip(real, dual, strict=True))]


def small_twist(change: Row, row: Row) -> list[Any]:
    """The twist of the world that changes a pose so: 2 dX ~X."""
    real, dual = times(pair(change), conjugate(pair(row)))
    return [2 * x for x in (*real[1:], *dual[1:])]


def left_jacobian(twist: Row) -> mpmath.matrix:
    """The derivative of the exponential in the world, by differences of 17 digits' steps at 50."""
    step, here = MP.mpf(10) ** -17, exp(twist)
    columns = []
    for i in range(6):
        ends = []
        for side in (1, -1):
            moved = list(twist)
            moved[i] += side * step
            ends.append(exp(moved))
        change = [(a - b) / (2 * step) for a, b in zip(*ends, strict=True)]
        columns.append(small_twist(change, here))
    return MP.matrix(columns).T


def norm(row: Row) -> Any:
    return MP.sqrt(sum(x * x for x in row))


def roundings(found: Row, value: Row, changes: Sequence[Row], parts: Sequence[Sequence[int]]) -> float:
    """Largest error of a part, in units of roundoff of the part and of what changes of the arguments make of it.

    ``changes`` has the change of the value for a change of each argument by its own size: their sum, relative to the
    value, is the condition number; one unit more is for rounding the result.
    """
    worst = MP.mpf(0)
    for part in parts:
        error = norm([value[k] - MP.mpf(float(found[k])) for k in part])
        scale = norm([value[k] for k in part]) + sum(norm([change[k] for k in part]) for change in changes)
        if error:
            worst = max(worst, error / (ROUNDING * scale) if scale else MP.inf)
    return float(worst)


def changes_of(function: Callable[[Row], Row], row: Row) -> list[list[Any]]:
    """Change of a function's values for a change of each argument by its own size, by differences at 50 digits."""
    step = MP.mpf(10) ** -17
    found = []
    for i, x in enumerate(row):
        if not x:
            continue
        ends = []
        for side in (1, -1):
            moved = list(row)
            moved[i] = x * (1 + side * step)
            ends.append(function(moved))
        found.append([(a - b) / (2 * step) for a, b in zip(*ends, strict=True)])
    return found


def exp_roundings(twist: Row, found: Row) -> float:
    row = exact(twist)
    return roundings(found, exp(row), changes_of(exp, row), POSE_PARTS)


def log_roundings(pose: Row, found: Row) -> float:
    """Error of a logarithm by Newton's step from it to that of the pose; at full turns there is none."""
    row, twist = exact(pose), exact(found)
    target = unit(row)
    inverse = MP.inverse(left_jacobian(twist))
    step = list(inverse * MP.matrix(small_twist([a - b for a, b in zip(target, exp(twist), strict=True)], target)))
    value = [a + b for a, b in zip(twist, step, strict=True)]
    changes = []
    for i, x in enumerate(row):
        change = [x if i == j else MP.mpf(0) for j in range(8)]
        changes.append(list(inverse * MP.matrix(small_twist(change, target))))
    return roundings(found, value, changes, TWIST_PARTS)
