"""Joints of a system as constraints: objects of one body, pinned to another's."""

from __future__ import annotations

from typing import Any

from ...core.multivector import Multivector
from ...mechanics.joints.base import Condition, Joint
from ...mechanics.system import System
from .constraints import Constraint, Pin, PinLinear


def joint_constraints(system: System) -> list[Constraint]:
    """Constraints of all joints of a system, in the order of the joints."""
    return [_constraint(system, joint, condition) for joint in system.joints for condition in joint.conditions()]


def _constraint(system: System, joint: Joint, condition: Condition) -> Constraint:
    a, b, x, y, product = joint.a, joint.b, condition.x, condition.y, condition.product
    swapped = a == system.fixed
    if swapped:
        a, b, x, y = b, a, y, x
    own, other = _in_body(system, a, x), _in_body(system, b, y)
    against = None if b == system.fixed else b
    if product is None:
        return Pin(own, other, body=a, other=against)

    def linear(u: Multivector) -> Any:
        return product(u, own) if swapped else product(own, u)

    target = linear(_in_body(system, a, y)) if condition.target is None else condition.target
    return PinLinear(linear, other, target, body=a, other=against)


def _in_body(system: System, name: str, x: Multivector) -> Multivector:
    """An object of the world in a body's frame, at the start."""
    return x if name == system.fixed else ~system.bodies[name].motor >> x
