"""Lines, circles, planes and spheres through many points: least squares of the distances, batched, with statuses.

Lines and planes come from principal axes; circles and spheres start from the algebraic fit in conformal coordinates and
are refined to the geometric one. The machinery is in `fitting` and `descent`, the formulas in `formulas.objects.fits`.
"""

from __future__ import annotations

from typing import Any, Literal, TypeAlias, overload

import numpy as np
from numpy.typing import NDArray

from ...common.validation import as_bool
from ...core.multivector import Multivector
from ...dispatch.formulas import ArrayOperand, evaluate
from ...dispatch.item_statuses import invalidate_nonfinite, raise_first
from ...status import Status
from .algebraic import Sets, algebraic_sphere, as_sets, vectors
from .geometric import CircleModel, SphereModel, refine

Array = NDArray[np.float64]
Codes = NDArray[np.uint8]
#: Objects, and the root of the mean of the squared distances of each.
WithResidual: TypeAlias = tuple[Multivector, Array]


@overload
def fit_line(points: Any, weights: Any = None, rms: Literal[False] = False, strict: bool = False) -> Multivector: ...


@overload
def fit_line(points: Any, weights: Any = None, *, rms: Literal[True], strict: bool = False) -> WithResidual: ...


def fit_line(points: Any, weights: Any = None, rms: bool = False, strict: bool = False) -> Multivector | WithResidual:
    """The line with the least sum of squared distances from points.

    Parameters
    ----------
    points : array (..., n, 3), or Multivector (..., n)
        Sets of positions, or points of CGA. n is at least 1.
    weights : array, optional
        Not negative; broadcasts with (..., n).
    rms : bool
        Also return the root of the weighted mean of the squared distances.
    strict : bool
        Raise `SingularError` for the first set without a line.

    Returns
    -------
    Multivector, shape (...), or (Multivector, array (...))
        Unit lines that run from the side of the first point to that of the last. `SINGULAR`: all points are one.
        `NOT_UNIQUE`: no direction is longer than all others; one of the longest. `INVALID`: a point is not finite,
        or a weight is negative, or all are zero.

    Notes
    -----
    Coordinates count as correct to rounding: structure below 64 rounding units of the coordinates is none.
    """
    sets = as_sets(points, weights)
    sigma, axes = sets.axes()
    direction = _orient(axes[:, 0], sets.local[:, -1] - sets.local[:, 0])
    position = sets.origin + sets.unit[:, None] * sets.middle
    kind = sets.algebra.kind("euclidean")
    line = evaluate(
        sets.algebra,
        "conformal.line",
        ArrayOperand(position, kind, "point"),
        ArrayOperand(direction, kind, "direction"),
    )
    status = _status(
        sets,
        (sigma[:, 0] <= sets.floor, Status.SINGULAR),
        (_is_tied(sigma, 0) | _is_near_tie(sets, sigma, 0), Status.NOT_UNIQUE),
    )
    residual = np.sqrt(sigma[:, 1] ** 2 + sigma[:, 2] ** 2) * sets.unit
    return _assemble(sets, line.value, status, residual, rms, strict, "fit_line")


@overload
def fit_plane(points: Any, weights: Any = None, rms: Literal[False] = False, strict: bool = False) -> Multivector: ...


@overload
def fit_plane(points: Any, weights: Any = None, *, rms: Literal[True], strict: bool = False) -> WithResidual: ...


def fit_plane(points: Any, weights: Any = None, rms: bool = False, strict: bool = False) -> Multivector | WithResidual:
    """The plane with the least sum of squared distances from points.

    Parameters as for `fit_line`.

    Returns
    -------
    Multivector, shape (...), or (Multivector, array (...))
        Unit planes about whose normal the points turn counter-clockwise in their order. `NOT_UNIQUE`: the points are on
        a line; the plane through it whose normal is nearest the coordinate axis that is most across it. Also if no
        direction is shorter than all others: one of the shortest. `SINGULAR`: all points are one. `INVALID` as there.
    """
    sets = as_sets(points, weights)
    sigma, axes = sets.axes()
    straight = (sigma[:, 1] <= sets.floor) & (sigma[:, 0] > sets.floor)
    normal = np.where(straight[:, None], _across(axes[:, 0]), axes[:, 2])
    normal = _orient(normal, _turning(sets.local))
    # the dual plane about the local origin, then moved: offsets far away keep their digits
    local = np.zeros((len(normal), 5))
    local[:, :3] = normal
    local[:, 4] = (normal * sets.middle).sum(-1)
    status = _status(
        sets,
        (sigma[:, 0] <= sets.floor, Status.SINGULAR),
        (straight | _is_tied(sigma, 1) | _is_near_tie(sets, sigma, 1), Status.NOT_UNIQUE),
    )
    plane = evaluate(sets.algebra, "fits.placed_plane", vectors(sets.algebra, local), *_local_frame(sets))
    return _assemble(sets, plane.value, status, sigma[:, 2] * sets.unit, rms, strict, "fit_plane")


