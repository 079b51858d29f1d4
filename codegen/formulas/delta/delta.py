"""The Delta robot: inverse and forward kinematics (thesis 7.7.2). Derivatives: `delta_rates`, the rest: `delta_frame`.

Three arms in vertical planes about e3, seen in each arm's own plane: there a position is a spinor x + z j, j = e1 e3,
with x along the arm's direction s and z along e3. ``robot`` is a row (offset, upper, forearm, unit, length, rest): the
base's radius less the platform's and the lengths of the arms, in units of ``length``, a power of two near the forearm;
unit is 1/length, ``rest`` what rounding took from the offset. ``sides`` say for each arm which elbow, ``root`` which of
two positions (`side_of`).

Near a singular pose a root nearly vanishes. Its derivative divides by it, and so needs it with more digits than the
lengths have: it is made once more on a ring with twice as many (`delta_digits`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from math import isqrt
from typing import NamedTuple

from ...algebra.multivector import Mask, Multivector, absolute, atan2, cos, select, sin, sqrt
from ...status import Status
from ...trace.outputs import Result, row
from ..objects.euclidean import axes, coordinates, cross, length, vector
from ..products.double_double import to_double_double, to_single
from ..products.outcome import NOISE, as_computed, epsilon, not_a_number, outcome

Row = tuple[Multivector, ...]
#: Root of a square that may have lost its digits.
Root = Callable[[Multivector], Multivector]
#: sin 60 degrees to 60 digits.
SINE = Fraction(isqrt(3 * 10**120), 2 * 10**60)
#: A length that is negative by fewer rounding errors of its terms than this is zero: the arm is stretched.
STRETCHED = 16


class Coordinates(NamedTuple):
    """The row of a position ``y``, or of its rates."""

    e1: Multivector
    e2: Multivector
    e3: Multivector


class Arms(NamedTuple):
    """A row of one number for each arm."""

    arm1: Multivector
    arm2: Multivector
    arm3: Multivector


class Branch(NamedTuple):
    """The row ``root``: see `side_of`."""

    volume: Multivector
    height: Multivector


class Robot(NamedTuple):
    """The row ``robot`` by name."""

    offset: Multivector
    upper: Multivector
    forearm: Multivector
    unit: Multivector
    length: Multivector
    rest: Multivector


def arm_directions(like: Multivector) -> list[Multivector]:
    """s_1, s_2, s_3, counter-clockwise about e3. The sine as it is: exact products of it have denominators of 1e120."""
    e1, e2, _ = axes(like)
    across = as_computed(like.constant(SINE)) * e2
    return [e1, -e1 / 2 + across, -e1 / 2 - across]


def down(like: Multivector) -> Multivector:
    """e3, from the base to the workspace."""
    return axes(like)[2]


def arm_plane(like: Multivector) -> Multivector:
    """j = e1 e3, the unit bivector of an arm's plane from s to e3."""
    return axes(like)[0] * down(like)


# -- inverse kinematics ------------------------------------------------------------------------------------------


class ArmSolution(NamedTuple):
    """Solution of one arm: the spinor of its upper arm up to a positive factor, and whether there is one.

    ``root`` is twice the area of the triangle of upper arm, forearm and shoulder to wrist, times two.
    """

    spinor: Multivector
    root: Multivector
    is_reachable: Mask
    is_aligned: Mask


