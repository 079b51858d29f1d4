"""Piecewise polynomials of rows of numbers in Bernstein form, and the linear systems of splines. No algebra comes in.

Every value is a mean of ordinates with positive weights, every derivative one of stored rates: no sum cancels but for
what the ordinates do. At the ends of a piece the first and last ordinates come back exactly.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from math import comb

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
#: Items whose sums are formed together: they stay in the cache, and are too few for a matrix product to start threads,
#: which cost more than these sums.
CHUNK = 4096


def _in_chunks(rows_at: Callable[[Array], Array], t: Array, widths: tuple[int, ...]) -> list[Array]:
    """Rows for parameters t (...), some thousand at a time, cut into blocks of columns: one array (..., width) each."""
    flat = t.reshape(-1)
    blocks = [np.empty((len(flat), width)) for width in widths]
    for start in range(0, len(flat), CHUNK):
        chunk = slice(start, start + CHUNK)
        parts = np.split(rows_at(flat[chunk]), np.cumsum(widths)[:-1], axis=1)
        for block, part in zip(blocks, parts, strict=True):
            block[chunk] = part
    return [block.reshape(*t.shape, width) for block, width in zip(blocks, widths, strict=True)]


def binomials(n: int) -> Array:
    """Binomial coefficients of n, shape (n + 1,)."""
    return np.array([comb(n, k) for k in range(n + 1)], np.float64)


def bernstein(degree: int, u: Array) -> Array:
    """Bernstein polynomials of one degree, shape (..., degree + 1), by de Casteljau's recursion (thesis 4.8.4)."""
    v = 1 - u
    basis = np.ones((1, *u.shape))
    for _ in range(degree):
        longer = np.zeros((len(basis) + 1, *u.shape))
        longer[:-1] = v * basis
        longer[1:] += u * basis
        basis = longer
    return np.ascontiguousarray(np.moveaxis(basis, 0, -1))


@dataclass(frozen=True, eq=False)
class Pieces:
    """Polynomials of one degree d over successive intervals.

    Attributes
    ----------
    breaks : (s + 1,)
        Ends of the intervals, ascending. A break belongs to the piece that starts there; the last to the last piece.
    ordinates : (s, d + 1, k)
        Bernstein coefficients of each piece.
    rates : (s, d, k)
        Bernstein coefficients of the derivatives by t. They are differences of the ordinates over the length of the
        interval, kept on their own because ordinates that were rounded would not give them back.
    """

    breaks: Array
    ordinates: Array
    rates: Array

    @property
    def degree(self) -> int:
        """Degree of the polynomials."""
        return int(self.ordinates.shape[1]) - 1

    def at(self, t: Array) -> tuple[Array, Array]:
        """Rows, and sums of the absolute values of their terms: the scale of their rounding errors. Both (..., k)."""
        total, size = _in_chunks(lambda u: self._sums(u, self._with_sizes), t, 2 * (self.ordinates.shape[-1],))
        return total, size

    def rate_at(self, t: Array) -> Array:
        """Derivatives by t, (..., k); at a break those of the piece that starts there."""
        (rate,) = _in_chunks(lambda u: self._sums(u, self.rates), t, (self.rates.shape[-1],))
        return rate

    @cached_property
    def _with_sizes(self) -> Array:
        """Ordinates and their absolute values, side by side."""
        return np.concatenate([self.ordinates, np.abs(self.ordinates)], -1)

    def _sums(self, t: Array, rows: Array) -> Array:
        """Sums of rows (s, d + 1, k) for a chunk of parameters."""
        count = rows.shape[1]
        if len(rows) == 1:
            start, end = self.breaks
            return np.asarray(bernstein(count - 1, (t - start) / (end - start)) @ rows[0])
        piece = np.clip(np.searchsorted(self.breaks, t, side="right") - 1, 0, len(rows) - 1)
        start = self.breaks[piece]
        weights = bernstein(count - 1, (t - start) / (self.breaks[piece + 1] - start))
        return np.asarray(np.einsum("mj,mjk->mk", weights, np.take(rows, piece, axis=0)))


