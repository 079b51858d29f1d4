"""Where a ray meets the carriers of a ribbon's point pairs: t in [0, 1], 0 at the first pair.

A number is returned: that of roots, rising, at most as many as there is room for, or VANISHES: f is zero for all t,
the ray lies in the plane of a flat ribbon, or in the surface; or INVALID: something is not finite. Ends and tangency
are as of circles (circle_roots.py): two roots are one where f between them is less than its rounding, for surfaces
and rays of about unit size nearer than 5e-8 (1e-3 in single precision).
"""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

from ....algorithms.roots.isolate import isolate
from ....algorithms.roots.pieces import cut_above, cut_below
from ....algorithms.roots.problem import COUNT, FOUND, MARGIN, NOISE, Problem, unit_roundoff
from ....algorithms.roots.problem import DEFERRED as DEFERS
from ....algorithms.roots.problem import VANISHES as FLAT
from ....algorithms.roots.values import BY_VALUES
from ....ir.loops.algorithm import Algorithm as algorithm
from ....ir.loops.algorithm import inlined
from ....ir.loops.language import (
    Bool,
    InOut,
    Int,
    Real,
    Reals,
    Static,
    Vector,
    empty,
    int_zeros,
    unrolled,
)  # fmt: skip
from ..records import SPANS
from .rows import PairRows
from .spans import DEFERRED, INVALID, VANISHES, is_real

#: Of what rounding may leave of a meet at the most, the fraction that is taken for likely where f touches zero, over
#: `TOUCH`.
LIKELY = 1.0 / 128.0


class PairFinder(NamedTuple):
    """Roots of rays on one kind of surface along point pairs."""

    label: str
    rows: PairRows
    problem: Problem


@inlined
def pair_condition(problem: Static, ray: Reals, row: Reals, t: Real, rest: Real) -> Real:
    """f = m B - w E."""
    rows = problem.surface
    f = rows.condition(
        ray[: rows.meets.end], row[rows.norm.begin : rows.norm.end], row[rows.kappa.begin : rows.kappa.end], rest, t
    )
    return f


@inlined
def pair_condition_bound(problem: Static, ray: Reals, row: Reals, t: Real, rest: Real) -> Real:
    """What the error of f is relative to."""
    rows = problem.surface
    bound = rows.condition_bound(
        ray[rows.written.begin : rows.written.end], row[rows.norm.begin : rows.norm.end],
        row[rows.kappa.begin : rows.kappa.end], rest, t,
    )  # fmt: skip
    return bound


@inlined
def pair_polynomial_bound(problem: Static, ray: Reals, row: Reals, t: Real, rest: Real) -> Real:
    """Sum of the absolute values of the polynomial's terms."""
    rows = problem.surface
    bound = rows.polynomial_bound(
        ray[rows.other.begin : rows.other.end], row[rows.norm.begin : rows.norm.end],
        ray[rows.other_kappa.begin : rows.other_kappa.end], rest, t,
    )  # fmt: skip
    return bound


@cache
def pair_finder(rows: PairRows, roots: int, defers: bool = False) -> PairFinder:
    """The finder of a kind of surface; ``roots``: the degree of its polynomial; ``defers``: see `Problem`."""
    problem = Problem(
        rows.label, roots, BY_VALUES, rows, pair_condition, None, pair_condition_bound, pair_polynomial_bound,
        defers,
    )  # fmt: skip
    return PairFinder(rows.label, rows, problem)


@inlined
def bernstein_size(count: Static, scaled: Reals) -> Real:
    """Largest absolute Bernstein coefficient of a polynomial given with binomials inside."""
    most = 0.0
    binomial = 1.0
    for i in unrolled(count):
        most = max(most, abs(scaled[i]) * (1.0 / binomial))
        binomial = binomial * float(count - 1 - i) / float(i + 1)
    return most


@inlined
def pair_sizes(finder: Static, row: InOut[Reals]) -> None:
    """Sizes of S0 and K, in a surface's row of constants."""
    rows = finder.rows
    for at, part in ((rows.sizes.begin, rows.norm), (rows.sizes.begin + 1, rows.kappa)):
        row[at] = bernstein_size(part.end - part.begin, row[part.begin : part.end])


@inlined
def unless_noise(count: Static, scaled: InOut[Reals], noise: Real) -> Real:
    """Replace a polynomial by zeros if rounding is all there is of it; its size, or NaN if it is not finite."""
    size = bernstein_size(count, scaled)
    if size > noise:
        return size
    total = 0.0
    for i in range(count):
        total += scaled[i]
        scaled[i] = 0.0
    return total - total


@inlined
def closed(finder: Static, ray: Reals, row: Reals, roots: InOut[Reals]) -> Int:
    """Two pairs on one circle: the carrier's meet is linear in t."""
    rows = finder.rows
    t = rows.closed_alpha(ray[: rows.meets.end])
    margin = MARGIN * unit_roundoff()
    roots[0] = 0.0 if t < 0.0 else 1.0 if t > 1.0 else t
    is_there = is_real(row[rows.spans.begin : rows.spans.end], roots[0])
    return 1 if t >= -margin and t <= 1.0 + margin and is_there else 0


