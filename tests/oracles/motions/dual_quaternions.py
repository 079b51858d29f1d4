"""Maps from twists to motors from their definitions, on dual quaternions at 50 digits: no geometric algebra in here.

q + eps d with i = -e23, j = -e31, k = -e12, eps = I3 n, so that w I3 + v n is -w + eps v.
"""

from __future__ import annotations

from typing import Any

import mpmath

MP = mpmath.mp.clone()
MP.dps = 50
Dual = tuple[list[Any], list[Any]]


def hamilton(a: list[Any], b: list[Any]) -> list[Any]:
    return [
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    ]


def times(a: Dual, b: Dual) -> Dual:
    mixed = [x + y for x, y in zip(hamilton(a[0], b[1]), hamilton(a[1], b[0]), strict=True)]
    return hamilton(a[0], b[0]), mixed


def plus(a: Dual, b: Dual, weight: Any = 1) -> Dual:
    return [x + weight * y for x, y in zip(a[0], b[0], strict=True)], [
        x + weight * y for x, y in zip(a[1], b[1], strict=True)
    ]


def conjugate(a: Dual) -> Dual:
    return tuple([p[0], -p[1], -p[2], -p[3]] for p in a)  # type: ignore[return-value]


def inverse(a: Dual) -> Dual:
    """conj(a)/(s + eps p) with a conj(a) = s + eps p."""
    norm = times(a, conjugate(a))
    s, p = norm[0][0], norm[1][0]
    return times(conjugate(a), ([1 / s, 0, 0, 0], [-p / s**2, 0, 0, 0]))


def dual(row: Any) -> Dual:
    """A twist (w, v)."""
    w, v = row[:3], row[3:]
    return [MP.mpf(0), *(-MP.mpf(x) for x in w)], [MP.mpf(0), *(MP.mpf(x) for x in v)]


def row_of(a: Dual) -> list[Any]:
    return [-x for x in a[0][1:]] + list(a[1][1:])


ONE: Dual = ([MP.mpf(1), 0, 0, 0], [MP.mpf(0), 0, 0, 0])
NOTHING: Dual = ([MP.mpf(0)] * 4, [MP.mpf(0)] * 4)


def exponential(a: Dual) -> Dual:
    """Power series of an eighth, squared three times."""
    total = term = ONE
    for n in range(1, 33):
        term = times(term, plus(NOTHING, a, MP.mpf(1) / (8 * n)))
        total = plus(total, term)
    for _ in range(3):
        total = times(total, total)
    return total


def motor(name: str, row: Any) -> Dual:
    """Each map from its definition."""
    phi = dual(row)
    if name == "exponential":
        return exponential(plus(NOTHING, phi, -MP.mpf(1) / 2))
    if name == "bortz":
        turn = exponential(plus(NOTHING, (phi[0], NOTHING[1]), -MP.mpf(1) / 2))
        return times((ONE[0], [-x / 2 for x in phi[1]]), turn)
    if name == "cayley":
        return times(plus(ONE, phi, -1), inverse(plus(ONE, phi)))
    lifted = ([MP.mpf(0)] * 4, [times(phi, phi)[1][0] / 2, 0, 0, 0])
    raw = plus(plus(ONE, phi), lifted)
    return times(raw, ([1 / MP.sqrt(times(raw, conjugate(raw))[0][0]), 0, 0, 0], [MP.mpf(0)] * 4))


def slopes(name: str, row: Any) -> list[Dual]:
    """-2 dR for each of the six numbers, from differences at 50 digits."""
    step = MP.mpf(10) ** -17
    found = []
    for i in range(6):
        ends = []
        for side in (1, -1):
            moved = [MP.mpf(x) for x in row]
            moved[i] += side * step
            ends.append(motor(name, moved))
        found.append(plus(NOTHING, plus(ends[0], ends[1], -1), -1 / step))
    return found
