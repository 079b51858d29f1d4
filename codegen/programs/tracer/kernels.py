"""The kernels of scenes, besides those of kinds of surface."""

from __future__ import annotations

from ...formulas.rays import boxes, rays, shading
from .. import KernelSpec

#: The side of a normal that a ray sees.
facing = KernelSpec(rays.facing, ("unit", "position"))
#: Of pictures.
camera_position = KernelSpec(shading.camera_position, ("motor",))
camera_direction = KernelSpec(shading.camera_direction, ("motor", "numbers3", "numbers2"))
light_terms = KernelSpec(shading.light_terms, ("position", "unit", "unit", "position", "number"))
reflected_direction = KernelSpec(rays.reflected_direction, ("position", "unit"))
#: Of the boxes of rows.
box_ray = KernelSpec(boxes.box_ray, ("position", "position", "number"))
box_span = KernelSpec(boxes.box_span, ("position",) * 5 + ("numbers2",))