@dataclass(frozen=True, eq=False)
class Quotient:
    """One polynomial over another without a root, on [0, 1] (thesis 4.8.5).

    Attributes
    ----------
    rows : (n + 1, k)
        What the means are of.
    weights : (n + 1,)
        Bernstein coefficients of the denominator; all are positive.
    """

    rows: Array
    weights: Array

    @property
    def degree(self) -> int:
        """Degree of numerator and denominator."""
        return len(self.weights) - 1

    @cached_property
    def ordinates(self) -> Array:
        """Bernstein coefficients of the numerator: rows times weights, (n + 1, k)."""
        return self.rows * self.weights[:, None]

    @cached_property
    def rates(self) -> Array:
        """Bernstein coefficients of the derivative times the square of the denominator, (2 n - 1, k).

        With b_i' b_j - b_i b_j' = (i - j) b_i b_j/(t (1 - t)), the quotient rule (4.32) is a sum of differences of
        rows with positive weights, C(n, i) C(n, j) (j - i)/C(2n - 2, i + j - 1) each: nothing is left to cancel.
        """
        n = self.degree
        rates = np.zeros((2 * n - 1, self.rows.shape[-1]))
        nearest = float(n)  # the share of i and j = i + 1; for the others by their ratios: binomials would overflow
        for i in range(n):
            j = np.arange(i + 1, n + 1)
            ratios = (n - j[:-1]) * (j[:-1] + 1 - i) * (i + j[:-1])
            below = (j[:-1] + 1) * (j[:-1] - i) * (2 * n - 1 - i - j[:-1])
            shares = nearest * np.cumprod(np.concatenate([[1.0], ratios / below]))
            rates[2 * i : i + n] += (shares * self.weights[i] * self.weights[j])[:, None] * (
                self.rows[j] - self.rows[i]
            )
            if i < n - 1:
                up, down = (n - i) * (n - i - 1) * (2 * i + 1) * 2, (i + 2) * (2 * n - 2 - 2 * i) * (2 * n - 3 - 2 * i)
                nearest *= up / down
        return rates

    def at(self, t: Array) -> tuple[Array, Array]:
        """Rows, and sums of the absolute values of their terms, both (..., k)."""
        rows = np.concatenate([self.ordinates, np.abs(self.ordinates)], -1)

        def sums(u: Array) -> Array:
            basis = bernstein(self.degree, u)
            return np.asarray(basis @ rows / (basis @ self.weights)[:, None])

        total, size = _in_chunks(sums, t, 2 * (self.ordinates.shape[-1],))
        return total, size

    def rate_at(self, t: Array) -> Array:
        """Derivatives by t, (..., k)."""

        def rates(u: Array) -> Array:
            denominator = (bernstein(self.degree, u) @ self.weights)[:, None]
            return np.asarray(bernstein(2 * self.degree - 2, u) @ self.rates / (denominator * denominator))

        (rate,) = _in_chunks(rates, t, (self.rates.shape[-1],))
        return rate


def bezier_pieces(rows: Array) -> Pieces:
    """One piece over [0, 1] with these ordinates."""
    return Pieces(np.array([0.0, 1.0]), rows[None], ((len(rows) - 1) * np.diff(rows, axis=0))[None])


def linear_pieces(breaks: Array, rows: Array) -> Pieces:
    """Straight from row to row."""
    rates = np.diff(rows, axis=0) / np.diff(breaks)[:, None]
    return Pieces(breaks, np.stack([rows[:-1], rows[1:]], 1), rates[:, None])


def hermite_pieces(breaks: Array, starts: Array, leaving: Array, ends: Array, arriving: Array) -> Pieces:
    """Cubics from ``starts`` to ``ends`` with derivatives ``leaving`` and ``arriving`` there, each (s, k)."""
    length = np.diff(breaks)[:, None]
    ordinates = np.stack([starts, starts + length / 3 * leaving, ends - length / 3 * arriving, ends], 1)
    middle = 3 * (ends - starts) / length - leaving - arriving
    return Pieces(breaks, ordinates, np.stack([leaving, middle, arriving], 1))


