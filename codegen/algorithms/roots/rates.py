"""Refinement of roots from a condition and its derivative, and what becomes of noisy runs."""

from __future__ import annotations

from ...ir.loops.algorithm import Algorithm as algorithm
from ...ir.loops.algorithm import inlined
from ...ir.loops.language import (
    Bool,
    InOut,
    Int,
    IntVector,
    Matrix,
    Out,
    Real,
    Reals,
    Static,
    Vector,
    empty,
    int_empty,
    largest,
)  # fmt: skip
from ...ir.loops.records import record
from .problem import (
    F_HI,
    F_LO,
    FOUND,
    HI,
    LO,
    PIECE,
    PROBES,
    STEPS,
    VANISHES,
    Steps,
    append,
    by_precision,
    secant,
    touches,
    unit_roundoff,
    value,
    widest_run,
)  # fmt: skip

#: Most of Newton's step that its curvature may change; beyond, the series does not hold.
BENT = 0.25
#: Steps after which it is asked whether f is rounding only.
PATIENCE = 4.0
#: A root between ``lo`` and ``hi``, where f has unlike signs, on its way. ``before``: length of the last step;
#: ``other``: somewhere else, with f and, after a step, its slope there; ``side``: 1 or -1, the sign of f at ``lo``.
Bracket = record(
    "Bracket", lo=Real, hi=Real, x=Real, before=Real, other=Real, f_other=Real, rate_other=Real, side=Real, step=Real
)
BRACKET = Bracket.size
X = Bracket.offsets["x"]


@inlined
def close() -> Real:
    """A third-order step up to this is followed by one of which the error is known; fourth root of the roundoff."""
    return by_precision(0.015625, 1.0264824865746e-4)


@inlined
def rates_parted(
    problem: Static, ray: Reals, row: Reals, at: Real, f_lo: Real, roots_left: Int, f_hi: Real, roots_right: Int
) -> Real:
    """f where a piece was parted.

    Where p has no root in one half, f has the sign of that half's other end: no more need be known.
    """
    if roots_left == -1:
        return -largest() if f_lo < 0.0 else largest()
    if roots_right == -1:
        return -largest() if f_hi < 0.0 else largest()
    return value(problem, ray, row, at)


@inlined
def bent_step(
    f: Real, rate: Real, away: Real, f_other: Real, rate_other: Real, is_known: Bool
) -> tuple[Real, Real]:  # fmt: skip
    """Newton's step with the curvature of f, and half of f's second derivative over its first.

    The curvature as far as another value of f (and its slope there, if that is known) tells it.
    """
    inverse = 1.0 / rate
    over = 1.0 / away
    chord = (f_other - f) * over
    newton = -f * inverse
    bend = (3.0 * chord - rate_other - 2.0 * rate if is_known else chord - rate) * over * inverse
    part = bend * newton
    if not abs(part) <= BENT:
        bend = 0.0
    return newton if bend == 0.0 else newton * (1.0 - part + 2.0 * part * part), bend


@inlined
def rates_begin(lo: Real, f_lo: Real, hi: Real, f_hi: Real, guess: Real, b: Out[Bracket]) -> None:
    """A root on its way, from a first guess."""
    is_first = abs(f_lo) < largest()
    b.lo = lo
    b.hi = hi
    b.x = guess
    b.before = hi - lo
    b.other = lo if is_first else hi
    b.f_other = f_lo if is_first else f_hi
    b.rate_other = 0.0
    b.side = -1.0 if f_lo < 0.0 else 1.0
    b.step = 0.0


