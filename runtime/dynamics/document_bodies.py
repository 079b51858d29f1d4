"""Bodies of a simulation file, and places on them: points by name, objects in their frames, errors that say the key."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..codegen.errors import BladesmithError, CompilerMissingError, InputError, MissingExtraError, suggest
from ..loading import stock_algebra
from ..multivector import Multivector
from ..tomlread import Document
from . import schema, schema_values, shapes
from .bodies import RigidBody
from .principal import principal

if TYPE_CHECKING:
    from ..algebras import Algebra

Array = NDArray[Any]
T = TypeVar("T")
KeyPath = tuple[str | int, ...]
#: What joints call the world.
WORLD = "base"


@dataclass(frozen=True, eq=False)
class Made:
    """A body, and what the rest of the file needs of it."""

    table: Any
    path: KeyPath
    body: RigidBody
    center: Array
    shape: shapes.Shape | None


class Ground:
    """A checked file, its bodies, and errors that point into it."""

    def __init__(self, document: Document[schema.FileTable], folder: Path) -> None:
        self.document, self.table, self.folder = document, document.contents, folder
        self.algebra: Algebra = stock_algebra(self.table.simulation.algebra)
        self.bodies: dict[str, Made] = {}
        for path, table in self.tables():
            if table.name in self.bodies:
                raise document.error((*path, "name"), f"is {table.name!r}, as of another body")
            if table.name == WORLD:
                raise document.error((*path, "name"), f"is {WORLD!r}, which is what joints call the world")
            self.bodies[table.name] = self.read_body(table, path)

    # -- errors ------------------------------------------------------------------------------------------------

    def made(self, path: KeyPath, make: Callable[[], T]) -> T:
        """What the schema cannot see: its error gets a file, a line and a key."""
        try:
            return make()
        except (MissingExtraError, CompilerMissingError):
            raise
        except BladesmithError as error:
            raise self.document.error(path, f"is refused: {_inside(error)}", error.remedy) from None

    # -- bodies ------------------------------------------------------------------------------------------------

    def tables(self) -> list[tuple[KeyPath, schema.BodyTable]]:
        single, several = self.table.body, self.table.bodies
        if single is not None and several:
            raise self.document.error(
                ("body",), "and bodies are both there; a single body is [body], more are [[bodies]]"
            )
        if single is not None:
            return [(("body",), single)]
        if not several:
            raise InputError("has no body.", where=self.document.name, remedy="Describe one under [body]")
        return [(("bodies", i), table) for i, table in enumerate(several)]

    def read_body(self, table: schema.BodyTable, path: KeyPath) -> Made:
        shape, center = self._shape(table, path)
        mass = table.mass if table.mass is not None else self._mass(table, shape)
        key = next(iter(schema_values.given(table, "moments", "tensor")), "shape")
        inertia = shape.inertia(mass) if shape is not None and key == "shape" else np.array(getattr(table, key))
        self.made((*path, key), partial(principal, inertia))
        turn = self._orientation(table, path)
        position, velocity, spin = (np.array(x) for x in (table.position, table.velocity, table.angular_velocity))
        if table.position_point is not None:
            position = position - turn @ self.point(table.position_point, table, center, (*path, "position_point"))
        if table.velocity_point is not None:
            point = self.point(table.velocity_point, table, center, (*path, "velocity_point"))
            velocity = velocity - turn @ np.cross(spin, point)
        make = partial(RigidBody, mass, inertia, position, turn, velocity, spin, self.algebra)
        return Made(table, path, self.made(path, make), center, shape)

    def _mass(self, table: schema.BodyTable, shape: shapes.Shape | None) -> float:
        assert table.density is not None and shape is not None  # the schema sees to it
        return table.density * shape.volume

    def _shape(self, table: schema.BodyTable, path: KeyPath) -> tuple[shapes.Shape | None, Array]:
        """The shape about the centre of mass, and the centre in the body's coordinates."""
        center = np.array(table.center or (0.0, 0.0, 0.0))
        match table.shape:
            case None:
                return None, center
            case schema.MeshTable(path=name, scale=scale):
                shape, own = self.made((*path, "shape", "path"), partial(shapes.mesh, self.folder / name, scale))
                if table.center is None:
                    return shape, own
                if not schema_values.given(table, "moments", "tensor"):
                    raise self.document.error(
                        (*path, "center"), "is that of the mesh; leave it out, or give moments or a tensor"
                    )
                moved = shape.vertices + own - center
                return shapes.Shape(moved, shape.faces, shape.volume, shape.gyration, shape.edges), center
            case given:
                measures = {key: value for key, value in given if key != "kind"}
                return self.made((*path, "shape"), partial(getattr(shapes, given.kind), **measures)), center

    def _orientation(self, table: schema.BodyTable, path: KeyPath) -> Array:
        given = table.orientation
        if given is None:
            return np.eye(3)
        if given.matrix is not None:
            home, matrix = self.algebra, np.eye(4)
            matrix[:3, :3] = given.matrix
            motor = self.made((*path, "orientation", "matrix"), partial(home.motor_from_matrix, matrix, strict=True))
        else:
            motor = self.made(
                (*path, "orientation"), partial(self.algebra.rotor, given.axis, given.radians, strict=True)
            )
        return self.algebra.matrix(motor.as_kind("motor"))[:3, :3]

    def which(self, name: str | None, path: KeyPath) -> Made:
        if name is None:
            if len(self.bodies) > 1:
                raise self.document.error(path, f"has no body, which is required: {', '.join(self.bodies)}")
            return next(iter(self.bodies.values()))
        if name not in self.bodies:
            raise self.document.error(
                path, f"is {name!r}, which is no body{suggest(name, self.bodies)}; there are: {', '.join(self.bodies)}"
            )
        return self.bodies[name]

    def owner(self, table: Any, path: KeyPath) -> Made:
        return self.which(table.body, path if table.body is None else (*path, "body"))

    def other(self, table: Any, path: KeyPath) -> tuple[str | None, Made | None]:
        if table.other is None:
            return None, None
        found = self.which(table.other, (*path, "other"))
        if found is self.owner(table, path):
            raise self.document.error((*path, "other"), f"is {table.other!r}, the same body")
        return found.table.name, found

    def place(self, place: Any, owner: Made | None, path: KeyPath) -> Array:
        """A point (3,) in a body's frame at its centre of mass, or in the world."""
        if owner is not None:
            return self.point(place, owner.table, owner.center, path)
        if isinstance(place, str):
            raise self.document.error(path, f"is {place!r}, a name; of the world three numbers are needed")
        return np.array(place)

    def point(self, place: Any, table: schema.BodyTable, center: Array, path: KeyPath) -> Array:
        if not isinstance(place, str):
            return np.array(place) - center
        if place == "center" and place not in table.points:
            return np.zeros(3)
        if place not in table.points:
            known = [*table.points, "center"]
            what = (
                f"is {place!r}, which is no point of {table.name}{suggest(place, known)}; there are: {', '.join(known)}"
            )
            raise self.document.error(path, what)
        return np.array(table.points[place]) - center

    def object(self, table: Any, owner: Made | None, path: KeyPath) -> Multivector:
        """An object in a body's frame at its centre of mass, or of the world."""
        maker = getattr(self.algebra, table.kind, None)
        if maker is None:
            kinds = ("point", "direction", "line", "plane")
            raise self.document.error(
                path, f"is a {table.kind}, which {self.algebra.name} has not; it has: {', '.join(kinds)}"
            )
        measures = {}
        for key, value in table:
            if key == "kind" or value is None:
                continue
            if key in ("xyz", "a", "b", "point", "center"):
                value = self.place(value, owner, (*path, key))
            measures[key] = value
        if table.kind == "plane":
            measures = self._plane(measures, owner)
        found: Multivector = self.made(path, partial(maker, **measures, strict=True))
        return found

    def _plane(self, measures: dict[str, Any], owner: Made | None) -> dict[str, Any]:
        """Unit normal and offset in a body's frame at its centre of mass, or in the world."""
        size = float(np.linalg.norm(measures["normal"]))
        normal = np.array(measures["normal"]) / size
        if "point" in measures:
            return {"normal": normal, "offset": float(normal @ measures["point"])}
        shift = 0.0 if owner is None else float(normal @ owner.center)
        return {"normal": normal, "offset": measures["offset"] / size - shift}


def _inside(error: BladesmithError) -> str:
    where = f"{error.where}: " if error.where else ""
    return where + error.what


__all__ = ["WORLD", "Ground", "KeyPath", "Made"]
