"""Triangle meshes of surfaces with analytic normals (thesis 4.10), for files and for pages."""

from __future__ import annotations

from typing import Any

from ...common.validation import invalid
from ...errors import SceneError
from ..scene import values
from .primitives import disc_mesh, facets_mesh, plane_mesh, sphere_mesh
from .ribbons import strip_mesh
from .triangle_mesh import TriangleMesh
from .tubes import ring_mesh

#: Default number of bands along a curve, and of quads around it.
RINGS = SEGMENTS = 64
#: Largest number of vertices: more are a mistake.
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
    """Triangulate a surface.

    Parameters
    ----------
    surface : Surface
    rings : int
        Smallest number of bands along the curve: each polynomial piece has equally many, so that vertices lie on its
        joints. For a sphere, bands from pole to pole.
    segments : int
        Quads around circles and spheres, or along point pairs. At least 3 around.
    caps : bool
        Close the open ends of evolved circles with discs. By default they stay open, like the surface.
    extent, center : float, (3,) array, optional
        Side of the square that represents a plane, and a position near its center.

    Returns
    -------
    TriangleMesh
        Normals are the surface's own. They point outward where evolved circles enclose a volume (with or without caps);
        otherwise they are the cross product of the direction along the circles, or from the first to the second end of
        the pairs, with that along the curve. Faces are counter-clockwise about them.

    Raises
    ------
    SceneError
        For a plane without an extent, and for evolved surfaces with objects that are imaginary (unless the surface
        allows gaps: then each part is meshed), flat, unbounded, or of zero size.

    Notes
    -----
    Thesis 4.10. Vertices follow from circle to circle by the similarity without a twist; along a closed curve they are
    rotated evenly so that the last ring is the first, and positions at seams agree to the last bit.
    """
    kind = getattr(surface, "kind", None)
    rings, segments = (
        values.whole(rings, "rings", 1, MOST_VERTICES),
        values.whole(segments, "segments", 1, MOST_VERTICES),
    )
    if kind in ("evolved_circles", "sphere", "disc"):
        segments = values.whole(segments, "segments", 3)
    if (rings + 1) * (segments + 1) > MOST_VERTICES:
        raise SceneError(f"{rings} x {segments} quads have more than {MOST_VERTICES} vertices.")
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
    raise invalid(surface, "surface", "a Surface", SceneError)


__all__ = ["TriangleMesh", "mesh_of"]
