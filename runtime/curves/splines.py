"""Splines through objects: Kochanek-Bartels (thesis 4.8.6), and interpolation at knots (thesis 3.12.1)."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from ..codegen.errors import InputError
from ..common.validation import as_bool, as_choice, as_int, check_shape, finite_array
from .base import Curve
from .bernstein import (
    Array,
    Pieces,
    cubic_pieces,
    hermite_pieces,
    linear_pieces,
    polynomial_through,
    quadratic_pieces,
)
from .bezier import Bezier, as_beziers
from .control_objects import as_controls, scalars

#: Steps between knots: splines multiply three of them, and divide by them.
SHORTEST, LONGEST = 1e-90, 1e90
#: What a cubic spline does at its ends.
Ends = Literal["not-a-knot", "natural"]


class KochanekBartels(Curve):
    """Kochanek-Bartels spline through its controls, one at each whole t (thesis 4.8.6); t runs over [0, segments].

    The tangents that leave (+) and reach (-) control i are, with tension t, bias b and continuity c of that control,

        V+ = (1 - t)/2 [(1 + b)(1 + c)(X_i - X_i-1) + (1 - b)(1 - c)(X_i+1 - X_i)],
        V- = (1 - t)/2 [(1 + b)(1 - c)(X_i - X_i-1) + (1 - b)(1 + c)(X_i+1 - X_i)].

    At the ends of an open spline the difference that is missing is replaced by the one there is: tangents are the
    one-sided difference, times (1 - t)(1 +- b c). Where continuity is 0 sums and objects are C1.

    Parameters
    ----------
    controls : Multivector (n,), or sequence of n >= 2
        As for `Bezier`.
    tension, bias, continuity : float, or array (n,)
        For all controls, or one for each. All zero is the Catmull-Rom spline.
    closed : bool
        Go on from the last control to the first, and along.
    align : bool
        As for `Bezier`. On a closed spline the last control may still oppose the first.

    Raises
    ------
    InputError, GradeError, ShapeError
    """

    def __init__(
        self,
        controls: Any,
        tension: Any = 0.0,
        bias: Any = 0.0,
        continuity: Any = 0.0,
        closed: bool = False,
        *,
        align: bool = False,
    ) -> None:
        super().__init__(as_controls(controls, align))
        self._shape = tuple(
            scalars(value, len(self), name)
            for value, name in ((tension, "tension"), (bias, "bias"), (continuity, "continuity"))
        )
        self._closed = as_bool(closed, "closed")

    @property
    def closed(self) -> bool:
        """True if the curve ends at its start."""
        return self._closed

    @property
    def segments(self) -> int:
        """Number of cubics: one fewer than controls, or as many where closed."""
        return len(self) if self._closed else len(self) - 1

    def _rows(self, rows: Array) -> Pieces:
        ahead = np.roll(rows, -1, axis=0) - rows
        if not self._closed:
            ahead[-1] = ahead[-2]
        behind = np.roll(ahead, 1, axis=0)
        if not self._closed:
            behind[0] = ahead[0]
        leaving, reaching = (before[:, None] * behind + after[:, None] * ahead for before, after in self._slopes())
        start, end = self._ends()
        return hermite_pieces(self.breaks, rows[start], leaving[start], rows[end], reaching[end])

    def _slopes(self) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
        """Weights (n,) of the differences before and after a control in the tangents that leave and reach it."""
        tension, bias, continuity = self._shape
        before, after = (1 - tension) * (1 + bias) / 2, (1 - tension) * (1 - bias) / 2
        leaving = (1 + continuity) * before, (1 - continuity) * after
        return leaving, ((1 - continuity) * before, (1 + continuity) * after)

    def _ends(self) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Numbers of the controls at the ends of the pieces."""
        start = np.arange(self.segments)
        return start, (start + 1) % len(self)

    def blending(self) -> tuple[NDArray[np.intp], Array]:
        start, end = self._ends()
        members = (start[:, None] + np.arange(-1, 3)) % len(self)
        unit = np.eye(4)
        # of the four controls around a piece: the differences before, in and after it
        before, inside, after = np.broadcast_to(np.diff(unit, axis=0)[:, None], (3, len(start), 4)).copy()
        if not self._closed:
            before[0], after[-1] = inside[0], inside[-1]
        (l0, l1), (r0, r1) = self._slopes()
        leaving = l0[start, None] * before + l1[start, None] * inside
        reaching = r0[end, None] * inside + r1[end, None] * after
        first, last = (np.broadcast_to(row, before.shape) for row in unit[1:3])
        return members, hermite_pieces(self.breaks, first, leaving, last, reaching).ordinates

    def to_beziers(self) -> list[Bezier]:
        """The cubics as Bezier curves over [0, 1], one for each segment."""
        return as_beziers(self)


