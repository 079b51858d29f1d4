"""Parameters of simulations by name: derivatives of the driver's parameters and of its start by each of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.algorithms.dynamics.records import SPRING_ENDS, Body, Spring
from ...codegen.errors import InputError
from ...codegen.programs.dynamics.loads import LAW_PLACES
from ...dispatch.formulas import evaluate
from ...mechanics.arguments import coefficients, multivector_of
from ...mechanics.motion_closed_kinds import on_layout
from ...mechanics.twists import commutator_matrix
from ..assembly.body_parameters import angular_places, mass_matrix, rotation_flow_changes
from ..assembly.constraint_parameters import relative_pose
from ..assembly.data import Assembly, DriverConstraint
from ..model import loads as load_types
from ..model.constraints import Pin

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ...core.multivector import Multivector

Array = NDArray[Any]
#: Relative size of singular values of pins that count as zero.
RANK_RTOL = 1e-9
#: Products of inertia that count as zero, of the moments.
AXES_RTOL = 1e-9


@dataclass
class Directions:
    """Derivatives of the driver's input by k components of parameters.

    Attributes
    ----------
    numbers : array (n, k, parameters of a simulation)
    start : array (n, k, 2, bodies, 6)
        Twists that move the motors, in the driver's frames, and changes of the twists.
    sizes : array (n, k)
        Size of a large change of the parameter, in its own unit: directions are multiplied by it, so that the driver
        compares tangents with the state; results are divided by it.
    """

    numbers: Array
    start: Array
    sizes: Array

    @property
    def count(self) -> int:
        return int(self.sizes.shape[1])

    def component(self, j: int) -> Directions:
        """Directions of one component."""
        return Directions(self.numbers[:, j : j + 1], self.start[:, j : j + 1], self.sizes[:, j : j + 1])

    @property
    def scaled(self) -> tuple[Array, Array]:
        """Derivatives of the parameters and of the start, multiplied by the sizes."""
        return self.numbers * self.sizes[..., None], self.start * self.sizes[..., None, None, None]


class Parameters:
    """Parameters of a simulation by which it can be differentiated.

    Parameters
    ----------
    assembly : Assembly
    loads : sequence of loads
    duration : float
        Time of the run, which gives the size of parameters that are zero.
    splits : bool
        Whether the motion is made of turns about principal axes.
    """

    def __init__(self, assembly: Assembly, loads: Sequence[Any], duration: float, splits: bool = False) -> None:
        self.assembly, self.duration, self.splits = assembly, duration, splits
        self.springs = [load for load in loads if isinstance(load, load_types.Spring)]
        self.present = assembly.loads
        self.gravity = sum((g.acceleration for g in loads if isinstance(g, load_types.Gravity)), np.zeros(3))
        self.numbers = assembly.parameters

    def by_name(self) -> dict[str, Callable[[], Directions]]:
        """Functions that compute the directions of each parameter; with several bodies names begin with that of one."""
        by_name: dict[str, Callable[[], Directions]] = {}
        for i, name in enumerate(self.assembly.names):
            prefix = "" if len(self.assembly.names) == 1 else f"{name}."
            for parameter, make in self._body_parameters().items():
                by_name[prefix + parameter] = partial(make, i)
        if "gravity" in self.present:
            by_name["gravity"] = self._gravity
        for i in range(len(self.springs)):
            prefixes = [f"spring[{i}]", *(["spring"] if len(self.springs) == 1 else [])]
            for prefix in prefixes:
                for what in ("stiffness", "length", "damping"):
                    by_name[f"{prefix}.{what}"] = partial(self._spring_parameter, i, what)
                by_name[f"{prefix}.point"] = partial(self._spring_end, i, 0)
                by_name[f"{prefix}.anchor"] = partial(self._spring_end, i, 1)
        return by_name

    def _body_parameters(self) -> dict[str, Callable[[int], Directions]]:
        by_name: dict[str, Callable[[int], Directions]] = {
            "mass": self._mass, "inertia": self._inertia, "position": self._position, "orientation": self._orientation,
            "velocity": self._velocity, "angular_velocity": self._angular_velocity,
        }  # fmt: skip
        for law in load_types.BODY_LAWS:
            if law.law in self.present:
                by_name |= {f"{law.kind}.{name}": partial(self._law, law, name) for name in law.numbers}
        if "body_wrench" in self.present:
            by_name["body_wrench"] = self._body_wrench
        if "world_wrench" in self.present:
            by_name["world_wrench"] = self._world_wrench
        return by_name

    # -- sizes ---------------------------------------------------------------------------------------------

    def _mass_of(self, i: int) -> Array:
        return self._per_simulation(self.assembly.bodies[i].mass)

    def _gyration_radius(self, i: int) -> Array:
        """Radius of gyration."""
        return np.sqrt(self._per_simulation(self.assembly.bodies[i].moments.mean(-1)) / self._mass_of(i))

    def _speeds(self, i: int) -> tuple[Array, Array]:
        """Angular and linear speeds, at least those of one radian in the whole time."""
        body, radius = self.assembly.bodies[i], self._gyration_radius(i)
        w, v = (self._per_simulation(np.linalg.norm(x, axis=-1)) for x in (body.angular_velocity, body.velocity))
        angular = np.maximum(np.maximum(w, v / radius), 1 / self.duration)
        return angular, angular * radius

    def _per_simulation(self, values: Any) -> Array:
        return np.broadcast_to(np.asarray(values, np.float64), (self.assembly.size,))

    def _directions(
        self, sizes: Array, count: int, numbers: Array | None = None, start: Array | None = None
    ) -> Directions:
        """Directions of components of the same size; derivatives are zero by default."""
        n, bodies = self.assembly.size, len(self.assembly.bodies)
        return Directions(
            np.zeros((n, count, self.numbers.shape[1])) if numbers is None else numbers,
            np.zeros((n, count, 2, bodies, 6)) if start is None else start,
            np.repeat(sizes[:, None], count, 1),
        )

    # -- mass and inertia ----------------------------------------------------------------------------------

    def _mass(self, i: int) -> Directions:
        numbers = self._mass_matrix_change(i, np.ones(1), np.zeros((1, 3)))
        self._set(numbers, i, "weight", self.gravity[..., None, :])
        return self._directions(self._mass_of(i), 1, numbers)

    def _inertia(self, i: int) -> Directions:
        moments = self.assembly.bodies[i].moments
        directions = self._directions(self._mass_of(i), 3, self._mass_matrix_change(i, np.zeros(3), np.eye(3)))
        directions.sizes = np.broadcast_to(moments, directions.sizes.shape).copy()
        return directions

    def _mass_matrix_change(self, i: int, mass: Array, moments: Array) -> Array:
        """Derivatives of the mass matrix along changes (k,) and (k, 3), in which it is linear; frames stay."""
        assembly, body, frame = self.assembly, self.assembly.bodies[i], self.assembly.frames[i]
        inner = (~frame.to_body * assembly.algebra.motor_from_matrix(body.axes)).as_kind("motor", check=False)
        inner = inner.reshape(*inner.shape, 1)
        matrix = mass_matrix(assembly.algebra, mass, moments, inner)
        numbers = np.zeros((assembly.size, len(mass), self.numbers.shape[1]))
        diagonal = matrix.diagonal(axis1=-2, axis2=-1)
        inverse, roots, compliance = (self._body_numbers(i, name) for name in ("inverse", "roots", "compliance"))
        self._set(numbers, i, "mass", matrix.reshape(*matrix.shape[:-2], 36))
        self._set(numbers, i, "metric", diagonal)
        self._set(numbers, i, "inverse", -diagonal * inverse[:, None] ** 2)
        self._set(numbers, i, "roots", -diagonal * roots[:, None] ** 3 / 2)
        own = compliance.reshape(-1, 1, 6, 6)
        change = -(own @ matrix @ own)
        self._set(numbers, i, "compliance", change.reshape(*change.shape[:-2], 36))
        places = angular_places(assembly.algebra)
        self._set(numbers, i, "moments", diagonal[..., places])
        self._set(numbers, i, "flows", rotation_flow_changes(frame.moments, diagonal[..., places]))
        turned = np.abs(matrix[..., places[:, None], places] - diagonal[..., places][..., None] * np.eye(3))
        if self.splits and (turned > AXES_RTOL * np.abs(diagonal[..., places]).max(-1)[..., None, None]).any():
            raise InputError(
                "mass and inertia turn the principal axes of this body at its pin, and exact flows are about these.",
                remedy="Use another integrator for sensitivities to them",
            )
        return numbers

    def _body_numbers(self, i: int, name: str) -> Array:
        """A field of a body's record (n, count)."""
        offset, count = Body.extent(name)
        return self.numbers[:, Body.size * i + offset : Body.size * i + offset + count]

    def _set(self, numbers: Array, i: int, name: str, values: Any) -> None:
        offset, count = Body.extent(name)
        numbers[:, :, Body.size * i + offset : Body.size * i + offset + count] = values

    # -- start ---------------------------------------------------------------------------------------------

    def _position(self, i: int) -> Directions:
        return self._start_directions(i, self._gyration_radius(i), self._world_axes(i), None, None, None)

    def _orientation(self, i: int) -> Directions:
        """Rotation vector along the body's axes; velocities stay in the world, and change in the body's frame."""
        body = self.assembly.bodies[i]
        velocity = np.einsum("...ji,...j->...i", body.rotation, body.velocity)[..., None, :]
        axes = np.eye(3)
        return self._start_directions(i, self._per_simulation(1.0), None, axes, np.cross(velocity, axes), None)

    def _velocity(self, i: int) -> Directions:
        return self._start_directions(i, self._speeds(i)[1], None, None, self._world_axes(i), None)

    def _angular_velocity(self, i: int) -> Directions:
        return self._start_directions(i, self._speeds(i)[0], None, None, None, np.eye(3))

    def _world_axes(self, i: int) -> Array:
        """Axes of the world in the body's frame (..., 3, 3), one after the other."""
        return self.assembly.bodies[i].rotation

    def _start_directions(
        self,
        i: int,
        sizes: Array,
        translations: Array | None,
        rotations: Array | None,
        linear: Array | None,
        angular: Array | None,
    ) -> Directions:
        """Changes (..., 3, 3) of position and orientation, of velocity and spin, all along the body's axes."""
        directions = self._directions(sizes, 3)
        directions.start[:, :, 0, i] = self._driver_twists(i, rotations, translations)
        directions.start[:, :, 1, i] = self._driver_twists(i, angular, linear)
        if self.assembly.mode == "subspace":
            projector = self._admissible_projector()
            directions.start[:, :, 1] = np.einsum("nij,nkbj->nkbi", projector, directions.start[:, :, 1])
        return self._with_pins(directions)

    def _driver_twists(self, i: int, angular: Array | None, linear: Array | None) -> Array:
        """Coefficients of twists in the driver's frame, from vectors along the body's axes."""
        if angular is None and linear is None:
            return np.zeros((1, 3, 6))
        frame = self.assembly.frames[i].to_body
        parts = [np.zeros((3, 3)) if x is None else x for x in (angular, linear)]
        screw = self.assembly.bodies[i]._screw(*np.broadcast_arrays(*parts))
        return coefficients(~frame.reshape(*frame.shape, 1) >> screw, "twist", "the direction")

    def _admissible_projector(self) -> Array:
        """Projectors (n, 6, 6) of twists to the nearest ones, by kinetic energy, that pins allow."""
        blocks = []
        for name in ("compliance", "mass"):
            offset, count = Body.extent(name)
            blocks.append(self.numbers[:, offset : offset + count].reshape(-1, 6, 6))
        return blocks[0] @ blocks[1]

    def _with_pins(self, directions: Directions) -> Directions:
        """Directions with the pins: one without an object of the world moves with the start; others keep the pose."""
        assembly = self.assembly
        fixed = []
        for packed in assembly.driver_constraints:
            if not isinstance(packed.constraint, Pin):
                continue
            frame = assembly.frames[packed.body].to_body
            local = on_layout(
                ~frame >> multivector_of(packed.constraint.body_object, assembly.algebra, "the object"), packed.layout
            )
            pinned = assembly.algebra.wrap(assembly.algebra.kind(packed.layout).layout, np.ascontiguousarray(local))
            if packed.constraint.world_object is None:
                size = assembly.algebra.kind(packed.layout).size
                directions.numbers[:, :, packed.object_offset : packed.object_offset + size] = (
                    self._pinned_object_change(packed, pinned, directions.start[:, :, 0])
                )
            else:
                fixed.append(commutator_matrix(pinned, packed.layout))
        if fixed and assembly.mode == "subspace":
            directions.start[:, :, 0, 0] = self._project_onto_pins(fixed, directions.start[:, :, 0, 0])
        return directions

    def _pinned_object_change(self, packed: DriverConstraint, local: Multivector, delta: Array) -> Array:
        """Change of a pinned object's coefficients where the start moves by twists (n, k, bodies, 6)."""
        assembly, algebra = self.assembly, self.assembly.algebra
        pose = relative_pose(assembly, packed.body, packed.other).as_kind("motor", check=False)
        pose = pose.reshape(*pose.shape, 1)
        twists = algebra.wrap(algebra.kind("twist"), np.ascontiguousarray(delta[:, :, packed.body]))
        if packed.other >= 0:
            twists = twists - (
                ~pose >> algebra.wrap(algebra.kind("twist"), np.ascontiguousarray(delta[:, :, packed.other]))
            )
        rate = evaluate(algebra, "pins.moved_rate", local.reshape(*local.shape, 1), twists).value
        return on_layout(pose >> algebra.wrap(local.kind.layout, rate), packed.layout)

    def _project_onto_pins(self, fixed: list[Array], delta: Array) -> Array:
        """Nearest directions (n, k, 6), by kinetic energy, that do not move the pinned objects."""
        offset, count = Body.extent("mass")
        root = np.linalg.cholesky(self.numbers[:, offset : offset + count].reshape(-1, 6, 6))  # M = L L^T
        rows = np.concatenate([np.broadcast_to(x, (len(root), *x.shape[-2:])) for x in fixed], -2)
        moved = np.swapaxes(np.linalg.solve(root, np.swapaxes(rows, -1, -2)), -1, -2)
        forbidden = np.linalg.pinv(moved, RANK_RTOL) @ moved
        change = np.linalg.solve(np.swapaxes(root, -1, -2), forbidden @ np.swapaxes(root, -1, -2))
        projected: Array = delta - np.einsum("nij,nkj->nki", change, delta)
        return projected

    # -- loads ---------------------------------------------------------------------------------------------

    def _gravity(self) -> Directions:
        directions = self._directions(self._accelerations(), 3)
        for i in range(len(self.assembly.bodies)):
            self._set(directions.numbers, i, "weight", self._mass_of(i)[:, None, None] * np.eye(3))
        return directions

    def _accelerations(self) -> Array:
        size = self._per_simulation(np.linalg.norm(self.gravity, axis=-1))
        return np.maximum(size, self._gyration_radius(0) / self.duration**2)

    def _law(self, law: type[load_types.BodyLaw], name: str, i: int) -> Directions:
        at = Body.size * i + Body.offsets["laws"] + LAW_PLACES[law.law].first + list(law.numbers).index(name)
        scales = (self._mass_of(i), self._gyration_radius(i), self._per_simulation(self.duration))
        unit = np.prod([x**power for x, power in zip(scales, law.numbers[name][1], strict=True)], 0)
        directions = self._directions(np.maximum(self.numbers[:, at], unit), 1)
        directions.numbers[:, :, at] = 1
        return directions

    def _body_wrench(self, i: int) -> Directions:
        frame = self.assembly.frames[i].to_body
        local = ~frame.reshape(*frame.shape, 1) >> self._unit_wrenches()
        twist = self.assembly.algebra.kind("twist")
        on = self.assembly.algebra.wrap(twist, np.ascontiguousarray(coefficients(local, "twist", "the wrench")))
        return self._wrench(i, "wrench", evaluate(self.assembly.algebra, "mechanics.covector_of", on).value)

    def _world_wrench(self, i: int) -> Directions:
        shift = self.assembly.shift
        local = ~shift.reshape(*shift.shape, 1) >> self._unit_wrenches()
        return self._wrench(i, "world", coefficients(local, "twist", "the wrench"))

    def _unit_wrenches(self) -> Multivector:
        return self.assembly.algebra.wrap(self.assembly.algebra.kind("twist"), np.eye(6))

    def _wrench(self, i: int, name: str, values: Array) -> Directions:
        offset, count = Body.extent(name)
        size = np.abs(self.numbers[:, Body.size * i + offset : Body.size * i + offset + count]).max(-1)
        directions = self._directions(
            np.maximum(size, self._mass_of(i) * self._gyration_radius(i) / self.duration**2), 6
        )
        self._set(directions.numbers, i, name, values)
        return directions

    def _spring_parameter(self, i: int, what: str) -> Directions:
        body = max(self.assembly.springs[i])
        mass, radius = self._mass_of(body), self._gyration_radius(body)
        least = {"stiffness": mass / self.duration**2, "length": radius, "damping": mass / self.duration}[what]
        at = self.assembly.spring_offset + Spring.size * i + Spring.offsets[what]
        directions = self._directions(np.maximum(np.abs(self.numbers[:, at]), least), 1)
        directions.numbers[:, :, at] = 1
        return directions

    def _spring_end(self, i: int, end: int) -> Directions:
        body = self.assembly.springs[i][end]
        axes: Array = np.eye(3)
        if body >= 0:  # to the driver's frame: columns of the rotation that takes points there
            axes = np.swapaxes(self.assembly.algebra.matrix(~self.assembly.frames[body].to_body)[..., :3, :3], -1, -2)
        at = self.assembly.spring_offset + Spring.size * i + Spring.offsets[SPRING_ENDS[end]]
        directions = self._directions(self._gyration_radius(max(self.assembly.springs[i])), 3)
        directions.numbers[:, :, at : at + 3] = axes
        return directions