def polynomial_through(knots: Array, rows: Array) -> Pieces:
    """The polynomial of degree at most two through two or three rows."""
    if len(rows) == 2:
        return linear_pieces(knots, rows)
    first, last = np.diff(knots)[:, None]
    slopes = np.diff(rows, axis=0) / np.diff(knots)[:, None]
    bend = (slopes[1] - slopes[0]) / (first + last)
    start, end = slopes[0] - bend * first, slopes[1] + bend * last
    middle = rows[0] + (first + last) / 2 * start
    return Pieces(knots[[0, -1]], np.stack([rows[0], middle, rows[-1]])[None], np.stack([start, end])[None])


def quadratic_pieces(knots: Array, rows: Array) -> Pieces:
    """The C1 spline of parabolas through four rows or more that join half way between knots.

    The knots next to the ends have no joint beside them: the first and last parabola pass through three rows. In the
    B-spline basis every row touches three unknowns; the matrix is totally positive, and needs no pivots.
    """
    inner = (knots[1:-2] + knots[2:-1]) / 2
    breaks = np.concatenate([knots[:1], inner, knots[-1:]])
    length = np.diff(breaks)
    wide = np.concatenate([length[:1], length[:-1] + length[1:], length[-1:]])  # support of the slopes at breaks
    u = (knots[1:-1] - breaks[:-1]) / length
    left = (1 - u) ** 2 * length / wide[:-1]
    right = u * u * length / wide[1:]
    one, none = np.ones(1), np.zeros(1)
    differences = rows - rows[0]
    points = solved_tridiagonal(
        np.concatenate([left, none]),
        np.concatenate([one, 1 - left - right, one]),
        np.concatenate([none, right]),
        differences,
    )
    slopes = 2 * np.diff(points, axis=0) / wide[:, None]
    joints = points[:-1] + (np.concatenate([none, length]) / wide)[:, None] * np.diff(points, axis=0)
    joints[-1] = points[-1]
    ordinates = rows[0] + np.stack([joints[:-1], points[1:-1], joints[1:]], 1)
    ordinates[0, 0], ordinates[-1, -1] = rows[0], rows[-1]
    return Pieces(breaks, ordinates, np.stack([slopes[:-1], slopes[1:]], 1))


def cubic_pieces(knots: Array, rows: Array, is_natural: bool) -> Pieces:
    """The C2 spline of cubics through the rows: natural, or with no joint at the second and last but one knot."""
    length = np.diff(knots)
    slopes = np.diff(rows, axis=0) / length[:, None]
    h, s = length[:, None], slopes
    inner = 3 * (h[1:] * s[:-1] + h[:-1] * s[1:])
    if is_natural:
        lower, main, upper = [1.0], [2.0, 2.0], [1.0]
        first, last = 3 * s[0], 3 * s[-1]
    else:
        a, b, y, z = length[0], length[1], length[-2], length[-1]
        lower, main, upper = [y + z], [b, y], [a + b]
        first = ((a + 2 * (a + b)) * b * s[0] + a * a * s[1]) / (a + b)
        last = (z * z * s[-2] + (2 * (y + z) + z) * y * s[-1]) / (y + z)
    tangents = solved_tridiagonal(
        np.concatenate([length[1:], lower]),
        np.concatenate([main[:1], 2 * (length[:-1] + length[1:]), main[1:]]),
        np.concatenate([upper, length[:-1]]),
        np.concatenate([first[None], inner, last[None]]),
    )
    return hermite_pieces(knots, rows[:-1], tangents[:-1], rows[1:], tangents[1:])


def solved_tridiagonal(lower: Array, main: Array, upper: Array, rows: Array) -> Array:
    """Solution (n, k) of a tridiagonal system that needs no pivots: one sweep down, one up."""
    pivots, solution = main.astype(float), rows.astype(float)
    for i in range(1, len(pivots)):
        factor = lower[i - 1] / pivots[i - 1]
        pivots[i] -= factor * upper[i - 1]
        solution[i] -= factor * solution[i - 1]
    solution[-1] /= pivots[-1]
    for i in range(len(pivots) - 2, -1, -1):
        solution[i] = (solution[i] - upper[i] * solution[i + 1]) / pivots[i]
    return solution
