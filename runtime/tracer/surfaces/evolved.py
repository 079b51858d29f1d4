"""Surfaces swept by objects that evolve along a curve (thesis 4.5, 4.7)."""

from __future__ import annotations

import logging
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...curves import Bezier, Curve
from ...errors import SceneError
from .. import values
from .base import Surface

Array = NDArray[Any]
_log = logging.getLogger("bladesmith")


class EvolvedCircles(Surface):
    """The surface swept by a circle that evolves linearly between two (thesis 4.5).

    Parameters
    ----------
    curve : Bezier of first degree, or two circles
        Circles as (center, normal, radius), mappings of these, or coefficients, ``(2, 10)`` as one array.
    align : bool
        Turn the second circle over where the two oppose each other (<C1 C2>_0 < 0): between such circles the
        interpolant may become imaginary. The turn is logged, and `flipped` says so.
    material : Material, optional

    Attributes
    ----------
    flipped : bool
        The second circle was turned over.
    """

    kind = "evolved_circles"

    def __init__(self, curve: Any, *, align: bool = True, material: Any = None) -> None:
        controls = _linear_controls(curve)
        try:
            count = len(controls)
        except TypeError:
            raise SceneError("curve is no curve of circles.") from None
        if count != 2:
            raise SceneError(f"an evolved surface runs between 2 circles; this curve has {count}.")
        first, second = (values.circle(c, f"controls[{i}]") for i, c in enumerate(controls))
        self.flipped = align and _opposed(first, second)
        if self.flipped:
            second = second._replace(normal=-second.normal)
            _log.warning("evolved_circles: the circles oppose each other; the second was turned over (align)")
        self.circles = (first, second)
        super().__init__(material)

    @cached_property
    def frame(self) -> tuple[Array, float]:
        """Centre and unit of length of the surface's own frame: the mean of the circles, and their size."""
        first, second = self.circles
        center = (first.center + second.center) / 2
        apart = float(np.max(np.abs(first.center - second.center)))
        return center, max(first.radius, second.radius, apart)

    @property
    def program_kind(self) -> str:
        return f"{self.kind}_1"

    @property
    def parameters(self) -> Array:
        center, size = self.frame
        local = [((c.center - center) / size, c.normal, c.radius / size) for c in self.circles]
        return np.array([[*center, size, 1 / size, *(x for c, n, r in local for x in (*c, *n, r))]])


def _linear_controls(curve: Any) -> Any:
    """Controls of a Bezier curve between unit objects, as they were given; what is no curve is taken for controls."""
    if isinstance(curve, Curve) and not (isinstance(curve, Bezier) and curve.kind.constraints):
        raise SceneError(f"an evolved surface follows a Bezier curve of unit circles, not a {type(curve).__name__}.")
    return curve.given if isinstance(curve, Bezier) else curve


def _opposed(first: values.Circle, second: values.Circle) -> bool:
    """Whether <C1 C2>_0 < 0, from the circles' own vectors.

    <C1 C2>_0 of dual circles S1* ^ P1*, S2* ^ P2* is (S1.P2)(P1.S2) - (S1.S2)(P1.P2) up to the sign of I5^2.
    """
    apart = second.center - first.center
    r1, r2 = first.radius, second.radius
    spheres = (r1 * r1 + r2 * r2 - apart @ apart) / (2 * r1 * r2)
    crossed = (second.normal @ apart / r1) * (first.normal @ apart / r2)
    return bool(spheres * (first.normal @ second.normal) + crossed < 0)
