"""Linear operations that need no compiled kernel: signs, grades, sums and changes of layout, in NumPy."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.algebra.blades import grade
from ..codegen.errors import AlgebraMismatchError, BladeError, GradeError, InputError, ShapeError, suggest
from ..codegen.execute.result_memory import MANY, STORE
from ..common.dtypes import F32, F64
from ..common.validation import as_int, real_array
from ..dispatch.arrays.backends import Backend, backend_of
from ..dispatch.arrays.types import array_type, common_backend, rows_on, wrap
from ..dispatch.coefficients import broadcast
from ..dispatch.multivector_data import M, MultivectorData
from ..dispatch.product_tables import LINEAR, linear_map
from ..dispatch.types import Blade, Type, TypedAlgebra

Columns = NDArray[np.int64]
#: Above this many coefficients the kind of a mapped result is not looked for.
MAX_PROVED = 64


def apply_linear_map(x: M, name: str) -> M:
    """A linear map of `product_tables.LINEAR` on every item."""
    out, apply = x._type.memoize(name, lambda: _map(x._type, name))
    return x._make(out, apply(x._data), x._lead)


def _map(source: Type, name: str) -> tuple[Type, Callable[[NDArray[Any]], NDArray[Any]]]:
    """Result type and function on rows."""
    algebra = source.algebra
    images, places, weights = linear_map(algebra, name, source.blades)
    blades = algebra.order(images.tolist()) or (0,)
    kind = algebra.layout_of(blades)
    if not source.kind.is_layout and source.size <= MAX_PROVED:
        proved = algebra.result_kind(LINEAR[name], (source.kind,))
        kind = proved if proved.blades == blades else kind
    out, backend = source.of_kind(kind), source.backend
    if len(images) == len(blades) == len(set(places.tolist())):  # one source each: signs and a permutation
        column = {image: i for i, image in enumerate(images.tolist())}
        order = [column[blade] for blade in blades]
        index, scale = places[order], weights[order].astype(source.dtype)
        if backend is not None:
            return out, lambda data: backend.take(data, index) * backend.constant(scale, data)
        if np.array_equal(index, np.arange(source.size)):
            return out, lambda data: data * scale if data.size < MANY else _many_scaled(data, scale)
        return out, lambda data: data[..., index] * scale
    matrix = np.zeros((source.size, len(blades)), source.dtype)
    matrix[places, [out.columns[image] for image in images.tolist()]] = weights
    if backend is not None:
        return out, lambda data: data @ backend.constant(matrix, data)
    return out, lambda data: data @ matrix


def _many_scaled(data: NDArray[Any], scale: NDArray[Any]) -> NDArray[Any]:
    """Many rows times a row, on the memory of earlier results."""
    return np.asarray(np.multiply(data, scale, out=STORE.empty(data.shape, data.dtype)))


def select_grades(x: M, grades: Sequence[int]) -> M:
    """The part of these grades."""
    for g in grades:
        as_int(g, "a grade", 0, x.algebra.dimension, GradeError)
    key = ("grade", *grades)
    out, index = x._type.memoize(key, lambda: _selection(x._type, set(grades)))
    if index is None:
        return x
    if x._type.backend is not None:
        return x._make(out, x._type.backend.take(x._data, index if len(index) else np.array([-1])), x._lead)
    data = x._data[..., index] if len(index) else np.zeros((*x._lead, 1), out.dtype)
    return x._make(out, data, x._lead)


def _selection(source: Type, grades: set[int]) -> tuple[Type, Columns | None]:
    index = [i for i, blade in enumerate(source.blades) if grade(blade) in grades]
    if len(index) == source.size:
        return source, None
    kind = source.algebra.layout_of([source.blades[i] for i in index] or [0])
    return source.of_kind(kind), np.array(index, np.int64)


def add(a: M, b: M, sign: int) -> M:
    """a + sign b; nothing is known of the sum."""
    if a._type.unconstrained is b._type.unconstrained:
        if a._lead != b._lead:
            broadcast(a, b)  # for its message
        data = a._data + b._data if sign > 0 else a._data - b._data
        return a._make(a._type.unconstrained, data, data.shape[:-1])
    out, place_a, place_b = _union(a._type, b._type)
    lead = a._lead if a._lead == b._lead else broadcast(a, b)
    if out.backend is not None:
        left, right = (rows_on(x, out.kind, out.backend) for x in (a, b))
        found: M = wrap(a.algebra, out.kind, left + right if sign > 0 else left - right, out.backend)
        return found
    data = np.zeros((*lead, out.size), out.dtype)
    data[..., place_a] = a._data
    if sign > 0:
        data[..., place_b] += b._data
    else:
        data[..., place_b] -= b._data
    return a._make(out, data, lead)


def _union(a: Type, b: Type) -> tuple[Type, Any, Any]:
    return a.memoize(("union", b), lambda: _make_union(a, b))


def _make_union(a: Type, b: Type) -> tuple[Type, Any, Any]:
    if a.algebra is not b.algebra:
        raise AlgebraMismatchError(
            f"the operands belong to different algebras, {a.algebra.name} and {b.algebra.name}.",
            remedy=f"Convert one first: {a.algebra.name}.multivector(x), where both have the same signature",
        )
    dtype = F32 if a.single and b.single else F64
    out = a.algebra.type_of(a.algebra.layout_of({*a.blades, *b.blades}), dtype)
    backend = common_backend(a, b)
    if backend is not None:
        return array_type(a.algebra, out.kind, dtype, backend), None, None
    return out, _column_indices(a, out), _column_indices(b, out)


def _column_indices(source: Type, target: Type) -> Any:
    """Index of the source's columns in the target: a slice where they are neighbours."""
    index = [target.columns[blade] for blade in source.blades]
    if index == list(range(index[0], index[0] + len(index))):
        return slice(index[0], index[0] + len(index))
    return np.array(index, np.int64)


