"""Rotations about three axes, one after the other, and their angles; all sequences of Euler angles are one text."""

from __future__ import annotations

from typing import NamedTuple

from ...algebra.multivector import Multivector, atan2, cos, select, sin
from ...status import Status
from ...trace.outputs import Result, row
from ..motions.motions import translator
from ..motions.screws import direction_part
from ..objects.euclidean import cross, dot, euclidean_part, length, space
from ..products.outcome import NOISE, as_computed, epsilon, is_finite, outcome, where_or_nan
from .poses import Pose, finite_pose


class EulerAngles(NamedTuple):
    """Angles about three axes, the first rotation first."""

    first: Multivector
    second: Multivector
    third: Multivector


def euler_pose(angles: EulerAngles, a: Multivector, b: Multivector, c: Multivector, position: Multivector) -> Pose:
    """The pose of rotations about the unit axes a, b, c of the world, one after the other. INVALID: not finite."""
    turn = _turn(c, angles.third) * (_turn(b, angles.second) * _turn(a, angles.first))
    return finite_pose(translator(position) * turn)


def _turn(axis: Multivector, angle: Multivector) -> Multivector:
    return cos(angle / 2) - sin(angle / 2) * (axis * space(axis))


def euler_angles(x: Multivector, a: Multivector, b: Multivector, c: Multivector) -> tuple[Result, Result]:
    """Angles of `euler_pose` for unit axes a and b that are perpendicular, and c = a or c = +-(a x b).

    The image of a under R gives the third and the second angle; the first is that of the rotation about a which the
    two leave of R, so that the three together are R to rounding, near gimbal lock too. There, where the image of a is
    along c to rounding, the third angle is 0, NOT_UNIQUE. INVALID: not finite.
    """
    r = euclidean_part(x)
    image = as_computed((r >> a).grade(1))
    normal = cross(a, b)
    proper, side = dot(a, c) > 0, dot(normal, c)
    first, second = select(proper, -normal, a), select(proper, b, side * b)
    u, v = dot(image, first), dot(image, second)
    across, along = length(u * a + v * b), dot(image, select(proper, a, -side * c))
    free = across > NOISE * epsilon(x)
    nothing = x.constant(0)
    third = select(free, atan2(v, u), nothing)
    middle = select(proper, atan2(across, along), atan2(along, across))
    rest = _turn(b, -middle) * (_turn(c, -third) * r)
    s, k = dot(quaternion_vector(rest), a), rest.grade(0)
    sign = select(k < 0, x.constant(-1), x.constant(1))
    beginning = 2 * atan2(sign * s, sign * k)
    finite = is_finite(r)
    code = outcome(x, (~finite, Status.INVALID), (~free, Status.NOT_UNIQUE))
    known = where_or_nan(finite, x.constant(1))
    return row([beginning * known, middle * known, third * known], "angles"), code


def quaternion_vector(r: Multivector) -> Multivector:
    """v of a rotor w - v I3."""
    return -direction_part(r.grade(2))
