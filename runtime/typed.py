"""Types of runtime multivectors: one object for each kind of an algebra in each precision.

Types are interned, so that dispatch compares identities. What a type's coefficients mean lives in its `Kind`;
what may be done with two types lives in `dispatch`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from .codegen.algebra import grade
from .codegen.kinds import Kind

if TYPE_CHECKING:
    from .algebras import Algebra

F64, F32 = np.dtype(np.float64), np.dtype(np.float32)


class Blade(int):
    """A basis blade: the bit mask of its vectors, which prints as its name, for example ``e12``."""

    name: str

    def __new__(cls, mask: int, name: str) -> Blade:
        blade = super().__new__(cls, mask)
        blade.name = name
        return blade

    @property
    def grade(self) -> int:
        """Number of vectors."""
        return grade(self)

    def __repr__(self) -> str:
        return self.name

    __str__ = __repr__

    def __format__(self, spec: str) -> str:
        return format(self.name, spec)

    def __reduce__(self) -> tuple[Any, ...]:
        return Blade, (int(self), self.name)


class Type:
    """One kind in one precision.

    Attributes
    ----------
    algebra : Algebra
    kind : Kind
        A kind, or a layout: the same blades with nothing known.
    dtype : numpy.dtype
        float64 or float32.
    single : int
        1 for float32, else 0.
    blades : tuple of int
        Bit masks in storage order.
    size : int
        Number of coefficients.
    """

    __slots__ = ("algebra", "kind", "dtype", "single", "blades", "size", "_columns", "_unary")

    def __init__(self, algebra: Algebra, kind: Kind, dtype: np.dtype[Any]) -> None:
        self.algebra = algebra
        self.kind = kind
        self.dtype = dtype
        self.single = int(dtype == F32)
        self.blades = kind.blades
        self.size = kind.size
        self._columns: dict[int, int] | None = None
        self._unary: dict[Any, Any] = {}

    @property
    def columns(self) -> dict[int, int]:
        """Blade to its place on the last axis."""
        if self._columns is None:
            self._columns = {blade: i for i, blade in enumerate(self.blades)}
        return self._columns

    @property
    def grades(self) -> tuple[int, ...]:
        """Grades of the blades, ascending."""
        return tuple(sorted({grade(blade) for blade in self.blades}))

    @property
    def free(self) -> Type:
        """The layout: the same blades with nothing known."""
        found: Type = self.remembered("free", lambda: self.algebra.type_of(self.kind.layout, self.dtype))
        return found

    def in_precision(self, dtype: np.dtype[Any]) -> Type:
        """The same kind in another precision."""
        return self.algebra.type_of(self.kind, dtype)

    def remembered(self, key: Any, make: Any) -> Any:
        """A value that depends on the type alone, made once."""
        try:
            return self._unary[key]
        except KeyError:
            value = self._unary[key] = make()
            return value

    def __repr__(self) -> str:
        return f"<type {self.kind!r}, {self.dtype}>"
