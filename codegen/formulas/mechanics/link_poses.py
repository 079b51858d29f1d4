"""Links of a tree in the world: joints of three rotations, screws between frames, wrenches of loads and of loops.

A pose is the rotor q of a link's frame and the position of its origin. Twists V = w I3 + v n and wrenches
F = f I3 + tau n as in `mechanics`. One text for CGA and PGA.
"""

from __future__ import annotations

from ...algebra.multivector import Multivector
from ...trace.outputs import Result, named, row
from ..motions.flows import renormalize
from ..motions.maps import exponential_motor, small_bend
from ..motions.screws import direction_part
from ..objects.euclidean import attached_part, axes, cross, dot, space
from ..products.frames import matrix_of
from .mechanics import Covector, of_covector, power, screw_of, velocity_at

# -- joints of three rotations, poses and loads ------------------------------------------------------------


def _turned(q: Multivector, phi: Multivector) -> Multivector:
    """q exp(-phi I3/2) of a rotation vector phi."""
    return q * exponential_motor(phi * space(phi))


def ball_rotation(reference: Multivector, phi: Multivector) -> Result:
    """The matrix of x -> q x ~q with q = r exp(-phi I3/2), row by row; r is the rotor where phi is zero."""
    q = _turned(reference, phi)
    matrix = matrix_of(lambda x: (q >> x).grade(1), axes(phi), axes(phi))
    return row([m for entries in matrix for m in entries], "rotation")


def ball_rotor(q: Multivector, reference: Multivector, phi: Multivector) -> Multivector:
    """The rotor of the link behind a ball, from that of its parent."""
    return q * _turned(reference, phi)


def ball_reference(reference: Multivector, phi: Multivector) -> Multivector:
    """r exp(-phi I3/2), one to rounding: the rotor from which coordinates are counted next."""
    return renormalize(_turned(reference, phi))


def ball_rate(phi: Multivector, w: Multivector) -> Multivector:
    """Rate of the coordinates phi, below a full turn, at the angular velocity w along the link's axes (Bortz 1971)."""
    turned = cross(phi, w)
    return w + turned / 2 + small_bend(dot(phi, phi)).value * cross(phi, turned)


def screw_in_frame(q: Multivector, position: Multivector, screw: Multivector) -> Multivector:
    """~M S M of a twist or a wrench, for the frame at a pose M: a rotor and the position of the origin."""
    a, b = direction_part(screw), attached_part(screw)
    return screw_of((~q >> a).grade(1), (~q >> (b + cross(a, position))).grade(1))


def screw_from_frame(q: Multivector, position: Multivector, screw: Multivector) -> Multivector:
    """M S ~M, back from the frame."""
    a, b = (q >> direction_part(screw)).grade(1), (q >> attached_part(screw)).grade(1)
    return screw_of(a, b + cross(position, a))


def wrench_of_powers(powers: Covector) -> Multivector:
    """The wrench with these powers on unit twists, as laws of loads give them."""
    return of_covector(powers)


def joint_wrench(axis: Multivector, rotation: Multivector, advance: Multivector, force: Multivector) -> Multivector:
    """The wrench along a joint's axis that a force of it is: a couple of a rotation, a force of a translation."""
    return screw_of(advance * axis, rotation * axis) * (force / (rotation * rotation + advance * advance))


# -- loops -------------------------------------------------------------------------------------------------
#
# A joint that closes a loop forbids rates e . w + d . v of its second link against its first, at the joint's place p in
# the second link and along axes of the first: the power of the wrench q d ~q I3 + (q e ~q + p x q d ~q) n on the
# difference of their twists.


def point_in_world(q: Multivector, position: Multivector, point: Multivector) -> Multivector:
    """A point of the frame at a pose."""
    return position + (q >> point).grade(1)


def loop_wrench(q: Multivector, angular: Multivector, linear: Multivector, place: Multivector) -> Multivector:
    """The wrench of a row (e, d) of the link with the rotor q, at a place, in the world."""
    force = (q >> linear).grade(1)
    return screw_of(force, (q >> angular).grade(1) + cross(place, force))


def loop_wrench_rate(
    q: Multivector, angular: Multivector, linear: Multivector, place: Multivector, omega: Multivector,
    other_omega: Multivector,
) -> Multivector:  # fmt: skip
    """Its rate, for the twists of both links in the world: the place moves with the second one."""
    w, force = direction_part(omega), (q >> linear).grade(1)
    turned, velocity = cross(w, force), velocity_at(other_omega, place)
    couple = cross(w, (q >> angular).grade(1)) + cross(velocity, force) + cross(place, turned)
    return screw_of(turned, couple)


def loop_errors(
    q: Multivector, position: Multivector, point: Multivector, axis: Multivector, other: Multivector, place: Multivector
) -> tuple[Result, Result, Result]:
    """Gap of a joint's place, tilt of its axis and rotation of its second link, along axes of its first."""
    between = ~q * other
    turn = 2 * between.grade(0) * (between.grade(2) * space(q)).grade(1)
    return (
        named("gap", (~q >> (place - position)).grade(1) - point),
        named("tilt", cross(axis, (between >> axis).grade(1))),
        named("turn", turn),
    )


def screw_power(twist: Multivector, wrench: Multivector) -> Multivector:
    """Power of a wrench on a twist."""
    return power(twist, wrench)
