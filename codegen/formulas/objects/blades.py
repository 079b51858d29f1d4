"""The blade manifold: norms, normalization, and the projection of a pure-grade multivector to the nearest blade."""

from __future__ import annotations

from ...algebra.multivector import Mask, Multivector, absolute, select, sqrt
from ...status import Status
from ...trace.derivatives import derivative_formula
from ...trace.outputs import Result
from ..products.outcome import NOISE, epsilon, is_finite, outcome, where_or_nan
from ..products.sizes import displace, product_sizes, sizes

Checked = tuple[Multivector, Result]


def norm_squared(x: Multivector) -> Multivector:
    """<x ~x>_0."""
    return x.scalar_product(~x)


def principal_root(s0: Multivector, s4: Multivector, norm: Multivector) -> tuple[Multivector, Multivector]:
    """Factors (p, q) with sqrt(s0 + s4) = p + q s4, for norm = [[s0 + s4]] (thesis 4.10).

    p^2 = (s0 + norm)/2, q = 1/(2 p). For s0 < 0 that sum cancels: then q is found first, from
    p^2 = s4^2/(2 (norm - s0)), and neither branch subtracts equal numbers.
    """
    direct = sqrt((norm + s0) / 2)
    other = sqrt((norm - s0) / 2)
    root = sqrt(-(s4 * s4).grade(0))
    positive = s0 >= 0
    p = select(positive, direct, root / (2 * other))
    q = select(positive, 1 / (2 * direct), other / root)
    return p, q


def blade_projector(x: Multivector) -> Multivector:
    """Projector S with S x a unit blade, for a pure-grade x (thesis 3.5, 4.11, 4.12).

    Sigma = -x ~x = s0 + s4; S is the conjugate of the principal square root of Sigma over its norm. Where s4^2
    vanishes by the blades of x (lines, planes, spheres), that is (1 - s4/(2 s0))/sqrt(s0).
    """
    sigma = -(x * ~x)
    s0, s4 = sigma.grade(0), sigma.grade(4)
    if not (s4 * s4).terms:
        return (1 - s4 / (2 * s0)) / sqrt(s0)
    norm = sqrt(s0 * s0 - s4 * s4)
    p, q = principal_root(s0, s4, norm)
    return (p - q * s4) / norm


def project_to_blade(x: Multivector) -> Multivector:
    """S x: the unit blade that a pure-grade x stands for; for a sum of points the point at their mean (3.1)."""
    if x.grades == (1,):
        weight = x | x.basis("ni")
        return -(x * x.basis("ni") * x).grade(1) / (2 * weight * weight)
    return blade_projector(x) * x


def project_sum(x: Multivector, written: Multivector) -> Checked:
    """S x for a sum x; ``written`` are the sums of the absolute values of its terms, the scale of its rounding errors.

    IMAGINARY: Sigma has no real root, so that x stands for no real object. SINGULAR: x has no length left, as L and
    -L together (or two planes of equal weight: then no blade is nearest). INVALID: x is not finite.
    """
    return checked_sum(x, cases_of_sum(x, written), project_to_blade(x))


def project_far_sum(x: Multivector, written: Multivector, distance: Multivector) -> Checked:
    """`project_sum` in coordinates about a local origin: ``distance`` is how far away the terms were given."""
    return checked_sum(x, cases_of_sum(x, written, distance), project_to_blade(x))


def project_rate(x: Multivector, dx: Multivector) -> Checked:
    """Derivative of S x along dx (4.26 to 4.30), generated from `project_to_blade`; statuses as of `project_sum`."""
    (rate,) = derivative_formula(project_to_blade, ["x"], "x", is_scalar=False)(x, dx)
    return checked_sum(x, cases_of_sum(x, x), rate.value)


def written_size(*terms: Multivector) -> Multivector:
    """Sums of the absolute values of the coefficients of several multivectors, blade by blade."""
    first = terms[0]
    return first.sum(x.new({b: x.ring.apply("abs", c) for b, c in x.terms.items()}) for x in terms)


def cases_of_sum(x: Multivector, written: Multivector, distance: Multivector | None = None) -> tuple[Mask, Mask]:
    """Masks of sums with a projection, and of imaginary ones: decided on what rounding may have left of each sum.

    x = X1 + X2 with commuting blades of squares a >= b: s0 = a + b, s4^2 = 4 a b, norm = a - b. The projection is
    X1/sqrt(a): a must be positive, and larger than b. Where s0 < 0 only s4^2 < 0 tells that a is positive.
    """
    unit = NOISE * epsilon(x)
    terms = sizes(written)
    if x.grades == (1,):
        weight = absolute(x | x.basis("ni"))
        return weight > unit * terms[0], weight < 0  # the mean of points is never imaginary
    sigma = -(x * ~x)
    s0, s4 = sigma.grade(0), sigma.grade(4)
    noise = product_sizes(sizes(x, unit, terms), terms if distance is None else displace(terms, distance))
    noise0 = unit * noise[1]
    positive, negative = s0 > noise0, s0 < -noise0
    square = (s4 * s4).grade(0)
    if not square.terms:
        return positive, negative
    noise_of_square = 2 * unit * product_sizes(sizes(s4), noise)[1]
    resolved = square < -noise_of_square
    isolated = s0 * s0 - square > 2 * s0 * noise0 + noise_of_square
    return (positive & isolated) | (~positive & resolved), negative & ~resolved


def checked_sum(x: Multivector, cases: tuple[Mask, Mask], value: Multivector) -> Checked:
    """The value where x has a projection, with the status of its case; INVALID where anything is not finite."""
    regular, imaginary = cases
    value = value * where_or_nan(regular, x.constant(1))
    status = outcome(
        x,
        (~is_finite(x), Status.INVALID),
        (imaginary, Status.IMAGINARY),
        (~regular, Status.SINGULAR),
        (~is_finite(value), Status.INVALID),
    )
    return value, status
