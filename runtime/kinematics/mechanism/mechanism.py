"""Mechanisms: bodies, the joints between them, and how they can move (thesis 7.6)."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ..calls import raise_first
from ..codegen.errors import ConstraintError, InputError
from ..dynamics.given import of_algebra, shown
from ..multivector import Multivector
from .analysis import Analysis, analysed
from .assembly import Assembly
from .driver import Asked, Driver
from .inputs import Known
from .motions import FreeMotion, SelfStress, free_basis, idle_speeds, self_stresses
from .poses import Placed
from .solving import METHODS, Poses, jacobians, scaled_motors, solved_poses

Array = NDArray[Any]


class Mechanism(Assembly):
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

    # -- how it moves --------------------------------------------------------------------------------------

    def constraint_matrix(self) -> Any:
        """The kinematic constraint matrix C of (7.22): C T = 0 for the twists T of all bodies that can move.

        Returns
        -------
        scipy.sparse.csr_array (m, 6 bodies)
            Six columns for each body of `moving`, its twist in the world, in the order of the twist's blades; as many
            rows for each joint as it takes freedoms, orthonormal in `frame`.
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
        idle = idle_speeds(self.loops, self.share)
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
        kept = left[:, sizes > self.share * max(sizes.max(initial=0), 1.0)]
        return self._world(kept.T)

    # -- speeds --------------------------------------------------------------------------------------------

    def jacobian(
        self, inputs: Any, outputs: Any, strict: bool = True, poses: Any = None, method: str = "elimination",
        status: bool = False, threads: int | None = None,
    ) -> Any:  # fmt: skip
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
        poses : Poses or mapping of str to Multivector (...), optional
            Where to look, all of them in one compiled call; points and twists are still those of the mechanism as it
            is. Joints that close loops, and those whose freedoms vary, are neither inputs nor outputs there.
        method : {"elimination", "general"}
            At poses: unknown speeds eliminated in an order made for the mechanism, or by orthogonal directions.
        status : bool
            At poses: return the status of each too, and raise nothing.
        threads : int, optional

        Returns
        -------
        array (outputs, inputs), or (..., outputs, inputs)
        array of Status (...)
            With ``status``. SINGULAR: outputs are left open; UNREACHABLE: the joints do not allow the inputs, or the
            pose does not close the loops.

        Raises
        ------
        ConstraintError, UndeterminedError
            If the joints do not allow an input, or outputs can move while all inputs rest: the direction.
        """
        if method not in METHODS:
            raise InputError(f"there is no method {method!r}; there are: {', '.join(METHODS)}.")
        if status and poses is None:
            raise InputError("a status goes with poses.", remedy="Give poses, or look at analysis(...)")
        if poses is not None:
            values, found, _ = jacobians(self, inputs, outputs, poses, method, threads)
            if strict and not status:
                raise_first(found, "pose")
            return (values, found) if status else values
        analysis = analysed(self, inputs, outputs)
        if strict:
            analysis.check()
        return analysis.jacobian

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
            if value is None or (joint is None and isinstance(value, Multivector) and value.shape):
                raise InputError(f"one speed or twist is needed for {x!r}; it is given {shown(value)}.")
            if joint is not None:
                given.add_joint(joint, value)
            else:
                given.add_body(x, value)
        found = given.solved(together=True)
        if strict and found.residual[0] > self.noise:
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

    def solve_pose(
        self, driven: Mapping[Any, Any] | None = None, targets: Mapping[Any, Any] | None = None, start: Any = None,
        path: bool = False, threads: int | None = None, strict: bool = False,
    ) -> Poses:  # fmt: skip
        """Poses where joints have given coordinates and bodies are at their targets, by Newton's method (compiled).

        Steps are limited, so that a pose is followed from the start along the way to where it is asked for; the
        solution is the one that hangs together with the start.

        Parameters
        ----------
        driven : mapping of joints or names to array (...), or (..., f)
            Coordinates, from where the joint is in this mechanism: radians, lengths.
        targets : mapping
            Of bodies to motors (...), from where they are in this mechanism, or to ``(point, places)``: a point that
            goes with the body, where it is now, and places (..., 3) for it.
        start : Poses or mapping of str to Multivector, optional
            Where to begin; as the mechanism is, if left out.
        path : bool
            The last axis is a path: each pose starts where the one before it came to.
        threads : int, optional
        strict : bool
            Raise for the first pose that is not found.

        Returns
        -------
        Poses (...)
        """
        given = [{} if x is None else x for x in (driven, targets)]
        return solved_poses(self, given[0], given[1], start, path, threads, strict)

    def driver(self, **asked: Any) -> Driver:
        """The compiled driver for what is asked; kept while the mechanism stays as it is."""
        key = tuple((name, _key(value)) for name, value in sorted(asked.items()))
        drivers = self._drivers
        if key not in drivers:
            drivers[key] = Driver(self, Asked(**asked))
        return drivers[key]

    @cached_property
    def _drivers(self) -> dict[Any, Driver]:
        return {}

    def motors_from_world(self, motors: Array) -> Array:
        """Motors (..., 8) in `frame`."""
        return scaled_motors(self, motors, True)

    def motors_to_world(self, motors: Array) -> Array:
        """Motors (..., 8) of `frame` in the world."""
        return scaled_motors(self, motors, False)

    def at(self, motors: Mapping[str, Multivector]) -> Mechanism:
        """The mechanism at another pose.

        Parameters
        ----------
        motors : mapping of str to Multivector
            Of bodies, from where they are now; those that are not named stay.
        """
        if not isinstance(motors, Mapping):
            raise InputError(f"a pose is a mapping of bodies to motors, not {shown(motors)}.")
        one = self.algebra.multivector({"": 1.0}).as_kind("motor")
        moved = dict.fromkeys(self.bodies, one)
        for name, motor in motors.items():
            self.number(name)
            moved[name] = of_algebra(motor, self.algebra, f"the motor of {name!r}").as_kind("motor")
            if motor.shape:
                raise InputError(f"the motor of {name!r} is a batch {motor.shape}; one pose is needed.")
        new = Mechanism(self.bodies, self.fixed, (), self.tolerance)
        named = {j: name for name, j in self._names.items()}
        for j, joint in enumerate(self._joints):
            new.add(Placed(joint, moved[joint.a], moved[joint.b]), named.get(j))
        return new

    def __repr__(self) -> str:
        return f"<Mechanism: {len(self.moving)} bodies on {self.fixed!r}, {len(self._joints)} joints>"


def _key(value: Any) -> Any:
    return (value.shape, value.tobytes()) if isinstance(value, np.ndarray) else value


def _wrenches(basis: Multivector, powers: Array) -> Multivector:
    """Wrenches (k,) with these powers (k, 6) on the unit twists."""
    from ..calls import Numbers, call

    found = call(basis.algebra, "mechanics.of_covector", Numbers(powers, 6, "powers")).value
    return found  # type: ignore[no-any-return]
