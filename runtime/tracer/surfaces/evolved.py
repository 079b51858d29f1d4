"""Surfaces swept by objects that evolve along a curve (thesis 4.5, 4.7)."""

from __future__ import annotations

import logging
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ...curves import Curve
from ..segments import Segments, local_segments
from .base import Surface

Array = NDArray[Any]
_log = logging.getLogger("bladesmith")


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
        self.segments: Segments = local_segments(curve, self.swept, bool(align))
        self.gaps = bool(gaps)
        turned = np.flatnonzero(self.segments.turned)
        if len(turned):
            which = ", ".join(map(str, turned))
            _log.warning("%s: controls oppose each other; turned over (align): %s", self.kind, which)
        super().__init__(material)

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
