"""Laws of loads on one body: the wrench, as a row, that its state and some numbers give.

A law takes of the body what its arguments are called: ``r``, its motor, ``omega``, its twist, or both; then its center
of mass and a row of numbers, all in its frame. Programs, tangents, series and places of numbers follow from `LAWS`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from ...algebra.multivector import Multivector, select, sqrt
from ...trace.outputs import Result, row
from ..motions.screws import direction_part
from ..objects.euclidean import dot, null_vector
from .mechanics import covector, velocity_at, wrench_at


class DragLaw(NamedTuple):
    """Moment per angular velocity, and force per velocity."""

    angular: Multivector
    linear: Multivector


def drag(omega: Multivector, center: Multivector, law: DragLaw) -> Result:
    """Against the turning of a body, and against the motion of its center."""
    force = -law.linear * velocity_at(omega, center)
    couple = -law.angular * direction_part(omega) * null_vector(omega)
    return row(covector(wrench_at(force, center) + couple), "drag")


class QuadraticDragLaw(NamedTuple):
    """Moment per square of the angular velocity, and force per square of the velocity."""

    angular: Multivector
    linear: Multivector


def quadratic_drag(omega: Multivector, center: Multivector, law: QuadraticDragLaw) -> Result:
    """The same with the squares of the velocities, against their directions."""
    velocity, turning = velocity_at(omega, center), direction_part(omega)
    force = -law.linear * _length(velocity) * velocity
    couple = -law.angular * _length(turning) * turning * null_vector(omega)
    return row(covector(wrench_at(force, center) + couple), "quadratic_drag")


def _length(x: Multivector) -> Multivector:
    """|x|, whose tangent at zero is zero."""
    square = dot(x, x)
    moves = square > 0
    return select(moves, sqrt(select(moves, square, square.constant(1))), square.constant(0))


class Law(NamedTuple):
    """A law, and whether it is analytic: a motion under one that is not has no Taylor series."""

    formula: Callable[..., Any]
    is_analytic: bool = True


LAWS = (Law(drag), Law(quadratic_drag, is_analytic=False))
