"""Multivectors as matrices whose products are the matrices of their products, and back."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import GradeError, InputError, ShapeError, SignatureError
from ...common.dtypes import F32, F64
from ...common.validation import as_array, as_choice
from ...dispatch.coefficients import embed
from ...dispatch.product_tables import product_table
from ...dispatch.types import TypedAlgebra
from ..operators import Operators
from . import basis_change

#: "left" and "right" are real matrices (2^n, 2^n) on the coefficients of the other factor.
REPRESENTATIONS = ("left", "right", "complex")
#: What to do where there are no matrices of motors.
OTHER_MATRICES = "Say which matrices are meant: representation='left', 'right' or 'complex'"
#: Dimensions of the largest matrices: 256 x 256.
LARGEST = 8
#: A matrix is that of a multivector if it differs by at most this many rounding units of its largest entry.
TOLERANCE = 2**16


def to_matrix(x: Operators, representation: str) -> NDArray[Any]:
    """Matrices (..., d, d) of multivectors.

    Parameters
    ----------
    x : Multivector
    representation : {"left", "right", "complex"}
        "left": L with L c(y) = c(x y), on the coefficients c in storage order; "right": R with R c(y) = c(y x), whose
        products are in the reverse order; "complex": the smallest complex matrices that tell all multivectors apart,
        Pauli's for three vectors of square 1.

    Raises
    ------
    SignatureError
        If the algebra has more than eight dimensions, or for "complex" a degenerate metric.
    """
    as_choice(representation, "representation", REPRESENTATIONS)
    algebra = _checked(x.algebra)
    if representation == "complex":
        return _complex_matrix(x)
    everything = tuple(int(blade) for blade in algebra.blades)
    own = x._type.blades
    factors = (own, everything) if representation == "left" else (everything, own)
    table = product_table(algebra, "geometric", *factors, everything)
    n = len(everything)
    row = np.repeat(np.arange(n), np.diff(table.starts))
    entry, column = (table.left, table.right) if representation == "left" else (table.right, table.left)
    matrix = np.zeros((n * n, x.size), x.dtype)
    terms = x.values.reshape(x.size, len(own))[:, entry] * table.weights.astype(x.dtype)
    np.add.at(matrix, row * n + column, terms.T)
    return np.ascontiguousarray(matrix.T).reshape(*x.shape, n, n)


def from_matrix(algebra: TypedAlgebra, given: Any, representation: str) -> Any:
    """The multivectors whose matrices (..., d, d) these are.

    Raises
    ------
    InputError
        If a matrix is that of no multivector.
    """
    as_choice(representation, "representation", REPRESENTATIONS)
    _checked(algebra)
    matrix = as_array(given, "the matrix")
    orthonormal = _orthonormal(algebra) if representation == "complex" else algebra
    d = gammas(*orthonormal.signature).shape[-1] if representation == "complex" else len(algebra.blades)
    if matrix.shape[-2:] != (d, d):
        raise ShapeError(f"the matrix has shape {matrix.shape}; matrices of {algebra.name} end in ({d}, {d}).")
    if matrix.dtype.kind not in "biufc" or (representation != "complex" and matrix.dtype.kind == "c"):
        raise InputError(f"the matrix has entries of type {matrix.dtype}; numbers are needed.")
    if representation == "complex":
        blades = _blade_matrices(orthonormal)
        values = np.tensordot(matrix, blades.conj(), ((-2, -1), (-2, -1))).real / d
    else:
        values = np.asarray(matrix[..., :, 0], F32 if matrix.dtype == F32 else F64)
    x = orthonormal.multivector_class._make(
        orthonormal.type_of(orthonormal.layout_of(orthonormal.blades), values.dtype), values, values.shape[:-1]
    )
    _check(matrix, to_matrix(x, representation))
    return x if orthonormal is algebra else basis_change.from_algebra(algebra, x)


def _check(given: NDArray[Any], made: NDArray[Any]) -> None:
    unit = TOLERANCE * np.finfo(made.real.dtype).eps
    size = np.abs(given).max((-2, -1), initial=0.0)
    bad = ~(np.abs(given - made).max((-2, -1), initial=0.0) <= unit * size)
    if bad.any():
        place = tuple(int(i) for i in np.argwhere(bad)[0])
        which = f"matrix {place[0] if len(place) == 1 else place}" if place else "the matrix"
        raise InputError(f"{which} is that of no multivector, by {float(np.abs(given - made)[place].max()):.1e}.")


def _checked(algebra: TypedAlgebra) -> TypedAlgebra:
    if algebra.dimension > LARGEST:
        raise SignatureError(f"{algebra.name} has {algebra.dimension} dimensions; matrices go to {LARGEST}.")
    return algebra


def _orthonormal(algebra: TypedAlgebra) -> Any:
    if algebra.is_degenerate:
        raise SignatureError(
            f"the metric of {algebra.name} is degenerate: no complex matrices tell all multivectors apart.",
            remedy='Use representation="left"',
        )
    on_basis: Any = algebra
    return on_basis.on_basis()


def _complex_matrix(x: Operators) -> NDArray[Any]:
    algebra = _orthonormal(x.algebra)
    own: Any = x if algebra is x.algebra else basis_change.convert(x, algebra)
    values = embed(own, algebra.layout_of(algebra.blades))
    return np.tensordot(values, _blade_matrices(algebra), ((-1,), (0,)))


def _blade_matrices(algebra: TypedAlgebra) -> NDArray[np.complex128]:
    """Matrices of the basis blades, in storage order: products of those of the vectors."""
    vectors = gammas(*algebra.signature)
    d = vectors.shape[-1] if len(vectors) else 1
    matrices = []
    for blade in algebra.blades:
        total = np.eye(d, dtype=complex)
        for i in range(algebra.dimension):
            if blade >> i & 1:
                total = total @ vectors[i]
        matrices.append(total)
    return np.array(matrices)


@lru_cache(maxsize=64)
def gammas(p: int, q: int, r: int) -> NDArray[np.complex128]:
    """Matrices of orthonormal vectors, unitary: those of Jordan and Wigner, i times for squares -1.

    Vectors 2k and 2k + 1 are z x .. x z x (x or y) x 1 x .. x 1 with k factors z; an odd one out is z x .. x z, if that
    makes the pseudoscalar i or -i. Where its square is 1 it would be a number, and multivectors would be mixed up.
    """
    n = p + q
    x, y, z = np.array([[0, 1], [1, 0]]), np.array([[0, -1j], [1j, 0]]), np.diag([1, -1])
    square = (-1) ** (n * (n - 1) // 2 + q)
    pairs = n // 2 if n % 2 == 0 or square < 0 else (n + 1) // 2
    made = []
    for i in range(n):
        k = i // 2
        factors = [z] * k + ([(x, y)[i % 2]] + [np.eye(2)] * (pairs - k - 1) if k < pairs else [])
        total: NDArray[Any] = np.eye(1)
        for factor in factors:
            total = np.kron(total, factor)
        made.append(total * (1j if i >= p else 1))
    return np.array(made, complex).reshape(n, 2**pairs, 2**pairs)


def as_homogeneous(algebra: TypedAlgebra) -> Any:
    """The maker of motors from homogeneous matrices.

    Raises
    ------
    GradeError
        If the algebra stands for no geometry.
    """
    maker = getattr(type(algebra), "motor_from_matrix", None)
    if maker is None:
        raise GradeError(
            f"{algebra.name} has no motors of space; they are those of cga3d and pga3d.", remedy=OTHER_MATRICES
        )
    return maker
