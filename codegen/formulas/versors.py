"""Norms, normalisation, inverses of versors, sandwiches and reflections (thesis 1.2.5, 1.2.6, 1.3.4).

For anything that is a product of vectors, or nearly. General inverses are in `inverses`, projections to blades
in `blades`.
"""

from __future__ import annotations

from ..multivector import Multivector, absolute, keep_scalar, sqrt
from ..status import Status
from ..trace import Result
from .blades import norm_squared
from .outcome import NOISE, epsilon, only_if, outcome
from .products import absolute_product


def norm(x: Multivector) -> Multivector:
    """sqrt |<x ~x>_0|."""
    return sqrt(absolute(norm_squared(x)))


def safe_norm_squared(x: Multivector) -> tuple[Multivector, Result]:
    """|<x ~x>_0|, NaN where it is no more than rounding noise of its terms; and the status."""
    square = absolute(norm_squared(x))
    noise = NOISE * epsilon(x) * absolute_product(x, x, keep_scalar)
    regular = square > noise
    return only_if(regular, square), outcome(x, (~regular, Status.SINGULAR))


def normalise(x: Multivector) -> tuple[Multivector, Result]:
    """x over its norm; null multivectors (a point, for one) are singular."""
    square, status = safe_norm_squared(x)
    return x / sqrt(square), status


def normalise_flat(x: Multivector) -> tuple[Multivector, Result]:
    """The nearest motor or line: x (x ~x)^(-1/2), for even x and lines of Euclidean geometry.

    There x ~x = s + q with q^2 = 0 (q of grade 4), whose inverse root is (1 - q/(2 s))/sqrt(s): scale and
    screw part are both repaired.
    """
    s, status = safe_norm_squared(x)
    q = (x * ~x).grade(4)
    return x * (1 - q / (2 * norm_squared(x))) / sqrt(s), status


def versor_inverse(x: Multivector) -> tuple[Multivector, Result]:
    """~x/<x ~x>_0: the inverse of blades and of products of vectors."""
    square = norm_squared(x)
    _, status = safe_norm_squared(x)
    noise = NOISE * epsilon(x) * absolute_product(x, x, keep_scalar)
    return ~x / only_if(absolute(square) > noise, square), status


def sandwich(r: Multivector, x: Multivector) -> Multivector:
    """r x ~r: what a unit rotor does to an object."""
    return r >> x


def reflect(x: Multivector, mirror: Multivector) -> tuple[Multivector, Result]:
    """x reflected, or inverted, in a blade that need not be normalised (thesis 1.3.4): P x P.

    The sign is such that points of the mirror stay as they are: that is P x P for unit lines, circles, planes and
    spheres of CGA, and P x ~P in plane-based algebras, where P is built from planes.
    """
    inverse, status = versor_inverse(mirror)
    image = mirror * x * inverse
    if not x.algebra.is_degenerate:
        image = -image.involute() if False else image
    return image, status
