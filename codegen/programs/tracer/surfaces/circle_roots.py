"""Where a ray meets a surface evolved along a piece of a curve of circles: its parameters t in [0, 1].

A number is returned: that of roots, rising, at most as many as there is room for (the polynomial's degree always
suffices), or VANISHES: f is zero for all t, the ray meets every circle (it lies in the surface or in the circles'
common plane, or passes through a point shared by all circles); or INVALID: something is not finite.

Ends: 0 and 1 belong to the surface, with `MARGIN` roundings by which a root there may be off. Tangency: two roots are
two if f, where it is extreme between them, is more than its rounding error. If it is not, nobody knows whether the
ray hits twice, touches or just misses: one root is reported, at the extremum. A ray in the plane of one circle
touches in this sense: there the meet Y vanishes, and the ray may hit twice or not at all. Only where the row's spans
say that the interpolant is real anything is looked for.
"""

from __future__ import annotations

from functools import cache
from typing import Any, NamedTuple

from ....algorithms.roots.isolate import isolate
from ....algorithms.roots.pieces import cut_above, cut_below
from ....algorithms.roots.problem import (
    COUNT,
    FOUND,
    NOISE,
    Problem,
    touches,
    unit_roundoff,
    value,
)  # fmt: skip
from ....algorithms.roots.problem import DEFERRED as DEFERS
from ....algorithms.roots.problem import VANISHES as FLAT
from ....algorithms.roots.rates import BY_RATES
from ....ir.loops.algorithm import Algorithm as algorithm
from ....ir.loops.algorithm import inlined
from ....ir.loops.language import (
    InOut,
    Int,
    IntVector,
    Out,
    Real,
    Reals,
    Static,
    Vector,
    empty,
    int_zeros,
    largest,
)  # fmt: skip
from ..records import SPANS
from .rows import CircleRows
from .spans import DEFERRED, INVALID, VANISHES, add_end, has_root_at, is_real

#: Q of circles on a common sphere was made of up to that many roundings of the products of controls.
COSPHERICAL = 32.0


class CircleFinder(NamedTuple):
    """Roots of rays on one kind of surface along circles: for all circles, and for those of one sphere."""

    label: str
    rows: CircleRows
    problem: Problem
    shared: Problem


def condition(problem: Static, ray: Reals, row: Reals, t: Real, rest: Real) -> Real:
    """The square of the meet, but for a positive factor."""
    rows = problem.surface
    f = rows.condition(
        ray[: rows.meets.end], row[rows.norm.begin : rows.norm.end], row[rows.kappa.begin : rows.kappa.end], rest, t
    )
    return f


def condition_rate(problem: Static, ray: Reals, row: Reals, t: Real, rest: Real, f_rate: Out[Vector[2]]) -> None:
    """The same and its derivative."""
    rows = problem.surface
    f_rate[:] = rows.rate(
        ray[: rows.meets.end], row[rows.norm.begin : rows.norm.end], row[rows.kappa.begin : rows.kappa.end], rest, t
    )


@algorithm
def condition_bound(problem: Static, ray: Reals, row: Reals, t: Real, rest: Real) -> Real:
    """Sum of the absolute values of its terms."""
    rows = problem.surface
    bound = rows.condition_bound(
        ray[rows.origin.begin : rows.origin.end], ray[rows.direction.begin : rows.direction.end],
        ray[: rows.meets.end], row[rows.norm.begin : rows.norm.end], row[rows.kappa.begin : rows.kappa.end],
        rest, t, row[rows.controls.begin : rows.controls.end], row[rows.products.begin : rows.products.end],
    )  # fmt: skip
    return bound


@algorithm
def polynomial_bound(problem: Static, ray: Reals, row: Reals, t: Real, rest: Real) -> Real:
    """Sum of the absolute values of the polynomial's terms."""
    rows = problem.surface
    bound = rows.polynomial_bound(
        ray[: rows.meets.end], row[rows.norm.begin : rows.norm.end], row[rows.kappa.begin : rows.kappa.end], rest, t
    )
    return bound


# Circles of one sphere: Q = 0, both branches are one, and the polynomial vanishes. There it and the condition are u.


@algorithm
def shared_rate(problem: Static, ray: Reals, row: Reals, t: Real, rest: Real, f_rate: Out[Vector[2]]) -> None:
    """The condition of circles of one sphere, and its derivative."""
    rows = problem.surface
    f_rate[:] = rows.shared_condition(ray[: rows.meets.end], row[rows.norm.begin : rows.norm.end], rest, t)


@algorithm
def shared_condition(problem: Static, ray: Reals, row: Reals, t: Real, rest: Real) -> Real:
    """The condition of circles of one sphere."""
    f_rate = empty(2)
    shared_rate(problem, ray, row, t, rest, f_rate)
    return f_rate[0]


@algorithm
def shared_condition_bound(problem: Static, ray: Reals, row: Reals, t: Real, rest: Real) -> Real:
    """Sum of the absolute values of its terms."""
    rows = problem.surface
    bound = rows.shared_condition_bound(
        ray[rows.origin.begin : rows.origin.end], ray[rows.direction.begin : rows.direction.end],
        ray[: rows.meets.end], row[rows.norm.begin : rows.norm.end], rest, t,
        row[rows.controls.begin : rows.controls.end],
    )  # fmt: skip
    return bound


