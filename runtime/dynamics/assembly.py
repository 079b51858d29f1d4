"""From bodies, loads and constraints to the numbers of the compiled driver.

Each body's frame is along principal axes at its centre of mass; that of a body whose pins never move is at the pins,
along the motions that they leave. The world's origin is moved to the bodies. Results go back the same way.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.errors import AlgebraMismatchError, GradeError, InputError, KindError, ShapeError
from ..codegen.programs.dynamics import Needs
from ..multivector import Multivector
from . import loads as kinds_of_load
from .bodies import RigidBody
from .constraints import Constraint, Pin
from .functions import Called
from .given import body_number

if TYPE_CHECKING:
    from ..algebras import Algebra

Array = NDArray[Any]


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
    batched: bool
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
        return self.width - int(block.shape[1])

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
            **self._kept_for_each(method),
        )  # fmt: skip

    def _kept_for_each(self, method: str) -> dict[str, Any]:
        """What only Taylor series ask for."""
        if method != "taylor":
            return {}
        constraints = len(self.rows) if self.mode == "constrained" else 0
        return {"springs": len(self.springs), "constraints": constraints, "turning": self.turns_freely}

    @property
    def turns_freely(self) -> bool:
        """Whether the motions that pins leave are all the turns about a point."""
        from .pins import is_turn

        allowed = self.frames[0].allowed
        return allowed is not None and bool((allowed == is_turn(self.algebra)).all())

    def which(self, body: int | str | None, what: str) -> int:
        """Number of a body by its name or number; -1 for the world."""
        return body_number(body, self.names, what)

    # -- there and back ------------------------------------------------------------------------------------

    @property
    def shift(self) -> Multivector:
        """Motor from the driver's world to the user's."""
        motor: Multivector = self.algebra.translator(self.origin)
        return motor

    def to_user(self, body: int, motors: Array, twists: Array) -> tuple[Multivector, Multivector]:
        """Poses and twists (in the bodies' frames) as the user has them; arrays (..., 8) and (..., 6)."""
        frame = self.frames[body].own
        own = frame if frame.shape == () else frame.reshape(frame.shape[0], *[1] * (motors.ndim - 2))
        shift = self.shift if self.shift.shape == () else self.shift.reshape(self.size, *[1] * (motors.ndim - 2))
        motor = self.algebra.wrap(self.algebra.kind("motor"), motors)
        twist = self.algebra.wrap(self.algebra.kind("twist"), twists)
        return (shift * (motor * ~own)).as_kind("motor", check=False), own >> twist


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
    from .body_numbers import loads_present, store_bodies, store_functions, store_springs
    from .constraint_numbers import store_constraint
    from .pins import pin_frame, principal_frame

    algebra = bodies[0].algebra
    constraints = [c.asked() for c in constraints]
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
    made = Assembly(algebra, tuple(bodies), tuple(names), size, bool(shape), frames, origin, mode)
    made.constraints = tuple(constraints)
    store_bodies(made, loads)
    store_springs(made, loads)
    store_functions(made, loads)
    for i, constraint in enumerate(constraints):
        try:
            store_constraint(made, constraint, duration)
        except (InputError, GradeError, ShapeError, KindError, AlgebraMismatchError) as error:
            where = error.where or f"constraint {i} ({constraint.label})"
            raise type(error)(error.what, where=where, remedy=error.remedy) from error.__cause__
    made.loads = loads_present(made, loads)
    return made


def _shape(bodies: Sequence[RigidBody], loads: Sequence[Any]) -> tuple[int, ...]:
    shapes = [b.shape for b in bodies]
    for load in loads:
        match load:
            case kinds_of_load.Spring():
                shapes += [load.point.shape[:-1], load.anchor.shape[:-1]]
                shapes += [x.shape for x in (load.stiffness, load.length, load.damping)]
            case kinds_of_load.Damper():
                shapes += [load.angular.shape, load.linear.shape]
            case kinds_of_load.Gravity():
                shapes.append(load.acceleration.shape[:-1])
            case kinds_of_load.BodyWrench() | kinds_of_load.WorldWrench():
                shapes += [load.wrench.shape] if isinstance(load.wrench, Multivector) else []
            case _:
                known = "Gravity, BodyWrench, WorldWrench, Spring, Damper"
                raise InputError(f"a load is a {type(load).__name__}; there are: {known}.")
    try:
        shape = np.broadcast_shapes(*shapes)
    except ValueError:
        raise ShapeError(f"bodies and loads have batches {sorted(set(shapes))} that do not go together.") from None
    if len(shape) > 1:
        raise ShapeError(f"bodies and loads have shape {shape}; one simulation, or a batch (n,), is meant.")
    if shape == (0,):
        raise ShapeError("the batch of bodies and loads is empty: there is nothing to simulate.")
    return shape


def of_item(x: Multivector, item: int) -> Multivector:
    """That of one simulation."""
    found: Multivector = x if x.shape == () else x[item]
    return found


def frame_of(made: Assembly, body: int, item: int | None = None) -> Multivector:
    """Motor from the driver's frame of a body, or of the world, to the user's."""
    motor = made.shift if body < 0 else made.frames[body].own
    return motor if item is None else of_item(motor, item)
