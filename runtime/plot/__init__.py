"""Pictures of geometric objects, curves, motions and fields, with matplotlib in 3D; no window is needed.

`draw` takes any object of `cga3d` and `pga3d`, batches, lists and curves; `orbit`, `screw` and `twist_field` show what
bivectors do. matplotlib is imported by the first picture, and no global state of it is touched.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

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


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f".{_HOMES[name]}", __name__), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return __all__
