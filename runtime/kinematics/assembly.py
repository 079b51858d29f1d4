"""Bodies and joints of a mechanism by name, and its joints as relations in one frame."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ..algebras import Algebra
from ..codegen.errors import ConstraintError, InputError, suggest
from ..dynamics.given import number as one_number
from ..dynamics.given import several, shown
from ..dynamics.screws import geometry
from .graph import Tree, spanning_tree
from .joints import Joint
from .local import Frame, Relation, relations, to_world
from .loops import Loops, Part, parts
from .poses import Placed, misfit

Array = NDArray[Any]
#: Singular values below this share of the largest are zero: constraints that say nothing new.
TOLERANCE = 1e-9
#: Objects of a joint that are further apart, in the joint's own length, are not one.
CLOSED = 1e-6
#: Of a unit speed, what counts as rounding, and how many roundings of coefficients far away.
NOISE, ROUNDINGS = 1e-8, 1000
#: How many roundings of coefficients far away blur loops and their singular values, and how much at most.
BLUR, MOST_BLUR = 100, 1e-3


class Assembly:
    """Bodies that joints hold together: what `Mechanism` is made of, and asks questions about."""

    def __init__(
        self, bodies: Sequence[str], fixed: str, joints: Sequence[Joint] = (), tolerance: float = TOLERANCE
    ) -> None:
        names = list(several(bodies, str, "bodies"))
        for name in names:
            if not isinstance(name, str) or not name:
                raise InputError(f"a body is named {name!r}; a word is needed.")
            if names.count(name) > 1:
                raise InputError(f"there are two bodies {name!r}; each has a name of its own.")
        if fixed not in names:
            raise InputError(f"the fixed body {fixed!r} is none of the bodies.{suggest(str(fixed), names)}")
        if not 0 < one_number(tolerance, "the tolerance") < 1:
            raise InputError(f"the tolerance is {tolerance!r}; a share between 0 and 1 is needed.")
        self.bodies, self.fixed, self.tolerance = tuple(names), fixed, float(tolerance)
        self.moving = tuple(name for name in names if name != fixed)
        self._numbers = {name: i for i, name in enumerate(self.moving)} | {fixed: -1}
        self._joints: list[Joint] = []
        self._names: dict[str, int] = {}
        self._held: set[int] = set()
        for joint in several(joints, Joint, "joints"):
            self.add(joint)

    # -- making --------------------------------------------------------------------------------------------

    def add(self, joint: Joint, name: str | None = None) -> Joint:
        """Add a joint, which inputs and outputs may call by a name.

        Raises
        ------
        InputError
            If a body of it is not there, the name is taken, or it is of another algebra than the others.
        """
        if not isinstance(joint, Joint):
            raise InputError(f"a joint is {shown(joint)}; one of bladesmith.kinematics is needed.")
        if type(joint) is Joint:
            raise InputError("Joint is what joints have in common; take one of bladesmith.kinematics, as Revolute.")
        if id(joint) in self._held:
            raise InputError(f"{joint.label} is a joint of this mechanism already.")
        if name is not None and (not isinstance(name, str) or not name):
            raise InputError(f"{joint.label} is named {name!r}; a word is needed.")
        for body in (joint.a, joint.b):
            self.number(body, joint.label)
        if name is not None and (name in self._names or name in self._numbers):
            raise InputError(f"there are two of the name {name!r}; bodies and joints have names of their own.")
        algebra = _algebra_of(joint)
        if self._joints and algebra.name != self.algebra.name:
            raise InputError(f"{joint.label} is of {algebra.name}, the joints before it of {self.algebra.name}.")
        if name is not None:
            self._names[name] = len(self._joints)
        self._joints.append(joint)
        self._held.add(id(joint))
        for known in [k for k in vars(self) if isinstance(getattr(type(self), k, None), cached_property)]:
            del self.__dict__[known]
        return joint

    def __reduce__(self) -> tuple[Any, ...]:
        """Bodies and joints go to other processes; what is found and compiled for them does not."""
        return _remade, (type(self), self.bodies, self.fixed, self.tolerance, self._joints, dict(self._names))

    @property
    def joints(self) -> tuple[Joint, ...]:
        """In the order in which they were added."""
        return tuple(self._joints)

    @cached_property
    def _places(self) -> dict[int, int]:
        """Where joints are, by identity: two may be equal. What was moved answers for what it was."""
        return {id(x.joint if isinstance(x, Placed) else x): j for j, x in enumerate(self._joints)} | {
            id(x): j for j, x in enumerate(self._joints)
        }

    @cached_property
    def joint_names(self) -> tuple[str, ...]:
        """Their names, or what they are and between what."""
        named = {j: name for name, j in self._names.items()}
        return tuple(named.get(j, joint.label) for j, joint in enumerate(self._joints))

    @cached_property
    def algebra(self) -> Algebra:
        """Of the joints' geometry."""
        return _algebra_of(self._joints[0]) if self._joints else geometry(None)

    def number(self, body: Any, where: str = "this mechanism") -> int:
        """Which body: -1 is the fixed one."""
        if not isinstance(body, str) or body not in self._numbers:
            near = suggest(str(body), self.bodies)
            raise InputError(f"{where}: there is no body {body!r}; there are: {', '.join(self.bodies)}.{near}")
        return self._numbers[body]

    def find_joint(self, x: Any) -> int | None:
        """Which joint is meant, by itself or by its name of `joint_names`; None for anything else."""
        if isinstance(x, Joint):
            if id(x) in self._places:
                return self._places[id(x)]
            raise InputError(f"{x.label} is no joint of this mechanism.")
        if not isinstance(x, str) or x in self._names or x in self._numbers:
            return self._names.get(x) if isinstance(x, str) else None
        found = [j for j, name in enumerate(self.joint_names) if name == x]
        if len(found) > 1:
            raise InputError(f"{len(found)} joints are {x}.", remedy="Name them when adding them, or give the joint")
        return found[0] if found else None

    # -- what the joints say -------------------------------------------------------------------------------

    @cached_property
    def _related(self) -> tuple[list[Relation], Frame]:
        for name, gap in self.residuals().items():
            if not gap <= CLOSED:
                raise ConstraintError(
                    f"{name}: the geometry of its two bodies is {gap:.3g} apart, in units of its own size.",
                    remedy="Find a pose that closes the mechanism with solve_pose, or correct the geometry",
                )
        if not self._joints:
            raise InputError("this mechanism has no joints.")
        return relations(self.algebra, self._joints)

    @property
    def frame(self) -> Frame:
        """Where, and in what unit, the mechanism's matrices are held."""
        return self._related[1]

    @property
    def noise(self) -> float:
        """Of a unit speed, what counts as rounding: the coefficients of small things far away hold less."""
        frame = self.frame
        far = float(np.abs(frame.center).max()) / frame.unit
        return float(max(NOISE, ROUNDINGS * np.finfo(float).eps * far**2))

    @cached_property
    def blur(self) -> float:
        """How far loops may seem to be open for the coefficients of small things far away, which hold less."""
        frame = self.frame
        far = float(np.abs(frame.center).max()) / frame.unit
        return float(min(BLUR * np.finfo(float).eps * far**2, MOST_BLUR))

    @property
    def share(self) -> float:
        """Of the largest singular value, what counts as zero: the tolerance, or `blur`."""
        return max(self.tolerance, self.blur)

    @cached_property
    def to_world(self) -> Array:
        """The matrix (6, 6) that takes twists of `frame` to the world's."""
        return to_world(self.algebra, self.frame)

    @cached_property
    def from_world(self) -> Array:
        """Its inverse."""
        return np.linalg.inv(self.to_world)

    @cached_property
    def tree(self) -> Tree:
        """The tree of bodies, and the joints that close loops."""
        found = [x.free.shape[1] for x in self._related[0]]
        return spanning_tree(self.moving, self.fixed, self._joints, found)

    @cached_property
    def loops(self) -> Loops:
        """Speeds at the joints of the tree, and what closes the loops."""
        return Loops(self.tree, self._related[0])

    @cached_property
    def _parts(self) -> list[Part]:
        return parts(self.loops.matrix, self.share)

    def way_of(self, joint: int) -> Any:
        """Relative twists (6, size) at a joint, for unit speeds of the tree (sparse)."""
        a, b = self.tree.ends[joint]
        ways = [self.loops.way(x) if x >= 0 else sparse.csr_array((6, self.loops.size)) for x in (a, b)]
        return (ways[1] - ways[0]).tocsr()

    def residuals(self) -> dict[str, float]:
        """How far the geometry of each joint's two bodies is apart, in the joint's own length; by joint."""
        return {name: gap for name, gap in zip(self.joint_names, misfit(self.algebra, self._joints), strict=True)}

    def residual(self) -> float:
        """The largest of the `residuals`: whether the loops close."""
        return max(self.residuals().values(), default=0.0)


def _algebra_of(joint: Joint) -> Algebra:
    return joint.conditions()[0].x.algebra


def _remade(
    kind: type[Assembly], bodies: tuple[str, ...], fixed: str, tolerance: float, joints: list[Joint],
    names: dict[str, int],
) -> Assembly:  # fmt: skip
    made, named = kind(bodies, fixed, (), tolerance), {j: name for name, j in names.items()}
    for j, joint in enumerate(joints):
        made.add(joint, named.get(j))
    return made
