"""Batches of multivectors of one kind, with the operators of geometric algebra.

Coefficients are the last axis of one contiguous array; leading dimensions broadcast. Products run in compiled
loops that `dispatch` finds; what only moves or flips coefficients is in `linear`; functions with formulas of
their own (norms, inverses, exponentials) are in `functions`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from . import arrays, checks, functions, linear, text
from .dispatch import from_buffer
from .operators import Number, Operators
from .typed import F64, Blade, Type

if TYPE_CHECKING:
    from .algebras import Algebra
    from .codegen.kinds import Kind


class Multivector(Operators):
    """Multivectors of one kind: ``shape`` of them, as rows of coefficients. Made by an algebra, not directly.

    Operators: ``a * b`` geometric, ``a ^ b`` outer, ``a | b`` inner product, ``a & b`` meet (in PGA: join), ``~a``
    reverse, ``R >> x`` sandwich R x ~R, ``a + b``, ``a - b``, ``2 * a``, ``a / 2``, ``a / b``. Numbers and arrays of
    numbers broadcast over items, not over coefficients.
    """

    __slots__ = ("_type", "_data", "_lead", "_pointer", "_status", "_is_open", "_largest")
    __array_ufunc__ = None  # so that ndarray * multivector comes here
    __hash__ = None  # type: ignore[assignment]

    _type: Type
    _data: NDArray[Any]
    _lead: tuple[int, ...]
    _pointer: Any
    _status: NDArray[np.uint8] | None
    _is_open: bool
    _largest: float

    def __init__(self, *_: Any) -> None:
        raise TypeError("multivectors are made by an algebra: alg.multivector({'e1': 1.0}), cga.point(xyz), ...")

    @classmethod
    def _make(
        cls, kind: Type, data: NDArray[Any], lead: tuple[int, ...], status: NDArray[np.uint8] | None = None
    ) -> Multivector:
        """A multivector on an array that nobody else writes to."""
        new = cls.__new__(cls)
        new._type = kind
        new._data = data if data.flags.c_contiguous else np.ascontiguousarray(data)
        new._lead = lead
        new._pointer = None
        new._status = status
        return new

    def _point(self) -> Any:
        """The buffer's pointer, kept for the next call."""
        self._pointer = pointer = from_buffer(self._data)
        return pointer

    # -- what it holds -------------------------------------------------------------------------------------

    @property
    def algebra(self) -> Algebra:
        """The algebra it belongs to."""
        return self._type.algebra

    @property
    def kind(self) -> Kind:
        """What is known of the coefficients: a kind, or a layout."""
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

    def _reach(self) -> float:
        """Largest absolute coefficient of all items, or NaN: looked for once, since nothing changes them."""
        known: float | None = getattr(self, "_largest", None)
        if known is not None:
            return known
        data = self._data
        largest = max(float(data.max()), -float(data.min())) if data.size else 0.0
        if not self._is_writable:
            self._largest = largest
        return largest

    @property
    def blades(self) -> tuple[Blade, ...]:
        """Blades that have a coefficient; they print as their names."""
        named = self.algebra.named_blades
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
    def status(self) -> Any:
        """`Status` of each item, from the function that made it; all OK after an operation."""
        return text.statuses(self._status, self._lead)

    # -- functions -----------------------------------------------------------------------------------------

    def norm(self) -> NDArray[Any]:
        """sqrt |<x ~x>_0| of each item."""
        return functions.norm(self)

    def normalized(self, kind: str | Kind | None = None, strict: bool = False) -> Multivector:
        """Each item at unit scale, of a constrained kind where that holds; see `functions.normalized`."""
        return functions.normalized(self, kind, strict)

    normalised = normalized

    def __pos__(self) -> Multivector:
        return self

    def inverse(self, method: str = "shirokov", strict: bool = False) -> Multivector:
        """The y with x y = 1; `SINGULAR` where there is none. ``method``: "shirokov", "hitzer" or "matrix"."""
        return functions.inverse(self, method, strict)

    def exp(self) -> Multivector:
        """Exponential: a motor from the bivector of a motion, a series for anything else."""
        return functions.exp(self)

    def log(self, strict: bool = False) -> Multivector:
        """The bivector whose exponential is this motor; its angle lies in [0, 2 pi)."""
        return functions.log(self, strict)

    def sqrt(self, strict: bool = False) -> Multivector:
        """The motor of half the motion."""
        return functions.sqrt(self, strict)

    def reflect(self, mirror: Multivector, strict: bool = False) -> Multivector:
        """This object reflected, or inverted, in a blade."""
        return functions.reflect(self, mirror, strict)

    # -- comparison and conversion -------------------------------------------------------------------------

    def isclose(self, other: Multivector | Number, rtol: float | None = None, atol: float = 0.0) -> Any:
        """For each item, whether the coefficients differ by at most ``atol + rtol * largest coefficient``.

        ``rtol`` is 1e-9 by default, 1e-4 in single precision.
        """
        lifted = other if isinstance(other, Multivector) else self.algebra.scalar(other)
        if rtol is None:
            rtol = 1e-9 if self.dtype == lifted.dtype == F64 else 1e-4
        return linear.is_close(self, lifted, rtol, atol)[()]

    def as_kind(self, kind: str | Kind, check: bool = True) -> Multivector:
        """This as a multivector of another kind of the algebra; `KindError` where an item is none.

        ``kind`` is a kind or its name; constraints are checked within `checks.TOLERANCE_ULPS`, unless they are
        proved by the kind that it has.
        """
        return checks.converted(self, self.algebra.kind(kind) if isinstance(kind, str) else kind, check)

    def astype(self, dtype: Any) -> Multivector:
        """The same in float64 or float32."""
        found = arrays.given_precision(dtype) or F64
        if found == self.dtype:
            return self
        return self._make(self._type.in_precision(found), self._data.astype(found), self._lead, self._status)

    def copy(self) -> Multivector:
        """A copy whose `values` may be written; therefore nothing is known of it but its blades."""
        new = self._make(self._type.free, self._data.copy(), self._lead, self._status)
        new._is_open = True
        return new

    def reshape(self, *shape: Any) -> Multivector:
        """The same items in another shape."""
        lead = np.empty(self._lead, np.uint8).reshape(*shape).shape
        status = None if self._status is None else self._status.reshape(lead)
        return self._make(self._type, self._data.reshape(*lead, self._type.size), lead, status)

    def to_basis(self, basis: str = "orthonormal") -> Multivector:
        """This in the algebra of the same signature on orthonormal vectors (in CGA e4 = e+, e5 = e-)."""
        from .interchange import bases

        return bases.to_basis(self, basis)

    def to_clifford(self, layout: Any = None) -> Any:
        """This as a multivector (an array of them, for a batch) of the package `clifford`."""
        from .interchange import clifford

        return clifford.to_clifford(self, layout)

    def parameters(self) -> Any:
        """What the constructor of this kind of object took, as a named tuple; see the algebra's ``parameters``."""
        return self.algebra.parameters(self)

    def to_matrix(self) -> NDArray[Any]:
        """The 4 x 4 matrix of a motor, or of another versor that keeps points points."""
        return self.algebra.matrix(self)

    # -- as formulas see it --------------------------------------------------------------------------------

    @property
    def terms(self) -> dict[int, NDArray[Any]]:
        """Coefficients by blade, as the code generator's multivectors have them: formulas can run on both."""
        return {blade: self._data[..., i] for i, blade in enumerate(self._type.blades)}

    def constant(self, value: float) -> Multivector:
        """A scalar of the same algebra and precision."""
        return self.algebra.scalar(float(value), self.dtype)

    def scaled(self, weight: Callable[[int], float]) -> Multivector:
        """Each blade's coefficient times a number that depends on the blade."""
        weights = np.array([float(weight(blade)) for blade in self._type.blades], self.dtype)
        return self._make(self._type.free, self._data * weights, self._lead)

    # -- items ---------------------------------------------------------------------------------------------

    def __getitem__(self, key: Any) -> Any:
        if isinstance(key, str | Blade):
            return linear.coefficient(self, key)
        keys = key if isinstance(key, tuple) else (key,)
        ellipsis = () if any(k is Ellipsis for k in keys) else (Ellipsis,)
        try:
            data = self._data[(*keys, *ellipsis, slice(None))]
        except IndexError as error:
            fits = sum(k is not None and k is not Ellipsis for k in keys) <= len(self._lead)
            raise IndexError(str(error) if fits else f"{len(keys)} indices for items of shape {self._lead}") from None
        status = None if self._status is None else np.asarray(self._status[key])
        return self._make(self._type, np.array(data), data.shape[:-1], status)

    def __len__(self) -> int:
        if not self._lead:
            raise TypeError("a single multivector has no len()")
        return self._lead[0]

    def __iter__(self) -> Iterator[Multivector]:
        return (self[i] for i in range(len(self)))

    # -- objects -------------------------------------------------------------------------------------------

    def __bool__(self) -> NoReturn:
        raise TypeError("a multivector has no truth value; compare with a.isclose(b), or look at a.values.")

    def __eq__(self, other: object) -> NoReturn:
        raise TypeError("multivectors are compared with a.isclose(b), which takes a tolerance.")

    def __array__(self, *_: Any, **__: Any) -> NoReturn:
        raise TypeError("a multivector is no array; its coefficients are x.values.")

    def __reduce__(self) -> tuple[Any, ...]:
        kind = self.kind
        return _rebuilt, (self.algebra, kind.name, kind.blades, kind.is_layout, self._data, self._status)

    def __copy__(self) -> Multivector:
        return self._make(self._type, self._data.copy(), self._lead, self._status)

    def __deepcopy__(self, _: Any) -> Multivector:
        return self.__copy__()

    def __repr__(self) -> str:
        return text.plain(self)

    def _repr_latex_(self) -> str:
        return text.latex(self)


def _rebuilt(
    algebra: Algebra, name: str, blades: tuple[int, ...], is_layout: bool, data: NDArray[Any], status: Any
) -> Multivector:
    """What pickle calls; the kind is looked up, so that no code travels."""
    kind = algebra.layout_of(blades) if is_layout else algebra.kind(name)
    return Multivector._make(algebra.type_of(kind, data.dtype), data, data.shape[:-1], status)
