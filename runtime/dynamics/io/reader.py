"""Reader of simulation files (docs/motion/simulations.md): a simulation, and the contents of its pictures.

Errors name file, line, key and remedy.
"""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import InputError, SimulationError
from ...common.documents import read_document
from ...common.files import as_path
from ...core.multivector import Multivector
from ...mechanics.io.fields import present_keys
from ...mechanics.io.reader import KeyPath
from ...mechanics.screws import couple, wrench
from ...mechanics.system import System
from ...mechanics.units import Units
from ..model import constraints, loads
from ..results.figure_spec import Sketch, Trace
from ..simulation import Simulation
from ..trajectory import Trajectory
from . import schema
from . import schema_parts as parts
from .bodies import WORLD, BodyEntry, BodyReader

Array = NDArray[Any]
#: An argument of `Simulation` or its `run` in a message.
_ARGUMENT = re.compile(r"\b(\w+)=(True|False|'[\w-]+'|\[\.\.\])")
#: Stored states by default.
STATES = 1000
#: Largest number of stored states.
MAX_STATES = 5_000_000


@dataclass(frozen=True, eq=False)
class Setup:
    """A simulation file, ready to run.

    Attributes
    ----------
    simulation : Simulation
    duration : float
    times : array
        Times of the states that are stored.
    options : dict
        Further arguments of `Simulation.run`: step, rtol, atol, project.
    sketch : Sketch
        Contents of pictures, stored with a trajectory.
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
            Arguments of `Simulation.run`, in place of the file's.
        """
        arguments = {"times": self.times, **self.options, **options}
        try:
            trajectory: Trajectory = self.simulation.run(self.duration, **arguments)
        except InputError as error:  # a start off its constraints, an integrator that does not serve them
            where = ": ".join(filter(None, (self.name, error.where)))
            raise type(error)(_in_toml(error.what), where=where, remedy=_in_toml(error.remedy)) from None
        except SimulationError as error:
            remedy = _in_toml(error.remedy)
            raise SimulationError(error.what, where=error.where, remedy=remedy, trajectory=error.trajectory) from error
        return trajectory


def _in_toml(text: Any) -> Any:
    """Message with the keys of a file in place of arguments of Python."""
    return text and _ARGUMENT.sub(lambda match: f"simulation.{match[1]} = {_value(match[2])}", text)


def _value(text: str) -> str:
    return text.lower() if text in ("True", "False") else text.replace("'", '"')


def load_simulation(path: str | os.PathLike[str]) -> Setup:
    """Read and check a simulation file.

    Raises
    ------
    InputError
        If it cannot be read, is not TOML, or does not fit the schema, with file, line and key.
    """
    file = as_path(path, "a simulation is read from")
    return _Reader(read_document(file, schema.FileTable), file.parent).setup()


