"""Surfaces swept by circles or point pairs that evolve along a curve (thesis 4.5, 4.7)."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ...curves import Curve
from ..scene import values
from ..sweeps.local_segments import Segments, local_segments
from ..sweeps.real_intervals import surface_label
from .base import Surface

Array = NDArray[Any]
_log = logging.getLogger("bladesmith")
#: Largest number of controls, or of surfaces, that a message lists.
MOST_LISTED = 8
#: Suppression of warnings about flipped controls, because the caller warns once for many surfaces.
_quiet: ContextVar[bool] = ContextVar("_quiet", default=False)


@contextmanager
def suppress_flip_warnings() -> Iterator[None]:
    """Suppress the warnings about flipped controls of surfaces that are constructed inside the block."""
    token = _quiet.set(True)
    try:
        yield
    finally:
        _quiet.reset(token)


def warn_flipped(where: str, surfaces: Sequence[Surface]) -> None:
    """Log one warning about all controls of a scene whose orientation was reversed."""
    flipped = [
        f"{surface_label(i, surface)}: {surface.flipped_text}"
        for i, surface in enumerate(surfaces)
        if isinstance(surface, EvolvedSurface) and surface.segments.newly_flipped.any()
    ]
    if flipped:
        most = [*flipped[:MOST_LISTED], *([".."] if len(flipped) > MOST_LISTED else [])]
        count = "1 surface" if len(flipped) == 1 else f"{len(flipped)} surfaces"
        _log.warning(
            "%s: controls of %s oppose their predecessor; orientation reversed (align): %s",
            where,
            count,
            "; ".join(most),
        )


class EvolvedSurface(Surface):
    """Base of surfaces along curves: polynomial pieces of the curve, one row of parameters for each.

    Attributes
    ----------
    curve : Curve
        The curve that the surface follows, with the orientation of `flipped` controls reversed.
    segments : Segments
        Pieces of the curve.
    flipped : (controls,) array of bool
        Controls whose orientation was reversed.
    gaps : bool
        Parts where the interpolant is imaginary are omitted instead of refused.
    """

    swept: ClassVar[str]
    _shown = ("curve",)

    def __init__(self, curve: Any, *, align: bool = False, gaps: bool = False, material: Any = None) -> None:
        flip = values.flag(align, "align")
        is_split = isinstance(curve, Segments)  # by a reader of many curves at once
        self.segments: Segments = curve if is_split else local_segments(curve, self.swept, flip)
        self.gaps = values.flag(gaps, "gaps")
        if self.segments.newly_flipped.any() and not _quiet.get():
            _log.warning(
                "%s: controls oppose their predecessor; orientation reversed (align): %s", self.kind, self.flipped_text
            )
        super().__init__(material)

    @property
    def flipped_text(self) -> str:
        """Indices of the controls that were flipped for this surface, as messages list them."""
        flips = np.flatnonzero(self.segments.newly_flipped)
        return ", ".join([*map(str, flips[:MOST_LISTED]), *([".."] if len(flips) > MOST_LISTED else [])])

    @property
    def curve(self) -> Curve:
        """Curve that the surface follows."""
        return self.segments.curve

    @property
    def flipped(self) -> NDArray[np.bool_]:
        """Controls whose orientation was reversed, by the curve itself or for this surface."""
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
        Controls define a Bezier curve: circles, their coefficients, (center, normal, radius) as tuples or mappings.
    align : bool
        Reverse the orientation of controls that oppose their predecessor (<C1 C2>_0 < 0): between such circles the
        interpolant may become imaginary. Reversals are logged, and listed in `flipped`. Otherwise the surface follows
        the controls as they are, like the curve through them.
    gaps : bool
        Omit parts where the interpolant is imaginary. Otherwise they are refused when the surface is first used.
    material : Material, optional
    """

    kind = "evolved_circles"
    swept = "circle"


class EvolvedPointPairs(EvolvedSurface):
    """The surface swept by the segment between two points that evolve along a curve (thesis 4.7.2).

    Parameters
    ----------
    curve : Curve of point pairs, or sequence of controls
        Controls define a Bezier curve: point pairs, their coefficients, (a, b) as tuples or mappings.
    align, gaps, material
        As for `EvolvedCircles`.
    """

    kind = "evolved_point_pairs"
    swept = "point_pair"
