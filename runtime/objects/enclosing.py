"""The smallest sphere around spheres, circles, point pairs and points (thesis 4.5.1), and never one that is too small.

Two are a formula (`formulas.objects.enclosing`). More are a sequence of smallest spheres around at most five of them.
"""

from __future__ import annotations

from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.errors import AlgebraMismatchError, GradeError, InputError
from ..common.validation import as_axis, as_bool
from ..core.multivector import Algebra, Multivector
from ..dispatch.formulas import ArrayOperand, evaluate
from ..dispatch.item_statuses import invalidate_nonfinite, raise_first
from ..status import Status
from .arguments import as_objects

Array = NDArray[np.float64]
EPS = float(np.finfo(np.float64).eps)
#: Steps of the exchange; each adds the farthest sphere. 5 to 15 are usual.
MOST_STEPS = 200
#: A sphere that sticks out by less, relative to the radius, is inside: the final radius covers it.
OUTSIDE = 64 * EPS
#: How far the radius is rounded up, in units of the last place of the center and of the radius.
MARGIN = 8


def enclosing_sphere(spheres: Any, axis: int = 0, strict: bool = False) -> Multivector:
    """The smallest sphere around spheres; circles, point pairs and points count as the smallest spheres around them.

    Parameters
    ----------
    spheres : Multivector or sequence
        A batch, whose ``axis`` runs over the set, or a list of objects of any of these kinds. Inside-out spheres
        count by their surface.
    axis : int
        Axis of a batch that runs over the set.
    strict : bool
        Raise `SingularError` for the first set that no sphere encloses.

    Returns
    -------
    Multivector
        Outward spheres, in the batch's shape without ``axis``: of a list, one. They hold every sphere of their set,
        rounding of their own coefficients included, and are larger than the smallest by rounding only: relative to
        the radius and to the distance from the origin. Points that are all the same give a sphere of the size of
        that rounding. `INVALID`: an object of the set is none; `SINGULAR`: a line or plane is among them.

    Raises
    ------
    InputError, ShapeError, GradeError
        For an empty set, or objects that are no multivectors of these kinds.

    Notes
    -----
    Thesis 4.5.1 for two, whose last step is imaginary as printed. Around more, successive spheres around two would be
    up to half too large: instead the farthest sphere is exchanged into a support of at most four (Fischer and Gaertner
    2003 for what a support is), until none is outside.
    """
    algebra, center, radius, bad, unbounded, dtype = _spheres_of(spheres, axis)
    lead, n = bad.shape[:-1], bad.shape[-1]
    broken = np.asarray(bad.any(-1))
    open_ = np.asarray(unbounded.any(-1)) & ~broken
    skip = (broken | open_)[..., None]
    center = np.where(skip[..., None], 0.0, center).reshape(-1, n, 3)
    radius = np.where(skip, 1.0, radius).reshape(-1, n)
    middle = _around_two(algebra, center, radius) if n == 2 else _around_many(center, radius)
    position = middle.astype(dtype)
    size = _safe_radius(position, center, radius, dtype)
    operands = ArrayOperand(position, algebra.kind("euclidean"), "center"), ArrayOperand(size, 0, "radius")
    sphere: Multivector = evaluate(algebra, "conformal.sphere", *operands).value
    status = np.where(broken, np.uint8(Status.INVALID), np.where(open_, np.uint8(Status.SINGULAR), np.uint8(0)))
    status = status.ravel()
    data = np.where((status != Status.OK)[:, None], np.nan, sphere._data).astype(dtype)
    found = sphere._make(sphere._type, data, status.shape, status if status.any() else None)
    found = invalidate_nonfinite(found).reshape(lead)
    if as_bool(strict, "strict"):
        raise_first(found._status, "enclosing_sphere")
    return found


# -- what is to be enclosed --------------------------------------------------------------------------------


