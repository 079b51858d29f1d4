"""Surfaces as triangle meshes with analytic normals (thesis 4.10), for other programs and for pages."""

from __future__ import annotations

from typing import Any

from ...errors import SceneError
from .. import values
from .plain import disc_mesh, facets_mesh, plane_mesh, sphere_mesh
from .ribbons import strip_mesh
from .rings import ring_mesh
from .triangles import TriangleMesh

RINGS = SEGMENTS = 64
#: Vertices beyond which a mesh is a mistake.
MOST_VERTICES = 1 << 26


def mesh_of(
    surface: Any,
    rings: int = RINGS,
    segments: int = SEGMENTS,
    *,
    caps: bool = False,
    extent: float | None = None,
    center: Any = None,
) -> TriangleMesh:
    """A surface as a triangle mesh.

    Parameters
    ----------
    surface : Surface
    rings : int
        Bands along the curve at least: each polynomial piece has the same number, so that vertices lie on its joints.
        Of a sphere the bands from pole to pole.
    segments : int
        Quads around circles and spheres, or along point pairs. At least 3 around.
    caps : bool
        Close the open ends of evolved circles with discs. They are left open by default, as the surface is.
    extent, center : float, (3,) array, optional
        Side of the square that stands for a plane, and a position, near which it is.

    Returns
    -------
    TriangleMesh
        Normals are the surface's own. They look outwards where evolved circles enclose something (caps or not), else
        along the circles, or from the first to the second end of the pairs, cross along the curve; faces turn
        counter-clockwise about them.

    Raises
    ------
    SceneError
        For a plane without an extent, and evolved surfaces with objects that are imaginary (unless the surface allows
        gaps: then each part is meshed), that become flat, without end, or shrink to a point.

    Notes
    -----
    Thesis 4.10. Vertices are carried from circle to circle by the similarity without a twist; a closed curve's are
    turned a little on the way so that the last ring is the first, and positions at seams agree to the last bit.
    """
    kind = getattr(surface, "kind", None)
    rings, segments = (
        values.whole(rings, "rings", 1, MOST_VERTICES),
        values.whole(segments, "segments", 1, MOST_VERTICES),
    )
    if kind in ("evolved_circles", "sphere", "disc"):
        segments = values.whole(segments, "segments", 3)
    if (rings + 1) * (segments + 1) > MOST_VERTICES:
        raise SceneError(f"{rings} x {segments} quads are more than a mesh can have.")
    caps = values.flag(caps, "caps")
    if kind == "evolved_circles":
        return ring_mesh(surface, rings, segments, caps)
    if kind == "evolved_point_pairs":
        return strip_mesh(surface, rings, segments)
    if kind == "sphere":
        return sphere_mesh(surface, values.whole(rings, "rings", 2), segments)
    if kind == "disc":
        return disc_mesh(surface, segments)
    if kind == "plane":
        return plane_mesh(surface, extent, center)
    if kind == "facets":
        return facets_mesh(surface)
    raise SceneError(f"a {type(surface).__name__} is no surface that can be meshed.")


__all__ = ["TriangleMesh", "mesh_of"]
