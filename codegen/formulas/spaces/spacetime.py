"""Events, velocities and rotors of spacetime, Cl(1,3,0): e0 is the observer's time, the speed of light is 1."""

from __future__ import annotations

from ...algebra.multivector import Multivector, cos, sin, sqrt
from ...status import Status
from ...trace.outputs import Result
from ..products.outcome import outcome, where_or_nan


def event(time: Multivector, position: Multivector) -> Multivector:
    """t e0 + x."""
    return time * position.basis("e0") + position


def velocity(v: Multivector) -> tuple[Multivector, Result]:
    """(e0 + v)/sqrt(1 - v^2): the unit vector along the motion. INVALID: not slower than light."""
    rest = 1 + (v * v).grade(0)  # v v = -|v|^2
    slow = rest > 0
    return (v.basis("e0") + v) / sqrt(where_or_nan(slow, rest)), outcome(v, (~slow, Status.INVALID))


def boost(v: Multivector) -> tuple[Multivector, Result]:
    """The rotor that takes e0 to the velocity u of v, in their plane: (1 + u e0)/sqrt(2 (1 + u . e0))."""
    u, status = velocity(v)
    e0 = v.basis("e0")
    return (1 + u * e0) / sqrt(2 * (1 + (u | e0))), status


def rotor(axis: Multivector, angle: Multivector) -> tuple[Multivector, Result]:
    """cos(angle/2) + sin(angle/2) times the plane of a unit axis, e12 for e3: counter-clockwise. INVALID: axis zero."""
    square = -(axis * axis).grade(0)
    regular = square > 0
    a = axis / sqrt(where_or_nan(regular, square))
    plane = (a * axis.basis("e123")).grade(2)
    return cos(angle / 2) - sin(angle / 2) * plane, outcome(axis, (~regular, Status.INVALID))
