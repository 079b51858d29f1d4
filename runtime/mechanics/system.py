"""Several bodies coupled by joints: closed loops included."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from ..codegen.errors import InputError, suggest
from ..common.validation import as_instance, as_tuple, as_word, finite_array, short_repr
from .arguments import frozen_copy
from .joints.base import Joint
from .joints.freedoms import Freedoms, joint_freedoms
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
    couplings : sequence of mapping, or a single one
        Linear relations of joints, as of `kinematics.Mechanism.couple`: coefficients by ``(joint, k)``, the index of a
        joint and of its freedom; the sum of coefficients times speeds is zero. Those of a `Simulation` have one or two.
    joint_names : sequence of str
        Names of the joints, for trajectories and loads; default: none have.
    joint_coordinates : sequence of float
        Of joints with one freedom at the start: those of trajectories are counted from there. Default: 0.

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
        couplings: Sequence[Mapping[tuple[int, int], float]] | Mapping[tuple[int, int], float] | None = (),
        joint_names: Sequence[str] = (),
        joint_coordinates: ArrayLike | None = None,
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
        self.joint_names = tuple(as_word(x, "a joint's name") for x in as_tuple(joint_names, "the joints' names", str))
        count = len(self.joints)
        if self.joint_names and (len(self.joint_names) != count or len(set(self.joint_names)) != count):
            raise InputError(f"{len(self.joint_names)} names for {count} joints; each has one of its own.")
        given = np.zeros(count) if joint_coordinates is None else joint_coordinates
        values = finite_array(given, "the joints' coordinates", (count,))
        self.joint_coordinates = frozen_copy(np.where([joint.mobility == 1 for joint in self.joints], values, 0.0))
        rows = as_tuple(couplings, "the couplings", Mapping)
        self.couplings = tuple(dict(as_instance(row, "a coupling", Mapping, "a mapping")) for row in rows)
        for row in self.couplings:
            for key in row:
                match key:
                    case (int(j), int(k)) if 0 <= j < len(self.joints) and 0 <= k < self.joints[j].mobility:
                        continue
                raise InputError(f"a coupling names {short_repr(key)}, which is no freedom (joint, k) of the system.")

    @cached_property
    def freedoms(self) -> list[Freedoms | None]:
        """Freedoms of the joints; None of one that is not made of a sequence of motions."""
        return joint_freedoms(next(iter(self.bodies.values())).algebra, self.joints)

    def joint_index(self, joint: Joint | str | int) -> int:
        """Index of a joint by itself, its name or its index.

        Raises
        ------
        InputError
            If it is no joint of the system.
        """
        if isinstance(joint, Joint):
            found = [i for i, each in enumerate(self.joints) if each is joint]
            if found:
                return found[0]
            raise InputError(f"{joint.label} is no joint of the system.")
        if isinstance(joint, str):
            if joint in self.joint_names:
                return self.joint_names.index(joint)
            known = ", ".join(self.joint_names) or "joints without names; give an index, or joint_names= to the System"
            raise InputError(f"there is no joint {joint!r}; there are: {known}.{suggest(joint, self.joint_names)}")
        if isinstance(joint, int | np.integer) and not isinstance(joint, bool) and 0 <= joint < len(self.joints):
            return int(joint)
        raise InputError(f"{short_repr(joint)} is no joint; there are {len(self.joints)}, from 0.")

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
