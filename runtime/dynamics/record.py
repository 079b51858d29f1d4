"""Trajectories as plain arrays: what files hold and pictures need, without the simulation that made them."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.errors import InputError
from ..loading import stock_algebra
from ..multivector import Multivector
from .given import coefficients
from .outlets import Outlets
from .sketch import Sketch

if TYPE_CHECKING:
    from .trajectory import Trajectory

Array = NDArray[Any]
#: Arrays of each body, by name: shapes without the leading dimensions (n,) and (stores,).
OF_BODIES: dict[str, tuple[int, ...]] = {
    "motor": (8,), "position": (3,), "orientation": (3, 3), "velocity": (3,), "angular_velocity": (3,),
    "momentum": (6,), "reaction": (6,),
}  # fmt: skip
SCREWS = ("momentum", "reaction")


@dataclass(frozen=True, eq=False)
class Record(Outlets):
    """A trajectory that was stored: the attributes of `Trajectory`, without the simulation that made it.

    Attributes
    ----------
    time : array (stores,)
    motor, momentum, reaction : Multivector (stores,)
    position, velocity, angular_velocity : array (stores, 3)
    orientation : array (stores, 3, 3)
    energy, violation : array (stores,)
    bodies : dict of Record
        All bodies by name.
    sketch : Sketch
        Shapes, traces and units that were stored with it.
    integrator, message : str
    status, steps
        As of `Trajectory`.
    """

    algebra: str
    time: Array
    rows: dict[str, dict[str, Array]]
    energy: Array
    violation: Array
    integrator: str = ""
    status: Any = "ok"
    message: str = ""
    steps: Any = 0
    sketch: Sketch = field(default_factory=Sketch)
    name: str = ""

    def __post_init__(self) -> None:
        if not self.name:
            object.__setattr__(self, "name", next(iter(self.rows)))

    @property
    def bodies(self) -> dict[str, Record]:
        """All bodies, by name."""
        return {name: self._of(name) for name in self.rows}

    def _of(self, name: str) -> Record:
        return replace(self, name=name)

    def _screw(self, key: str) -> Multivector:
        home = stock_algebra(self.algebra)
        return home.wrap(home.kind("twist"), self.rows[self.name][key])

    @cached_property
    def motor(self) -> Multivector:
        """Body to world."""
        home = stock_algebra(self.algebra)
        return home.wrap(home.kind("motor"), self.rows[self.name]["motor"])

    @property
    def position(self) -> Array:
        """Of the centre of mass."""
        return self.rows[self.name]["position"]

    @property
    def orientation(self) -> Array:
        """Body to world."""
        return self.rows[self.name]["orientation"]

    @property
    def velocity(self) -> Array:
        """Of the centre of mass, in the world."""
        return self.rows[self.name]["velocity"]

    @property
    def angular_velocity(self) -> Array:
        """Along the body's axes."""
        return self.rows[self.name]["angular_velocity"]

    @property
    def momentum(self) -> Multivector:
        """In the world, moments about its origin."""
        return self._screw("momentum")

    @property
    def reaction(self) -> Multivector:
        """Of all constraints together, in the world, moments about its origin."""
        return self._screw("reaction")

    @property
    def batch(self) -> tuple[int, ...]:
        """() of one simulation, (n,) of n."""
        return self.energy.shape[:-1]

    def path(self, point: Any) -> Array:
        """Where a point (3,) of the body was (stores, 3)."""
        return np.asarray(self.position + self.orientation @ np.asarray(point, np.float64))

    def __getitem__(self, item: int) -> Record:
        """One simulation of a batch."""
        if not self.batch:
            raise InputError("this is one simulation; only a batch has items.")
        if not -self.batch[0] <= item < self.batch[0]:
            raise InputError(f"there are {self.batch[0]} simulations, and none has the number {item}.")
        rows = {name: {key: x[item] for key, x in own.items()} for name, own in self.rows.items()}
        status, steps = (x[item] if np.ndim(x) else x for x in (self.status, self.steps))
        return Record(
            self.algebra, self.time, rows, self.energy[item], self.violation[item], self.integrator, str(status),
            self.message, int(steps), self.sketch, self.name,
        )  # fmt: skip

    def __len__(self) -> int:
        return len(self.time)

    def __repr__(self) -> str:
        until = self.time[-1] if len(self) else 0.0
        return f"<Record: {len(self)} states to t = {until:.6g}, {self.integrator}>"


def recorded(trajectory: Trajectory | Record, sketch: Sketch | None = None) -> Record:
    """A trajectory's arrays.

    Parameters
    ----------
    trajectory : Trajectory or Record
    sketch : Sketch, optional
        In place of its own.

    Raises
    ------
    InputError
        If it is neither, or the sketch names a body that is not there.
    """
    from .trajectory import Trajectory

    if isinstance(trajectory, Record):
        found = trajectory
    elif isinstance(trajectory, Trajectory):
        found = _taken(trajectory)
    else:
        raise InputError(f"a {type(trajectory).__name__} is no trajectory.", remedy="Give what Simulation.run returned")
    if sketch is None:
        return found
    if not isinstance(sketch, Sketch):
        raise InputError(f"the sketch is a {type(sketch).__name__}; a dynamics.Sketch is needed.")
    for name in (*filter(None, sketch.shapes), *sketch.colors, *[t.body for t in sketch.traces if t.body]):
        if name not in found.rows:
            raise InputError(f"the sketch names the body {name!r}; there are: {', '.join(found.rows)}.")
    return replace(found, sketch=sketch)


def _taken(trajectory: Trajectory) -> Record:
    rows = {}
    bodies = trajectory.bodies
    for name, own in bodies.items():
        arrays = {key: np.asarray(getattr(own, key)) for key in OF_BODIES if key not in ("motor", *SCREWS)}
        arrays["motor"] = own.motor.as_kind("motor", check=False).values
        for key in SCREWS:
            arrays[key] = coefficients(getattr(own, key), "twist", key)
        rows[name] = arrays
    return Record(
        trajectory.motor.algebra.name, trajectory.time, rows, np.asarray(trajectory.energy),
        np.asarray(trajectory.violation), trajectory.integrator, trajectory.status, trajectory.message,
        trajectory.steps,
    )  # fmt: skip


__all__ = ["OF_BODIES", "Record", "recorded"]
