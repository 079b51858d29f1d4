"""Types of values in algorithms: numbers, arrays of them, and values that are known when the text is printed."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from math import prod
from typing import Any

from ...errors import AlgorithmError


@dataclass(frozen=True)
class Scalar:
    """A number: ``Real`` in the target's precision, ``Int`` of 64 bits, or ``Bool``."""

    name: str

    def __repr__(self) -> str:
        return self.name


REAL, INT, BOOL = Scalar("Real"), Scalar("Int"), Scalar("Bool")


@dataclass(frozen=True)
class ArrayType:
    """Numbers in row-major order.

    Parameters
    ----------
    scalar : Scalar
        Of each: `REAL` or `INT`.
    shape : tuple of int or None, or None
        None as the first length: known at run time. None in place of the shape: the caller's, for each call anew.
    axes : int
        Of an array without a shape.
    bits : int
        In which an integer is stored, of a parameter: 64 or 32 with a sign, 8 without.
    record : Record, optional
        The layout of its rows: names for parts of them. Types are compared without it.
    """

    scalar: Scalar
    shape: tuple[int | None, ...] | None
    axes: int = 0
    bits: int = 64
    record: Any = field(default=None, compare=False, repr=False)

    @property
    def is_generic(self) -> bool:
        return self.shape is None

    @property
    def storage(self) -> str:
        """Name of the type of its numbers where they are stored: "Real", "Int", or an integer of fewer bits."""
        return str(self.scalar) if self.bits == 64 else f"Int{self.bits}"

    @property
    def is_open(self) -> bool:
        """Whether the number of rows is known at run time only."""
        return bool(self.shape) and self.sizes[0] is None

    @property
    def sizes(self) -> tuple[int | None, ...]:
        """The lengths of an array that has them."""
        assert self.shape is not None
        return self.shape

    def stride(self, axis: int) -> int:
        """Numbers from one index of an axis to the next."""
        return prod(n for n in self.sizes[axis + 1 :] if n is not None)

    @property
    def size(self) -> int:
        """Numbers in all; of an open array, in one row."""
        return prod(n for n in self.sizes if n is not None)

    def row(self, count: int = 1) -> ArrayType:
        """What is left behind some leading indices."""
        return replace(self, shape=self.sizes[count:])

    def __repr__(self) -> str:
        if self.shape is None:
            return f"{self.scalar} array of {self.axes} axes"
        return f"{self.scalar} array of shape ({', '.join('n' if n is None else str(n) for n in self.shape)})"


@dataclass(frozen=True)
class StaticType:
    """A parameter whose value is known when the text is printed."""

    def __repr__(self) -> str:
        return "Static"


Type = Scalar | ArrayType | StaticType


@dataclass(frozen=True)
class Parameter:
    """A declared parameter.

    Parameters
    ----------
    name : str
    type : Type
    access : {"in", "inout", "out"}
        Arrays of the first are read, those of the last written.
    """

    name: str
    type: Type
    access: str = "in"


class Annotation:
    """What a parameter's annotation evaluates to: `Real`, `Vector[3]`, `Out[Matrix[4, 4]]` and so on.

    Subscripted annotations are checked when the algorithm is declared.
    """

    def __init__(self, type: Type, access: str = "in") -> None:
        self.type, self.access = type, access


class ArrayAnnotation(Annotation):
    """``Vector``: of any length; ``Vector[3]``: of this one."""

    def __init__(self, scalar: Scalar, axes: int, is_open: bool = False) -> None:
        super().__init__(ArrayType(scalar, None, axes))
        self.scalar, self.axes, self.has_open_rows = scalar, axes, is_open

    def __getitem__(self, lengths: Any) -> Annotation:
        if self.has_open_rows and isinstance(lengths, Annotation) and getattr(lengths.type, "record", None):
            row = lengths.type
            assert isinstance(row, ArrayType)
            return Annotation(replace(row, shape=(None, *row.sizes)))
        shape = lengths if isinstance(lengths, tuple) else (lengths,)
        if len(shape) != self.axes or not all(isinstance(n, int) and not isinstance(n, bool) and n > 0 for n in shape):
            raise AlgorithmError(
                f"an array of {self.axes} axes takes {self.axes} positive lengths, not {lengths!r}",
                remedy="Write for example Vector[3] or Matrix[4, 4].",
            )
        return Annotation(ArrayType(self.scalar, (None, *shape) if self.has_open_rows else shape))


class AccessAnnotation:
    """``Out[...]`` and ``InOut[...]``."""

    def __init__(self, access: str) -> None:
        self.access = access

    def __getitem__(self, item: Any) -> Annotation:
        if not isinstance(item, Annotation) or not isinstance(item.type, ArrayType) or item.access != "in":
            raise AlgorithmError("Out and InOut are of arrays", remedy="Write for example Out[Vector[3]].")
        return Annotation(item.type, self.access)