class Interpolating(Curve):
    """Spline through objects at given knots (thesis 3.12.1); t runs from the first knot to the last.

    Degree 1 is straight between neighbours (C0). Degree 2 is the C1 spline of parabolas that join half way between
    knots, with no joint next to the ends. Degree 3 is the C2 spline of cubics that join at the knots. Through two
    objects goes a straight line whatever the degree, through three a parabola (but a natural cubic).

    Parameters
    ----------
    objects : Multivector (n,), or sequence of n >= 2
        As the controls of `Bezier`.
    knots : array (n,), optional
        Increasing parameters; 0, 1, 2, ... without. Where neighbouring steps have a ratio q, sums of degree 2 and 3
        swing by about q in between, and lose the digits of that.
    degree : 1, 2 or 3
    ends : {"not-a-knot", "natural"}
        A cubic's ends: no joint at the second and the last knot but one, or no second derivative at the ends.
    align : bool
        As for `Bezier`.

    Raises
    ------
    InputError, GradeError, ShapeError
    """

    def __init__(
        self, objects: Any, knots: Any = None, degree: int = 3, *, ends: Ends = "not-a-knot", align: bool = False
    ) -> None:
        degree = as_int(degree, "degree", 1, 3)
        as_choice(ends, "ends", ("not-a-knot", "natural"))
        super().__init__(as_controls(objects, align))
        self._requested_degree = degree
        self._ends = ends
        self._knots = np.arange(float(len(self))) if knots is None else _increasing(knots, len(self))

    @property
    def knots(self) -> Array:
        """Parameters of the objects, (n,)."""
        return self._knots.copy()

    @property
    def breaks(self) -> Array:
        """Parameters where pieces join, and the ends, (segments + 1,)."""
        return self._pieces.breaks.copy()

    @property
    def segments(self) -> int:
        """Number of polynomial pieces."""
        return len(self._pieces.ordinates)

    @property
    def domain(self) -> tuple[float, float]:
        """First and last knot."""
        return float(self._knots[0]), float(self._knots[-1])

    @property
    def _pieces(self) -> Pieces:
        found = self._local
        assert isinstance(found, Pieces)
        return found

    def _rows(self, rows: Array) -> Pieces:
        is_natural = self._ends == "natural"
        if self._requested_degree == 1:
            return linear_pieces(self._knots, rows)
        if len(rows) == 2 or (len(rows) == 3 and not (self._requested_degree == 3 and is_natural)):
            return polynomial_through(self._knots, rows)
        if self._requested_degree == 2:
            return quadratic_pieces(self._knots, rows)
        return cubic_pieces(self._knots, rows, is_natural)

    def to_beziers(self) -> list[Bezier]:
        """The pieces as Bezier curves over [0, 1], one for each segment; piece i runs over breaks[i : i + 2]."""
        return as_beziers(self)


def _increasing(value: Any, count: int) -> Array:
    """Checked knots, whose steps can be squared and divided by."""
    knots = finite_array(value, "knots").copy()
    check_shape(knots, "knots", (count,), remedy="Give one for each object")
    with np.errstate(over="ignore"):
        steps = np.diff(knots)
    if not (steps > 0).all():
        i = int(np.argmin(steps > 0))
        raise InputError(f"knots[{i + 1}] is {knots[i + 1]:g}, which does not exceed knots[{i}], {knots[i]:g}.")
    good = (steps >= SHORTEST) & (steps <= LONGEST)
    if not good.all():
        i = int(np.argmin(good))
        raise InputError(
            f"knots[{i + 1}] - knots[{i}] is {steps[i]:g}; steps from {SHORTEST:g} to {LONGEST:g} are taken.",
            remedy="Measure the parameter in another unit",
        )
    return knots