class _Reader(BodyReader):
    """Reader of the rest of a checked file."""

    def setup(self) -> Setup:
        """Simulation of the file."""
        load_list = [self._load(x, ("loads", i)) for i, x in enumerate(self.table.loads)]
        constraint_list = [self._constraint(x, ("constraints", i)) for i, x in enumerate(self.table.constraints)]
        run = self.table.simulation
        options = {key: getattr(run, key) for key in present_keys(run, "step", "rtol", "atol", "project")}
        simulation, sketch = self._simulation(load_list, constraint_list), self._sketch(constraint_list)
        return Setup(simulation, run.duration, self._times(), options, sketch, self.document.name)

    # -- loads -------------------------------------------------------------------------------------------------

    def _load(self, table: Any, path: KeyPath) -> loads.Load:
        match table:
            case parts.GravityTable():
                return self.document.build(path, partial(loads.Gravity, table.acceleration))
            case parts.WorldWrenchTable():
                owner = self.owner(table, path)
                return loads.WorldWrench(self._wrench(table, None, path), owner.table.name)
            case parts.BodyWrenchTable():
                owner = self.owner(table, path)
                return loads.BodyWrench(self._wrench(table, owner, path), owner.table.name)
            case parts.SpringTable():
                owner = self.owner(table, path)
                name, other = self.other(table, path)
                point = self.position(table.point, (*path, "point"), owner)
                anchor = self.position(table.anchor, (*path, "anchor"), other)
                numbers = (table.stiffness, table.length, table.damping)
                return self.document.build(path, partial(loads.Spring, point, anchor, *numbers, owner.table.name, name))
            case parts.JointLoadTable():
                return self._joint_load(table, path)
            case _:
                owner = self.owner(table, path)
                law: Any = parts.LAW_TABLES[type(table)]
                values = {name: getattr(table, name) for name in law.numbers}
                names = {"body": owner.table.name, "other": self.other(table, path)[0]}
                built: loads.Load = self.document.build(path, partial(law, **values, **names))
                return built

    def _joint_load(self, table: parts.JointLoadTable, path: KeyPath) -> loads.Load:
        """A load on the joint of a name."""
        names = [joint.name for joint in self.table.joints]
        if names.count(table.joint) != 1:
            where = (*path, "joint")
            self.one_of(table.joint, [name for name in names if name is not None], where, "a joint")
            raise self.document.error(where, f"is {table.joint!r}, the name of several joints")
        values = {name: x for name, x in table if name not in ("kind", "joint")}
        load: Any = parts.JOINT_TABLES[type(table)]
        built: loads.Load = self.document.build(path, partial(load, names.index(table.joint), **values))
        return built

    def _wrench(self, table: parts.WrenchTable, owner: BodyEntry | None, path: KeyPath) -> Multivector:
        """A force and a couple together; in a body's frame, forces pass through its center by default."""
        place: Any = 0 if table.point is None else self.position(table.point, (*path, "point"), owner)
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
                pinned = self.object(table.object, (*path, "object"), owner)
                world = table.world
                there = None if world is None else self.object(world, (*path, "world"), frame)
                if world is not None and world.kind != table.object.kind:
                    raise self.document.error((*path, "world"), f"is a {world.kind}, the object a {table.object.kind}")
                return constraints.Pin(pinned, there, own, other)
            case parts.IncidenceTable():
                point = self.algebra.point(self.position(table.point, (*path, "point"), owner), strict=True)
                return constraints.Incidence(point, self.object(table.on, (*path, "on"), frame), own, other)
            case _:
                wrenches = [self._wrench(x, frame, (*path, "wrenches", i)) for i, x in enumerate(table.wrenches)]
                return constraints.VirtualPower(wrenches, own, other)

    # -- the run -----------------------------------------------------------------------------------------------

    def _simulation(self, load_list: list[loads.Load], constraint_list: list[constraints.Constraint]) -> Simulation:
        run = self.table.simulation
        options: dict[str, Any] = {
            "integrator": run.integrator, "map": run.map,
            "stabilization": run.stabilization or run.stabilisation or "auto",
        }  # fmt: skip
        if run.baumgarte is not None:
            options["baumgarte"] = run.baumgarte
        between = [self.joint(x, ("joints", i), [*self.bodies, WORLD]) for i, x in enumerate(self.table.joints)]
        names = [joint.name or f"joint_{i + 1}" for i, joint in enumerate(self.table.joints)]
        known = names if len(set(names)) == len(names) else ()
        system = System({name: entry.body for name, entry in self.bodies.items()}, between, WORLD, joint_names=known)
        return self.document.build(("simulation",), partial(Simulation, system, load_list, constraint_list, **options))

    def _times(self) -> Array:
        run = self.table.simulation
        if run.times is not None:
            times = np.array(run.times)
            for i, t in enumerate(run.times):
                if t > run.duration or (i and t <= run.times[i - 1]):
                    raise self.document.error(
                        ("simulation", "times", i), f"is {t:g}; times rise from 0 to the duration, {run.duration:g}"
                    )
            return times if len(times) and times[0] == 0 else np.concatenate([[0.0], times])
        interval = run.interval or run.duration / STATES
        count = (
            int(np.ceil(run.duration / interval * (1 - 1e-12)))
            if run.duration / interval < 2 * MAX_STATES
            else MAX_STATES + 1
        )
        if count > MAX_STATES:
            raise self.document.error(
                ("simulation", "interval"),
                f"is {interval:g}: more than {MAX_STATES} states in {run.duration:g}",
                "Store fewer",
            )
        return np.concatenate([np.arange(count) * interval, [run.duration]])

    # -- pictures ----------------------------------------------------------------------------------------------

    def _sketch(self, constraint_list: list[constraints.Constraint]) -> Sketch:
        table, units = self.table, self.table.units
        names = {name: entry.shape for name, entry in self.bodies.items() if entry.shape is not None}
        colors = {name: entry.table.color for name, entry in self.bodies.items() if entry.table.color is not None}
        traces = []
        for i, each in enumerate(table.traces):
            path: KeyPath = ("traces", i)
            owner = self.owner(each, path)
            point = self.position(each.point, (*path, "point"), owner)
            name = each.point if isinstance(each.point, str) else ""
            label = name if each.label is None else each.label
            traces.append(Trace(point, label, each.color, owner.table.name if len(self.bodies) > 1 else None))
        for i, t in enumerate(table.picture.shown or ()):
            if t > table.simulation.duration:
                raise self.document.error(
                    ("picture", "shown", i), f"is {t:g}, after the end at {table.simulation.duration:g}"
                )
        objects = [x for each in constraint_list for x in self._objects_of(each)] if table.picture.objects else []
        return Sketch(
            names, traces, objects, colors, Units(units.length, units.mass, units.time), table.picture.title or "",
            (table.picture.elevation, table.picture.azimuth),
            None if table.picture.shown is None else tuple(table.picture.shown),
        )  # fmt: skip

    def _objects_of(self, constraint: constraints.Constraint) -> list[Multivector]:
        """World-fixed objects of a constraint, for drawing."""
        if constraint.other is not None:
            return []
        if isinstance(constraint, constraints.Incidence):
            return [constraint.world_object] if isinstance(constraint.world_object, Multivector) else []
        if isinstance(constraint, constraints.Pin):
            return [self.bodies[str(constraint.body)].body.motor >> constraint.body_object]
        return []


__all__ = ["Setup", "load_simulation"]
