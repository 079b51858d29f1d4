"""Contents of pictures of a simulation: shapes of bodies, traced points, objects of constraints, names of units.

Plain data, stored with a trajectory; nothing is drawn here.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from numpy.typing import ArrayLike, NDArray

from ...codegen.errors import InputError, suggest
from ...common.validation import as_instance, as_pair, as_text, as_tuple, check_shape, finite_array, short_repr
from ...core.multivector import Multivector
from ...mechanics.arguments import frozen_copy, vectors
from ...mechanics.shapes import Shape
from ...mechanics.units import Units
from ...plot import palette

Array = NDArray[Any]
#: Colors by name, the same in every picture.
COLORS = {
    "blue": palette.BLUE, "red": palette.RED, "green": palette.GREEN, "orange": palette.AMBER, "purple": palette.PURPLE,
    "teal": palette.TEAL, "pink": palette.ROSE, "brown": palette.BROWN, "black": palette.INK, "gray": palette.GREY,
}  # fmt: skip
#: Default colors of traces.
TRACE_COLORS = (palette.GREEN, palette.RED, palette.AMBER, palette.PURPLE, palette.TEAL, palette.ROSE, palette.BROWN)


def color_code(color: str) -> str:
    """Code ``#rrggbb`` of a color, by its name or itself.

    Raises
    ------
    InputError
        If it is not a color.
    """
    code = COLORS.get(color, color) if isinstance(color, str) else ""
    if len(code) == 7 and code[0] == "#" and all(c in "0123456789abcdefABCDEF" for c in code[1:]):
        return code
    near = suggest(color, COLORS) if isinstance(color, str) else ""
    raise InputError(f"{short_repr(color)} is not a color{near}; there are {', '.join(COLORS)} and '#rrggbb'.")


@dataclass(frozen=True)
class Trace:
    """A point of a body whose path is shown.

    Parameters
    ----------
    point : array (3,)
        In the body's frame (origin at the center of mass).
    label : str
    color : str
        A name of `COLORS` or ``"#rrggbb"``; by default each trace has its own.
    body : str, optional
        Name of the body, if there are several.
    """

    point: ArrayLike
    label: str = ""
    color: str | None = None
    body: str | None = None

    def __post_init__(self) -> None:
        point = vectors(self.point, "a trace's point")
        check_shape(point, "a trace's point", (3,))
        object.__setattr__(self, "point", frozen_copy(point))
        for name, value in (("label", self.label), ("body", "" if self.body is None else self.body)):
            as_text(value, f"a trace's {name}")
        if self.color is not None:
            object.__setattr__(self, "color", color_code(self.color))


@dataclass(frozen=True)
class Sketch:
    """Contents of a picture.

    Parameters
    ----------
    shapes : Shape, or mapping of bodies' names to them
        A single shape is that of the only body.
    traces : sequence of Trace, or of points (3,)
    objects : sequence of Multivector
        Objects of the world that bodies are pinned to or slide on.
    colors : mapping of bodies' names to colors
    units : Units
    title : str
    view : (elevation, azimuth)
        Degrees.
    shown : sequence of float, optional
        Times at which bodies are drawn in a picture; default: the first and the last.
    """

    shapes: Mapping[str, Shape] = field(default_factory=dict)
    traces: Sequence[Trace] = ()
    objects: Sequence[Multivector] = ()
    colors: Mapping[str, str] = field(default_factory=dict)
    units: Units = Units()
    title: str = ""
    view: tuple[float, float] = (20.0, -60.0)
    shown: tuple[float, ...] | None = None

    def __post_init__(self) -> None:
        shapes: Any = self.shapes
        as_instance(shapes, "shapes", (Shape, Mapping), "a Shape, or a mapping of bodies' names to them,")
        shapes = {"": shapes} if isinstance(shapes, Shape) else dict(shapes)
        for name, shape in shapes.items():
            as_instance(shape, f"the shape of {name or 'the body'}", Shape)
        object.__setattr__(self, "shapes", shapes)
        traces = tuple(x if isinstance(x, Trace) else Trace(x) for x in as_tuple(self.traces, "the traces", Trace))
        object.__setattr__(self, "traces", traces)
        objects = as_tuple(self.objects, "the objects", Multivector)
        for i, x in enumerate(objects):
            as_instance(x, f"objects[{i}]", Multivector, "a multivector")
        object.__setattr__(self, "objects", objects)
        as_instance(self.colors, "colors", Mapping, "a mapping of bodies' names to colors")
        as_instance(self.units, "units", Units, "a Units(length, mass, time)")
        self._check_view()
        object.__setattr__(self, "colors", {name: color_code(c) for name, c in self.colors.items()})

    def _check_view(self) -> None:
        """Check title, angles and times."""
        as_text(self.title, "the title")
        as_pair(self.view, "the view (elevation, azimuth)")
        if self.shown is not None:
            finite_array(self.shown, "the shown times", ("n",))

    def shape_of(self, name: str, alone: bool) -> Shape | None:
        """Shape of a body, if it has one."""
        return self.shapes.get(name) or (self.shapes.get("") if alone else None)

    def color_of(self, number: int) -> str:
        """Color of a trace."""
        color = self.traces[number].color
        return TRACE_COLORS[number % len(TRACE_COLORS)] if color is None else color


__all__ = ["COLORS", "Sketch", "Trace", "color_code"]
