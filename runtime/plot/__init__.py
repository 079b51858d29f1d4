"""Pictures of geometric objects, curves, motions and fields, with matplotlib in 3D; no window is needed.

`draw` takes any object of `cga3d` and `pga3d`, batches, lists and curves; `orbit`, `screw` and `twist_field` show what
bivectors do. matplotlib is imported by the first picture, and no global state of it is touched.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..lazily import lazily
from . import palette

if TYPE_CHECKING:
    from .drawing import draw, paths, skipped
    from .motions import orbit, orbit_paths, screw, screw_parts, twist_field, velocities
    from .pages import axes, panels, save

#: Public name -> module of this package that defines it.
_HOMES = {
    "axes": "pages",
    "draw": "drawing",
    "orbit": "motions",
    "orbit_paths": "motions",
    "panels": "pages",
    "paths": "drawing",
    "save": "pages",
    "screw": "motions",
    "screw_parts": "motions",
    "skipped": "drawing",
    "twist_field": "motions",
    "velocities": "motions",
}

__all__ = [
    "axes",
    "draw",
    "orbit",
    "orbit_paths",
    "palette",
    "panels",
    "paths",
    "save",
    "screw",
    "screw_parts",
    "skipped",
    "twist_field",
    "velocities",
]

__getattr__, __dir__ = lazily(__name__, _HOMES)
