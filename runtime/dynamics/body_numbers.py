"""Numbers of bodies, springs and loads as the compiled driver reads them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..calls import Numbers, call
from ..multivector import Multivector
from . import loads as kinds_of_load
from .assembly import Assembly, of_item
from .functions import arity
from .given import coefficients, of_algebra

if TYPE_CHECKING:
    from ..algebras import Algebra

Array = NDArray[Any]
#: Numbers of a body, and where they stand: as in templates/c/dynamics_rates.j2.
BODY = 122
PLACES = {
    "metric": (0, 6), "inverse": (6, 6), "roots": (12, 6), "weight": (18, 3), "center": (21, 3), "world": (24, 6),
    "wrench": (30, 6), "drag": (36, 2), "mass": (38, 36), "compliance": (74, 36), "flows": (110, 9),
    "moments": (119, 3),
}  # fmt: skip
#: Numbers of a spring.
SPRING = 9


def loads_present(made: Assembly, loads: Sequence[Any]) -> tuple[str, ...]:
    found = set()
    for load in loads:
        constant = isinstance(getattr(load, "wrench", None), Multivector)
        match load:
            case kinds_of_load.Gravity():
                found.add("gravity")
            case kinds_of_load.Spring():
                found.add("spring")
            case kinds_of_load.Damper():
                found.add("drag")
            case kinds_of_load.BodyWrench():
                found.add("body_wrench" if constant else "user")
            case _:
                found.add("world_wrench" if constant else "user")
    return tuple(name for name in ("gravity", "body_wrench", "world_wrench", "drag", "spring", "user") if name in found)


def mass_matrix(algebra: Algebra, mass: Any, moments: Array, frame: Multivector) -> Array:
    """(..., 6, 6), see `mechanics.mass_matrix`."""
    row: Array = call(
        algebra, "mechanics.mass_matrix", Numbers(mass, 0, "the mass"), algebra.vector(moments, "the moments"), frame
    ).value
    return row.reshape(*row.shape[:-1], 6, 6)


def _put(numbers: Array, name: str, values: Any) -> None:
    place, count = PLACES[name]
    numbers[:, place : place + count] = values


def store_bodies(made: Assembly, loads: Sequence[Any]) -> None:
    algebra = made.algebra
    gravity = sum((load.acceleration for load in loads if isinstance(load, kinds_of_load.Gravity)), np.zeros(3))
    for i, (body, frame) in enumerate(zip(made.bodies, made.frames, strict=True)):
        numbers = np.zeros((made.size, BODY))
        put = partial(_put, numbers)

        axes = algebra.motor_from_matrix(body.axes)  # from the principal axes to the body's
        matrix = mass_matrix(algebra, body.mass, body.moments, (~frame.own * axes).as_kind("motor", check=False))
        metric = matrix.diagonal(axis1=-2, axis2=-1)
        inverse = 1 / metric
        if frame.allowed is not None:
            inverse = np.where(frame.allowed, inverse, 0.0)
            free = np.flatnonzero(frame.allowed)
            compliance = np.zeros(matrix.shape)
            inner = (..., free[:, None], free)
            compliance[inner] = np.linalg.inv(matrix[inner])
            put("compliance", compliance.reshape(*matrix.shape[:-2], 36))
        put("metric", metric)
        put("inverse", inverse)
        put("roots", np.sqrt(1 / metric))
        put("mass", matrix.reshape(*matrix.shape[:-2], 36))
        put("weight", np.asarray(body.mass)[..., None] * gravity)
        put("center", algebra.matrix(~frame.own)[..., :3, 3])
        put("flows", flows(frame.moments))
        put("moments", frame.moments)
        put("world", _wrenches(made, i, loads, kinds_of_load.WorldWrench, made.shift))
        in_body = _wrenches(made, i, loads, kinds_of_load.BodyWrench, frame.own)
        put("wrench", call(algebra, "mechanics.covector_of", algebra.wrap(algebra.kind("twist"), in_body)).value)
        dampers = [d for d in loads if isinstance(d, kinds_of_load.Damper) and made.which(d.body, "a damper") == i]
        for d in dampers:
            numbers[:, PLACES["drag"][0]] += d.angular
            numbers[:, PLACES["drag"][0] + 1] += d.linear
        made.store(numbers)


def _wrenches(made: Assembly, body: int, loads: Sequence[Any], kind: type[Any], frame: Multivector) -> Array:
    """Sum of the constant wrenches of a kind on a body, in a frame, on twists' blades."""
    total = np.zeros((made.size, 6))
    for load in loads:
        ours = type(load) is kind and made.which(load.body, "a wrench") == body
        if ours and isinstance(load.wrench, Multivector):
            wrench = ~frame >> of_algebra(load.wrench, made.algebra, "the wrench")
            total = total + coefficients(wrench, "twist", "the wrench")
    return total


