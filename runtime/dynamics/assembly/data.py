"""Assembly of a simulation: frames, parameters and callbacks, as the driver reads them.

Each body's frame is along principal axes at its center of mass; that of a body whose pins never move is at the pins,
along the motions that they allow. The world's origin is moved to the bodies. Results go back the same way.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.programs.dynamics.config import DynamicsConfig
from ...core.multivector import Multivector
from ...mechanics.arguments import body_number
from ...mechanics.rigid_body import RigidBody
from ...mechanics.twists import rotational_mask
from ..model.constraints import Constraint
from .callbacks import CallbackRegistry

if TYPE_CHECKING:
    from ...core.multivector import Algebra

Array = NDArray[Any]


@dataclass
class BodyFrame:
    """Frame in which the driver computes a body.

    Attributes
    ----------
    to_body : Multivector
        Motor from the driver's frame to the body's (origin at the center of mass, the user's axes).
    pose : Multivector
        Motor of the driver's frame in the driver's world, at the start.
    moments : array (..., 3)
        Moments of inertia about the frame's origin, along its axes, where there are no products of inertia.
    allowed : bool array (6,), optional
        Coefficients of the twists that pins allow.
    """

    to_body: Multivector
    pose: Multivector
    moments: Array
    allowed: Array | None = None


@dataclass
class DriverConstraint:
    """A constraint A[~S V S] = H as the driver reads it: see the record Constraint of codegen/algorithms/dynamics.

    Attributes
    ----------
    layout : str
        Kind of the object V.
    body, other : int
        Indices of its bodies; -1 is the world.
    equations : int
    power : bool
        Whether it constrains velocities by a wrench V without power.
    callback : int
        Number of the function that gives V, H and their derivatives; -1 if they are constant.
    object_offset, target_offset, matrix_offset : int
        Offsets of V, H and A among the parameters; a matrix offset of -1 is the identity.
    error_offset : int
        Offset of the length by which the radius of V is not known; -1: it is known.
    """

    constraint: Constraint
    layout: str
    body: int
    other: int
    equations: int
    power: bool = False
    callback: int = -1
    object_offset: int = 0
    target_offset: int = 0
    matrix_offset: int = -1
    error_offset: int = -1


@dataclass
class Assembly:
    """Input of the driver, except for the integrator.

    Attributes
    ----------
    size : int
        Number of simulations.
    batched : bool
        Whether users gave a batch; one of size 1 stays a batch.
    origin : array (..., 3)
        Origin of the driver's world in the user's.
    mode : {"free", "subspace", "constrained"}
    loads : tuple of str
        Types of loads that are present.
    springs : list of (int, int)
        Bodies at the two ends of each spring; -1 is the world.
    couplings : list of (int, int)
        Bodies between which laws of loads act, by the first one's motion as the second sees it.
    user_loads : list of (int, bool, int)
        Body, whether the wrench is the world's, and number of the function of each load that is a function.
    parameter_blocks : list of array (simulations, k)
        Parameters of each simulation, in the order of the driver.
    spring_offset : int
        Offset of the first spring among the parameters.
    damped : bool
        Whether springs have damping.
    depends_on_state : bool
        Whether loads are functions of the state.
    """

    algebra: Algebra
    bodies: tuple[RigidBody, ...]
    names: tuple[str, ...]
    size: int
    batched: bool
    frames: list[BodyFrame]
    origin: Array
    mode: str
    loads: tuple[str, ...] = ()
    constraints: tuple[Constraint, ...] = ()
    callbacks: CallbackRegistry = field(default_factory=CallbackRegistry)
    driver_constraints: list[DriverConstraint] = field(default_factory=list)
    springs: list[tuple[int, int]] = field(default_factory=list)
    couplings: list[tuple[int, int]] = field(default_factory=list)
    user_loads: list[tuple[int, bool, int]] = field(default_factory=list)
    parameter_blocks: list[Array] = field(default_factory=list)
    parameter_count: int = 0
    spring_offset: int = 0
    damped: bool = False
    depends_on_state: bool = False

    def append(self, values: Any) -> int:
        """Add parameters (..., k) of each simulation, and return their offset."""
        block = np.broadcast_to(np.asarray(values, np.float64), (self.size, np.shape(values)[-1]))
        self.parameter_blocks.append(block)
        self.parameter_count += block.shape[1]
        return self.parameter_count - int(block.shape[1])

    @property
    def parameters(self) -> Array:
        """Parameters (simulations, parameters of each)."""
        return np.ascontiguousarray(np.concatenate(self.parameter_blocks, 1))

    @property
    def equation_count(self) -> int:
        """Number of scalar constraint equations."""
        return sum(c.equations for c in self.driver_constraints)

    @property
    def layouts(self) -> tuple[str, ...]:
        """Kinds of the constraints' objects, without repetition."""
        return tuple(dict.fromkeys(c.layout for c in self.driver_constraints))

    def needs(self, method: str, chart: str) -> DynamicsConfig:
        """Specification of the program that computes it."""
        return DynamicsConfig(
            self.algebra.name, len(self.bodies), self.mode, self.loads, self.layouts, self.equation_count, method,
            chart, bool(self.callbacks.functions), **self._series_needs(method),
        )  # fmt: skip

    def _series_needs(self, method: str) -> dict[str, Any]:
        """Further needs of programs with Taylor series."""
        if method != "taylor":
            return {}
        constraints = len(self.driver_constraints) if self.mode == "constrained" else 0
        return {"springs": len(self.springs), "constraints": constraints, "turning": self.rotates_freely}

    @property
    def rotates_freely(self) -> bool:
        """True if pins allow all rotations about a point, and nothing else."""
        allowed = self.frames[0].allowed
        return allowed is not None and bool((allowed == rotational_mask(self.algebra)).all())

    def body_index(self, body: int | str | None, what: str) -> int:
        """Index of a body by its name or index; -1 for the world."""
        return body_number(body, self.names, what)

    # -- frames --------------------------------------------------------------------------------------------

    @property
    def shift(self) -> Multivector:
        """Motor from the driver's world to the user's."""
        motor: Multivector = self.algebra.translator(self.origin)
        return motor

    def frame_motor(self, body: int) -> Multivector:
        """Motor from the driver's frame of a body, or of the world (-1), to the user's."""
        return self.shift if body < 0 else self.frames[body].to_body

    def to_user(self, body: int, motors: Array, twists: Array) -> tuple[Multivector, Multivector]:
        """Poses and twists (in the bodies' frames) in the user's terms, from arrays (..., 8) and (..., 6)."""
        to_body = self.frames[body].to_body
        to_body = to_body if to_body.shape == () else to_body.reshape(to_body.shape[0], *[1] * (motors.ndim - 2))
        shift = self.shift if self.shift.shape == () else self.shift.reshape(self.size, *[1] * (motors.ndim - 2))
        motor = self.algebra.wrap(self.algebra.kind("motor"), motors)
        twist = self.algebra.wrap(self.algebra.kind("twist"), twists)
        return (shift * (motor * ~to_body)).as_kind("motor", check=False), to_body >> twist


def item_of(x: Multivector, item: int) -> Multivector:
    """Item of a batch; a single multivector is the same for all items."""
    found: Multivector = x if x.shape == () else x[item]
    return found
