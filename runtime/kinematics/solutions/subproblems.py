"""Subproblems of arms: angles of rotations about known axes that bring points and directions together, in batches.

Rotations are about lines with a unit direction; what has no real answer is NaN. Answers are starts for Newton's method:
an equation without an answer by less than rounding counts as one that is touched.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
#: By how much the sine or cosine of an angle may exceed one.
EXCESS = 1e-4
#: Imaginary part, relative to the root, up to which it counts as real: double roots are known to half the digits.
NEARLY_REAL = 1e-3
#: Determinants, relative to the squares of entries, below which a pair of equations says one thing: the first for sure.
DEPENDENT, INDEPENDENT = 1e-9, 1e-3


class Line(NamedTuple):
    """An axis: unit direction (3,), and a point (3,)."""

    direction: Array
    point: Array


def crossing(direction: Array) -> Array:
    """The matrix of x -> direction x x: for batches less than half of what NumPy's function takes."""
    x, y, z = direction
    return np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])


def rotate(direction: Array, angle: Array, x: Array) -> Array:
    """Vectors (..., 3) rotated about a direction by angles (...)."""
    c, s = np.cos(angle)[..., None], np.sin(angle)[..., None]
    across = x @ crossing(direction).T
    return np.asarray(c * x + s * across + (1 - c) * (x @ direction)[..., None] * direction)


def rotate_about(line: Line, angle: Array, x: Array) -> Array:
    """Points (..., 3) rotated about a line."""
    return rotate(line.direction, angle, x - line.point) + line.point


def matrix_about(direction: Array, angle: Array) -> Array:
    """Matrices (..., 3, 3) of rotations."""
    c, s = np.cos(angle)[..., None, None], np.sin(angle)[..., None, None]
    return np.asarray(c * np.eye(3) + s * crossing(direction) + (1 - c) * np.outer(direction, direction))


def angle_between(direction: Array, x: Array, y: Array) -> Array:
    """Angle about a direction from x (..., 3) to y (..., 3), both seen along it; zero where either is along it."""
    across = (x * y).sum(-1) - (x @ direction) * (y @ direction)
    return np.asarray(np.arctan2((y * (x @ crossing(direction).T)).sum(-1), across))


def linear_in_angle(a: Array, b: Array, c: Array) -> Array:
    """Both angles (..., 2) with a cos + b sin = c."""
    size = np.hypot(a, b)
    with np.errstate(all="ignore"):
        ratio = c / size
        ratio = np.where(np.abs(ratio) <= 1 + EXCESS, np.clip(ratio, -1, 1), np.nan)
        swing = np.arccos(ratio)
    middle = np.arctan2(b, a)
    return np.stack([middle + swing, middle - swing], -1)


def two_angles(a: Array, b: Array, d: Array) -> tuple[Array, Array]:
    """Pairs of angles (..., k) with a (cos x, sin x) + b (cos y, sin y) = d, for matrices (..., 2, 2) and d (..., 2).

    Up to four pairs. The intersection of an ellipse with a circle is a polynomial of degree four; where a matrix has
    one equation only in its angle, the other angle is by itself.
    """
    with np.errstate(all="ignore"):
        independent = [_independence(m) for m in (a, b)]
        first_is_better = (independent[0] >= independent[1])[..., None, None]
        better, other = np.where(first_is_better, a, b), np.where(first_is_better, b, a)
        best = np.maximum(*independent)
        of_better, of_other = _by_quartic(better, other, d)
        is_certain = (best > DEPENDENT)[..., None]
        of_better, of_other = (np.where(is_certain, v, np.nan) for v in (of_better, of_other))
        alone_better, alone_other = _by_single_equation(better, other, d)
        is_single = (best < INDEPENDENT)[..., None]
        alone_better, alone_other = (np.where(is_single, v, np.nan) for v in (alone_better, alone_other))
    one = np.concatenate([of_better, alone_better], -1)
    two = np.concatenate([of_other, alone_other], -1)
    is_first = first_is_better[..., 0]
    return np.where(is_first, one, two), np.where(is_first, two, one)


