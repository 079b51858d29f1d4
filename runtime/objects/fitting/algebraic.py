"""Initial values of fits: points in local coordinates, their principal axes, and algebraic spheres.

Coordinates are local to each set: about a point near its mean, in a power of two for a unit, so that neither size nor
distance from the origin costs digits. Sets are rows of arrays.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import ShapeError
from ...codegen.formulas.products.outcome import NOISE
from ...common.validation import broadcast_to, real_array
from ...core.multivector import Algebra, Multivector
from ...core.registry import stock_algebra
from ...dispatch.formulas import ArrayOperand, evaluate
from ..arguments import as_objects
from ..subspaces.spanning_vectors import on_grades

Array = NDArray[np.float64]
EPS = float(np.finfo(np.float64).eps)


@dataclass(frozen=True)
class Sets:
    """Sets of points in local coordinates.

    Attributes
    ----------
    lead : tuple of int
        Shape of the batch of k sets; dtype: precision of the results.
    origin, unit : arrays (k, 3) and (k,)
        points = origin + unit * local.
    local : array (k, n, 3)
        At most 1 in size.
    middle : array (k, 3)
        Weighted mean of ``local``.
    weight : array (k, n)
        Square roots of the weights, whose sum is 1.
    floor : array (k,)
        Below this singular values of the set are rounding errors of the points.
    valid : array (k,)
        Sets that are finite, with weights that can be used.
    """

    algebra: Algebra
    lead: tuple[int, ...]
    dtype: np.dtype[Any]
    origin: Array
    unit: Array
    local: Array
    middle: Array
    weight: Array
    floor: Array
    valid: NDArray[np.bool_]

    def axes(self) -> tuple[Array, Array]:
        """Singular values (k, 3), largest first, and principal axes (k, 3, 3), one a row."""
        centred = (self.local - self.middle[:, None]) * self.weight[..., None]
        # R of centred = Q R has its singular values; unlike the products of coordinates it keeps small ones
        triangle: Any = np.linalg.qr(centred, mode="r")
        full = np.zeros((len(centred), 3, 3))
        full[:, : triangle.shape[-2]] = triangle
        _, sigma, vt = np.linalg.svd(full)
        return np.asarray(sigma), np.asarray(vt)


def as_sets(points: Any, weights: Any) -> Sets:
    """Points (..., n, 3), or points of CGA (..., n), in local coordinates.

    Raises
    ------
    InputError, ShapeError, GradeError
        If they are no points, or the weights do not fit.
    """
    if isinstance(points, (Multivector, list, tuple)) and _holds_multivectors(points):
        known = as_objects(points, "the points", (1,))
        algebra = known.algebra
        xyz: Any = evaluate(algebra, "conformal.point_parameters", known).value._data
    else:
        algebra = stock_algebra("cga3d")
        xyz = real_array(points, "the points", (..., 3))
    if xyz.ndim < 2 or xyz.shape[-1] != 3 or not xyz.shape[-2]:
        raise ShapeError(f"the points have shape {xyz.shape}; sets of n points have shape (..., n, 3), n at least 1.")
    lead, n = xyz.shape[:-2], xyz.shape[-2]
    dtype, xyz = xyz.dtype, xyz.astype(float, order="C").reshape(-1, n, 3)
    weight, usable = _weights(weights, lead, n)
    with np.errstate(all="ignore"):  # nor is a sum of distances beyond the largest number
        valid = np.isfinite((xyz.max((-1, -2)) - xyz.min((-1, -2))) * n) & usable
    xyz = np.where(valid[:, None, None], xyz, 0.0)
    origin = xyz[:, 0] + (xyz - xyz[:, :1]).mean(1)
    local = xyz - origin[:, None]
    reach = np.abs(local).max((-1, -2), initial=0.0)
    largest = np.finfo(float).maxexp - 1  # of a power of two
    unit = np.ldexp(1.0, np.where(reach > 0, np.minimum(np.frexp(reach)[1], largest), 0))
    local = local / unit[:, None, None]
    middle = np.einsum("kn,kni->ki", weight * weight, local)
    floor = NOISE * float(np.finfo(dtype).eps) * (1 + np.abs(origin).max(-1) / unit)
    return Sets(algebra, lead, dtype, origin, unit, local, middle, weight, floor, valid)


def _holds_multivectors(points: Any) -> bool:
    return isinstance(points, Multivector) or (len(points) > 0 and isinstance(points[0], Multivector))


def _weights(weights: Any, lead: tuple[int, ...], n: int) -> tuple[Array, NDArray[np.bool_]]:
    """Square roots of the weights over their sum (k, n), and which sets' weights can be used."""
    if weights is None:
        given: Array = np.full((*lead, n), 1.0 / n)
    else:
        given = broadcast_to(real_array(weights, "the weights").astype(float), (*lead, n), "weights")
    given = given.reshape(-1, n)
    with np.errstate(all="ignore"):
        usable = (given >= 0).all(-1) & np.isfinite(given).all(-1) & (given.max(-1, initial=0.0) > 0)
        scaled = given / given.max(-1, keepdims=True)
        weight = np.sqrt(scaled / scaled.sum(-1, keepdims=True))
    return np.where(usable[:, None], weight, np.sqrt(1.0 / n)), np.asarray(usable)


