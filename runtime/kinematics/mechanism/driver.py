"""Compiled driver of a mechanism: its parameters, in the mechanism's own frame and unit, and calls over threads.

The only module that knows the layout of the driver's structures (templates/c/programs/mechanisms/mechanism_types.h).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.build.extension import load, required_compiler
from ...codegen.programs.mechanisms.config import Cut, Link, MechanismConfig, Target
from ...codegen.programs.mechanisms.layout import JointLayout, MechanismLayout, assign_offsets
from ...codegen.programs.mechanisms.mechanism import mechanism_program
from ...common import parallel
from ...common.memory import check_workspace
from ...core.geometry.scaling import in_units
from ...core.multivector import Multivector
from ...mechanics.joints.base import Condition, Joint
from ...mechanics.motion_closed_kinds import layout_of, matrix_of, on_layout
from ...mechanics.twists import commutator_matrix
from .structure import Assembly

Array = NDArray[Any]
#: Code of a pose or Jacobian that was found, as in templates/c/programs/mechanisms/mechanism_types.h.
DONE = 0
#: Code of a pose whose search stalled.
STUCK = 1
#: Code of a pose whose search ran out of steps.
LATE = 2
#: Code of a pose or Jacobian that is not finite.
NOT_FINITE = 3
#: Code of a Jacobian with undetermined outputs.
OPEN = 1
#: Code of a Jacobian with inputs that the joints do not allow.
NOT_ALLOWED = 2
#: Length of a step of Newton's method at most, in radians and in the mechanism's unit.
STEP = 0.25
#: Closure error that is zero.
CLOSED = 1e-14
#: Steps of Newton's method at most.
ROUNDS = 400
#: Closure errors up to this multiple of `CLOSED` that no longer decrease are rounding errors.
NEARLY = 100
#: Rows with a smaller independent fraction are redundant.
TOLERANCE = 1e-9


@dataclass(frozen=True)
class DriverRequest:
    """Request that a driver is compiled for.

    Parameters
    ----------
    driven : tuple of int
        Joints with given coordinates.
    targets : tuple of (int, tuple or None)
        Bodies with target poses; or with a point, in the world at the start, that has a target position.
    inputs : array (6, k) or None
        Twists of the first target, in the world, that are inputs.
    outputs : tuple of int
        Bodies whose twists are outputs.
    coordinates : tuple of int
        Joints whose speeds are outputs.
    """

    driven: tuple[int, ...] = ()
    targets: tuple[tuple[int, Any], ...] = ()
    inputs: Any = None
    outputs: tuple[int, ...] = ()
    coordinates: tuple[int, ...] = ()


class Driver:
    """A mechanism and a request, compiled."""

    def __init__(self, mechanism: Assembly, request: DriverRequest) -> None:
        self.mechanism, self.request = mechanism, request
        self._tree = mechanism.tree
        self._link_index = {b: i for i, b in enumerate(self._tree.order)}
        algebra = mechanism.algebra
        self._needs = self._program_needs()
        self._layout = assign_offsets(self._needs, {name: algebra.kind(name).size for name in algebra.kinds})
        required_compiler("poses of mechanisms are compiled at their first use")
        self._module = load(mechanism_program(self._needs).extension())
        self.numbers = np.zeros(max(1, self._layout.size))
        self._store()

    # -- parameters -------------------------------------------------------------------------------------

    def _program_needs(self) -> MechanismConfig:
        tree, mechanism = self._tree, self.mechanism
        self._objects = [_objects(mechanism, joint) for joint in mechanism.joints]
        links, cuts = [], []
        for body in tree.order:
            j = tree.joint[body]
            parent = self._link_of(tree.parent[body])
            objects = self._objects[j]
            if objects.varying:
                links.append(Link(parent, 6, 0, ()))
            else:
                relation = mechanism.loops.relations[j]
                driven = j in self.request.driven
                links.append(Link(parent, relation.free.shape[1], len(relation.rows), objects.layouts, driven))
        for j in self.closure_joints:
            a, b = (self._link_of(x) for x in tree.ends[j])
            objects = self._objects[j]
            rows = len(mechanism.loops.relations[j].rows)
            cuts.append(Cut(a, b, rows, objects.layouts, objects.varying))
        targets = tuple(Target(self._link_of(b), 6 if point is None else 3) for b, point in self.request.targets)
        columns = 0 if self.request.inputs is None else np.shape(self.request.inputs)[1]
        outputs = tuple(self._link_of(b) for b in self.request.outputs)
        coordinates = tuple(self._link_of(tree.child_of[j]) for j in self.request.coordinates)
        return MechanismConfig(
            mechanism.algebra.name, tuple(links), tuple(cuts), targets, columns, outputs, coordinates
        )

    def _link_of(self, body: int) -> int:
        return -1 if body < 0 else self._link_index[body]

    @property
    def closure_joints(self) -> list[int]:
        """Joints that are closure equations: those that close loops, and those of the tree whose freedoms vary."""
        varying = [j for j in self._tree.joint if self._objects[j].varying]
        return [*self._tree.loop_joints, *varying]

    def _store(self) -> None:
        offsets: MechanismLayout = self._layout
        relations = self.mechanism.loops.relations
        for link, body in zip(offsets.links, self._tree.order, strict=True):
            j, sign = self._tree.joint[body], self._tree.sign[body]
            objects = self._objects[j]
            if objects.varying:
                self._put(link.free, np.eye(6))
                continue
            self._put(link.free, sign * relations[j].free.T)
            self._put(link.back, sign * np.linalg.pinv(relations[j].rows))
            self._store_objects(link, objects, relations[j].rows)
        for cut, j in zip(offsets.cuts, self.closure_joints, strict=True):
            self._put(cut.rows, relations[j].rows)
            self._store_objects(cut, self._objects[j], relations[j].rows)
        frame = self.mechanism.frame
        for goal, (_, point) in zip(offsets.targets, self.request.targets, strict=True):
            if point is not None:
                self._put(goal.free, (np.asarray(point, float) - frame.center) / frame.unit)
        if self.request.inputs is not None:
            self._put(offsets.right, self.mechanism.from_world @ np.asarray(self.request.inputs, float))

    def _put(self, at: int, values: Array) -> None:
        flat = np.ravel(values)
        self.numbers[at : at + flat.size] = flat

    def _store_objects(self, offsets: JointLayout, objects: _SharedObjects, rows: Array) -> None:
        """Store the objects of a joint, and matrices G with G (X x E) = W E for its rows W."""
        mixed = rows @ np.linalg.pinv(np.concatenate(objects.rates), rcond=1e-9)
        target, at = np.zeros(len(rows)), 0
        for shared, x, matrix in zip(offsets.shared, objects.coefficients, objects.matrices, strict=True):
            function = mixed[:, at : at + len(matrix)] @ matrix
            at += len(matrix)
            self._put(shared.x, x)
            self._put(shared.g, function)
            target += function @ x
        self._put(offsets.h, target)

    # -- calls ---------------------------------------------------------------------------------------------

    def _model(self, tolerance: float = TOLERANCE) -> tuple[Any, Any]:
        ffi = self._module.ffi
        model, numbers = ffi.new("bs_mechanism *"), ffi.from_buffer("double[]", self.numbers)
        model.numbers, model.tolerance = numbers, max(tolerance, self.mechanism.closure_tol)
        model.open = self.mechanism.velocity_tol
        model.step, model.closed, model.rounds = STEP, CLOSED, ROUNDS
        model.nearly = max(NEARLY * CLOSED, self.mechanism.closure_tol)
        return model, numbers

    def links(self, motors: Array, threads: int | None = None) -> Array:
        """Links (items, bodies, 8) of bodies at motors (items, bodies, 8), in the driver's order."""
        links = np.empty_like(motors)
        ffi, lib = self._module.ffi, self._module.lib
        source, target = ffi.from_buffer("double[]", motors), ffi.from_buffer("double[]", links)
        parallel.run(lambda a, b: lib.bs_mechanism_links(source, target, a, b), len(motors), threads)
        return links

    def _run(
        self, part: Callable[[Any, int, int], None], n: int, threads: int | None,
        progress: Callable[[int], None] | None = None,
    ) -> None:  # fmt: skip
        """Run parts of a batch over threads, each with a workspace."""
        size = int(self._module.lib.bs_mechanism_workspace())
        check_workspace(size, min(n, parallel.thread_count(threads)), f"a mechanism of {len(self._needs.links)} bodies")
        new = self._module.ffi.from_buffer
        parallel.run(lambda a, b: part(new(np.empty(size // 8 + 1)), a, b), n, threads, progress=progress)

    @property
    def order(self) -> list[int]:
        """The body of each link."""
        return self._tree.order

    def blank_poses(self, paths: int, steps: int) -> dict[str, Array]:
        """Motors (paths, steps, bodies, 8), largest remaining errors and codes (paths, steps): nothing is found yet."""
        shape = (paths, steps)
        return {
            "motors": np.full((*shape, len(self.order), 8), np.nan), "residual": np.full(shape, np.nan),
            "status": np.full(shape, LATE, np.int32),
        }  # fmt: skip

    def poses(
        self, links: Array, driven: Array, targets: Array, results: dict[str, Array], threads: int | None = None,
        progress: Callable[[int], None] | None = None,
    ) -> None:  # fmt: skip
        """Solve for poses with given displacements of driven coordinates and targets of bodies, into `blank_poses`.

        Arguments have axes (paths, steps, ...): each step of a path starts from the one before it. Links are changed in
        place; progress is in paths.
        """
        ffi, lib, (paths, steps) = self._module.ffi, self._module.lib, links.shape[:2]
        model, numbers = self._model()
        poses = ffi.new("bs_poses *")
        arrays = {"links": links, "driven": driven, "targets": targets, **results}
        codes = arrays.pop("status")
        buffers = [ffi.from_buffer("double[]", x if x.size else np.zeros(1)) for x in arrays.values()]
        for name, buffer in zip(arrays, buffers, strict=True):
            setattr(poses, name, buffer)
        poses.status, poses.steps = ffi.from_buffer("int32_t[]", codes), steps
        self._run(lambda w, a, b: lib.bs_mechanism_poses(model, poses, w, a, b), paths, threads, progress)
        del numbers

    def jacobians(self, links: Array, general: bool = False, threads: int | None = None) -> tuple[Array, Array, Array]:
        """Jacobians (items, outputs, inputs) in the mechanism's frame, the largest closure errors, and codes."""
        ffi, lib, n = self._module.ffi, self._module.lib, len(links)
        rows = 6 * len(self._needs.outputs) + sum(self._needs.links[b].free for b in self._needs.coordinates)
        matrices, residual, status = np.empty((n, rows, self._layout.inputs)), np.empty(n), np.empty(n, np.int32)
        model, numbers = self._model()
        jacobians = ffi.new("bs_jacobians *")
        buffers = [ffi.from_buffer("double[]", x if x.size else np.zeros(1)) for x in (links, matrices, residual)]
        jacobians.links, jacobians.jacobian, jacobians.residual = buffers
        jacobians.status, jacobians.general = ffi.from_buffer("int32_t[]", status), int(general)
        self._run(lambda w, a, b: lib.bs_mechanism_jacobians(model, jacobians, w, a, b), n, threads)
        del numbers
        return matrices, residual, status


@dataclass(frozen=True)
class _SharedObjects:
    """Objects that the bodies of a joint share, in the mechanism's frame and unit.

    Attributes
    ----------
    layouts : tuple of str
    coefficients : list of array (k,)
    matrices : list of array (m, k)
        Linear functions A with B(X, Y) = A Y; identities where the objects are one.
    rates : list of array (m, 6)
        Rates of the conditions for unit twists.
    varying : bool
    """

    layouts: tuple[str, ...]
    coefficients: list[Array]
    matrices: list[Array]
    rates: list[Array]
    varying: bool


def _objects(mechanism: Assembly, joint: Joint) -> _SharedObjects:
    conditions = joint.conditions()
    parts = [_object(mechanism, joint, c) for c in conditions]
    varying = any(c.product is not None for c in conditions)
    return _SharedObjects(
        tuple(p[0] for p in parts), [p[1] for p in parts], [p[2] for p in parts], [p[3] for p in parts], varying
    )


def _object(mechanism: Assembly, joint: Joint, c: Condition) -> tuple[str, Array, Array, Array]:
    algebra, frame = mechanism.algebra, mechanism.frame
    away = ~algebra.translator(frame.center)

    def in_frame(x: Multivector) -> Multivector:
        local = in_units(away >> x, frame.unit)
        return local / float(np.abs(local.values).max())

    y = in_frame(c.y)
    layout = layout_of([y], joint.label)
    if c.product is None:
        matrix = np.eye(algebra.kind(layout).size)
    else:
        product, x = c.product, in_frame(c.x)
        matrix = matrix_of(lambda v: product(x, v), algebra, layout, joint.label)
    rates = matrix @ commutator_matrix(y, layout)
    size = np.linalg.norm(rates)
    return layout, on_layout(y, layout), matrix / size, rates / size


def driver_of(assembly: Assembly, **request: Any) -> Driver:
    """The compiled driver for a request; kept while the assembly stays as it is."""
    key = tuple((name, _key(value)) for name, value in sorted(request.items()))
    if key not in assembly.drivers:
        assembly.drivers[key] = Driver(assembly, DriverRequest(**request))
    driver: Driver = assembly.drivers[key]
    return driver


def _key(value: Any) -> Any:
    return (value.shape, value.tobytes()) if isinstance(value, np.ndarray) else value


__all__: Sequence[str] = ["DriverRequest", "Driver", "driver_of"]
