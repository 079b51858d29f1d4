"""A mechanism's compiled driver: its numbers, in the mechanism's own frame and unit, and calls over threads.

The only module that knows the layout of the driver's structures (templates/c/mechanism_types.h).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .. import parallel
from ..codegen.build import load
from ..codegen.programs.mechanism import Cut, Link, Needs, Target, mechanism_program
from ..codegen.programs.plan import Numbered, Placed, numbered
from ..dynamics.layouts import layout_of, matrix_of, on_layout
from ..dynamics.pins import rates_of
from ..lengths import in_units
from ..multivector import Multivector
from .joints import Condition, Joint

if TYPE_CHECKING:
    from .mechanism import Mechanism

Array = NDArray[Any]
#: How a pose or a Jacobian came out, as in templates/c/mechanism_types.h.
DONE, STUCK, LATE, NOT_FINITE = range(4)
OPEN, NOT_ALLOWED = 1, 2
#: Turns, and lengths in the mechanism's unit, of one step of Newton's method at most; errors that are none; steps.
STEP, CLOSED, ROUNDS = 0.25, 1e-14, 400
#: Errors that grow no less at so many times what is none are rounding.
NEARLY = 100
#: Rows of which less than this share is new say nothing new.
TOLERANCE = 1e-9


@dataclass(frozen=True)
class Asked:
    """What a driver is made for.

    Parameters
    ----------
    driven : tuple of int
        Joints whose coordinates are given.
    targets : tuple of (int, tuple or None)
        Bodies with poses to reach; or with a point, in the world at the start, of which the place is to be reached.
    inputs : array (6, k) or None
        Twists of the first target, of the world, that are inputs.
    outputs : tuple of int
        Bodies whose twists are asked for.
    coordinates : tuple of int
        Joints whose speeds are asked for.
    """

    driven: tuple[int, ...] = ()
    targets: tuple[tuple[int, Any], ...] = ()
    inputs: Any = None
    outputs: tuple[int, ...] = ()
    coordinates: tuple[int, ...] = ()


class Driver:
    """A mechanism and what is asked of it, compiled."""

    def __init__(self, mechanism: Mechanism, asked: Asked) -> None:
        self.mechanism, self.asked = mechanism, asked
        self._tree = mechanism.tree
        self._place = {b: i for i, b in enumerate(self._tree.order)}  # of bodies among links
        algebra = mechanism.algebra
        self._needs = self._made_needs()
        self._numbered = numbered(self._needs, {name: algebra.kind(name).size for name in algebra.kinds})
        self._module = load(mechanism_program(self._needs).extension())
        self.numbers = np.zeros(max(1, self._numbered.size))
        self._store()

    # -- what there is -------------------------------------------------------------------------------------

    def _made_needs(self) -> Needs:
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
                driven = j in self.asked.driven
                links.append(Link(parent, relation.free.shape[1], len(relation.rows), objects.layouts, driven))
        for j in self.cut_joints:
            a, b = (self._link_of(x) for x in tree.ends[j])
            objects = self._objects[j]
            rows = len(mechanism.loops.relations[j].rows)
            cuts.append(Cut(a, b, rows, objects.layouts, objects.varying))
        targets = tuple(Target(self._link_of(b), 6 if point is None else 3) for b, point in self.asked.targets)
        columns = 0 if self.asked.inputs is None else np.shape(self.asked.inputs)[1]
        outputs = tuple(self._link_of(b) for b in self.asked.outputs)
        coordinates = tuple(self._link_of(tree.hung_by[j]) for j in self.asked.coordinates)
        return Needs(mechanism.algebra.name, tuple(links), tuple(cuts), targets, columns, outputs, coordinates)

    def _link_of(self, body: int) -> int:
        return -1 if body < 0 else self._place[body]

    @property
    def cut_joints(self) -> list[int]:
        """Joints that are rows: those that close loops, and those of the tree whose freedoms vary."""
        varying = [j for j in self._tree.joint if self._objects[j].varying]
        return [*self._tree.cuts, *varying]

    def _store(self) -> None:
        places: Numbered = self._numbered
        relations = self.mechanism.loops.relations
        for place, body in zip(places.links, self._tree.order, strict=True):
            j, sign = self._tree.joint[body], self._tree.sign[body]
            objects = self._objects[j]
            if objects.varying:
                self._put(place.free, np.eye(6))
                continue
            self._put(place.free, sign * relations[j].free.T)
            self._put(place.back, sign * np.linalg.pinv(relations[j].rows))
            self._share(place, objects, relations[j].rows)
        for place, j in zip(places.cuts, self.cut_joints, strict=True):
            self._put(place.rows, relations[j].rows)
            self._share(place, self._objects[j], relations[j].rows)
        frame = self.mechanism.frame
        for place, (_, point) in zip(places.targets, self.asked.targets, strict=True):
            if point is not None:
                self._put(place.free, (np.asarray(point, float) - frame.center) / frame.unit)
        if self.asked.inputs is not None:
            self._put(places.right, self.mechanism.from_world @ np.asarray(self.asked.inputs, float))

    def _put(self, at: int, values: Array) -> None:
        flat = np.ravel(values)
        self.numbers[at : at + flat.size] = flat

    def _share(self, place: Placed, objects: _Objects, rows: Array) -> None:
        """Shares of shared objects in rows: G with G (X x E) = W E."""
        mixed = rows @ np.linalg.pinv(np.concatenate(objects.rates), rcond=1e-9)
        target, at = np.zeros(len(rows)), 0
        for shared, x, matrix in zip(place.shared, objects.coefficients, objects.matrices, strict=True):
            own = mixed[:, at : at + len(matrix)] @ matrix
            at += len(matrix)
            self._put(shared.x, x)
            self._put(shared.g, own)
            target += own @ x
        self._put(place.h, target)

    # -- calls ---------------------------------------------------------------------------------------------

    def _model(self, tolerance: float = TOLERANCE) -> tuple[Any, Any]:
        ffi = self._module.ffi
        model, numbers = ffi.new("bs_mechanism *"), ffi.from_buffer("double[]", self.numbers)
        model.numbers, model.tolerance = numbers, max(tolerance, self.mechanism.blur)
        model.open = self.mechanism.noise
        model.step, model.closed, model.rounds = STEP, CLOSED, ROUNDS
        model.nearly = max(NEARLY * CLOSED, self.mechanism.blur)
        return model, numbers

    def links(self, motors: Array, threads: int | None = None) -> Array:
        """Links (items, bodies, 8) of bodies at motors (items, bodies, 8), in the driver's order."""
        found = np.empty_like(motors)
        ffi, lib = self._module.ffi, self._module.lib
        given, to = ffi.from_buffer("double[]", motors), ffi.from_buffer("double[]", found)
        parallel.run(lambda a, b: lib.bs_mechanism_links(given, to, a, b), len(motors), threads)
        return found

    @property
    def order(self) -> list[int]:
        """Which body each link is."""
        return self._tree.order

    def poses(
        self, links: Array, driven: Array, targets: Array, threads: int | None = None, steps: int = 1
    ) -> tuple[Array, Array, Array]:
        """Motors (items, bodies, 8) where driven coordinates have gone their way and targets are reached, the
        largest error left (items,), and how it went (items,); links are moved in place. So many steps in a row are a
        path, of which each starts where the one before it came to."""
        ffi, lib, n = self._module.ffi, self._module.lib, len(links)
        motors, residual, status = np.empty_like(links), np.empty(n), np.empty(n, np.int32)
        model, kept = self._model()
        given = ffi.new("bs_poses *")
        arrays = {"links": links, "driven": driven, "targets": targets, "motors": motors, "residual": residual}
        buffers = [ffi.from_buffer("double[]", x if x.size else np.zeros(1)) for x in arrays.values()]
        for name, buffer in zip(arrays, buffers, strict=True):
            setattr(given, name, buffer)
        given.status, given.steps = ffi.from_buffer("int32_t[]", status), steps
        parallel.run(lambda a, b: lib.bs_mechanism_poses(model, given, a, b), n // steps, threads)
        del kept
        return motors, residual, status

    def jacobians(self, links: Array, general: bool = False, threads: int | None = None) -> tuple[Array, Array, Array]:
        """Jacobians (items, outputs, inputs) in the mechanism's frame, the largest errors of joints, and status."""
        ffi, lib, n = self._module.ffi, self._module.lib, len(links)
        rows = 6 * len(self._needs.outputs) + sum(self._needs.links[b].free for b in self._needs.coordinates)
        found, residual, status = np.empty((n, rows, self._numbered.inputs)), np.empty(n), np.empty(n, np.int32)
        model, kept = self._model()
        given = ffi.new("bs_jacobians *")
        buffers = [ffi.from_buffer("double[]", x if x.size else np.zeros(1)) for x in (links, found, residual)]
        given.links, given.jacobian, given.residual = buffers
        given.status, given.general = ffi.from_buffer("int32_t[]", status), int(general)
        parallel.run(lambda a, b: lib.bs_mechanism_jacobians(model, given, a, b), n, threads)
        del kept
        return found, residual, status


@dataclass(frozen=True)
class _Objects:
    """What a joint's bodies share, in the mechanism's frame and unit.

    Attributes
    ----------
    layouts : tuple of str
    coefficients : list of array (k,)
    matrices : list of array (m, k)
        Of linear functions: A of B(X, Y) = A Y; ones where the objects are one.
    rates : list of array (m, 6)
        Of what is asked for, by unit twists.
    varying : bool
    """

    layouts: tuple[str, ...]
    coefficients: list[Array]
    matrices: list[Array]
    rates: list[Array]
    varying: bool


def _objects(mechanism: Mechanism, joint: Joint) -> _Objects:
    conditions = joint.conditions()
    parts = [_object(mechanism, joint, c) for c in conditions]
    varying = any(c.product is not None for c in conditions)
    return _Objects(
        tuple(p[0] for p in parts), [p[1] for p in parts], [p[2] for p in parts], [p[3] for p in parts], varying
    )


def _object(mechanism: Mechanism, joint: Joint, c: Condition) -> tuple[str, Array, Array, Array]:
    algebra, frame = mechanism.algebra, mechanism.frame
    away = ~algebra.translator(frame.center)

    def own(x: Multivector) -> Multivector:
        moved = in_units(away >> x, frame.unit)
        size = float(np.abs(moved.values).max())
        return moved / size

    y = own(c.y)
    layout = layout_of([y], joint.label)
    if c.product is None:
        matrix = np.eye(algebra.kind(layout).size)
    else:
        product, x = c.product, own(c.x)
        matrix = matrix_of(lambda v: product(x, v), algebra, layout, joint.label)
    rates = matrix @ rates_of(y, layout)
    size = np.linalg.norm(rates)
    return layout, on_layout(y, layout), matrix / size, rates / size


__all__: Sequence[str] = ["Asked", "Driver"]
