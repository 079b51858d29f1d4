"""Reciprocal and pseudo-reciprocal frames, linear maps as matrices, the map J (thesis 1.2.3, 1.2.4, 1.4.5).

A frame is a list of independent multivectors of any grades. Where the metric is degenerate, the scalar product
is replaced by the coefficient of I in X ^ P.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import reduce

from ...algebra.algebra import Algebra
from ...algebra.multivector import Multivector
from ...trace.outputs import Result, row

LinearMap = Callable[[Multivector], Multivector]
Product = Callable[[Multivector, Multivector], Multivector]


def blade_frame(like: Multivector, blades: Iterable[int]) -> list[Multivector]:
    """Basis blades as multivectors."""
    one = like.ring.constant(Fraction(1))
    return [like.new({b: one}) for b in blades]


def pairing(x: Multivector, p: Multivector) -> Multivector:
    """<x ^ p>_I: the coefficient of the pseudoscalar."""
    sign = Fraction(x.algebra.pseudoscalar_sign)
    coefficient = (x ^ p).terms.get(x.algebra.full_blade)
    return x.new({} if coefficient is None else {0: x.ring.combine([(coefficient, sign)])})


# -- frames ------------------------------------------------------------------------------------------------


def reciprocal_vectors(vectors: Sequence[Multivector]) -> list[Multivector]:
    """Reciprocal frame of independent vectors: a^i = (-1)^(i-1) (a_1 ^ .. no a_i .. ^ a_n) E^-1, E their blade."""
    volume = _outer(vectors[0], vectors)
    inverse = ~volume / volume.scalar_product(~volume)
    found = []
    for i in range(len(vectors)):
        others = _outer(vectors[0], [v for j, v in enumerate(vectors) if j != i])
        found.append((others * inverse if i % 2 == 0 else -(others * inverse)).grade(1))
    return found


def reciprocal_frame(frame: Sequence[Multivector]) -> list[Multivector]:
    """X^j with <X_i X^j>_0 = delta_ij, in the span of the frame.

    By the adjugate of the matrix of products (2^k k multiplications for k members): meant for small frames, or for
    constant ones, where every product is folded. Divides by zero where the frame's metric is degenerate.
    """
    gram = [[x.scalar_product(y) for y in frame] for x in frame]
    return _reciprocal_combinations(gram, frame)


def pseudo_reciprocal_frame(frame: Sequence[Multivector]) -> list[Multivector]:
    """P^j with <X_i ^ P^j>_I = delta_ij, among the images J(X) of the frame: for any metric."""
    images = [x.complement() for x in frame]
    gram = [[pairing(x, p) for p in images] for x in frame]
    return _reciprocal_combinations(gram, images)


def coframe(frame: Sequence[Multivector]) -> tuple[list[Multivector], Product]:
    """The frame that reads coefficients, and the product to read them with: scalar, or `pairing` where degenerate."""
    if frame[0].algebra.is_degenerate:
        return pseudo_reciprocal_frame(frame), pairing
    return reciprocal_frame(frame), Multivector.scalar_product


# -- linear maps -------------------------------------------------------------------------------------------


def matrix_of(
    function: LinearMap, frame: Sequence[Multivector], codomain: Sequence[Multivector]
) -> list[list[Multivector]]:
    """Matrix of a linear map on column coefficients: M_ji = <F(X_i) X^j>_0, or <F(X_i) ^ P^j>_I.

    (The printed c_ij of 1.2.4 is its transpose.) Rows belong to ``codomain``, columns to ``frame``.
    """
    images = [function(x) for x in frame]
    readers, product = coframe(codomain)
    return [[product(image, reader) for image in images] for reader in readers]


def apply_matrix(
    matrix: Sequence[Sequence[Multivector]],
    x: Multivector,
    frame: Sequence[Multivector],
    codomain: Sequence[Multivector],
) -> Multivector:
    """F(x) from the matrix of F, for x in the span of ``frame``."""
    readers, product = coframe(frame)
    columns = [product(x, reader) for reader in readers]
    image = [x.sum(m * c for m, c in zip(entries, columns, strict=True)) for entries in matrix]
    return x.sum(c * y for c, y in zip(image, codomain, strict=True))


def sandwich_matrix(r: Multivector, blades: Sequence[int]) -> Result:
    """Matrix of x -> r x ~r on the span of blades that it keeps, row by row."""
    frame = blade_frame(r, blades)
    return row([m for entries in matrix_of(lambda x: r >> x, frame, frame) for m in entries])


def j_map(a: Multivector) -> Multivector:
    """J(A) = sum_i <A ^ X^i>_I X^i over the basis blades X_i, with X_i ^ X^i = I (1.4.5); it equals `complement`."""
    frame = pseudo_reciprocal_frame(blade_frame(a, a.algebra.blades))
    return a.sum(pairing(a, p) * p for p in frame)


@dataclass(frozen=True)
class Entry:
    """One term of a matrix that is linear in a multivector's coefficients: weight * coefficient, at (row, column)."""

    row: int
    column: int
    coefficient: int
    weight: Fraction


