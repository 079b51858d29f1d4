"""Paths through poses: screw motions, means, and splines whose pieces are polynomials of the logarithm.

A piece starts at a pose x: x exp(-xi(u)/2), xi(u) = c_1 u + .. + c_5 u^5, 0 <= u <= 1, where u runs in ``length`` units
of time. The body's twist V and its rate A follow from xi' and xi'', and at the ends of a piece the other way round, by
the exponential's Jacobian and the rate of its inverse.
"""

from __future__ import annotations

from typing import Annotated

from ...algebra.multivector import Multivector, absolute
from ...status import Status
from ...trace.derivatives import tangent_formula
from ...trace.outputs import Result
from ...trace.rows import BladesOf
from ..motions.maps import FULL_TURN_SQUARED, chart_rate_exponential, exponential_motor, square_parts
from ..motions.motions import translation_of, translator
from ..motions.twists import ScrewRow, screw_of_row, screw_row
from ..objects.euclidean import euclidean_part
from ..products.exponentials import exp_bivector, log_motor
from ..products.outcome import NOISE, epsilon, is_finite, outcome, where_or_nan
from .pose_jacobians import jacobian_on
from .poses import finite_pose, shortest

#: Degree of a piece.
DEGREE = 5
#: c_1 .. c_5 of a piece, twists (w, v).
Coefficients = Annotated[tuple[Multivector, ...], BladesOf("twist")]

_rate_tangent = tangent_formula(chart_rate_exponential, __name__)


# -- between two poses -------------------------------------------------------------------------------------


def screw_path(x: Multivector, y: Multivector, t: Multivector) -> tuple[Multivector, Result]:
    """x (~x y)^t by the smaller angle: a screw motion. NOT_UNIQUE: half a turn to rounding, either way."""
    relative = (~x * y).grade(0, 2, 4)
    b, _ = log_motor(shortest(relative))
    either = absolute(relative.grade(0)) <= NOISE * epsilon(x)
    return finite_pose(x * exp_bivector(t * b), (either, Status.NOT_UNIQUE))


def straight_path(x: Multivector, y: Multivector, t: Multivector) -> tuple[Multivector, Result]:
    """The same rotation, of the body about the origin of its frame, which goes straight on."""
    r, s = euclidean_part(x), euclidean_part(y)
    relative = (~r * s).grade(0, 2)
    b, _ = log_motor(shortest(relative))
    either = absolute(relative.grade(0)) <= NOISE * epsilon(x)
    place = (1 - t) * translation_of(x) + t * translation_of(y)
    return finite_pose(translator(place) * (r * exp_bivector(t * b)), (either, Status.NOT_UNIQUE))


def relative_twist(x: Multivector, y: Multivector) -> tuple[Result, Result]:
    """The row of phi with x exp(-phi/2) = y by the smaller angle. NOT_UNIQUE: half a turn to rounding."""
    relative = (~x * y).grade(0, 2, 4)
    b, _ = log_motor(shortest(relative))
    finite = is_finite(b)
    either = absolute(relative.grade(0)) <= NOISE * epsilon(x)
    return screw_row(-2 * b, "twist"), outcome(x, (~finite, Status.INVALID), (either, Status.NOT_UNIQUE))


def moved_by(x: Multivector, twist: ScrewRow) -> Multivector:
    """x exp(-phi/2)."""
    return (x * exponential_motor(screw_of_row(twist))).grade(0, 2, 4)


# -- pieces of splines -------------------------------------------------------------------------------------


def _piece(c: tuple[Multivector, ...], u: Multivector) -> tuple[Multivector, Multivector, Multivector]:
    """xi, and its first and second derivative."""
    terms = [screw_of_row(ScrewRow(*c[6 * k : 6 * k + 6])) for k in range(DEGREE)]
    value = rate = second = u.new({})
    for k, term in reversed(list(enumerate(terms, 1))):
        value = (value + term) * u
        rate = rate * u + k * term
        if k > 1:
            second = second * u + k * (k - 1) * term
    return value, rate, second


def piece_pose(x: Multivector, c: Coefficients, u: Multivector) -> tuple[Multivector, Result]:
    """The pose of a piece that starts at x."""
    return finite_pose((x * exponential_motor(_piece(c, u)[0])).grade(0, 2, 4))


def piece_twist(c: Coefficients, u: Multivector, length: Multivector) -> Result:
    """The body's twist, of its own frame."""
    value, rate, _ = _piece(c, u)
    return screw_row(jacobian_on(value, rate, -1) / length, "twist")


def piece_twist_rate(c: Coefficients, u: Multivector, length: Multivector) -> tuple[Result, Result]:
    """The rate of the body's twist. SINGULAR: the piece has turned by 2 pi from its start."""
    value, rate, second = _piece(c, u)
    twist = jacobian_on(value, rate, -1)
    _, bent = _rate_tangent(value, twist, rate, twist.new({b: twist.constant(0).scalar() for b in twist.terms}))
    regular = square_parts(value)[0] < FULL_TURN_SQUARED
    scale = where_or_nan(regular, 1 / (length * length))
    acceleration = jacobian_on(value, second - bent.value, -1) * scale
    return screw_row(acceleration, "acceleration"), outcome(u, (~regular, Status.SINGULAR))


def end_rates(twist: ScrewRow, velocity: ScrewRow, acceleration: ScrewRow) -> tuple[Result, Result]:
    """xi' and xi'' where xi is a twist, and the body moves with a twist that has a rate."""
    phi, v, a = (screw_of_row(x) for x in (twist, velocity, acceleration))
    rate = chart_rate_exponential(phi, v)
    _, second = _rate_tangent(phi, v, rate, a)
    return screw_row(rate, "rate"), screw_row(second.value, "second")


def end_acceleration(twist: ScrewRow, velocity: ScrewRow, second: ScrewRow) -> Result:
    """The rate of the body's twist where xi is a twist, of the body's twist and xi''."""
    phi, v = screw_of_row(twist), screw_of_row(velocity)
    rate = chart_rate_exponential(phi, v)
    _, bent = _rate_tangent(phi, v, rate, v.new({b: v.constant(0).scalar() for b in v.terms}))
    return screw_row(jacobian_on(phi, screw_of_row(second) - bent.value, -1), "acceleration")
