"""Laws of joints: the force of springs, dampers, friction and limits, from the coordinate and the speed."""

from __future__ import annotations

from typing import NamedTuple

from ...algebra.multivector import Multivector, select, sqrt


class JointLaw(NamedTuple):
    """Stiffness, where the spring rests, damping; friction, and the speed at which it is 0.7 of itself; limits.

    Limits are springs of one side, with damping while they are pressed.
    """

    stiffness: Multivector
    rest: Multivector
    damping: Multivector
    friction: Multivector
    slip: Multivector
    lower: Multivector
    upper: Multivector
    stop_stiffness: Multivector
    stop_damping: Multivector


def joint_law(x: Multivector, speed: Multivector, law: JointLaw) -> Multivector:
    """Force along a joint: -k (x - x0) - d v - f v/sqrt(v^2 + s^2), and that of a limit that is passed."""
    nothing, one = x.constant(0), x.constant(1)
    above, below = x > law.upper, x < law.lower
    over = select(above, x - law.upper, select(below, x - law.lower, nothing))
    pressed = select(above, one, select(below, one, nothing))
    free = -law.stiffness * (x - law.rest) - law.damping * speed
    sliding = law.friction * speed / sqrt(speed * speed + law.slip * law.slip)
    return free - sliding - law.stop_stiffness * over - pressed * law.stop_damping * speed
