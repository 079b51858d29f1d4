"""Lines at a point where one meets a surface: its reflection, the normal, the tangent (thesis 4.4.2, 4.7, 4.8).

Arguments are checked and statuses completed here; the formulas are in `codegen.formulas.rays`. A line that only
touches is no special case: the normal is that of the surface at the point, not of a meet that rounding may lose.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..arrays import truth
from ..calls import Numbers, call, invalidated, raise_first
from ..errors import SceneError, ShapeError
from ..euclidean import plain
from ..objects.inputs import as_objects
from . import values
from .surfaces import Surface
from .surfaces.evolved import EvolvedSurface
from .surfaces.facets import Facets
from .surfaces.flats import Flat, Plane

if TYPE_CHECKING:
    from ..multivector import Multivector

Array = NDArray[Any]
#: A point this far from a surface or a line is still on it, relative to the size of the numbers they are made of.
TOLERANCE = {np.dtype(np.float64): 1e-9, np.dtype(np.float32): 1e-4}
#: Where a line only touches a surface, rounding moves their meet by the root of its size: a first guess of the normal
#: may come from a point so far away, relative to the same numbers.
NEAR = 1e-3
#: Direction and normal that stand for those of items that are told to be wrong: no second fault is found in them.
HARMLESS = ((1.0, 0.0, 0.0), (0.6, 0.8, 0.0))


def reflect(
    line: Multivector, hit: Multivector, surface: Surface, *, tolerance: float | None = None, strict: bool = False
) -> Multivector:
    """The reflection of lines in a surface: L' = Phi L Phi for the tangent plane Phi at the point where they meet.

    Parameters
    ----------
    line : lines, shapes broadcasting with the points
    hit : points
        Where the lines meet the surface.
    surface : Surface
    tolerance : float, optional
        How far a point may be from the surface and from its line. Default: 1e-9 (float32: 1e-4) of the size of the
        numbers they are made of, which is the distance of the point from the origin and the surface's reach.
    strict : bool
        Raise `SingularError` for the first item without an answer.

    Returns
    -------
    lines
        Through the points, in the direction that reflected light takes; in a tangent line's own where it grazes.
        `INVALID`: the point is not on the surface, or not on the line. `SINGULAR`: the surface has no normal there.

    Raises
    ------
    SceneError, GradeError, ShapeError
        If an argument is no surface, line or point, or shapes do not broadcast.
    """
    return _made("reflected_line", line, hit, surface, tolerance, strict)


def normal_line(
    line: Multivector, hit: Multivector, surface: Surface, *, tolerance: float | None = None, strict: bool = False
) -> Multivector:
    """The normals of a surface where lines meet it: N ~ L' - L.

    Parameters
    ----------
    line, hit, surface, tolerance, strict
        As for `reflect`.

    Returns
    -------
    lines
        Through the points, towards the side that the lines come from. `NOT_UNIQUE`: the line grazes the surface to
        within 1e-9 (float32: 1e-4) of an angle, and rounding may have chosen the side. Otherwise as for `reflect`.
    """
    return _made("normal_line", line, hit, surface, tolerance, strict)


def tangent_line(
    line: Multivector, hit: Multivector, surface: Surface, *, tolerance: float | None = None, strict: bool = False
) -> Multivector:
    """The tangents of a surface in the plane of a line and its reflection: L_T ~ L' + L.

    Parameters
    ----------
    line, hit, surface, tolerance, strict
        As for `reflect`.

    Returns
    -------
    lines
        Through the points, onwards. `SINGULAR`: the line comes along the normal to within 1e-9 (float32: 1e-4) of an
        angle, and no tangent is the one. Otherwise as for `reflect`.
    """
    return _made("tangent_line", line, hit, surface, tolerance, strict)


def _made(
    formula: str, line: Multivector, hit: Multivector, surface: Surface, tolerance: float | None, strict: bool
) -> Multivector:
    if not isinstance(surface, Surface):
        raise SceneError(f"surface is {type(surface).__name__}, which is no Surface.")
    lines, points = _objects(line, "line"), _objects(hit, "point")
    cga = lines.algebra
    kept = np.result_type(lines.dtype, points.dtype)
    allowed = TOLERANCE[kept] if tolerance is None else values.positive(tolerance, "tolerance")
    try:
        shape = np.broadcast_shapes(lines.shape, points.shape)
    except ValueError:
        raise ShapeError(f"lines {lines.shape} and points {points.shape} do not broadcast.") from None
    position = np.broadcast_to(points.astype(np.float64).parameters().xyz, (*shape, 3))
    vector = cga.vector(position, "the point")
    found = call(cga, "rays.line_from", vector, lines.astype(np.float64)).values
    direction, off_line = plain(found[0]), found[1][..., 0]
    slack = allowed * (np.linalg.norm(position, axis=-1) + reach(surface)) if tolerance is None else allowed
    distance, normal = contact(surface, position, direction, slack)
    with np.errstate(invalid="ignore"):
        off = ~((distance <= slack) & (off_line <= slack))
    direction, normal = (np.where(off[..., None], x, y) for x, y in zip(HARMLESS, (direction, normal), strict=True))
    operands = [vector, cga.vector(direction, "the line's direction"), cga.vector(normal, "the normal")]
    if formula != "reflected_line":
        operands.append(Numbers(TOLERANCE[kept], 0, "least"))
    made: Multivector = cga.made(f"rays.{formula}", *operands)
    made = invalidated(made, off).astype(kept)
    if truth(strict, "strict"):
        raise_first(made._status, formula)
    return made


def _objects(value: Any, name: str) -> Multivector:
    found = as_objects(value, f"the {name}s")
    if found.kind.name != name:
        raise SceneError(f"a {name} is needed, not {found.kind.name}.")
    return found


def reach(surface: Surface) -> float:
    """Size of the numbers that points of a surface are made of; a plane has none of its own, and counts from 1."""
    if isinstance(surface, Plane):
        return max(1.0, abs(surface.offset))
    if isinstance(surface, EvolvedSurface):
        pieces = surface.segments
        return float(np.max(np.abs(pieces.center).max(1) + pieces.size))
    if isinstance(surface, Facets):
        return float(np.abs(surface.vertices).max(initial=0.0))
    return float(np.abs(surface.parameters).max(initial=0.0))


def contact(surface: Surface, position: Array, direction: Array, slack: Array | float) -> tuple[Array, Array]:
    """Distance of positions (..., 3) from a surface along its normal there, and these unit normals.

    Planes, spheres and discs know. Elsewhere lines through the position are asked: the given one and, where it does
    not find the surface close by, two across it, of which one crosses any surface that the first touches. The normal
    that they find leads to the surface's own, and to how far it is.
    """
    if isinstance(surface, Flat):
        return surface.contact(position)
    shape = position.shape[:-1]
    position, direction = position.reshape(-1, 3), direction.reshape(-1, 3)
    limit = np.broadcast_to(slack, shape).reshape(-1)
    near = NEAR * (np.linalg.norm(position, axis=-1) + reach(surface))
    distance, normal = _nearest(surface, position, direction)
    for probe in _across(direction):
        _ask(surface, position, probe, ~(distance <= near), distance, normal, distance.copy())
    _ask(surface, position, normal.copy(), distance <= near, distance, normal, np.maximum(distance, limit))
    return distance.reshape(shape), normal.reshape(*shape, 3)


def _ask(
    surface: Surface, position: Array, probe: Array, chosen: Array, distance: Array, normal: Array, below: Array
) -> None:
    """Look along the probes of the chosen items; distances and normals change where one comes below a limit."""
    places = np.flatnonzero(chosen & np.isfinite(probe).all(-1))
    if not len(places):
        return
    away, facing = _nearest(surface, position[places], probe[places])
    better = away <= below[places]
    distance[places[better]], normal[places[better]] = away[better], facing[better]


def _nearest(surface: Surface, position: Array, direction: Array) -> tuple[Array, Array]:
    """Distance along lines to the surface, infinite where they miss it, and the normals there."""
    found = surface.intersect(position, direction)
    away = np.where(np.isfinite(found.normal).all(-1), np.abs(found.t), np.inf)
    first = np.argmin(away, axis=-1)[:, None]
    normal = np.take_along_axis(found.normal, first[..., None], axis=1)[:, 0]
    return np.take_along_axis(away, first, axis=1)[:, 0], normal


def _across(direction: Array) -> tuple[Array, Array]:
    """Two unit vectors square to unit directions (n, 3) and to each other."""
    least = np.eye(3)[np.abs(direction).argmin(-1)]
    first = np.cross(direction, least)
    with np.errstate(invalid="ignore"):
        first = first / np.linalg.norm(first, axis=-1, keepdims=True)
    return first, np.cross(direction, first)


__all__ = ["normal_line", "reflect", "tangent_line"]
