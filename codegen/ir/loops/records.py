"""Records: rows of numbers with named fields, declared once for algorithms, NumPy and C."""

from __future__ import annotations

import keyword
from collections.abc import Mapping
from math import prod
from typing import Any

import numpy as np

from ...errors import AlgorithmError, suggest
from .types import INT, REAL, Annotation, ArrayType, Scalar


class Record(Annotation):
    """A layout: names of the parts of a row.

    As an annotation of an algorithm's parameter it is one row; ``Rows[Body]`` is as many as there are at run time.

    Attributes
    ----------
    name : str
    size : int
        Numbers of a row.
    offsets : mapping of str to int
        Where each field begins.
    shapes : mapping of str to tuple of int
        Of each field; ``()``: a number.
    scalar : Scalar
        Of all fields: `REAL` or `INT`.
    still : frozenset of str
        Fields that derivatives take for constant where a kernel reads them.
    records : mapping of str to Record
        Of fields that are a row of another record.
    """

    def __init__(
        self, name: str, shapes: Mapping[str, tuple[int, ...]], scalar: Scalar = REAL,
        records: Mapping[str, Record] | None = None,
    ) -> None:  # fmt: skip
        self.name, self.scalar, self.records = name, scalar, dict(records or {})
        self.still: frozenset[str] = frozenset()
        self.size = 0
        self.shapes = {**shapes, **{field: (each.size,) for field, each in self.records.items()}}
        self.offsets: dict[str, int] = {}
        for field, shape in self.shapes.items():
            self.offsets[field] = self.size
            self.size += prod(shape)
        super().__init__(ArrayType(scalar, (self.size,), record=self))

    def field(self, name: str) -> tuple[int, ArrayType | Scalar]:
        """Offset and type of a field.

        Raises
        ------
        AlgorithmError
            If there is none of this name.
        """
        if name not in self.offsets:
            known = ", ".join(self.offsets)
            raise AlgorithmError(
                f"{self.name} has no field {name}{suggest(name, self.offsets)}", remedy=f"There are: {known}."
            )
        shape, row = self.shapes[name], self.records.get(name)
        return self.offsets[name], ArrayType(self.scalar, shape, record=row) if shape else self.scalar

    def with_still(self, *names: str) -> Record:
        """The record, with fields that no derivative varies."""
        found = Record(self.name, self.shapes, self.scalar, self.records)
        found.still = frozenset(names)
        return found

    def extent(self, name: str) -> tuple[int, int]:
        """Where a field begins in a row, and how many numbers it has.

        Raises
        ------
        AlgorithmError
            If there is none of this name.
        """
        offset, type = self.field(name)
        return offset, type.size if isinstance(type, ArrayType) else 1

    def zeros(self, *shape: int, dtype: Any = None) -> RecordArray:
        """Rows of zeros, with attributes for the fields. Default: float64, or int64 for integers."""
        return self.view(np.zeros((*shape, self.size), dtype or (np.int64 if self.scalar == INT else np.float64)))

    def view(self, array: Any) -> RecordArray:
        """An array of rows, with attributes for the fields.

        Raises
        ------
        AlgorithmError
            If its last axis has another length.
        """
        rows = np.asarray(array)
        if rows.ndim == 0 or rows.shape[-1] != self.size:
            raise AlgorithmError(
                f"an array of shape {rows.shape} for {self.name}", remedy=f"Its last axis must be {self.size}."
            )
        found = rows.view(RecordArray)
        object.__setattr__(found, "_record", self)
        return found

    def c_text(self, prefix: str) -> str:
        """C: where each field begins and the size of a row, as constants ``<prefix>_<FIELD>`` and ``<prefix>_SIZE``."""
        entries = [f"{prefix}_{name.upper()} = {offset}" for name, offset in self.offsets.items()]
        return f"/* {self.name} */\nenum {{ {', '.join([*entries, f'{prefix}_SIZE = {self.size}'])} }};\n"

    def c_fields(self) -> str:
        """C: the fields as members of a structure whose numbers follow each other as those of a row do."""
        type = "ptrdiff_t" if self.scalar == INT else "S"
        return "".join(f"  {type} {name}{''.join(f'[{n}]' for n in shape)};\n" for name, shape in self.shapes.items())