@algorithm
def shared_bound(problem: Static, ray: Reals, row: Reals, t: Real, rest: Real) -> Real:
    """Sum of the absolute values of the terms of u."""
    rows = problem.surface
    bound = rows.shared_bound(ray[rows.shared.begin : rows.shared.end], rest, t)
    return bound


@cache
def circle_finder(rows: CircleRows, roots: int, defers: bool = False) -> CircleFinder:
    """The finder of a kind of surface; ``roots``: the degree of its polynomial; ``defers``: see `Problem`."""
    name, degree = rows.label, rows.printed // 12
    declare: Any = inlined if degree == 1 else algorithm  # a short kernel is repeated where it is called
    problem = Problem(
        name, roots, BY_RATES, rows, declare(condition), declare(condition_rate), condition_bound, polynomial_bound,
        defers,
    )  # fmt: skip
    shared = Problem(
        f"{name}_shared", 2 * degree, BY_RATES, rows, shared_condition, shared_rate, shared_condition_bound,
        shared_bound, defers,
    )  # fmt: skip
    return CircleFinder(name, rows, problem, shared)


# -- every root, no false one ------------------------------------------------------------------------------------------


@algorithm
def add_touching_end(
    problem: Static, ray: Reals, row: Reals, end: Real, roots: InOut[Reals], found: InOut[IntVector[FOUND]]
) -> None:
    """Keep an end of the piece where there is a circle, no root next to it, and f is zero to rounding."""
    spans = row[problem.surface.spans.begin : problem.surface.spans.end]
    if not is_real(spans, end) or found[COUNT] == len(roots):
        return
    if not has_root_at(roots, found[COUNT], end):
        f = value(problem, ray, row, end)
        if touches(problem, ray, row, end, f):
            add_end(roots, found, end)


@algorithm
def isolated_shared(finder: Static, ray: InOut[Reals], row: Reals, roots: InOut[Reals]) -> Int:
    """Every root, no false one, of circles of one sphere."""
    rows = finder.rows
    problem = finder.shared
    degree = problem.degree
    part = empty(degree + 1)
    found = int_zeros(FOUND)
    ray[rows.shared.begin : rows.shared.end] = rows.shared_meets(
        ray[: rows.meets.end], row[rows.norm.begin : rows.norm.end]
    )
    c = rows.shared_polynomial(ray[rows.shared.begin : rows.shared.end])
    total = 0.0
    size = 0.0
    for i in range(degree + 1):
        total += c[i]
        size = max(size, abs(c[i]))
    noise = NOISE * unit_roundoff() * size
    if total - total != 0.0:
        return INVALID
    for i in range(SPANS):
        lo = row[rows.spans.begin + 2 * i]
        hi = row[rows.spans.begin + 2 * i + 1]
        if not lo < hi:
            continue
        part[:] = c
        cut_above(degree, part, hi)
        cut_below(degree, part, lo / hi)
        isolate(problem, ray, row, part, noise, lo, hi, roots, found)
    if problem.defers:
        is_at_end = abs(c[0]) <= noise or abs(c[degree]) <= noise
        return DEFERRED if is_at_end or found[DEFERS] != 0 else found[COUNT]
    if found[FLAT] != 0:
        return VANISHES
    for end in (0, 1):
        if abs(c[degree * end]) <= noise:
            add_touching_end(problem, ray, row, float(end), roots, found)
    count: Int = found[COUNT]
    return count


@inlined
def isolated(finder: Static, ray: InOut[Reals], row: Reals, reach: Real, roots: InOut[Reals]) -> Int:
    """Every root, no false one. ``reach``: (1 + x^2)^2 of the ray's origin x, which p's terms may grow by."""
    rows = finder.rows
    problem = finder.problem
    degree = problem.degree
    noise = NOISE * unit_roundoff() * reach * row[rows.sizes.begin + 1]
    if row[rows.sizes.begin] <= COSPHERICAL * unit_roundoff():
        return isolated_shared(finder, ray, row, roots)  # type: ignore[no-any-return]
    c = rows.polynomial(
        ray[: rows.meets.end], row[rows.norm.begin : rows.norm.end], row[rows.kappa.begin : rows.kappa.end]
    )
    total = 0.0
    least = largest()
    most = -largest()
    for i in range(degree + 1):
        total += c[i]
        least = min(least, c[i])
        most = max(most, c[i])
    if total - total != 0.0:
        return INVALID
    if least > noise or most < -noise:
        return 0
    part = empty(degree + 1)
    found = int_zeros(FOUND)
    for i in range(SPANS):
        lo = row[rows.spans.begin + 2 * i]
        hi = row[rows.spans.begin + 2 * i + 1]
        if not lo < hi:
            continue
        part[:] = c
        if hi < 1.0:
            cut_above(degree, part, hi)
        if lo > 0.0:
            cut_below(degree, part, lo / hi)
        isolate(problem, ray, row, part, noise, lo, hi, roots, found)
    if problem.defers:
        is_at_end = abs(c[0]) <= noise or abs(c[degree]) <= noise
        return DEFERRED if is_at_end or found[DEFERS] != 0 else found[COUNT]
    if found[FLAT] != 0:
        return VANISHES
    for end in (0, 1):
        if abs(c[degree * end]) <= noise:
            add_touching_end(problem, ray, row, float(end), roots, found)
    count: Int = found[COUNT]
    return count
