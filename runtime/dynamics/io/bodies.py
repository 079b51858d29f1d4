"""Bodies of a simulation file, with their points, objects in their frames, and errors that name the key."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import InputError
from ...common.documents import Document
from ...mechanics import shapes
from ...mechanics.io.fields import present_keys
from ...mechanics.io.reader import KeyPath, MechanicsReader
from ...mechanics.principal_axes import principal
from ...mechanics.rigid_body import RigidBody
from . import schema

Array = NDArray[Any]
#: Name of the world in joints.
WORLD = "base"


@dataclass(frozen=True, eq=False)
class BodyEntry:
    """A body of a file, with its table, shape and center of mass."""

    table: Any
    path: KeyPath
    body: RigidBody
    center: Array
    shape: shapes.Shape | None


class BodyReader(MechanicsReader[schema.FileTable]):
    """Reader of the bodies of a checked file."""

    def __init__(self, document: Document[schema.FileTable], folder: Path) -> None:
        super().__init__(document, folder, document.contents.simulation.algebra)
        self.bodies: dict[str, BodyEntry] = {}
        for path, table in self.tables():
            if table.name in self.bodies:
                raise document.error((*path, "name"), f"is {table.name!r}, the name of another body")
            if table.name == WORLD:
                raise document.error((*path, "name"), f"is {WORLD!r}, which is what joints call the world")
            self.bodies[table.name] = self.read_body(table, path)

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

    def read_body(self, table: schema.BodyTable, path: KeyPath) -> BodyEntry:
        shape, center = self._shape(table, path)
        mass = table.mass if table.mass is not None else self._mass(table, shape)
        key = next(iter(present_keys(table, "moments", "tensor")), "shape")
        inertia = shape.inertia(mass) if shape is not None and key == "shape" else np.array(getattr(table, key))
        self.document.build((*path, key), partial(principal, inertia))
        rotation = self._orientation(table, path)
        position, velocity, spin = (np.array(x) for x in (table.position, table.velocity, table.angular_velocity))
        if table.position_point is not None:
            position = position - rotation @ self.point(table.position_point, table, center, (*path, "position_point"))
        if table.velocity_point is not None:
            point = self.point(table.velocity_point, table, center, (*path, "velocity_point"))
            velocity = velocity - rotation @ np.cross(spin, point)
        make = partial(RigidBody, mass, inertia, position, rotation, velocity, spin, self.algebra)
        return BodyEntry(table, path, self.document.build(path, make), center, shape)

    def _mass(self, table: schema.BodyTable, shape: shapes.Shape | None) -> float:
        assert table.density is not None and shape is not None  # the schema sees to it
        return table.density * shape.volume

    def _shape(self, table: schema.BodyTable, path: KeyPath) -> tuple[shapes.Shape | None, Array]:
        """The shape about the center of mass, and the center in the body's coordinates."""
        center = np.array(table.center or (0.0, 0.0, 0.0))
        match table.shape:
            case None:
                return None, center
            case schema.MeshTable(path=name, scale=scale):
                shape, mesh_center = self.document.build(
                    (*path, "shape", "path"), partial(shapes.mesh, self.folder / name, scale)
                )
                if table.center is None:
                    return shape, mesh_center
                if not present_keys(table, "moments", "tensor"):
                    raise self.document.error(
                        (*path, "center"), "is that of the mesh; leave it out, or give moments or a tensor"
                    )
                vertices = shape.vertices + mesh_center - center
                return shapes.Shape(vertices, shape.faces, shape.volume, shape.gyration, shape.edges), center
            case measured:
                measures = {key: value for key, value in measured if key != "kind"}
                return self.document.build(
                    (*path, "shape"), partial(getattr(shapes, measured.kind), **measures)
                ), center

    def _orientation(self, table: schema.BodyTable, path: KeyPath) -> Array:
        if table.orientation is None:
            return np.eye(3)
        return self.algebra.matrix(self.rotor(table.orientation, (*path, "orientation")).as_kind("motor"))[:3, :3]

    def entry_of(self, name: str | None, path: KeyPath) -> BodyEntry:
        if name is None:
            if len(self.bodies) > 1:
                raise self.document.error(path, f"has no body, which is required: {', '.join(self.bodies)}")
            return next(iter(self.bodies.values()))
        return self.bodies[self.one_of(name, self.bodies, path, "a body")]

    def owner(self, table: Any, path: KeyPath) -> BodyEntry:
        return self.entry_of(table.body, path if table.body is None else (*path, "body"))

    def other(self, table: Any, path: KeyPath) -> tuple[str | None, BodyEntry | None]:
        if table.other is None:
            return None, None
        other = self.entry_of(table.other, (*path, "other"))
        if other is self.owner(table, path):
            raise self.document.error((*path, "other"), f"is {table.other!r}, the same body")
        return other.table.name, other

    def position(self, value: Any, path: KeyPath, owner: BodyEntry | None = None) -> Array:
        """Point (3,) in a body's frame at its center of mass, or in the world."""
        if owner is not None:
            return self.point(value, owner.table, owner.center, path)
        if isinstance(value, str):
            raise self.document.error(path, f"is {value!r}, a name; of the world three numbers are needed")
        return np.array(value)

    def point(self, value: Any, table: schema.BodyTable, center: Array, path: KeyPath) -> Array:
        """Point (3,) relative to a center, by its coordinates or its name."""
        if not isinstance(value, str):
            return np.array(value) - center
        if value == "center" and value not in table.points:
            return np.zeros(3)
        self.one_of(value, [*table.points, "center"], path, f"a point of {table.name}")
        return np.array(table.points[value]) - center


__all__ = ["WORLD", "BodyEntry", "BodyReader", "KeyPath"]
