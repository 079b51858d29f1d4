"""Structure of a mechanism: bodies and joints by name, and the joints as linear relations in one frame."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.algebra.algebra import Kind
from ...codegen.errors import ConstraintError, InputError, suggest
from ...common.validation import as_choice, as_float, as_instance, as_tuple, as_word
from ...core.geometry.scaling import length_powers
from ...core.multivector import Algebra, Multivector
from ...dispatch.algorithm_loops import TARGETS
from ...mechanics.joints.base import Joint
from ...mechanics.joints.displaced import DisplacedJoint, closure_errors
from ...mechanics.joints.local_relations import Frame, Relation, relations, to_world
from ...mechanics.screws import geometry
from .graph import Tree, spanning_tree
from .loop_closure import Block, Loops, decompose

Array = NDArray[Any]
#: Singular values below this fraction of the largest are zero: redundant constraints.
TOLERANCE = 1e-9
#: Closure error, in the joint's own length, above which a joint is open.
CLOSED = 1e-6
#: Relative velocity below which a unit speed's effect is a rounding error.
NOISE = 1e-8
#: Rounding errors of far-away coefficients in velocities.
ROUNDINGS = 1000
#: Rounding errors of far-away coefficients in loop closures and their singular values.
CLOSURE_ROUNDINGS = 100
#: Closure error from far-away coefficients, at most.
MAX_CLOSURE_TOL = 1e-3


class Assembly:
    """Bodies and the joints between them, with the linear relations of the joints: the data of a `Mechanism`."""

    def __init__(
        self, bodies: Sequence[str], fixed: str, joints: Sequence[Joint] = (), tolerance: float = TOLERANCE,
        target: str = "c",
    ) -> None:  # fmt: skip
        names = list(as_tuple(bodies, "bodies", str))
        for name in names:
            as_word(name, "the name of a body")
            if names.count(name) > 1:
                raise InputError(f"there are two bodies {name!r}; names of bodies are distinct.")
        if fixed not in names:
            raise InputError(f"fixed={fixed!r} is not in bodies.{suggest(str(fixed), names)}")
        self.bodies, self.fixed = tuple(names), fixed
        self.tolerance = as_float(tolerance, "the tolerance", above=0, below=1)
        self.target = as_choice(target, "target", TARGETS)
        self.moving = tuple(name for name in names if name != fixed)
        self._body_indices = {name: i for i, name in enumerate(self.moving)} | {fixed: -1}
        self._joints: list[Joint] = []
        self._joint_indices: dict[str, int] = {}
        self._joint_ids: set[int] = set()
        self._couplings: list[dict[tuple[int, int], float]] = []
        for joint in as_tuple(joints, "joints", Joint):
            self.add(joint)

    # -- making --------------------------------------------------------------------------------------------

    def add(self, joint: Joint, name: str | None = None) -> Joint:
        """Add a joint; its name can be used in inputs and outputs.

        Raises
        ------
        InputError
            If a body is not in the mechanism, the name is taken, or the algebra differs from that of the other joints.
        """
        as_instance(joint, "a joint", Joint, "one of bladesmith.kinematics")
        if type(joint) is Joint:
            raise InputError("Joint is a base class; take a joint of bladesmith.kinematics, as Revolute.")
        if id(joint) in self._joint_ids:
            raise InputError(f"{joint.label} is already a joint of this mechanism.")
        if name is not None:
            as_word(name, f"the name of {joint.label}")
        for body in (joint.a, joint.b):
            self.body_index(body, joint.label)
        if name is not None and (name in self._joint_indices or name in self._body_indices):
            raise InputError(f"the name {name!r} is taken; names of bodies and joints are distinct.")
        algebra = _algebra_of(joint)
        if self._joints and algebra.name != self.algebra.name:
            raise InputError(f"{joint.label} is of {algebra.name}, the joints before it of {self.algebra.name}.")
        if name is not None:
            self._joint_indices[name] = len(self._joints)
        self._joints.append(joint)
        self._joint_ids.add(id(joint))
        self._forget()
        return joint

    def couple(self, coefficients: Mapping[Any, float]) -> None:
        """Add a linear relation of joints: the sum of coefficients times speeds is zero.

        Parameters
        ----------
        coefficients : mapping
            By joint or its name, where it has one freedom, or by ``(joint, k)`` for its freedom k; speeds are in
            radians, or in lengths along the joint. ``{"finger_2": 1, "finger_1": -1}``: a finger that follows another.

        Raises
        ------
        InputError
            If there is no such joint, it is named twice, or a coefficient is not finite.
        """
        row: dict[tuple[int, int], float] = {}
        for key, value in as_instance(coefficients, "a coupling", Mapping, "a mapping of joints to numbers").items():
            joint, k = key if isinstance(key, tuple) and len(key) == 2 else (key, 0)
            j = self.find_joint(joint)
            if j is None:
                raise InputError(
                    f"a coupling names {joint!r}, which is not a joint of this mechanism."
                    f"{suggest(str(joint), self.joint_names)}"
                )
            count = self._joints[j].mobility
            if not 0 <= k < count or (count > 1 and key is joint):
                raise InputError(
                    f"a coupling names freedom {k} of {self.joint_names[j]}, which has {count}.",
                    remedy="Give (joint, k), with k from 0",
                )
            if (j, k) in row:
                raise InputError(f"a coupling names {self.joint_names[j]} twice.")
            row[j, k] = as_float(value, f"the coefficient of {self.joint_names[j]}")
        if not any(row.values()):
            raise InputError("a coupling has at least one coefficient that is not zero.")
        self._couplings.append(row)
        self._forget()

    @property
    def couplings(self) -> tuple[dict[tuple[str, int], float], ...]:
        """Linear relations of joints: coefficients by name of a joint and index of its freedom."""
        return tuple({(self.joint_names[j], k): c for (j, k), c in row.items()} for row in self._couplings)

    def _forget(self) -> None:
        """Forget results that another joint or coupling changes."""
        for name in [k for k in vars(self) if isinstance(getattr(type(self), k, None), cached_property)]:
            del self.__dict__[name]

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle bodies, joints and couplings; cached results and compiled drivers are left out."""
        return _restore, (
            type(self), self.bodies, self.fixed, self.tolerance, self.target, self._joints, dict(self._joint_indices),
            self._couplings,
        )  # fmt: skip

    @property
    def joints(self) -> tuple[Joint, ...]:
        """Joints in the order in which they were added."""
        return tuple(self._joints)

    @cached_property
    def _indices_by_id(self) -> dict[int, int]:
        """Index of each joint by identity, for two may be equal; a displaced joint counts as the original one, too."""
        return {id(x.joint if isinstance(x, DisplacedJoint) else x): j for j, x in enumerate(self._joints)} | {
            id(x): j for j, x in enumerate(self._joints)
        }

    @cached_property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints; the labels of joints without a name."""
        names = {j: name for name, j in self._joint_indices.items()}
        return tuple(names.get(j, joint.label) for j, joint in enumerate(self._joints))

    @cached_property
    def algebra(self) -> Algebra:
        """The algebra of the joints' geometry."""
        return _algebra_of(self._joints[0]) if self._joints else geometry(None)

    def body_index(self, body: Any, where: str = "this mechanism") -> int:
        """Index of a body among those that move; -1 for the fixed one."""
        if not isinstance(body, str) or body not in self._body_indices:
            near = suggest(str(body), self.bodies)
            raise InputError(f"{where}: there is no body {body!r}; there are: {', '.join(self.bodies)}.{near}")
        return self._body_indices[body]

    def find_joint(self, x: Any) -> int | None:
        """Index of a joint, given by itself or by its name of `joint_names`; None for anything else."""
        if isinstance(x, Joint):
            if id(x) in self._indices_by_id:
                return self._indices_by_id[id(x)]
            raise InputError(f"{x.label} is not a joint of this mechanism.")
        if not isinstance(x, str) or x in self._joint_indices or x in self._body_indices:
            return self._joint_indices.get(x) if isinstance(x, str) else None
        matches = [j for j, name in enumerate(self.joint_names) if name == x]
        if len(matches) > 1:
            raise InputError(f"{len(matches)} joints are {x}.", remedy="Name them when adding them, or give the joint")
        return matches[0] if matches else None

    # -- relations of the joints -------------------------------------------------------------------------------

    @cached_property
    def _relations_and_frame(self) -> tuple[list[Relation], Frame]:
        for name, gap in self.residuals().items():
            if not gap <= CLOSED:
                raise ConstraintError(
                    f"{name}: the geometry of its two bodies is {gap:.3g} apart, relative to its own size.",
                    remedy="Find a pose that closes the mechanism with solve_pose, or correct the geometry",
                )
        if not self._joints:
            raise InputError("this mechanism has no joints.")
        return relations(self.algebra, self._joints)

    @property
    def frame(self) -> Frame:
        """Origin and unit of length of the mechanism's matrices."""
        return self._relations_and_frame[1]

    @property
    def velocity_tol(self) -> float:
        """Relative velocity that is a rounding error.

        It grows with the square of the distance from the origin, because coefficients hold squared coordinates.
        """
        frame = self.frame
        far = float(np.abs(frame.center).max()) / frame.unit
        return float(max(NOISE, ROUNDINGS * np.finfo(float).eps * far**2))

    @cached_property
    def closure_tol(self) -> float:
        """Apparent loop-closure error caused by the rounding of far-away coordinates."""
        frame = self.frame
        far = float(np.abs(frame.center).max()) / frame.unit
        return float(min(CLOSURE_ROUNDINGS * np.finfo(float).eps * far**2, MAX_CLOSURE_TOL))

    @property
    def rank_rtol(self) -> float:
        """Fraction of the largest singular value that counts as zero: the tolerance, or `closure_tol`."""
        return max(self.tolerance, self.closure_tol)

    @cached_property
    def to_world(self) -> Array:
        """The matrix (6, 6) from twists of `frame` to twists of the world."""
        return to_world(self.algebra, self.frame)

    @cached_property
    def from_world(self) -> Array:
        """The matrix (6, 6) from twists of the world to twists of `frame`."""
        return np.linalg.inv(self.to_world)

    def motors_from_world(self, motors: Array) -> Array:
        """Motors (..., 8) in `frame`."""
        kind, scales, shift = self.frame_motor
        motor = self.algebra.wrap(kind, np.ascontiguousarray(motors, float))
        return np.asarray((~shift >> motor).values / scales)

    def motors_to_world(self, motors: Array) -> Array:
        """Motors (..., 8) of `frame` in the world."""
        kind, scales, shift = self.frame_motor
        motor = self.algebra.wrap(kind, np.ascontiguousarray(motors * scales))
        return np.asarray((shift >> motor).values)

    @property
    def frame_motor(self) -> tuple[Kind, Array, Multivector]:
        """Kind of motors, factors of their coefficients by the unit of `frame`, translation to its center."""
        kind = self.algebra.kind("motor")
        scales = self.frame.unit ** length_powers(self.algebra, kind.blades).astype(float)
        return kind, scales, self.algebra.translator(self.frame.center).as_kind(kind, check=False)

    def twists_to_world(self, twists: Array) -> Multivector:
        """Twists (..., 6) of `frame` as multivectors in the world."""
        return self.algebra.wrap(self.algebra.kind("twist"), np.ascontiguousarray(twists @ self.to_world.T))

    def twist_of(self, body: str, speeds: Array) -> Multivector:
        """The twist of a body, in the world, for speeds at the joints of the tree."""
        b = self.body_index(body)
        return self.twists_to_world(np.zeros(6) if b < 0 else self.loops.twist(b, speeds))

    @cached_property
    def drivers(self) -> dict[Any, Any]:
        """Compiled drivers by what they are requested for; forgotten when a joint is added."""
        return {}

    @cached_property
    def pose_plans(self) -> dict[Any, Any]:
        """What calls of single poses share, by the joints that they drive; see `poses.item`."""
        return {}

    @cached_property
    def jacobian_plans(self) -> dict[Any, Any]:
        """What calls of single Jacobians share, by inputs, outputs and method."""
        return {}

    @cached_property
    def tree(self) -> Tree:
        """The spanning tree of bodies, and the joints that close loops."""
        freedoms = [x.free.shape[1] for x in self._relations_and_frame[0]]
        return spanning_tree(self.moving, self.fixed, self._joints, freedoms)

    @cached_property
    def loops(self) -> Loops:
        """Loop-closure equations in the speeds at the joints of the tree."""
        return Loops(self.tree, self._relations_and_frame[0], self._couplings)

    @cached_property
    def _blocks(self) -> list[Block]:
        return decompose(self.loops.matrix, self.rank_rtol)

    def joint_jacobian(self, joint: int) -> Any:
        """Relative twists (6, size) at a joint for unit speeds of the tree (sparse)."""
        return self.loops.joint_jacobian(joint)

    def residuals(self) -> dict[str, float]:
        """Closure error of each joint, relative to its length scale, by its name."""
        return dict(zip(self.joint_names, closure_errors(self.algebra, self._joints), strict=True))

    def residual(self) -> float:
        """The largest of the `residuals`: rounding where all loops close."""
        return max(self.residuals().values(), default=0.0)


def _algebra_of(joint: Joint) -> Algebra:
    return joint.conditions()[0].x.algebra


def _restore(
    kind: type[Assembly], bodies: tuple[str, ...], fixed: str, tolerance: float, target: str, joints: list[Joint],
    names: dict[str, int], couplings: list[dict[tuple[int, int], float]],
) -> Assembly:  # fmt: skip
    assembly, by_index = kind(bodies, fixed, (), tolerance, target), {j: name for name, j in names.items()}
    for j, joint in enumerate(joints):
        assembly.add(joint, by_index.get(j))
    for row in couplings:
        assembly.couple({(joints[j], k): c for (j, k), c in row.items()})
    return assembly
