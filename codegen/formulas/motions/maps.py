"""Charts of the motions: maps from twist bivectors to motors, and the rates that belong to them (thesis 6.11).

One text for CGA and PGA. A twist is phi = w I3 + v n, with dR = -Omega_w R/2 = -R Omega_b/2. Each map has a motor and
rates for the world's and for the body's twist. The charts of the integrators are scaled alike: R (1 - phi/2 + ..).
"""

from __future__ import annotations

from fractions import Fraction
from functools import cache
from math import comb, factorial
from typing import NamedTuple

from ...algebra.multivector import Multivector, absolute, sqrt, stumpff1, stumpff2, stumpff3
from ...status import Status
from ...trace.outputs import Result
from ..objects.euclidean import attached_part, euclidean_part, null_vector
from ..products.exponentials import exp_bivector
from ..products.outcome import NOISE, epsilon, outcome, where_or_nan

Rate = tuple[Multivector, Result]
#: 4 pi^2, where the exponential map is first singular, to 40 digits: coefficients are differences of its powers.
FULL_TURN_SQUARED = Fraction(6283185307179586476925286766559005768394, 10**39) ** 2


def square_parts(phi: Multivector) -> tuple[Multivector, Multivector]:
    """w and q of phi^2 = -w + q: w the square of the angle, q of grade 4 (q^2 = 0) made by the advance."""
    square = phi * phi
    return -square.grade(0), square.grade(4)


# -- exponential: R = exp(-phi/2) ---------------------------------------------------------------------------
#
# With A = phi x . the world's twist is (1 - exp(-A))/A dphi, so that dphi = (A/2 coth(A/2) +- A/2) Omega. A acts as a
# cross product of screws: A^2 = -(w - q) on all that it does not annul. So the even part is 1 + k(w - q) A^2 with
# k(w - q) = k(w) - q k'(w): two commutators where (6.24) takes four, and no difference of large terms. The forms of
# the thesis are in `map_forms`.


class Bend(NamedTuple):
    """k(w) = (1 - h cot h)/w with h = sqrt(w)/2, the share of A^2 in the rate, and its derivative k'(w)."""

    value: Multivector
    slope: Multivector
    status: Result


def bend(w: Multivector) -> Bend:
    """k and k' at every angle: k = (c2 - c3)/(4 c1) with Stumpff functions at w/4, whose differences lose no digits.

    SINGULAR: full turns, where c1 = sin h/h vanishes to rounding, and with it the rate of the twists across.
    """
    z = w / 4
    c1, c3 = stumpff1(z), stumpff3(z)
    regular = absolute(c1) > NOISE * epsilon(w)
    per_sine = 1 / where_or_nan(regular, c1)
    value = (stumpff2(z) - c3) * per_sine
    higher = _stumpff4(z) - _stumpff5(z)
    slope = ((3 * higher - c3) * per_sine + value * value) / 32
    return Bend(value / 4, slope, outcome(w, (~regular, Status.SINGULAR)))


def _stumpff4(w: Multivector) -> Multivector:
    return w.new({0: w.ring.apply("stumpff4", w.scalar())})


def _stumpff5(w: Multivector) -> Multivector:
    return w.new({0: w.ring.apply("stumpff5", w.scalar())})


#: Poles of k that are split off its series below: with two, the rest converges like 9^-n up to the full turn.
POLES = 2
#: Terms of the rest: at the full turn the last one is 1e-17 of the sum.
TERMS = 18


@cache
def _regular_terms() -> tuple[Fraction, ...]:
    """|B_2n|/(2n)! - sum_m 2/(4 pi^2 m^2)^n, n = 1, 2, ..: Taylor terms of k less its first poles, as doubles."""
    bernoulli = [Fraction(1)]
    for n in range(1, 2 * TERMS + 1):
        bernoulli.append(-sum((comb(n + 1, k) * bernoulli[k] for k in range(n)), Fraction(0)) / (n + 1))
    poles = [FULL_TURN_SQUARED * m * m for m in range(1, POLES + 1)]
    terms = (
        abs(bernoulli[2 * n]) / factorial(2 * n) - sum((2 / pole**n for pole in poles), Fraction(0))
        for n in range(1, TERMS + 1)
    )
    return tuple(Fraction(float(term)) for term in terms)