@inlined
def advance(problem: Static, ray: Reals, row: Reals, b: InOut[Bracket]) -> Bool:
    """One of Newton's steps, with the curvature from the place before; whether x is the root.

    Bisection where a step leaves the interval or does not shrink by half. A short step is followed by one with the same
    slope and curvature, of which the error is known: the slope is off by three times that step over the one before. It
    is the last when that is a rounding, or when f is nothing but its own rounding error. Of f at the ends only the sign
    need be known: as numbers those of `rates_parted` have no use.
    """
    tolerance = 2.0 * unit_roundoff()
    x = b.x
    f_rate = empty(2)
    problem.rate(problem, ray, row, x, 1.0 - x, f_rate)
    f = f_rate[0]
    rate = f_rate[1]
    move, bend = bent_step(f, rate, b.other - x, b.f_other, b.rate_other, b.step > 0.0)
    lo = b.lo
    hi = b.hi
    after = x + move
    size = abs(move)
    is_left = b.side * f > 0.0
    lo = x if is_left else lo
    hi = hi if is_left else x
    b.lo = lo
    b.hi = hi
    if f == 0.0 or hi - lo <= tolerance:
        return True
    b.step += 1.0
    if b.step == float(STEPS):
        return True
    b.other = x
    b.f_other = f
    b.rate_other = rate
    if not (after > lo and after < hi and size <= 0.5 * b.before):
        b.x = 0.5 * (lo + hi)
        b.before = hi - lo
        return False
    b.x = after
    b.before = size
    if size > close():
        return False
    f_after = value(problem, ray, row, after)
    last = -f_after / (rate * (1.0 + 2.0 * bend * move))
    rest = abs(last)
    is_before = b.side * f_after > 0.0
    lo = after if is_before else lo
    hi = hi if is_before else after
    b.lo = lo
    b.hi = hi
    if after + last >= lo and after + last <= hi:
        b.x = after + last
        if 3.0 * rest * rest <= tolerance * size:
            return True
    if not b.step > PATIENCE:
        return False
    bound = problem.bound(problem, ray, row, after, 1.0 - after)
    is_rounding: Bool = abs(f_after) <= unit_roundoff() * bound
    return is_rounding


@algorithm
def rates_refine(
    problem: Static, ray: Reals, row: Reals, lo: Real, f_lo: Real, hi: Real, f_hi: Real, guess: Real
) -> Real:
    """The root between lo and hi, where f has unlike signs, and where to begin."""
    b = empty(BRACKET)
    rates_begin(lo, f_lo, hi, f_hi, guess, b)
    is_done = False
    while not is_done:
        is_done = advance(problem, ray, row, b)
    return b[X]


@inlined
def rates_finish(
    problem: Static, ray: Reals, row: Reals, brackets: InOut[Matrix], count: Int, roots: InOut[Reals],
    found: InOut[IntVector[FOUND]],
) -> None:  # fmt: skip
    """Keep the roots of one or two brackets. In turns: they do not wait for one another."""
    done = int_empty(2)
    done[0] = 1 if count < 1 else 0
    done[1] = 1 if count < 2 else 0
    while done[0] + done[1] < 2:
        for i in range(count):
            if done[i] == 0:
                is_done = advance(problem, ray, row, brackets[i])
                done[i] = 1 if is_done else 0
    for i in range(count):
        append(roots, found, brackets[i, X])


