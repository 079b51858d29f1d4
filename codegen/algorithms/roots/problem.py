"""Root finding on [0, 1]: what a problem is, its tolerances, and where roots are kept."""

from __future__ import annotations

from typing import Any, NamedTuple

from ...ir.loops.algorithm import Algorithm as algorithm
from ...ir.loops.algorithm import inlined
from ...ir.loops.language import Bool, InOut, IntVector, Real, Reals, Static, epsilon


class Steps(NamedTuple):
    """How roots are refined: from values of the condition (values.py), or from its derivative as well (rates.py)."""

    bracket: int  #: numbers of a bracket
    parted: Any
    begin: Any
    finish: Any
    refine: Any
    settle: Any


class Problem(NamedTuple):
    """A polynomial p, and a condition f that tells which of its roots are meant.

    p vanishes wherever f does, and at roots of other branches, where f does not: f is what stood there before a square
    root was squared away. Its algorithms take the problem, then two rows of numbers of a single problem, which are
    handed on to them.

    Attributes
    ----------
    label : str
        In generated code.
    degree : int
        Of p.
    steps : Steps
    surface : tuple
        What the algorithms are about.
    condition : algorithm
        f at a, with b = 1 - a, or any positive continuous multiple of it.
    rate : algorithm or None
        f and its derivative by a.
    bound : algorithm
        Sum of the absolute values of the terms of f at a: its rounding error is relative to it.
    noise : algorithm
        Sum of the absolute values of p's terms at a and b; it rises in both, and b need not be 1 - a.
    defers : bool
        Whether cases that are rare are left to another search, which looks at one item alone: text of several items at
        once has none of what they take.
    """

    label: str
    degree: int
    steps: Steps
    surface: Any
    condition: Any
    rate: Any
    bound: Any
    noise: Any
    defers: bool = False


#: In unit roundoffs: errors of p's coefficients relative to the caller's bound, some ten when they are made and as many
#: by halving; the rest, eight times MARGIN, is what p changes by outside its interval.
NOISE = 288.0
#: How far outside [0, 1] a root still counts, because it was rounded there.
MARGIN = 32.0
#: Error of f relative to its bound.
TOUCH = 16.0
#: Out of reach: bisection alone ends after 53.
STEPS = 128
#: Places where f is asked in a wide run.
PROBES = 32
#: Numbers of a piece or a run of pieces: its ends, f there, what its coefficients may be off by.
LO, HI, F_LO, F_HI, OFF = range(5)
PIECE = 5
#: Places of what a search tells: how many roots it found, whether f is zero to rounding in a wide run, and whether it
#: defers to another, so that nothing else of it counts.
COUNT, VANISHES, DEFERRED = range(3)
FOUND = 3

#: Between the unit roundoffs of float32 and of float64.
BETWEEN = 1e-10


@inlined
def by_precision(single: Real, double: Real) -> Real:
    """One of two numbers, by the precision of the target."""
    return single if epsilon() > BETWEEN else double


@inlined
def unit_roundoff() -> Real:
    """Half of the distance from 1 to the next number."""
    return 0.5 * epsilon()


@inlined
def near() -> Real:
    """Cube root of the unit roundoff: a third-order step from here is exact."""
    return by_precision(0.00390625, 4.76837158203125e-6)


@inlined
def widest_run() -> Real:
    """A run of noisy pieces up to this width is two or three roots that nearly meet; a wider one is probed."""
    return by_precision(0.015625, 0.000244140625)


@inlined
def root_of_unit() -> Real:
    """Square root of the unit roundoff."""
    return by_precision(2.44140625e-4, 1.0536712127723509e-8)


@inlined
def value(problem: Static, ray: Reals, row: Reals, a: Real) -> Real:
    """The condition at a place."""
    return problem.condition(problem, ray, row, a, 1.0 - a)


@inlined
def touches(problem: Static, ray: Reals, row: Reals, a: Real, f: Real) -> Bool:
    """Whether the condition at a place, of value f, is zero to rounding."""
    bound = problem.bound(problem, ray, row, a, 1.0 - a)
    is_zero: Bool = abs(f) <= TOUCH * unit_roundoff() * bound
    return is_zero


@inlined
def secant(lo: Real, f_lo: Real, hi: Real, f_hi: Real) -> Real:
    """Where the line through two points is zero."""
    return lo + (hi - lo) * (f_lo / (f_lo - f_hi))


@inlined
def append(roots: InOut[Reals], found: InOut[IntVector[FOUND]], root: Real) -> None:
    """Keep a root, if there is room."""
    if found[COUNT] < len(roots):
        roots[found[COUNT]] = 0.0 if root < 0.0 else 1.0 if root > 1.0 else root
        found[COUNT] += 1


@algorithm
def append_between(
    problem: Static, ray: Reals, row: Reals, lo: Real, f_lo: Real, hi: Real, f_hi: Real, guess: Real,
    roots: InOut[Reals], found: InOut[IntVector[FOUND]],
) -> None:  # fmt: skip
    """Keep the root between two places, if the condition has unlike signs there."""
    if (f_lo < 0.0) ^ (f_hi < 0.0):
        if lo < hi:
            root = problem.steps.refine(problem, ray, row, lo, f_lo, hi, f_hi, guess)
            append(roots, found, root)
        else:
            append(roots, found, lo)
