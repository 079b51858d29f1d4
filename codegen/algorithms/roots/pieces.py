"""Bernstein coefficients of a polynomial on a piece of [0, 1]: halves, cuts, sign variations, derivative."""

from __future__ import annotations

from ...ir.loops.algorithm import Algorithm as algorithm
from ...ir.loops.algorithm import inlined
from ...ir.loops.language import Bool, InOut, Int, Real, Reals, Static, empty, unrolled

#: Up to this degree coefficients stay in registers when loops over them are written out.
SHORT = 12


@inlined
def halve(degree: Static, left: InOut[Reals], right: InOut[Reals], c: Reals) -> None:
    """Coefficients on both halves of the interval of c; left or right may be c.

    Where there are few, sums are halved at the sides of the triangle only; where there are many, as they are made, lest
    they grow out of range.
    """
    w = empty(degree + 1)
    for i in unrolled(degree + 1):
        w[i] = c[i]
    if degree <= SHORT:
        for i in unrolled(degree + 1):
            side = 0.5**i
            left[i] = side * w[0]
            right[degree - i] = side * w[degree - i]
            for j in unrolled(degree - i):
                w[j] = w[j] + w[j + 1]
    else:
        for i in range(degree + 1):
            left[i] = w[0]
            right[degree - i] = w[degree - i]
            for j in range(degree - i):
                w[j] = 0.5 * (w[j] + w[j + 1])


@inlined
def unsure_variations(degree: Static, c: Reals, noise: Real) -> Int:
    """`variations` where some coefficients are within noise of zero.

    Were every sign unlike the one before, there would be as many changes as the degree: one less for each certain sign
    that does not fit to the certain one before.
    """
    misfits = 0
    last: Bool = False
    known: Bool = False
    for i in unrolled(degree + 1):
        below = c[i] < -noise
        certain = below | (c[i] > noise)
        turned = certain & (last ^ below ^ (i & 1 == 1))
        misfits += 1 if known & turned else 0
        last = last ^ turned
        known = known | certain
    return degree - misfits if known else -2


@inlined
def variations(degree: Static, c: Reals, noise: Real) -> tuple[Int, Bool]:
    """Most sign changes of the coefficients, and whether some are within noise of zero: these may take either sign.

    There are no fewer than the polynomial has roots. -1: all have one certain sign. -2: they are all noise.
    """
    before = not c[0] >= 0.0
    changes = 0
    least = abs(c[0])
    for i in unrolled(1, degree + 1):
        size = abs(c[i])
        is_negative = not c[i] >= 0.0
        least = min(least, size)
        changes += 1 if before ^ is_negative else 0
        before = is_negative
    if least > noise:
        return changes if changes > 0 else -1, False
    return unsure_variations(degree, c, noise), True


@algorithm
def recount(degree: Static, c: Reals, noise: Real) -> tuple[Int, Bool]:
    """`variations`, where it is rare."""
    count, is_unsure = variations(degree, c, noise)
    return count, is_unsure


@inlined
def crossing(degree: Static, c: Reals) -> Real:
    """Where the polygon of the coefficients first changes sign, as a fraction of its interval: near a root."""
    at = degree - 1
    first = c[degree - 1]
    after = c[degree]
    for i in unrolled(degree - 2, -1, -1):
        is_change = (c[i] < 0.0) ^ (c[i + 1] < 0.0)
        at = i if is_change else at
        first = c[i] if is_change else first
        after = c[i + 1] if is_change else after
    part = first / (first - after)
    return (float(at) + (part if part > 0.0 and part < 1.0 else 0.5)) / float(degree)


@inlined
def cut_above(degree: Static, c: InOut[Reals], r: Real) -> None:
    """Coefficients from the start of the interval to the fraction r of it."""
    for n in range(degree, 0, -1):
        for i in range(n):
            low = degree - i - 1
            c[low + 1] = (1.0 - r) * c[low] + r * c[low + 1]


@inlined
def cut_below(degree: Static, c: InOut[Reals], r: Real) -> None:
    """Coefficients from the fraction r of the interval to its end."""
    for n in range(degree, 0, -1):
        for i in range(n):
            c[i] = (1.0 - r) * c[i] + r * c[i + 1]


@inlined
def slope(degree: Static, c: Reals, r: Real) -> Real:
    """Derivative at the fraction r of the interval, up to a positive factor."""
    w = empty(degree)
    for i in range(degree):
        w[i] = c[i + 1] - c[i]
    for n in range(degree - 1, 0, -1):
        for i in range(n):
            w[i] = (1.0 - r) * w[i] + r * w[i + 1]
    return w[0]
