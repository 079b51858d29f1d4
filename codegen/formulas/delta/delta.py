"""The Delta robot: inverse and forward kinematics (thesis 7.7.2). Derivatives: `delta_rates`, the rest: `delta_frame`.

Three arms in vertical planes about e3, seen in each arm's own plane: there a position is a spinor x + z j, j = e1 e3,
with x along the arm's direction s and z along e3. ``robot`` is a row (reach, upper, forearm, unit, length, rest): the
base's radius less the platform's and the lengths of the arms, in units of ``length``, a power of two near the forearm;
unit is 1/length, ``rest`` what rounding took from reach. ``sides`` say for each arm which elbow, ``side`` which root.

Near a singular pose a root nearly vanishes. Its derivative divides by it, and so needs it with more digits than the
lengths have: it is made once more on a ring with twice as many (`delta_digits`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from math import isqrt
from typing import NamedTuple

from ..multivector import Mask, Multivector, absolute, atan2, cos, select, sin, sqrt
from ..status import Status
from ..trace import Result, row
from .delta_digits import doubled, shortened
from .euclidean import axes, coordinates, cross, length, vector
from .outcome import NOISE, as_computed, epsilon, outcome, undefined

Row = tuple[Multivector, ...]
#: Of a square that may have lost its digits.
Root = Callable[[Multivector], Multivector]
#: sin 60 degrees to 60 digits.
SINE = Fraction(isqrt(3 * 10**120), 2 * 10**60)
#: A length that is negative by fewer rounding errors of its terms than this is zero: the arm is stretched.
STRETCHED = 16


class Robot(NamedTuple):
    """The row ``robot`` by name."""

    reach: Multivector
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


def arm_turn(like: Multivector) -> Multivector:
    """j = e1 e3, the unit bivector of an arm's plane from s to e3."""
    return axes(like)[0] * down(like)


# -- inverse kinematics ------------------------------------------------------------------------------------------


class Reach(NamedTuple):
    """One arm on its way to a position: the spinor of its upper arm but for a positive factor, and what says whether.

    ``root`` is twice the area of the triangle of upper arm, forearm and shoulder to wrist, times two.
    """

    spinor: Multivector
    root: Multivector
    is_reached: Mask
    is_aligned: Mask


