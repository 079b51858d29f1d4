"""Serial chains: joints as screws, the poses that they add up to, and the twists (thesis 7.2 to 7.14).

A pose of a frame is a rotor q and the place p of its origin, R = (1 - p n/2) q: what is far from the world's origin is
then never multiplied by a turn. A joint turns about the unit vector a through its place and advances along it, with
the unit twist S = k (a I3 + (p x a) n) + l a n; it moves what follows by exp(-x S/2). One text for CGA and PGA.
"""

from __future__ import annotations

from ...algebra.multivector import Multivector, cos, select, sin
from ...status import Status
from ...trace.outputs import Result, named
from ..motions.flows import renormalize
from ..motions.motions import translation_of, translator
from ..motions.screws import direction_part
from ..motions.twists import screw_row
from ..objects.euclidean import attached_part, cross, direction_of, dot, euclidean_part, null_vector, space
from ..products.exponentials import log_motor
from ..products.outcome import is_finite, outcome, where_or_nan
from .mechanics import screw_of, to_body_frame

# -- a joint's numbers --------------------------------------------------------------------------------------


def joint(twist: Multivector, near: Multivector) -> tuple[Result, Result, Result, Result, Result]:
    """a, the point of the axis that is nearest to a place, k and l of a twist S.

    For a translation a is its direction, k is zero and the place the one given. INVALID: zero, or not finite.
    """
    m, moment = direction_part(twist), attached_part(twist)
    about = moment - cross(near, m)
    a, inverse = direction_of(m)
    u, moment_inverse = direction_of(moment)
    rotates, translates = inverse > 0, moment_inverse > 0
    nothing = twist.constant(0)
    foot = near + select(rotates, inverse * cross(a, about), nothing)
    finite = is_finite(twist) & is_finite(near)
    valid = where_or_nan(finite & (rotates | translates), twist.constant(1))
    advance = select(rotates, dot(about, a), 1 / where_or_nan(translates, moment_inverse))
    return (
        named("direction", select(rotates, a, u) * valid),
        named("position", foot * valid),
        named("rotation", select(rotates, dot(m, a), nothing) * valid),
        named("advance", advance * valid),
        outcome(twist, (~finite, Status.INVALID), (~rotates & ~translates, Status.INVALID)),
    )


def axis_through(position: Multivector, direction: Multivector) -> tuple[Multivector, Result]:
    """a I3 + (p x a) n of the unit vector a along a direction: a turn counter-clockwise about a line, dually the line.

    INVALID: no direction.
    """
    a, scale = direction_of(direction)
    return screw_of(a, cross(position, a)), outcome(direction, (~(scale > 0), Status.INVALID))


def screw_through(position: Multivector, direction: Multivector, pitch: Multivector) -> tuple[Multivector, Result]:
    """The same with an advance along the line by ``pitch`` for each radian."""
    a, scale = direction_of(direction)
    return screw_of(a, cross(position, a) + pitch * a), outcome(direction, (~(scale > 0), Status.INVALID))


def translation_along(direction: Multivector) -> tuple[Multivector, Result]:
    """a n of the unit vector along a direction. INVALID: no direction."""
    a, scale = direction_of(direction)
    return a * null_vector(a), outcome(direction, (~(scale > 0), Status.INVALID))


# -- along the chain ----------------------------------------------------------------------------------------


def joint_position(
    q: Multivector, position: Multivector, offset: Multivector, axis: Multivector, displacement: Multivector
) -> Multivector:
    """Position of a joint: an offset on, and as far along its axis as it has moved."""
    return position + (q >> (offset + displacement * axis)).grade(1)


def rotate(q: Multivector, axis: Multivector, angle: Multivector) -> Multivector:
    """q exp(-angle a I3/2)."""
    return q * (cos(angle / 2) - sin(angle / 2) * axis * space(q))


def link_direction(q: Multivector, axis: Multivector) -> Multivector:
    """A direction of a link, in the world."""
    return (q >> axis).grade(1)


def frame_pose(
    q: Multivector, position: Multivector, offset: Multivector, rotation: Multivector
) -> tuple[Result, Result]:
    """Pose of a frame that stands an offset on and turned, its rotor one to rounding."""
    return named("rotor", renormalize(q) * rotation), named("position", position + (q >> offset).grade(1))


def compose(q: Multivector, position: Multivector, base: Multivector) -> Multivector:
    """The motor of a pose, place and base added up."""
    return translator(base + position) * q


# -- twists -------------------------------------------------------------------------------------------------


def unit_twist(axis: Multivector, position: Multivector, rotation: Multivector, advance: Multivector) -> Multivector:
    """k (a I3 + (p x a) n) + l a n."""
    return screw_of(rotation * axis, rotation * cross(position, axis) + advance * axis)


def twist_about(angular_velocity: Multivector, velocity: Multivector, position: Multivector) -> Multivector:
    """The twist of a turning, with the velocity of the point at a place."""
    return screw_of(angular_velocity, velocity + cross(position, angular_velocity))


def column(
    axis: Multivector, position: Multivector, reference: Multivector, rotation: Multivector, advance: Multivector
) -> Result:
    """Column of a Jacobian: the turn of a joint's unit twist and its velocity at a place, along the world's axes."""
    return screw_row(unit_twist(axis, position - reference, rotation, advance), "column")


def body_column(
    q: Multivector, axis: Multivector, position: Multivector, reference: Multivector, rotation: Multivector,
    advance: Multivector,
) -> Result:  # fmt: skip
    """The same along the axes of a frame."""
    return screw_row(to_body_frame(q, unit_twist(axis, position - reference, rotation, advance)), "column")


def link_twist(
    omega: Multivector, rate: Multivector, joint: Multivector, speed: Multivector, acceleration: Multivector
) -> tuple[Result, Result]:
    """Twist of a link and its rate, from those of the link before: Omega + S dx (7.13), and dS = S x Omega (7.14)."""
    carried = joint.commutator(omega).grade(2)
    return named("omega", omega + speed * joint), named("rate", rate + acceleration * joint + speed * carried)


# -- back from a pose ---------------------------------------------------------------------------------------


def decompose(r: Multivector, base: Multivector) -> tuple[Result, Result]:
    """Rotor and place of a motor, the place as seen from the base."""
    return named("rotor", euclidean_part(r)), named("position", translation_of(r) - base)


def pose_error(q: Multivector, position: Multivector, goal_rotor: Multivector, goal_position: Multivector) -> Result:
    """Twist from a frame to its goal in a unit of time: w of the shortest rotation, and the path of the frame's origin.

    The motor between both as seen from the frame's origin is (1 - d n/2) Q ~q, Q and -Q one goal. Turn and way are
    taken by themselves, -2 log(Q ~q) and d: then half the square of both together falls along a twist by their plain
    product with it, at any distance, which of the common logarithm holds at the goal alone.
    """
    rotation = goal_rotor * ~q
    nearer = select(rotation.grade(0) < 0, q.constant(-1), q.constant(1))
    return screw_row(-2 * log_motor(nearer * rotation)[0] + (goal_position - position) * null_vector(q), "column")
