"""Norms, normalization, inverses of versors, sandwiches and reflections (thesis 1.2.5, 1.2.6, 1.3.4).

For anything that is a product of vectors, or nearly. General inverses are in `inverses`, projections to blades
in `blades`.
"""

from __future__ import annotations

from ...algebra.multivector import Multivector, absolute, sqrt
from ...algebra.product_terms import keep_scalar
from ...status import Status
from ...trace.outputs import Result
from ..objects.blades import norm_squared
from .outcome import NOISE, epsilon, outcome, where_or_nan
from .products import absolute_product


def norm(x: Multivector) -> Multivector:
    """sqrt |<x ~x>_0|."""
    return sqrt(absolute(norm_squared(x)))


def noise_of_square(x: Multivector) -> Multivector:
    """Bound of the rounding error of <x ~x>_0 where it should be zero."""
    return NOISE * epsilon(x) * absolute_product(x, x, keep_scalar)


def normalise(x: Multivector) -> tuple[Multivector, Result]:
    """x over its norm; null multivectors (a point, for one) are singular."""
    square = absolute(norm_squared(x))
    regular = square > noise_of_square(x)
    return x / sqrt(where_or_nan(regular, square)), outcome(x, (~regular, Status.SINGULAR))


def normalise_flat(x: Multivector) -> tuple[Multivector, Result]:
    """The nearest motor, line or plane (sphere too): x (x ~x)^(-1/2), for x ~x = s + q with q^2 = 0, q of grade 4.

    The inverse root is (1 - q/(2 s))/sqrt(s), so scale and screw part are both repaired. s is negative for the
    direct objects of CGA. (Point pairs and circles have another q: `blades.project_to_blade`.)
    SINGULAR: no length. IMAGINARY: s has the other sign.
    """
    s, q = norm_squared(x), (x * ~x).grade(4)
    positive = s if x.algebra.is_degenerate or 0 in x.grades else -s
    noise = noise_of_square(x)
    regular = positive > noise
    root = sqrt(where_or_nan(regular, positive))
    correction = 1 - q / (2 * s) if q.terms else x.constant(1)
    return x * correction / root, outcome(x, (positive < -noise, Status.IMAGINARY), (~regular, Status.SINGULAR))


def versor_inverse(x: Multivector) -> tuple[Multivector, Result]:
    """~x/<x ~x>_0: the inverse of blades and of products of vectors."""
    square = norm_squared(x)
    regular = absolute(square) > noise_of_square(x)
    return ~x / where_or_nan(regular, square), outcome(x, (~regular, Status.SINGULAR))


def sandwich(r: Multivector, x: Multivector) -> Multivector:
    """r x ~r: what a unit rotor does to an object."""
    return r >> x


def reflect(x: Multivector, mirror: Multivector) -> tuple[Multivector, Result]:
    """x reflected, or inverted, in a blade that need not be normalized (thesis 1.3.4). SINGULAR: a null blade.

    The sign is such that points of the mirror keep theirs; see `reflect_in_unit`.
    """
    inverse, status = versor_inverse(mirror)
    image = mirror * x * inverse
    return -image if _reverses_points(mirror) else image, status


def reflect_in_unit(x: Multivector, mirror: Multivector) -> Multivector:
    """x reflected in a unit object: P x P (1.3.4) for lines, circles, planes and spheres of CGA; P x ~P in PGA.

    In a point pair of CGA it is -P x P, so that points keep a positive weight there too.
    """
    image = mirror * x * ~mirror
    return -image if _reverses_points(mirror) != (not x.algebra.is_degenerate) else image


def _reverses_points(mirror: Multivector) -> bool:
    """Return whether P x P^-1 changes the sign of points x of the mirror P: direct objects, or built from planes."""
    (k,) = mirror.grades
    p, q, r = mirror.algebra.signature
    return bool((k * (p + q - 1) if r else k + 1) & 1)
