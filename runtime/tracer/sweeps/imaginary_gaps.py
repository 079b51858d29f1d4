"""Intervals where sums of circles or point pairs along a curve are imaginary: decided rigorously, not sampled.

The signs of three polynomials decide (formulas/curves/spans.py). Where all Bernstein coefficients of a polynomial on an
interval have one sign by more than rounding, so has the polynomial; other intervals are bisected. All rows are
processed together.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...curves.bernstein import binomials
from ...dispatch.formulas import ArrayOperand, evaluate

Array = NDArray[np.float64]
#: Error bound of a coefficient in rounding units, relative to the sum of the absolute values of its terms.
ROUNDING = 16
#: Rounding unit.
EPSILON = float(np.finfo(np.float64).eps)
#: Largest number of bisections: an interval that is still undecided counts as a point.
DEPTH = 46
#: Largest number of open intervals of a row; no polynomial of these degrees has so many roots.
MOST_OPEN = 256


@dataclass(frozen=True, eq=False)
class Gaps:
    """Intervals of the pieces' own parameter without real objects.

    Attributes
    ----------
    row : (g,)
        Row of each gap; ascending.
    low, high : (g,)
    imaginary : (g,) of bool
        Objects are imaginary inside; otherwise the gap is one point, up to rounding, where the projector is singular.
    """

    row: NDArray[np.intp]
    low: Array
    high: Array
    imaginary: NDArray[np.bool_]


def imaginary_gaps(controls: Array, kind: str, free: bool = False) -> Gaps:
    """Find the gaps of curves with Bernstein coefficients ``controls`` (rows, 10 (n + 1)); adjacent ones are merged."""
    kappa, norm, isolated = _polynomials(controls, kind, free)
    row = np.arange(len(controls))
    number = np.zeros(len(controls), np.int64)  # of the interval of length 2^-depth
    gaps: list[tuple[NDArray[np.intp], Array, Array, NDArray[np.bool_]]] = []
    for depth in range(DEPTH + 1):
        width = np.float64(0.5**depth)
        weight = np.ones(len(row)) if free else _largest_weight(number * width, (number + 1) * width)
        real, imaginary, undecided = _classify(kappa, norm, isolated, weight)
        if depth == DEPTH:
            undecided = ~real & ~imaginary
        undecided |= _too_many(row, ~(real | imaginary | undecided))
        done = imaginary | undecided
        gaps.append((row[done], number[done] * width, (number[done] + 1) * width, imaginary[done]))
        remaining = ~(real | done)
        if not remaining.any():
            break
        row, number = np.repeat(row[remaining], 2), np.repeat(2 * number[remaining], 2)
        number[1::2] += 1
        kappa, norm, isolated = (_subdivide(p[remaining]) for p in (kappa, norm, isolated))
    return _merge_gaps(*(np.concatenate(part) for part in zip(*gaps, strict=True)))


def _polynomials(controls: Array, kind: str, free: bool) -> list[Array]:
    """Bernstein coefficients of K, S0 and D with their error bounds, each (rows, 2, d + 1)."""
    from ...core.registry import stock_algebra

    formula = f"spans.{'free_' if free else ''}{kind}_norms"
    width = controls.shape[1]
    result = evaluate(stock_algebra("cga3d"), formula, ArrayOperand(np.ascontiguousarray(controls), width, "controls"))
    norm, kappa, isolated, *bounds = result.values
    unit = ROUNDING * EPSILON
    norm_bound, kappa_bound, kappa_rest, isolated_bound, isolated_rest = (unit * b for b in bounds)
    kappa_bound, isolated_bound = kappa_bound + unit * kappa_rest, isolated_bound + unit * isolated_rest
    if not free:  # ends are certainly objects, however large the terms of their squares are
        for value, bound in ((norm, norm_bound), (isolated, isolated_bound)):
            value[:, [0, -1]] = np.maximum(value[:, [0, -1]], np.finfo(np.float64).tiny)
            bound[:, [0, -1]] = 0.0
    pairs = ((kappa, kappa_bound), (norm, norm_bound), (isolated, isolated_bound))
    return [np.stack(pair, axis=1) / binomials(pair[0].shape[1] - 1) for pair in pairs]


def _largest_weight(low: Array, high: Array) -> Array:
    """Largest w = t (1 - t) on intervals."""
    middle = (low <= 0.5) & (high >= 0.5)
    return np.where(middle, 0.25, np.maximum(low * (1 - low), high * (1 - high)))


def _classify(
    kappa: Array, norm: Array, isolated: Array, weight: Array
) -> tuple[NDArray[np.bool_], NDArray[np.bool_], NDArray[np.bool_]]:
    """Masks of intervals where objects are certainly real, certainly imaginary, and undecided because of rounding.

    Where K vanishes, D is the square of S0: there S0 > w sqrt(K + rounding) is a sharper test than D > 0.
    """

    def positive(x: Array) -> NDArray[np.bool_]:
        return np.asarray((x[:, 0] > x[:, 1]).all(axis=1))

    def negative(x: Array) -> NDArray[np.bool_]:
        return np.asarray((x[:, 0] < -x[:, 1]).all(axis=1))

    def within(x: Array) -> NDArray[np.bool_]:
        return np.asarray((np.abs(x[:, 0]) <= x[:, 1]).all(axis=1))

    # a K that may be zero counts as zero: then S0 alone decides (circles of one sphere)
    square = np.asarray((kappa[:, 0] >= -kappa[:, 1]).all(axis=1))
    least = (norm[:, 0] - norm[:, 1]).min(axis=1)
    most = weight * np.sqrt(np.maximum((kappa[:, 0] + kappa[:, 1]).max(axis=1), 0.0))
    real = negative(kappa) | (positive(norm) & (positive(isolated) | (least > most)))
    imaginary = (square & negative(norm)) | negative(isolated)
    undecided = square & within(isolated) & (within(norm) | positive(kappa))
    return real, imaginary & ~real, undecided & ~imaginary & ~real


def _subdivide(polynomials: Array) -> Array:
    """Bernstein coefficients on both halves (2 m, ...), interleaved, by de Casteljau's recursion."""
    count = polynomials.shape[-1]
    halves = np.empty((len(polynomials), 2, *polynomials.shape[1:]))
    row = polynomials
    for k in range(count):
        halves[:, 0, ..., k], halves[:, 1, ..., count - 1 - k] = row[..., 0], row[..., -1]
        row = (row[..., 1:] + row[..., :-1]) / 2
    return halves.reshape(-1, *polynomials.shape[1:])


def _too_many(row: NDArray[np.intp], remaining: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Mask of the open intervals of rows that have too many of them."""
    counts = np.bincount(row[remaining], minlength=1)
    return np.asarray(remaining & (counts[np.minimum(row, len(counts) - 1)] > MOST_OPEN))


def _merge_gaps(row: NDArray[np.intp], low: Array, high: Array, imaginary: NDArray[np.bool_]) -> Gaps:
    """Sort gaps, and merge adjacent ones."""
    order = np.lexsort((low, row))
    row, low, high, imaginary = row[order], low[order], high[order], imaginary[order]
    if not len(row):
        return Gaps(row, low, high, imaginary)
    starts = np.concatenate([[True], (row[1:] != row[:-1]) | (low[1:] > high[:-1])])
    first = np.nonzero(starts)[0]
    last = np.concatenate([first[1:], [len(row)]]) - 1
    return Gaps(row[first], low[first], high[last], np.logical_or.reduceat(imaginary, first))
