"""Roots on [0, 1] of one branch of a polynomial.

Descartes' rule on Bernstein coefficients isolates, the condition tells true from false and refines. A piece of [0, 1]
is dropped when p has one certain sign on it, or at most one root and f no sign change. It holds one root when f
changes sign and p has at most two roots. Otherwise it is halved. So no tolerance tells true from false. One is needed
where p drowns in its own rounding errors, because roots of p lie closer together than about the square root of the
unit roundoff: there f is asked at its extremum (`settle`), and where it is zero to rounding, a touching root is
reported once. And where [begin, end] begins or ends at a root: there the sign of f is chance, and so the end is moved
inwards to where it is certain (`trim`).
"""

from __future__ import annotations

from ...ir.loops.algorithm import Algorithm as algorithm
from ...ir.loops.algorithm import inlined
from ...ir.loops.language import (
    Bool,
    InOut,
    IntVector,
    Out,
    Real,
    Reals,
    Static,
    Vector,
    empty,
    epsilon,
    int_empty,
)  # fmt: skip
from .pieces import crossing, cut_above, cut_below, halve, recount, variations
from .problem import (
    BETWEEN,
    F_HI,
    F_LO,
    FOUND,
    HI,
    LO,
    MARGIN,
    NOISE,
    OFF,
    PIECE,
    append_between,
    touches,
    unit_roundoff,
    value,
)  # fmt: skip

#: Pieces that wait, and what is counted of each: its halvings, its roots at most, whether coefficients are unsure.
STACK = 28
DEPTH, ROOTS, UNSURE = range(3)


@algorithm
def certain(
    problem: Static, ray: Reals, row: Reals, begin: Real, inwards: Real
) -> tuple[Bool, Real, Real]:  # fmt: skip
    """From an end of a piece inwards, by at most a quarter of it: where f is more than its rounding error, and f there.

    False if there is no such place.
    """
    most = 0.25 * abs(inwards)
    first = MARGIN * unit_roundoff()
    step = 0.0
    x = begin
    f = 0.0
    while step <= most:
        x = begin - step if inwards < 0.0 else begin + step
        f = value(problem, ray, row, x)
        is_zero = touches(problem, ray, row, x, f)
        if not is_zero:
            return True, x, f
        step = first if step == 0.0 else 2.0 * step
    return False, x, f


@algorithm
def trim(
    problem: Static, ray: Reals, row: Reals, c: InOut[Reals], piece: InOut[Vector[PIECE]], last: Out[Vector[4]],
    roots: InOut[Reals], found: InOut[IntVector[FOUND]],
) -> Bool:  # fmt: skip
    """Let a piece begin and end where f is certain; whether something is left above: its places and f in ``last``.

    f at an end of [0, 1] or of a piece where p is zero to rounding may be nothing else, and its sign chance: what p
    tells of roots and f of signs would not belong together. What lies beside the piece, one root or none, is kept:
    below at once, above by ``last``.
    """
    width = piece[HI] - piece[LO]
    if abs(c[0]) <= piece[OFF]:
        is_certain, x, f = certain(problem, ray, row, piece[LO], width)
        if is_certain:
            append_between(problem, ray, row, piece[LO], piece[F_LO], x, f, 0.5 * (piece[LO] + x), roots, found)
            cut_below(problem.degree, c, (x - piece[LO]) / width)
            piece[LO] = x
            piece[F_LO] = f
    if not abs(c[problem.degree]) <= piece[OFF]:
        return False
    is_certain, x, f = certain(problem, ray, row, piece[HI], -width)
    if not is_certain:
        return False
    last[0] = x
    last[1] = f
    last[2] = piece[HI]
    last[3] = piece[F_HI]
    cut_above(problem.degree, c, (x - piece[LO]) / (piece[HI] - piece[LO]))
    piece[HI] = x
    piece[F_HI] = f
    return True