def flows(moments: Array) -> Array:
    """Numbers (..., 9) of the flows of a free rotation: the middle moment for all axes, the rest for two of them."""
    order = np.argsort(moments, -1)
    rates = 1 / np.take_along_axis(moments, order, -1)
    eye = np.eye(3)
    middle = rates[..., 1:2]
    return np.concatenate(
        [middle, eye[order[..., 0]], rates[..., 0:1] - middle, eye[order[..., 2]], rates[..., 2:3] - middle], -1
    )


def store_springs(made: Assembly, loads: Sequence[Any]) -> None:
    """Points go to the driver's frames."""
    made.spring_place = made.width
    for load in loads:
        if not isinstance(load, kinds_of_load.Spring):
            continue
        body, other = (made.which(b, "a spring") for b in (load.body, load.other))
        ends = [_moved_point(made, body, load.point), _moved_point(made, other, load.anchor)]
        shape = np.broadcast_shapes((made.size,), *[e.shape[:-1] for e in ends])
        numbers = [np.broadcast_to(x, shape)[..., None] for x in (load.stiffness, load.length, load.damping)]
        made.store(np.concatenate([np.broadcast_to(e, (*shape, 3)) for e in ends] + numbers, -1))
        made.springs.append((body, other))
        made.damped = made.damped or bool((load.damping != 0).any())


def _moved_point(made: Assembly, body: int, point: Array) -> Array:
    """A point of a body, or of the world, in the driver's frame."""
    if body < 0:
        return point - made.origin
    matrix = made.algebra.matrix(~made.frames[body].own)
    return np.asarray(np.einsum("...ij,...j->...i", matrix[..., :3, :3], point) + matrix[..., :3, 3])


def store_functions(made: Assembly, loads: Sequence[Any]) -> None:
    for load in loads:
        world = isinstance(load, kinds_of_load.WorldWrench)
        if not (world or isinstance(load, kinds_of_load.BodyWrench)) or isinstance(load.wrench, Multivector):
            continue
        body = made.which(load.body, "a wrench")
        name = f"the {'world' if world else 'body'} wrench"
        made.user_loads.append(
            (body, world, made.called.add(_load_function(made, body, world, load.wrench, name), name, 6))
        )


def _load_function(
    made: Assembly, body: int, world: bool, function: Callable[..., Any], name: str
) -> Callable[[int, float, Array], Array]:
    count, frame = arity(function, name), made.frames[body]
    made.functions_of_state = made.functions_of_state or count != 1

    def evaluate(item: int, t: float, state: Array) -> Array:
        if count == 1:
            given = function(t)
        else:
            motor, twist = one_state(made, body, item, state)
            given = function(t, motor, twist)
        wrench = of_algebra(given, made.algebra, name)
        own = of_item(frame.own, item)
        moved = ~of_item(made.shift, item) >> wrench if world else ~own >> wrench
        return coefficients(moved, "twist", name)

    return evaluate


def one_state(made: Assembly, body: int, item: int, state: Array) -> tuple[Multivector, Multivector]:
    algebra, own = made.algebra, of_item(made.frames[body].own, item)
    motor = algebra.wrap(algebra.kind("motor"), state[:8].copy())
    twist = algebra.wrap(algebra.kind("twist"), state[8:].copy())
    return (of_item(made.shift, item) * (motor * ~own)).as_kind("motor", check=False), own >> twist
