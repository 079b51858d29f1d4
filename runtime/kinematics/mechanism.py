"""Mechanisms: bodies, the joints between them, and how they can move (thesis 7.6)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ..algebras import Algebra
from ..codegen.errors import ConstraintError, InputError, suggest
from ..dynamics.screws import geometry
from ..multivector import Multivector
from .analysis import Analysis, analysed
from .graph import Tree, spanning_tree
from .inputs import Known
from .joints import Joint
from .local import Frame, Relation, relations, to_world
from .loops import Loops, Part, parts
from .motions import FreeMotion, SelfStress, free_basis, idle_speeds, self_stresses
from .poses import Placed, misfit

Array = NDArray[Any]
#: Singular values below this share of the largest are zero: constraints that say nothing new.
TOLERANCE = 1e-9
#: Objects of a joint that are further apart, in the joint's own length, are not one.
CLOSED = 1e-6


class Mechanism:
    """Bodies that joints hold together, at one pose.

    Parameters
    ----------
    bodies : sequence of str
    fixed : str
        The one that does not move.
    joints : sequence of Joint
        Their geometry is in the world, where the bodies are now. `add` takes more.
    tolerance : float
        Share of the largest singular value below which one is zero.

    Raises
    ------
    InputError
        If a name is there twice, or the fixed body is none of the bodies.
    """

    def __init__(
        self, bodies: Sequence[str], fixed: str, joints: Sequence[Joint] = (), tolerance: float = TOLERANCE
    ) -> None:
        names = [bodies] if isinstance(bodies, str) else list(bodies)
        for name in names:
            if not isinstance(name, str) or not name:
                raise InputError(f"a body is named {name!r}; a word is needed.")
            if names.count(name) > 1:
                raise InputError(f"there are two bodies {name!r}; each has a name of its own.")
        if fixed not in names:
            raise InputError(f"the fixed body {fixed!r} is none of the bodies.{suggest(str(fixed), names)}")
        if not 0 < tolerance < 1:
            raise InputError(f"the tolerance is {tolerance!r}; a share between 0 and 1 is needed.")
        self.bodies, self.fixed, self.tolerance = tuple(names), fixed, float(tolerance)
        self.moving = tuple(name for name in names if name != fixed)
        self._numbers = {name: i for i, name in enumerate(self.moving)} | {fixed: -1}
        self._joints: list[Joint] = []
        self._names: dict[str, int] = {}
        for joint in joints:
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
            raise InputError(f"a joint is a {type(joint).__name__}; one of bladesmith.kinematics is needed.")
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
        for known in [k for k in vars(self) if isinstance(getattr(type(self), k, None), cached_property)]:
            del self.__dict__[known]
        return joint

    @property
    def joints(self) -> tuple[Joint, ...]:
        """In the order in which they were added."""
        return tuple(self._joints)

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
            raise InputError(
                f"{where}: there is no body {body!r}; there are: {', '.join(self.bodies)}.{suggest(str(body), self.bodies)}"
            )
        return self._numbers[body]

    def find_joint(self, x: Any) -> int | None:
        """Which joint is meant, by itself or by its name; None for anything else."""
        if isinstance(x, Joint):
            for j, joint in enumerate(self._joints):
                if joint is x or (isinstance(joint, Placed) and joint.joint is x):
                    return j
            raise InputError(f"{x.label} is no joint of this mechanism.")
        return self._names.get(x) if isinstance(x, str) else None

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
        return parts(self.loops.matrix, self.tolerance)

    def way_of(self, joint: int) -> Any:
        """Relative twists (6, size) at a joint, for unit speeds of the tree (sparse)."""
        a, b = self.tree.ends[joint]
        ways = [self.loops.way(x) if x >= 0 else sparse.csr_array((6, self.loops.size)) for x in (a, b)]
        return (ways[1] - ways[0]).tocsr()

    def constraint_matrix(self) -> Any:
        """The kinematic constraint matrix C of (7.22): C T = 0 for the twists T of all bodies that can move.

        Returns
        -------
        scipy.sparse.csr_array (m, 6 bodies)
            Six columns for each body of `moving`, its twist in the world, in the order of the twist's blades; as many
            rows for each joint as it takes freedoms, orthonormal at the joint's own place and in its own length.
        """
        inverse, at = self.from_world, 0
        rows, columns, values = [], [], []
        for joint, relation in zip(self._joints, self._related[0], strict=True):
            block = relation.rows @ inverse
            for body, sign in ((joint.a, -1), (joint.b, 1)):
                number = self._numbers[body]
                if number >= 0:
                    i, j = np.indices(block.shape)
                    rows.append((at + i).ravel())
                    columns.append((6 * number + j).ravel())
                    values.append((sign * block).ravel())
            at += len(block)
        where = (np.concatenate(rows), np.concatenate(columns))
        return sparse.csr_array((np.concatenate(values), where), shape=(at, 6 * len(self.moving)))

    def rank(self) -> int:
        """Of the constraint matrix."""
        return 6 * len(self.moving) - self.mobility()

    def mobility(self) -> int:
        """How many speeds can be chosen: the nullity of the constraint matrix."""
        return self.loops.size - sum(part.rank for part in self._parts)

    def free_motions(self) -> list[FreeMotion]:
        """A basis of what the joints allow.

        Returns
        -------
        list of FreeMotion
            Motions of one body alone first (a rod that spins between two balls), then one for each coordinate that
            can be chosen, those near the fixed body first.
        """
        idle = idle_speeds(self.loops, self.tolerance)
        made = [FreeMotion(self, v, self.moving[b], True) for b, v in idle]
        names = self._coordinate_names
        return made + [
            FreeMotion(self, v, names[i], False)
            for i, v in free_basis(self.loops, self._parts, [v for _, v in idle])
        ]  # fmt: skip

    @cached_property
    def _coordinate_names(self) -> list[str]:
        counts = np.diff(self.loops.starts)
        return [
            self.joint_names[j] + (f"[{k}]" if counts[b] > 1 else "")
            for b, j in enumerate(self.tree.joint)
            for k in range(counts[b])
        ]

    def redundant(self) -> list[SelfStress]:
        """Constraints that are there twice, as wrenches that joints bear against each other without any load."""
        algebra, found = self.algebra, []
        basis = algebra.wrap(algebra.kind("twist"), np.eye(6))
        for rows in self_stresses(self.loops, self._parts):
            sizes = np.abs(rows).max(-1)
            bearing = np.flatnonzero(sizes > 1e-9 * sizes.max(initial=0))
            powers = rows[bearing] @ self.from_world
            wrenches = _wrenches(basis, powers)
            found.append(SelfStress({self.joint_names[j]: wrenches[k] for k, j in enumerate(bearing)}))
        return found

    def allowed_twists(self, body: str, against: str | None = None) -> Multivector:
        """A basis of a body's twists, in the world.

        Parameters
        ----------
        body : str
        against : str, optional
            Another body; the fixed one, if left out.

        Returns
        -------
        Multivector (k,)
            Orthonormal in the mechanism's frame and length.
        """
        numbers = [self.number(body), self.number(self.fixed if against is None else against)]
        ways = [self.loops.way(b) if b >= 0 else sparse.csr_array((6, self.loops.size)) for b in numbers]
        way = (ways[0] - ways[1]).tocsr()
        found = np.concatenate([np.zeros((6, 0)), *(way[:, p.columns] @ p.null for p in self._parts)], 1)
        left, sizes, _ = np.linalg.svd(found, full_matrices=False)
        kept = left[:, sizes > self.tolerance * max(sizes.max(initial=0), 1.0)]
        return self._world(kept.T)

    # -- speeds --------------------------------------------------------------------------------------------

    def jacobian(self, inputs: Any, outputs: Any, strict: bool = True) -> Array:
        """The linear map from speeds that are chosen to speeds that follow (7.25, columns split).

        Parameters
        ----------
        inputs : str, Joint, tuple or list
            A joint, or its name: its speeds, in radians, or in lengths along it. A body: the six coefficients of its
            twist. ``(body, twists)``: speeds along these twists. Or several.
        outputs : str, Joint, tuple or list
            Likewise; ``(body, point)`` is the velocity of a point that goes with the body.
        strict : bool
            False: what the joints do not allow is left out, and what is left open moves least; see `analysis`.

        Returns
        -------
        array (outputs, inputs)

        Raises
        ------
        ConstraintError, UndeterminedError
            If the joints do not allow an input, or outputs can move while all inputs rest: the direction.
        """
        found = analysed(self, inputs, outputs)
        if strict:
            found.check()
        return found.jacobian

    def analysis(self, inputs: Any, outputs: Any) -> Analysis:
        """The Jacobian, and what is wrong with it: speeds not allowed, open or lost directions, singular values."""
        return analysed(self, inputs, outputs)

    def solve(self, known: Mapping[Any, Any], strict: bool = True) -> dict[str, Multivector]:
        """Twists of all bodies for those of some, or for the speeds of joints (7.24).

        Parameters
        ----------
        known : mapping
            Of bodies to twists in the world, of joints or their names to speeds.
        strict : bool
            False: the nearest that the joints allow.

        Returns
        -------
        dict of str to Multivector
            By body, in the world. What is not determined is as slow as can be, by speeds at the joints.

        Raises
        ------
        ConstraintError
            If the joints do not allow what is known.
        """
        if not isinstance(known, Mapping) or not known:
            raise InputError("solve takes a mapping of bodies to twists, or of joints to speeds.")
        given = Known(self)
        for x, value in known.items():
            joint = self.find_joint(x)
            if joint is not None:
                given.add_joint(joint, value)
            else:
                given.add_body(x, value)
        found = given.solved(together=True)
        if strict and found.residual[0] > 1e-8:
            raise ConstraintError(
                f"the joints do not allow {found.residual[0]:.3g} of what is given.",
                remedy="Give twists that go together, or strict=False for the nearest ones",
            )
        twists = self.loops.twists(found.speeds[:, 0])
        return {self.fixed: self._world(np.zeros(6))} | {
            name: self._world(t) for name, t in zip(self.moving, twists, strict=True)
        }

    def twist_of(self, body: str, speeds: Array) -> Multivector:
        """The twist of a body, in the world, for speeds at the joints of the tree."""
        b = self.number(body)
        return self._world(np.zeros(6) if b < 0 else self.loops.way(b) @ speeds)

    def _world(self, twists: Array) -> Multivector:
        kind = self.algebra.kind("twist")
        return self.algebra.wrap(kind, np.ascontiguousarray(twists @ self.to_world.T))

    # -- poses ---------------------------------------------------------------------------------------------

    def residuals(self) -> dict[str, float]:
        """How far the geometry of each joint's two bodies is apart, in the joint's own length; by joint."""
        return {name: gap for name, gap in zip(self.joint_names, misfit(self.algebra, self._joints), strict=True)}

    def residual(self) -> float:
        """The largest of the `residuals`: whether the loops close."""
        return max(self.residuals().values(), default=0.0)

    def at(self, motors: Mapping[str, Multivector]) -> Mechanism:
        """The mechanism at another pose.

        Parameters
        ----------
        motors : mapping of str to Multivector
            Of bodies, from where they are now; those that are not named stay.
        """
        one = self.algebra.multivector({"": 1.0}).as_kind("motor")
        moved = {name: motors.get(name, one) for name in self.bodies}
        for name in motors:
            self.number(name)
        new = Mechanism(self.bodies, self.fixed, (), self.tolerance)
        named = {j: name for name, j in self._names.items()}
        for j, joint in enumerate(self._joints):
            new.add(Placed(joint, moved[joint.a], moved[joint.b]), named.get(j))
        return new

    def __repr__(self) -> str:
        return f"<Mechanism: {len(self.moving)} bodies on {self.fixed!r}, {len(self._joints)} joints>"


def _algebra_of(joint: Joint) -> Algebra:
    return joint.conditions()[0].x.algebra


def _wrenches(basis: Multivector, powers: Array) -> Multivector:
    """Wrenches (k,) with these powers (k, 6) on the unit twists."""
    from ..calls import Numbers, call

    found = call(basis.algebra, "mechanics.of_covector", Numbers(powers, 6, "powers")).value
    return found  # type: ignore[no-any-return]