def small_bend(w: Multivector) -> Bend:
    """k and k' up to the full turn without a root or a sine: k = sum over m of 2/(4 pi^2 m^2 - w), all terms positive.

    The first poles as they are, the rest by its series: exact to rounding for 0 <= w < 4 pi^2, useless beyond.
    """
    terms = _regular_terms()
    slopes = tuple(n * c for n, c in enumerate(terms))[1:]
    near, far = FULL_TURN_SQUARED - w, 4 * FULL_TURN_SQUARED - w
    inverse = 1 / (near * far)
    first, second = far * inverse, near * inverse
    value = 2 * (first + second) + polynomial(terms, w)
    slope = 2 * (first * first + second * second) + polynomial(slopes, w)
    return Bend(value, slope, outcome(w))


def polynomial(terms: tuple[Fraction, ...], x: Multivector) -> Multivector:
    """sum terms[n] x^n, even and odd powers side by side: half the waiting of Horner's rule."""
    square = x * x
    halves = []
    for part in (terms[0::2], terms[1::2]):
        total = x.constant(part[-1])
        for c in reversed(part[:-1]):
            total = total * square + c
        halves.append(total)
    return halves[0] + x * halves[1]


def exponential_motor(phi: Multivector) -> Multivector:
    """exp(-phi/2)."""
    return exp_bivector(-phi / 2)


def exponential_rate_world(phi: Multivector, omega: Multivector) -> Rate:
    """dphi with exp(-phi/2) moving at the world's twist omega; (6.24) in two commutators. SINGULAR: a full turn."""
    k = bend(square_parts(phi)[0])
    return _exponential_rate(phi, omega, 1, k), k.status


def exponential_rate_body(phi: Multivector, omega: Multivector) -> Rate:
    """The same for the body's twist."""
    k = bend(square_parts(phi)[0])
    return _exponential_rate(phi, omega, -1, k), k.status


def _exponential_rate(phi: Multivector, omega: Multivector, side: int, k: Bend) -> Multivector:
    _, q = square_parts(phi)
    turned = phi.commutator(omega)
    twice = phi.commutator(turned)
    return omega + side * turned / 2 + k.value * twice - k.slope * (q * twice).grade(2)


# -- Bortz: the exponential on orientations, the position beside it ------------------------------------------


def bortz_motor(phi: Multivector) -> Multivector:
    """(1 - v n/2) exp(-w I3/2) of phi = w I3 + v n: a rotation vector and the place of the origin."""
    turn, shift = _rotation_and_translation(phi)
    return (1 - shift / 2) * exponential_motor(turn)


def bortz_rate_world(phi: Multivector, omega: Multivector) -> Rate:
    """The Bortz equation for the rotation, and the velocity of the origin's image, v + w x place."""
    turn, shift = _rotation_and_translation(phi)
    spin, velocity = _rotation_and_translation(omega)
    k = bend(square_parts(turn)[0])
    return _exponential_rate(turn, spin, 1, k) + velocity + shift.commutator(spin), k.status


def bortz_rate_body(phi: Multivector, omega: Multivector) -> Rate:
    """The same for the body's twist, whose velocity is turned into the world."""
    rotation, _ = _rotation_and_translation(phi)
    k = bend(square_parts(rotation)[0])
    return _bortz_rate_body(rotation, omega, k), k.status


def _bortz_rate_body(rotation: Multivector, omega: Multivector, k: Bend) -> Multivector:
    spin, velocity = _rotation_and_translation(omega)
    return _exponential_rate(rotation, spin, -1, k) + (exponential_motor(rotation) >> velocity)


def _rotation_and_translation(phi: Multivector) -> tuple[Multivector, Multivector]:
    """w I3 and v n."""
    return euclidean_part(phi), attached_part(phi) ^ null_vector(phi)


# -- Cayley: R = (1 - phi)/(1 + phi), the tangent of a quarter of the angle ----------------------------------


