"""Change of basis between an algebra's vectors and orthonormal ones: every conversion of basis and sign is here.

The orthonormal algebra of a signature is ``bs.algebra(p, q, r)``; a change of basis of the vectors gives one of
the blades (their outer products), a sparse matrix that is exact.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.algebra.algebra import Algebra as Mathematics
from ...codegen.algebra.multivector import Multivector as Exact
from ...codegen.errors import AlgebraMismatchError, SignatureError
from ...codegen.rings.protocol import RationalRing
from ...dispatch.coefficients import embed
from ...dispatch.multivector_data import M, MultivectorData
from ...dispatch.types import TypedAlgebra


def orthonormal_vectors(algebra: Mathematics) -> list[Exact]:
    """Orthonormal vectors of an algebra in its own basis: those of square +1, then -1, then 0 (a single one first).

    A pair of null vectors n, m with n . m = g gives e+ = m/2 + n/g and e- = m/2 - n/g; in CGA, where n0 . n_inf = -1,
    that is e+ = n_inf/2 - n0 and e- = n_inf/2 + n0.

    Raises
    ------
    SignatureError
        If the metric is made of other blocks than squares +1, -1, 0 and such pairs.
    """
    ring = RationalRing()
    units = [Exact(algebra, ring, {1 << i: Fraction(1)}) for i in range(algebra.dimension)]
    found: dict[int, list[Exact]] = {1: [], -1: [], 0: []}
    for i, row in enumerate(algebra.metric):
        others = [j for j, g in enumerate(row) if g and j != i]
        if not others and row[i] in (1, -1, 0):
            found[int(row[i])].append(units[i])
        elif len(others) == 1 and not row[i] and not algebra.metric[others[0]][others[0]]:
            j, g = others[0], row[others[0]]
            if i < j:
                found[1].append(units[j] / 2 + units[i] / g)
                found[-1].append(units[j] / 2 - units[i] / g)
        else:
            raise SignatureError(
                f"the basis of {algebra.name} has no known orthonormal one: vector {i + 1} is neither of square "
                "1, -1 or 0 and orthogonal to the others, nor one of a pair of null vectors."
            )
    null_first = len(found[0]) == 1
    return [*(found[0] if null_first else []), *found[1], *found[-1], *([] if null_first else found[0])]


def is_orthonormal(algebra: Mathematics) -> bool:
    """Test whether the vectors are already orthonormal, and in the standard order."""
    p, q, r = algebra.signature
    squares = [Fraction(0)] * (r == 1) + [Fraction(1)] * p + [Fraction(-1)] * q + [Fraction(0)] * (r if r != 1 else 0)
    return algebra.is_diagonal and [algebra.metric[i][i] for i in range(algebra.dimension)] == squares


@lru_cache(maxsize=512)
def _columns(
    source: TypedAlgebra, target: TypedAlgebra, blades: tuple[int, ...]
) -> tuple[tuple[int, ...], NDArray[np.float64]]:
    """Blades of the target, and the matrix that takes coefficients on ``blades`` of the source to them."""
    images = [_image(source, target, blade) for blade in blades]
    found = target.order(blade for image in images for blade in image) or (0,)
    place = {blade: i for i, blade in enumerate(found)}
    matrix = np.zeros((len(blades), len(found)))
    for i, image in enumerate(images):
        for blade, weight in image.items():
            matrix[i, place[blade]] = float(weight)
    return found, matrix


def _image(source: TypedAlgebra, target: TypedAlgebra, blade: int) -> dict[int, Fraction]:
    """A basis blade of the source in the target's basis: the outer product of its vectors' images."""
    total = Exact(target, RationalRing(), {0: Fraction(1)})
    for i, vector in enumerate(_vector_images(source, target)):
        if blade >> i & 1:
            total = total ^ Exact(target, RationalRing(), dict(vector))
    return dict(total.terms)


@lru_cache(maxsize=64)
def _vector_images(source: TypedAlgebra, target: TypedAlgebra) -> Sequence[tuple[tuple[int, Fraction], ...]]:
    """The source's basis vectors in the target's basis, through the orthonormal vectors of both."""
    n = source.dimension
    own = [[v.terms.get(1 << j, Fraction(0)) for j in range(n)] for v in orthonormal_vectors(source)]
    images = []
    for row in _inverse(own):
        total = Exact(target, RationalRing(), {})
        for weight, vector in zip(row, orthonormal_vectors(target), strict=True):
            total = total.linear_combination(1, vector, weight)
        images.append(tuple(total.terms.items()))
    return images


def _inverse(matrix: list[list[Fraction]]) -> list[list[Fraction]]:
    """Inverse of a rational matrix, by elimination."""
    n = len(matrix)
    rows = [[*row, *(Fraction(int(i == j)) for j in range(n))] for i, row in enumerate(matrix)]
    for i in range(n):
        pivot = next(k for k in range(i, n) if rows[k][i])
        rows[i], rows[pivot] = rows[pivot], rows[i]
        rows[i] = [value / rows[i][i] for value in rows[i]]
        for k in range(n):
            if k != i and rows[k][i]:
                factor = rows[k][i]
                rows[k] = [value - factor * own for value, own in zip(rows[k], rows[i], strict=True)]
    return [row[n:] for row in rows]


def convert(x: M, target: TypedAlgebra) -> M:
    """x in another algebra of the same signature."""
    blades, matrix = _columns(x.algebra, target, x._type.blades)
    data = x._data @ matrix.astype(x.dtype)
    return x._make(target.type_of(target.layout_of(blades), x.dtype), data, x.shape, x._status)


def from_algebra(target: TypedAlgebra, x: M) -> M:
    """x, of another algebra, in ``target``.

    Raises
    ------
    AlgebraMismatchError
        If the signatures differ.
    """
    if x.algebra.signature != target.signature:
        raise AlgebraMismatchError(
            f"{x.algebra.name} is Cl{x.algebra.signature} and {target.name} is Cl{target.signature}; "
            "only algebras of one signature convert."
        )
    return convert(x, target)


def dense(x: MultivectorData, algebra: TypedAlgebra) -> NDArray[Any]:
    """All 2^n coefficients of x in the blade order of its algebra."""
    return embed(x, algebra.layout_of(algebra.blades))