def _independence(m: Array) -> Array:
    return np.asarray(np.nan_to_num(np.abs(np.linalg.det(m)) / (m**2).sum((-1, -2))))


def _by_quartic(a: Array, b: Array, d: Array) -> tuple[Array, Array]:
    """From (cos x, sin x) = a^-1 (d - b (cos y, sin y)): its square is one."""
    det = np.linalg.det(a)
    adjugate = np.stack(
        [np.stack([a[..., 1, 1], -a[..., 0, 1]], -1), np.stack([-a[..., 1, 0], a[..., 0, 0]], -1)], -2
    )
    inverse = adjugate / det[..., None, None]
    p, q = np.einsum("...ij,...j->...i", inverse, d), -inverse @ b
    # |p + q u|^2 = 1 with u = (cos y, sin y), as a polynomial of z = e^(iy): z^2 of it has degree four
    m = np.swapaxes(q, -1, -2) @ q
    second = (m[..., 0, 0] - m[..., 1, 1]) / 4 - 0.5j * m[..., 0, 1]
    linear = 2 * np.einsum("...i,...ij->...j", p, q)
    first = (linear[..., 0] - 1j * linear[..., 1]) / 2
    constant = (p**2).sum(-1) - 1 + (m[..., 0, 0] + m[..., 1, 1]) / 2
    z = _roots(np.stack([second, first, constant + 0j, first.conj(), second.conj()], -1))
    y = np.where(np.abs(np.abs(z) - 1) < NEARLY_REAL, np.angle(z), np.nan)
    u = np.stack([np.cos(y), np.sin(y)], -1)
    v = p[..., None, :] + np.einsum("...ij,...kj->...ki", q, u)
    return np.arctan2(v[..., 1], v[..., 0]), y


def _roots(coefficients: Array) -> Array:
    """Roots (..., 4) of polynomials (..., 5), the highest power first; those at infinity are NaN."""
    size = np.abs(coefficients).max(-1, keepdims=True)
    c = np.where(size > 0, coefficients / size, np.nan)
    flat = c.reshape(-1, 5)
    found = np.full((len(flat), 4), np.nan, complex)
    usable = np.isfinite(flat).all(-1)
    is_quartic = usable & (np.abs(flat[:, 0]) > 1e-12)
    matrix = np.zeros((int(is_quartic.sum()), 4, 4), complex)
    matrix[:, 0] = -flat[is_quartic, 1:] / flat[is_quartic, :1]
    matrix[:, [1, 2, 3], [0, 1, 2]] = 1
    finite = np.isfinite(matrix).all((-1, -2))
    values = np.full((len(matrix), 4), np.nan, complex)
    values[finite] = np.linalg.eigvals(matrix[finite])
    found[is_quartic] = values
    for i in np.flatnonzero(usable & ~is_quartic):  # both ends vanish: at most two angles
        low = np.roots(flat[i, 1:4])
        found[i, : len(low)] = low
    return found.reshape(*coefficients.shape[:-1], 4)


def _by_single_equation(a: Array, b: Array, d: Array) -> tuple[Array, Array]:
    """Where a has one equation in x: the combination without x gives y, and the rest x."""
    finite = np.isfinite(a).all((-1, -2), keepdims=True)
    u, s, vh = np.linalg.svd(np.where(finite, a, 0))
    rest, main = u[..., :, 1], u[..., :, 0]
    row = np.einsum("...i,...ij->...j", rest, b)
    y = linear_in_angle(row[..., 0], row[..., 1], (rest * d).sum(-1))
    angles = np.stack([np.cos(y), np.sin(y)], -1)
    left = (main * d).sum(-1)[..., None] - np.einsum("...i,...ij,...kj->...k", main, b, angles)
    of_x = s[..., :1] * vh[..., 0, :]
    x = linear_in_angle(of_x[..., None, 0], of_x[..., None, 1], left)
    flat = (*y.shape[:-1], 4)
    return x.reshape(flat), np.broadcast_to(y[..., None], x.shape).reshape(flat)