@algorithm
def rates_dip(
    problem: Static, ray: Reals, row: Reals, lo: Real, f_lo: Real, hi: Real, f_hi: Real, roots: InOut[Reals],
    found: InOut[IntVector[FOUND]],
) -> Bool:  # fmt: skip
    """Keep the roots between two places where f has like signs; whether it comes nearer to zero from both.

    One root if it touches zero between, two if it crosses, by where its derivative vanishes: known to full accuracy
    where roots are not.
    """
    tolerance = 4.0 * unit_roundoff()
    side = -1.0 if f_lo < 0.0 else 1.0
    low = empty(2)
    high = empty(2)
    f_rate = empty(2)
    f_rate[0] = f_lo
    f_rate[1] = 0.0
    left = lo
    right = hi
    x = lo
    problem.rate(problem, ray, row, lo, 1.0 - lo, low)
    problem.rate(problem, ray, row, hi, 1.0 - hi, high)
    if not (side * low[1] < 0.0 and side * high[1] >= 0.0):
        return False
    for step in range(STEPS):
        if not right - left > tolerance:
            break
        crossing = left + (right - left) * (low[1] / (low[1] - high[1]))
        is_plain = step % 3 == 2 or not (crossing > left and crossing < right)
        x = 0.5 * (left + right) if is_plain else crossing
        problem.rate(problem, ray, row, x, 1.0 - x, f_rate)
        if side * f_rate[0] < 0.0 or f_rate[1] == 0.0:
            break
        if side * f_rate[1] < 0.0:
            left = x
            low[1] = f_rate[1]
        else:
            right = x
            high[1] = f_rate[1]
    f = f_rate[0]
    is_touching = touches(problem, ray, row, x, f)
    if is_touching:
        append(roots, found, x)
    elif side * f < 0.0:
        first = rates_refine(problem, ray, row, lo, f_lo, x, f, secant(lo, f_lo, x, f))
        append(roots, found, first)
        second = rates_refine(problem, ray, row, x, f, hi, f_hi, secant(x, f, hi, f_hi))
        append(roots, found, second)
    return True


@algorithm
def rates_between(
    problem: Static, ray: Reals, row: Reals, lo: Real, f_lo: Real, hi: Real, f_hi: Real, roots: InOut[Reals],
    found: InOut[IntVector[FOUND]],
) -> Bool:  # fmt: skip
    """Keep the roots between two places, by signs and slopes there; False: f only falls or only rises, and has none."""
    if not (f_lo < 0.0) ^ (f_hi < 0.0):
        return rates_dip(problem, ray, row, lo, f_lo, hi, f_hi, roots, found)  # type: ignore[no-any-return]
    root = rates_refine(problem, ray, row, lo, f_lo, hi, f_hi, secant(lo, f_lo, hi, f_hi))
    append(roots, found, root)
    return True


@algorithm
def rates_settle(
    problem: Static, ray: Reals, row: Reals, run: Vector[PIECE], c: Reals, begin: Real, end: Real,
    roots: InOut[Reals], found: InOut[IntVector[FOUND]],
) -> None:  # fmt: skip
    """Keep the roots of f in a run of noisy pieces, where roots of p nearly meet.

    p does not help, f and its slope tell. A wide run is searched in parts. At the ends of a short one f may touch zero.
    """
    f_lo = run[F_LO]  # of places inside perhaps only the sign is known yet
    f_hi = run[F_HI]
    if run[LO] > begin:
        f_lo = value(problem, ray, row, run[LO])
    if run[HI] < end:
        f_hi = value(problem, ray, row, run[HI])
    if not run[HI] - run[LO] > widest_run():
        is_found = rates_between(problem, ray, row, run[LO], f_lo, run[HI], f_hi, roots, found)
        if not is_found:
            is_first = abs(f_lo) < abs(f_hi)
            x = run[LO] if is_first else run[HI]
            is_touching = touches(problem, ray, row, x, f_lo if is_first else f_hi)
            if is_touching:
                append(roots, found, x)
        return
    zeros = 0
    lo = run[LO]
    f = f_lo
    for i in range(1, PROBES + 1):
        hi = run[HI]
        after = f_hi
        if i < PROBES:
            hi = run[LO] + (run[HI] - run[LO]) * (float(i) / float(PROBES))
            after = value(problem, ray, row, hi)
        is_zero = touches(problem, ray, row, hi, after)
        zeros += 1 if is_zero else 0
        rates_between(problem, ray, row, lo, f, hi, after, roots, found)
        lo = hi
        f = after
    if zeros == PROBES:
        found[VANISHES] = 1


#: Refinement by a condition and its derivative.
BY_RATES = Steps(BRACKET, rates_parted, rates_begin, rates_finish, rates_refine, rates_settle)