def scale(x: M, value: Any, divide: bool = False) -> M:
    """Items times (or divided by) numbers that broadcast with them; nothing is known of the result.

    Raises
    ------
    InputError, ShapeError
        If they are no real numbers, or too large for one; if the shapes do not broadcast.
    """
    if isinstance(value, float | int | Fraction):
        try:
            value = float(value)
        except OverflowError:
            raise InputError("the factor is too large for a floating-point number.") from None
        if not divide:
            return x._make(x._type.unconstrained, x._data * value, x._lead)
    backend = x._type.backend or (None if type(value) is np.ndarray else backend_of(value))
    if backend is not None:
        return _scale_on_arrays(x, value, divide, backend)
    factor = real_array(value, "the factor")
    dtype = x.dtype if factor.dtype == x.dtype or factor.ndim == 0 else F64
    data = x._data if x.dtype == dtype else x._data.astype(dtype)
    number = factor.astype(dtype)[..., None]
    try:
        with np.errstate(all="ignore"):
            data = data / number if divide else data * number
    except ValueError:
        shapes = f"{x._lead} and {factor.shape}"
        raise ShapeError(f"shapes {shapes} do not broadcast; insert axes with a[:, None].") from None
    return x._make(x._type.unconstrained.in_precision(dtype), data, data.shape[:-1])


def _scale_on_arrays(x: M, value: Any, divide: bool, backend: Backend) -> M:
    data = rows_on(x, x.kind, backend)
    if not isinstance(value, float):
        factor = backend.floating(value, "the factor")
        try:
            np.broadcast_shapes(x._lead, tuple(factor.shape))
        except ValueError:
            what = f"shapes {x._lead} and {tuple(factor.shape)} do not broadcast; insert axes with a[:, None]."
            raise ShapeError(what) from None
        value = factor[..., None] if factor.ndim else backend.cast(factor, backend.precision(data))
    found: M = wrap(x.algebra, x.kind.layout, data / value if divide else data * value, backend)
    return found


def is_close(a: MultivectorData, b: MultivectorData, rtol: float, atol: float) -> NDArray[np.bool_]:
    """Test whether the difference's largest coefficient is at most atol + rtol times the operands' largest."""
    difference = add(a, b, -1)
    with np.errstate(all="ignore"):
        size = np.maximum(np.abs(a._data).max(-1), np.abs(b._data).max(-1))
        return np.asarray(np.abs(difference._data).max(-1) <= atol + rtol * size)


def blade_in(algebra: TypedAlgebra, key: Any) -> tuple[int, int]:
    """Blade and sign of a key of a dictionary of coefficients: a name, a tuple of labels, or a `Blade`.

    Raises
    ------
    BladeError
        If it is not one of these.
    """
    if isinstance(key, Blade):
        if key >> algebra.dimension:
            raise BladeError(f"{key!r} is not a blade of {algebra.name}.")
        return int(key), 1
    if isinstance(key, str):
        return algebra.parse_blade(key)
    if isinstance(key, tuple):
        return algebra.parse_blade([str(label) for label in key])
    hint = suggest(f"e{key}", algebra.vectors)
    raise BladeError(f"{key!r} is not a blade{hint}; write 'e12' or (1, 2).")