def _solve_arm(
    y: Multivector, robot: Robot, s: Multivector, side: Multivector, root_of: Root | None = None
) -> ArmSolution:
    """Upper arms that reach a wrist: where the elbow's circle meets the forearm's sphere, T = (C* ^ Sigma*) I5.

    The sphere cuts the arm's plane in a circle of radius q about the wrist's projection, at the distance p of the
    shoulder. The ends of T are z = u (c -+ sqrt(T^2) j)/p^2, c = upper^2 + p^2 - q^2, and T^2 is Heron's product of
    the four sums of upper, p and q: what is negative of them tells why there is no elbow. Nothing is subtracted that
    is not a length of the robot. ``root_of`` gives the root of Heron's product where it is known with all its digits.
    """
    u = y - robot.offset * s
    e3 = down(y)
    across = u | cross(s, e3)
    spinor = (u | s) + (u | e3) * arm_plane(y)
    p = as_computed(sqrt((spinor * ~spinor).grade(0)))
    q = as_computed(sqrt(absolute((robot.forearm - across) * (robot.forearm + across))))
    upper, total, difference = robot.upper, p + q, p - q
    rounding = STRETCHED * epsilon(y) * (upper + robot.forearm + absolute(robot.offset))
    reachable = (absolute(difference) <= upper + rounding) & (total >= upper - rounding)
    reachable = reachable & (absolute(across) <= robot.forearm + rounding)
    heron = (upper - difference) * (upper + difference) * ((total - upper) * (total + upper))
    root = as_computed(sqrt(_positive(heron))) if root_of is None else root_of(heron)
    c = upper * upper + total * difference
    return ArmSolution(spinor * (c - side * root * arm_plane(y)), root, reachable, p <= rounding * (NOISE // STRETCHED))


def _positive(x: Multivector) -> Multivector:
    """The greater of x and 0; a selection would let most exact points vanish, and what is divided by it with them."""
    return (x + absolute(x)) / 2


def moving(root: Multivector) -> Root:
    """A root that is known as a function of its square: a step of Newton's method, which has the right derivative."""
    return lambda square: (square / root + root) / 2


def _still(root: Multivector) -> Root:
    """A root that is known, and not differentiated."""
    return lambda _: root


def _lengths(robot: Robot) -> tuple[Multivector, Multivector, Multivector]:
    """Offset, upper arm and forearm with twice the digits."""
    return to_double_double(robot.offset, robot.rest), to_double_double(robot.upper), to_double_double(robot.forearm)


def solve_arms(
    y: Coordinates, robot: Robot, sides: Arms, roots: Sequence[Root | None] = (None,) * 3
) -> list[ArmSolution]:
    position = vector(tuple(c * robot.unit for c in y))
    return [_solve_arm(position, robot, *each) for each in zip(arm_directions(position), sides, roots, strict=True)]


def exact_roots(y: Coordinates, robot: Robot) -> Row:
    """The roots of all arms, 4 upper^2 p^2 - c^2 with twice the digits: c = upper^2 + u^2 - forearm^2."""
    position = to_double_double(vector(tuple(c * robot.unit for c in y)))
    offset, upper, forearm = _lengths(robot)
    lengths, height = upper * upper - forearm * forearm, position | down(position)
    roots = []
    for s in arm_directions(position):
        u = position - offset * s
        along = u | s
        c = lengths + (u * u).grade(0)
        square = 4 * upper * upper * (along * along + height * height) - c * c
        roots.append(as_computed(sqrt(_positive(to_single(square, y[0])))))
    return tuple(roots)


def all_of(masks: list[Mask]) -> Mask:
    total = masks[0]
    for mask in masks[1:]:
        total = total & mask
    return total


def angles_of(arms: list[ArmSolution]) -> Result:
    plane = arm_plane(arms[0].spinor)
    return row([atan2(-(r.spinor | plane), r.spinor.grade(0)) for r in arms], "theta")


def inverse(y: Coordinates, robot: Robot, sides: Arms) -> tuple[Result, Result]:
    """Angles of the arms for a position of the platform, from s_i towards e3 (7.7.2).

    UNREACHABLE: an arm does not reach its wrist. SINGULAR: the wrist is on a motor's axis. `arm_codes` says which.
    """
    return _angles_and_status(y, solve_arms(y, robot, sides))


def inverse_precise(y: Coordinates, robot: Robot, sides: Arms) -> tuple[Result, Result]:
    """`inverse` with all digits next to singular poses, too, where it has half of them."""
    return _angles_and_status(y, solve_arms(y, robot, sides, [_still(root) for root in exact_roots(y, robot)]))


def _angles_and_status(y: Coordinates, arms: list[ArmSolution]) -> tuple[Result, Result]:
    """The angles, NaN where there are none, and why."""
    like, finite = y[0], are_finite(y)
    reachable, free = all_of([r.is_reachable for r in arms]), all_of([~r.is_aligned for r in arms])
    good, nan = reachable & free & finite, not_a_number(like)
    status = outcome(like, (~finite, Status.INVALID), (~reachable, Status.UNREACHABLE), (~free, Status.SINGULAR))
    return row([select(good, angle, nan) for angle in angles_of(arms).values], "theta"), status


def arm_codes(y: Coordinates, robot: Robot, sides: Arms) -> Result:
    """The status of each arm: OK, UNREACHABLE, SINGULAR (the wrist is on its motor's axis) or INVALID."""
    finite = are_finite(y)
    codes = [
        outcome(
            y[0], (~finite, Status.INVALID), (~r.is_reachable, Status.UNREACHABLE), (r.is_aligned, Status.SINGULAR)
        ).value
        for r in solve_arms(y, robot, sides)
    ]
    return row(codes, "codes")


def are_finite(values: Row) -> Mask:
    """Return whether each number less itself is zero; as computed one by one, for sums may be rounded in any order."""
    return values[0].sum(as_computed(x - as_computed(x)) for x in values) <= 0


# -- forward kinematics ------------------------------------------------------------------------------------------


def sphere_centers(theta: Arms, robot: Robot) -> list[Multivector]:
    """a_i, the elbows less the platform's radius: the centers of the spheres on which the platform is."""
    like = theta[0]
    places = [(robot.offset + robot.upper * cos(t), robot.upper * sin(t)) for t in theta]
    return [x * s + z * down(like) for (x, z), s in zip(places, arm_directions(like), strict=True)]


def side_of(theta: Arms, robot: Robot, root: Branch) -> Multivector:
    """+1 where the forearms' volume is positive, v_1 ^ v_2 ^ v_3 = + |..| e123, and -1 where it is negative.

    ``root`` is a row of two numbers, of which one is zero. The other is 1 or -1: first the sign of the volume itself,
    which is continuous in theta; or second 1 for the position farther along e3 and -1 for the one nearer. Seen along
    e3 the centers a_i = k_i s_i + .. run counter-clockwise where k_1 k_2 + k_2 k_3 + k_3 k_1 > 0; there, and where
    both are equally far, the farther one has the positive volume. The sum is rounded alike in all kernels, so that
    they take the same position.
    """
    ks = [as_computed(robot.offset + robot.upper * cos(t)) for t in theta]
    products = [as_computed(ks[i] * ks[j]) for i, j in ((0, 1), (1, 2), (2, 0))]
    area = as_computed(as_computed(products[0] + products[1]) + products[2])
    one = robot.offset.constant(1)
    return as_computed(root.volume + root.height * select(area < 0, -one, one))


class Meeting(NamedTuple):
    """Meeting point of three spheres of one radius, on the axis of the circle A_1 ^ A_2 ^ A_3 of their centers."""

    position: Multivector
    meet: Mask
    coincide: Mask


def meeting_of(theta: Arms, robot: Robot, side: Multivector, root_of: Root | None = None) -> Meeting:
    """T = I5 (Sigma_1* ^ Sigma_2* ^ Sigma_3*), by its middle o and its half, sqrt((forearm - |o|)(forearm + |o|)).

    With b, c from the first center to the others, o = (b^2 c - c^2 b) (b ^ c)^-1/2. ``side`` is +1 or -1, that of
    b x c (`side_of`). ``root_of`` gives the half of its square where it is known with all its digits.
    """
    a = sphere_centers(theta, robot)
    b, c = a[1] - a[0], a[2] - a[0]
    plane = b ^ c
    area = length(cross(b, c))
    squares = [(x * x).grade(0) for x in (b, c, b - c)]
    per_area = 1 / area
    middle = (squares[0] * c - squares[1] * b) | plane * (-per_area * per_area / 2)
    radius = length(middle)
    gap = robot.forearm - radius
    extent = absolute(robot.offset) + robot.upper
    rounding = STRETCHED * epsilon(area) * (robot.forearm + extent)
    square = gap * (robot.forearm + radius)
    height = sqrt(_positive(square)) if root_of is None else root_of(square)
    noise = NOISE * epsilon(area) * extent
    apart = all_of([x > noise * noise for x in squares])
    position = a[0] + middle + cross(b, c) * (per_area * side * height)
    return Meeting(position, (gap >= -rounding) & (area > 0), ~apart)


def exact_height(theta: Arms, robot: Robot) -> Multivector:
    """The half of `meeting_of` with twice the digits: forearm^2 - a b c/(4 area^2) of the centers' squared distances.

    The distances are of the elbows' spinors, k^2 + k'^2 + k k' + (z - z')^2: directions meet at s . s' = -1/2.
    """
    like = theta[0]
    offset, upper, forearm = _lengths(robot)
    angles = [to_double_double(t) for t in theta]
    ks, zs = [offset + upper * cos(t) for t in angles], [upper * sin(t) for t in angles]
    distances = []
    for i, j in ((0, 1), (1, 2), (2, 0)):
        rise = zs[i] - zs[j]
        distances.append(ks[i] * ks[i] + ks[j] * ks[j] + ks[i] * ks[j] + rise * rise)
    a, b, c = distances
    side, product = a + b - c, a * b
    area = 4 * product - side * side
    square = forearm * forearm * area - product * c
    return as_computed(sqrt(_positive(to_single(square, like)) / to_single(area, like)))


def forward(theta: Arms, robot: Robot, root: Branch) -> tuple[Result, Result]:
    """Position of the platform for the angles of the arms (7.7.2).

    UNREACHABLE: the forearms do not meet. SINGULAR: two of them start at one point, and leave the platform free.
    """
    return _position_and_status(theta, robot, meeting_of(theta, robot, side_of(theta, robot, root)))


def forward_precise(theta: Arms, robot: Robot, root: Branch) -> tuple[Result, Result]:
    """`forward` with all digits next to singular poses, too, where it has half of them."""
    known = _still(exact_height(theta, robot))
    return _position_and_status(theta, robot, meeting_of(theta, robot, side_of(theta, robot, root), known))


def _position_and_status(theta: Arms, robot: Robot, meeting: Meeting) -> tuple[Result, Result]:
    """The position, NaN where there is none, and why."""
    like, finite = theta[0], are_finite(theta)
    good = meeting.meet & ~meeting.coincide & finite
    status = outcome(
        like, (~finite, Status.INVALID), (meeting.coincide, Status.SINGULAR), (~meeting.meet, Status.UNREACHABLE)
    )
    values = [x * robot.length for x in coordinates(meeting.position)]
    return row([select(good, x, not_a_number(like)) for x in values], "y"), status
