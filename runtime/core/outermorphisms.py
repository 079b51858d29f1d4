"""Linear maps of vectors, extended to all blades: f(a ^ b) = f(a) ^ f(b)."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any, Generic

import numpy as np
from numpy.typing import NDArray

from ..codegen.algebra.blades import grade, outer_sign
from ..codegen.algebra.mismatch import algebra_mismatch
from ..codegen.errors import AlgebraMismatchError, GradeError, InputError, ShapeError, SignatureError, SingularError
from ..common.validation import all_finite, real_array
from ..dispatch.multivector_data import check_multivector
from ..dispatch.plans import table_rows
from ..dispatch.product_tables import Table
from .constructors import Constructors
from .functions.inverses import inverse
from .kind_constraints import convert_to_kind
from .operators import Operators, P

Matrix = NDArray[np.float64]


class Outermorphism(Generic[P]):
    """A linear map of vectors and what it makes of all blades. Made by `Algebra.outermorphism`.

    Attributes
    ----------
    algebra : Algebra
    matrix : array (n, n)
        On coefficients of vectors, read-only: column j is the image of basis vector j.

    Notes
    -----
    Images of blades are sums of products of entries without divisions: each is within k rounding units, for grade k,
    of the sum of the absolute values of its terms.
    """

    def __init__(self, algebra: Constructors[P], matrix: NDArray[Any]) -> None:
        self.algebra = algebra
        self.matrix = np.array(matrix, np.float64)
        self.matrix.flags.writeable = False
        self._images: dict[int, dict[int, float]] = {0: {0: 1.0}}
        self._tables: dict[tuple[int, ...], tuple[Table, Matrix]] = {}

    # -- on multivectors -----------------------------------------------------------------------------------

    def apply(self, x: P) -> P:
        """The image of each item, scalars as they are; of a batch in one compiled loop."""
        check_multivector(x)
        if x.algebra is not self.algebra:
            raise AlgebraMismatchError(f"the map is one of {self.algebra.name}, and x belongs to {x.algebra.name}.")
        blades = x.kind.blades
        if blades not in self._tables:
            self._tables[blades] = self._table(blades)
        table, entries = self._tables[blades]
        data = np.empty((*x.shape, len(table.blades)), x.dtype)
        table_rows(table, x._type.single)(data, entries.astype(x.dtype), x._data, x.size)
        return self.algebra.wrap(self.algebra.layout_of(table.blades), data, x._status)

    __call__ = apply

    def _table(self, blades: tuple[int, ...]) -> tuple[Table, Matrix]:
        """The map on these blades as a table of terms, and its entries."""
        terms = [
            (image, entry, column)
            for column, blade in enumerate(blades)
            for image, entry in self._image(blade).items()
            if entry
        ]
        found = self.algebra.order(image for image, _, _ in terms) or (0,)
        place = {blade: i for i, blade in enumerate(found)}
        terms.sort(key=lambda term: (place[term[0]], term[2]))
        starts = np.searchsorted([place[image] for image, _, _ in terms], np.arange(len(found) + 1))
        entries = np.array([entry for _, entry, _ in terms] or [0.0])
        left, right = np.arange(len(terms), dtype=np.int32), np.array([column for _, _, column in terms], np.int32)
        sizes = (len(entries), len(blades))
        return Table(found, sizes, starts.astype(np.int32), left, right, np.ones(len(terms))), entries[None]

    def _image(self, blade: int) -> dict[int, float]:
        """The image of a basis blade: that of its first vector ^ that of the rest."""
        image = self._images.get(blade)
        if image is None:
            first = blade & -blade
            column = self.matrix[:, first.bit_length() - 1].tolist()
            image = {}
            for other, weight in self._image(blade ^ first).items():
                for i, entry in enumerate(column):
                    if entry and (sign := outer_sign(1 << i, other)):
                        image[other | 1 << i] = image.get(other | 1 << i, 0.0) + sign * entry * weight
            self._images[blade] = image
        return image

    # -- maps from maps ------------------------------------------------------------------------------------

    def __matmul__(self, other: Outermorphism[P]) -> Outermorphism[P]:
        """The map that applies ``other`` first."""
        if not isinstance(other, Outermorphism):
            return NotImplemented
        if other.algebra is not self.algebra:
            raise AlgebraMismatchError(f"the maps are of {self.algebra.name} and of {other.algebra.name}.")
        return Outermorphism(self.algebra, self.matrix @ other.matrix)

    def adjoint(self) -> Outermorphism[P]:
        """The map g with f(a) . b = a . g(b).

        Raises
        ------
        SignatureError
            If the metric is degenerate: null vectors orthogonal to all leave it open.
        """
        if self.algebra.is_degenerate:
            raise SignatureError(f"the metric of {self.algebra.name} is degenerate; it gives maps no adjoint.")
        metric = np.array(self.algebra.metric, float).reshape(self.matrix.shape)
        return Outermorphism(self.algebra, np.linalg.solve(metric, self.matrix.T @ metric))

    def inverse(self) -> Outermorphism[P]:
        """The map that undoes this one.

        Raises
        ------
        SingularError
            If the matrix is singular, or to rounding.
        """
        condition = np.linalg.cond(self.matrix) if self.matrix.size else 1.0
        if not condition * np.finfo(float).eps < 1:
            raise SingularError(f"the map is singular, the condition of its matrix {condition:.1e}: it has no inverse.")
        return Outermorphism(self.algebra, np.linalg.inv(self.matrix))

    @cached_property
    def determinant(self) -> float:
        """Factor of the pseudoscalar: f(I) = determinant I."""
        return float(np.linalg.det(self.matrix))

    def __repr__(self) -> str:
        return f"<outermorphism of {self.algebra.name}, determinant {self.determinant:.6g}>"


def outermorphism(algebra: Constructors[P], given: Any) -> Outermorphism[P]:
    """The map of a matrix (n, n), of a function of vectors, or of an invertible versor.

    Raises
    ------
    ShapeError, InputError
        If the matrix has another shape, or an entry is not finite; if the function's results are no single vectors.
    GradeError
        If the multivector is neither even nor odd, or does not keep vectors vectors.
    SingularError
        If the versor has no inverse.
    """
    if isinstance(given, Operators):
        versor: Any = given
        matrix = _of_versor(algebra, versor)
    elif callable(given):
        matrix = _of_function(algebra, given)
    else:
        matrix = real_array(given, "the matrix", (algebra.dimension, algebra.dimension))
    if not all_finite(matrix):
        raise InputError("an entry of the map's matrix is not finite.")
    return Outermorphism(algebra, matrix)


def _of_function(algebra: Constructors[P], function: Callable[[P], Any]) -> Matrix:
    kind = algebra.kind("vector")
    columns = []
    for i in range(algebra.dimension):
        name = algebra.blade_name(1 << i)
        image = function(algebra.basis_blade(name))
        if not hasattr(image, "as_kind") or image.algebra is not algebra or image.shape:
            raise InputError(f"the function gives no vector of {algebra.name} for {name}.")
        columns.append(image.as_kind(kind).values)
    return np.array(columns, float).reshape(algebra.dimension, -1).T


def _of_versor(algebra: Constructors[P], versor: P) -> Matrix:
    """Columns R e_i R^-1, with the sign that makes odd versors reflections."""
    if versor.algebra is not algebra:
        what = f"the versor belongs to {versor.algebra.name}, not to {algebra.name}."
        raise algebra_mismatch(what, versor, algebra)
    if versor.shape:
        raise ShapeError(f"the versor has the shape {versor.shape}; a map is made of one.")
    parities = {g % 2 for g in versor.grades}
    if len(parities) != 1:
        raise GradeError("the multivector has even and odd grades; a versor has one of them.", remedy="Use .grade(...)")
    sign = -1.0 if parities == {1} else 1.0
    vectors = algebra.vector(np.eye(algebra.dimension))
    images = sign * (versor * vectors * inverse(versor, strict=True))
    others = [i for i, blade in enumerate(images.kind.blades) if grade(blade) != 1]
    rest = np.abs(images.values[..., others]).max(initial=0.0)
    if rest > RELATIVE * np.abs(images.values).max(initial=0.0):
        raise GradeError("the multivector is no versor: it takes vectors to more than vectors.")
    own: Matrix = convert_to_kind(images.grade(1), algebra.kind("vector")).values.astype(np.float64)
    return own.T


#: Other grades of a versor's image of vectors are rounding up to this part of it.
RELATIVE = 1e-9

__all__ = ["Outermorphism", "outermorphism"]
