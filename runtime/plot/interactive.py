"""Interactive figures of notebooks: sliders and draggable points call a function, and its objects are drawn anew."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from ..common.validation import as_int, as_pair, real_array
from ..errors import InputError, MissingExtraError
from . import axes_setup, palette
from .input_groups import is_curve
from .packing import PackedObjects, Part, drawables, is_mesh, vertices
from .tessellation import Array, Box
from .view_box import automatic_box, extent_box

if TYPE_CHECKING:
    from .widget import InteractiveFigure

#: Room for what moves around what is there at first, relative to it.
ROOM = 0.25
#: Height of a figure in pixels, and its bounds.
HEIGHT, HEIGHTS = 420, (50, 4000)


@dataclass(frozen=True)
class Interaction:
    """What changes a picture: from the values of sliders and points to objects, and to their parts.

    Attributes
    ----------
    function : callable
        Takes the sliders and points by name; gives an object, or a list of them.
    sliders : dict of str to (low, high, start)
    points : dict of str to array (3,)
        Where they are at first.
    """

    function: Callable[..., Any]
    sliders: Mapping[str, tuple[float, float, float]]
    points: Mapping[str, Array]

    @property
    def inputs(self) -> dict[str, Any]:
        """The values at first."""
        return {
            "number": 0,
            "sliders": {name: start for name, (_, _, start) in self.sliders.items()},
            "points": {name: xyz.tolist() for name, xyz in self.points.items()},
        }

    def setup(self, box: Box) -> dict[str, Any]:
        """What does not change: the box, and what can be moved."""
        half = (box.high - box.low) / 2
        return {
            "half": half.tolist(), "center": box.center.tolist(), "size": 2 * float(np.linalg.norm(half)),
            "sliders": [{"name": name, "low": low, "high": high} for name, (low, high, _) in self.sliders.items()],
            "points": list(self.points),
        }  # fmt: skip

    def things(self, inputs: Mapping[str, Any]) -> list[Any]:
        """What the function gives for these values.

        Raises
        ------
        InputError
            If a value is missing or not finite.
        """
        given: dict[str, Any] = {}
        for name, (low, high, _) in self.sliders.items():
            given[name] = min(max(_finite(inputs["sliders"].get(name), name), low), high)
        for name in self.points:
            given[name] = np.array([_finite(x, name) for x in inputs["points"].get(name, ())])
        found = self.function(**given)
        return list(found) if isinstance(found, list | tuple) else [found]

    def answer(self, picture: PackedObjects, inputs: Mapping[str, Any]) -> tuple[dict[str, Any], list[list[Part]]]:
        """The answer to these values: how many objects there are, and the parts of each.

        After an error its text, and the objects as they were.
        """
        begin, error = time.perf_counter(), ""
        try:
            picture.update(self.things(inputs))
        except Exception as failure:  # the user's function may do anything: the figure says what, and lives on
            error = f"{type(failure).__name__}: {failure}"
        frame = {
            "number": inputs.get("number", 0), "objects": len(picture.parts), "error": error,
            "milliseconds": 1e3 * (time.perf_counter() - begin),
        }  # fmt: skip
        return frame, picture.parts


def show(
    *content: Any,
    sliders: Mapping[str, Sequence[float]] | None = None,
    points: Mapping[str, Any] | None = None,
    extent: Any = None,
    view: tuple[float, float] = axes_setup.VIEW,
    height: int = HEIGHT,
) -> InteractiveFigure:
    """An interactive figure for notebooks: drag to turn, scroll to zoom, move sliders and points.

    Parameters
    ----------
    *content
        A function, which is called with the values of sliders and points by their names and gives what is drawn, an
        object or a list of them; or the objects themselves. Everything that `draw` takes, and meshes (with ``vertices``
        and ``faces``). Each has a color of its own.
    sliders : mapping of str to (low, high) or (low, high, start), optional
        The function gets numbers. They start at the middle.
    points : mapping of str to (3,), optional
        Points that can be dragged, from here on; the function gets arrays (3,).
    extent
        As of `draw`. Default: what is there at first, and a quarter more. It stays.
    view : (elevation, azimuth)
        Degrees.
    height : int
        Pixels.

    Returns
    -------
    InteractiveFigure
        A widget: notebooks show it, and its ``inputs`` can be read.

    Raises
    ------
    InputError
        If a name or a value is not valid, or there is nothing to draw; and what the function raises at first.
    MissingExtraError
        If anywidget is not installed (extra `notebook`).
    """
    function = content[0] if len(content) == 1 and callable(content[0]) and not is_curve(content[0]) else None
    if function is None and (sliders or points):
        raise InputError("sliders and points are for a function, and there is none.", remedy="Give a function of them")
    if not content:
        raise InputError("there is nothing to draw.", remedy="Give a function, or objects")
    found = Interaction(
        function or (lambda: list(content)),
        {_name(name): _range(name, given) for name, given in (sliders or {}).items()},
        {_name(name): real_array(xyz, name, (3,)).astype(float) for name, xyz in (points or {}).items()},
    )
    if set(found.sliders) & set(found.points):
        raise InputError("a slider and a point have the same name.")
    elevation, azimuth = as_pair(view, "view")
    height = as_int(height, "height", *HEIGHTS)
    box = _box(found, extent)
    try:
        from .widget import InteractiveFigure
    except ImportError:
        raise MissingExtraError("notebook", "An interactive figure") from None
    setup = {**found.setup(box), "view": [float(elevation), float(azimuth)], "height": height}
    return InteractiveFigure(setup, found.inputs, partial(found.answer, PackedObjects(box)))


def _box(found: Interaction, extent: Any) -> Box:
    things = [vertices(x) if is_mesh(x) else x for x in found.things(found.inputs)]
    things += [xyz[None] for xyz in found.points.values()]
    ink = palette.per_item(None, 1, palette.INK)
    groups = [drawable for thing in things for drawable in drawables(thing, ink)]
    if extent is not None:
        return extent_box(extent)
    box = automatic_box(groups)
    if box is None:
        raise InputError("there is nothing to draw: no object is real and finite.")
    room = ROOM * (box.high - box.low)
    return Box(box.low - room, box.high + room)


def _name(name: Any) -> str:
    if not isinstance(name, str) or not name.isidentifier():
        raise InputError(f"{name!r} is not the name of an argument.")
    return name


def _range(name: str, given: Any) -> tuple[float, float, float]:
    numbers = [_finite(x, name) for x in given] if isinstance(given, Sequence | np.ndarray) else []
    if len(numbers) == 2:
        numbers.append(sum(numbers) / 2)
    if len(numbers) != 3 or not numbers[0] < numbers[1] or not numbers[0] <= numbers[2] <= numbers[1]:
        raise InputError(f"slider {name} is {given}.", remedy="Give (low, high), or (low, high, start) between them")
    return numbers[0], numbers[1], numbers[2]


def _finite(value: Any, name: str) -> float:
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = math.nan
    if not math.isfinite(number):
        raise InputError(f"{name} is {value!r}; a finite number is needed.")
    return number
