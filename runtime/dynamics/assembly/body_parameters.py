"""Parameters of bodies, springs and loads as the compiled driver reads them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.algorithms.dynamics.records import LAW_NUMBERS, Body, Coupling, Spring
from ...codegen.programs.dynamics.config import LOADS
from ...codegen.programs.dynamics.loads import LAW_PLACES
from ...core.multivector import Multivector
from ...dispatch.formulas import ArrayOperand, evaluate
from ...mechanics.arguments import coefficients, multivector_of
from ..model import loads as load_types
from .callbacks import arity
from .data import Assembly, item_of

if TYPE_CHECKING:
    from ...core.multivector import Algebra

Array = NDArray[Any]


def loads_present(loads: Sequence[Any]) -> tuple[str, ...]:
    """Types of loads that a program needs, in the order of the program."""
    present = set()
    for load in loads:
        constant = isinstance(getattr(load, "wrench", None), Multivector)
        match load:
            case load_types.Gravity():
                present.add("gravity")
            case load_types.Spring():
                present.add("spring")
            case load_types.BodyLaw():
                present |= {load.law} if load.other is None else {load.law, "coupling"}
            case load_types.BodyWrench():
                present.add("body_wrench" if constant else "user")
            case _:
                present.add("world_wrench" if constant else "user")
    return tuple(name for name in LOADS if name in present)


def mass_matrix(algebra: Algebra, mass: Any, moments: Array, frame: Multivector) -> Array:
    """Mass matrices (..., 6, 6); see the formula `mechanics.mass_matrix`."""
    row: Array = evaluate(
        algebra,
        "mechanics.mass_matrix",
        ArrayOperand(mass, 0, "the mass"),
        algebra.spatial(moments, "the moments"),
        frame,
    ).value
    return row.reshape(*row.shape[:-1], 6, 6)


def pack_bodies(assembly: Assembly, loads: Sequence[Any]) -> None:
    """Add mass, inertia, frame and constant loads of each body."""
    algebra = assembly.algebra
    gravity = sum((load.acceleration for load in loads if isinstance(load, load_types.Gravity)), np.zeros(3))
    for i, (body, frame) in enumerate(zip(assembly.bodies, assembly.frames, strict=True)):
        numbers = Body.zeros(assembly.size)

        axes = algebra.motor_from_matrix(body.axes)  # from the principal axes to the body's
        matrix = mass_matrix(algebra, body.mass, body.moments, (~frame.to_body * axes).as_kind("motor", check=False))
        metric = matrix.diagonal(axis1=-2, axis2=-1)
        inverse = 1 / metric
        if frame.allowed is not None:
            inverse = np.where(frame.allowed, inverse, 0.0)
            allowed = np.flatnonzero(frame.allowed)
            compliance = np.zeros(matrix.shape)
            inner = (..., allowed[:, None], allowed)
            compliance[inner] = np.linalg.inv(matrix[inner])
            numbers.compliance = compliance
        numbers.metric = metric
        numbers.inverse = inverse
        numbers.roots = np.sqrt(1 / metric)
        numbers.mass = matrix
        numbers.weight = np.asarray(body.mass)[..., None] * gravity
        numbers.center = algebra.matrix(~frame.to_body)[..., :3, 3]
        numbers.flows = rotation_flows(frame.moments)
        numbers.moments = frame.moments
        numbers.world = constant_wrenches(assembly, i, loads, load_types.WorldWrench, assembly.shift)
        in_body = constant_wrenches(assembly, i, loads, load_types.BodyWrench, frame.to_body)
        numbers.wrench = evaluate(algebra, "mechanics.covector_of", algebra.wrap(algebra.kind("twist"), in_body)).value
        numbers.laws = law_numbers(assembly, i, loads)
        assembly.append(np.asarray(numbers))


def law_numbers(assembly: Assembly, body: int, loads: Sequence[Any]) -> Array:
    """Numbers (simulations, k) of all laws of loads on a body against the world."""
    numbers = np.zeros((assembly.size, LAW_NUMBERS))
    for load in loads:
        of_world = isinstance(load, load_types.BodyLaw) and load.other is None
        if of_world and assembly.body_index(load.body, load.label) == body:
            _add_law(numbers, load)
    return numbers


def _add_law(numbers: Array, load: load_types.BodyLaw) -> None:
    """Add the numbers of a law of loads to those in their places."""
    for at, name in enumerate(load.numbers, LAW_PLACES[load.law].first):
        numbers[..., at] += getattr(load, name)


def constant_wrenches(
    assembly: Assembly, body: int, loads: Sequence[Any], kind: type[Any], frame: Multivector
) -> Array:
    """Sum of the constant wrenches of a kind on a body, in a frame, on twists' blades."""
    total = np.zeros((assembly.size, 6))
    for load in loads:
        acts = type(load) is kind and assembly.body_index(load.body, "a wrench") == body
        if acts and isinstance(load.wrench, Multivector):
            wrench = ~frame >> multivector_of(load.wrench, assembly.algebra, "the wrench")
            total = total + coefficients(wrench, "twist", "the wrench")
    return total


