"""Where sums of circles or point pairs along a curve are imaginary: decided for certain, not sampled.

The signs of three polynomials decide it (codegen/formulas/spans.py). On an interval where all Bernstein coefficients of
one have a sign by more than rounding so has the polynomial; other intervals are halved. All rows are done at once.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import comb

import numpy as np
from numpy.typing import NDArray

from ..calls import Numbers, call

Array = NDArray[np.float64]
#: Rounding units that a coefficient may be off, of the sum of the absolute values of its terms.
ROUNDING = 16
EPSILON = float(np.finfo(np.float64).eps)
#: Halvings after which an interval is a point, where nothing is decided.
DEPTH = 46
#: Intervals of one row that are halved on; no polynomial of these degrees has so many roots.
MOST_OPEN = 256


@dataclass(frozen=True, eq=False)
class Gaps:
    """Intervals of the pieces' own parameter where no real object is found.

    Attributes
    ----------
    row : (g,)
        Whose they are; ascending.
    low, high : (g,)
    imaginary : (g,) of bool
        Objects are imaginary inside; else there is one place, to rounding, where the projector is singular.
    """

    row: NDArray[np.intp]
    low: Array
    high: Array
    imaginary: NDArray[np.bool_]


def imaginary_gaps(controls: Array, kind: str, free: bool = False) -> Gaps:
    """Gaps of curves with Bernstein coefficients ``controls`` (rows, 10 (n + 1)), merged where they touch."""
    kappa, norm, isolated = _polynomials(controls, kind, free)
    row = np.arange(len(controls))
    place = np.zeros(len(controls), np.int64)  # number of the interval of 2^-depth
    found: list[tuple[NDArray[np.intp], Array, Array, NDArray[np.bool_]]] = []
    for depth in range(DEPTH + 1):
        width = np.float64(0.5**depth)
        weight = np.ones(len(row)) if free else _largest_weight(place * width, (place + 1) * width)
        real, imaginary, blind = _decided(kappa, norm, isolated, weight)
        if depth == DEPTH:
            blind = ~real & ~imaginary
        blind |= _too_many(row, ~(real | imaginary | blind))
        done = imaginary | blind
        found.append((row[done], place[done] * width, (place[done] + 1) * width, imaginary[done]))
        left = ~(real | done)
        if not left.any():
            break
        row, place = np.repeat(row[left], 2), np.repeat(2 * place[left], 2)
        place[1::2] += 1
        kappa, norm, isolated = (_halved(p[left]) for p in (kappa, norm, isolated))
    return _merged(*(np.concatenate(part) for part in zip(*found, strict=True)))


def _polynomials(controls: Array, kind: str, free: bool) -> list[Array]:
    """K, S0 and D with their bounds, each (rows, 2, d + 1): Bernstein coefficients."""
    from ..loading import stock_algebra

    formula = f"spans.{'free_' if free else ''}{kind}_norms"
    width = controls.shape[1]
    result = call(stock_algebra("cga3d"), formula, Numbers(np.ascontiguousarray(controls), width, "controls"))
    norm, kappa, isolated, *bounds = result.values
    unit = ROUNDING * EPSILON
    norm_bound, kappa_bound, kappa_rest, isolated_bound, isolated_rest = (unit * b for b in bounds)
    kappa_bound, isolated_bound = kappa_bound + unit * kappa_rest, isolated_bound + unit * isolated_rest
    if not free:  # ends are objects for certain, however large the terms are that their squares are made of
        for value, bound in ((norm, norm_bound), (isolated, isolated_bound)):
            value[:, [0, -1]] = np.maximum(value[:, [0, -1]], np.finfo(np.float64).tiny)
            bound[:, [0, -1]] = 0.0
    pairs = ((kappa, kappa_bound), (norm, norm_bound), (isolated, isolated_bound))
    return [np.stack(pair, axis=1) / _binomials(pair[0].shape[1]) for pair in pairs]


def _binomials(count: int) -> Array:
    return np.array([comb(count - 1, k) for k in range(count)], np.float64)


def _largest_weight(low: Array, high: Array) -> Array:
    """Largest w = t (1 - t) on intervals."""
    middle = (low <= 0.5) & (high >= 0.5)
    return np.where(middle, 0.25, np.maximum(low * (1 - low), high * (1 - high)))


def _decided(
    kappa: Array, norm: Array, isolated: Array, weight: Array
) -> tuple[NDArray[np.bool_], NDArray[np.bool_], NDArray[np.bool_]]:
    """Intervals where objects are real for certain, imaginary for certain, and where rounding hides it.

    Where K vanishes D is the square of S0: there S0 above w sqrt(K + rounding) tells more than D does.
    """

    def positive(x: Array) -> NDArray[np.bool_]:
        return np.asarray((x[:, 0] > x[:, 1]).all(axis=1))

    def negative(x: Array) -> NDArray[np.bool_]:
        return np.asarray((x[:, 0] < -x[:, 1]).all(axis=1))

    def within(x: Array) -> NDArray[np.bool_]:
        return np.asarray((np.abs(x[:, 0]) <= x[:, 1]).all(axis=1))

    # K that may be zero counts as zero: then S0 alone decides (circles of one sphere)
    square = np.asarray((kappa[:, 0] >= -kappa[:, 1]).all(axis=1))
    least = (norm[:, 0] - norm[:, 1]).min(axis=1)
    most = weight * np.sqrt(np.maximum((kappa[:, 0] + kappa[:, 1]).max(axis=1), 0.0))
    real = negative(kappa) | (positive(norm) & (positive(isolated) | (least > most)))
    imaginary = (square & negative(norm)) | negative(isolated)
    blind = square & within(isolated) & (within(norm) | positive(kappa))
    return real, imaginary & ~real, blind & ~imaginary & ~real


def _halved(polynomials: Array) -> Array:
    """Bernstein coefficients on both halves (2 m, ...), one after the other, by de Casteljau's recursion."""
    count = polynomials.shape[-1]
    halves = np.empty((len(polynomials), 2, *polynomials.shape[1:]))
    row = polynomials
    for k in range(count):
        halves[:, 0, ..., k], halves[:, 1, ..., count - 1 - k] = row[..., 0], row[..., -1]
        row = (row[..., 1:] + row[..., :-1]) / 2
    return halves.reshape(-1, *polynomials.shape[1:])


def _too_many(row: NDArray[np.intp], left: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Open intervals of rows that have too many of them."""
    counts = np.bincount(row[left], minlength=1)
    return np.asarray(left & (counts[np.minimum(row, len(counts) - 1)] > MOST_OPEN))


def _merged(row: NDArray[np.intp], low: Array, high: Array, imaginary: NDArray[np.bool_]) -> Gaps:
    """In order, and one where they follow on each other."""
    order = np.lexsort((low, row))
    row, low, high, imaginary = row[order], low[order], high[order], imaginary[order]
    if not len(row):
        return Gaps(row, low, high, imaginary)
    starts = np.concatenate([[True], (row[1:] != row[:-1]) | (low[1:] > high[:-1])])
    first = np.nonzero(starts)[0]
    last = np.concatenate([first[1:], [len(row)]]) - 1
    return Gaps(row[first], low[first], high[last], np.logical_or.reduceat(imaginary, first))
