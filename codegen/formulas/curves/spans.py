"""Polynomials whose signs decide where sums of circles or point pairs along a curve stand for real objects.

C' = sum c_k a^(n-k) b^k with b = t, a = 1 - t. -C' ~C' = S0 + w Q, with w = a b where both ends are blades, else w = 1;
K = Q^2. C' has a real projection where K < 0, and where S0 > 0 and D = S0^2 - w^2 K > 0: that is where the smaller
eigenvalue S0 - w sqrt(K) is positive. Polynomials are rows of coefficients of a^(d-k) b^k, first k = 0; each has
a row of bounds beside it, in rounding units of the precision.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import comb

from ...algebra.multivector import Multivector, absolute
from ...rings.bernstein import HomogeneousRing
from ...trace.outputs import Result, row
from ..products.sizes import Sizes, product_sizes, sizes
from .homogeneous import Scalars, coefficients, from_row, parameters, polynomial


def circle_norms(controls: Scalars) -> tuple[Result, ...]:
    """S0, K, D, and what rounding is of each, of a curve that begins and ends with circles."""
    return _norms(controls, "circle", ends=1)


def free_circle_norms(controls: Scalars) -> tuple[Result, ...]:
    """The same of a curve whose ends may be no circles."""
    return _norms(controls, "circle", ends=0)


def point_pair_norms(controls: Scalars) -> tuple[Result, ...]:
    """The same of a curve that begins and ends with point pairs."""
    return _norms(controls, "point_pair", ends=1)


def free_point_pair_norms(controls: Scalars) -> tuple[Result, ...]:
    """The same of a curve whose ends may be no point pairs."""
    return _norms(controls, "point_pair", ends=0)


def _norms(controls: Scalars, kind: str, ends: int) -> tuple[Result, ...]:
    algebra, base = controls[0].algebra, controls[0].ring
    values, ring = from_row(controls, kind), HomogeneousRing(base)
    n = len(values) - 1
    scaled = [comb(n, k) * c for k, c in enumerate(values)]
    round_ = polynomial(scaled, ring)
    square = -(round_ * ~round_)
    inner = slice(ends, 2 * n + 1 - ends)
    squares = coefficients(square.grade(4), 2 * n, base)[inner]
    s0, q = square.grade(0), polynomial(squares, ring)
    k = (q * q).grade(0)
    a, b = parameters(algebra, base)
    w_square = a * b * a * b if ends else a.constant(1)

    # bounds: of -C' ~C' by the sizes of the controls, of K by those of Q, which may be much smaller
    written = _polynomials([sizes(c) for c in scaled], ring)
    of_square = product_sizes(written, written)
    noise = _trim(of_square, 2 * n, inner, ring)
    of_q = _polynomials([sizes(c) for c in squares], ring)
    linear, quadratic = product_sizes(of_q, noise)[1], product_sizes(noise, noise)[1]
    of_s0, of_k = of_square[1], product_sizes(of_q, of_q)[1]
    size = polynomial([absolute(c) for c in coefficients(s0, 2 * n, base)], ring)
    of_d = 2 * (size * of_s0) + size * size + w_square * (of_k + 2 * linear)
    rest = of_s0 * of_s0 + w_square * quadratic

    def _named_row(x: Multivector, degree: int, name: str) -> Result:
        return row(coefficients(x, degree, base), name)

    of_kappa = 4 * (n - ends)
    return (
        _named_row(s0, 2 * n, "norm"),
        _named_row(k, of_kappa, "kappa"),
        _named_row(s0 * s0 - w_square * k, 4 * n, "isolated"),
        _named_row(of_s0, 2 * n, "norm_bound"),
        _named_row(of_k + 2 * linear, of_kappa, "kappa_bound"),
        _named_row(quadratic, of_kappa, "kappa_rest"),
        _named_row(of_d, 4 * n, "isolated_bound"),
        _named_row(rest, 4 * n, "isolated_rest"),
    )


def _polynomials(parts: Sequence[Sizes], ring: HomogeneousRing) -> Sizes:
    """Sizes of coefficients as polynomials."""
    first, second, third = (polynomial(part, ring) for part in zip(*parts, strict=True))
    return first, second, third


def _trim(x: Sizes, degree: int, inner: slice, ring: HomogeneousRing) -> Sizes:
    """Without the first and last coefficients, where inner says so."""
    first, second, third = (polynomial(coefficients(part, degree, ring.base)[inner], ring) for part in x)
    return first, second, third
