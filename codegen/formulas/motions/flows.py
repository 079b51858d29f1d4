"""Exact and classical flows of one rigid body: free flight, turning by itself, parts of a split Hamiltonian."""

from __future__ import annotations

from ...algebra.multivector import Multivector, sqrt
from ...trace.outputs import Result, named, row
from ..mechanics.mechanics import Covector, componentwise_product, covector, of_covector
from ..objects.euclidean import attached_part, cross, dot, euclidean_part, null_vector, space
from ..products.exponentials import exp_bivector
from .motions import translation_of, translator
from .screws import direction_part

# -- a free body in a field that is the same everywhere ----------------------------------------------------
#
# Position and rotation separate there: R = (1 - x n/2) q, and the center of mass has a path of its own.


def rotor_rate(q: Multivector, w: Multivector) -> Multivector:
    """dq = -q w I3/2, w along the body's axes."""
    return -(q * w * space(q)) / 2


def spin_rate(w: Multivector, moments: Multivector, inverse: Multivector) -> Multivector:
    """dw with I dw = (I w) x w, along the principal axes."""
    turning = cross(componentwise_product(moments, w), w)
    return componentwise_product(inverse, turning)


def lever_rate(q: Multivector, center: Multivector, weight: Multivector, inverse: Multivector) -> Multivector:
    """Contribution of a force that is the same all over the world to dw of a body that turns about a point."""
    return componentwise_product(inverse, cross(center, (~q >> weight).grade(1)))


def renormalize(q: Multivector) -> Multivector:
    """q (3 - q ~q)/2: the unit rotor next to one whose norm is nearly 1, to second order."""
    return q * ((3 - q.scalar_product(~q)) / 2)


def flight(r: Multivector, omega: Multivector) -> tuple[Result, Result, Result, Result]:
    """Rotor, place, velocity in the world and spin of a state."""
    rotor = euclidean_part(r)
    velocity = (rotor >> attached_part(omega)).grade(1)
    return (
        named("rotor", rotor),
        named("position", translation_of(r)),
        named("velocity", velocity),
        named("spin", direction_part(omega)),
    )


def state_after_flight(
    q: Multivector, position: Multivector, velocity: Multivector, spin: Multivector
) -> tuple[Result, Result]:
    """The state that `flight` takes apart; the rotor need not quite be one."""
    rotor = q / sqrt(q.scalar_product(~q))
    omega = spin * space(q) + (~rotor >> velocity).grade(1) * null_vector(q)
    return named("motor", translator(position) * rotor), named("twist", omega)


# -- flows of a split Hamiltonian --------------------------------------------------------------------------
#
# The state is the motor of a frame at the center of mass, or at the point that is held, along the principal axes there,
# with the linear momentum p and the angular momentum L about the frame's origin, both along the world's axes.


def parts_of_momentum(r: Multivector, powers: Covector) -> tuple[Result, Result]:
    """p and L, or force and moment, of what has these powers in the body's frame."""
    wrench = of_covector(powers)
    rotor = euclidean_part(r)
    p, angular = ((rotor >> x).grade(1) for x in (direction_part(wrench), attached_part(wrench)))
    return named("linear", p), named("angular", angular)


def momentum_row(r: Multivector, linear: Multivector, angular: Multivector) -> Result:
    """Powers of p and L on unit twists of the body's frame."""
    turn = ~euclidean_part(r)
    p, moment = ((turn >> x).grade(1) for x in (linear, angular))
    return row(covector(p * space(p) + moment * null_vector(p)), "momentum")


def translate(r: Multivector, displacement: Multivector) -> Multivector:
    """The body moved along."""
    return (translator(displacement) * r).grade(0, 2, 4)


def central_flow(r: Multivector, angular: Multivector, weight: Multivector) -> Multivector:
    """Flow of L^2 weight/2: every body turns about L, at a rate that is constant."""
    return r * exp_bivector(-weight * _in_body(r, angular) * space(r) / 2)


def axial_flow(r: Multivector, angular: Multivector, axis: Multivector, weight: Multivector) -> Multivector:
    """Flow of (L . a)^2 weight/2 for a unit vector a of the body: it turns about a."""
    rate = weight * dot(_in_body(r, angular), axis)
    return r * exp_bivector(-rate * axis * space(r) / 2)


def _in_body(r: Multivector, vector: Multivector) -> Multivector:
    return (~euclidean_part(r) >> vector).grade(1)
