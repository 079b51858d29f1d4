"""Simulation files (docs/simulations.md): read, checked, and made into a simulation and what its pictures show.

Every fault is told with file, line, key and remedy.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..codegen.errors import BladesmithError, CompilerMissingError, InputError, MissingExtraError, suggest
from ..loading import stock_algebra
from ..multivector import Multivector
from ..tomlread import Document, read_document
from . import constraints, loads, schema, shapes
from .bodies import RigidBody
from .principal import principal
from .screws import couple, wrench
from .simulation import Simulation
from .sketch import Sketch, Trace, Units
from .trajectory import Trajectory

if TYPE_CHECKING:
    from ..algebras import Algebra

Array = NDArray[Any]
T = TypeVar("T")
Path_ = tuple[str | int, ...]
#: States that are stored where nothing else is said, and at most.
STATES, MOST_STATES = 1000, 5_000_000


@dataclass(frozen=True, eq=False)
class Setup:
    """A simulation file, ready to run.

    Attributes
    ----------
    simulation : Simulation or System
    duration : float
    times : array
        Of the states that are stored.
    options : dict
        What `Simulation.run` takes besides: step, rtol, atol.
    sketch : Sketch
        What pictures show, and what is stored with a trajectory.
    """

    simulation: Any
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
        found: Trajectory = self.simulation.run(self.duration, **given)
        return found


@dataclass(frozen=True, eq=False)
class _Made:
    """A body, and what the rest of the file needs of it."""

    table: Any
    path: Path_
    body: RigidBody
    center: Array
    shape: shapes.Shape | None


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
        raise InputError(f"a simulation is read from a file, and {path!r} names none.") from None
    if "\0" in str(file):
        raise InputError(f"the name {str(file)!r} has a null character.")
    return _Reader(read_document(str(file), schema.FileTable), file.parent).setup()


class _Reader:
    """A checked file on its way to a simulation."""

    def __init__(self, document: Document[schema.FileTable], folder: Path) -> None:
        self.document, self.table, self.folder = document, document.contents, folder
        self.algebra: Algebra = stock_algebra(self.table.simulation.algebra)
        self.bodies: dict[str, _Made] = {}

    def setup(self) -> Setup:
        """Everything."""
        for path, table in self._tables():
            if table.name in self.bodies:
                raise self.document.error((*path, "name"), f"is {table.name!r}, as of another body")
            self.bodies[table.name] = self._body(table, path)
        acting = [self._load(x, ("loads", i)) for i, x in enumerate(self.table.loads)]
        holding = [self._constraint(x, ("constraints", i)) for i, x in enumerate(self.table.constraints)]
        run = self.table.simulation
        options = {key: getattr(run, key) for key in schema.given(run, "step", "rtol", "atol")}
        return Setup(
            self._simulation(acting, holding), run.duration, self._times(), options, self._sketch(holding),
            self.document.name,
        )  # fmt: skip

    # -- errors ------------------------------------------------------------------------------------------------

    def made(self, path: Path_, make: Callable[[], T]) -> T:
        """What the schema cannot see: its error gets a file, a line and a key."""
        try:
            return make()
        except (MissingExtraError, CompilerMissingError):
            raise
        except BladesmithError as error:
            raise self.document.error(path, f"is refused: {_inside(error)}", error.remedy) from None

    # -- bodies ------------------------------------------------------------------------------------------------

    def _tables(self) -> list[tuple[Path_, schema.BodyTable]]:
        single, several = self.table.body, self.table.bodies
        if single is not None and several:
            raise self.document.error(("body",), "and bodies are both there; a single body is [body], more are [[bodies]]")
        if single is not None:
            return [(("body",), single)]
        if not several:
            raise InputError("has no body.", where=self.document.name, remedy="Describe one under [body]")
        return [(("bodies", i), table) for i, table in enumerate(several)]

    def _body(self, table: schema.BodyTable, path: Path_) -> _Made:
        shape, center = self._shape(table, path)
        mass = table.mass if table.mass is not None else self._mass(table, shape)
        key = next(iter(schema.given(table, "moments", "tensor")), "shape")
        inertia = shape.inertia(mass) if shape is not None and key == "shape" else np.array(getattr(table, key))
        self.made((*path, key), partial(principal, inertia))
        turn = self._orientation(table, path)
        position, velocity, spin = (np.array(x) for x in (table.position, table.velocity, table.angular_velocity))
        if table.position_point is not None:
            position = position - turn @ self._point(table.position_point, table, center, (*path, "position_point"))
        if table.velocity_point is not None:
            point = self._point(table.velocity_point, table, center, (*path, "velocity_point"))
            velocity = velocity - turn @ np.cross(spin, point)
        make = partial(RigidBody, mass, inertia, position, turn, velocity, spin, self.algebra)
        return _Made(table, path, self.made(path, make), center, shape)

    def _mass(self, table: schema.BodyTable, shape: shapes.Shape | None) -> float:
        assert table.density is not None and shape is not None  # the schema sees to it
        return table.density * shape.volume

    def _shape(self, table: schema.BodyTable, path: Path_) -> tuple[shapes.Shape | None, Array]:
        """The shape about the centre of mass, and the centre in the body's coordinates."""
        center = np.array(table.center or (0.0, 0.0, 0.0))
        match table.shape:
            case None:
                return None, center
            case schema.MeshTable(path=name, scale=scale):
                shape, own = self.made((*path, "shape", "path"), partial(shapes.mesh, self.folder / name, scale))
                if table.center is None:
                    return shape, own
                if not schema.given(table, "moments", "tensor"):
                    raise self.document.error((*path, "center"), "is that of the mesh; leave it out, or give moments or a tensor")
                moved = shape.vertices + own - center
                return shapes.Shape(moved, shape.faces, shape.volume, shape.gyration, shape.edges), center
            case given:
                measures = {key: value for key, value in given if key != "kind"}
                return self.made((*path, "shape"), partial(getattr(shapes, given.kind), **measures)), center

    def _orientation(self, table: schema.BodyTable, path: Path_) -> Array:
        given = table.orientation
        if given is None:
            return np.eye(3)
        if given.matrix is not None:
            home, matrix = self.algebra, np.eye(4)
            matrix[:3, :3] = given.matrix
            motor = self.made((*path, "orientation", "matrix"), partial(home.motor_from_matrix, matrix, strict=True))
        else:
            motor = self.made((*path, "orientation"), partial(self.algebra.rotor, given.axis, given.radians, strict=True))
        return self.algebra.matrix(motor.as_kind("motor"))[:3, :3]

    def _which(self, name: str | None, path: Path_) -> _Made:
        if name is None:
            if len(self.bodies) > 1:
                raise self.document.error(path, f"has no body, which is required: {', '.join(self.bodies)}")
            return next(iter(self.bodies.values()))
        if name not in self.bodies:
            raise self.document.error(path, f"is {name!r}, which is no body{suggest(name, self.bodies)}; there are: {', '.join(self.bodies)}")
        return self.bodies[name]

    def _owner(self, table: Any, path: Path_) -> _Made:
        return self._which(table.body, path if table.body is None else (*path, "body"))

    def _other(self, table: Any, path: Path_) -> tuple[str | None, _Made | None]:
        if table.other is None:
            return None, None
        found = self._which(table.other, (*path, "other"))
        if found is self._owner(table, path):
            raise self.document.error((*path, "other"), f"is {table.other!r}, the same body")
        return found.table.name, found

    def _place(self, place: Any, owner: _Made | None, path: Path_) -> Array:
        """A point (3,) in a body's frame at its centre of mass, or in the world."""
        if owner is not None:
            return self._point(place, owner.table, owner.center, path)
        if isinstance(place, str):
            raise self.document.error(path, f"is {place!r}, a name; of the world three numbers are needed")
        return np.array(place)

    def _point(self, place: Any, table: schema.BodyTable, center: Array, path: Path_) -> Array:
        if not isinstance(place, str):
            return np.array(place) - center
        if place == "center" and place not in table.points:
            return np.zeros(3)
        if place not in table.points:
            known = [*table.points, "center"]
            what = f"is {place!r}, which is no point of {table.name}{suggest(place, known)}; there are: {', '.join(known)}"
            raise self.document.error(path, what)
        return np.array(table.points[place]) - center

    # -- loads -------------------------------------------------------------------------------------------------

    def _load(self, table: Any, path: Path_) -> loads.Load:
        match table:
            case schema.GravityTable():
                return self.made(path, partial(loads.Gravity, table.acceleration))
            case schema.WorldWrenchTable():
                owner = self._owner(table, path)
                return loads.WorldWrench(self._wrench(table, None, path), owner.table.name)
            case schema.BodyWrenchTable():
                owner = self._owner(table, path)
                return loads.BodyWrench(self._wrench(table, owner, path), owner.table.name)
            case schema.SpringTable():
                owner = self._owner(table, path)
                name, other = self._other(table, path)
                ends = [self._place(table.point, owner, (*path, "point")), self._place(table.anchor, other, (*path, "anchor"))]
                numbers = (table.stiffness, table.length, table.damping)
                return self.made(path, partial(loads.Spring, *ends, *numbers, owner.table.name, name))
            case _:
                owner = self._owner(table, path)
                return self.made(path, partial(loads.Damper, table.angular, table.linear, owner.table.name))

    def _wrench(self, table: schema.Wrench, owner: _Made | None, path: Path_) -> Multivector:
        """A force and a couple together; in a body's frame, forces pass through its centre by default."""
        place: Any = 0 if table.point is None else self._place(table.point, owner, (*path, "point"))
        parts = [wrench(table.force or (0.0, 0.0, 0.0), place, self.algebra, strict=True)]
        if table.couple is not None:
            parts.append(couple(table.couple, self.algebra, strict=True))
        total: Multivector = parts[0] if len(parts) == 1 else parts[0] + parts[1]
        return total

    # -- constraints -------------------------------------------------------------------------------------------

    def _constraint(self, table: Any, path: Path_) -> constraints.Constraint:
        owner = self._owner(table, path)
        other, frame = self._other(table, path)
        own = owner.table.name
        match table:
            case schema.PinTable():
                pinned = self._object(table.object, owner, (*path, "object"))
                there = None if table.world is None else self._object(table.world, frame, (*path, "world"))
                if there is not None and table.world.kind != table.object.kind:
                    raise self.document.error((*path, "world"), f"is a {table.world.kind}, the object a {table.object.kind}")
                return constraints.Pin(pinned, there, own, other)
            case schema.IncidenceTable():
                point = self.algebra.point(self._place(table.point, owner, (*path, "point")), strict=True)
                return constraints.Incidence(point, self._object(table.on, frame, (*path, "on")), own, other)
            case _:
                wrenches = [
                    self._wrench(x, frame, (*path, "wrenches", i)) for i, x in enumerate(table.wrenches)
                ]
                return constraints.VirtualPower(wrenches, own, other)

    def _object(self, table: Any, owner: _Made | None, path: Path_) -> Multivector:
        """An object in a body's frame at its centre of mass, or of the world."""
        maker = getattr(self.algebra, table.kind, None)
        if maker is None:
            kinds = ("point", "direction", "line", "plane")
            raise self.document.error(path, f"is a {table.kind}, which {self.algebra.name} has not; it has: {', '.join(kinds)}")
        measures = {}
        for key, value in table:
            if key == "kind" or value is None:
                continue
            if key in ("xyz", "a", "b", "point", "center"):
                value = self._place(value, owner, (*path, key))
            measures[key] = value
        if table.kind == "plane":
            normal = np.array(measures["normal"]) / np.linalg.norm(measures["normal"])
            if "point" in measures:
                measures["offset"] = float(normal @ measures.pop("point"))
            elif owner is not None:
                measures["offset"] = measures["offset"] / np.linalg.norm(measures["normal"]) - float(normal @ owner.center)
                measures["normal"] = normal
        found: Multivector = self.made(path, partial(maker, **measures, strict=True))
        return found

    # -- the run -----------------------------------------------------------------------------------------------

    def _simulation(self, acting: list[loads.Load], holding: list[constraints.Constraint]) -> Any:
        run = self.table.simulation
        options = {
            "integrator": run.integrator, "map": run.map,
            "stabilization": run.stabilization or run.stabilisation or "auto",
        }  # fmt: skip
        bodies = {name: made.body for name, made in self.bodies.items()}
        if len(bodies) > 1:
            return self.made(("bodies",), partial(_system, bodies, acting, holding, options))
        own = [_on_single(x) for x in (*acting, *holding)]
        body = next(iter(bodies.values()))
        return self.made(("simulation",), partial(Simulation, body, own[: len(acting)], own[len(acting) :], **options))

    def _times(self) -> Array:
        run = self.table.simulation
        if run.times is not None:
            found = np.array(run.times)
            for i, t in enumerate(run.times):
                if t > run.duration or (i and t <= run.times[i - 1]):
                    raise self.document.error(("simulation", "times", i), f"is {t:g}; times rise from 0 to the duration, {run.duration:g}")
            return found if len(found) and found[0] == 0 else np.concatenate([[0.0], found])
        interval = run.interval or run.duration / STATES
        count = int(np.ceil(run.duration / interval * (1 - 1e-12))) if run.duration / interval < 2 * MOST_STATES else MOST_STATES + 1
        if count > MOST_STATES:
            raise self.document.error(
                ("simulation", "interval"), f"is {interval:g}: more than {MOST_STATES} states in {run.duration:g}", "Store fewer"
            )
        return np.concatenate([np.arange(count) * interval, [run.duration]])

    # -- pictures ----------------------------------------------------------------------------------------------

    def _sketch(self, holding: list[constraints.Constraint]) -> Sketch:
        table, units = self.table, self.table.units
        names = {name: made.shape for name, made in self.bodies.items() if made.shape is not None}
        colors = {name: made.table.color for name, made in self.bodies.items() if made.table.color is not None}
        traces = []
        for i, each in enumerate(table.traces):
            path: Path_ = ("traces", i)
            owner = self._owner(each, path)
            point = self._place(each.point, owner, (*path, "point"))
            label = each.label or (each.point if isinstance(each.point, str) else "")
            traces.append(Trace(point, label, each.color, owner.table.name if len(self.bodies) > 1 else None))
        for i, t in enumerate(table.picture.shown or ()):
            if t > table.simulation.duration:
                raise self.document.error(("picture", "shown", i), f"is {t:g}, after the end at {table.simulation.duration:g}")
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


def _on_single(each: Any) -> Any:
    """A load or constraint whose body is the only one: it is number 0."""
    from dataclasses import replace

    return each if isinstance(each, loads.Gravity) else replace(each, body=0)


def _system(bodies: dict[str, RigidBody], acting: list[Any], holding: list[Any], options: dict[str, Any]) -> Any:
    raise InputError("simulations of several bodies are not served yet")


def _inside(error: BladesmithError) -> str:
    where = f"{error.where}: " if error.where else ""
    return where + error.what


__all__ = ["Setup", "load_simulation"]
