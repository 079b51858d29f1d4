"""Types of runtime multivectors, and algebras as the makers of types: one for each kind in each precision.

Types are interned, so that plans are found by identity. The meaning of a type's coefficients is in its `Kind`;
`plans` says what may be done with two types.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import cached_property
from typing import Any, ClassVar, TypeVar

import numpy as np

from ..codegen.algebra import algebra as mathematics
from ..codegen.algebra.algebra import Kind
from ..codegen.algebra.blades import grade
from ..codegen.trace.result_kinds import result_blades
from ..common.dtypes import F32
from .arrays.backends import Backend
from .kernel_entries import KernelSource

T = TypeVar("T")
#: Layouts of at most this many blades are named by them.
NAMED_BLADES = 4


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
    algebra : TypedAlgebra
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

    __slots__ = ("algebra", "kind", "dtype", "single", "blades", "size", "_columns", "_cache")

    #: The package whose arrays hold the coefficients; None: NumPy. See `dispatch.arrays`.
    backend: Backend | None = None

    def __init__(self, algebra: TypedAlgebra, kind: Kind, dtype: np.dtype[Any]) -> None:
        self.algebra = algebra
        self.kind = kind
        self.dtype = dtype
        self.single = int(dtype == F32)
        self.blades = kind.blades
        self.size = kind.size
        self._columns: dict[int, int] | None = None
        self._cache: dict[Any, Any] = {}

    @property
    def columns(self) -> dict[int, int]:
        """Blade to its index on the last axis."""
        if self._columns is None:
            self._columns = {blade: i for i, blade in enumerate(self.blades)}
        return self._columns

    @property
    def grades(self) -> tuple[int, ...]:
        """Grades of the blades, ascending."""
        return self.memoize("grades", lambda: tuple(sorted({grade(blade) for blade in self.blades})))

    @property
    def unconstrained(self) -> Type:
        """The type of the layout: the same blades, no constraints."""
        return self.memoize("unconstrained", lambda: self.of_kind(self.kind.layout))

    def of_kind(self, kind: Kind) -> Type:
        """The type of another kind, in the same precision."""
        return self.algebra.type_of(kind, self.dtype)

    def in_precision(self, dtype: np.dtype[Any]) -> Type:
        """The type of the same kind in another precision."""
        return self.algebra.type_of(self.kind, dtype)

    def memoize(self, key: Any, compute: Callable[[], T]) -> T:
        """A value that depends on the type alone, computed once."""
        try:
            return self._cache[key]  # type: ignore[no-any-return]
        except KeyError:
            value = self._cache[key] = compute()
            return value

    def __repr__(self) -> str:
        return f"<type {self.kind!r}, {self.dtype}>"


class TypedAlgebra(mathematics.Algebra):
    """An algebra that interns the layouts and types of its multivectors, and knows their kernels.

    Attributes
    ----------
    multivector_class : type
        Class of the results of products and formulas.
    stock : KernelSource, optional
        Kernels that were generated for this algebra.
    targets : dict
        Functions that evaluate formulas, by formula and kinds of operands; see `formulas.resolve_kernel`.
    item_plans : dict
        The same for single items, by formula, types and shapes; see `formulas.evaluate_item`.
    """

    multivector_class: ClassVar[type[Any]]
    stock: KernelSource | None

    def __init__(
        self,
        name: str,
        vectors: Sequence[str],
        metric: Sequence[Sequence[int | Fraction]],
        pseudoscalar: str | None = None,
    ) -> None:
        self.stock = None
        self.targets: dict[Any, Any] = {}
        self.item_plans: dict[Any, Any] = {}
        self._types: dict[tuple[Kind, Any], Type] = {}
        self._layouts: dict[tuple[int, ...], Kind] = {}
        self._names: dict[str, tuple[int, int]] = {}
        super().__init__(name, vectors, metric, pseudoscalar)

    @cached_property
    def blades(self) -> tuple[Blade, ...]:
        """All basis blades in storage order."""
        self.check_listed()
        order = (b for g in range(self.dimension + 1) for b in self.blades_of_grade(g))
        return tuple(self.named_blades[blade] for blade in order)

    @cached_property
    def named_blades(self) -> Mapping[int, Blade]:
        """Blade of each bit mask, created on demand."""
        return _NamedBlades(self)

    @cached_property
    def scalar_layout(self) -> Kind:
        """The layout of scalars."""
        return self.layout_of((0,))

    def layout_of(self, blades: Iterable[int]) -> Kind:
        """The layout of these blades: a kind's, if one has exactly them."""
        ordered = self.order(int(blade) for blade in blades)
        layout = self._layouts.get(ordered)
        if layout is None:
            layout = self._layouts[ordered] = self._find_layout(ordered)
        return layout

    def _find_layout(self, blades: tuple[int, ...]) -> Kind:
        fitting = [kind for kind in self.kinds.values() if kind.blades == blades]
        if fitting:
            return min(fitting, key=lambda kind: bool(kind.constraints)).layout
        few = "_".join(self.blade_name(blade) for blade in blades[:NAMED_BLADES])
        return Kind(self, few if len(blades) <= NAMED_BLADES else f"blades{len(blades)}", blades)

    def type_of(self, kind: Kind, dtype: np.dtype[Any]) -> Type:
        """The one type of a kind and a precision."""
        key = kind, dtype
        interned = self._types.get(key)
        if interned is None:
            local = kind if kind.algebra is self else replace(kind, algebra=self)
            local = self.layout_of(local.blades) if local.is_layout else local  # equal layouts may have several names
            interned = self._types[key] = Type(self, local, dtype)
        return interned

    def result_kind(self, formula: Callable[..., Any], kinds: Sequence[Kind]) -> Kind:
        """The narrowest kind that a formula's value provably belongs to, else the layout of its blades.

        The formula may use sums and products only. A proof costs some milliseconds.
        """
        kind, blades = result_blades(self, formula, kinds)
        return kind or self.layout_of(blades)

    def parse_blade(self, name: str | Sequence[int | str]) -> tuple[int, int]:  # labels are words too
        """Blade and sign of a name in any order of vectors; cached."""
        if not isinstance(name, str):
            return super().parse_blade(name)  # type: ignore[arg-type]
        parsed = self._names.get(name)
        if parsed is None:
            parsed = self._names[name] = super().parse_blade(name)
        return parsed


class _NamedBlades(dict[int, Blade]):
    def __init__(self, algebra: TypedAlgebra) -> None:
        super().__init__()
        self.algebra = algebra

    def __missing__(self, blade: int) -> Blade:
        self[blade] = named = Blade(blade, self.algebra.blade_name(blade))
        return named
