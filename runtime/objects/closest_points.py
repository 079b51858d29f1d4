"""The points closest to lines, planes and points in the least-squares sense (thesis 3.12.4).

Two lines are a formula; sets are stacked equations whose rows `codegen.formulas.motions.screws` gives.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.errors import AlgebraMismatchError, GradeError, InputError, ShapeError
from ..common.deprecation import renamed_keywords
from ..common.validation import as_bool, broadcast_to, real_array
from ..core.kind_constraints import tolerance
from ..core.multivector import Algebra, Multivector
from ..dispatch.formulas import ArrayOperand, evaluate
from ..dispatch.item_statuses import invalidate_nonfinite, raise_first
from ..status import Status
from .arguments import as_objects, same_sort

Array = NDArray[Any]


@renamed_keywords(first="X", second="Y")
def closest_point(X: Any, Y: Any = None, *, weights: Any = None, axis: int = 0, strict: bool = False) -> Multivector:
    """The point that is closest to lines (and planes, points) in the least-squares sense, a point of CGA.

    Parameters
    ----------
    X : Multivector or sequence
        Unit lines. Without ``Y``: the set, along ``axis`` of one batch, or a list, in which lines, planes and
        points may be mixed.
    Y : Multivector, optional
        Lines too: the point of each pair, halfway on the common perpendicular. Shapes broadcast.
    weights : array, optional
        One weight per object of a set, not negative; broadcasts with the set's shape.
    axis : int
        Axis of a batch that runs over the set.

    Returns
    -------
    Multivector
        Of pairs: as many points; of a set (..., n, ...): its shape without ``axis``. `NOT_UNIQUE` where the objects
        leave a line or plane of points equally good: for two parallel lines, the point of the middle line nearest the
        origin; for sets, the one nearest the mean of the objects' own points nearest the origin.
        `INVALID`: an object of the set is no unit object, or the weights are negative or sum to zero.

    Raises
    ------
    InputError, GradeError, ShapeError
        For no objects at all, objects that are neither lines, planes nor points, weights of another shape.

    Notes
    -----
    Thesis 3.12.4; the printed formula has lost a "+ n0". Pairs are the intersection of the axes of L1* +- L2*, without
    loss for lines that are nearly parallel; sets minimise the sum of weighted squared distances by singular values.
    """
    if Y is not None:
        if weights is not None:
            raise InputError("weights are those of a set of objects; two lines meet halfway.")
        a, b = (as_lines(x, what) for x, what in ((X, "the first lines"), (Y, "the second lines")))
        same_sort(a, b)
        point = invalidate_nonfinite(evaluate(a.algebra, "screws.closest_point", a, b).value)
    else:
        point = _closest_to_set(X, weights, axis)
    if as_bool(strict, "strict"):
        raise_first(point._status, "closest_point")
    return point  # type: ignore[no-any-return]


# -- sets --------------------------------------------------------------------------------------------------


def _closest_to_set(objects: Any, weights: Any, axis: int) -> Multivector:
    parts = list(objects) if isinstance(objects, (list, tuple)) else [objects]
    if not parts:
        raise InputError("there are no objects: the list is empty.")
    names = [f"object {i}" for i in range(len(parts))] if len(parts) > 1 else ["the objects"]
    checked = [as_objects(x, name, (1, 3, 4)) for x, name in zip(parts, names, strict=True)]
    if isinstance(objects, (list, tuple)):
        checked = [x.reshape(-1) for x in checked]
        axis = 0
    algebra = checked[0].algebra
    if any(x.algebra is not algebra for x in checked):
        raise AlgebraMismatchError("objects of different algebras do not mix; convert some.")
    for x in checked:
        if not -x.ndim <= axis < x.ndim:
            raise ShapeError(f"the objects have shape {x.shape}, without an axis {axis} to run over.")
    systems = [_system(algebra, x, axis) for x in checked]
    matrix, points, bad = (np.concatenate([s[i] for s in systems], -n) for i, n in ((0, 3), (1, 2), (2, 1)))
    dtype = np.result_type(*(x.dtype for x in checked))
    if not matrix.shape[-3]:
        raise InputError("there are no objects in the set.")
    factor, rejected = _weights(weights, checked, axis, bad.shape)
    xyz, status = _solve_least_squares(matrix, points, factor, bad, tolerance(dtype))
    status[rejected] = Status.INVALID
    xyz[status == Status.INVALID] = np.nan
    position = ArrayOperand(xyz.astype(dtype), algebra.kind("euclidean"), "xyz")
    found: Multivector = evaluate(algebra, "conformal.point", position).value
    return invalidate_nonfinite(found._make(found._type, found._data, found.shape, status))


def _system(algebra: Algebra, x: Multivector, axis: int) -> tuple[Array, Array, Array]:
    """Matrices (..., n, 3, 3) whose product with an offset from the points (..., n, 3) is the way to the objects."""
    if x.kind.name == "plane":
        normal, offset = (_move_axis(v._data, axis) for v in evaluate(algebra, "conformal.plane_parameters", x).values)
        matrix = normal[..., :, None] * normal[..., None, :]
        points = normal * offset
    elif x.kind.name == "line":
        found = evaluate(algebra, "screws.line_equations", x).values
        matrix, points = (_move_axis(plain(v), axis) for v in found)
        matrix = matrix.reshape(*points.shape, 3)
    elif x.kind.name == "point":
        points = _move_axis(plain(evaluate(algebra, "conformal.point_parameters", x).value), axis)
        matrix = np.broadcast_to(np.eye(3), (*points.shape, 3))
    else:
        raise GradeError(f"a {x.kind.name} is neither line, plane nor point; its distances are not linear.")
    return matrix.astype(float), points.astype(float), ~np.isfinite(points).all(-1)


def _move_axis(rows: Array, axis: int) -> Array:
    """The set's axis last but one, before the coefficients."""
    return np.moveaxis(rows, axis if axis >= 0 else axis - 1, -2)