@overload
def fit_circle(points: Any, weights: Any = None, rms: Literal[False] = False, strict: bool = False) -> Multivector: ...


@overload
def fit_circle(points: Any, weights: Any = None, *, rms: Literal[True], strict: bool = False) -> WithResidual: ...


def fit_circle(points: Any, weights: Any = None, rms: bool = False, strict: bool = False) -> Multivector | WithResidual:
    """The circle with the least sum of squared distances from points in space.

    Parameters as for `fit_line`.

    Returns
    -------
    Multivector, shape (...), or (Multivector, array (...))
        Unit circles about whose normal the points turn counter-clockwise in their order. `SINGULAR`: the points are on
        a line, or one; `NOT_CONVERGED`: no minimum was found; `INVALID` as there. Arcs that are straight but for noise
        give circles of a large radius.

    Notes
    -----
    The minimum nearest to the circle that Pratt's algebraic fit finds in the plane of the points.
    """
    sets = as_sets(points, weights)
    sigma, axes = sets.axes()
    straight = sigma[:, 1] <= sets.floor
    unknowns, cost, converged = _circle(sets, axes, ~straight)
    flip = _side(unknowns[:, 5:8], _turning(sets.local))
    s, p = vectors(sets.algebra, unknowns[:, :5]), vectors(sets.algebra, unknowns[:, 5:] * flip)
    circle = evaluate(sets.algebra, "fits.placed_circle", s, p, *_local_frame(sets))
    status = _status(sets, (straight, Status.SINGULAR), (~converged, Status.NOT_CONVERGED))
    return _assemble(sets, circle.value, status, np.sqrt(cost) * sets.unit, rms, strict, "fit_circle")


@overload
def fit_sphere(points: Any, weights: Any = None, rms: Literal[False] = False, strict: bool = False) -> Multivector: ...


@overload
def fit_sphere(points: Any, weights: Any = None, *, rms: Literal[True], strict: bool = False) -> WithResidual: ...


def fit_sphere(points: Any, weights: Any = None, rms: bool = False, strict: bool = False) -> Multivector | WithResidual:
    """The sphere with the least sum of squared distances from points.

    Parameters as for `fit_line`.

    Returns
    -------
    Multivector, shape (...), or (Multivector, array (...))
        Outward unit spheres. `NOT_UNIQUE`: the points are on a circle (three always are); the smallest sphere through
        it. `SINGULAR`: they are on a line or a plane, which no sphere fits as well; `NOT_CONVERGED`: no minimum was
        found; `INVALID` as there. Points on a plane but for noise give spheres of a large radius.

    Notes
    -----
    The minimum nearest to Pratt's algebraic fit, which is the least sum of (S* . X)^2 over unit spheres S.
    """
    sets = as_sets(points, weights)
    algebra = sets.algebra
    sigma, axes = sets.axes()
    flat, straight = sigma[:, 2] <= sets.floor, sigma[:, 1] <= sets.floor
    unknowns, cost = np.full((len(flat), 5), np.nan), np.full(len(flat), np.nan)
    converged, round_ = np.zeros(len(flat), bool), np.zeros(len(flat), bool)
    solid = np.flatnonzero(~flat & sets.valid)
    if len(solid):
        xyz, weight = sets.local[solid], sets.weight[solid]
        start = algebraic_sphere(algebra, xyz, weight, np.broadcast_to(np.eye(5), (len(solid), 5, 5)))
        unknowns[solid], cost[solid], converged[solid] = refine(SphereModel(algebra), start, xyz, weight)
    if (flat & ~straight).any():  # the sphere about a circle's center, if there is a circle
        circles, circle_cost, found = _circle(sets, axes, flat & ~straight)
        round_ = flat & ~straight & found & (np.sqrt(circle_cost) <= sets.floor)
        unknowns[round_], cost[round_], converged[round_] = circles[round_, :5], circle_cost[round_], True
    status = _status(
        sets,
        (flat & ~round_, Status.SINGULAR),
        (~converged, Status.NOT_CONVERGED),
        (round_, Status.NOT_UNIQUE),
    )
    sphere = evaluate(algebra, "fits.placed_sphere", vectors(algebra, unknowns), *_local_frame(sets))
    return _assemble(sets, sphere.value, status, np.sqrt(cost) * sets.unit, rms, strict, "fit_sphere")


# -- pieces ------------------------------------------------------------------------------------------------


