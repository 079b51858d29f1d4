"""Refinement of roots from values of the condition alone, and what becomes of noisy runs."""

from __future__ import annotations

from ...ir.loops.algorithm import Algorithm as algorithm
from ...ir.loops.algorithm import inlined
from ...ir.loops.language import Bool, InOut, Int, IntVector, Matrix, Out, Real, Reals, Static, Vector
from .pieces import slope
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
    near,
    secant,
    touches,
    unit_roundoff,
    value,
    widest_run,
)  # fmt: skip

GOLDEN = 0.3819660112501051
#: A root between LO and HI that waits for its turn: F_LO and F_HI as of a piece, and a first guess.
GUESS = 4
BRACKET = 5


@inlined
def values_parted(
    problem: Static, ray: Reals, row: Reals, at: Real, f_lo: Real, roots_left: Int, f_hi: Real, roots_right: Int
) -> Real:
    """f where a piece was parted."""
    return value(problem, ray, row, at)


@inlined
def values_refine(
    problem: Static, ray: Reals, row: Reals, lo: Real, f_lo: Real, hi: Real, f_hi: Real, guess: Real
) -> Real:
    """The root between lo and hi, where f has unlike signs, and where to begin.

    a is the last point, b the nearest one with f of the other sign, c the one before. Inverse quadratic interpolation
    where the three are fit for it (Chandrupatla's test), else bisection; one division. The secant through a and c tells
    the interpolation's error: when that is a rounding, and not by chance far from the root, the next value of f could
    not add anything.
    """
    tolerance = 2.0 * unit_roundoff()
    close = near()
    scale = 1.0 / (f_hi - f_lo)
    a = hi
    fa = f_hi * scale
    b = lo
    fb = f_lo * scale
    move = guess - a
    for _ in range(STEPS):
        x = a + move
        f = value(problem, ray, row, x)
        fx = scale * f
        c = a
        fc = fa
        if (fx < 0.0) ^ (fa < 0.0):
            c = b
            fc = fb
            b = a
            fb = fa
        a = x
        fa = fx
        ab = b - a
        ac = c - a
        fab = fb - fa
        fac = fc - fa
        fbc = fc - fb
        w = abs(ab - ac)
        if fa == 0.0 or abs(ab) <= tolerance:
            break
        move = 0.5 * ab
        if fab * fab * w < abs(ab) * (fbc * fbc) and fac * fac * w < abs(ac) * (fbc * fbc):
            weight = fa / (fab * fac * fbc)
            line = ac * fab * fbc
            inverse = fc * ab * fac - fb * ac * fab
            move = -weight * inverse
            if abs(weight * (line - inverse)) <= tolerance and abs(move) <= close:
                return a + move
    return a


@inlined
def values_begin(lo: Real, f_lo: Real, hi: Real, f_hi: Real, guess: Real, b: Out[Vector[BRACKET]]) -> None:
    """A root that waits for its turn."""
    b[LO] = lo
    b[HI] = hi
    b[F_LO] = f_lo
    b[F_HI] = f_hi
    b[GUESS] = guess


@inlined
def values_finish(
    problem: Static, ray: Reals, row: Reals, brackets: Matrix, count: Int, roots: InOut[Reals],
    found: InOut[IntVector[FOUND]],
) -> None:  # fmt: skip
    """Keep the roots of some brackets."""
    for i in range(count):
        b = brackets[i]
        root = values_refine(problem, ray, row, b[LO], b[F_LO], b[HI], b[F_HI], b[GUESS])
        append(roots, found, root)


@inlined
def dips(before: Real, middle: Real, after: Real) -> Bool:
    """Whether the middle one of three values is nearest to zero."""
    is_nearest: Bool = abs(middle) <= abs(before) and abs(middle) <= abs(after)
    return is_nearest


@algorithm
def append_refined(
    problem: Static, ray: Reals, row: Reals, lo: Real, f_lo: Real, hi: Real, f_hi: Real, roots: InOut[Reals],
    found: InOut[IntVector[FOUND]],
) -> None:  # fmt: skip
    """Keep the root between two places where f has unlike signs, begun with the secant."""
    root = values_refine(problem, ray, row, lo, f_lo, hi, f_hi, secant(lo, f_lo, hi, f_hi))
    append(roots, found, root)


