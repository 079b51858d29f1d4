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
    any_item,
    empty,
    epsilon,
    int_empty,
)  # fmt: skip
from .pieces import crossing, cut_above, cut_below, halve, recount, variations
from .problem import (
    BETWEEN,
    DEFERRED,
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
#: In place of a number of roots, of several items at once: others have this piece, and this one has not.
ELSEWHERE = -3


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
def settle(
    problem: Static, ray: Reals, row: Reals, run: Vector[PIECE], c: Reals, begin: Real, end: Real,
    roots: InOut[Reals], found: InOut[IntVector[FOUND]],
) -> None:  # fmt: skip
    """Keep the roots of f in a run of noisy pieces, or leave the whole to another search."""
    if problem.defers:
        found[DEFERRED] = 1
    else:
        problem.steps.settle(problem, ray, row, run, c, begin, end, roots, found)


@inlined
def isolate(
    problem: Static, ray: Reals, row: Reals, coefficients: Reals, noise: Real, begin: Real, end: Real,
    roots: InOut[Reals], found: InOut[IntVector[FOUND]],
) -> None:  # fmt: skip
    """Append the roots of f in [begin, end], rising.

    Several items at once halve the same pieces, and one that has done with a piece waits for the others: so all share
    the place where pieces wait, and rows of coefficients are vectors.

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
    whole = empty(degree + 1)
    piece = empty(PIECE)
    for i in range(degree + 1):
        whole[i] = coefficients[i]
    piece[LO] = begin
    piece[HI] = end
    piece[OFF] = noise
    f_begin = value(problem, ray, row, begin if begin > 0.0 else -margin)
    f_end = value(problem, ray, row, end if end < 1.0 else 1.0 + margin)
    piece[F_LO] = f_begin
    piece[F_HI] = f_end
    count, is_unsure = recount(degree, whole, noise)
    is_trimmed = False
    if problem.defers:
        if is_unsure:
            found[DEFERRED] = 1
            count = ELSEWHERE
    elif is_unsure:
        is_trimmed = trim(problem, ray, row, whole, piece, last, roots, found)
        count, is_unsure = recount(degree, whole, noise)
    c[0] = whole
    pieces[0] = piece
    counts[0, DEPTH] = 0
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
        off = pieces[height, OFF]
        if counts[height, UNSURE] != 0 and (count == -2 or count > most):
            if problem.defers:
                found[DEFERRED] = 1
                count = ELSEWHERE
            else:
                terms = problem.noise(problem, ray, row, hi, 1.0 - lo)
                off = min(off, NOISE * unit_roundoff() * terms)
                count, is_unsure = recount(degree, c[height], off)
        is_crowded = count > most
        is_noisy = count == -2 or (is_crowded and counts[height, DEPTH] == deepest)
        is_halved = is_crowded and not is_noisy
        if count != ELSEWHERE and not is_halved:
            if is_running and not is_noisy:
                settle(problem, ray, row, run, coefficients, begin, end, roots, found)
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
                if pending == 0:
                    problem.steps.begin(lo, f_lo, hi, f_hi, guess, brackets[0])
                else:
                    problem.steps.begin(lo, f_lo, hi, f_hi, guess, brackets[1])
                pending += 1
        if any_item(pending == 2 or (pending > 0 and is_running)):
            problem.steps.finish(problem, ray, row, brackets, pending, roots, found)
            pending = 0
        if any_item(is_halved):
            halve(degree, c[upper], c[height], c[height])
            middle = 0.5 * (lo + hi)
            depth = counts[height, DEPTH] + 1
            lower_count, is_lower_unsure = variations(degree, c[upper], off)
            upper_count, is_upper_unsure = variations(degree, c[height], off)
            is_below = is_halved and (is_running or lower_count != -1)
            f = problem.steps.parted(
                problem, ray, row, middle, f_lo, lower_count if is_halved else -1, f_hi, upper_count
            )  # fmt: skip
            pieces[upper, LO] = lo
            pieces[upper, HI] = middle
            pieces[upper, F_LO] = f_lo
            pieces[upper, F_HI] = f
            pieces[upper, OFF] = off
            pieces[height, LO] = middle
            pieces[height, F_LO] = f
            counts[upper, DEPTH] = depth
            counts[height, DEPTH] = depth
            counts[upper, ROOTS] = lower_count if is_below else ELSEWHERE
            counts[height, ROOTS] = upper_count if is_halved else ELSEWHERE
            counts[upper, UNSURE] = 1 if is_below and is_lower_unsure else 0
            counts[height, UNSURE] = 1 if is_halved and is_upper_unsure else 0
            height += 1 if any_item(is_below) else 0
        else:
            height -= 1
    if pending > 0:
        problem.steps.finish(problem, ray, row, brackets, pending, roots, found)
    if is_running:
        settle(problem, ray, row, run, coefficients, begin, end, roots, found)
    if problem.defers:
        return
    if is_trimmed:
        append_between(problem, ray, row, last[0], last[1], last[2], last[3], 0.5 * (last[0] + last[2]), roots, found)
