"""Several bodies coupled by joints: closed loops included."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ..codegen.errors import InputError, suggest
from ..kinematics.joints import Condition, Joint
from ..multivector import Multivector
from .bodies import RigidBody
from .constraints import Constraint, Pin, PinLinear
from .given import several, shown


class System:
    """Bodies and the joints between them, for `Simulation`.

    Parameters
    ----------
    bodies : mapping of str to RigidBody, sequence, or a single one
        By name; those of a sequence are called "body_1", "body_2", ...
    joints : sequence of joints, or a single one
        Of `bladesmith.kinematics`; their geometry is in the world where the bodies are at the start.
    fixed : str
        What joints call the world.

    Raises
    ------
    InputError
        If a joint names a body that is not there, or bodies are of different algebras.
    """

    def __init__(
        self,
        bodies: Mapping[str, RigidBody] | Sequence[RigidBody] | RigidBody,
        joints: Sequence[Joint] | Joint | None = (),
        fixed: str = "base",
    ) -> None:
        if isinstance(bodies, Mapping):
            named = dict(bodies)
        else:
            named = {f"body_{i + 1}": b for i, b in enumerate(several(bodies, RigidBody, "the bodies"))}
        if not named:
            raise InputError("a system has at least one body.")
        for name, body in named.items():
            if not isinstance(name, str) or not name:
                raise InputError(f"a body's name is {shown(name)}; a text is needed.")
            if not isinstance(body, RigidBody):
                raise InputError(f"{name} is {shown(body)}; a dynamics.RigidBody is needed.")
        if not isinstance(fixed, str) or not fixed:
            raise InputError(f"fixed is {shown(fixed)}; what joints call the world is a text.")
        if fixed in named:
            raise InputError(f"{fixed!r} is a body, and cannot be the world too; name another with fixed=.")
        if len({body.algebra.name for body in named.values()}) > 1:
            raise InputError("the bodies of a system are of one algebra.")
        self.bodies, self.fixed = named, fixed
        self.joints: tuple[Joint, ...] = several(joints, Joint, "the joints")
        for joint in self.joints:
            self._check(joint)

    def _check(self, joint: Joint) -> None:
        if not isinstance(joint, Joint):
            raise InputError(f"a joint is {shown(joint)}; one of bladesmith.kinematics is needed.")
        for name in (joint.a, joint.b):
            if name not in self.bodies and name != self.fixed:
                known = [*self.bodies, self.fixed]
                raise InputError(
                    f"{joint.label}: there is no body {name!r}; there are: {', '.join(known)}.{suggest(name, known)}"
                )

    def constraints(self) -> list[Constraint]:
        """What the joints are to the driver: objects of one body, pinned to another's."""
        return [self._constraint(joint, condition) for joint in self.joints for condition in joint.conditions()]

    def _constraint(self, joint: Joint, condition: Condition) -> Constraint:
        a, b, x, y, product = joint.a, joint.b, condition.x, condition.y, condition.product
        turned = a == self.fixed
        if turned:
            a, b, x, y = b, a, y, x
        own, other = self._in_body(a, x), self._in_body(b, y)
        against = None if b == self.fixed else b
        if product is None:
            return Pin(own, other, body=a, other=against)

        def linear(u: Multivector) -> Any:
            return product(u, own) if turned else product(own, u)

        target = linear(self._in_body(a, y)) if condition.target is None else condition.target
        return PinLinear(linear, other, target, body=a, other=against)

    def _in_body(self, name: str, x: Multivector) -> Multivector:
        """An object of the world in a body's frame, at the start."""
        return x if name == self.fixed else ~self.bodies[name].motor >> x

    def __repr__(self) -> str:
        return f"<System: {', '.join(self.bodies)}; {len(self.joints)} joints>"