def record(name: str, **fields: Any) -> Record:
    """Declare a record.

    Parameters
    ----------
    name : str
        For messages.
    **fields : Real, Vector[n], Matrix[m, n] or a record of such; or all of them Int, IntVector[n] or records of these
        In the order of the row.

    Raises
    ------
    AlgorithmError
        If a field is of another type than these or than the others, or its name cannot be an attribute.

    Examples
    --------
    >>> from bladesmith.codegen.language import Matrix, Real, Vector, record
    >>> Body = record("Body", mass=Real, position=Vector[3], inertia=Matrix[3, 3])
    >>> bodies = Body.zeros(10)
    >>> bodies.position.shape
    (10, 3)
    """
    shapes: dict[str, tuple[int, ...]] = {}
    scalars: list[Scalar] = []
    records: dict[str, Record] = {}
    for field, annotation in fields.items():
        if hasattr(np.ndarray, field) or keyword.iskeyword(field) or field.startswith("_") or not field.isascii():
            raise AlgorithmError(f"{name}: {field} cannot be a field", remedy="Choose another name.")
        type = annotation.type if isinstance(annotation, Annotation) and annotation.access == "in" else None
        if isinstance(type, ArrayType) and not type.is_generic and not type.is_open:
            shapes[field] = tuple(n for n in type.sizes if n is not None)
            scalars.append(type.scalar)
            if type.record is not None:
                records[field] = type.record
        elif isinstance(type, Scalar):
            shapes[field] = ()
            scalars.append(type)
        if field not in shapes or scalars[-1] not in (REAL, INT) or scalars[-1] != scalars[0]:
            remedy = "Use Real, Vector[n] and Matrix[m, n], or Int and IntVector[n] for all fields."
            raise AlgorithmError(f"{name}: {field} has another type", remedy=remedy)
    if not shapes:
        raise AlgorithmError(f"{name} has no field", remedy="Declare one, such as mass=Real.")
    return Record(name, shapes, scalars[0], records)


class RecordArray(np.ndarray[Any, Any]):
    """Rows of a record: an array whose attributes are views of the fields."""

    _record: Record | None = None

    def __array_finalize__(self, source: Any) -> None:
        object.__setattr__(self, "_record", getattr(source, "_record", None))

    def _place(self, name: str) -> tuple[Record, int]:
        layout = self._record
        if layout is None or name not in layout.offsets or self.ndim == 0 or self.shape[-1] != layout.size:
            raise AttributeError(f"no field {name!r} of {layout.name if layout else 'an array'}")
        return layout, layout.offsets[name]

    def __getattr__(self, name: str) -> Any:
        layout, offset = self._place(name)
        shape = layout.shapes[name]
        rows = np.asarray(self)
        if not shape:
            return rows[offset] if rows.ndim == 1 else rows[..., offset]  # a number, no view that changes later
        part = rows[..., offset : offset + prod(shape)]
        if name in layout.records:
            return layout.records[name].view(part)
        return part.reshape(*self.shape[:-1], *shape) if len(shape) > 1 else part

    def __setattr__(self, name: str, value: Any) -> None:
        if self._record is None or name not in self._record.offsets:
            object.__setattr__(self, name, value)
            return
        layout, offset = self._place(name)
        shape, values = layout.shapes[name], np.asarray(value)
        rows, size = np.asarray(self), prod(shape)
        if shape and values.shape[max(values.ndim - len(shape), 0) :] == shape:
            values = values.reshape(*values.shape[: values.ndim - len(shape)], size)
        rows[..., offset : offset + size] = values[..., None] if not shape and values.ndim else values
