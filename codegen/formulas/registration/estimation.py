"""The motor between models whose objects are matched: steps of Algorithm 1, and rates for descents (thesis 5.3)."""

from __future__ import annotations

from fractions import Fraction

from ...algebra.multivector import Multivector, select, sqrt
from ...trace.derivatives import derivative_formula
from ...trace.outputs import Result, row
from ..objects.blades import norm_squared
from ..objects.conformal import infinity, point
from ..objects.costs import any_rotor, is_plain, magnitude, parallel
from ..products.exponentials import exp_bivector
from ..products.outcome import where_or_nan
from .registration import carriers, center, near_motor, rotor_rates

# -- Algorithm 1 -------------------------------------------------------------------------------------------


def half_step(r: Multivector, x: Multivector, y: Multivector, sign: Multivector) -> Multivector:
    """sqrt(R_m) R, where R_m takes R x ~R to (sign) y: half the way. NaN where they face each other.

    A round goes by its carriers, its center and then its axis: the rotor between two rounds is no motor, and the
    motor next to it does not converge.
    """
    for p, q in zip(carriers(x, x.constant(1)), carriers(y, sign), strict=True):
        r = _half_motor(r, p, q)
    return r


def half_step_of_two(r: Multivector, x: Multivector, y: Multivector, x2: Multivector, y2: Multivector) -> Multivector:
    """The same for x with y, points or spheres, whose axes lead to the centers of another pair x2, y2.

    By themselves they are translated and never turned. NaN where two centers are one.
    """
    ends = [(point(center(a)).grade(1), point(center(b)).grade(1)) for a, b in ((x, x2), (y, y2))]
    (p, along), (q, onto) = ((a, _line(a, b)) for a, b in ends)
    return _half_motor(_half_motor(r, p, q), along, onto)


def _half_motor(r: Multivector, p: Multivector, q: Multivector) -> Multivector:
    """The square root of a motor with <R>_0 >= 0 is next to 1 + R, whose sum with it has no digits to lose."""
    moved = (r >> p).grade(*p.grades)
    whole = any_rotor(moved, q)
    if p.grades != (1,):
        whole = where_or_nan(is_plain(moved, q), p.constant(1)) * whole
    return near_motor(near_motor((1 + whole).grade(0, 2, 4)) * r)


def _line(a: Multivector, b: Multivector) -> Multivector:
    joint = (a ^ b ^ infinity(a)).grade(3)
    length = sqrt(norm_squared(joint) * -1)
    return joint / where_or_nan(length > 0, length)


def change(after: Multivector, before: Multivector) -> Result:
    """Distance of the motor from one estimate to the next from the identity, whatever its sign: |R_s -+ 1|."""
    step = after * ~before
    there, back = magnitude(step - 1), magnitude(step + 1)
    return row([sqrt(select(there < back, there, back))], "change")


# -- descents ----------------------------------------------------------------------------------------------


def motor_rates(b: Multivector) -> tuple[Multivector, Result]:
    """exp(b), and the twists (d exp b) exp(-b), 6 x 6 row by row, in which it moves as each coefficient of b grows."""
    motor = exp_bivector(b)
    rate_of = derivative_formula(exp_bivector, ["b"], "b", is_scalar=False)
    blades = b.algebra.kind("twist").blades
    basis = [b.new({blade: b.ring.constant(Fraction(1))}) for blade in blades]
    twists = [(rate_of(b, e)[0].values[0] * ~motor).grade(2) for e in basis]
    nothing = b.ring.constant(Fraction(0))
    return motor, row([t.new({0: t.terms.get(blade, nothing)}) for t in twists for blade in blades], "twists")


def printed_rates(r: Multivector, x: Multivector, y: Multivector) -> tuple[Result, Result]:
    """The printed cost (5.1) from R x ~R to y or -y, and its gradient by the twist b in exp(b) R."""
    rotor, rates = rotor_rates((r >> x).grade(*x.grades), y)
    error, along = rotor - 1, parallel(rotor)
    cost = norm_squared(error) + norm_squared(along)
    gradient = [2 * (error.scalar_product(~d) + along.scalar_product(~parallel(d))) for d in rates]
    return row([cost], "cost"), row(gradient, "gradient")