# -- conformal coordinates ---------------------------------------------------------------------------------


@lru_cache(maxsize=8)
def metric(algebra: Algebra) -> Array:
    """Inner products of the basis vectors."""
    return np.array([[float(g) for g in row] for row in algebra.metric])


def vectors(algebra: Algebra, rows: Array) -> Multivector:
    """Rows as vectors of the algebra."""
    return on_grades(algebra, (1,), rows, None, rows.shape[:-1])


def positions(algebra: Algebra, xyz: Array) -> ArrayOperand:
    return ArrayOperand(np.ascontiguousarray(xyz), algebra.kind("euclidean"), "the points")


def algebraic_sphere(algebra: Algebra, xyz: Array, weight: Array, basis: Array) -> Array:
    """The unit dual sphere s in the span of ``basis`` (k, 5, m) with the least sum of weighted (s . X)^2.

    Pratt's fit: with the singular values of the points in conformal coordinates, the smallest positive eigenvalue of
    their sum of products under the condition s^2 = 1.
    """
    g = metric(algebra)
    conformal = evaluate(algebra, "conformal.point", positions(algebra, xyz)).value._data
    rows = (conformal @ g * weight[..., None]) @ basis
    m = basis.shape[-1]
    triangle: Any = np.linalg.qr(rows, mode="r")
    full = np.zeros((len(rows), m, m))
    full[:, : triangle.shape[-2]] = triangle
    _, sigma, vt = np.linalg.svd(full)
    floored = np.maximum(sigma, EPS * sigma[:, :1])
    scaled = np.swapaxes(vt, -1, -2) / floored[:, None, :]
    form = np.swapaxes(basis @ scaled, -1, -2) @ g @ (basis @ scaled)
    _, modes = np.linalg.eigh((form + np.swapaxes(form, -1, -2)) / 2)
    s = (basis @ (scaled @ modes[..., -1:]))[..., 0]
    return normalize_vectors(algebra, s)


def normalize_vectors(algebra: Algebra, s: Array) -> Array:
    """Rows over the root of their squares; NaN where those are not positive."""
    with np.errstate(all="ignore"):
        square = products(algebra, s, s)
        return np.asarray(s / np.sqrt(np.where(square > 0, square, np.nan))[..., None])


def products(algebra: Algebra, a: Array, b: Array) -> Array:
    """Inner products of rows of vectors."""
    return np.asarray(np.einsum("...i,ij,...j->...", a, metric(algebra), b))


__all__ = [
    "EPS",
    "Sets",
    "algebraic_sphere",
    "as_sets",
    "metric",
    "normalize_vectors",
    "positions",
    "products",
    "vectors",
]
