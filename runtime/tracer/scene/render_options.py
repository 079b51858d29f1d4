"""Checked options of intersections and pictures, to which a scene's driver is bound."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...common.validation import as_choice, as_instance, invalid
from ...errors import SceneError
from ..rendering.canvas import check_memory
from ..surfaces import LEAST_SAMPLES, MOST_SAMPLES
from . import values
from .defaults import HEIGHT, MAX_GRID, MAX_SIDE, SETTINGS, WIDTH

#: Pixels along a side beyond which the message does not even tell the memory.
ABSURD = 10**9
#: What runs the loops over rays and pixels.
TARGETS = ("c", "numba", "cuda")


@dataclass(frozen=True)
class RenderOptions:
    """Options of an intersection with given rays, or of a picture."""

    method: str
    samples: int
    dtype: np.dtype[Any]
    width: int = 0
    height: int = 0
    grid: int = 1
    layers: tuple[str, ...] = ()
    target: str = "c"


def ray_options(method: str, samples: Any, dtype: np.dtype[Any], target: Any = "c") -> RenderOptions:
    """Options of an intersection with given rays."""
    return RenderOptions(
        values.text(method, "method"),
        values.whole(samples, "samples", LEAST_SAMPLES, MOST_SAMPLES),
        dtype,
        target=as_choice(target, "target", TARGETS, SceneError),
    )


def picture_options(
    settings: Mapping[str, int],
    width: Any,
    height: Any,
    layers: tuple[str, ...],
    method: str,
    samples: Any,
    antialias: Any,
    dtype: Any,
    target: Any = "c",
) -> RenderOptions:
    """Options of a picture; its memory is checked first, since that error is the most helpful one.

    Raises
    ------
    SceneError
        With the name of the option.
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
    as_choice(target, "target", TARGETS, SceneError)
    return RenderOptions(values.text(method, "method"), samples, kind, columns, rows, grid, layers, target)


def check_settings(settings: Any) -> dict[str, int]:
    """Check the defaults that a scene holds for its pictures."""
    given = {} if settings is None else settings
    checked = dict(as_instance(given, "settings", Mapping, f"a mapping with {', '.join(SETTINGS)}", SceneError))
    for name, value in checked.items():
        as_choice(name, "a key of settings", SETTINGS, SceneError)
        values.whole(value, f"settings.{name}", 1, SETTINGS[name])
    return checked


def picture_size(settings: Mapping[str, int], width: Any, height: Any) -> tuple[int, int]:
    """Width and height: the arguments, else those of the scene file, else 640 by 480."""
    return _setting(settings, width, "width", WIDTH), _setting(settings, height, "height", HEIGHT)


def _setting(settings: Mapping[str, int], value: Any, name: str, default: int, maximum: int | None = None) -> int:
    return values.whole(settings.get(name, default) if value is None else value, name, 1, maximum)


def _floating(dtype: Any) -> np.dtype[Any]:
    checked: np.dtype[Any] | None = None
    with contextlib.suppress(TypeError):
        checked = np.dtype(dtype)
    if checked is None or checked not in (np.float32, np.float64):
        raise invalid(dtype, "dtype", "float64 or float32", SceneError)
    return checked
