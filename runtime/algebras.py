"""Algebras as users hold them: what makes multivectors, knows their types and finds their kernels.

The mathematics is the code generator's `Algebra`; this adds arrays. Where algebras come from is in `loading`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import arrays
from .codegen import algebra as mathematics
from .codegen.catalogue import algebra_from_data, data_from_algebra
from .codegen.errors import BladeError, GradeError, ShapeError
from .codegen.kinds import Kind
from .linear import blade_in
from .multivector import Multivector
from .stock import StockKernels
from .typed import Blade, Type


class Algebra(mathematics.Algebra):
    """A geometric algebra whose multivectors hold numbers. Made by `algebra`, or one of the stock ones.

    Basis blades are attributes: ``alg.e12``, ``cga.ni``.

    Attributes
    ----------
    blades : tuple of Blade
        All basis blades in storage order: by grade, then by index. They are bit masks that print as names.
    kinds : dict of str to Kind
    signature : (p, q, r)
    """

    def __init__(
        self,
        name: str,
        vectors: Sequence[str],
        metric: Sequence[Sequence[int | Fraction]],
        pseudoscalar: str | None = None,
    ) -> None:
        self.stock: StockKernels | None = None
        self.targets: dict[Any, Any] = {}
        self._types: dict[tuple[Kind, Any], Type] = {}
        self._layouts: dict[tuple[int, ...], Kind] = {}
        self._names: dict[str, tuple[int, int]] = {}
        self._origin: tuple[Callable[..., Algebra], tuple[Any, ...]] | None = None
        super().__init__(name, vectors, metric, pseudoscalar)

    def remember(self, maker: Callable[..., Algebra], *arguments: Any) -> None:
        """Pickle this algebra as a call that gives it back."""
        self._origin = maker, arguments

    @classmethod
    def from_data(cls, data: Mapping[str, Any]) -> Algebra:
        """An algebra with its kinds from plain data, as in a spec or a manifest."""
        plain = algebra_from_data(data)
        new = cls(plain.name, plain.vectors, plain.metric, plain.pseudoscalar_name)
        new.kinds.update({name: replace(kind, algebra=new) for name, kind in plain.kinds.items()})
        return new

    # -- blades, kinds and types ---------------------------------------------------------------------------

    @cached_property
    def blades(self) -> tuple[Blade, ...]:
        """All basis blades in storage order."""
        order = (b for g in range(self.dimension + 1) for b in self.blades_of_grade(g))
        return tuple(self.named_blades[blade] for blade in order)

    @cached_property
    def named_blades(self) -> Mapping[int, Blade]:
        """Blade of each bit mask, made when asked for."""
        return _NamedBlades(self)

    def layout_of(self, blades: Iterable[int]) -> Kind:
        """The layout of these blades: a kind's, if one has exactly them."""
        ordered = self.order(int(blade) for blade in blades)
        known = self._layouts.get(ordered)
        if known is None:
            known = self._layouts[ordered] = self._find_layout(ordered)
        return known

    def _find_layout(self, blades: tuple[int, ...]) -> Kind:
        fitting = [kind for kind in self.kinds.values() if kind.blades == blades]
        if fitting:
            return min(fitting, key=lambda kind: bool(kind.constraints)).layout
        few = "_".join(self.blade_name(blade) for blade in blades[:NAMED_BLADES])
        return Kind(self, few if len(blades) <= NAMED_BLADES else f"blades{len(blades)}", blades)

    def type_of(self, kind: Kind, dtype: np.dtype[Any]) -> Type:
        """The one type of a kind and a precision."""
        key = kind, dtype
        known = self._types.get(key)
        if known is None:
            own = kind if kind.algebra is self else replace(kind, algebra=self)
            own = self.layout_of(own.blades) if own.is_layout else own  # equal layouts may have several names
            known = self._types[key] = Type(self, own, dtype)
        return known

    def parse_blade(self, name: str | Sequence[int | str]) -> tuple[int, int]:  # labels are words too
        """Blade and sign of a name in any order of vectors; remembered."""
        if not isinstance(name, str):
            return super().parse_blade(name)  # type: ignore[arg-type]
        known = self._names.get(name)
        if known is None:
            known = self._names[name] = super().parse_blade(name)
        return known

    # -- multivectors --------------------------------------------------------------------------------------

    def multivector(
        self,
        values: Any,
        grades: Iterable[int] | None = None,
        *,
        blades: Iterable[Any] | None = None,
        kind: str | Kind | None = None,
        basis: str | None = None,
        dtype: Any = None,
    ) -> Multivector:
        """Multivectors from coefficients.

        Parameters
        ----------
        values : dict, array of shape (..., k), or Multivector
            A dictionary gives arrays by blade: a name in any order of vectors (``"e21"`` is ``-e12``), a tuple
            (``(1, 12)``) or a `Blade`; the arrays broadcast. An array holds k coefficients per item: of the blades
            of ``grades``, of ``blades``, of ``kind``, or of all blades of the algebra, in storage order. A
            multivector of an algebra of the same signature is converted.
        grades : iterable of int, optional
        blades : iterable of str, tuple or Blade, optional
        kind : str or Kind, optional
            Kind of the result; its constraints are checked.
        basis : "orthonormal", optional
            The names, or the order of the values, are those of orthonormal vectors (in CGA e4 = e+, e5 = e-).
        dtype : float64 or float32, optional

        Raises
        ------
        BladeError, KindError, ShapeError, InputError
            For unknown blades, items that are not of the kind, shapes that do not fit, values that are no numbers.
        """
        from .interchange import bases

        precision = arrays.given_precision(dtype)
        if isinstance(values, Multivector):
            made = values if values.algebra is self else bases.from_algebra(self, values)
        elif basis is not None:
            other = bases.orthonormal_algebra(self, basis)
            made = other.multivector(values, grades, blades=blades)
            made = made if other is self else bases.from_algebra(self, made)
        elif isinstance(values, Mapping):
            made = self._from_mapping(values)
        else:
            made = self._from_array(values, grades, blades, kind)
        made = made if precision is None else made.astype(precision)
        return made if kind is None else made.as_kind(kind)

    def _from_mapping(self, values: Mapping[Any, Any]) -> Multivector:
        columns: dict[int, NDArray[Any]] = {}
        for key, value in values.items():
            blade, sign = blade_in(self, key)
            column = arrays.real(value, f"the coefficient of {key!r}") * sign
            columns[blade] = columns[blade] + column if blade in columns else column
        given = [v for v in values.values() if hasattr(v, "dtype")] or [0.0]
        kind = self.layout_of(columns or (0,))
        try:
            lead = np.broadcast_shapes(*(c.shape for c in columns.values()))
        except ValueError:
            shapes = ", ".join(f"{self.blade_name(b)} {c.shape}" for b, c in columns.items())
            raise ShapeError(f"the coefficients' shapes do not broadcast: {shapes}.") from None
        data = np.zeros((*lead, kind.size), arrays.precision(*given))
        for i, blade in enumerate(kind.blades):
            if blade in columns:
                data[..., i] = columns[blade]
        return Multivector._make(self.type_of(kind, data.dtype), data, lead)

    def _from_array(
        self, values: Any, grades: Iterable[int] | None, blades: Iterable[Any] | None, kind: str | Kind | None
    ) -> Multivector:
        layout, signs = self._layout_for(grades, blades, kind)
        rows = arrays.rows(values, layout.size, f"the array of values on {layout.name}")
        data = np.array(rows, order="C") if signs is None else _permuted(rows, signs)
        return Multivector._make(self.type_of(layout, data.dtype), data, data.shape[:-1])

    def _layout_for(
        self, grades: Iterable[int] | None, blades: Iterable[Any] | None, kind: str | Kind | None
    ) -> tuple[Kind, list[tuple[int, int]] | None]:
        """Layout of an array's columns; where blades were named, the column and sign of each of its blades."""
        if blades is not None:
            pairs = [blade_in(self, key) for key in blades]
            layout = self.layout_of(blade for blade, _ in pairs)
            if layout.size != len(pairs) or not pairs:
                raise BladeError("the list of blades is empty, or names a blade twice.")
            column = {blade: (i, sign) for i, (blade, sign) in enumerate(pairs)}
            return layout, [column[blade] for blade in layout.blades]
        if grades is not None:
            given = grades if isinstance(grades, Iterable) else (grades,)
            wanted = sorted({_grade(g, self.dimension) for g in given})
            return self.layout_of(blade for g in wanted for blade in self.blades_of_grade(g)), None
        if kind is not None:
            return (self.layout(kind) if isinstance(kind, str) else kind.layout), None
        return self.layout_of(self.blades), None

    def scalar(self, value: Any, dtype: Any = None) -> Multivector:
        """Scalars from an array of numbers."""
        data = arrays.real(value, "the scalar")
        data = np.array(data, dtype=arrays.given_precision(dtype) or data.dtype)[..., None]
        return Multivector._make(self.type_of(self.layout_of((0,)), data.dtype), data, data.shape[:-1])

    def wrap(self, kind: Kind, values: NDArray[Any], status: NDArray[np.uint8] | None = None) -> Multivector:
        """Results of a compiled kernel as multivectors; the array is taken over, not copied."""
        return Multivector._make(self.type_of(kind, values.dtype), values, values.shape[:-1], status)

    def symbols(self, name: str = "x", kind: str | Kind | None = None, grades: Iterable[int] | None = None) -> Any:
        """A symbolic multivector whose coefficients are SymPy symbols ``x_e12``, for formulas in GA notation."""
        import sympy

        from .codegen.multivector import from_values
        from .codegen.symbolic import SymbolicRing

        name = mathematics.validated_identifier(name, "a symbol's name")
        found = self.kind(kind) if isinstance(kind, str) else kind or self._layout_for(grades, None, None)[0]
        symbols = [sympy.Symbol(f"{name}_{self.blade_name(b)}" if b else name, real=True) for b in found.blades]
        return from_values(self, SymbolicRing(), found.blades, symbols)

    # -- geometry, where the algebra has one ---------------------------------------------------------------

    def parameters(self, x: Multivector) -> Any:
        """Parameters of a geometric object.

        Raises
        ------
        GradeError
            If the algebra stands for no geometry.
        """
        raise GradeError(f"{self.name} has no geometric objects; they are those of cga3d and pga3d.")

    def matrix(self, x: Multivector) -> NDArray[Any]:
        """Matrix of a versor's action on points.

        Raises
        ------
        GradeError
            If the algebra stands for no geometry.
        """
        raise GradeError(f"{self.name} has no points to act on; they are those of cga3d and pga3d.")

    # -- objects -------------------------------------------------------------------------------------------

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_") or name == "vectors":
            raise AttributeError(name)
        try:
            blade, sign = self.parse_blade(name)
        except BladeError as error:
            raise AttributeError(f"{self.name} has no {name!r}, and it is no blade: {error}") from None
        return self.multivector({self.named_blades[blade]: float(sign)})

    def __reduce__(self) -> tuple[Any, ...]:
        from .loading import KNOWN, from_hashable, hashable

        if self._origin:
            return self._origin
        key = hashable(data_from_algebra(self))
        KNOWN.setdefault(key, self)
        return from_hashable, (key,)


#: Layouts of at most this many blades are named by them.
NAMED_BLADES = 4


class _NamedBlades(dict[int, Blade]):
    def __init__(self, algebra: Algebra) -> None:
        super().__init__()
        self.algebra = algebra

    def __missing__(self, blade: int) -> Blade:
        self[blade] = named = Blade(blade, self.algebra.blade_name(blade))
        return named


def _permuted(rows: NDArray[Any], signs: Sequence[tuple[int, int]]) -> NDArray[Any]:
    columns = [column for column, _ in signs]
    data: NDArray[Any] = np.ascontiguousarray(rows[..., columns])
    data *= np.array([sign for _, sign in signs], rows.dtype)
    return data


def _grade(value: Any, dimension: int) -> int:
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or not 0 <= value <= dimension:
        raise GradeError(f"{value!r} is no grade; grades are whole numbers from 0 to {dimension}.")
    return int(value)
