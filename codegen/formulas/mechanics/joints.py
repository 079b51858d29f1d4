"""Bodies that joints hold: what the compiled driver of a mechanism calls (thesis 7.3 to 7.6).

Motors take bodies from where they are at the start to where they are now: a joint's object X, the same for both of its
bodies at the start, is R X ~R for each. A motor S of one body as another sees it takes X to where it is seen.
"""

from __future__ import annotations

from ...algebra.multivector import Multivector, select
from ...trace.outputs import Result, row
from ..objects.euclidean import axes
from ..products.exponentials import exp_bivector, log_motor
from ..registration.registration import near_motor
from .mechanics import adjoint, basis_twists, coefficient, velocity_at


def transform_object(s: Multivector, x: Multivector) -> Result:
    """S X ~S, on the blades of X."""
    moved = s >> x
    return row([coefficient(moved, blade) for blade in x.terms], "object")


def compose(r: Multivector, s: Multivector) -> Multivector:
    """R S: a body whose parent is at R, and which its parent sees at S."""
    return near_motor(r * s)


def relative(r: Multivector, s: Multivector) -> Multivector:
    """~R S."""
    return near_motor(~r * s)


def adjoint_matrix(r: Multivector) -> Result:
    """The matrix of T -> R T ~R on twists, row by row."""
    return adjoint(~r)


def move_by_twist(omega: Multivector, s: Multivector) -> Multivector:
    """exp(-Omega/2) S: moved by a twist for a unit of time."""
    return near_motor(exp_bivector(-omega / 2) * s)


def twist_between(r: Multivector, target: Multivector) -> Multivector:
    """The twist that takes R to a target in a unit of time, the short way: target = exp(-Omega/2) R."""
    motor = target * ~r
    nearer = select(motor.grade(0) < 0, r.constant(-1), r.constant(1))
    return -2 * log_motor(nearer * motor)[0].grade(2)


def point_rates(position: Multivector) -> Result:
    """Velocities of a point for each unit twist, one after the other."""
    return row(
        [
            v.scalar_product(a)
            for v in (velocity_at(e, position) for e in basis_twists(position))
            for a in axes(position)
        ]
    )
