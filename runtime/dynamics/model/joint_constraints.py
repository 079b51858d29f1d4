"""Joints of a system as constraints: objects of one body, pinned to another's."""

from __future__ import annotations

from typing import Any

from ...codegen.errors import InputError
from ...core.multivector import Multivector
from ...mechanics.joints.base import Condition, Joint
from ...mechanics.screws import couple, wrench
from ...mechanics.system import System
from .constraints import Constraint, Pin, PinLinear, VirtualPower


def joint_constraints(system: System) -> list[Constraint]:
    """Constraints of all joints of a system, in the order of the joints."""
    found: list[Constraint] = []
    for j, joint in enumerate(system.joints):
        found += [_constraint(system, joint, condition) for condition in joint.conditions()]
        if joint.pitch is not None:
            found.append(_advance(system, j, joint.pitch))
    return found


def _advance(system: System, index: int, pitch: float) -> Constraint:
    """A rotation translates by its pitch: the wrench that both do no work against, a force and a couple on the axis."""
    joint, freedoms = system.joints[index], system.freedoms[index]
    if freedoms is None:
        raise InputError(f"{joint.label} is not closed at the start.", remedy="Give the line of the first body alone")
    algebra = next(iter(system.bodies.values())).algebra
    axis = freedoms.axes[0]
    against = wrench(axis, freedoms.position, algebra) - couple(pitch * axis, algebra)
    a, b = (joint.b, joint.a) if joint.a == system.fixed else (joint.a, joint.b)
    return VirtualPower(_in_body(system, b, against), body=a, other=None if b == system.fixed else b)


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
