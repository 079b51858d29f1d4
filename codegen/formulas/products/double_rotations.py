"""Squares of the two simple parts of a bivector, and double rotations by nearly equal angles as sums of two halves."""

from __future__ import annotations

from typing import NamedTuple

from ...algebra.multivector import Mask, Multivector, atan2, select, sqrt
from .outcome import NOISE, as_computed, epsilon
from .parabolic import two_numbers


class Squares(NamedTuple):
    """The squares l1 <= l2 of the simple parts of a bivector B, and their difference d >= 0; B^2 = s + q."""

    s: Multivector
    q: Multivector
    l1: Multivector
    l2: Multivector
    d: Multivector


def squares(b: Multivector) -> Squares:
    """l1, l2 = (s -+ d)/2 with d^2 = s^2 - q^2, the smaller in size from l1 l2 = q^2/4: nothing is subtracted.

    Where l1 and l2 nearly agree, d has half of the digits only: what is made of them must be symmetric.
    """
    square = b * b
    s, q = square.grade(0), square.grade(4)
    return Squares(s, q, *two_numbers(s, (q * q).grade(0) / 4))


def square_of(b: Multivector) -> Multivector:
    """The scalar part of b^2."""
    return (b * b).grade(0)


class Half(NamedTuple):
    """One half of a double rotation: R i = (c + v) i with the idempotent i, and the angle of c + v in [0, pi]."""

    i: Multivector
    c: Multivector
    v: Multivector
    sine: Multivector
    f: Multivector


def halves(r: Multivector, squares: Squares) -> tuple[Mask, list[Half]]:
    """Mask of two rotations by angles that nearly agree, or add up to nearly a turn; and R as sum of two halves.

    There the planes are badly determined, but the 4-vector of both together, J with J^2 = 1, is not: R is the sum of
    R (1 + J)/2 and R (1 - J)/2, whose bivectors have angles f - g and f + g. Each is projected twice, so that a small
    one has no rounding of the other left in it.
    """
    r0, v, r4 = r.grade(0), r.grade(2), r.grade(4)
    r4_squared = (r4 * r4).grade(0)
    least = epsilon(r) * epsilon(r)  # a square that can be squared
    double = (2 * squares.d < -squares.s) & (squares.s < -least)
    double = double | (2 * r4_squared > 1)  # there s may be noise above zero
    by_r4 = 4 * r0 * r0 < 1
    both = select(by_r4, r4, squares.q)
    j = both / sqrt(select(by_r4, r4_squared, (squares.q * squares.q).grade(0)))
    cosine = (r4 * j).grade(0)
    found = []
    across = (v * j).grade(2)
    for sign in (1, -1):
        half = as_computed((v + across * sign) / 2)
        turned = (half * j).grade(2)
        half = ((turned * j).grade(2) + turned * sign) / 2
        c, sine = r0 + cosine * sign, sqrt(-2 * square_of(half))
        found.append(Half((1 + j * sign) / 2, c, half, sine, atan2(sine, c)))
    return double, found


def has_half_turn(parts: list[Half]) -> Mask:
    """Return whether a half of a double rotation is -1, so that its plane is any."""
    first, second = ((h.sine <= NOISE * epsilon(h.c)) & (h.c < 0) for h in parts)
    return first | second
