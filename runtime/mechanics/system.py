"""Several bodies coupled by joints: closed loops included."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ..codegen.errors import InputError, suggest
from ..common.validation import as_instance, as_tuple, as_word
from .joints.base import Joint
from .rigid_body import RigidBody


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
            named = {f"body_{i + 1}": b for i, b in enumerate(as_tuple(bodies, "the bodies", RigidBody))}
        if not named:
            raise InputError("a system has at least one body.")
        for name, body in named.items():
            as_word(name, "a body's name")
            as_instance(body, name, RigidBody, "a dynamics.RigidBody")
        as_word(fixed, "fixed")
        if fixed in named:
            raise InputError(f"{fixed!r} is a body, and cannot be the world too; name another with fixed=.")
        if len({body.algebra.name for body in named.values()}) > 1:
            raise InputError("the bodies of a system are of one algebra.")
        self.bodies, self.fixed = named, fixed
        self.joints: tuple[Joint, ...] = as_tuple(joints, "the joints", Joint)
        for joint in self.joints:
            self._check(joint)

    def _check(self, joint: Joint) -> None:
        as_instance(joint, "a joint", Joint, "one of bladesmith.kinematics")
        for name in (joint.a, joint.b):
            if name not in self.bodies and name != self.fixed:
                known = [*self.bodies, self.fixed]
                raise InputError(
                    f"{joint.label}: there is no body {name!r}; there are: {', '.join(known)}.{suggest(name, known)}"
                )

    def __repr__(self) -> str:
        return f"<System: {', '.join(self.bodies)}; {len(self.joints)} joints>"
