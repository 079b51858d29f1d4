"""Constants of ribbons: polynomials of a curve of point pairs, and sizes for telling their rounding errors."""

from __future__ import annotations

from collections.abc import Sequence
from math import comb

from ...algebra.multivector import Multivector
from ...rings.bernstein import HomogeneousRing
from ...trace.outputs import Result, row
from ..objects.euclidean import dot
from ..products.outcome import epsilon
from ..products.sizes import Sizes, product_sizes, sizes
from .homogeneous import Bivectors, coefficients, from_row, polynomial, to_row

#: Spacings of numbers at 1 that a square of a pair may be off 1, relative to its terms, and be taken for 1.
UNIT_SQUARE = 8


def ribbon_constants(controls: Bivectors) -> tuple[Result, ...]:
    """S0, K, the controls with their binomials, Q C', and sizes, of a curve that begins and ends with pairs.

    Sizes: the sum of the squares of Q's coefficients, and of the products that they are made of, for telling what is
    nothing but rounding; what rounding may make of the squares of the ends; of the carriers of C', coefficients of
    the direction and of the moment, then of the terms of those of Q C'.
    """
    return _constants(controls, ends=1)


def ribbon_free_constants(controls: Bivectors) -> tuple[Result, ...]:
    """The same of a curve whose ends may be no pairs."""
    return _constants(controls, ends=0)


def _constants(controls: Bivectors, ends: int) -> tuple[Result, ...]:
    given, base = from_row(controls, "point_pair"), controls[0].ring
    n, ring = len(given) - 1, HomogeneousRing(base)
    scaled = [comb(n, k) * c for k, c in enumerate(given)]
    pair = polynomial(scaled, ring)
    square = -(pair * ~pair)
    found = coefficients(square.grade(4), 2 * n, base)[ends : 2 * n + 1 - ends]
    q, degree = polynomial(found, ring), 2 * (n - ends)
    norm, kappa = coefficients(square.grade(0), 2 * n, base), coefficients(dot(q, q), 2 * degree, base)
    products = coefficients((q * pair).grade(2), degree + n, base)
    written = [epsilon(c) * UNIT_SQUARE * product_sizes(sizes(c), sizes(c))[1] for c in (given[0], given[-1])]
    size = _together(scaled)
    levers = [size[:2], product_sizes(product_sizes(size, size), size)[:2]]
    near = [*_nearness(scaled, found, ends), *written, *(size for lever in levers for size in lever)]
    return (
        row(norm, "norm"),
        row(kappa, "kappa"),
        to_row(scaled, "point_pair", "scaled"),
        to_row(products, "point_pair", "products"),
        row(near, "near"),
    )


def _nearness(scaled: Sequence[Multivector], found: Sequence[Multivector], ends: int) -> list[Multivector]:
    n, nothing = len(scaled) - 1, scaled[0].new({})
    squares = [_square(c) for c in scaled]
    made = [squares[i] * squares[j] for j in range(n + 1) for i in range(j + 1) if i < j or ends <= i <= n - ends]
    return [nothing.sum(map(_square, found)), nothing.sum(made)]


def _square(x: Multivector) -> Multivector:
    """Sum of the squares of the coefficients."""
    return x.sum(c * c for c in x.coefficients())


def _together(values: Sequence[Multivector]) -> Sizes:
    """Sums of the sizes of several multivectors."""
    parts = [sizes(x) for x in values]
    first, second, third = (values[0].sum(p[i] for p in parts) for i in range(3))
    return first, second, third