def cayley_motor(phi: Multivector) -> Multivector:
    """(1 - phi)(1 + phi)^-1 = (1 - phi)^2 (1 + w - q)^-1, near exp(-2 phi): a full turn is at infinity (6.26)."""
    w, q = square_parts(phi)
    inverse = 1 / (1 + w)
    return ((1 - w) * inverse + q * (2 * inverse * inverse)) - phi * (2 * inverse) - q * phi * (2 * inverse * inverse)


def cayley_rate_world(phi: Multivector, omega: Multivector) -> Multivector:
    """(1 + phi) omega (1 - phi)/4 (6.27)."""
    return _two_sided(phi, omega) / 4


def cayley_rate_body(phi: Multivector, omega: Multivector) -> Multivector:
    """(1 - phi) omega (1 + phi)/4."""
    return _two_sided(-phi, omega) / 4


def _two_sided(phi: Multivector, omega: Multivector) -> Multivector:
    """(1 + phi) omega (1 - phi), of grade 2 as its reverse shows."""
    return omega + 2 * phi.commutator(omega) - (phi * omega * phi).grade(2)


# -- outer exponential: the tangent of half the angle --------------------------------------------------------


def outer_motor(phi: Multivector) -> Multivector:
    """(1 + phi + phi ^ phi/2)/sqrt(1 + w), near exp(phi): half a turn is at infinity (6.28)."""
    w, q = square_parts(phi)
    return (1 + phi + q / 2) / sqrt(1 + w)


def outer_rate_world(phi: Multivector, omega: Multivector) -> Multivector:
    """-(omega + omega x phi + omega q/2 - (omega . phi) phi)/2: (6.29) without a root or a division."""
    return -_outer_rate(phi, omega, 1) / 2


def outer_rate_body(phi: Multivector, omega: Multivector) -> Multivector:
    """-(omega - omega x phi + omega q/2 - (omega . phi) phi)/2."""
    return -_outer_rate(phi, omega, -1) / 2


def _outer_rate(phi: Multivector, omega: Multivector, side: int) -> Multivector:
    _, q = square_parts(phi)
    lifted = (omega * q).grade(2) / 2
    return omega + side * omega.commutator(phi) + lifted - omega.scalar_product(phi) * phi


# -- charts of the integrators: R = r (1 - phi/2 + ..), dphi = omega + .., omega the body's twist --------------


def moved_exponential(r: Multivector, phi: Multivector) -> Multivector:
    """r exp(-phi/2)."""
    return r * exponential_motor(phi)


def moved_bortz(r: Multivector, phi: Multivector) -> Multivector:
    """r (1 - v n/2) exp(-w I3/2)."""
    return r * bortz_motor(phi)


def moved_cayley(r: Multivector, phi: Multivector) -> Multivector:
    """r (1 - phi/4)/(1 + phi/4)."""
    return r * cayley_motor(phi / 4)


def moved_outer(r: Multivector, phi: Multivector) -> Multivector:
    """r times the outer exponential of -phi/2."""
    return r * outer_motor(-phi / 2)


def chart_rate_exponential(phi: Multivector, omega: Multivector) -> Multivector:
    """`exponential_rate_body` for angles below a full turn, at the cost of one division."""
    return _exponential_rate(phi, omega, -1, small_bend(square_parts(phi)[0]))


def chart_rate_truncated(phi: Multivector, omega: Multivector) -> Multivector:
    """omega - A omega/2 + A^2 omega/12, the same but for A^4 omega/720: all that a method of order 4 needs."""
    turned = phi.commutator(omega)
    return omega - turned / 2 + phi.commutator(turned) / 12


def chart_rate_bortz(phi: Multivector, omega: Multivector) -> Multivector:
    """`bortz_rate_body` for angles below a full turn."""
    turn, _ = _rotation_and_translation(phi)
    return _bortz_rate_body(turn, omega, small_bend(square_parts(turn)[0]))


def chart_rate_cayley(phi: Multivector, omega: Multivector) -> Multivector:
    """(1 - phi/4) omega (1 + phi/4)."""
    return _two_sided(-phi / 4, omega)


def chart_rate_outer(phi: Multivector, omega: Multivector) -> Multivector:
    """The rate of the outer exponential's -phi/2, times -2."""
    return _outer_rate(-phi / 2, omega, -1)
