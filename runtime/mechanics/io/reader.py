"""Reader of what files of mechanisms and simulations share: objects, orientations and joints."""

from __future__ import annotations

from collections.abc import Collection
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel

from ...codegen.errors import suggest
from ...common.documents import Document
from ...core.registry import stock_algebra
from ..joints.base import Joint
from .geometry import OrientationTable
from .joints import KINDS

if TYPE_CHECKING:
    from ...core.multivector import Algebra, Multivector

Array = NDArray[Any]
FileTable = TypeVar("FileTable", bound=BaseModel)
KeyPath = tuple[str | int, ...]
#: Kinds of objects that every algebra has.
COMMON_OBJECTS = ("point", "direction", "line", "plane")
#: Keys of objects whose values are positions.
POSITIONS = ("xyz", "a", "b", "point", "center")


class MechanicsReader(Generic[FileTable]):
    """A checked file and the algebra of its objects; errors have file, line and key."""

    def __init__(self, document: Document[FileTable], folder: Path, algebra: str) -> None:
        self.document, self.table, self.folder = document, document.contents, folder
        self.algebra: Algebra = stock_algebra(algebra)

    def position(self, value: Any, path: KeyPath, owner: Any = None) -> Array:
        """Coordinates (3,), given directly or by a name, in the frame of their owner or in the world."""
        raise NotImplementedError

    def one_of(self, name: str, names: Collection[str], path: KeyPath, what: str) -> str:
        """A name, checked to be among some."""
        if name not in names:
            hint = f"{suggest(name, names)}; there are: {', '.join(names) or 'none'}"
            raise self.document.error(path, f"is {name!r}, which is not {what}{hint}")
        return name

    def object(self, table: Any, path: KeyPath, owner: Any = None) -> Multivector:
        """The object of a table, in the frame of its owner or in the world."""
        maker = getattr(self.algebra, table.kind, None)
        if maker is None:
            has = f"which {self.algebra.name} does not have; it has: {', '.join(COMMON_OBJECTS)}"
            raise self.document.error(path, f"is a {table.kind}, {has}")
        measures = {key: value for key, value in table if key != "kind" and value is not None}
        for key in POSITIONS:
            if key in measures:
                measures[key] = self.position(measures[key], (*path, key), owner)
        if table.kind == "plane":
            size = float(np.linalg.norm(measures["normal"]))
            normal = np.array(measures["normal"]) / size
            if "point" in measures:
                offset = float(normal @ measures["point"])
            else:
                offset = measures["offset"] / size + float(normal @ self.position((0.0, 0.0, 0.0), path, owner))
            measures = {"normal": normal, "offset": offset}
        x: Multivector = self.document.build(path, partial(maker, **measures, strict=True))
        return x

    def rotor(self, table: OrientationTable, path: KeyPath) -> Multivector:
        """The rotor of an orientation."""
        rotor: Multivector
        if table.matrix is None:
            rotor = self.document.build(path, partial(self.algebra.rotor, *table.rotation, strict=True))
        else:
            matrix = np.eye(4)
            matrix[:3, :3] = table.matrix
            make = partial(self.algebra.motor_from_matrix, matrix, strict=True)
            rotor = self.document.build((*path, "matrix"), make)
        return rotor

    def joint(self, table: Any, path: KeyPath, bodies: Collection[str]) -> Joint:
        """The joint of a table, between some of the bodies."""
        for key in ("a", "b"):
            self.one_of(getattr(table, key), bodies, (*path, key), "a body")
        if table.a == table.b:
            raise self.document.error((*path, "b"), f"is {table.b!r}, the same as a")
        ends, kind, options = (table.a, table.b), KINDS[table.kind], table.options()
        if table.objects is None:
            if table.kind == "universal" and self.algebra.is_degenerate:
                what = f"is universal, which {self.algebra.name} does not have; use cga3d"
                raise self.document.error(path, what)
            point = np.zeros(3) if table.point is None else self.position(table.point, (*path, "point"))
            return self.document.build(path, partial(kind, *ends, **table.placement(point, self.algebra), **options))
        objects = [self.object(x, (*path, "objects", i)) for i, x in enumerate(table.objects)]
        try:
            return self.document.build(path, partial(kind, *ends, *objects, **options))
        except TypeError:
            what = f"are {len(objects)}, which is not the number of objects of a {table.kind} joint"
            raise self.document.error((*path, "objects"), what) from None


__all__ = ["KeyPath", "MechanicsReader"]