def _spheres_of(
    spheres: Any, axis: int
) -> tuple[Algebra, Array, Array, NDArray[np.bool_], NDArray[np.bool_], np.dtype[Any]]:
    """Centers (..., n, 3) and radii (..., n) of all objects, and masks of the invalid and of the unbounded ones."""
    listed = isinstance(spheres, (list, tuple))
    parts = list(spheres) if listed else [spheres]
    if not parts:
        raise InputError("there is nothing to enclose: the list is empty.")
    checked = [as_objects(x, f"object {i}" if listed else "the spheres") for i, x in enumerate(parts)]
    algebra = checked[0].algebra
    if any(x.algebra is not algebra for x in checked):
        raise AlgebraMismatchError("objects of different algebras do not mix; convert some.")
    if algebra.kind("euclidean").size != 3:
        raise GradeError(f"spheres are those of cga3d; {algebra.name} has none.")
    checked = [x.reshape(-1) if listed or not x.shape else x for x in checked]
    axis = 0 if listed else axis
    for x in checked:
        axis = as_axis(axis, x.shape, "the spheres have")
    balls = [_balls(algebra, x) for x in checked]
    center = np.concatenate([np.moveaxis(c, axis, -2) for c, _, _ in balls], -2)
    radius = np.concatenate([np.moveaxis(r, axis, -1) for _, r, _ in balls], -1)
    flat = np.concatenate([np.moveaxis(f, axis, -1) for _, _, f in balls], -1)
    if not flat.shape[-1]:
        raise InputError("there is nothing to enclose: the set is empty.")
    bad = ~flat & ~(np.isfinite(center).all(-1) & np.isfinite(radius))
    return algebra, center, radius, bad, flat, np.result_type(*(x.dtype for x in checked))


