"""Compiled driver of a mechanism: its parameters, in the mechanism's own frame and unit, and calls over threads.

The only module that knows what the algorithms take (codegen/programs/mechanisms).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.execute.items import CLoop
from ...codegen.programs.mechanisms.config import Cut, Link, MechanismConfig, Output, Target
from ...codegen.programs.mechanisms.program import work_of
from ...codegen.programs.mechanisms.tables import mechanism_tables
from ...codegen.targets.c.instances import ONE_BY_ONE
from ...common import parallel
from ...common.memory import check_workspace, filled
from ...mechanics.joints.local_relations import SLIDE
from ...mechanics.twists import rotational_mask
from .loop_calls import ItemFrame, LoopCall, mechanism_loop, wide_instance
from .shared_objects import SharedObjects, shared_objects
from .structure import Assembly

Array = NDArray[Any]
#: Items, and steps of their paths together, from which on several are computed at once: their program is compiled then,
#: and lanes without an item cost as much as those with one.
WIDE_BATCH, WIDE_STEPS = 6, 256
#: Code of a pose or Jacobian that was found, as in codegen/programs/mechanisms/poses.py and jacobians.py.
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
#: Bytes of work arrays of the items that a GPU runs at a time.
MOST_ON_GPU = 1 << 30
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
    outputs : tuple
        ``(joint,)``: its speeds; ``(body, False)``: its twist in the world, ``(body, True)``: the velocity of a point.
    """

    driven: tuple[int, ...] = ()
    targets: tuple[tuple[int, Any], ...] = ()
    inputs: Any = None
    outputs: tuple[tuple[int] | tuple[int, bool], ...] = ()