@algorithm
def without_products(rows: Static, ray: InOut[Reals], size: Real) -> None:
    """Coefficients of p with a small constant in place of E and nothing in place of K: those of S0 B.

    For rays and surfaces whose E vanishes, with which p would.
    """
    binomial = 1.0
    degree = rows.meets.end - rows.pairs - 1
    for i in range(rows.pairs):
        ray[rows.other.begin + i] = ray[i]
    for k in range(degree + 1):
        ray[rows.other.begin + rows.pairs + k] = unit_roundoff() * size * binomial
        binomial = binomial * float(degree - k) / float(k + 1)
    for k in range(rows.other_kappa.begin, rows.other_kappa.end):
        ray[k] = 0.0


@inlined
def use_all(rows: Static, ray: InOut[Reals], row: Reals) -> None:
    """Coefficients of p, where E does not vanish: those of f."""
    for i in range(rows.meets.end):
        ray[rows.other.begin + i] = ray[i]
    for i in range(rows.kappa.end - rows.kappa.begin):
        ray[rows.other_kappa.begin + i] = row[rows.kappa.begin + i]


@inlined
def ends_at_zero(finder: Static, ray: Reals, row: Reals, noise: Vector[2], end: Int) -> Bool:
    """Whether f is zero to rounding at an end of the curve, where it need not change its sign.

    So it is for rays along the first or the last carrier. ``noise``: what rounding may leave of B and of E.
    """
    rows = finder.rows
    if not rows.is_free:  # f is m B there
        is_on_end: Bool = abs(ray[rows.pairs - 1 if end > 0 else 0]) <= noise[0]
        return is_on_end
    f = pair_condition(finder.problem, ray, row, float(end), 1.0 - float(end))
    m = 2.0 * row[rows.norm.end - 1 if end > 0 else rows.norm.begin]
    is_on_carrier: Bool = abs(f) <= abs(m) * noise[0] + noise[1]
    return is_on_carrier


@inlined
def pair_isolated(finder: Static, ray: InOut[Reals], row: Reals, noise: Vector[2], roots: InOut[Reals]) -> Int:
    """Every root, no false one. ``noise``: what rounding may leave of B and of E."""
    rows = finder.rows
    problem = finder.problem
    degree = problem.degree
    size_b = unless_noise(rows.pairs, ray[: rows.pairs], noise[0])
    size_e = unless_noise(
        rows.meets.end - rows.pairs, ray[rows.pairs : rows.meets.end], 0.0 if size_b > 0.0 else noise[1]
    )
    size_k = row[rows.sizes.begin + 1]
    if size_b - size_b != 0.0 or size_e - size_e != 0.0:
        return INVALID
    if problem.defers:
        if size_e == 0.0:
            return DEFERRED
        use_all(rows, ray, row)
    elif size_e == 0.0:
        if size_b == 0.0:
            return VANISHES
        if rows.closed_alpha is not None and size_k == 0.0:
            return closed(finder, ray, row, roots)  # type: ignore[no-any-return]
        without_products(rows, ray, size_b)
        size_e = unit_roundoff() * size_b
        size_k = 0.0
    else:
        use_all(rows, ray, row)
    c = rows.polynomial(
        ray[rows.other.begin : rows.other.end], row[rows.norm.begin : rows.norm.end],
        ray[rows.other_kappa.begin : rows.other_kappa.end],
    )  # fmt: skip
    terms = rows.weight * (size_e * size_e + size_k * size_b * size_b)
    terms = terms + 2.0 * row[rows.sizes.begin] * size_b * size_e
    off = NOISE * unit_roundoff() * terms
    total = 0.0
    plus = 0
    minus = 0
    for i in range(degree + 1):
        total += c[i]
        plus += 1 if c[i] > off else 0
        minus += 1 if c[i] < -off else 0
    if plus == degree + 1 or minus == degree + 1:
        return 0
    if total - total != 0.0:
        return INVALID
    for i in range(rows.meets.end):
        added = LIKELY / unit_roundoff() * (noise[1] if i >= rows.pairs else noise[0])
        ray[rows.written.begin + i] = abs(ray[i]) + added
    part = empty(degree + 1)
    found = int_zeros(FOUND)
    for i in range(SPANS):
        lo = row[rows.spans.begin + 2 * i]
        hi = row[rows.spans.begin + 2 * i + 1]
        if not lo <= hi:
            continue
        part[:] = c
        if lo > 0.0:
            cut_below(degree, part, lo)
        if hi < 1.0:
            cut_above(degree, part, (hi - lo) / (1.0 - lo))
        isolate(problem, ray, row, part, off, lo, hi, roots, found)
    if problem.defers:
        return DEFERRED if found[DEFERS] != 0 else found[COUNT]
    count = VANISHES if found[FLAT] != 0 else found[COUNT]
    return count