@inlined
def isolate(
    problem: Static, ray: Reals, row: Reals, coefficients: Reals, noise: Real, begin: Real, end: Real,
    roots: InOut[Reals], found: InOut[IntVector[FOUND]],
) -> None:  # fmt: skip
    """Append the roots of f in [begin, end], rising.

    ``coefficients``: p's Bernstein coefficients there, with errors up to ``noise``.
    """
    degree = problem.degree
    deepest = 13 if epsilon() > BETWEEN else 27  # halvings until a piece is as short as a root of the roundoff
    margin = MARGIN * unit_roundoff()
    c = empty(STACK, degree + 1)
    pieces = empty(STACK, PIECE)
    counts = int_empty(STACK, 3)
    run = empty(PIECE)
    brackets = empty(2, problem.steps.bracket)
    last = empty(4)
    height = 0
    pending = 0
    is_running = False
    for i in range(degree + 1):
        c[0, i] = coefficients[i]
    pieces[0, LO] = begin
    pieces[0, HI] = end
    pieces[0, OFF] = noise
    counts[0, DEPTH] = 0
    f_begin = value(problem, ray, row, begin if begin > 0.0 else -margin)
    f_end = value(problem, ray, row, end if end < 1.0 else 1.0 + margin)
    pieces[0, F_LO] = f_begin
    pieces[0, F_HI] = f_end
    count, is_unsure = recount(degree, c[0], noise)
    is_trimmed = False
    if is_unsure:
        is_trimmed = trim(problem, ray, row, c[0], pieces[0], last, roots, found)
        count, is_unsure = recount(degree, c[0], noise)
    counts[0, ROOTS] = count
    counts[0, UNSURE] = 1 if is_unsure else 0
    while height >= 0:
        upper = height + 1
        lo = pieces[height, LO]
        hi = pieces[height, HI]
        f_lo = pieces[height, F_LO]
        f_hi = pieces[height, F_HI]
        is_unlike = (f_lo < 0.0) ^ (f_hi < 0.0)
        most = 2 if is_unlike else 1
        count = counts[height, ROOTS]
        if counts[height, UNSURE] != 0 and (count == -2 or count > most):
            terms = problem.noise(problem, ray, row, hi, 1.0 - lo)
            pieces[height, OFF] = min(pieces[height, OFF], NOISE * unit_roundoff() * terms)
            count, is_unsure = recount(degree, c[height], pieces[height, OFF])
        is_crowded = count > most
        is_noisy = count == -2 or (is_crowded and counts[height, DEPTH] == deepest)
        if is_crowded and not is_noisy:
            halve(degree, c[upper], c[height], c[height])
            middle = 0.5 * (lo + hi)
            pieces[upper, LO] = lo
            pieces[upper, F_LO] = f_lo
            pieces[upper, HI] = middle
            pieces[height, LO] = middle
            off = pieces[height, OFF]
            pieces[upper, OFF] = off
            counts[height, DEPTH] += 1
            counts[upper, DEPTH] = counts[height, DEPTH]
            lower_count, is_lower_unsure = variations(degree, c[upper], off)
            upper_count, is_upper_unsure = variations(degree, c[height], off)
            counts[upper, ROOTS] = lower_count
            counts[upper, UNSURE] = 1 if is_lower_unsure else 0
            counts[height, ROOTS] = upper_count
            counts[height, UNSURE] = 1 if is_upper_unsure else 0
            f = problem.steps.parted(problem, ray, row, middle, f_lo, lower_count, f_hi, upper_count)
            pieces[upper, F_HI] = f
            pieces[height, F_LO] = f
            height += 1 if is_running or lower_count != -1 else 0
            continue
        if is_running and not is_noisy:
            problem.steps.settle(problem, ray, row, run, coefficients, begin, end, roots, found)
            is_running = False
        if is_noisy:
            if not is_running:
                run[LO] = lo
                run[F_LO] = f_lo
            run[HI] = hi
            run[F_HI] = f_hi
            is_running = True
        elif count >= 0 and is_unlike:
            guess = lo + (hi - lo) * crossing(degree, c[height])
            problem.steps.begin(lo, f_lo, hi, f_hi, guess, brackets[pending])
            pending += 1
        if pending == 2 or (pending > 0 and (is_running or height == 0)):
            problem.steps.finish(problem, ray, row, brackets, pending, roots, found)
            pending = 0
        height -= 1
    if is_running:
        problem.steps.settle(problem, ray, row, run, coefficients, begin, end, roots, found)
    if is_trimmed:
        append_between(problem, ray, row, last[0], last[1], last[2], last[3], 0.5 * (last[0] + last[2]), roots, found)
