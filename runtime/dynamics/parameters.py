"""Parameters of simulations by name: how the driver's numbers and its start change with each of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..calls import call
from . import loads as kinds_of_load
from .assembly import Assembly, Row
from .body_numbers import BODY, PLACES, SPRING, mass_matrix
from .constraint_numbers import relative_pose
from .constraints import Pin
from .given import coefficients, of_algebra
from .layouts import on_layout
from .pins import rates_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ..multivector import Multivector

Array = NDArray[Any]
#: Singular values of what pins hold that count as zero, as shares of the largest.
NOISE = 1e-9


@dataclass
class Directions:
    """Of k parameters, one after the other.

    Attributes
    ----------
    numbers : array (n, k, numbers of a simulation)
    start : array (n, k, 2, bodies, 6)
        Twists that move the motors, in the driver's frames, and changes of the twists.
    sizes : array (n, k)
        What a large change of the parameter is, in its own unit: directions are multiplied by it, so that the driver
        compares tangents with the state; results are divided by it.
    """

    numbers: Array
    start: Array
    sizes: Array

    @property
    def count(self) -> int:
        return int(self.sizes.shape[1])

    def component(self, j: int) -> Directions:
        """One parameter."""
        return Directions(self.numbers[:, j : j + 1], self.start[:, j : j + 1], self.sizes[:, j : j + 1])

    @property
    def scaled(self) -> tuple[Array, Array]:
        """Numbers and start, multiplied by the sizes."""
        return self.numbers * self.sizes[..., None], self.start * self.sizes[..., None, None, None]


class Parameters:
    """What can be varied in a simulation.

    Parameters
    ----------
    made : Assembly
    loads : sequence of loads
    duration : float
        For the size of what a parameter that is zero may become.
    """

    def __init__(self, made: Assembly, loads: Sequence[Any], duration: float) -> None:
        self.made, self.duration = made, duration
        self.springs = [load for load in loads if isinstance(load, kinds_of_load.Spring)]
        self.present = made.loads
        self.gravity = sum((g.acceleration for g in loads if isinstance(g, kinds_of_load.Gravity)), np.zeros(3))
        self.numbers = made.numbers

    def by_name(self) -> dict[str, Callable[[], Directions]]:
        """Directions of each, made when asked for. With several bodies the name of one stands in front."""
        found: dict[str, Callable[[], Directions]] = {}
        for i, name in enumerate(self.made.names):
            front = "" if len(self.made.names) == 1 else f"{name}."
            for parameter, make in self._of_body().items():
                found[front + parameter] = partial(make, i)
        if "gravity" in self.present:
            found["gravity"] = self._gravity
        for i in range(len(self.springs)):
            fronts = [f"spring[{i}]", *(["spring"] if len(self.springs) == 1 else [])]
            for front in fronts:
                for place, what in ((6, "stiffness"), (7, "length"), (8, "damping")):
                    found[f"{front}.{what}"] = partial(self._spring_number, i, place, what)
                found[f"{front}.point"] = partial(self._spring_end, i, 0)
                found[f"{front}.anchor"] = partial(self._spring_end, i, 1)
        return found

    def _of_body(self) -> dict[str, Callable[[int], Directions]]:
        found: dict[str, Callable[[int], Directions]] = {
            "mass": self._mass, "inertia": self._inertia, "position": self._position, "orientation": self._orientation,
            "velocity": self._velocity, "angular_velocity": self._angular_velocity,
        }  # fmt: skip
        if "drag" in self.present:
            found["damper.angular"] = partial(self._damper, 0)
            found["damper.linear"] = partial(self._damper, 1)
        if "body_wrench" in self.present:
            found["body_wrench"] = self._body_wrench
        if "world_wrench" in self.present:
            found["world_wrench"] = self._world_wrench
        return found

    # -- sizes ---------------------------------------------------------------------------------------------

    def _mass_of(self, i: int) -> Array:
        return self._per_simulation(self.made.bodies[i].mass)

    def _reach(self, i: int) -> Array:
        """Radius of gyration."""
        return np.sqrt(self._per_simulation(self.made.bodies[i].moments.mean(-1)) / self._mass_of(i))

    def _speeds(self, i: int) -> tuple[Array, Array]:
        """Angular and linear, at least those of one radian in the whole time."""
        body, reach = self.made.bodies[i], self._reach(i)
        w, v = (self._per_simulation(np.linalg.norm(x, axis=-1)) for x in (body.angular_velocity, body.velocity))
        turning = np.maximum(np.maximum(w, v / reach), 1 / self.duration)
        return turning, turning * reach

    def _per_simulation(self, values: Any) -> Array:
        return np.broadcast_to(np.asarray(values, np.float64), (self.made.size,))

    def _new(self, sizes: Array, count: int, numbers: Array | None = None, start: Array | None = None) -> Directions:
        """Directions of some components of the same size; what is left out is zero."""
        n, bodies = self.made.size, len(self.made.bodies)
        return Directions(
            np.zeros((n, count, self.numbers.shape[1])) if numbers is None else numbers,
            np.zeros((n, count, 2, bodies, 6)) if start is None else start,
            np.repeat(sizes[:, None], count, 1),
        )

    # -- mass and inertia ----------------------------------------------------------------------------------

    def _mass(self, i: int) -> Directions:
        numbers = self._with_matrix(i, np.ones(1), np.zeros((1, 3)))
        self._put(numbers, i, "weight", self.gravity[..., None, :])
        return self._new(self._mass_of(i), 1, numbers)

    def _inertia(self, i: int) -> Directions:
        moments = self.made.bodies[i].moments
        found = self._new(self._mass_of(i), 3, self._with_matrix(i, np.zeros(3), np.eye(3)))
        found.sizes = np.broadcast_to(moments, found.sizes.shape).copy()
        return found

    def _with_matrix(self, i: int, mass: Array, moments: Array) -> Array:
        """Numbers with the mass matrix of changes (k,) and (k, 3): it is linear in both. Frames stay."""
        made, body, frame = self.made, self.made.bodies[i], self.made.frames[i]
        inner = (~frame.own * made.algebra.motor_from_matrix(body.axes)).as_kind("motor", check=False)
        inner = inner.reshape(*inner.shape, 1)
        matrix = mass_matrix(made.algebra, mass, moments, inner)
        numbers = np.zeros((made.size, len(mass), self.numbers.shape[1]))
        self._put(numbers, i, "mass", matrix.reshape(*matrix.shape[:-2], 36))
        self._put(numbers, i, "metric", matrix.diagonal(axis1=-2, axis2=-1))
        return numbers

    def _put(self, numbers: Array, i: int, name: str, values: Any) -> None:
        place, count = PLACES[name]
        numbers[:, :, BODY * i + place : BODY * i + place + count] = values

    # -- start ---------------------------------------------------------------------------------------------

    def _position(self, i: int) -> Directions:
        return self._started(i, self._reach(i), self._world_axes(i), None, None, None)

    def _orientation(self, i: int) -> Directions:
        """A rotation vector along the body's axes; velocities of the world stay, and change as the body sees them."""
        body = self.made.bodies[i]
        seen = np.einsum("...ji,...j->...i", body.rotation, body.velocity)[..., None, :]
        axes = np.eye(3)
        return self._started(i, self._per_simulation(1.0), None, axes, np.cross(seen, axes), None)

    def _velocity(self, i: int) -> Directions:
        return self._started(i, self._speeds(i)[1], None, None, self._world_axes(i), None)

    def _angular_velocity(self, i: int) -> Directions:
        return self._started(i, self._speeds(i)[0], None, None, None, np.eye(3))

    def _world_axes(self, i: int) -> Array:
        """The world's axes as the body sees them (..., 3, 3), one after the other."""
        return self.made.bodies[i].rotation

    def _started(
        self, i: int, sizes: Array, ways: Array | None, turns: Array | None, linear: Array | None, angular: Array | None
    ) -> Directions:
        """Changes (..., 3, 3) of place and orientation, of velocity and spin, all along the body's axes."""
        found = self._new(sizes, 3)
        found.start[:, :, 0, i] = self._own(i, turns, ways)
        found.start[:, :, 1, i] = self._own(i, angular, linear)
        if self.made.mode == "subspace":
            free = self._free()
            found.start[:, :, 1] = np.einsum("nij,nkbj->nkbi", free, found.start[:, :, 1])
        self._move_pins(found)
        return found

    def _own(self, i: int, first: Array | None, second: Array | None) -> Array:
        """Coefficients of twists of the body in the driver's frame."""
        if first is None and second is None:
            return np.zeros((1, 3, 6))
        frame = self.made.frames[i].own
        parts = [np.zeros((3, 3)) if x is None else x for x in (first, second)]
        screw = self.made.bodies[i]._screw(*np.broadcast_arrays(*parts))
        return coefficients(~frame.reshape(*frame.shape, 1) >> screw, "twist", "the direction")

    def _free(self) -> Array:
        """From twists to the nearest ones, by kinetic energy, that pins leave (n, 6, 6)."""
        blocks = []
        for name in ("compliance", "mass"):
            place, count = PLACES[name]
            blocks.append(self.numbers[:, place : place + count].reshape(-1, 6, 6))
        return blocks[0] @ blocks[1]

    def _move_pins(self, found: Directions) -> None:
        """A pin without an object of the world is where the body starts; one with it keeps the pose."""
        made = self.made
        held = []
        for row in made.rows:
            if not isinstance(row.constraint, Pin):
                continue
            frame = made.frames[row.body].own
            own = on_layout(~frame >> of_algebra(row.constraint.body_object, made.algebra, "the object"), row.layout)
            pinned = made.algebra.wrap(made.algebra.kind(row.layout).layout, np.ascontiguousarray(own))
            if row.constraint.world_object is None:
                size = made.algebra.kind(row.layout).size
                found.numbers[:, :, row.v : row.v + size] = self._carried(row, pinned, found.start[:, :, 0])
            else:
                held.append(rates_of(pinned, row.layout))
        if held and made.mode == "subspace":
            found.start[:, :, 0, 0] = self._kept(held, found.start[:, :, 0, 0])

    def _carried(self, row: Row, own: Multivector, delta: Array) -> Array:
        """How a pinned object moves where the start is moved by twists (n, k, bodies, 6)."""
        made, algebra = self.made, self.made.algebra
        pose = relative_pose(made, row.body, row.other).as_kind("motor", check=False)
        pose = pose.reshape(*pose.shape, 1)
        moves = algebra.wrap(algebra.kind("twist"), np.ascontiguousarray(delta[:, :, row.body]))
        if row.other >= 0:
            moves = moves - (~pose >> algebra.wrap(algebra.kind("twist"), np.ascontiguousarray(delta[:, :, row.other])))
        rate = call(algebra, "pins.moved_rate", own.reshape(*own.shape, 1), moves).value
        return on_layout(pose >> algebra.wrap(own.kind.layout, rate), row.layout)

    def _kept(self, held: list[Array], delta: Array) -> Array:
        """The nearest directions (n, k, 6), by kinetic energy, that do not move what is held."""
        place, count = PLACES["mass"]
        root = np.linalg.cholesky(self.numbers[:, place : place + count].reshape(-1, 6, 6))  # M = L L^T
        rows = np.concatenate([np.broadcast_to(x, (len(root), *x.shape[-2:])) for x in held], -2)
        moved = np.swapaxes(np.linalg.solve(root, np.swapaxes(rows, -1, -2)), -1, -2)
        off = np.linalg.pinv(moved, NOISE) @ moved
        change = np.linalg.solve(np.swapaxes(root, -1, -2), off @ np.swapaxes(root, -1, -2))
        kept: Array = delta - np.einsum("nij,nkj->nki", change, delta)
        return kept

    # -- loads ---------------------------------------------------------------------------------------------

    def _gravity(self) -> Directions:
        found = self._new(self._accelerations(), 3)
        for i in range(len(self.made.bodies)):
            self._put(found.numbers, i, "weight", self._mass_of(i)[:, None, None] * np.eye(3))
        return found

    def _accelerations(self) -> Array:
        given = self._per_simulation(np.linalg.norm(self.gravity, axis=-1))
        return np.maximum(given, self._reach(0) / self.duration**2)

    def _damper(self, which: int, i: int) -> Directions:
        place = BODY * i + PLACES["drag"][0] + which
        unit = self._mass_of(i) / self.duration * (1 if which else self._reach(i) ** 2)
        found = self._new(np.maximum(self.numbers[:, place], unit), 1)
        found.numbers[:, :, place] = 1
        return found

    def _body_wrench(self, i: int) -> Directions:
        frame = self.made.frames[i].own
        moved = ~frame.reshape(*frame.shape, 1) >> self._unit_wrenches()
        twist = self.made.algebra.kind("twist")
        on = self.made.algebra.wrap(twist, np.ascontiguousarray(coefficients(moved, "twist", "the wrench")))
        return self._wrench(i, "wrench", call(self.made.algebra, "mechanics.covector_of", on).value)

    def _world_wrench(self, i: int) -> Directions:
        shift = self.made.shift
        moved = ~shift.reshape(*shift.shape, 1) >> self._unit_wrenches()
        return self._wrench(i, "world", coefficients(moved, "twist", "the wrench"))

    def _unit_wrenches(self) -> Multivector:
        return self.made.algebra.wrap(self.made.algebra.kind("twist"), np.eye(6))

    def _wrench(self, i: int, name: str, values: Array) -> Directions:
        place, count = PLACES[name]
        given = np.abs(self.numbers[:, BODY * i + place : BODY * i + place + count]).max(-1)
        found = self._new(np.maximum(given, self._mass_of(i) * self._reach(i) / self.duration**2), 6)
        self._put(found.numbers, i, name, values)
        return found

    def _spring_number(self, i: int, place: int, what: str) -> Directions:
        body = max(self.made.springs[i])
        mass, reach = self._mass_of(body), self._reach(body)
        least = {"stiffness": mass / self.duration**2, "length": reach, "damping": mass / self.duration}[what]
        at = self.made.spring_place + SPRING * i + place
        found = self._new(np.maximum(np.abs(self.numbers[:, at]), least), 1)
        found.numbers[:, :, at] = 1
        return found

    def _spring_end(self, i: int, end: int) -> Directions:
        body = self.made.springs[i][end]
        axes: Array = np.eye(3)
        if body >= 0:  # to the driver's frame: columns of the turn that takes points there
            axes = np.swapaxes(self.made.algebra.matrix(~self.made.frames[body].own)[..., :3, :3], -1, -2)
        at = self.made.spring_place + SPRING * i + 3 * end
        found = self._new(self._reach(max(self.made.springs[i])), 3)
        found.numbers[:, :, at : at + 3] = axes
        return found