def _circle(sets: Sets, axes: Array, selection: NDArray[np.bool_]) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Unknowns (s, p), cost and convergence; NaN for sets that are not selected."""
    unknowns, cost = np.full((len(selection), 10), np.nan), np.full(len(selection), np.nan)
    converged = np.zeros(len(selection), bool)
    some = np.flatnonzero(selection & sets.valid)
    if not len(some):
        return unknowns, cost, converged
    xyz, weight, frame, middle = sets.local[some], sets.weight[some], axes[some], sets.middle[some]
    normal = frame[:, 2]
    height = (normal * middle).sum(-1)
    flat = xyz - (np.einsum("ki,kni->kn", normal, xyz) - height[:, None])[..., None] * normal[:, None]
    plane = np.zeros((len(some), 5))
    plane[:, :3], plane[:, 4] = normal, height
    # spheres about points of the plane: their duals are orthogonal to its own; about the mean, for the basis
    basis = np.zeros((len(some), 5, 4))
    basis[:, :3, 0], basis[:, :3, 1] = frame[:, 0], frame[:, 1]
    basis[:, 3, 2] = basis[:, 4, 3] = 1.0
    shifted = flat - middle[:, None]
    s = algebraic_sphere(sets.algebra, shifted, weight, basis)
    moved = evaluate(
        sets.algebra, "fits.translate_sphere", vectors(sets.algebra, s), _local_frame(sets)[0]._replace(value=middle)
    )
    model = CircleModel(sets.algebra)
    start = model.project(np.concatenate([moved.value._data, plane], -1))
    unknowns[some], cost[some], converged[some] = refine(model, start, xyz, weight)
    return unknowns, cost, converged


def _local_frame(sets: Sets) -> tuple[ArrayOperand, ArrayOperand]:
    """Origin and unit of local coordinates."""
    return ArrayOperand(sets.origin, sets.algebra.kind("euclidean"), "the origin"), ArrayOperand(
        sets.unit, 0, "the unit"
    )


def _turning(local: Array) -> Array:
    """Twice the vector area of the polygon of the points: the normal about which they turn."""
    return np.asarray(np.cross(local, np.roll(local, -1, axis=1)).sum(1))


def _side(direction: Array, guide: Array) -> Array:
    """+1 or -1 (k, 1) that turns a direction towards a guide; where that is across, its first sizeable entry counts."""
    dot = (direction * guide).sum(-1)
    size = np.abs(direction).max(-1, keepdims=True)
    first = np.argmax(np.abs(direction) >= size / 2, -1)
    tie = np.take_along_axis(direction, first[:, None], -1)[:, 0]
    unclear = np.abs(dot) <= 64 * np.finfo(float).eps * np.abs(guide).max(-1, initial=0.0)
    return np.where(np.where(unclear, tie, dot) < 0, -1.0, 1.0)[:, None]


def _orient(direction: Array, guide: Array) -> Array:
    return direction * _side(direction, guide)


def _across(direction: Array) -> Array:
    """Unit vectors across a direction, in its plane with the coordinate axis that is most across it."""
    axis = np.eye(3)[np.argmin(np.abs(direction), -1)]
    rest = axis - (axis * direction).sum(-1, keepdims=True) * direction
    return np.asarray(rest / np.linalg.norm(rest, axis=-1, keepdims=True))


def _is_tied(sigma: Array, i: int) -> NDArray[np.bool_]:
    """Test whether two singular values are equal to rounding."""
    return np.asarray(sigma[:, i] - sigma[:, i + 1] <= 64 * np.finfo(float).eps * sigma[:, 0])


def _is_near_tie(sets: Sets, sigma: Array, i: int) -> NDArray[np.bool_]:
    """Test whether they differ by less than the rounding of the points."""
    return np.asarray(sigma[:, i] - sigma[:, i + 1] <= sets.floor)


def _status(sets: Sets, *cases: tuple[NDArray[np.bool_], Status]) -> Codes:
    """The first case that holds for each set."""
    status = np.full(len(sets.valid), np.uint8(Status.OK))
    for mask, code in reversed(cases):
        status[mask] = code
    status[~sets.valid] = Status.INVALID
    return status


def _assemble(
    sets: Sets, x: Multivector, status: Codes, residual: Array, rms: bool, strict: bool, name: str
) -> Multivector | WithResidual:
    """The fitted objects in the shape of the batch, with their statuses, and their residuals if asked for."""
    answered = (status == Status.OK) | (status == Status.NOT_UNIQUE)
    data = np.where(answered[:, None], x._data, np.nan).astype(sets.dtype)
    fitted = x._make(sets.algebra.type_of(x.kind, data.dtype), data, status.shape, status if status.any() else None)
    fitted = invalidate_nonfinite(fitted).reshape(sets.lead)
    if as_bool(strict, "strict"):
        raise_first(fitted._status, name)
    if not as_bool(rms, "rms"):
        return fitted
    return fitted, np.where(answered, residual, np.nan).astype(sets.dtype).reshape(sets.lead)[()]


__all__ = ["fit_circle", "fit_line", "fit_plane", "fit_sphere"]
