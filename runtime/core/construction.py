"""Kinds and arrays of coefficients from what users pass: dictionaries by blade, and arrays on a layout."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from numbers import Integral
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.algebra.algebra import Kind
from ..codegen.errors import BladeError, GradeError, InputError, KindError, ShapeError
from ..common.dtypes import common_precision
from ..common.validation import as_array, as_instance, as_int, as_tuple, real_array
from ..dispatch.types import TypedAlgebra
from .linear_maps import blade_in
from .operators import is_expression

#: Rows whose columns are permuted at a time, so that an interrupt is seen.
ROWS_AT_ONCE = 1 << 17


def from_mapping(algebra: TypedAlgebra, values: Mapping[Any, Any]) -> tuple[Kind, NDArray[Any]]:
    """Arrays by blade, broadcast against each other."""
    columns: dict[int, NDArray[Any]] = {}
    for key, value in values.items():
        blade, sign = blade_in(algebra, key)
        column = real_array(value, f"the coefficient of {key!r}") * sign
        columns[blade] = columns[blade] + column if blade in columns else column
    given = [v for v in values.values() if hasattr(v, "dtype")] or [0.0]
    kind = algebra.layout_of(columns or (0,))
    try:
        lead = np.broadcast_shapes(*(c.shape for c in columns.values()))
    except ValueError:
        shapes = ", ".join(f"{algebra.blade_name(b)} {c.shape}" for b, c in columns.items())
        raise ShapeError(f"the coefficients' shapes do not broadcast: {shapes}.") from None
    data = np.zeros((*lead, kind.size), common_precision(*given))
    for i, blade in enumerate(kind.blades):
        if blade in columns:
            data[..., i] = columns[blade]
    return kind, data


def from_array(
    algebra: TypedAlgebra,
    values: Any,
    grades: Iterable[int] | None,
    blades: Iterable[Any] | None,
    kind: str | Kind | None,
) -> tuple[Kind, NDArray[Any]]:
    """An array (..., k) on grades, blades, a kind's blades, or all of them."""
    layout, signs = layout_for(algebra, grades, blades, kind)
    rows = real_array(values, f"the array of values on {layout.name}", (..., layout.size))
    data = np.array(rows, order="C") if signs is None else _permute_columns(rows, signs)
    return layout, data


def shared_array(
    algebra: TypedAlgebra, values: Any, grades: Iterable[int] | None, blades: Iterable[Any] | None,
    kind: str | Kind | None,
) -> tuple[Kind, NDArray[Any]]:  # fmt: skip
    """The array itself (..., k) on grades, blades, a layout, or all blades.

    Raises
    ------
    InputError, KindError
        If its memory is not as it has to be; if the kind has constraints.
    """
    layout, signs = layout_for(algebra, grades, blades, kind)
    if kind is not None and not as_kind(algebra, kind).is_layout:
        raise KindError(
            f"an array that others may write to is no {layout.name}.", remedy=f'Write kind=alg.layout("{layout.name}")'
        )
    what = f"the array of values on {layout.name}"
    given = as_array(values, what)
    rows = real_array(given, what, (..., layout.size))
    problem = (
        f"its type is {given.dtype}" if rows is not given
        else "it is not contiguous" if not rows.flags.c_contiguous
        else "its columns have names" if signs is not None
        else "it is no array" if isinstance(values, list | tuple | Mapping)
        else ""
    )  # fmt: skip
    if problem:
        remedy = "Leave out copy=False, or give a contiguous array of float64 or float32 in storage order"
        raise InputError(f"{what} cannot be shared: {problem}.", remedy=remedy)
    return layout, rows


def has_expressions(values: Any) -> bool:
    """Test whether a dictionary, or a list, holds SymPy expressions."""
    if isinstance(values, Mapping):
        return any(is_expression(v) for v in values.values())
    if isinstance(values, np.ndarray) and values.dtype != object:
        return False
    return isinstance(values, list | tuple | np.ndarray) and any(is_expression(v) for v in values)


def symbolic(
    algebra: TypedAlgebra, values: Any, grades: Any, blades: Any, kind: Any, basis: str | None, dtype: Any
) -> Any:
    """A symbolic multivector; parameters of `core.multivector.Algebra.multivector`.

    Raises
    ------
    InputError
        If a basis or a precision is asked for, which expressions do not have.
    """
    from .symbolic.multivector import as_polynomial, from_expressions

    if basis is not None or dtype is not None:
        raise InputError("basis= and dtype= are those of numbers; the values are expressions.")
    if isinstance(values, Mapping):
        total: Any = from_expressions(algebra, {})
        for key, value in values.items():
            blade, sign = blade_in(algebra, key)
            total = total + sign * total.new({blade: as_polynomial(value)})
        return total
    layout, signs = layout_for(algebra, grades, blades, kind)
    if len(values) != layout.size:
        raise ShapeError(f"there are {len(values)} expressions; {layout.name} has {layout.size} coefficients.")
    order = signs or [(i, 1) for i in range(layout.size)]
    columns = {blade: (values[i], sign) for blade, (i, sign) in zip(layout.blades, order, strict=True)}
    return from_expressions(algebra, {blade: value if s > 0 else -value for blade, (value, s) in columns.items()})


def as_kind(algebra: TypedAlgebra, kind: Any) -> Kind:
    """Kind of an algebra, or of its name."""
    return algebra.kind(kind) if isinstance(kind, str) else as_instance(kind, "kind", Kind, "a kind or its name")


def layout_for(
    algebra: TypedAlgebra, grades: Iterable[int] | None, blades: Iterable[Any] | None, kind: str | Kind | None
) -> tuple[Kind, list[tuple[int, int]] | None]:
    """Layout of an array's columns; where blades were named, the column and sign of each of its blades."""
    if blades is not None:
        pairs = [blade_in(algebra, key) for key in as_tuple(blades, "blades")]
        layout = algebra.layout_of(blade for blade, _ in pairs)
        if layout.size != len(pairs) or not pairs:
            raise BladeError("the list of blades is empty, or names a blade twice.")
        column = {blade: (i, sign) for i, (blade, sign) in enumerate(pairs)}
        return layout, [column[blade] for blade in layout.blades]
    if grades is not None:
        given = as_tuple(grades, "grades", Integral)
        wanted = sorted({as_int(g, "a grade", 0, algebra.dimension, GradeError) for g in given})
        return algebra.layout_of(blade for g in wanted for blade in algebra.blades_of_grade(g)), None
    if kind is not None:
        return as_kind(algebra, kind).layout, None
    return algebra.layout_of(algebra.blades), None


def _permute_columns(rows: NDArray[Any], signs: Sequence[tuple[int, int]]) -> NDArray[Any]:
    """A copy in the layout's order and signs."""
    if all(pair == (i, 1) for i, pair in enumerate(signs)) and len(signs) == rows.shape[-1]:
        return np.array(rows, order="C")
    columns, factors = [column for column, _ in signs], np.array([sign for _, sign in signs], rows.dtype)
    data = np.empty((*rows.shape[:-1], len(signs)), rows.dtype)
    given, found = rows.reshape(-1, rows.shape[-1]), data.reshape(-1, len(signs))
    for begin in range(0, len(found), ROWS_AT_ONCE):
        block = slice(begin, begin + ROWS_AT_ONCE)
        np.multiply(given[block][:, columns], factors, out=found[block])
    return data
