"""Multivectors on JAX arrays and PyTorch tensors: the same operators, with the derivatives of these packages.

NumPy's types and those of other arrays are never the same, so that the plan of an operation says whose arrays are
meant, and NumPy's are found as fast as if there were no others.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NoReturn, Self

import numpy as np

from ...codegen.algebra.algebra import Kind
from ...codegen.errors import InputError, KindError
from ...codegen.execute.arrays import broadcast_leads
from ...codegen.trace.result_kinds import belongs
from ...common.dtypes import F32, F64, as_precision
from ...common.validation import check_shape
from ...dispatch.arrays.backends import Backend, Node, backend_of
from ...dispatch.arrays.types import ArrayType, array_type, wrap
from ...dispatch.coefficients import embed
from ...dispatch.types import Blade
from ..construction import as_kind, layout_for
from ..linear_maps import blade_in
from ..operators import Operators
from . import functions


class ArrayMultivector(Operators):
    """Multivectors of one kind on a JAX array or a PyTorch tensor, made by ``alg.multivector(array, ...)``.

    Operators and functions are those of `Multivector`; an operand may be one on NumPy arrays. Values may be traced, by
    `jax.jit`, `jax.grad` and others. There are no statuses: an item without an answer is NaN.
    """

    __slots__ = ()

    _type: ArrayType
    _data: Any

    @classmethod
    def _make(cls, kind: Any, data: Any, lead: tuple[int, ...], status: Any = None) -> Self:
        backend: Backend = kind.backend
        own = backend.precision(data)
        new = cls.__new__(cls)
        new._type = kind if own == kind.dtype else kind.in_precision(own)
        new._data = data
        new._lead = lead
        new._pointer = new._status = None
        return new

    # -- contents ------------------------------------------------------------------------------------------

    @property
    def values(self) -> Any:
        """Coefficients (..., k) in the order of `blades`: an array of the package."""
        return self._data

    @property
    def algebra(self) -> Any:
        """The algebra it belongs to."""
        return self._type.algebra

    @property
    def _backend(self) -> Backend:
        """Of which package its array is."""
        backend = self._type.backend
        assert backend is not None
        return backend

    @property
    def status(self) -> NoReturn:
        """There is none.

        Raises
        ------
        InputError
        """
        raise InputError(
            f"multivectors on arrays of {self._backend.name} have no statuses: an item without an answer is NaN.",
            remedy="Take x.numpy(), or a kernel that returns a status",
        )

    def numpy(self) -> Any:
        """A copy on NumPy arrays, a `Multivector`.

        Raises
        ------
        InputError
            While a function is traced.
        """
        numbers = self._backend.numbers(self._data)
        if numbers is None:
            raise InputError("there are no numbers while a function is traced.", remedy="Return the multivector")
        plain = self._type.algebra.type_of(self.kind, self.dtype)
        return self._type.algebra.multivector_class._make(plain, np.array(numbers, order="C"), self._lead)

    def __array__(self, dtype: Any = None, copy: Any = None) -> Any:
        return np.array(self._data, dtype, copy=copy)

    def astype(self, dtype: Any) -> Self:
        """Convert to float64 or float32."""
        precision = as_precision(dtype) or F64
        return self._make(self._type, self._backend.cast(self._data, precision), self._lead)

    def reshape(self, *shape: Any) -> Self:
        """Reshape the batch."""
        lead = np.empty(self._lead, np.uint8).reshape(*shape).shape
        return self._make(self._type, self._data.reshape(*lead, self._type.size), lead)

    def copy(self) -> NoReturn:
        """There is no writing to these arrays.

        Raises
        ------
        InputError
        """
        raise InputError("values of other packages' arrays are not written to.", remedy="Take x.numpy().copy()")

    def __copy__(self) -> Self:
        return self

    def __getitem__(self, key: Any) -> Any:
        if isinstance(key, str | Blade):
            return self._coefficient(key)
        keys = key if isinstance(key, tuple) else (key,)
        ellipsis = () if any(k is Ellipsis for k in keys) else (Ellipsis,)
        data = self._data[(*keys, *ellipsis, slice(None))]
        return self._make(self._type, data, tuple(data.shape[:-1]))

    def _coefficient(self, name: str | Blade) -> Any:
        blade, sign = (int(name), 1) if isinstance(name, int) else self._type.algebra.parse_blade(name)
        column = self._type.columns.get(blade)
        return self._data[..., 0] * 0 if column is None else self._data[..., column] * sign

    def as_kind(self, kind: str | Kind, check: bool = True) -> Self:
        """Convert to another kind of the algebra; `KindError` if an item does not belong to it.

        While a function is traced there are no numbers to check: then blades must suffice, and constraints be proved by
        the kind that it has, or ``check`` be False.
        """
        wanted = as_kind(self._type.algebra, kind)
        if wanted == self.kind:
            return self
        if check:
            numbers = self._backend.numbers(self._data)
            if numbers is not None:
                self.numpy().as_kind(wanted)
            elif not belongs(self.kind, wanted):
                raise KindError(
                    f"a {self.kind.name} of {self._type.algebra.name} may be no {wanted.name}, and while a function is "
                    "traced there are no numbers to check.",
                    remedy="Say that it is one: x.as_kind(kind, check=False)",
                )
        found: Self = wrap(self._type.algebra, wanted, embed(self, wanted), self._backend)
        return found

    # -- functions -----------------------------------------------------------------------------------------

    def exp(self) -> Self:
        """Exponential of bivectors."""
        return functions.exp(self)

    def log(self) -> Self:
        """The bivector whose exponential is this rotor; its angle lies in [0, 2 pi)."""
        return functions.log(self)

    def sqrt(self) -> Self:
        """The rotor of half the motion."""
        return functions.sqrt(self)

    def norm(self) -> Any:
        """sqrt |<x ~x>_0| of each item: an array of the package."""
        return functions.norm(self)

    __abs__ = norm

    def normalized(self) -> Self:
        """Each item at unit scale; a motor, a line or a plane the nearest one."""
        found: Self = functions.normalized(self)
        return found

    normalised = normalized

    def inverse(self) -> Self:
        """The y with x y = 1."""
        found: Self = functions.inverse(self)
        return found

    def __pow__(self, exponent: Any) -> Self:
        """A power: of whole numbers the product, of others exp(exponent log(x))."""
        found: Self = functions.power(self, exponent)
        return found

    def __pos__(self) -> Self:
        return self

    def __truediv__(self, other: Any) -> Self:
        inverse: Any = getattr(other, "inverse", None) if isinstance(other, Operators) else None
        return super().__truediv__(other) if inverse is None else self * inverse()

    def __rtruediv__(self, other: Any) -> Self:
        return self.inverse().__rmul__(other)

    # -- objects -------------------------------------------------------------------------------------------

    def __repr__(self) -> str:
        holder = f"an array of {self._backend.name}"
        return f"<{self.kind.name} of {self._type.algebra.name}, shape {self._lead}, on {holder}>"

    def __reduce__(self) -> NoReturn:
        raise TypeError("multivectors on other packages' arrays are not pickled; take x.numpy().")


def from_any(
    algebra: Any, values: Any, grades: Any, blades: Any, kind: str | Kind | None, basis: str | None
) -> ArrayMultivector | None:
    """Multivectors of ``algebra.multivector(values, ...)``, where an array of a package is among the values; else None.

    Raises
    ------
    InputError
        If a basis is named, or a multivector is of another algebra.
    """
    if isinstance(values, ArrayMultivector):
        if values._type.algebra is not algebra:
            home = values._type.algebra.name
            raise InputError(f"a multivector of {home} on another package's array is not converted.")
        return values
    several = isinstance(values, Mapping)
    found = (backend_of(v) for v in (values.values() if several else (values,)))
    backend = next((b for b in found if b is not None), None)
    if backend is None:
        return None
    if basis is not None:
        raise InputError("basis= is for NumPy arrays.", remedy="Multiply by the matrix of the change of basis")
    if several:
        return _from_columns(algebra, values, backend)
    return _from_rows(algebra, values, grades, blades, kind, backend)


def _from_rows(
    algebra: Any, values: Any, grades: Any, blades: Any, kind: str | Kind | None, backend: Backend
) -> ArrayMultivector:
    layout, signs = layout_for(algebra, grades, blades, kind)
    what = f"the array of values on {layout.name}"
    data = backend.floating(values, what)
    check_shape(data, what, (..., layout.size))
    if signs is not None:
        order = np.array([column for column, _ in signs], np.int64)
        data = backend.take(data, order) * backend.constant(np.array([float(sign) for _, sign in signs]), data)
    made: ArrayMultivector = wrap(algebra, layout, data, backend)
    return made


def _from_columns(algebra: Any, values: Mapping[Any, Any], backend: Backend) -> ArrayMultivector:
    columns: dict[int, Any] = {}
    for key, value in values.items():
        blade, sign = blade_in(algebra, key)
        column = backend.floating(value, f"the coefficient of {key!r}") * sign
        columns[blade] = columns[blade] + column if blade in columns else column
    broadcast_leads([tuple(column.shape) for column in columns.values()], "multivector")
    kind = algebra.layout_of(columns)
    made: ArrayMultivector = wrap(algebra, kind, backend.stack([columns[blade] for blade in kind.blades]), backend)
    return made


# -- as trees of arrays ----------------------------------------------------------------------------------------------


def flatten(x: Any) -> tuple[tuple[Any, ...], Any]:
    """The array of a multivector, and what else it is."""
    return (x.values,), (x.algebra, x.kind)


def unflatten(backend: Backend, kept: tuple[Any, Kind], leaves: Sequence[Any]) -> Any:
    """A multivector on an array; on whatever else a package puts in an array's place."""
    algebra, kind = kept
    (data,) = leaves
    if isinstance(data, np.ndarray) and data.shape[-1:] == (kind.size,) and data.dtype in (F32, F64):
        return algebra.wrap(kind, np.array(data, order="C"))
    made = array_type(algebra, kind, backend.precision(data), backend)
    return ArrayMultivector._make(made, data, tuple(getattr(data, "shape", ()))[:-1])


ArrayType.multivector_class = ArrayMultivector
Backend.nodes.append(Node(ArrayMultivector, flatten, unflatten))
