"""What pictures show of a simulation besides its numbers: shapes of bodies, points whose paths are drawn, objects that
hold bodies, the names of units. Plain data: it is written beside a trajectory, and no picture is made here.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from numpy.typing import NDArray

from ..codegen.errors import InputError, ShapeError, suggest
from ..multivector import Multivector
from ..plot import palette
from .given import finite, kept, several, shown, vectors
from .shapes import Shape

Array = NDArray[Any]
#: Colours by name, the same in every picture.
COLORS = {
    "blue": palette.BLUE, "red": palette.RED, "green": palette.GREEN, "orange": palette.AMBER, "purple": palette.PURPLE,
    "teal": palette.TEAL, "pink": palette.ROSE, "brown": palette.BROWN, "black": palette.INK, "gray": palette.GREY,
}  # fmt: skip
#: Of traces that are given none.
TRACE_COLORS = (palette.GREEN, palette.RED, palette.AMBER, palette.PURPLE, palette.TEAL, palette.ROSE, palette.BROWN)


def color_code(color: str) -> str:
    """``#rrggbb`` of a name, or of itself.

    Raises
    ------
    InputError
        If it is no colour.
    """
    found = COLORS.get(color, color) if isinstance(color, str) else ""
    if len(found) == 7 and found[0] == "#" and all(c in "0123456789abcdefABCDEF" for c in found[1:]):
        return found
    near = suggest(color, COLORS) if isinstance(color, str) else ""
    raise InputError(f"{shown(color)} is no colour{near}; there are {', '.join(COLORS)} and '#rrggbb'.")


@dataclass(frozen=True)
class Trace:
    """A point of a body whose path is shown.

    Parameters
    ----------
    point : array (3,)
        In the body's frame (origin at the centre of mass).
    label : str
    color : str
        A name of `COLORS` or ``"#rrggbb"``; by default each trace has its own.
    body : str, optional
        Its name, where there are several.
    """

    point: Any
    label: str = ""
    color: str | None = None
    body: str | None = None

    def __post_init__(self) -> None:
        point = vectors(self.point, "a trace's point")
        if point.shape != (3,):
            raise ShapeError(f"a trace's point has shape {point.shape}; one point (3,) is needed.")
        object.__setattr__(self, "point", kept(point))
        for name, value in (("label", self.label), ("body", "" if self.body is None else self.body)):
            if not isinstance(value, str):
                raise InputError(f"a trace's {name} is {shown(value)}; a text is needed.")
        if self.color is not None:
            object.__setattr__(self, "color", color_code(self.color))


@dataclass(frozen=True)
class Units:
    """What numbers are called: labels only."""

    length: str = "m"
    mass: str = "kg"
    time: str = "s"

    def _named(self, si: str, composed: str) -> str:
        return si if (self.length, self.mass, self.time) == ("m", "kg", "s") else composed

    @property
    def velocity(self) -> str:
        return f"{self.length}/{self.time}"

    @property
    def angular_velocity(self) -> str:
        return f"rad/{self.time}"

    @property
    def force(self) -> str:
        return self._named("N", f"{self.mass} {self.length}/{self.time}^2")

    @property
    def moment(self) -> str:
        return self._named("N m", f"{self.mass} {self.length}^2/{self.time}^2")

    @property
    def energy(self) -> str:
        return self._named("J", f"{self.mass} {self.length}^2/{self.time}^2")

    @property
    def momentum(self) -> str:
        return f"{self.mass} {self.length}/{self.time}"

    @property
    def angular_momentum(self) -> str:
        return f"{self.mass} {self.length}^2/{self.time}"


@dataclass(frozen=True)
class Sketch:
    """What a picture shows.

    Parameters
    ----------
    shapes : Shape, or mapping of bodies' names to them
        One shape is that of the only body.
    traces : sequence of Trace, or of points (3,)
    objects : sequence of Multivector
        Of the world: what bodies are pinned to or slide on.
    colors : mapping of bodies' names to colours
    units : Units
    title : str
    view : (elevation, azimuth)
        Degrees.
    shown : sequence of float, optional
        Times at which bodies are drawn in a picture that stands still; default: the first and the last.
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
        given: Any = self.shapes
        if not isinstance(given, Shape | Mapping):
            raise InputError(
                f"the shapes are {shown(given)}; a Shape, or a mapping of bodies' names to them, is needed."
            )
        shapes = {"": given} if isinstance(given, Shape) else dict(given)
        for name, shape in shapes.items():
            if not isinstance(shape, Shape):
                raise InputError(f"the shape of {name or 'the body'} is {shown(shape)}; a Shape is needed.")
        object.__setattr__(self, "shapes", shapes)
        made = tuple(x if isinstance(x, Trace) else Trace(x) for x in several(self.traces, Trace, "the traces"))
        object.__setattr__(self, "traces", made)
        objects = several(self.objects, Multivector, "the objects")
        for i, x in enumerate(objects):
            if not isinstance(x, Multivector):
                raise InputError(f"objects[{i}] is {shown(x)}; a multivector is needed.")
        object.__setattr__(self, "objects", objects)
        if not isinstance(self.colors, Mapping):
            raise InputError(f"the colors are {shown(self.colors)}; a mapping of bodies' names to colours is needed.")
        if not isinstance(self.units, Units):
            raise InputError(f"the units are {shown(self.units)}; Units(length, mass, time) are needed.")
        self._check_view()
        object.__setattr__(self, "colors", {name: color_code(c) for name, c in self.colors.items()})

    def _check_view(self) -> None:
        """Title, angles and times."""
        if not isinstance(self.title, str):
            raise InputError(f"the title is {shown(self.title)}; a text is needed.")
        angles = finite(self.view, "the view")
        if angles.shape != (2,):
            raise ShapeError(f"the view has shape {angles.shape}; elevation and azimuth are needed, in degrees.")
        if self.shown is not None:
            times = finite(self.shown, "the shown times")
            if times.ndim != 1:
                raise ShapeError(f"the shown times have shape {times.shape}; a row of times is needed.")

    def shape_of(self, name: str, alone: bool) -> Shape | None:
        """The shape of a body, if it has one."""
        return self.shapes.get(name) or (self.shapes.get("") if alone else None)

    def color_of(self, number: int) -> str:
        """Of a trace."""
        own = self.traces[number].color
        return TRACE_COLORS[number % len(TRACE_COLORS)] if own is None else own


__all__ = ["COLORS", "Sketch", "Trace", "Units", "color_code"]
