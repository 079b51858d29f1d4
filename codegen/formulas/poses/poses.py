"""Poses as quaternions, dual quaternions, matrices and rotation vectors, and back; what poses do to points.

A pose is a unit motor x = (1 - t n/2) R with rotor R and position t. A quaternion w + x i + y j + z k is the rotor
w - v I3, v = (x, y, z); the dual unit is n I3, which commutes with all rotors.
"""

from __future__ import annotations

from typing import NamedTuple

from ...algebra.multivector import Mask, Multivector, absolute, select, sqrt
from ...status import Status
from ...trace.outputs import Result, named, row
from ..motions.motions import motor_to_matrix, rotor_from_columns, translation_of, translator
from ..motions.screws import direction_part
from ..objects.euclidean import (
    attached_part,
    coordinates,
    cross,
    dot,
    euclidean_part,
    null_vector,
    space,
    vector,
)
from ..products.exponentials import exp_bivector, log_motor
from ..products.frames import reciprocal_vectors
from ..products.outcome import as_computed, epsilon, is_finite, outcome, size, where_or_nan

#: Units of roundoff by which squares and products of what is unit and orthogonal may be off: those of kinds.
UNIT = 4096
#: Newton steps to the nearest rotation: singular values between 1/4 and 4 are 1 to rounding after these.
POLAR_STEPS = 7

Pose = tuple[Multivector, Result]


class Quaternion(NamedTuple):
    """w + x i + y j + z k."""

    w: Multivector
    x: Multivector
    y: Multivector
    z: Multivector


class DualQuaternion(NamedTuple):
    """r + d eps of two quaternions."""

    rw: Multivector
    rx: Multivector
    ry: Multivector
    rz: Multivector
    dw: Multivector
    dx: Multivector
    dy: Multivector
    dz: Multivector


class PoseMatrix(NamedTuple):
    """The first three rows of a homogeneous matrix."""

    r11: Multivector
    r12: Multivector
    r13: Multivector
    t1: Multivector
    r21: Multivector
    r22: Multivector
    r23: Multivector
    t2: Multivector
    r31: Multivector
    r32: Multivector
    r33: Multivector
    t3: Multivector


# -- quaternions -------------------------------------------------------------------------------------------


def rotor_of_quaternion(w: Multivector, x: Multivector, y: Multivector, z: Multivector) -> Multivector:
    """w - v I3."""
    return w - vector((x, y, z)) * space(w)


def quaternion_of_rotor(r: Multivector) -> list[Multivector]:
    """w, x, y, z of w - v I3."""
    return [r.grade(0), *coordinates(-direction_part(r.grade(2)))]


def pose_of_quaternion(q: Quaternion, position: Multivector) -> Pose:
    """The pose of a unit quaternion and a position. INVALID: not finite, or not unit to rounding."""
    r = as_computed(rotor_of_quaternion(*q))
    square = r.scalar_product(~r)
    error = absolute(square - 1)
    factor = select(error <= 4 * epsilon(r), r.constant(1), (3 - square) / 2)
    return finite_pose(translator(position) * (r * where_or_nan(error <= UNIT * epsilon(r), factor)))


def finite_pose(x: Multivector, *cases: tuple[Mask, Status]) -> Pose:
    """x and its status: one of these cases, or INVALID and NaN all over where it is not finite."""
    finite = is_finite(x)
    return x * where_or_nan(finite, x.constant(1)), outcome(x, *cases, (~finite, Status.INVALID))


def pose_of_any_quaternion(q: Quaternion, position: Multivector) -> Pose:
    """The same of a quaternion of any length. SINGULAR: zero. INVALID: not finite."""
    r = rotor_of_quaternion(*q)
    written = size(r)
    nothing = written <= 0
    r = as_computed(r / where_or_nan(~nothing, written))
    unit = r / sqrt(r.scalar_product(~r))
    return finite_pose(translator(position) * unit, (nothing, Status.SINGULAR))


def quaternion(x: Multivector) -> Result:
    """w, x, y, z of a pose's rotation; the sign is the motor's."""
    return row(quaternion_of_rotor(euclidean_part(x)), "quaternion")


def sign_of_quaternion(x: Multivector) -> Result:
    """+1 or -1 that makes the first of w, x, y, z that is not zero positive."""
    sign = x.constant(1)
    for c in reversed(quaternion_of_rotor(euclidean_part(x))):
        sign = select(c > 0, x.constant(1), select(c < 0, x.constant(-1), sign))
    return named("sign", sign)


def shortest(x: Multivector) -> Multivector:
    """x or -x, the same pose: the one whose angle is at most half a turn."""
    return x * select(x.grade(0) < 0, x.constant(-1), x.constant(1))


def position(x: Multivector) -> Multivector:
    """The image of the origin."""
    return translation_of(x)


# -- dual quaternions --------------------------------------------------------------------------------------


def _motor_of(q: DualQuaternion) -> Multivector:
    unit = null_vector(q.rw) * space(q.rw)
    return as_computed(rotor_of_quaternion(*q[:4]) + rotor_of_quaternion(*q[4:]) * unit)