@algorithm
def values_dip(
    problem: Static, ray: Reals, row: Reals, lo: Real, f_lo: Real, middle: Real, f_middle: Real, hi: Real, f_hi: Real,
    roots: InOut[Reals], found: InOut[IntVector[FOUND]],
) -> None:  # fmt: skip
    """Keep the roots between two places where f has like signs; it is nearest to zero at a known place between.

    One root if it touches there, two if it crosses. Golden section search.
    """
    a = lo
    fa = f_lo
    b = hi
    fb = f_hi
    x = middle
    fx = f_middle
    for _ in range(STEPS):
        if (fx < 0.0) ^ (fa < 0.0):
            break
        is_left = x - a > b - x
        y = x + GOLDEN * (a - x if is_left else b - x)
        fy = value(problem, ray, row, y)
        is_nearer = (fy < 0.0) ^ (fa < 0.0) or abs(fy) < abs(fx)
        if is_left ^ is_nearer:
            a = x if not is_left else y
            fa = fx if not is_left else fy
        else:
            b = x if is_left else y
            fb = fx if is_left else fy
        x = y if is_nearer else x
        fx = fy if is_nearer else fx
        if b - a <= near() * near():
            break
    is_touching = touches(problem, ray, row, x, fx)
    if is_touching:
        append(roots, found, x)
    elif (fx < 0.0) ^ (fa < 0.0):
        append_refined(problem, ray, row, a, fa, x, fx, roots, found)
        append_refined(problem, ray, row, x, fx, b, fb, roots, found)


@algorithm
def probe(
    problem: Static, ray: Reals, row: Reals, run: Vector[PIECE], roots: InOut[Reals], found: InOut[IntVector[FOUND]]
) -> None:
    """Keep the roots of f in a wide run, where p does not help: from the sign changes and the dips between probes."""
    x0 = run[LO]
    x1 = run[LO]
    x2 = run[LO]
    f0 = run[F_LO]
    f1 = run[F_LO]
    f2 = run[F_LO]
    zeros = 0
    for i in range(1, PROBES + 1):
        x0 = x1
        x1 = x2
        f0 = f1
        f1 = f2
        x2 = run[HI]
        f2 = run[F_HI]
        if i < PROBES:
            x2 = run[LO] + (run[HI] - run[LO]) * (float(i) / float(PROBES))
            f2 = value(problem, ray, row, x2)
        is_zero = touches(problem, ray, row, x2, f2)
        zeros += 1 if is_zero else 0
        if (f1 < 0.0) ^ (f2 < 0.0):
            append_refined(problem, ray, row, x1, f1, x2, f2, roots, found)
        elif i > 1 and not (f0 < 0.0) ^ (f1 < 0.0):  # noqa: SIM102 - calls are not parts of conditions
            if dips(f0, f1, f2):
                values_dip(problem, ray, row, x0, f0, x1, f1, x2, f2, roots, found)
    if zeros == PROBES:
        found[VANISHES] = 1


@algorithm
def values_settle(
    problem: Static, ray: Reals, row: Reals, run: Vector[PIECE], c: Reals, begin: Real, end: Real,
    roots: InOut[Reals], found: InOut[IntVector[FOUND]],
) -> None:  # fmt: skip
    """Keep the roots of f in a run of noisy pieces, where some roots of p nearly meet; c: its coefficients in all.

    With unlike signs of f one root is true. With like signs two are or none is, and f at the extremum of p between them
    tells. The extremum is a simple root of p' and known to full accuracy where p's own roots are not.
    """
    width = end - begin
    lo = (run[LO] - begin) / width
    hi = (run[HI] - begin) / width
    if run[HI] - run[LO] > widest_run():
        probe(problem, ray, row, run, roots, found)
        return
    if (run[F_LO] < 0.0) ^ (run[F_HI] < 0.0):
        append_refined(problem, ray, row, run[LO], run[F_LO], run[HI], run[F_HI], roots, found)
        return
    g_lo = slope(problem.degree, c, lo)
    g_hi = slope(problem.degree, c, hi)
    x = run[LO] if abs(run[F_LO]) < abs(run[F_HI]) else run[HI]
    if (g_lo < 0.0) ^ (g_hi < 0.0):
        x = begin + width * (lo + (hi - lo) * (g_lo / (g_lo - g_hi)))
    fx = value(problem, ray, row, x)
    is_crossing = (fx < 0.0) ^ (run[F_LO] < 0.0)
    is_dip = dips(run[F_LO], fx, run[F_HI])
    is_touching = touches(problem, ray, row, x, fx)
    if is_touching:
        append(roots, found, x)
    elif is_crossing or (x > run[LO] and x < run[HI] and is_dip):
        values_dip(problem, ray, row, run[LO], run[F_LO], x, fx, run[HI], run[F_HI], roots, found)


#: Refinement by values of the condition.
BY_VALUES = Steps(BRACKET, values_parted, values_begin, values_finish, values_refine, values_settle)
