"""Joints of a mechanism file: by places and directions or by shared objects; errors that say the key."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..codegen.errors import BladesmithError, CompilerMissingError, MissingExtraError, suggest
from ..loading import stock_algebra
from ..tomlread import Document
from . import bilinear, joints, schema

if TYPE_CHECKING:
    from ..multivector import Multivector

Array = NDArray[Any]
T = TypeVar("T")
KeyPath = tuple[str | int, ...]
#: Joints by the kind that a file gives.
KINDS: dict[str, Any] = {
    "spherical": joints.Spherical, "revolute": joints.Revolute, "cylindrical": joints.Cylindrical,
    "prismatic": joints.Prismatic, "planar": joints.Planar, "universal": bilinear.Universal, "rigid": joints.Rigid,
    "bilinear": bilinear.Bilinear,
}  # fmt: skip


class Ground:
    """A checked file, its points and joints, and errors that point into it."""

    def __init__(self, document: Document[schema.FileTable], folder: Path, tip: str | None, root: str | None) -> None:
        self.document, self.table, self.folder = document, document.contents, folder
        self.tip, self.root = tip, root
        algebra = "cga3d" if self.table.mechanism is None else self.table.mechanism.algebra
        self.algebra = stock_algebra(algebra)

    # -- errors ------------------------------------------------------------------------------------------------

    def made(self, path: KeyPath, make: Callable[[], T]) -> T:
        """What the schema cannot see: its error gets a file, a line and a key."""
        try:
            return make()
        except (MissingExtraError, CompilerMissingError):
            raise
        except BladesmithError as error:
            where = f"{error.where}: " if error.where else ""
            raise self.document.error(path, f"is refused: {where}{error.what}", error.remedy) from None

    def among(self, name: str, known: Any, path: KeyPath, what: str) -> str:
        """A name that is one of some."""
        if name not in known:
            there = ", ".join(known) or "none"
            raise self.document.error(
                path, f"is {name!r}, which is no {what}{suggest(name, known)}; there are: {there}"
            )
        return name

    def place(self, place: Any, path: KeyPath) -> Array:
        """Coordinates (3,), or those of a point by its name."""
        if isinstance(place, str):
            return np.array(self.table.points[self.among(place, self.table.points, path, "point")])
        return np.array(place)

    def joint(self, table: Any, path: KeyPath) -> joints.Joint:
        own = self.table.mechanism
        assert own is not None
        for key in ("a", "b"):
            self.among(getattr(table, key), own.bodies, (*path, key), "body")
        if table.a == table.b:
            raise self.document.error((*path, "b"), f"is {table.b!r}, the same as a")
        ends = (table.a, table.b)
        kind = KINDS[table.kind]
        if table.objects is not None:
            made = [self.object(x, (*path, "objects", i)) for i, x in enumerate(table.objects)]
            options = {"product": table.product} if table.kind == "bilinear" else {}
            try:
                built: joints.Joint = self.made(path, partial(kind, *ends, *made, **options))
                return built
            except TypeError:
                raise self.document.error(
                    (*path, "objects"), f"are {len(made)}, which is no number of objects of a {table.kind} joint"
                ) from None
        make = partial(self._by_places, table, kind, ends, (*path, "point"))
        return self.made(path, make)

    def _by_places(self, table: Any, kind: Any, ends: tuple[str, str], path: KeyPath) -> joints.Joint:
        home = self.algebra
        point = np.zeros(3) if table.point is None else self.place(table.point, path)
        match table:
            case schema.SphericalTable():
                objects: tuple[Any, ...] = (home.point(point, strict=True),)
            case schema.RevoluteTable(axis=axis) if home.is_degenerate:
                objects = (home.line(point, axis, strict=True), home.point(point, strict=True))
            case schema.RevoluteTable(axis=axis):
                objects = (home.circle(point, axis, 1.0, strict=True),)
            case schema.CylindricalTable(axis=axis):
                objects = (home.line(point, axis, strict=True),)
            case schema.PrismaticTable(axis=axis):
                way = np.array(axis, float)
                beside = np.cross(way, np.eye(3)[np.abs(way).argmin()])
                objects = (home.line(point, axis, strict=True), home.direction(beside, strict=True))
            case schema.PlanarTable(normal=normal):
                way = np.array(normal) / np.linalg.norm(np.array(normal))
                objects = (home.plane(way, float(way @ point), strict=True),)
            case schema.UniversalTable():
                if home.is_degenerate:
                    raise self.document.error(path[:-1], f"is universal, which {home.name} has not; use cga3d")
                objects = tuple(home.circle(point, x, 1.0, strict=True) for x in (table.axis_a, table.axis_b))
            case _:
                objects = (point, home)
        found: joints.Joint = kind(*ends, *objects)
        return found

    def object(self, table: Any, path: KeyPath) -> Multivector:
        """An object of the world, where the bodies are at the start."""
        maker = getattr(self.algebra, table.kind, None)
        if maker is None:
            raise self.document.error(
                path, f"is a {table.kind}, which {self.algebra.name} has not; it has: point, direction, line, plane"
            )
        measures = {}
        for key, value in table:
            if key != "kind" and value is not None:
                named = key in ("xyz", "a", "b", "point", "center")
                measures[key] = self.place(value, (*path, key)) if named else value
        if table.kind == "plane":
            size = float(np.linalg.norm(measures["normal"]))
            normal = np.array(measures["normal"]) / size
            offset = float(normal @ measures["point"]) if "point" in measures else measures["offset"] / size
            measures = {"normal": normal, "offset": offset}
        found: Multivector = self.made(path, partial(maker, **measures, strict=True))
        return found


__all__ = ["Ground", "KeyPath"]