def _norm_parts(x: Multivector) -> tuple[Multivector, Multivector]:
    """s and q of x ~x = s + q, q of grade 4."""
    norm = x * ~x
    return norm.grade(0), norm.grade(4)


def _repaired(x: Multivector, s: Multivector, q: Multivector) -> Multivector:
    """x (x ~x)^(-1/2), the nearest motor."""
    return x * (1 - q / (2 * s)) / sqrt(s)


def pose_of_dual_quaternion(q: DualQuaternion) -> Pose:
    """The pose of a unit dual quaternion. INVALID: not finite, or not unit to rounding."""
    x = _motor_of(q)
    s, rest = _norm_parts(x)
    tolerance = UNIT * epsilon(x)
    is_unit = absolute(s - 1) <= tolerance
    is_unit = is_unit & (size(rest) <= tolerance * (1 + size(attached_part(x))))
    return finite_pose(_repaired(x, where_or_nan(is_unit, s), rest))


def pose_of_any_dual_quaternion(q: DualQuaternion) -> Pose:
    """The pose next to a dual quaternion of any length. SINGULAR: its real part is zero. INVALID: not finite."""
    x = _motor_of(q)
    written = size(euclidean_part(x))
    nothing = written <= 0
    x = as_computed(x / where_or_nan(~nothing, written))
    return finite_pose(_repaired(x, *_norm_parts(x)), (nothing, Status.SINGULAR))


def dual_quaternion(x: Multivector) -> Result:
    """Real and dual part of a pose."""
    dual = attached_part(x) * space(x)
    return row([*quaternion_of_rotor(euclidean_part(x)), *quaternion_of_rotor(dual)], "dual_quaternion")


# -- matrices ----------------------------------------------------------------------------------------------


def _columns(m: PoseMatrix) -> tuple[list[Multivector], Multivector]:
    columns = [as_computed(vector((m[k], m[4 + k], m[8 + k]))) for k in range(4)]
    return columns[:3], columns[3]


def pose_of_matrix(m: PoseMatrix) -> Pose:
    """The pose with <R>_0 >= 0 of a rotation matrix and a position. INVALID: not finite, no rotation to rounding."""
    columns, origin = _columns(m)
    valid = _is_right_handed(columns)
    for i, f in enumerate(columns):
        for j, g in enumerate(columns[i:], i):
            valid = valid & (absolute(dot(f, g) - int(i == j)) <= UNIT * epsilon(origin))
    return finite_pose(translator(origin) * (rotor_from_columns(columns) * where_or_nan(valid, origin.constant(1))))


def _is_right_handed(columns: list[Multivector]) -> Mask:
    a, b, c = columns
    return dot(cross(a, b), c) > 0


def nearest_pose_of_matrix(m: PoseMatrix) -> tuple[Multivector, Result, Result]:
    """The pose of the rotation that is nearest to a matrix, and the largest change of an entry.

    The orthogonal factor of the polar decomposition: half the sum of the columns and their reciprocal frame, again and
    again. INVALID: not finite, or no positive determinant.
    """
    columns, origin = _columns(m)
    valid = _is_right_handed(columns)
    frame = columns
    for _ in range(POLAR_STEPS):
        frame = [as_computed((f + g) / 2) for f, g in zip(frame, reciprocal_vectors(frame), strict=True)]
    deviation = origin.constant(0)
    for f, g in zip(columns, frame, strict=True):
        for change in coordinates(f - g):
            larger = absolute(change) > deviation
            deviation = select(larger, absolute(change), deviation)
    turn = rotor_from_columns(frame) * where_or_nan(valid, origin.constant(1))
    pose, status = finite_pose(translator(origin) * turn)
    return pose, named("deviation", deviation), status


# -- rotation vectors ---------------------------------------------------------------------------------------


def pose_of_rotation_vector(r: Multivector, position: Multivector) -> Pose:
    """The pose of a rotation about a vector by its length, and of a position. INVALID: not finite."""
    return finite_pose(translator(position) * exp_bivector(-r * space(r) / 2))


def rotation_vector(x: Multivector) -> tuple[Multivector, Result]:
    """Axis times angle, which is in [0, 2 pi) and counts the motor's sign; statuses of `log_motor`."""
    logarithm, status = log_motor(euclidean_part(x))
    return -2 * direction_part(logarithm), status


# -- what poses do -----------------------------------------------------------------------------------------


def composed(x: Multivector, y: Multivector) -> Pose:
    """x y: y acts first. INVALID: not finite."""
    return finite_pose((x * y).grade(0, 2, 4))


def matrix(x: Multivector) -> Result:
    """The homogeneous matrix, row by row."""
    return motor_to_matrix(x)


def moved(x: Multivector, point: Multivector) -> Multivector:
    """The image of a point."""
    return (euclidean_part(x) >> point).grade(1) + translation_of(x)


def rotated(x: Multivector, v: Multivector) -> Multivector:
    """The image of a vector that has no place."""
    return (euclidean_part(x) >> v).grade(1)
