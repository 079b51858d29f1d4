"""Residuals of matches as linear forms of what a motor moves, in units of their standard deviations.

A match of two objects has up to six: of positions (of the ends of a segment across the line of the other one; of what a
point, an end or a center is off), of directions and of radii. Their covariance is that of both objects' parameters.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.algorithms.registration_layout import RESIDUAL, RESIDUALS, VECTORS
from ...plot.tessellation import across
from ..model.parameters import DIRECTIONS, columns

Array = NDArray[Any]
#: Added to variances, relative to those of the parameters: what is known exactly in a direction has a finite weight.
RIDGE = 1e-12
#: Ends are held along the line while they are off by less than this many standard deviations (Tukey's biweight, which
#: has 95 % efficiency for normal errors): further ones were cut.
CUT = 4.685


@dataclass(frozen=True)
class Match:
    """Matched objects of a kind, in the frames of their models: what their residuals are made of.

    Attributes
    ----------
    x, y : arrays (n, k)
        Parameters of the query's and of the reference's objects.
    moved : array (n, k)
        ``x`` under the motor.
    rotation : array (3, 3)
    """

    x: Array
    y: Array
    moved: Array
    rotation: Array


@dataclass(frozen=True)
class LinearResiduals:
    """Residuals before their covariance is known.

    Attributes
    ----------
    forms : array (n, m, 7)
        Coefficients of the two moved vectors, and what is taken off.
    by_query, by_reference : arrays (n, m, k)
        Their derivatives by the parameters.
    """

    forms: Array
    by_query: Array
    by_reference: Array


def vectors(x: Array, kind: str) -> tuple[Array, int]:
    """The two vectors (n, 6) of each object that its residuals depend on, and 1 if the second one is a direction."""
    place = columns(kind)
    if kind == "plane":
        return np.concatenate([x[:, 3:] * x[:, :3], x[:, :3]], 1), 1
    parts = [x[:, part] for name, part in place.items() if name != "radius"]
    return np.concatenate([parts[0], parts[-1]], 1), int(any(name in DIRECTIONS for name in place))


def axes_of(rows: Array, kind: str) -> Array:
    """Directions (n, 3) of objects that have one, of any length."""
    place = columns(kind)
    if "b" in place:
        return np.asarray(rows[:, place["b"]] - rows[:, place["a"]])
    return np.asarray(rows[:, place.get("direction", place.get("normal", slice(0)))])


def turned_rows(rows: Array, kind: str, turned: Array) -> Array:
    """Parameters of the same objects, some of them turned round."""
    found = rows.copy()
    if kind in ("point_pair", "segment"):
        found[turned] = np.roll(rows[turned], 3, axis=1)
    elif kind == "plane":
        found[turned] *= -1
    elif kind in ("line", "circle"):
        found[turned, 3:6] *= -1
    return found


def linear_residuals(kind: str, match: Match) -> LinearResiduals:
    """Residuals (see the module) of the matches of a kind."""
    return _RESIDUALS[kind](match)


def _empty(n: int, m: int, k: int) -> LinearResiduals:
    return LinearResiduals(np.zeros((n, m, RESIDUAL)), np.zeros((n, m, k)), np.zeros((n, m, k)))


def _of_positions(match: Match) -> LinearResiduals:
    """Points, and both ends of point pairs."""
    n, k = match.x.shape
    found = _empty(n, k, k)
    for part in (slice(i, i + 3) for i in range(0, k, 3)):
        found.forms[:, part, part] = np.eye(3)
        found.by_query[:, part, part] = match.rotation
        found.by_reference[:, part, part] = -np.eye(3)
    found.forms[:, :, VECTORS] = match.y
    return found


def _of_spheres(match: Match) -> LinearResiduals:
    found = _empty(len(match.x), 4, 4)
    found.forms[:, :3, :3] = np.eye(3)
    found.forms[:, :, VECTORS] = match.y
    found.forms[:, 3, VECTORS] -= match.x[:, 3]
    found.by_query[:, :3, :3], found.by_query[:, 3, 3] = match.rotation, 1
    found.by_reference[:] = -np.eye(4)
    return found


def _of_circles(match: Match) -> LinearResiduals:
    found, normals = _empty(len(match.x), 6, 7), _across(match.y[:, 3:6])
    found.forms[:, :3, :3], found.forms[:, :3, VECTORS] = np.eye(3), match.y[:, :3]
    found.by_query[:, :3, :3], found.by_reference[:, :3, :3] = match.rotation, -np.eye(3)
    found.forms[:, 3:5, 3:6] = normals
    found.by_query[:, 3:5, 3:6], found.by_reference[:, 3:5, 3:6] = normals @ match.rotation, -normals
    found.forms[:, 5, VECTORS] = match.y[:, 6] - match.x[:, 6]
    found.by_query[:, 5, 6], found.by_reference[:, 5, 6] = 1, -1
    return found


def _of_lines(match: Match) -> LinearResiduals:
    """What a point of the query's line, and its direction, are off across the reference's line."""
    found, off = _empty(len(match.x), 4, 6), _across(match.y[:, 3:])
    along = ((match.moved[:, :3] - match.y[:, :3]) * match.y[:, 3:]).sum(1)
    found.forms[:, :2, :3], found.forms[:, 2:, 3:6] = off, off
    found.forms[:, :2, VECTORS] = (off @ match.y[:, :3, None])[..., 0]
    found.by_query[:, :2, :3], found.by_query[:, 2:, 3:] = off @ match.rotation, off @ match.rotation
    found.by_reference[:, :2, :3], found.by_reference[:, 2:, 3:] = -off, -off
    found.by_reference[:, :2, 3:] = -along[:, None, None] * off
    return found


def _of_planes(match: Match) -> LinearResiduals:
    """What the normal is off, and the foot of the query's plane off the reference's plane."""
    found, normal = _empty(len(match.x), 3, 4), match.y[:, :3]
    off = _across(normal)
    found.forms[:, :2, 3:6] = off
    found.by_query[:, :2, :3], found.by_reference[:, :2, :3] = off @ match.rotation, -off
    found.forms[:, 2, :3], found.forms[:, 2, VECTORS] = normal, match.y[:, 3]
    found.by_query[:, 2, 3], found.by_reference[:, 2, 3] = 1, -1
    found.by_reference[:, 2, :3] = match.moved[:, 3:] * match.moved[:, :3]
    return found


def _of_segments(match: Match) -> LinearResiduals:
    """What the ends of the query's segment are off across the reference's line, and along it off the ends there.

    The error of a line at some fraction of the way from one end of its segment to the other, or beyond, is made of the
    errors of both.
    """
    n = len(match.x)
    found = _empty(n, 6, 6)
    begin, along, length = segment_axes(match.y)
    off = _across(along)
    for i, part in enumerate((slice(0, 3), slice(3, 6))):
        two, one = slice(2 * i, 2 * i + 2), 4 + i
        fraction = ((match.moved[:, part] - begin) * along).sum(1) / length
        found.forms[:, two, part], found.forms[:, one, part] = off, along
        found.forms[:, two, VECTORS] = (off @ begin[..., None])[..., 0]
        found.forms[:, one, VECTORS] = (along * match.y[:, part]).sum(1)
        found.by_query[:, two, part] = off @ match.rotation
        found.by_query[:, one, part] = along @ match.rotation
        found.by_reference[:, two, :3] = -(1 - fraction)[:, None, None] * off
        found.by_reference[:, two, 3:] = -fraction[:, None, None] * off
        found.by_reference[:, one, part] = -along
    return found


def segment_axes(rows: Array) -> tuple[Array, Array, Array]:
    """First ends (n, 3), unit directions (n, 3) and lengths (n,) of segments."""
    between = rows[:, 3:] - rows[:, :3]
    length = np.linalg.norm(between, axis=1)
    return rows[:, :3], between / length[:, None], length


def _across(normals: Array) -> Array:
    """Two unit vectors (n, 2, 3) across each."""
    return np.stack(across(normals), 1)


_RESIDUALS: dict[str, Callable[[Match], LinearResiduals]] = {
    "point": _of_positions, "point_pair": _of_positions, "line": _of_lines, "segment": _of_segments,
    "circle": _of_circles, "plane": _of_planes, "sphere": _of_spheres,
}  # fmt: skip


def whitened(residuals: LinearResiduals, query: Array | None, reference: Array | None, alone: int = RESIDUALS) -> Array:
    """Forms (n, 6, 7) of residuals of unit covariance, zeros behind them.

    Parameters
    ----------
    residuals : LinearResiduals
    query, reference : array (n, k, k) or (n,), optional
        Covariances of the parameters, or the variance of each; None for exact ones.
    alone : int
        Residuals from this one on count as independent of all others, so that each may be left out.
    """
    n, m, _ = residuals.forms.shape
    total, ridge = np.zeros((n, m, m)), np.zeros(n)
    for covariances, by in ((query, residuals.by_query), (reference, residuals.by_reference)):
        if covariances is None:
            continue
        if covariances.ndim == 1:
            total += covariances[:, None, None] * (by @ by.swapaxes(1, 2))
            ridge += covariances * by.shape[2]
        else:
            total += by @ covariances @ by.swapaxes(1, 2)
            ridge += np.trace(covariances, axis1=1, axis2=2)
    independent = np.arange(m) >= alone
    total[:, (independent[:, None] | independent) & ~np.eye(m, dtype=bool)] = 0.0
    factor = np.linalg.cholesky(total + (RIDGE * ridge)[:, None, None] * np.eye(m))
    found = np.zeros((n, RESIDUALS, RESIDUAL))
    found[:, :m] = np.linalg.solve(factor, residuals.forms)
    return found
