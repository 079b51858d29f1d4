"""Options of pictures, checked: what a scene's driver is bound to."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import SceneError, suggest
from . import values
from .pictures import check_memory
from .surfaces import LEAST_SAMPLES, MOST_SAMPLES

WIDTH, HEIGHT = 640, 480
#: Pixels of a side and rays along a side of a pixel beyond which a picture is a mistake.
MAX_SIDE, MAX_GRID = 65536, 64
#: Pixels of a side of which not even the memory is told.
ABSURD = 10**9
#: Reflections along one ray beyond which a scene is a mistake.
MAX_REFLECTIONS = 1000
#: What a scene may say of its pictures, and the most of each.
SETTINGS = {"width": MAX_SIDE, "height": MAX_SIDE, "antialias": MAX_GRID}


@dataclass(frozen=True)
class View:
    """How a scene is asked."""

    method: str
    samples: int
    dtype: np.dtype[Any]
    width: int = 0
    height: int = 0
    grid: int = 1
    layers: tuple[str, ...] = ()


def rays_view(method: str, samples: Any, dtype: np.dtype[Any]) -> View:
    """Options of rays that are given."""
    return View(values.text(method, "method"), values.whole(samples, "samples", LEAST_SAMPLES, MOST_SAMPLES), dtype)


def picture_view(
    settings: Mapping[str, int],
    width: Any,
    height: Any,
    layers: tuple[str, ...],
    method: str,
    samples: Any,
    antialias: Any,
    dtype: Any,
) -> View:
    """Options of a picture; its memory first, since that error says most.

    Raises
    ------
    SceneError
        That names the option.
    """
    columns, rows = picture_size(settings, width, height)
    for side, name in ((columns, "width"), (rows, "height")):
        if side > ABSURD:
            values.whole(side, name, 1, MAX_SIDE)
    kind = _floating(dtype)
    check_memory(columns, rows, layers, kind)
    for side, name in ((columns, "width"), (rows, "height")):
        values.whole(side, name, 1, MAX_SIDE)
    grid = _setting(settings, antialias, "antialias", 1, MAX_GRID)
    samples = values.whole(samples, "samples", LEAST_SAMPLES, MOST_SAMPLES)
    return View(values.text(method, "method"), samples, kind, columns, rows, grid, layers)


def checked_settings(settings: Any) -> dict[str, int]:
    """Defaults of pictures that a scene comes with."""
    if not isinstance(settings, Mapping | None):
        raise SceneError(f"settings is {values.shown(settings)}; a mapping with {', '.join(SETTINGS)} is needed.")
    given = dict(settings or {})
    for name, value in given.items():
        if name not in SETTINGS:
            raise SceneError(
                f"settings has {values.shown(name)}{suggest(str(name), SETTINGS)}; there are {', '.join(SETTINGS)}."
            )
        values.whole(value, f"settings.{name}", 1, SETTINGS[name])
    return given


def picture_size(settings: Mapping[str, int], width: Any, height: Any) -> tuple[int, int]:
    """Width and height: what is given, else the scene file's, else 640 by 480."""
    return _setting(settings, width, "width", WIDTH), _setting(settings, height, "height", HEIGHT)


def _setting(settings: Mapping[str, int], value: Any, name: str, default: int, most: int | None = None) -> int:
    return values.whole(settings.get(name, default) if value is None else value, name, 1, most)


def _floating(dtype: Any) -> np.dtype[Any]:
    found: np.dtype[Any] | None = None
    with contextlib.suppress(TypeError):
        found = np.dtype(dtype)
    if found is None or found not in (np.float32, np.float64):
        raise SceneError(f"dtype is {values.shown(dtype)}; it is float64 or float32.")
    return found