class Driver:
    """A mechanism and a request, compiled."""

    def __init__(self, mechanism: Assembly, request: DriverRequest) -> None:
        self.mechanism, self.request = mechanism, request
        self._tree = mechanism.tree
        self._link_index = {b: i for i, b in enumerate(self._tree.order)}
        self._tables = mechanism_tables(self._program_needs())
        self.numbers = np.zeros(self._tables.size)
        self._store()
        self._calls: dict[tuple[str, bool], LoopCall] = {}

    # -- parameters -------------------------------------------------------------------------------------

    def _program_needs(self) -> MechanismConfig:
        tree, mechanism = self._tree, self.mechanism
        self._objects = [shared_objects(mechanism, joint) for joint in mechanism.joints]
        links, cuts = [], []
        for body in tree.order:
            j = tree.joint[body]
            parent = self._link_of(tree.parent[body])
            objects = self._objects[j]
            if objects.varying:
                links.append(Link(body, parent, 6, 0, ()))
            else:
                relation = mechanism.loops.relations[j]
                driven = turning_coordinates(mechanism, j) if j in self.request.driven else ()
                links.append(
                    Link(
                        body, parent, relation.free.shape[1], len(relation.rows), objects.layouts, driven,
                        has_coordinates(mechanism, j),
                    )
                )  # fmt: skip
        for j in self.closure_joints:
            a, b = (self._link_of(x) for x in tree.ends[j])
            objects = self._objects[j]
            rows = len(mechanism.loops.relations[j].rows)
            cuts.append(Cut(a, b, rows, objects.layouts, objects.varying))
        targets = tuple(Target(self._link_of(b), 6 if point is None else 3) for b, point in self.request.targets)
        columns = 0 if self.request.inputs is None else np.shape(self.request.inputs)[1]
        outputs = tuple(
            Output(self._link_of(tree.child_of[x[0]]), 0)
            if len(x) == 1
            else Output(self._link_of(x[0]), 3 if x[1] else 6)
            for x in self.request.outputs
        )
        return MechanismConfig(
            mechanism.algebra.name, tuple(links), tuple(cuts), targets, columns, outputs, self._places()
        )

    def _places(self) -> tuple[int, ...]:
        """Of the driven coordinates, in the order of links, those in the order of the request."""
        starts, at = {}, 0
        for j in self.request.driven:
            starts[j] = at
            at += len(self.mechanism.loops.relations[j].speeds)
        links = [j for j in (self._tree.joint[body] for body in self._tree.order) if j in starts]
        return tuple(starts[j] + k for j in links for k in range(len(self.mechanism.loops.relations[j].speeds)))

    def _link_of(self, body: int) -> int:
        return -1 if body < 0 else self._link_index[body]

    @property
    def closure_joints(self) -> list[int]:
        """Joints that are closure equations: those that close loops, and those of the tree whose freedoms vary."""
        varying = [j for j in self._tree.joint if self._objects[j].varying]
        return [*self._tree.loop_joints, *varying]

    def _store(self) -> None:
        tables = self._tables.arguments
        self._object_table = tables["shared"]
        relations = self.mechanism.loops.relations
        for link, body in zip(tables["links"], self._tree.order, strict=True):
            j, sign = self._tree.joint[body], self._tree.sign[body]
            objects = self._objects[j]
            if objects.varying:
                self._put(link.free, np.eye(6))
                continue
            self._put(link.free, sign * relations[j].free.T)
            self._put(link.inverse, sign * np.linalg.pinv(relations[j].rows))
            self._store_objects(link, objects, relations[j].rows)
        for each in tables["driven"]:
            body = self._tree.order[int(each.link)]
            j, sign = self._tree.joint[body], self._tree.sign[body]
            k = int(each.column - tables["links"][int(each.link)].first)
            self._put(each.unit, 1 / relations[j].speeds[k])
            if each.measure >= 0:
                self._put(each.measure, sign * np.linalg.pinv(relations[j].free)[k])
        for cut, j in zip(tables["cuts"], self.closure_joints, strict=True):
            if cut.matrix >= 0:
                self._put(cut.matrix, relations[j].rows)
            self._store_objects(cut, self._objects[j], relations[j].rows)
        frame = self.mechanism.frame
        rows = iter(tables["outputs"])
        for output in self.request.outputs:
            if len(output) == 1:
                for speed in relations[output[0]].speeds:
                    self._put(next(rows).map, speed)
                continue
            row = next(rows)
            if row.rows == 6:
                self._put(row.map, self.mechanism.to_world)
        for goal, (_, point) in zip(tables["targets"], self.request.targets, strict=True):
            if point is not None:
                self._put(goal.point, (np.asarray(point, float) - frame.center) / frame.unit)
        if self.request.inputs is not None:
            self._put(tables["sizes"].right, self.mechanism.from_world @ np.asarray(self.request.inputs, float))

    def _put(self, at: Any, values: Array) -> None:
        flat = np.ravel(values)
        self.numbers[int(at) : int(at) + flat.size] = flat

    def _store_objects(self, joint: Any, objects: SharedObjects, rows: Array) -> None:
        """Store the objects of a joint, and matrices G with G (X x E) = W E for its rows W."""
        mixed = rows @ np.linalg.pinv(np.concatenate(objects.rates), rcond=1e-9)
        target, at = np.zeros(len(rows)), 0
        own = self._object_table[joint.object : joint.object + joint.objects]
        for shared, x, matrix in zip(own, objects.coefficients, objects.matrices, strict=True):
            function = mixed[:, at : at + len(matrix)] @ matrix
            at += len(matrix)
            self._put(shared.offset, x)
            self._put(shared.part, function)
            target += function @ x
        self._put(joint.values, target)

    # -- calls ---------------------------------------------------------------------------------------------

    def _options(self) -> dict[str, Any]:
        """What is the same in all calls, beside the tables."""
        m = self.mechanism
        tolerances = (
            max(TOLERANCE, m.closure_tol), m.velocity_tol, STEP, CLOSED, max(NEARLY * CLOSED, m.closure_tol)
        )  # fmt: skip
        return {"numbers": self.numbers, "tolerances": np.array(tolerances), "rounds": np.array([ROUNDS])}

    def exported_tables(self) -> tuple[dict[str, Any], dict[str, tuple[int, ...]], list[tuple[int, float]]]:
        """What an exported search for poses is given: tables, shapes of arrays to work in, and for each coordinate in
        its order the driven joint and what a unit of it counts.
        """
        mechanism, order = self.mechanism, self._tree.order
        _, scales, shift = mechanism.frame_motor
        given = {**self._tables.arguments, **self._options(), "scales": scales, "shift": shift.values}
        joints = sorted(self.request.driven, key=lambda j: order.index(self._tree.child_of[j]))
        speeds = [(j, float(mechanism.loops.relations[j].speeds[0])) for j in joints]
        return given, {**self._tables.work(), **work_of(self._tables.room)}, speeds

    @property
    def room(self) -> int:
        """Rows and columns that its algorithms have room for."""
        return self._tables.room

    def _call(self, name: str, is_wide: bool = False) -> LoopCall:
        call = self._calls.get((name, is_wide))
        if call is None:
            tables, algebra, target = self._tables, self.mechanism.algebra.name, self.mechanism.target
            instance = wide_instance(tables.room, target) if is_wide else None
            one = ONE_BY_ONE[0]
            loop, parameters = mechanism_loop(algebra, tables.room, name, target, instance or one)
            work = {**tables.work(), **work_of(tables.room)}
            lanes = 8 * int(instance.bytes) // instance.bits if instance and isinstance(loop, CLoop) else 1
            call = LoopCall(loop, parameters, {**tables.arguments, **self._options()}, work, lanes)
            self._calls[name, is_wide] = call
        return call

    def _run(
        self, name: str, each: dict[str, Array], threads: int | None, progress: Callable[[int], None] | None = None,
        **same: Any,
    ) -> None:  # fmt: skip
        """Run an algorithm over items, in parts, each with work arrays of its own."""
        n = len(next(iter(each.values())))
        steps = math.prod(each["residuals"].shape)
        call = self._call(name, n >= WIDE_BATCH and steps >= WIDE_STEPS)
        chunk = None
        if call.is_on_gpu:
            threads, chunk = 1, max(1, MOST_ON_GPU // max(1, call.size))
        else:
            check_workspace(
                call.size, min(n, parallel.thread_count(threads)), f"a mechanism of {len(self._tree.order)} bodies"
            )
        numbers = {key: np.atleast_1d(value) for key, value in same.items()}

        def part(begin: int, end: int) -> None:
            call({key: array[begin:end] for key, array in each.items()}, numbers)

        parallel.run(part, n, threads, chunk, progress, unit=call.lanes)

    def blank_poses(self, paths: int, steps: int) -> dict[str, Array]:
        """Motors (paths, steps, bodies, 8), largest remaining errors and codes (paths, steps): nothing is found yet."""
        shape = (paths, steps)
        return {
            "motors": filled((*shape, len(self._tree.order), 8), np.nan), "residual": np.full(shape, np.nan),
            "status": np.full(shape, LATE, np.int64),
        }  # fmt: skip

    def poses(
        self, motors: Array, driven: Array, targets: Array, results: dict[str, Array], follows: bool,
        threads: int | None = None, progress: Callable[[int], None] | None = None,
    ) -> None:  # fmt: skip
        """Solve for poses with given driven coordinates and targets of bodies, into `blank_poses`.

        Motors (paths, bodies, 8) are those to start from, the other arguments have axes (paths, steps, ...): each step
        of a path starts from the one before it. Driven coordinates are in the joints' units, those of joints without
        `has_coordinates` displacements; if they follow, they count whole turns from the start. Progress is in paths.
        """
        each = {
            "given": motors, "wanted": driven, "goals": targets, "found": results["motors"],
            "residuals": results["residual"], "statuses": results["status"],
        }  # fmt: skip
        self._run("poses", each, threads, progress, follows=int(follows))

    def pose_frame(self, driven: Array, residual: Array, status: Array, follows: Array) -> ItemFrame | None:
        """The search for one pose in a call, see `poses`; None where there is none.

        Pointers to the motors to start from, "given", and to those that are found, "found", are set for each call.
        """
        same = {"wanted": driven, "residuals": residual, "statuses": status, "follows": follows, "goals": np.zeros(0)}
        size = 8 * len(self._tree.order)
        return self._call("poses").frame({"given": size, "found": size}, same)

    def points(self, positions: Sequence[Any]) -> Array:
        """What `jacobians` takes for points of bodies at the start, in the world."""
        frame = self.mechanism.frame
        rows = [np.append((np.asarray(p, float) - frame.center) / frame.unit, frame.unit) for p in positions]
        return np.concatenate([np.zeros(0), *rows])

    def jacobian_frame(
        self, points: Array, residual: Array, status: Array, general: bool
    ) -> tuple[ItemFrame, tuple[int, int]] | None:
        """One Jacobian in a call, see `jacobians`, and its shape; None where there is no such call.

        Pointers to "given", the motors, and to "jacobian" are set for each call.
        """
        same = {"points": points, "residuals": residual, "statuses": status}
        shape = self._tables.outputs, self._tables.inputs
        sizes = {"given": 8 * len(self._tree.order), "jacobian": math.prod(shape)}
        frame = self._call("general" if general else "elimination").frame(sizes, same)
        return None if frame is None else (frame, shape)

    def jacobians(
        self, motors: Array, points: Array, general: bool = False, threads: int | None = None
    ) -> tuple[Array, Array, Array]:
        """Jacobians (items, outputs, inputs) in the world at motors (items, bodies, 8) of the mechanism's frame, the
        largest closure errors, and codes.
        """
        n, tables = len(motors), self._tables
        matrices, residual, status = np.empty((n, tables.outputs, tables.inputs)), np.empty(n), np.empty(n, np.int64)
        each = {"given": motors, "jacobian": matrices, "residuals": residual, "statuses": status}
        self._run("general" if general else "elimination", each, threads, points=points)
        return matrices, residual, status


def has_coordinates(mechanism: Assembly, joint: int) -> bool:
    """Whether a joint has one or two coordinates that its displacement says, by itself but for whole turns."""
    return len(mechanism.loops.relations[joint].speeds) <= 2 and not mechanism.joints[joint].pitch


def turning_coordinates(mechanism: Assembly, joint: int) -> tuple[bool, ...]:
    """Of each coordinate of a joint, whether it is the same after a whole turn."""
    free = mechanism.loops.relations[joint].free
    turns = np.abs(free[rotational_mask(mechanism.algebra)]).max(0) > SLIDE
    return tuple((turns & (not mechanism.joints[joint].pitch)).tolist())  # another turn of a screw is another place


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
