"""Trajectories as plain arrays, the contents of files and the input of pictures."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import InputError, suggest
from ...common.validation import as_instance
from ...core.multivector import Multivector
from ...core.registry import stock_algebra
from .figure_spec import Sketch, Trace

Array = NDArray[Any]
#: Arrays of each body, by name: shapes without the leading dimensions (n,) and (stores,).
OF_BODIES: dict[str, tuple[int, ...]] = {
    "motor": (8,), "position": (3,), "orientation": (3, 3), "velocity": (3,), "angular_velocity": (3,),
    "momentum": (6,), "reaction": (6,),
}  # fmt: skip
SCREWS = ("momentum", "reaction")
#: Bodies that a message names at most.
MOST_NAMES = 12


def several_bodies(names: Sequence[str]) -> InputError:
    """Error where one body's states are asked of several bodies."""
    more = ", .." if len(names) > MOST_NAMES else ""
    return InputError(
        f"the trajectory is of {len(names)} bodies: {', '.join(names[:MOST_NAMES])}{more}.",
        remedy=f"Ask one of them, as trajectory[{names[-1]!r}].position",
    )


def no_body(name: str, names: Sequence[str]) -> InputError:
    """Error where a body is asked that is not there."""
    return InputError(f"there is no body {name!r}; there are: {', '.join(names)}.{suggest(name, names)}")


class TrajectorySource:
    """A trajectory that gives its arrays: one that a simulation gave, or one that was stored."""

    def to_data(self) -> TrajectoryData:
        """Plain arrays of all bodies."""
        raise NotImplementedError


@dataclass(frozen=True, eq=False)
class TrajectoryData(TrajectorySource):
    """Arrays of a trajectory, of all bodies; the attributes of a body are those of ``name``, or of the only one.

    Attributes
    ----------
    rows : dict of dict of array
        Arrays of each body, by its name and by `OF_BODIES`.
    sketch : Sketch
        Shapes, traces and units that go with it.
    name : str
        Body whose attributes these are; of several bodies without one they raise `InputError`.
    """

    algebra: str
    time: Array
    rows: dict[str, dict[str, Array]]
    energy: Array
    violation: Array
    integrator: str = ""
    ending: str | NDArray[np.str_] = "ok"
    message: str = ""
    steps: int | NDArray[np.int64] = 0
    sketch: Sketch = field(default_factory=Sketch)
    name: str = ""

    def __post_init__(self) -> None:
        if not self.name and len(self.rows) == 1:
            object.__setattr__(self, "name", next(iter(self.rows)))

    @property
    def _own(self) -> dict[str, Array]:
        """Arrays of the body."""
        if not self.name:
            raise several_bodies(list(self.rows))
        return self.rows[self.name]

    @property
    def bodies(self) -> dict[str, Self]:
        """All bodies, by name."""
        return {name: self._of(name) for name in self.rows}

    def _of(self, name: str) -> Self:
        return replace(self, name=name)

    def _screw(self, key: str) -> Multivector:
        home = stock_algebra(self.algebra)
        return home.wrap(home.kind("twist"), self._own[key])

    @cached_property
    def motor(self) -> Multivector:
        """Body to world."""
        home = stock_algebra(self.algebra)
        return home.wrap(home.kind("motor"), self._own["motor"])

    @property
    def position(self) -> Array:
        """Center of mass, in the world."""
        return self._own["position"]

    @property
    def orientation(self) -> Array:
        """Body to world."""
        return self._own["orientation"]

    @property
    def velocity(self) -> Array:
        """Velocity of the center of mass, in the world."""
        return self._own["velocity"]

    @property
    def angular_velocity(self) -> Array:
        """Along the body's axes."""
        return self._own["angular_velocity"]

    @property
    def momentum(self) -> Multivector:
        """In the world, moments about its origin."""
        return self._screw("momentum")

    @property
    def reaction(self) -> Multivector:
        """Wrench of all constraints together, in the world, moments about its origin."""
        return self._screw("reaction")

    @property
    def batch(self) -> tuple[int, ...]:
        """Shape of the batch: () for one simulation, (n,) for n."""
        return self.energy.shape[:-1]

    def path(self, point: Any) -> Array:
        """Positions (stores, 3) of a point (3,) of the body."""
        return np.asarray(self.position + self.orientation @ np.asarray(point, np.float64))

    def path_of(self, trace: Trace) -> Array:
        """Positions (stores, 3) of the point of a trace: of its body, of this one, or of the first."""
        return self.bodies[trace.body or self.name or next(iter(self.rows))].path(trace.point)

    def __getitem__(self, item: int | str) -> Self:
        """One simulation of a batch, or by name one body."""
        if isinstance(item, str):
            if item not in self.rows:
                raise no_body(item, list(self.rows))
            return self._of(item)
        if not self.batch:
            raise InputError("this is one simulation; only a batch has items.")
        if not -self.batch[0] <= item < self.batch[0]:
            raise InputError(f"there are {self.batch[0]} simulations, and none has the number {item}.")
        rows = {name: {key: x[item] for key, x in arrays.items()} for name, arrays in self.rows.items()}
        ending, steps = (np.broadcast_to(x, self.batch)[item] for x in (self.ending, self.steps))
        return replace(
            self, rows=rows, energy=self.energy[item], violation=self.violation[item], ending=str(ending),
            steps=int(steps),
        )  # fmt: skip

    def to_data(self) -> Self:
        """Itself."""
        return self

    def __len__(self) -> int:
        return len(self.time)

    def __repr__(self) -> str:
        until = self.time[-1] if len(self) else 0.0
        return f"<{type(self).__name__}: {len(self)} states to t = {until:.6g}, {self.integrator}>"


def starts_with_trajectory(*arguments: object) -> bool:
    """Test whether a writer is called in its old order, with the trajectory before the path."""
    return bool(arguments) and isinstance(arguments[0], TrajectorySource)


def data_of(trajectory: TrajectorySource, sketch: Sketch | None = None) -> TrajectoryData:
    """Arrays of a trajectory, with another sketch in place of its own if one is given.

    Raises
    ------
    InputError
        If it is not a trajectory, or the sketch names a body that is not there.
    """
    remedy = "Give what Simulation.run returned"
    data = as_instance(trajectory, "the trajectory", TrajectorySource, "a trajectory", remedy=remedy).to_data()
    if sketch is None:
        return data
    if not isinstance(sketch, Sketch):
        raise InputError(f"the sketch is a {type(sketch).__name__}; a dynamics.Sketch is needed.")
    for name in (*filter(None, sketch.shapes), *sketch.colors, *[t.body for t in sketch.traces if t.body]):
        if name not in data.rows:
            raise InputError(f"the sketch names the body {name!r}; there are: {', '.join(data.rows)}.")
    return replace(data, sketch=sketch)


__all__ = [
    "OF_BODIES",
    "SCREWS",
    "TrajectoryData",
    "TrajectorySource",
    "data_of",
    "no_body",
    "several_bodies",
    "starts_with_trajectory",
]