def left_multiplication(algebra: Algebra, blades: Sequence[int], space: Sequence[int] | None = None) -> list[Entry]:
    """The matrix of y -> x y, for x on ``blades`` and y on ``space`` (all blades), as a table.

    x y = 1 is then one linear system per item: the inverse by matrices (Perwass), for a solver with pivots.
    """
    space = algebra.blades if space is None else tuple(space)
    place = {b: i for i, b in enumerate(space)}
    return [
        Entry(place[c], j, i, w)
        for i, a in enumerate(blades)
        for j, b in enumerate(space)
        for c, w in algebra.product(a, b)
        if c in place
    ]


# -- small linear algebra over any ring --------------------------------------------------------------------


def _outer(like: Multivector, factors: Sequence[Multivector]) -> Multivector:
    return reduce(lambda a, b: a ^ b, factors, like.constant(1))


def _reciprocal_combinations(gram: Sequence[Sequence[Multivector]], images: Sequence[Multivector]) -> list[Multivector]:
    """Combinations Y^j of the images with product(X_i, Y^j) = delta_ij, given gram[i][k] = product(X_i, images[k])."""
    like = images[0]
    if _is_monomial(gram):
        return _divided_monomial(gram, images)
    k = len(images)
    minors = [[_minor(gram, i, j) for j in range(k)] for i in range(k)]
    det = like.sum(gram[0][j] * minors[0][j] for j in range(k))
    scale = 1 / det
    return [like.sum(minors[j][m] * images[m] for m in range(k)) * scale for j in range(k)]


def _is_monomial(gram: Sequence[Sequence[Multivector]]) -> bool:
    """Return whether each row and each column has one entry by its blades: basis blades, orthogonal or null."""
    pattern = [[bool(entry.terms) for entry in entries] for entries in gram]
    return all(sum(r) == 1 for r in pattern) and all(sum(c) == 1 for c in zip(*pattern, strict=True))


def _divided_monomial(gram: Sequence[Sequence[Multivector]], images: Sequence[Multivector]) -> list[Multivector]:
    places = [next(j for j, entry in enumerate(entries) if entry.terms) for entries in gram]
    return [images[j] / gram[i][j] for i, j in enumerate(places)]


def _minor(gram: Sequence[Sequence[Multivector]], i: int, j: int) -> Multivector:
    """Signed minor without row i and column j, expanded along rows, with shared sub-determinants."""
    rows = [r for r in range(len(gram)) if r != i]
    columns = tuple(c for c in range(len(gram)) if c != j)
    like = gram[0][0]
    known: dict[tuple[int, tuple[int, ...]], Multivector] = {}

    def expand(depth: int, left: tuple[int, ...]) -> Multivector:
        if not left:
            return like.constant(1)
        if (depth, left) not in known:
            parts = []
            for position, c in enumerate(left):
                rest = left[:position] + left[position + 1 :]
                part = gram[rows[depth]][c] * expand(depth + 1, rest)
                parts.append(-part if position % 2 else part)
            known[depth, left] = like.sum(parts)
        return known[depth, left]

    value = expand(0, columns)
    return -value if (i + j) % 2 else value
