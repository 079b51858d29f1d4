"""From bodies, loads and constraints to the numbers of the compiled driver.

Each body's frame is along principal axes at its centre of mass; that of a body whose pins never move is at the pins,
along the motions that they leave. The world's origin is moved to the bodies. Results go back the same way.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..calls import Numbers, call
from ..codegen.errors import InputError, ShapeError, suggest
from ..codegen.programs.dynamics import Needs
from ..multivector import Multivector
from . import loads as kinds_of_load
from .bodies import RigidBody
from .constraints import Constraint, Incidence, Pin, PinLinear, PinPath, VirtualPower
from .functions import Called, Differences, arity
from .given import coefficients, of_algebra
from .layouts import carried, layout_of, matrix_of, on_layout

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
SPRING = 9


@dataclass
class Frame:
    """Where a body's frame is.

    Attributes
    ----------
    own : Multivector
        Motor from the driver's frame to the body's (origin at the centre of mass, the user's axes).
    pose : Multivector
        Motor of the driver's frame in the driver's world, at the start.
    allowed : bool array (6,), optional
        Coefficients of twists that pins leave.
    moments : array (..., 3)
        About the frame's origin, along its axes, where there are no products of inertia.
    """

    own: Multivector
    pose: Multivector
    moments: Array
    allowed: Array | None = None


@dataclass
class Row:
    """A constraint as the driver reads it: see `bs_constraint`."""

    constraint: Constraint
    layout: str
    body: int
    other: int
    rows: int
    power: bool = False
    user: int = -1
    v: int = 0
    h: int = 0
    a: int = -1


@dataclass
class Assembly:
    """Everything of a simulation but its integrator."""

    algebra: Algebra
    bodies: tuple[RigidBody, ...]
    names: tuple[str, ...]
    size: int
    frames: list[Frame]
    origin: Array
    mode: str
    loads: tuple[str, ...] = ()
    constraints: tuple[Constraint, ...] = ()
    called: Called = field(default_factory=Called)
    rows: list[Row] = field(default_factory=list)
    springs: list[tuple[int, int]] = field(default_factory=list)
    user_loads: list[tuple[int, bool, int]] = field(default_factory=list)
    blocks: list[Array] = field(default_factory=list)
    width: int = 0
    spring_place: int = 0
    damped: bool = False
    functions_of_state: bool = False

    def store(self, values: Any) -> int:
        """Where these numbers (..., k) stand in a simulation's."""
        block = np.broadcast_to(np.asarray(values, np.float64), (self.size, np.shape(values)[-1]))
        self.blocks.append(block)
        self.width += block.shape[1]
        return self.width - block.shape[1]

    @property
    def numbers(self) -> Array:
        """(simulations, numbers of each)."""
        return np.ascontiguousarray(np.concatenate(self.blocks, 1))

    @property
    def layouts(self) -> tuple[str, ...]:
        """Each once."""
        return tuple(dict.fromkeys(row.layout for row in self.rows))

    def needs(self, method: str, chart: str) -> Needs:
        """The program that serves it."""
        return Needs(
            self.algebra.name, len(self.bodies), self.mode, self.loads, self.layouts,
            sum(row.rows for row in self.rows), method, chart, bool(self.called.functions),
            springs=len(self.springs) if method == "taylor" else 0,
        )  # fmt: skip

    @property
    def turns_freely(self) -> bool:
        """Whether the motions that pins leave are all the turns about a point."""
        from .pins import is_turn

        allowed = self.frames[0].allowed
        return allowed is not None and bool((allowed == is_turn(self.algebra)).all())

    # -- there and back ------------------------------------------------------------------------------------

    @property
    def shift(self) -> Multivector:
        """Motor from the driver's world to the user's."""
        return self.algebra.translator(self.origin)

    def to_user(self, body: int, motors: Array, twists: Array) -> tuple[Multivector, Multivector]:
        """Poses and twists (in the bodies' frames) as the user has them; arrays (..., 8) and (..., 6)."""
        frame = self.frames[body].own
        own = frame if frame.shape == () else frame.reshape(frame.shape[0], *[1] * (motors.ndim - 2))
        shift = self.shift if self.shift.shape == () else self.shift.reshape(self.size, *[1] * (motors.ndim - 2))
        motor = self.algebra.wrap(self.algebra.kind("motor"), motors)
        twist = self.algebra.wrap(self.algebra.kind("twist"), twists)
        return (shift * (motor * ~own)).as_kind("motor", check=False), own >> twist

    def local(self, x: Multivector) -> Multivector:
        """An object of the user's world in the driver's."""
        return ~self.shift >> x


def assemble(
    bodies: Sequence[RigidBody],
    names: Sequence[str],
    loads: Sequence[Any],
    constraints: Sequence[Constraint],
    duration: float,
    null_space: bool,
) -> Assembly:
    """The numbers of a simulation.

    Parameters
    ----------
    duration : float
        Over which functions of time are asked.
    null_space : bool
        Whether pins that never move may be kept by moving only as they allow.
    """
    from .pins import pin_frame, principal_frame

    algebra = bodies[0].algebra
    shape = _shape(bodies, loads)
    still = bool(constraints) and len(bodies) == 1 and all(type(c) is Pin and c.other is None for c in constraints)
    if null_space and still:
        frames, origin = pin_frame(bodies[0], constraints)
        mode = "subspace"
    else:
        origin = np.mean([np.broadcast_to(b.position, (*shape, 3)) for b in bodies], 0)
        frames = [principal_frame(b, origin) for b in bodies]
        mode = "constrained" if constraints else "free"
    size = shape[0] if shape else 1
    made = Assembly(algebra, tuple(bodies), tuple(names), size, frames, origin, mode)
    made.constraints = tuple(constraints)
    _store_bodies(made, loads)
    _store_springs(made, loads)
    _store_functions(made, loads)
    for constraint in constraints:
        _store_constraint(made, constraint, duration)
    made.loads = _loads_present(made, loads)
    return made


def _shape(bodies: Sequence[RigidBody], loads: Sequence[Any]) -> tuple[int, ...]:
    shapes = [b.shape for b in bodies]
    for load in loads:
        if isinstance(load, kinds_of_load.Spring):
            shapes += [load.point.shape[:-1], load.anchor.shape[:-1], load.stiffness.shape, load.length.shape, load.damping.shape]
        elif isinstance(load, kinds_of_load.Damper):
            shapes += [load.angular.shape, load.linear.shape]
        elif isinstance(load, kinds_of_load.Gravity):
            shapes.append(load.acceleration.shape[:-1])
        elif isinstance(load, kinds_of_load.BodyWrench | kinds_of_load.WorldWrench):
            if isinstance(load.wrench, Multivector):
                shapes.append(load.wrench.shape)
        else:
            raise InputError(f"a load is a {type(load).__name__}; there are Gravity, BodyWrench, WorldWrench, Spring, Damper.")
    try:
        shape = np.broadcast_shapes(*shapes)
    except ValueError:
        raise ShapeError(f"bodies and loads have batches {sorted(set(shapes))} that do not go together.") from None
    if len(shape) > 1:
        raise ShapeError(f"bodies and loads have shape {shape}; one simulation, or a batch (n,), is meant.")
    return shape


def _which(made: Assembly, body: int | str | None, what: str) -> int:
    """Number of a body."""
    if body is None:
        return -1
    if isinstance(body, str):
        if body not in made.names:
            raise InputError(f"{what}: there is no body {body!r}.{suggest(body, made.names)}")
        return made.names.index(body)
    if not 0 <= body < len(made.bodies):
        raise InputError(f"{what}: there is no body {body}; there are {len(made.bodies)}.")
    return int(body)


def _loads_present(made: Assembly, loads: Sequence[Any]) -> tuple[str, ...]:
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


def _store_bodies(made: Assembly, loads: Sequence[Any]) -> None:
    algebra = made.algebra
    gravity = sum((load.acceleration for load in loads if isinstance(load, kinds_of_load.Gravity)), np.zeros(3))
    for i, (body, frame) in enumerate(zip(made.bodies, made.frames, strict=True)):
        numbers = np.zeros((made.size, BODY))

        def put(name: str, values: Any, numbers: Array = numbers) -> None:
            place, count = PLACES[name]
            numbers[:, place : place + count] = values

        axes = algebra.motor_from_matrix(body.axes)  # from the principal axes to the body's
        matrix = mass_matrix(algebra, body.mass, body.moments, (~frame.own * axes).as_kind("motor", check=False))
        metric = matrix.diagonal(axis1=-2, axis2=-1)
        inverse = 1 / metric
        if frame.allowed is not None:
            inverse = np.where(frame.allowed, inverse, 0.0)
            free = np.flatnonzero(frame.allowed)
            compliance = np.zeros(matrix.shape)
            inner = np.ix_(*[range(n) for n in matrix.shape[:-2]], free, free)
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
        put("world", _wrenches(made, i, loads, kinds_of_load.WorldWrench, lambda w: made.local(w)))
        in_body = _wrenches(made, i, loads, kinds_of_load.BodyWrench, lambda w, own=frame.own: ~own >> w)
        put("wrench", call(algebra, "mechanics.covector_of", algebra.wrap(algebra.kind("twist"), in_body)).value)
        dampers = [d for d in loads if isinstance(d, kinds_of_load.Damper) and _which(made, d.body, "a damper") == i]
        for d in dampers:
            numbers[:, PLACES["drag"][0]] += d.angular
            numbers[:, PLACES["drag"][0] + 1] += d.linear
        made.store(numbers)


def _wrenches(
    made: Assembly, body: int, loads: Sequence[Any], kind: type, moved: Callable[[Multivector], Multivector]
) -> Array:
    """Sum of the constant wrenches of a kind on a body, on twists' blades."""
    total = np.zeros((made.size, 6))
    for load in loads:
        if type(load) is kind and isinstance(load.wrench, Multivector) and _which(made, load.body, "a wrench") == body:
            wrench = moved(of_algebra(load.wrench, made.algebra, "the wrench"))
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


def _store_springs(made: Assembly, loads: Sequence[Any]) -> None:
    """Points go to the driver's frames."""
    made.spring_place = made.width
    for load in loads:
        if not isinstance(load, kinds_of_load.Spring):
            continue
        body, other = (_which(made, b, "a spring") for b in (load.body, load.other))
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
    return np.einsum("...ij,...j->...i", matrix[..., :3, :3], point) + matrix[..., :3, 3]


def _store_functions(made: Assembly, loads: Sequence[Any]) -> None:
    for load in loads:
        world = isinstance(load, kinds_of_load.WorldWrench)
        if not (world or isinstance(load, kinds_of_load.BodyWrench)) or isinstance(load.wrench, Multivector):
            continue
        body = _which(made, load.body, "a wrench")
        name = f"the {'world' if world else 'body'} wrench"
        made.user_loads.append((body, world, made.called.add(_load_function(made, body, world, load.wrench, name), name)))


def _load_function(
    made: Assembly, body: int, world: bool, function: Callable[..., Any], name: str
) -> Callable[[int, float, Array], Array]:
    count, frame = arity(function, name), made.frames[body]
    made.functions_of_state = made.functions_of_state or count != 1

    def evaluate(item: int, t: float, state: Array) -> Array:
        if count == 1:
            given = function(t)
        else:
            motor, twist = _one_state(made, body, item, state)
            given = function(t, motor, twist)
        wrench = of_algebra(given, made.algebra, name)
        own = _item(frame.own, item)
        moved = ~_item(made.shift, item) >> wrench if world else ~own >> wrench
        return coefficients(moved, "twist", name)

    return evaluate


def _item(x: Multivector, item: int) -> Multivector:
    return x if x.shape == () else x[item]


def _one_state(made: Assembly, body: int, item: int, state: Array) -> tuple[Multivector, Multivector]:
    algebra, own = made.algebra, _item(made.frames[body].own, item)
    motor = algebra.wrap(algebra.kind("motor"), state[:8].copy())
    twist = algebra.wrap(algebra.kind("twist"), state[8:].copy())
    return (_item(made.shift, item) * (motor * ~own)).as_kind("motor", check=False), own >> twist


# -- constraints -------------------------------------------------------------------------------------------


def _store_constraint(made: Assembly, c: Constraint, duration: float) -> None:
    body, other = _which(made, c.body, c.label), _which(made, c.other, c.label)
    if body < 0 or body == other:
        raise InputError(f"{c.label} is between {c.body!r} and {c.other!r}; it takes a body and something else.")
    match c:
        case Pin():
            _store_pin(made, c, body, other)
        case PinPath():
            identity = lambda x: x  # noqa: E731
            _store_linear(made, c, body, other, None, identity, c.world_object, c.body_object, duration)
        case PinLinear():
            _store_linear(made, c, body, other, c.function, None, c.world_object, c.target, duration)
        case Incidence():
            point = of_algebra(c.body_point, made.algebra, "the body's point")
            product = (lambda x: point ^ x) if not made.algebra.is_degenerate else (lambda x: point & x)
            _store_linear(made, c, body, other, product, None, c.world_object, 0, duration)
        case VirtualPower():
            _store_power(made, c, body, other, duration)
        case _:
            raise InputError(f"{c!r} is no constraint; there are Pin, PinPath, PinLinear, Incidence, VirtualPower.")


def _frame(made: Assembly, body: int, item: int | None = None) -> Multivector:
    """Motor from the driver's frame of a body, or of the world, to the user's."""
    motor = made.shift if body < 0 else made.frames[body].own
    return motor if item is None else _item(motor, item)


def relative_pose(made: Assembly, body: int, other: int) -> Multivector:
    """Motor of a body's driver frame, as another's sees it, at the start."""
    pose = made.frames[body].pose
    return pose if other < 0 else ~made.frames[other].pose * pose


def _store_pin(made: Assembly, c: Pin, body: int, other: int) -> None:
    own = of_algebra(c.body_object, made.algebra, "the body's object")
    own = ~_frame(made, body) >> own
    layout = layout_of([own], c.label)
    there = relative_pose(made, body, other) >> own
    if c.world_object is not None:
        there = moved_near(~_frame(made, other) >> of_algebra(c.world_object, made.algebra, "the world's object"), there)
    row = Row(c, layout, body, other, made.algebra.kind(layout).size)
    row.v, row.h = made.store(on_layout(there, layout)), made.store(on_layout(own, layout))
    made.rows.append(row)


#: Objects closer than this, as a share of their size, are one.
SAME = 1e-9


def moved_near(given: Multivector, exact: Multivector) -> Multivector:
    """An object as given, or where it is expected if it differs from there by rounding: far from the origin the
    coefficients of what users give have lost the digits of the place."""
    difference = (given - exact).values
    size = np.abs(given.values).max()
    return exact if np.abs(difference).max(initial=0) <= SAME * size else given


def _path(value: Any, made: Assembly, what: str, frame: Multivector) -> Callable[[float], list[Multivector]]:
    """A function of time, moved to a frame: the object, or it and its derivatives."""

    def at(t: float) -> list[Multivector]:
        given = value(t) if callable(value) else value
        parts = given if isinstance(given, tuple) else (given,)
        return [~frame >> of_algebra(x, made.algebra, what) for x in parts]

    return at


def _derivatives(path: Callable[[float], list[Multivector]], layout: str, duration: float) -> Callable[[float], Any]:
    """Rows (3, k) of a path's values and derivatives."""
    if len(path(0.0)) == 3:
        return lambda t: np.stack([on_layout(x, layout) for x in path(t)])
    return Differences(lambda t: on_layout(path(t)[0], layout), (0.0, duration))


def _store_linear(
    made: Assembly, c: Constraint, body: int, other: int, function: Any, identity: Any, world: Any, target: Any,
    duration: float,
) -> None:  # fmt: skip
    """A[~S V S] = H; without a function A is one, and H an object of the body."""
    if made.size > 1 and (callable(world) or callable(target)):
        raise InputError(f"{c.label} has functions of time; those are for one simulation, not for a batch of {made.size}.")
    path = _path(world, made, "the world's object", _frame(made, other, 0) if callable(world) else _frame(made, other))
    layout = layout_of([path(0.0)[0], path(duration)[0]], c.label)
    algebra = made.algebra
    if function is None:
        aims = _path(target, made, "the body's object", _frame(made, body, 0) if callable(target) else _frame(made, body))
        layout = layout_of([path(0.0)[0], path(duration)[0], aims(0.0)[0]], c.label)
        rows, matrix = algebra.kind(layout).size, None

        def goal(t: float) -> list[Array]:
            return [on_layout(x, layout) for x in aims(t)]
    else:
        matrix = matrix_of(function, algebra, layout, f"the function of {c.label}")
        keep = _blades_of(function, algebra, layout)
        rows = len(matrix)
        matrix = matrix @ carried(_frame(made, body), layout)  # of a batch each body has a frame of its own

        def goal(t: float) -> list[Array]:
            given = target(t) if callable(target) else target
            return [_on_blades(x, keep, algebra) for x in (given if isinstance(given, tuple) else (given,))]

    row = Row(c, layout, body, other, rows)
    if callable(world) or callable(target):
        v = _derivatives(path, layout, duration) if callable(world) else _constant(on_layout(path(0.0)[0], layout))
        h = _with_derivatives(goal, duration) if callable(target) else _constant(goal(0.0)[0])
        row.user = made.called.add(lambda item, t, state: np.concatenate([*v(t), *h(t)], axis=None), c.label)
    else:
        row.v, row.h = made.store(on_layout(path(0.0)[0], layout)), made.store(goal(0.0)[0])
    if matrix is not None:
        row.a = made.store(matrix.reshape(*matrix.shape[:-2], -1))
    made.rows.append(row)


def _constant(values: Array) -> Callable[[float], Any]:
    fixed = np.stack([values, 0 * values, 0 * values])
    return lambda t: fixed


def _with_derivatives(goal: Callable[[float], list[Array]], duration: float) -> Callable[[float], Any]:
    if len(goal(0.0)) == 3:
        return lambda t: np.stack(goal(t))
    return Differences(lambda t: goal(t)[0], (0.0, duration))


def _blades_of(function: Any, algebra: Algebra, layout: str) -> list[int]:
    """Blades on which a linear function has values, in order."""
    from .layouts import basis

    y = function(basis(algebra, layout))
    used = [b for b, v in zip(y.kind.blades, np.moveaxis(y.values, -1, 0), strict=True) if np.any(v)]
    return sorted(used)


def _on_blades(x: Any, blades: list[int], algebra: Algebra) -> Array:
    if not isinstance(x, Multivector):
        x = algebra.scalar(float(x))
    found = np.zeros(len(blades))
    for b, v in zip(x.kind.blades, x.values, strict=True):
        if b in blades:
            found[blades.index(b)] = v
        elif v:
            raise InputError(f"the target has {algebra.blade_name(b)}, which the linear function never gives.")
    return found


def _store_power(made: Assembly, c: VirtualPower, body: int, other: int, duration: float) -> None:
    algebra, frame = made.algebra, _frame(made, other)
    if not callable(c.wrenches):
        given = list(c.wrenches) if c.wrenches.__class__ in (list, tuple) or c.wrenches.shape else [c.wrenches]
        for wrench in given:
            moved = ~frame >> of_algebra(wrench, algebra, "a wrench")
            row = Row(c, "twist", body, other, 1, power=True)
            row.v, row.h = made.store(coefficients(moved, "twist", "a wrench")), made.store([0.0])
            made.rows.append(row)
        return
    if made.size > 1:
        raise InputError(f"{c.label} has a function; that is for one simulation, not for a batch of {made.size}.")
    count = arity(c.wrenches, "the wrenches")

    known: dict[tuple[float, bytes], list[Array]] = {}  # the last ones: the driver asks for each wrench by itself

    def parts(t: float, state: Array) -> list[Array]:
        key = (t, state.tobytes())
        if key not in known:
            known.clear()
            known[key] = evaluated(t, state)
        return known[key]

    def evaluated(t: float, state: Array) -> list[Array]:
        arguments = (t,) if count == 1 else (t, *_one_state(made, body, 0, state))
        value = c.wrenches(*arguments)
        pair = value if isinstance(value, tuple) and len(value) == 2 else (value, None)
        rows = [None if x is None else np.atleast_2d(coefficients(~_item(frame, 0) >> of_algebra(x, algebra, "the wrenches"), "twist", "the wrenches")) for x in pair]
        if rows[1] is None and count == 1:
            rows[1] = Differences(lambda u: np.atleast_2d(parts_of(u)), (0.0, duration))(t)[1]
        if rows[1] is None:
            raise InputError("wrenches that depend on the state come with their rates: return (T, dT).")
        return rows  # type: ignore[return-value]

    def parts_of(t: float) -> Array:
        return coefficients(~_item(frame, 0) >> of_algebra(c.wrenches(t), algebra, "the wrenches"), "twist", "the wrenches")

    state = np.concatenate([np.ravel(made.frames[body].pose.values)[:8], np.zeros(6)])
    for i in range(len(parts(0.0, state)[0])):
        row = Row(c, "twist", body, other, 1, power=True)

        def one(item: int, t: float, state: Array, i: int = i) -> Array:
            values, rates = parts(t, state)
            return np.concatenate([values[i], rates[i], np.zeros(6 + 3)])

        row.user = made.called.add(one, c.label)
        made.rows.append(row)