def _weights(weights: Any, checked: Sequence[Multivector], axis: int, shape: tuple[int, ...]) -> tuple[Array, Array]:
    """Square roots of the weights (..., n), and which sets cannot be weighted so."""
    if weights is None:
        return np.ones(shape), np.zeros(shape[:-1], bool)
    given = real_array(weights, "the weights").astype(float)
    if given.ndim > 1 and len(checked) == 1:
        given = np.moveaxis(given, axis, -1)
    given = broadcast_to(given, shape, "weights")
    bad = ~((given >= 0) & np.isfinite(given)).all(-1) | ~(given.sum(-1) > 0)
    return np.sqrt(np.where(bad[..., None], 1.0, given)), bad


def _solve_least_squares(matrix: Array, points: Array, factor: Array, bad: Array, limit: float) -> tuple[Array, Array]:
    """Least squares of the stacked rows about the mean of the points, by singular values.

    (Not by the 3 x 3 matrix of their products: that squares the angle of nearly parallel lines.)
    """
    broken = np.asarray(bad.any(-1))
    with np.errstate(all="ignore"):
        clean = np.where(broken[..., None, None], 0.0, points)
        middle = clean.mean(-2)
        rows = factor[..., None, None] * np.where(broken[..., None, None, None], 0.0, matrix)
        right = (rows @ (clean - middle[..., None, :])[..., None])[..., 0]
        n = rows.shape[-3]
        u, sigma, vt = np.linalg.svd(rows.reshape(*rows.shape[:-3], 3 * n, 3), full_matrices=False)
        kept = sigma > limit * sigma[..., :1]
        heights = (np.swapaxes(u, -1, -2) @ right.reshape(*right.shape[:-2], 3 * n, 1))[..., 0]
        heights = np.where(kept, heights / np.where(kept, sigma, 1.0), 0.0)
        xyz = middle + (np.swapaxes(vt, -1, -2) @ heights[..., None])[..., 0]
    status = np.where(kept.all(-1), np.uint8(Status.OK), np.uint8(Status.NOT_UNIQUE))
    status = np.where(broken, np.uint8(Status.INVALID), status)
    return np.array(xyz), np.array(status, np.uint8)


# -- arguments and results ---------------------------------------------------------------------------------


def as_lines(x: Any, what: str) -> Multivector:
    """Unit lines of CGA; circles are refused."""
    found = as_objects(x, what, (3,))
    if found.kind.name != "line":
        raise GradeError(f"{what} are a {found.kind.name}; lines are needed.")
    return found


def plain(value: Any) -> Array:
    """Coefficients of a result; a scalar's without their axis."""
    rows: Array = value._data if isinstance(value, Multivector) else value
    is_scalar = isinstance(value, Multivector) and value.kind.blades == (0,)
    return rows[..., 0] if is_scalar else rows


__all__ = ["as_lines", "closest_point", "plain"]
