"""Simulation files (docs/simulations.md): read, checked, and made into a simulation and what its pictures show.

Every fault is told with file, line, key and remedy.
"""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.errors import InputError, SimulationError
from ..kinematics import bilinear, joints
from ..multivector import Multivector
from ..tomlread import read_document
from . import constraints, loads, schema, schema_values
from . import schema_parts as parts
from .document_bodies import WORLD, Ground, KeyPath, Made
from .given import shown
from .screws import couple, wrench
from .simulation import Simulation
from .sketch import Sketch, Trace, Units
from .system import System
from .trajectory import Trajectory

Array = NDArray[Any]
#: An argument of `Simulation` or its `run` in a message.
_ARGUMENT = re.compile(r"\b(\w+)=(True|False|'[\w-]+'|\[\.\.\])")
#: States that are stored where nothing else is said, and at most.
STATES, MOST_STATES = 1000, 5_000_000


@dataclass(frozen=True, eq=False)
class Setup:
    """A simulation file, ready to run.

    Attributes
    ----------
    simulation : Simulation
    duration : float
    times : array
        Of the states that are stored.
    options : dict
        What `Simulation.run` takes besides: step, rtol, atol, project.
    sketch : Sketch
        What pictures show, and what is stored with a trajectory.
    """

    simulation: Simulation
    duration: float
    times: Array
    options: Mapping[str, float]
    sketch: Sketch
    name: str = ""

    def run(self, **options: Any) -> Trajectory:
        """Run it.

        Parameters
        ----------
        **options
            Of `Simulation.run`, in place of the file's.
        """
        given = {"times": self.times, **self.options, **options}
        try:
            found: Trajectory = self.simulation.run(self.duration, **given)
        except InputError as error:  # a start off its constraints, an integrator that does not serve them
            where = ": ".join(filter(None, (self.name, error.where)))
            raise type(error)(_in_toml(error.what), where=where, remedy=_in_toml(error.remedy)) from None
        except SimulationError as error:
            remedy = _in_toml(error.remedy)
            raise SimulationError(error.what, where=error.where, remedy=remedy, trajectory=error.trajectory) from error
        return found


def _in_toml(text: Any) -> Any:
    """What a message says of arguments of Python, said of keys of a file."""
    return text and _ARGUMENT.sub(lambda found: f"simulation.{found[1]} = {_value(found[2])}", text)


def _value(text: str) -> str:
    return text.lower() if text in ("True", "False") else text.replace("'", '"')


def load_simulation(path: str | os.PathLike[str]) -> Setup:
    """Read and check a simulation file.

    Raises
    ------
    InputError
        If it cannot be read, is no TOML, does not fit the schema, or means nothing: with file, line and key.
    """
    try:
        file = Path(os.fsdecode(path))
    except TypeError:
        raise InputError(f"a simulation is read from a file, and {shown(path)} names none.") from None
    if "\0" in str(file):
        raise InputError(f"the name {str(file)!r} has a null character.")
    return _Reader(read_document(str(file), schema.FileTable), file.parent).setup()


