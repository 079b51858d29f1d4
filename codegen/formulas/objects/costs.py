"""Distance of a rotor from the identity, and the cost of taking one object to another (thesis 3.13, 5.1).

The default is positive: squares of coefficients on the orthonormal basis. The printed cost is here by name; it is
indefinite once dilations come in (concentric spheres of radii 1 and 10: -3.5, cheaper than standing still).
"""

from __future__ import annotations

from ...algebra.multivector import Mask, Multivector, absolute, select, sqrt
from ..motions.motions import translator
from ..motions.rotors import gamma, plain_rotor
from ..products.outcome import epsilon, where_or_nan
from .blades import norm_squared
from .conformal import infinity, origin
from .euclidean import euclidean_part

#: Rotors are left to the careful formulas where h = 1 + gamma <x2 x1>_{0,4} comes this many roots of the spacing of
#: numbers near to zero or to the negative scalars: what is left keeps eps/(CARE sqrt(eps)) of a pair's cost.
CARE = 16


# -- rotors ------------------------------------------------------------------------------------------------


def magnitude(x: Multivector) -> Multivector:
    """Sum of the squared coefficients of x on the orthonormal basis: <x' x>_0 with x' = -e_- x- e_-, x- the conjugate.

    x' turns each orthonormal basis blade into its inverse, whatever it squares to; on the null basis n0 and n_inf
    count 1/2 and 2.
    """
    return positive_product(x, x)


def positive_product(x: Multivector, y: Multivector) -> Multivector:
    """The inner product that `magnitude` is the square of."""
    minus = infinity(x) / 2 + origin(x)
    return -(minus * x.conjugate() * minus).scalar_product(y)


def parallel(r: Multivector) -> Multivector:
    """R_par = R . e_+, which has every term of R with n_inf in it."""
    return r | (infinity(r) / 2 - origin(r))


def _nearer(r: Multivector) -> Multivector:
    """R or -R, the one with <R>_0 >= 0, less its scalar part's sign elsewhere: squares do not see it."""
    return r.grade(2, 4) + absolute(r.grade(0))


def rotor_cost(r: Multivector) -> Multivector:
    """|R - 1|^2 + |R . e_+|^2, sums of squares on the orthonormal basis; of R and -R the smaller one.

    A rotation by th and a translation t cost 2 - 2 cos(th/2) and 3 t^2/4.
    """
    return _positive(_nearer(r))


def rotor_cost_thesis(r: Multivector) -> Multivector:
    """(5.1) as printed, <(R - 1)(~R - 1)>_0 + <R_par ~R_par>_0; of R and -R the one with <R>_0 >= 0.

    For motors 2 - 2 cos(th/2) + t^2/4. Dilations and transversions make it negative.
    """
    return _published_cost(_nearer(r))


def _positive(r: Multivector) -> Multivector:
    return magnitude(r - 1) + magnitude(parallel(r))


def _published_cost(r: Multivector) -> Multivector:
    return norm_squared(r - 1) + norm_squared(parallel(r))


# -- pairs of objects --------------------------------------------------------------------------------------


def pair_cost(x1: Multivector, x2: Multivector) -> Multivector:
    """`rotor_cost` of the rotor from x1 to x2, which is that from x2 to x1. NaN unless `is_plain`."""
    return _positive(_rotor(x1, x2))


def pair_cost_thesis(x1: Multivector, x2: Multivector) -> Multivector:
    """`rotor_cost_thesis` of the rotor from x1 to x2. NaN unless `is_plain`."""
    return _published_cost(_rotor(x1, x2))


def aligned_cost(x1: Multivector, x2: Multivector) -> Multivector:
    """`pair_cost` of x1 and whichever of x2 and -x2 is turned the same way: objects without an orientation."""
    return _positive(_rotor(x1, align(x2, x1)))


def aligned_cost_thesis(x1: Multivector, x2: Multivector) -> Multivector:
    """`pair_cost_thesis`, aligned in the same way."""
    return _published_cost(_rotor(x1, align(x2, x1)))


def agreement(x: Multivector, reference: Multivector) -> Multivector:
    """gamma <x reference>_0: 1 for equal objects, negative where x and -x should change places; never for points."""
    return gamma(x) * x.scalar_product(reference)


def align(x: Multivector, reference: Multivector) -> Multivector:
    """x or -x, whichever agrees with the reference. A point has one orientation only."""
    if x.grades == (1,):
        return x
    return select(agreement(x, reference) < 0, x.constant(-1), x.constant(1)) * x


def _rotor(x1: Multivector, x2: Multivector) -> Multivector:
    """`any_rotor`, NaN where it needs care."""
    if x1.grades == (1,):
        return any_rotor(x1, x2)
    return where_or_nan(is_plain(x1, x2), x1.constant(1)) * any_rotor(x1, x2)


def any_rotor(x1: Multivector, x2: Multivector) -> Multivector:
    """The rotor with <R>_0 >= 0 from x1 to x2. Points are translated."""
    if x1.grades == (1,):
        return translator(euclidean_part(x2) - euclidean_part(x1))
    return plain_rotor(x1, x2)


def is_plain(x1: Multivector, x2: Multivector) -> Mask:
    """Return whether `rotors.plain_rotor` keeps its digits: h = 1 + gamma <x2 x1>_{0,4} is neither zero nor negative.

    Such are objects that face each other (L and nearly -L), circles that link at right angles, touching spheres.
    """
    product = gamma(x1) * (x2 * x1)
    h0, p4 = 1 + product.grade(0), product.grade(4)
    near = CARE * sqrt(epsilon(x1))
    if not p4.terms:
        return absolute(h0) > near
    square = (p4 * p4).grade(0)
    if not square.terms:
        return h0 > near
    size = 1 + h0 * h0 + absolute(square)
    return (h0 * h0 - square > near * size) & ((h0 > 0) | (-square > near * size))