def _reach(y: Multivector, robot: Robot, s: Multivector, side: Multivector, known: Root | None = None) -> Reach:
    """Upper arms that reach a wrist: where the elbow's circle meets the forearm's sphere, T = (C* ^ Sigma*) I5.

    The sphere cuts the arm's plane in a circle of radius q about the wrist's projection, at the distance p of the
    shoulder. The ends of T are z = u (c -+ sqrt(T^2) j)/p^2, c = upper^2 + p^2 - q^2, and T^2 is Heron's product of
    the four sums of upper, p and q: what is negative of them tells why there is no elbow. Nothing is subtracted that
    is not a length of the robot. ``known`` gives the root of Heron's
    product where it is known with all its digits.
    """
    u = y - robot.reach * s
    e3 = down(y)
    across = u | cross(s, e3)
    spinor = (u | s) + (u | e3) * arm_turn(y)
    p = as_computed(sqrt((spinor * ~spinor).grade(0)))
    q = as_computed(sqrt(absolute((robot.forearm - across) * (robot.forearm + across))))
    upper, total, difference = robot.upper, p + q, p - q
    rounding = STRETCHED * epsilon(y) * (upper + robot.forearm + absolute(robot.reach))
    reached = (absolute(difference) <= upper + rounding) & (total >= upper - rounding)
    reached = reached & (absolute(across) <= robot.forearm + rounding)
    heron = (upper - difference) * (upper + difference) * ((total - upper) * (total + upper))
    root = as_computed(sqrt(_positive(heron))) if known is None else known(heron)
    c = upper * upper + total * difference
    return Reach(spinor * (c - side * root * arm_turn(y)), root, reached, p <= rounding * (NOISE // STRETCHED))


def _positive(x: Multivector) -> Multivector:
    """The greater of x and 0; a selection would let most exact points vanish, and what is divided by it with them."""
    return (x + absolute(x)) / 2


def moving(root: Multivector) -> Root:
    """A root that is known as a function of its square: a step of Newton's method, which has the right derivative."""
    return lambda square: (square / root + root) / 2


def _still(root: Multivector) -> Root:
    """A root that is known, and not differentiated."""
    return lambda _: root


def reaches_of(y: Row, robot: Row, sides: Row, roots: Sequence[Root | None] = (None,) * 3) -> list[Reach]:
    parts = Robot(*robot)
    position = vector(tuple(c * parts.unit for c in y))
    return [_reach(position, parts, *each) for each in zip(arm_directions(position), sides, roots, strict=True)]


def exact_roots(y: Row, robot: Row) -> Row:
    """The roots of all arms, 4 upper^2 p^2 - c^2 with twice the digits: c = upper^2 + u^2 - forearm^2."""
    parts = Robot(*robot)
    position = doubled(vector(tuple(c * parts.unit for c in y)))
    reach, upper, forearm = doubled(parts.reach, parts.rest), doubled(parts.upper), doubled(parts.forearm)
    lengths, height = upper * upper - forearm * forearm, position | down(position)
    roots = []
    for s in arm_directions(position):
        u = position - reach * s
        along = u | s
        c = lengths + (u * u).grade(0)
        square = 4 * upper * upper * (along * along + height * height) - c * c
        roots.append(as_computed(sqrt(_positive(shortened(square, y[0])))))
    return tuple(roots)


def all_of(masks: list[Mask]) -> Mask:
    total = masks[0]
    for mask in masks[1:]:
        total = total & mask
    return total


def _reach_codes(reach: Reach, finite: Mask) -> list[tuple[Mask, Status]]:
    return [
        (~finite, Status.INVALID),
        (~reach.is_reached, Status.UNREACHABLE),
        (reach.is_aligned, Status.SINGULAR),
    ]


def angles_of(reaches: list[Reach]) -> Result:
    turn = arm_turn(reaches[0].spinor)
    return row([atan2(-(r.spinor | turn), r.spinor.grade(0)) for r in reaches], "theta")


def inverse(y: Row, robot: Row, sides: Row) -> tuple[Result, Result]:
    """Angles of the arms for a position of the platform, from s_i towards e3 (7.7.2).

    UNREACHABLE: an arm does not reach its wrist. SINGULAR: the wrist is on a motor's axis. `arm_codes` says which.
    """
    return _told(y, reaches_of(y, robot, sides))


def inverse_precise(y: Row, robot: Row, sides: Row) -> tuple[Result, Result]:
    """`inverse` with all digits next to singular poses, too, where it has half of them."""
    return _told(y, reaches_of(y, robot, sides, [_still(root) for root in exact_roots(y, robot)]))


def _told(y: Row, reaches: list[Reach]) -> tuple[Result, Result]:
    """The angles, NaN where there are none, and why."""
    like, finite = y[0], are_finite(y)
    reached, free = all_of([r.is_reached for r in reaches]), all_of([~r.is_aligned for r in reaches])
    good, nan = reached & free & finite, undefined(like)
    status = outcome(like, (~finite, Status.INVALID), (~reached, Status.UNREACHABLE), (~free, Status.SINGULAR))
    return row([select(good, angle, nan) for angle in angles_of(reaches).values], "theta"), status


def arm_codes(y: Row, robot: Row, sides: Row) -> Result:
    """The status of each arm: OK, UNREACHABLE, SINGULAR (the wrist is on its motor's axis) or INVALID."""
    finite = are_finite(y)
    codes = [outcome(y[0], *_reach_codes(r, finite)).value for r in reaches_of(y, robot, sides)]
    return row(codes, "codes")


def are_finite(values: Row) -> Mask:
    """Whether each number less itself is zero; as computed one by one, for sums may be rounded in any order."""
    return values[0].sum(as_computed(x - as_computed(x)) for x in values) <= 0


# -- forward kinematics ------------------------------------------------------------------------------------------


def sphere_centers(theta: Row, robot: Robot) -> list[Multivector]:
    """a_i, the elbows less the platform's radius: the centres of the spheres on which the platform is."""
    like = theta[0]
    places = [(robot.reach + robot.upper * cos(t), robot.upper * sin(t)) for t in theta]
    return [x * s + z * down(like) for (x, z), s in zip(places, arm_directions(like), strict=True)]


class Meeting(NamedTuple):
    """Where three spheres of one radius meet: on the axis of the circle A_1 ^ A_2 ^ A_3 of their centres."""

    position: Multivector
    meet: Mask
    coincide: Mask


def meeting_of(theta: Row, robot: Robot, side: Multivector, known: Root | None = None) -> Meeting:
    """T = I5 (Sigma_1* ^ Sigma_2* ^ Sigma_3*), by its middle o and its half, sqrt((forearm - |o|)(forearm + |o|)).

    With b, c from the first centre to the others, o = (b^2 c - c^2 b) (b ^ c)^-1/2. ``known`` gives the
    half of its square where it is known with all its digits.
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
    reach = absolute(robot.reach) + robot.upper
    rounding = STRETCHED * epsilon(area) * (robot.forearm + reach)
    square = gap * (robot.forearm + radius)
    height = sqrt(_positive(square)) if known is None else known(square)
    noise = NOISE * epsilon(area) * reach
    apart = all_of([x > noise * noise for x in squares])
    position = a[0] + middle + cross(b, c) * (per_area * side * height)
    return Meeting(position, (gap >= -rounding) & (area > 0), ~apart)


def exact_height(theta: Row, robot: Row) -> Multivector:
    """The half of `meeting_of` with twice the digits: forearm^2 - a b c/(4 area^2) of the centres' squared distances.

    Those are of the elbows' spinors, k^2 + k'^2 + k k' + (z - z')^2: directions meet at s . s' = -1/2.
    """
    parts, like = Robot(*robot), theta[0]
    reach, upper, forearm = doubled(parts.reach, parts.rest), doubled(parts.upper), doubled(parts.forearm)
    angles = [doubled(t) for t in theta]
    ks, zs = [reach + upper * cos(t) for t in angles], [upper * sin(t) for t in angles]
    distances = []
    for i, j in ((0, 1), (1, 2), (2, 0)):
        rise = zs[i] - zs[j]
        distances.append(ks[i] * ks[i] + ks[j] * ks[j] + ks[i] * ks[j] + rise * rise)
    a, b, c = distances
    side, product = a + b - c, a * b
    area = 4 * product - side * side
    square = forearm * forearm * area - product * c
    return as_computed(sqrt(_positive(shortened(square, like)) / shortened(area, like)))


def forward(theta: Row, robot: Row, side: Multivector) -> tuple[Result, Result]:
    """Position of the platform for the angles of the arms (7.7.2).

    UNREACHABLE: the forearms do not meet. SINGULAR: two of them start at one point, and leave the platform free.
    """
    return _found(theta, Robot(*robot), meeting_of(theta, Robot(*robot), side))


def forward_precise(theta: Row, robot: Row, side: Multivector) -> tuple[Result, Result]:
    """`forward` with all digits next to singular poses, too, where it has half of them."""
    parts = Robot(*robot)
    return _found(theta, parts, meeting_of(theta, parts, side, _still(exact_height(theta, robot))))


def _found(theta: Row, robot: Robot, found: Meeting) -> tuple[Result, Result]:
    """The position, NaN where there is none, and why."""
    like, finite = theta[0], are_finite(theta)
    good = found.meet & ~found.coincide & finite
    status = outcome(
        like, (~finite, Status.INVALID), (found.coincide, Status.SINGULAR), (~found.meet, Status.UNREACHABLE)
    )
    values = [x * robot.length for x in coordinates(found.position)]
    return row([select(good, x, undefined(like)) for x in values], "y"), status
