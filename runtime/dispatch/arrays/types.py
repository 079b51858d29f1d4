"""Types of multivectors on other packages' arrays: of the same kinds as NumPy's, and never the same type."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np

from ...codegen.algebra.algebra import Kind
from ...codegen.errors import InputError
from ..coefficients import embed
from ..multivector_data import MultivectorData
from ..types import Type, TypedAlgebra
from .backends import Backend


class ArrayType(Type):
    """One kind in one precision, on arrays of one package."""

    __slots__ = ("backend",)

    #: Class of the multivectors.
    multivector_class: ClassVar[type[Any]]

    def __init__(self, algebra: TypedAlgebra, kind: Kind, dtype: np.dtype[Any], backend: Backend) -> None:
        super().__init__(algebra, kind, dtype)
        self.backend: Backend = backend

    def of_kind(self, kind: Kind) -> Type:
        return array_type(self.algebra, kind, self.dtype, self.backend)

    def in_precision(self, dtype: np.dtype[Any]) -> Type:
        return array_type(self.algebra, self.kind, dtype, self.backend)


def array_type(algebra: TypedAlgebra, kind: Kind, dtype: np.dtype[Any], backend: Backend) -> ArrayType:
    """The one type of a kind and a precision on arrays of a package."""
    plain = algebra.type_of(kind, dtype)
    return plain.memoize(("arrays", backend.name), lambda: ArrayType(algebra, plain.kind, dtype, backend))


def wrap(algebra: TypedAlgebra, kind: Kind, data: Any, backend: Backend) -> Any:
    """Rows of coefficients of a package as multivectors."""
    made = array_type(algebra, kind, backend.precision(data), backend)
    return made.multivector_class._make(made, data, tuple(data.shape[:-1]))


def rows_on(x: MultivectorData, kind: Kind, backend: Backend) -> Any:
    """Rows on the blades of a kind, as an array of the package."""
    data = embed(x, kind)
    return data if x._type.backend is not None else backend.floating(data, "an operand")


def common_backend(*operands: Type) -> Backend | None:
    """The package of the operands of one operation; None if all are on NumPy arrays.

    Raises
    ------
    InputError
        If there are two packages.
    """
    found: dict[str, Backend] = {b.name: b for x in operands if (b := x.backend) is not None}
    if len(found) > 1:
        raise InputError(f"the operands hold arrays of {' and '.join(found)}; convert one of them first.")
    return next(iter(found.values()), None)