def rotation_flows(moments: Array) -> Array:
    """Parameters (..., 9) of the flows of a free rotation: the middle moment for all axes, differences for two."""
    order = np.argsort(moments, -1)
    rates = 1 / np.take_along_axis(moments, order, -1)
    eye = np.eye(3)
    middle = rates[..., 1:2]
    return np.concatenate(
        [middle, eye[order[..., 0]], rates[..., 0:1] - middle, eye[order[..., 2]], rates[..., 2:3] - middle], -1
    )


def rotation_flow_changes(moments: Array, changes: Array) -> Array:
    """Tangents (n, k, 9) of `rotation_flows` of moments (.., 3) that change (n, k, 3); axes stay."""
    order = np.argsort(moments, -1)[..., None, :]
    rates = -np.take_along_axis(changes / moments[..., None, :] ** 2, np.broadcast_to(order, changes.shape), -1)
    axis, middle = np.zeros(changes.shape), rates[..., 1:2]
    return np.concatenate([middle, axis, rates[..., 0:1] - middle, axis, rates[..., 2:3] - middle], -1)


def angular_places(algebra: Algebra) -> Array:
    """Which coefficients of a twist are the rotations about the three axes."""
    one = algebra.motor_from_matrix(np.eye(4))
    return np.array([mass_matrix(algebra, 0.0, row, one).diagonal().argmax() for row in np.eye(3)])


def pack_springs(assembly: Assembly, loads: Sequence[Any]) -> None:
    """Add springs, their ends in the driver's frames, then laws between two bodies."""
    assembly.spring_offset = assembly.parameter_count
    for load in loads:
        if not isinstance(load, load_types.Spring):
            continue
        body, other = (assembly.body_index(b, "a spring") for b in (load.body, load.other))
        ends = [
            _point_in_driver_frame(assembly, body, load.point),
            _point_in_driver_frame(assembly, other, load.anchor),
        ]
        numbers = Spring.zeros(*np.broadcast_shapes((assembly.size,), *[e.shape[:-1] for e in ends]))
        numbers.point, numbers.anchor = ends
        numbers.stiffness, numbers.length, numbers.damping = load.stiffness, load.length, load.damping
        assembly.append(np.asarray(numbers))
        assembly.springs.append((body, other))
        assembly.damped = assembly.damped or bool((load.damping != 0).any())
    for load in loads:
        if isinstance(load, load_types.BodyLaw) and load.other is not None:
            body, other = (assembly.body_index(b, load.label) for b in (load.body, load.other))
            coupling = Coupling.zeros(assembly.size)
            coupling.center = _point_in_driver_frame(assembly, body, np.zeros(3))
            _add_law(coupling.laws, load)
            assembly.append(np.asarray(coupling))
            assembly.couplings.append((body, other))


def _point_in_driver_frame(assembly: Assembly, body: int, point: Array) -> Array:
    """Point of a body, or of the world (-1), in the driver's frame."""
    if body < 0:
        return point - assembly.origin
    matrix = assembly.algebra.matrix(~assembly.frames[body].to_body)
    return np.asarray(np.einsum("...ij,...j->...i", matrix[..., :3, :3], point) + matrix[..., :3, 3])


def pack_functions(assembly: Assembly, loads: Sequence[Any]) -> None:
    """Add wrenches that are functions."""
    for load in loads:
        world = isinstance(load, load_types.WorldWrench)
        if not (world or isinstance(load, load_types.BodyWrench)) or isinstance(load.wrench, Multivector):
            continue
        body = assembly.body_index(load.body, "a wrench")
        name = f"the {'world' if world else 'body'} wrench"
        assembly.user_loads.append(
            (body, world, assembly.callbacks.add(_load_function(assembly, body, world, load.wrench, name), name, 6))
        )


def _load_function(
    assembly: Assembly, body: int, world: bool, function: Callable[..., Any], name: str
) -> Callable[[int, float, Array], Array]:
    count, frame = arity(function, name), assembly.frames[body]
    assembly.depends_on_state = assembly.depends_on_state or count != 1

    def evaluate(item: int, t: float, state: Array) -> Array:
        if count == 1:
            value = function(t)
        else:
            motor, twist = one_state(assembly, body, item, state)
            value = function(t, motor, twist)
        wrench = multivector_of(value, assembly.algebra, name)
        to_body = item_of(frame.to_body, item)
        local = ~item_of(assembly.shift, item) >> wrench if world else ~to_body >> wrench
        return coefficients(local, "twist", name)

    return evaluate


def one_state(assembly: Assembly, body: int, item: int, state: Array) -> tuple[Multivector, Multivector]:
    """Motor and twist of a body in the user's terms, from a state (14,) of the driver."""
    algebra, to_body = assembly.algebra, item_of(assembly.frames[body].to_body, item)
    motor = algebra.wrap(algebra.kind("motor"), state[:8].copy())
    twist = algebra.wrap(algebra.kind("twist"), state[8:].copy())
    return (item_of(assembly.shift, item) * (motor * ~to_body)).as_kind("motor", check=False), to_body >> twist
