"""Data of multivectors: a type, an array of coefficients, a shape and statuses. No products.

`MultivectorData` is the base class of what users hold (`core.multivector.Multivector`, which adds operators and
functions). Dispatch and the lower modules of the core see this much of it, and make results by `_make` of an operand.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, NoReturn, Self, TypeAlias, TypeVar

import _cffi_backend
import numpy as np
from numpy.typing import NDArray

from ..codegen.algebra.algebra import Kind
from ..codegen.errors import InputError
from ..common.dtypes import F64, as_precision
from ..common.validation import invalid
from ..status import Status
from .types import Blade, Type, TypedAlgebra

#: Some class of multivectors.
M = TypeVar("M", bound="MultivectorData")

#: The status of one item, or of each item of a batch.
Statuses: TypeAlias = Status | NDArray[np.uint8]

from_buffer = _cffi_backend.FFI().from_buffer


class MultivectorData:
    """A batch of multivectors of one type; coefficients are the last axis of one contiguous array."""

    __slots__ = ("_type", "_data", "_lead", "_pointer", "_status", "_is_open", "_largest", "_deviation")
    __array_ufunc__ = None  # so that ndarray * multivector comes here
    __hash__ = None  # type: ignore[assignment]

    _type: Type
    _data: NDArray[Any]
    _lead: tuple[int, ...]
    _pointer: Any
    _status: NDArray[np.uint8] | None
    _is_open: bool
    _largest: float
    _deviation: NDArray[Any]

    def __init__(self, *_: Any) -> None:
        raise TypeError("multivectors are made by an algebra: alg.multivector({'e1': 1.0}), cga.point(xyz), ...")

    @classmethod
    def _make(
        cls, kind: Type, data: NDArray[Any], lead: tuple[int, ...], status: NDArray[np.uint8] | None = None
    ) -> Self:
        """A multivector on an array that nobody else writes to."""
        new = cls.__new__(cls)
        new._type = kind
        new._data = data if data.flags.c_contiguous else np.ascontiguousarray(data)
        new._lead = lead
        new._pointer = None
        new._status = status
        return new

    def _point(self) -> Any:
        """The buffer's pointer, stored for the next call."""
        self._pointer = pointer = from_buffer(self._data)
        return pointer

    # -- contents ------------------------------------------------------------------------------------------

    @property
    def algebra(self) -> TypedAlgebra:
        """The algebra it belongs to."""
        return self._type.algebra

    @property
    def kind(self) -> Kind:
        """Constraints on the coefficients: a kind, or a layout, which has none."""
        return self._type.kind

    @property
    def values(self) -> NDArray[Any]:
        """Coefficients (..., k) in the order of `blades`: a read-only view, but writable on a `copy`."""
        if self._is_writable:
            return self._data
        return np.asarray(self._data.data.toreadonly())  # a plain view could be made writable again

    @property
    def _is_writable(self) -> bool:
        return getattr(self, "_is_open", False)

    def _largest_coefficient(self) -> float:
        """Largest absolute coefficient of all items, or NaN; cached, since nothing changes them."""
        cached: float | None = getattr(self, "_largest", None)
        if cached is not None:
            return cached
        data = self._data
        largest = max(float(data.max()), -float(data.min())) if data.size else 0.0
        if not self._is_writable:
            self._largest = largest
        return largest

    @property
    def blades(self) -> tuple[Blade, ...]:
        """Blades that have a coefficient; they print as their names."""
        named = self._type.algebra.named_blades
        return tuple(named[blade] for blade in self._type.blades)

    @property
    def grades(self) -> tuple[int, ...]:
        """Grades of the blades."""
        return self._type.grades

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the batch; ``()`` for a single multivector."""
        return self._lead

    @property
    def ndim(self) -> int:
        """Number of dimensions of the batch."""
        return len(self._lead)

    @property
    def size(self) -> int:
        """Number of items."""
        return math.prod(self._lead)

    @property
    def dtype(self) -> np.dtype[Any]:
        """float64 or float32."""
        return self._type.dtype

    @property
    def status(self) -> Statuses:
        """`Status` of each item, from the function that computed it; all OK after an operation."""
        return statuses(self._status, self._lead)

    @property
    def deviation(self) -> NDArray[Any] | None:
        """Distances of the items from what `normalized` with a tolerance was given; None elsewhere."""
        deviation = getattr(self, "_deviation", None)
        return deviation if deviation is None else deviation[()]

    # -- conversion of the array ---------------------------------------------------------------------------

    def astype(self, dtype: Any) -> Self:
        """Convert to float64 or float32."""
        precision = as_precision(dtype) or F64
        if precision == self.dtype:
            return self
        return self._make(self._type.in_precision(precision), self._data.astype(precision), self._lead, self._status)

    def copy(self) -> Self:
        """A copy whose `values` may be written; therefore its kind is the layout of its blades."""
        new = self._make(self._type.unconstrained, self._data.copy(), self._lead, self._status)
        new._is_open = True
        return new

    def reshape(self, *shape: Any) -> Self:
        """Reshape the batch."""
        lead = np.empty(self._lead, np.uint8).reshape(*shape).shape
        status = None if self._status is None else self._status.reshape(lead)
        return self._make(self._type, self._data.reshape(*lead, self._type.size), lead, status)

    # -- items ---------------------------------------------------------------------------------------------

    def __getitem__(self, key: Any) -> Any:
        if isinstance(key, str | Blade):
            return self._coefficient(key)
        keys = key if isinstance(key, tuple) else (key,)
        ellipsis = () if any(k is Ellipsis for k in keys) else (Ellipsis,)
        try:
            data = self._data[(*keys, *ellipsis, slice(None))]
        except IndexError as error:
            fits = sum(k is not None and k is not Ellipsis for k in keys) <= len(self._lead)
            raise IndexError(str(error) if fits else f"{len(keys)} indices for items of shape {self._lead}") from None
        status = None if self._status is None else np.asarray(self._status[key])
        own = data if data.flags.owndata else np.array(data)  # NumPy copies what indices or masks choose
        return self._make(self._type, own, data.shape[:-1], status)

    def _coefficient(self, name: str | Blade) -> NDArray[Any]:
        """Coefficient of one blade, in the sign of the name's order; zero where the layout lacks it."""
        blade, sign = (int(name), 1) if isinstance(name, int) else self._type.algebra.parse_blade(name)
        column = self._type.columns.get(blade)
        if column is None:
            return np.zeros(self._lead, self.dtype)
        return self._data[..., column] * self.dtype.type(sign)  # type: ignore[no-any-return]

    def __len__(self) -> int:
        if not self._lead:
            raise TypeError("a single multivector has no len()")
        return self._lead[0]

    def __iter__(self) -> Iterator[Self]:
        return (self[i] for i in range(len(self)))

    # -- objects -------------------------------------------------------------------------------------------

    def __bool__(self) -> NoReturn:
        raise TypeError("a multivector has no truth value; compare with a.isclose(b), or look at a.values.")

    def __eq__(self, other: object) -> NoReturn:
        raise TypeError("multivectors are compared with a.isclose(b), which takes a tolerance.")

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        """`values`, for functions of arrays; without a copy where the type is right."""
        return np.array(self.values, dtype, copy=copy)

    def __dlpack__(self, **options: Any) -> Any:
        """`values` for other packages, without a copy: read-only, but writable on a `copy`.

        To a package that asks for a version of the protocol without that mark, such as JAX, it is promised, not said.
        """
        return (self.values if options.get("max_version") else self._data).__dlpack__(**options)

    def __dlpack_device__(self) -> tuple[int, int]:
        """The host."""
        kind, number = self.values.__dlpack_device__()
        return int(kind), int(number)

    def __copy__(self) -> Self:
        return self._make(self._type, self._data.copy(), self._lead, self._status)

    def __deepcopy__(self, _: Any) -> Self:
        return self.__copy__()


def check_multivector(x: Any, what: str = "x") -> None:
    """Check that a value is a multivector on NumPy arrays.

    Raises
    ------
    InputError
        If it is not.
    """
    if not isinstance(x, MultivectorData):
        raise invalid(x, what, "a multivector")
    if x._type.backend is not None:
        holder = f"an array of {x._type.backend.name}"
        raise InputError(f"{what} is on {holder}; one of NumPy is needed.", remedy="Take x.numpy()")


def statuses(codes: NDArray[np.uint8] | None, lead: tuple[int, ...]) -> Statuses:
    """A `Status` for one item, an array of codes for a batch."""
    if codes is None:
        codes = np.zeros(lead, np.uint8)
    return Status(int(codes)) if not lead else codes
