"""Surfaces swept by objects that evolve along a curve (thesis 4.5, 4.7)."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ...curves import Curve
from .. import values
from ..segments import Segments, local_segments
from .base import Surface

Array = NDArray[Any]
_log = logging.getLogger("bladesmith")
#: Numbers of controls, and surfaces, that a message lists.
MOST_LISTED = 8
#: Whether a maker of many surfaces says once for all what was turned over.
_quiet: ContextVar[bool] = ContextVar("_quiet", default=False)


@contextmanager
def quietly() -> Iterator[None]:
    """Surfaces made inside do not say which of their controls were turned over."""
    token = _quiet.set(True)
    try:
        yield
    finally:
        _quiet.reset(token)


def tell_turned(where: str, surfaces: Sequence[Surface]) -> None:
    """One line about all controls of a scene that were turned over."""
    turned = [
        f"{named(i, surface)}: {surface.turned_text}"
        for i, surface in enumerate(surfaces)
        if isinstance(surface, EvolvedSurface) and surface.segments.turned.any()
    ]
    if turned:
        most = [*turned[:MOST_LISTED], *([".."] if len(turned) > MOST_LISTED else [])]
        count = "1 surface" if len(turned) == 1 else f"{len(turned)} surfaces"
        _log.warning("%s: controls of %s oppose the one before; turned over (align): %s", where, count, "; ".join(most))


def named(place: int, surface: Surface) -> str:
    """A surface of a scene as messages call it."""
    return f"surfaces[{place}]" + (f" ({surface.name!r})" if surface.name else "")


class EvolvedSurface(Surface):
    """What surfaces along curves share: polynomial pieces of the curve, one row of the program for each.

    Attributes
    ----------
    curve : Curve
        The curve that the surface follows, controls turned over where `flipped` says so.
    segments : Segments
        Its pieces.
    flipped : (controls,) array of bool
        Controls that were turned over.
    gaps : bool
        Parts where the interpolant is imaginary are left out instead of refused.
    """

    swept: ClassVar[str]

    def __init__(self, curve: Any, *, align: bool = True, gaps: bool = False, material: Any = None) -> None:
        turn = values.flag(align, "align")
        made = isinstance(curve, Segments)  # by a reader of many curves at once
        self.segments: Segments = curve if made else local_segments(curve, self.swept, turn)
        self.gaps = values.flag(gaps, "gaps")
        if self.segments.turned.any() and not _quiet.get():
            _log.warning("%s: controls oppose each other; turned over (align): %s", self.kind, self.turned_text)
        super().__init__(material)

    @property
    def turned_text(self) -> str:
        """Numbers of the controls that were turned over for this surface, as messages list them."""
        turned = np.flatnonzero(self.segments.turned)
        return ", ".join([*map(str, turned[:MOST_LISTED]), *([".."] if len(turned) > MOST_LISTED else [])])

    @property
    def curve(self) -> Curve:
        """The curve that the surface follows."""
        return self.segments.curve

    @property
    def flipped(self) -> NDArray[np.bool_]:
        """Controls that were turned over, by the curve itself or for this surface."""
        return self.segments.flipped

    @property
    def degree(self) -> int:
        """Degree of the curve's pieces."""
        return int(self.segments.controls.shape[1]) - 1

    @property
    def program_kind(self) -> str:
        return f"{self.kind}_free_{self.degree}" if self.segments.free else f"{self.kind}_{self.degree}"

    @property
    def parameters(self) -> Array:
        return self.segments.parameters(self.gaps)


class EvolvedCircles(EvolvedSurface):
    """The surface swept by a circle that evolves along a curve (thesis 4.5).

    Parameters
    ----------
    curve : Curve of circles, or sequence of controls
        Of controls a Bezier curve is made: circles, their coefficients, (center, normal, radius) as tuples or mappings.
    align : bool
        Turn controls over where neighbours oppose each other (<C1 C2>_0 < 0): between such circles the interpolant
        may become imaginary. Turns are logged, and `flipped` tells them.
    gaps : bool
        Leave out parts where the interpolant is imaginary. Otherwise they are refused when the surface is first used.
    material : Material, optional
    """

    kind = "evolved_circles"
    swept = "circle"


class EvolvedPointPairs(EvolvedSurface):
    """The surface swept by the segment between two points that evolve along a curve (thesis 4.7.2).

    Parameters
    ----------
    curve : Curve of point pairs, or sequence of controls
        Of controls a Bezier curve is made: point pairs, their coefficients, (a, b) as tuples or mappings.
    align : bool
        Turn controls over where neighbours oppose each other (<P1 P2>_0 < 0): between such pairs the interpolant
        may become imaginary. Turns are logged, and `flipped` tells them.
    gaps : bool
        Leave out parts where the interpolant is imaginary. Otherwise they are refused when the surface is first used.
    material : Material, optional
    """

    kind = "evolved_point_pairs"
    swept = "point_pair"