class _Reader(Ground):
    """A checked file on its way to a simulation."""

    def setup(self) -> Setup:
        """Everything."""
        acting = [self._load(x, ("loads", i)) for i, x in enumerate(self.table.loads)]
        holding = [self._constraint(x, ("constraints", i)) for i, x in enumerate(self.table.constraints)]
        run = self.table.simulation
        options = {key: getattr(run, key) for key in schema_values.given(run, "step", "rtol", "atol", "project")}
        return Setup(
            self._simulation(acting, holding), run.duration, self._times(), options, self._sketch(holding),
            self.document.name,
        )  # fmt: skip

    # -- loads -------------------------------------------------------------------------------------------------

    def _load(self, table: Any, path: KeyPath) -> loads.Load:
        match table:
            case parts.GravityTable():
                return self.made(path, partial(loads.Gravity, table.acceleration))
            case parts.WorldWrenchTable():
                owner = self.owner(table, path)
                return loads.WorldWrench(self._wrench(table, None, path), owner.table.name)
            case parts.BodyWrenchTable():
                owner = self.owner(table, path)
                return loads.BodyWrench(self._wrench(table, owner, path), owner.table.name)
            case parts.SpringTable():
                owner = self.owner(table, path)
                name, other = self.other(table, path)
                point = self.place(table.point, owner, (*path, "point"))
                anchor = self.place(table.anchor, other, (*path, "anchor"))
                numbers = (table.stiffness, table.length, table.damping)
                return self.made(path, partial(loads.Spring, point, anchor, *numbers, owner.table.name, name))
            case _:
                owner = self.owner(table, path)
                return self.made(path, partial(loads.Damper, table.angular, table.linear, owner.table.name))

    def _wrench(self, table: parts.Wrench, owner: Made | None, path: KeyPath) -> Multivector:
        """A force and a couple together; in a body's frame, forces pass through its centre by default."""
        place: Any = 0 if table.point is None else self.place(table.point, owner, (*path, "point"))
        summands = [wrench(table.force or (0.0, 0.0, 0.0), place, self.algebra, strict=True)]
        if table.couple is not None:
            summands.append(couple(table.couple, self.algebra, strict=True))
        total: Multivector = summands[0] if len(summands) == 1 else summands[0] + summands[1]
        return total

    # -- constraints -------------------------------------------------------------------------------------------

    def _constraint(self, table: Any, path: KeyPath) -> constraints.Constraint:
        owner = self.owner(table, path)
        other, frame = self.other(table, path)
        own = owner.table.name
        match table:
            case parts.PinTable():
                pinned = self.object(table.object, owner, (*path, "object"))
                world = table.world
                there = None if world is None else self.object(world, frame, (*path, "world"))
                if world is not None and world.kind != table.object.kind:
                    raise self.document.error((*path, "world"), f"is a {world.kind}, the object a {table.object.kind}")
                return constraints.Pin(pinned, there, own, other)
            case parts.IncidenceTable():
                point = self.algebra.point(self.place(table.point, owner, (*path, "point")), strict=True)
                return constraints.Incidence(point, self.object(table.on, frame, (*path, "on")), own, other)
            case _:
                wrenches = [self._wrench(x, frame, (*path, "wrenches", i)) for i, x in enumerate(table.wrenches)]
                return constraints.VirtualPower(wrenches, own, other)

    # -- the run -----------------------------------------------------------------------------------------------

    def _simulation(self, acting: list[loads.Load], holding: list[constraints.Constraint]) -> Simulation:
        run = self.table.simulation
        options: dict[str, Any] = {
            "integrator": run.integrator, "map": run.map,
            "stabilization": run.stabilization or run.stabilisation or "auto",
        }  # fmt: skip
        if run.baumgarte is not None:
            options["baumgarte"] = run.baumgarte
        between = [self._joint(x, ("joints", i)) for i, x in enumerate(self.table.joints)]
        system = System({name: made.body for name, made in self.bodies.items()}, between, WORLD)
        return self.made(("simulation",), partial(Simulation, system, acting, holding, **options))

    def _joint(self, table: Any, path: KeyPath) -> joints.Joint:
        for key in ("a", "b"):
            if getattr(table, key) != WORLD:
                self.which(getattr(table, key), (*path, key))
        if table.a == table.b:
            raise self.document.error((*path, "b"), f"is {table.b!r}, the same as a")
        home, ends = self.algebra, (table.a, table.b)
        match table:
            case parts.SphericalTable(point=point):
                return joints.Spherical(*ends, home.point(point, strict=True))
            case parts.RevoluteTable(point=point, axis=axis) if home.is_degenerate:
                return joints.Revolute(*ends, home.line(point, axis, strict=True), home.point(point, strict=True))
            case parts.RevoluteTable(point=point, axis=axis):
                return joints.Revolute(*ends, home.circle(point, axis, 1.0, strict=True))
            case parts.CylindricalTable(point=point, axis=axis):
                return joints.Cylindrical(*ends, home.line(point, axis, strict=True))
            case parts.PrismaticTable(point=point, axis=axis):
                beside = home.direction(np.cross(axis, np.eye(3)[np.abs(axis).argmin()]), strict=True)
                return self.made(path, partial(joints.Prismatic, *ends, home.line(point, axis, strict=True), beside))
            case parts.PlanarTable(point=point, normal=normal):
                way = np.array(normal) / np.linalg.norm(normal)
                return joints.Planar(*ends, home.plane(way, float(way @ point), strict=True))
            case _:
                if home.is_degenerate:
                    raise self.document.error(path, f"is universal, which {home.name} has not; use cga3d")
                circles = [home.circle(table.point, axis, 1.0, strict=True) for axis in (table.axis_a, table.axis_b)]
                return self.made(path, partial(bilinear.Universal, *ends, *circles))

    def _times(self) -> Array:
        run = self.table.simulation
        if run.times is not None:
            found = np.array(run.times)
            for i, t in enumerate(run.times):
                if t > run.duration or (i and t <= run.times[i - 1]):
                    raise self.document.error(
                        ("simulation", "times", i), f"is {t:g}; times rise from 0 to the duration, {run.duration:g}"
                    )
            return found if len(found) and found[0] == 0 else np.concatenate([[0.0], found])
        interval = run.interval or run.duration / STATES
        count = (
            int(np.ceil(run.duration / interval * (1 - 1e-12)))
            if run.duration / interval < 2 * MOST_STATES
            else MOST_STATES + 1
        )
        if count > MOST_STATES:
            raise self.document.error(
                ("simulation", "interval"),
                f"is {interval:g}: more than {MOST_STATES} states in {run.duration:g}",
                "Store fewer",
            )
        return np.concatenate([np.arange(count) * interval, [run.duration]])

    # -- pictures ----------------------------------------------------------------------------------------------

    def _sketch(self, holding: list[constraints.Constraint]) -> Sketch:
        table, units = self.table, self.table.units
        names = {name: made.shape for name, made in self.bodies.items() if made.shape is not None}
        colors = {name: made.table.color for name, made in self.bodies.items() if made.table.color is not None}
        traces = []
        for i, each in enumerate(table.traces):
            path: KeyPath = ("traces", i)
            owner = self.owner(each, path)
            point = self.place(each.point, owner, (*path, "point"))
            named = each.point if isinstance(each.point, str) else ""
            label = named if each.label is None else each.label
            traces.append(Trace(point, label, each.color, owner.table.name if len(self.bodies) > 1 else None))
        for i, t in enumerate(table.picture.shown or ()):
            if t > table.simulation.duration:
                raise self.document.error(
                    ("picture", "shown", i), f"is {t:g}, after the end at {table.simulation.duration:g}"
                )
        objects = [x for each in holding for x in self._held_by(each)] if table.picture.objects else []
        return Sketch(
            names, traces, objects, colors, Units(units.length, units.mass, units.time), table.picture.title or "",
            (table.picture.elevation, table.picture.azimuth),
            None if table.picture.shown is None else tuple(table.picture.shown),
        )  # fmt: skip

    def _held_by(self, constraint: constraints.Constraint) -> list[Multivector]:
        """What of the world holds a body."""
        if constraint.other is not None:
            return []
        if isinstance(constraint, constraints.Incidence):
            return [constraint.world_object] if isinstance(constraint.world_object, Multivector) else []
        if isinstance(constraint, constraints.Pin):
            return [self.bodies[str(constraint.body)].body.motor >> constraint.body_object]
        return []


__all__ = ["Setup", "load_simulation"]
