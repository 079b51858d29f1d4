"""Reflected line, normal line and tangent line where a line meets a surface (thesis 4.4.2, 4.7, 4.8).

Arguments are checked and statuses completed here; the formulas are in `codegen.formulas.rays.rays`. A tangent line
needs no special case: the normal is that of the surface at the point, not of an intersection that rounding may lose.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...common.validation import as_bool, as_instance
from ...core.geometry.euclidean import plain
from ...dispatch.formulas import ArrayOperand, evaluate
from ...dispatch.item_statuses import invalidate, raise_first
from ...errors import SceneError, ShapeError
from ...objects.arguments import as_objects
from ...plot.tessellation import across
from ..scene import values
from ..surfaces import Surface
from ..surfaces.evolved import EvolvedSurface
from ..surfaces.planes_spheres_discs import Flat, Plane
from ..surfaces.triangles import Facets

if TYPE_CHECKING:
    from ...core.multivector import Multivector

Array = NDArray[Any]
#: Largest distance of a point from a surface or a line that it lies on, relative to the magnitude of their numbers.
TOLERANCE = {np.dtype(np.float64): 1e-9, np.dtype(np.float32): 1e-4}
#: Largest distance, relative to the same numbers, of the point that gives a first estimate of the normal: rounding
#: displaces the intersection with a tangent line by the square root of its own size.
NEAR = 1e-3
#: Direction and normal that replace those of invalid items, so that the formula finds no second fault in them.
HARMLESS = ((1.0, 0.0, 0.0), (0.6, 0.8, 0.0))


def reflect(
    line: Multivector, hit: Multivector, surface: Surface, *, tolerance: float | None = None, strict: bool = False
) -> Multivector:
    """Reflect lines in a surface: L' = Phi L Phi for the tangent plane Phi at the point where they meet.

    Parameters
    ----------
    line : lines, shapes broadcasting with the points
    hit : points
        Points where the lines meet the surface.
    surface : Surface
    tolerance : float, optional
        Largest distance of a point from the surface and from its line. Default: 1e-9 (float32: 1e-4) of the magnitude
        of their numbers: the distance of the point from the origin plus the surface's largest coordinate.
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
        If an argument is not a surface, line or point, or shapes do not broadcast.
    """
    return _line_at_hit("reflected_line", line, hit, surface, tolerance, strict)


def normal_line(
    line: Multivector, hit: Multivector, surface: Surface, *, tolerance: float | None = None, strict: bool = False
) -> Multivector:
    """Compute normal lines of a surface where lines meet it: N ~ L' - L.

    Parameters
    ----------
    line, hit, surface, tolerance, strict
        As for `reflect`.

    Returns
    -------
    lines
        Through the points, towards the side that the lines come from. `NOT_UNIQUE`: the line is tangent to the surface
        within an angle of 1e-9 (float32: 1e-4), and rounding may have chosen the side. Otherwise as for `reflect`.
    """
    return _line_at_hit("normal_line", line, hit, surface, tolerance, strict)


def tangent_line(
    line: Multivector, hit: Multivector, surface: Surface, *, tolerance: float | None = None, strict: bool = False
) -> Multivector:
    """Compute tangent lines of a surface in the plane of a line and its reflection: L_T ~ L' + L.

    Parameters
    ----------
    line, hit, surface, tolerance, strict
        As for `reflect`.

    Returns
    -------
    lines
        Through the points, forwards. `SINGULAR`: the line is parallel to the normal within an angle of 1e-9 (float32:
        1e-4), and the tangent is not unique. Otherwise as for `reflect`.
    """
    return _line_at_hit("tangent_line", line, hit, surface, tolerance, strict)


def _line_at_hit(
    formula: str, line: Multivector, hit: Multivector, surface: Surface, tolerance: float | None, strict: bool
) -> Multivector:
    as_instance(surface, "surface", Surface, error=SceneError)
    lines, points = _objects(line, "line"), _objects(hit, "point")
    cga = lines.algebra
    dtype = np.result_type(lines.dtype, points.dtype)
    allowed = TOLERANCE[dtype] if tolerance is None else values.positive(tolerance, "tolerance")
    try:
        shape = np.broadcast_shapes(lines.shape, points.shape)
    except ValueError:
        raise ShapeError(f"lines {lines.shape} and points {points.shape} do not broadcast.") from None
    position = np.broadcast_to(points.astype(np.float64).parameters().xyz, (*shape, 3))
    vector = cga.spatial(position, "the point")
    line_parts = evaluate(cga, "rays.line_from", vector, lines.astype(np.float64)).values
    direction, off_line = plain(line_parts[0]), line_parts[1][..., 0]
    slack = allowed * (np.linalg.norm(position, axis=-1) + magnitude(surface)) if tolerance is None else allowed
    distance, normal = contact(surface, position, direction, slack)
    with np.errstate(invalid="ignore"):
        off = ~((distance <= slack) & (off_line <= slack))
    direction, normal = (np.where(off[..., None], x, y) for x, y in zip(HARMLESS, (direction, normal), strict=True))
    operands = [vector, cga.spatial(direction, "the line's direction"), cga.spatial(normal, "the normal")]
    if formula != "reflected_line":
        operands.append(ArrayOperand(TOLERANCE[dtype], 0, "least"))
    result: Multivector = cga.construct(f"rays.{formula}", *operands)
    result = invalidate(result, off).astype(dtype)
    if as_bool(strict, "strict"):
        raise_first(result._status, formula)
    return result


def _objects(value: Any, name: str) -> Multivector:
    objects = as_objects(value, f"the {name}s")
    if objects.kind.name != name:
        raise SceneError(f"a {name} is needed, not {objects.kind.name}.")
    return objects


def magnitude(surface: Surface) -> float:
    """Magnitude of the coordinates of a surface's points; at least 1 for a plane, which has no size of its own."""
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

    Planes, spheres and discs have formulas. On other surfaces lines through the position are intersected: the given one
    and, if it meets no point nearby, two perpendicular to it, one of which crosses any surface that the first touches.
    The normal at that point is the direction of the last line, which gives the surface's own normal and the distance.
    """
    if isinstance(surface, Flat):
        return surface.contact(position)
    shape = position.shape[:-1]
    position, direction = position.reshape(-1, 3), direction.reshape(-1, 3)
    limit = np.broadcast_to(slack, shape).reshape(-1)
    near = NEAR * (np.linalg.norm(position, axis=-1) + magnitude(surface))
    distance, normal = _nearest(surface, position, direction)
    with np.errstate(invalid="ignore"):  # invalid lines have no direction
        probes = across(direction)
    for probe in probes:
        _probe(surface, position, probe, ~(distance <= near), distance, normal, distance.copy())
    _probe(surface, position, normal.copy(), distance <= near, distance, normal, np.maximum(distance, limit))
    return distance.reshape(shape), normal.reshape(*shape, 3)


def _probe(
    surface: Surface, position: Array, probe: Array, selected: Array, distance: Array, normal: Array, below: Array
) -> None:
    """Intersect along the probes of selected items; update distances and normals where the distance is small enough."""
    items = np.flatnonzero(selected & np.isfinite(probe).all(-1))
    if not len(items):
        return
    away, facing = _nearest(surface, position[items], probe[items])
    better = away <= below[items]
    distance[items[better]], normal[items[better]] = away[better], facing[better]


def _nearest(surface: Surface, position: Array, direction: Array) -> tuple[Array, Array]:
    """Distance along lines to the surface, infinite where they miss it, and the normals there."""
    points = surface.intersect(position, direction)
    away = np.where(np.isfinite(points.normal).all(-1), np.abs(points.t), np.inf)
    first = np.argmin(away, axis=-1)[:, None]
    normal = np.take_along_axis(points.normal, first[..., None], axis=1)[:, 0]
    return np.take_along_axis(away, first, axis=1)[:, 0], normal
