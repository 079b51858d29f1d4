"""Roots of rays on surfaces along curves by the printed methods: the companion matrix, and sign changes of samples.

For comparison: they lose roots and find false ones.
"""

from __future__ import annotations

from ....algorithms.roots.companion import polynomial_roots
from ....ir.loops.algorithm import Algorithm as algorithm
from ....ir.loops.algorithm import inlined
from ....ir.loops.language import InOut, Int, Real, Reals, Static, empty, sqrt
from .spans import is_real

#: The printed threshold on |f|.
FILTER = 1e-6


@inlined
def meet(rows: Static, ray: Reals, row: Reals, t: Real) -> Real:
    """f of the unit object, for a unit ray."""
    f = rows.meet(
        ray[: rows.meets.end], row[rows.norm.begin : rows.norm.end], row[rows.kappa.begin : rows.kappa.end],
        1.0 - t, t,
    )  # fmt: skip
    return f


@inlined
def insert(roots: InOut[Reals], count: Int, t: Real) -> None:
    """Put a root among some, which rise."""
    at = count
    while at > 0:
        if not roots[at - 1] > t:
            break
        roots[at] = roots[at - 1]
        at -= 1
    roots[at] = t


@inlined
def quadratic(f0: Real, f1: Real, f2: Real, first: Int) -> Real:
    """Root between ``first`` and the next integer, where values have unlike signs, of the quadratic through 0, 1 and 2.

    That of the secant where the quadratic is not finite.
    """
    c2 = 0.5 * (f0 + f2) - f1
    c1 = f1 - f0 - c2
    square = c1 * c1 - 4.0 * c2 * f0
    root = sqrt(square if square > 0.0 else 0.0)
    q = -0.5 * (c1 - root if c1 < 0.0 else c1 + root)
    low = f0 / q
    high = q / c2
    secant = 1.0 + f1 / (f1 - f2) if first != 0 else f0 / (f0 - f1)
    begin = float(first)
    if low >= begin and low <= begin + 1.0:
        return low
    return high if high >= begin and high <= begin + 1.0 else secant


@algorithm
def companion(finder: Static, ray: Reals, row: Reals, roots: InOut[Reals]) -> Int:
    """Real roots of the published polynomial in [0, 1] where |f| < 1e-6; how many, rising."""
    rows = finder.rows
    re = empty(rows.printed)
    im = empty(rows.printed)
    powers = rows.published_polynomial(
        ray[: rows.meets.end], row[rows.norm.begin : rows.norm.end], row[rows.kappa.begin : rows.kappa.end]
    )
    found = polynomial_roots(rows.printed, powers, rows.printed, re, im)
    count = 0
    for i in range(found):
        t = re[i]
        is_there = is_real(row[rows.spans.begin : rows.spans.end], t)
        if im[i] != 0.0 or not (t >= 0.0 and t <= 1.0) or not is_there:
            continue
        f = meet(rows, ray, row, t)
        if abs(f) < FILTER and count < len(roots):
            insert(roots, count, t)
            count += 1
    return count


@algorithm
def sampled(finder: Static, ray: Reals, row: Reals, samples: Int, roots: InOut[Reals]) -> Int:
    """Roots between samples, three or more evenly spaced from 0 to 1, where f changes sign; how many, rising.

    The root is that of the quadratic through these two samples and a neighbour.
    """
    rows = finder.rows
    step = 1.0 / float(samples - 1)
    f0 = 0.0
    f1 = 0.0
    count = 0
    run = 0
    for i in range(samples):
        t = 1.0 if rows.ends_at_one and i == samples - 1 else float(i) * step
        if not is_real(row[rows.spans.begin : rows.spans.end], t if t < 1.0 else 1.0):
            run = 0
            continue
        f2 = meet(rows, ray, row, t)
        if run > 0 and (f1 < 0.0) ^ (f2 < 0.0) and count < len(roots):
            x = 0.0
            if run == 1:  # no neighbour before: take the one behind
                f3 = meet(rows, ray, row, t + step)
                x = quadratic(f1, f2, f3, 0)
            else:
                x = quadratic(f0, f1, f2, 1) - 1.0
            root = t + (x - 1.0) * step
            if count > 0:
                root = max(root, roots[count - 1])  # by a rounding
            roots[count] = root
            count += 1
        f0 = f1
        f1 = f2
        run += 1
    return count