def _balls(algebra: Algebra, x: Multivector) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Centers and radii of the smallest spheres around objects, and which have none because they are flat."""
    name = x.kind.name
    given = np.isfinite(x._data).all(-1)
    if name in ("line", "plane"):
        return np.full((*x.shape, 3), np.nan), np.full(x.shape, np.nan), given
    outcome = evaluate(algebra, f"conformal.{name}_parameters", x)
    values = [v._data.astype(float) for v in outcome.values]
    if name == "point":
        return values[0], np.where(given, 0.0, np.nan), np.zeros(x.shape, bool)
    if name == "point_pair":
        center, radius = (values[0] + values[1]) / 2, np.linalg.norm(values[1] - values[0], axis=-1) / 2
    else:
        center, radius = values[0], values[1 if name == "sphere" else 2][..., 0]
    flat = given & (outcome.status == Status.SINGULAR)
    return center, radius, flat


def _safe_radius(position: Array, center: Array, radius: Array, dtype: np.dtype[Any]) -> Array:
    """Radius that the farthest sphere needs about a rounded center, with a margin for rounding of the result."""
    at = position.astype(float)
    reach = (np.linalg.norm(center - at[:, None], axis=-1) + radius).max(-1)
    unit = MARGIN * float(np.finfo(dtype).eps)
    large = np.abs(at).max(-1)
    size = reach * (1 + unit) + unit * large
    return np.asarray(np.maximum(size, np.finfo(dtype).tiny)).astype(dtype)


# -- centers of smallest spheres ---------------------------------------------------------------------------


def _around_two(algebra: Algebra, center: Array, radius: Array) -> Array:
    kind = algebra.kind("euclidean")
    c1, c2 = (ArrayOperand(np.ascontiguousarray(center[:, i]), kind, "center") for i in (0, 1))
    r1, r2 = (ArrayOperand(np.ascontiguousarray(radius[:, i]), 0, "radius") for i in (0, 1))
    middle: Array = evaluate(algebra, "enclosing.enclosing_pair", c1, r1, c2, r2).values[0]._data
    return middle


def _around_many(center: Array, radius: Array) -> Array:
    """Centers (k, 3) of the smallest spheres around n spheres each, all sets at once."""
    k, n = radius.shape
    if not k:
        return np.zeros((0, 3))
    rows = np.arange(k)
    first = np.argmax(radius, -1)
    origin = center[rows, first]
    center = center - origin[:, None]  # so that distance from the origin costs no digits
    position, size = np.zeros((k, 3)), radius[rows, first]
    support = np.repeat(first[:, None], 4, 1)
    live = rows
    for _ in range(MOST_STEPS):
        reach = np.linalg.norm(center[live] - position[live, None], axis=-1) + radius[live]
        far = np.argmax(reach, -1)
        outside = reach[np.arange(len(live)), far] > size[live] * (1 + OUTSIDE)
        live, far = live[outside], far[outside]
        if not len(live):
            break
        some = np.concatenate([support[live], far[:, None]], -1)
        where, needed, chosen = _around_five(
            np.take_along_axis(center[live], some[..., None], 1), np.take_along_axis(radius[live], some, 1)
        )
        grown = needed > size[live]  # not so where rounding is all that is left
        live, some = live[grown], some[grown]
        position[live], size[live] = where[grown], needed[grown]
        support[live] = np.take_along_axis(some, chosen[grown], 1)
    return np.asarray(position + origin)


#: Supports that hold the fifth sphere, by size, as places among five.
_SUPPORTS = [np.array([(4, *rest) for rest in combinations(range(4), q)]) for q in range(4)]
#: The same, each repeated to four places.
_PADDED = np.array([[row[i % len(row)] for i in range(4)] for rows in _SUPPORTS for row in rows.tolist()])


def _around_five(center: Array, radius: Array) -> tuple[Array, Array, NDArray[np.int64]]:
    """Smallest spheres around five with the fifth on them: center, radius, and the places of a support of four.

    Of every possible support the sphere that touches it from outside is made; around its center, the five need some
    radius, which is least for the right one.
    """
    middles = [_touching(center[:, rows], radius[:, rows]) for rows in _SUPPORTS]
    candidates = np.concatenate([one for one, _ in middles] + [other for _, other in middles], 1)
    with np.errstate(all="ignore"):
        needed = (np.linalg.norm(candidates[:, :, None] - center[:, None], axis=-1) + radius[:, None]).max(-1)
    needed = np.where(np.isfinite(needed), needed, np.inf)
    best = np.argmin(needed, -1)
    rows = np.arange(len(best))
    return candidates[rows, best], needed[rows, best], _PADDED[best % len(_PADDED)]


def _touching(center: Array, radius: Array) -> tuple[Array, Array]:
    """Centers (k, m, 3) of the two spheres that q spheres (k, m, q) touch from inside, in the span of their centers.

    With d_i = c_i - c_0, e_i = r_i - r_0, center c_0 + y and radius r_0 + h: d_i . y = (d_i^2 - e_i^2)/2 + e_i h gives
    y = a + h b, and y^2 = h^2 the excess h.
    """
    d, e = center[..., 1:, :] - center[..., :1, :], radius[..., 1:] - radius[..., :1]
    base = center[..., 0, :]
    if not d.shape[-2]:
        return base, base
    inverse = np.linalg.pinv(d)
    with np.errstate(all="ignore"):
        a = (inverse @ (((d * d).sum(-1) - e * e) / 2)[..., None])[..., 0]
        b = (inverse @ e[..., None])[..., 0]
        square, mixed, lead = (a * a).sum(-1), (a * b).sum(-1), 1 - (b * b).sum(-1)
        root = np.sqrt(np.maximum(mixed * mixed + lead * square, 0.0))
        q = mixed + np.copysign(root, mixed)  # lead h^2 - 2 mixed h - square = 0, without a difference
        excesses = q / lead, -square / q
    return base + a + excesses[0][..., None] * b, base + a + excesses[1][..., None] * b


__all__ = ["enclosing_sphere"]
