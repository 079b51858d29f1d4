"""Mechanisms: bodies, the joints between them, their mobility, velocities and poses (thesis 7.6)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from functools import cached_property
from pathlib import Path
from typing import Any, Literal, overload

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ...codegen.errors import ConstraintError, InputError
from ...codegen.export.options import ExportOptions, describes_options
from ...common.deprecation import renamed_attribute, renamed_keywords
from ...common.progress import ProgressOption
from ...common.rich_display import Displayed
from ...common.validation import as_instance, check_shape, short_repr
from ...core.geometry.motors import motors_from
from ...core.multivector import Multivector
from ...dispatch.formulas import ArrayOperand, evaluate
from ...dispatch.item_statuses import raise_first
from ...dispatch.multivector_data import Statuses
from ...mechanics.arguments import multivector_of
from ...mechanics.joints.displaced import DisplacedJoint
from .driver import driver_of
from .dynamics import MechanismDynamics
from .jacobian import Analysis, analyze
from .loop_closure import block_matrix
from .mobility import NOISE, FreeMotion, SelfStress, free_basis, passive_dof, self_stresses
from .poses.batch import Poses
from .poses.item import is_usual, jacobian_item, solve_item
from .poses.jacobians import METHODS, jacobians
from .poses.solver import solve_poses
from .velocity_solver import KnownVelocities

Array = NDArray[Any]


class Mechanism(MechanismDynamics, Displayed):
    """Bodies that joints hold together, at one pose.

    Parameters
    ----------
    bodies : sequence of str
    fixed : str
        The body that does not move.
    joints : sequence of Joint
        Their geometry is in the world, at the current poses of the bodies. `add` takes more.
    tolerance : float
        Fraction of the largest singular value below which one is zero.
    target : {"c", "numba", "cuda"}
        What runs poses and their Jacobians: the results have the same bits. Where there is no C compiler, "c" is numba,
        too. "cuda" computes a pose, or a path, in each thread of a GPU.

    Raises
    ------
    InputError
        If a name occurs twice, or the fixed body is not among the bodies.
    """

    @describes_options
    def export(
        self, language: str, folder: str | Path, driven: Sequence[Any], name: str = "mechanism", *, dtype: str = "",
        split: bool = False, overwrite: bool = False,
    ) -> list[Path]:  # fmt: skip
        """Write the search for poses as a source file that needs nothing of this package; see :doc:`/algebra/export`.

        Parameters
        ----------
        {language}
        {folder}
        driven : sequence of str or Joint
            The joints whose coordinates are given: of one coordinate each.
        {name}
        {dtype}
        {split}
        {overwrite}

        {files}

        Raises
        ------
        InputError
            If a joint is unknown or has not one coordinate, joints are coupled, or numbers are float32.
            {refusals}
        """
        from ...codegen.export.export import export
        from ..exporting.mechanisms import mechanism_items

        options = ExportOptions(
            language, name, dtype, split, overwrite, f"a mechanism of the joints {', '.join(self.joint_names)}"
        )
        if options.precision == "f32":
            raise InputError(
                f"poses of a mechanism are found with float64 numbers, and {language} would have float32.",
                remedy="Export it in a language with float64, without dtype.",
            )
        found = [self.find_joint(x) for x in driven]
        joints = [j for j in found if j is not None]
        if not joints or len(joints) < len(found) or not is_usual(self, joints):
            raise InputError(
                "a mechanism is exported for driven joints of one coordinate each, without couplings.",
                remedy="Name some of its revolute, prismatic and screw joints.",
            )
        driver = driver_of(self, driven=tuple(joints), targets=())
        given, work, speeds = driver.exported_tables()
        given["speeds"] = [speed for _, speed in speeds]
        names = [self.joint_names[j] for j, _ in speeds]
        items = mechanism_items(self.algebra.name, driver.room, given, work, names, self.moving, name)
        return export(items, folder, options)

    # -- mobility --------------------------------------------------------------------------------------

    def constraint_matrix(self) -> Any:
        """The kinematic constraint matrix C of (7.22): C T = 0 for the twists T of all bodies that can move.

        Returns
        -------
        scipy.sparse.csr_array (m, 6 bodies)
            Six columns for each body of `moving`, its twist in the world, in the order of the twist's blades; a row for
            each degree of freedom that a joint removes, orthonormal in `frame`.
        """
        blocks, row = [], 0
        for joint, relation in zip(self._joints, self._relations_and_frame[0], strict=True):
            rows = relation.rows @ self.from_world
            for body, sign in ((self._body_indices[joint.a], -1), (self._body_indices[joint.b], 1)):
                if body >= 0:
                    blocks.append((row, 6 * body, sign * rows))
            row += len(rows)
        for powers in self.loops.coupling_powers:
            for j, power in powers.items():
                for body, sign in zip(self.tree.ends[j], (-1, 1), strict=True):
                    if body >= 0:
                        blocks.append((row, 6 * body, sign * power[None] @ self.from_world))
            row += 1
        return block_matrix(blocks, (row, 6 * len(self.moving)))

    def rank(self) -> int:
        """Rank of the constraint matrix."""
        return 6 * len(self.moving) - self.mobility()

    def mobility(self) -> int:
        """Number of degrees of freedom: the nullity of the constraint matrix."""
        return self.loops.size - sum(part.rank for part in self._blocks)

    def free_motions(self) -> list[FreeMotion]:
        """A basis of the motions that the joints allow.

        Returns
        -------
        list of FreeMotion
            Motions of one body alone first (a rod that spins between two balls), then one for each independent
            coordinate, those near the fixed body first.
        """
        passive = passive_dof(self.loops, self.rank_rtol)
        basis = free_basis(self.loops, self._blocks, [v for _, v in passive])
        return [
            *(FreeMotion(self, v, self.moving[b], True) for b, v in passive),
            *(FreeMotion(self, v, self._coordinate_names[i], False) for i, v in basis),
        ]

    @cached_property
    def _coordinate_names(self) -> list[str]:
        counts = np.diff(self.loops.offsets)
        return [
            self.joint_names[j] + (f"[{k}]" if counts[b] > 1 else "")
            for b, j in enumerate(self.tree.joint)
            for k in range(counts[b])
        ]

    def self_stresses(self) -> list[SelfStress]:
        """Redundant constraints, as wrenches that joints bear against each other without any load."""
        algebra, stresses = self.algebra, []
        for rows in self_stresses(self.loops, self._blocks):
            sizes = np.abs(rows).max(-1)
            bearing = np.flatnonzero(sizes > NOISE * sizes.max(initial=0))
            powers = ArrayOperand(rows[bearing] @ self.from_world, 6, "powers")
            wrenches = evaluate(algebra, "mechanics.of_covector", powers).value
            stresses.append(SelfStress({self.joint_names[j]: wrenches[k] for k, j in enumerate(bearing)}))
        return stresses

    redundant = renamed_attribute("self_stresses")

    @renamed_keywords(against="relative_to")
    def allowed_twists(self, body: str, relative_to: str | None = None) -> Multivector:
        """A basis of a body's twists, in the world.

        Parameters
        ----------
        body : str
        relative_to : str, optional
            Another body; the fixed one, if left out.

        Returns
        -------
        Multivector (k,)
            Orthonormal in the mechanism's frame and length.
        """
        ends = [self.body_index(body), self.body_index(self.fixed if relative_to is None else relative_to)]
        jacobians = [self.loops.body_jacobian(b) if b >= 0 else sparse.csr_array((6, self.loops.size)) for b in ends]
        relative = (jacobians[0] - jacobians[1]).tocsr()
        twists = np.concatenate([np.zeros((6, 0)), *(relative[:, p.columns] @ p.null for p in self._blocks)], 1)
        left, sizes, _ = np.linalg.svd(twists, full_matrices=False)
        basis = left[:, sizes > self.rank_rtol * max(sizes.max(initial=0), 1.0)]
        return self.twists_to_world(basis.T)

    # -- speeds --------------------------------------------------------------------------------------------

    @overload
    def jacobian(
        self, inputs: Any, outputs: Any, strict: bool = ..., poses: Any = ..., method: str = ...,
        status: Literal[False] = ..., threads: int | None = ...,
    ) -> Array: ...  # fmt: skip
    @overload
    def jacobian(
        self, inputs: Any, outputs: Any, strict: bool = ..., poses: Any = ..., method: str = ...,
        *, status: Literal[True], threads: int | None = ...,
    ) -> tuple[Array, Statuses]: ...  # fmt: skip
    def jacobian(
        self, inputs: Any, outputs: Any, strict: bool = True, poses: Any = None, method: str = "elimination",
        status: bool = False, threads: int | None = None,
    ) -> Array | tuple[Array, Statuses]:  # fmt: skip
        """The linear map from speeds of inputs to speeds of outputs (7.25, columns split).

        Parameters
        ----------
        inputs : str, Joint, tuple or list
            A joint, or its name: its speeds, in radians, or in lengths along it. A body: the six coefficients of its
            twist. ``(body, twists)``: speeds along these twists. Or several.
        outputs : str, Joint, tuple or list
            Likewise; ``(body, point)`` is the velocity of a point of the body.
        strict : bool
            False: the nearest inputs that the joints allow, the least speeds of undetermined outputs; see `analysis`.
        poses : Poses or mapping of str to Multivector (...), optional
            Poses to evaluate, all of them in one compiled call; points and twists are still given at the mechanism's
            own pose. Joints that close loops are no inputs there, those whose freedoms vary neither inputs nor outputs.
        method : {"elimination", "general"}
            At poses: elimination of unknown speeds in an order chosen for the mechanism, or orthogonal elimination.
        status : bool
            At poses: return the status of each too, and raise nothing.
        threads : int, optional
            Default: the package's (`bladesmith.set_threads`).

        Returns
        -------
        array (outputs, inputs), or (..., outputs, inputs)
        array of Status (...)
            With ``status``. SINGULAR: outputs are undetermined; UNREACHABLE: the joints do not allow the inputs, or the
            pose does not close the loops; of a pose that was not found that of the pose.

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
            if threads is None or (threads.__class__ is int and threads == 1):
                usual = jacobian_item(self, inputs, outputs, poses, method)
                if usual is not None:
                    return (usual, np.zeros((), np.uint8)) if status else usual
            values, codes, _ = jacobians(self, inputs, outputs, poses, method, threads)
            if strict and not status:
                raise_first(
                    codes, "pose", explain=lambda *_: "; strict=False goes on, status=True says which have none"
                )
            return (values, codes) if status else values
        analysis = analyze(self, inputs, outputs)
        if strict:
            analysis.check()
        return analysis.jacobian

    def analysis(self, inputs: Any, outputs: Any) -> Analysis:
        """The Jacobian with its defects: speeds not allowed, undetermined or lost directions, singular values.

        Printed, it says whether the pose is singular, and along which inputs and outputs; see `Analysis`.
        """
        return analyze(self, inputs, outputs)

    @renamed_keywords(known="velocities")
    def solve(self, velocities: Mapping[Any, Any], strict: bool = True) -> dict[str, Multivector]:
        """Twists of all bodies for those of some, or for the speeds of joints (7.24).

        Parameters
        ----------
        velocities : mapping
            Twists in the world by body, speeds by joint or its name.
        strict : bool
            False: the nearest twists that the joints allow.

        Returns
        -------
        dict of str to Multivector
            By body, in the world. Undetermined motions have the least speeds at the joints.

        Raises
        ------
        ConstraintError
            If the joints do not allow the known speeds.
        """
        if not isinstance(velocities, Mapping) or not velocities:
            raise InputError("solve takes a mapping of bodies to twists, or of joints to speeds.")
        system = KnownVelocities(self)
        for x, value in velocities.items():
            joint = self.find_joint(x)
            if value is None or (joint is None and isinstance(value, Multivector) and value.shape):
                raise InputError(f"one speed or twist is needed for {x!r}; it is given {short_repr(value)}.")
            if joint is not None:
                system.add_joint(joint, value)
            else:
                system.add_body(x, value)
        solution = system.solve(together=True)
        if strict and solution.residual[0] > self.velocity_tol:
            raise ConstraintError(
                f"the known speeds violate the joint constraints (relative residual {solution.residual[0]:.3g}).",
                remedy="Give compatible twists, or strict=False for the nearest ones",
            )
        twists = self.loops.twists(solution.speeds[:, 0])
        return {self.fixed: self.twists_to_world(np.zeros(6))} | {
            name: self.twists_to_world(t) for name, t in zip(self.moving, twists, strict=True)
        }

    # -- poses ---------------------------------------------------------------------------------------------

    def solve_pose(
        self, driven: Mapping[Any, Any] | None = None, targets: Mapping[Any, Any] | None = None, start: Any = None,
        path: bool = False, threads: int | None = None, strict: bool = False, *, progress: ProgressOption = False,
        executor: Executor | None = None,
    ) -> Poses:  # fmt: skip
        """Poses where joints have given coordinates and bodies are at their targets, by Newton's method (compiled).

        Steps are limited, so that a pose is followed from the start to its targets: the solution is on the same
        assembly branch as ``start``.

        Parameters
        ----------
        driven : mapping of joints or names to array (...), or (..., f)
            Coordinates, relative to this mechanism's pose: radians, lengths.
        targets : mapping
            Motors (...) by body, of cga3d or pga3d, or matrices (..., 4, 4), relative to this mechanism's pose, or
            ``(point, positions)``: a point of the body, at this mechanism's pose, and positions (..., 3) for it.
        start : Poses or mapping of str to Multivector, optional
            Poses to start from; default: this mechanism's pose.
        path : bool
            The last axis is a path: each pose starts from the one before it.
        threads : int, optional
            Default: the package's (`bladesmith.set_threads`); with an executor those of each call, one by default.
        strict : bool
            Raise for the first pose that is not found.
        progress : bool or callable
            True: a bar on standard error. A callable gets a `bladesmith.Progress` of poses.
        executor : concurrent.futures.Executor, optional
            Solves parts of a batch, whole paths each, on its workers; the results have the same bits.

        Returns
        -------
        Poses (...)

        Raises
        ------
        ExecutorError
            If workers of the executor fail or end, and do so again.
        Interrupted
            On an interrupt. As that of an `ExecutorError`, its ``partial`` is the poses so far: NaN, and NOT_CONVERGED
            where nothing is proved, for those that were not looked at.
        """
        if targets is None and path is False and threads is None and progress is False and executor is None:
            usual = solve_item(self, driven, start, strict)
            if usual is not None:
                return usual
        return solve_poses(
            self, {} if driven is None else driven, {} if targets is None else targets, start, path, threads, strict,
            progress, executor,
        )  # fmt: skip

    def at(self, motors: Mapping[str, Multivector]) -> Mechanism:
        """The mechanism at another pose, its inertias with it.

        Parameters
        ----------
        motors : mapping of str to Multivector or array (4, 4)
            Displacements of bodies; those that are not named stay.
        """
        as_instance(motors, "a pose", Mapping, "a mapping of bodies to motors")
        one = self.algebra.multivector({"": 1.0}).as_kind("motor")
        displacements = dict.fromkeys(self.bodies, one)
        for name, motor in motors.items():
            self.body_index(name)
            what = f"the motor of {name!r}"
            given = multivector_of(motors_from(motor, self.algebra, what), self.algebra, what)
            displacements[name] = given.as_kind("motor")
            check_shape(given, what, ())
        new = Mechanism(self.bodies, self.fixed, (), self.tolerance, self.target)
        names = {j: name for name, j in self._joint_indices.items()}
        for j, joint in enumerate(self._joints):
            new.add(DisplacedJoint(joint, displacements[joint.a], displacements[joint.b]), names.get(j))
        for row in self._couplings:
            new.couple({(new._joints[j], k): c for (j, k), c in row.items()})
        new._inertias = self.displaced_inertias(displacements)
        return new

    def __repr__(self) -> str:
        return f"<Mechanism: {len(self.moving)} bodies on {self.fixed!r}, {len(self._joints)} joints>"
