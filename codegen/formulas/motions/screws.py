"""Screws of lines: sums of dual lines and their axes, screw motors, the points closest to lines (thesis 3.9, 3.12.4).

A twist bivector is S = m I3 + t n with the null vector n of CGA or PGA; a unit line is (dually, in CGA)
L* = m I3 + (p x m) n. The signs are those of MATHS: the printed (3.9) is the line through -p.
"""

from __future__ import annotations

from ...algebra.multivector import Mask, Multivector, absolute, select
from ...status import Status
from ...trace.outputs import Result, named, row
from ..objects.conformal import point
from ..objects.euclidean import attached_part, axes, cross, direction_of, dot, euclidean_part, null_vector, space
from ..products.exponentials import exp_bivector
from ..products.frames import matrix_of
from ..products.outcome import NOISE, as_computed, epsilon, is_finite, outcome, where_or_nan


def twist_of(line: Multivector) -> Multivector:
    """The bivector of a line: its dual in CGA, itself in PGA."""
    return line if line.algebra.is_degenerate else line.dual()


def line_of(twist: Multivector) -> Multivector:
    """The line with this bivector."""
    return twist if twist.algebra.is_degenerate else twist.undual()


def direction_part(twist: Multivector) -> Multivector:
    """m of S = m I3 + t n."""
    return -(euclidean_part(twist) * space(twist)).grade(1)


def rejection(t: Multivector, m: Multivector) -> Multivector:
    """The part of a vector across the unit vector m, to rounding of its own size: (t ^ m) m."""
    return ((t ^ m) * m).grade(1)


# -- screws ------------------------------------------------------------------------------------------------


def screw(s: Multivector) -> tuple[Result, Result, Result, Result]:
    """Axis, pitch and magnitude with s = magnitude (L* + pitch m n), of a twist bivector (thesis 3.9.3, 3.9.4).

    The axis is a unit line, the pitch the advance per radian of the motion exp(-angle/2 s/magnitude).
    NOT_UNIQUE: a pure translation; the axis is the line through the origin along it, the magnitude its length
    |t| (the pitch, which is infinite, is NaN here). SINGULAR: zero. INVALID: not finite.
    """
    return _decompose(s, direction_part(s), s.constant(1) > 0)


def screw_of_lines(
    l1: Multivector, l2: Multivector, alpha: Multivector
) -> tuple[Result, Result, Result, Result, Result]:
    """The screw of alpha L1* + (1 - alpha) L2* for unit lines, and where its axis meets their common perpendicular.

    The fraction counts from L1 (0) to L2 (1): b m2 . m/m^2 = (b^2 + a b c)/(a^2 + b^2 + 2 a b c) with a = alpha,
    b = 1 - alpha, c = m1 . m2. Directions that cancel to rounding leave a translation: NOT_UNIQUE, see `screw`.
    """
    a, b = alpha, 1 - alpha
    d1, d2 = as_computed(twist_of(l1)), as_computed(twist_of(l2))
    s, m2 = a * d1 + b * d2, direction_part(d2)
    m = a * direction_part(d1) + b * m2
    square = dot(m, m)
    noise = NOISE * epsilon(m) * (absolute(a) + absolute(b))
    turns = square > noise * noise
    fraction = b * dot(m2, m) / where_or_nan(turns, square)
    axis, pitch, magnitude, status = _decompose(s, m, turns)
    return axis, pitch, magnitude, named("fraction", fraction), status


def _decompose(s: Multivector, m: Multivector, may_rotate: Mask) -> tuple[Result, Result, Result, Result]:
    """Axis, pitch, magnitude and status; a direction m that may not turn counts as zero."""
    t, nothing = attached_part(s), s.constant(0)
    m, scale = direction_of(m)
    u, t_scale = direction_of(t)
    turns, moves = (scale > 0) & may_rotate, t_scale > 0
    moment = rejection(t * scale, m)
    direction = select(turns, m, u)
    twist = direction * space(s) + select(turns, moment, nothing) * null_vector(s)
    finite = is_finite(s)
    magnitude = select(turns & finite, 1 / scale, where_or_nan(moves & finite, 1 / t_scale))
    return (
        named("axis", line_of(twist)),
        named("pitch", where_or_nan(turns, dot(t, m) * scale)),
        named("magnitude", magnitude),
        outcome(
            s,
            (~finite, Status.INVALID),
            (~turns & ~moves, Status.SINGULAR),
            (~turns, Status.NOT_UNIQUE),
        ),
    )


def screw_bivector(axis: Multivector, pitch: Multivector, magnitude: Multivector) -> Multivector:
    """magnitude (L* + pitch m n): the twist bivector of a screw about a unit line."""
    twist = twist_of(axis)
    return magnitude * (twist + pitch * direction_part(twist) * null_vector(axis))


def screw_motor(axis: Multivector, angle: Multivector, pitch: Multivector) -> Multivector:
    """exp(-angle/2 (L* + pitch m n)): turn about the unit line by an angle and advance along it by pitch * angle."""
    return exp_bivector(screw_bivector(axis, pitch, -angle / 2))


# -- closest points ----------------------------------------------------------------------------------------


def closest_point(l1: Multivector, l2: Multivector) -> tuple[Multivector, Result]:
    """The point halfway between two unit lines on their common perpendicular (thesis 3.12.4, corrected).

    As in the text it is where L+ and L-, the axes of the screws L1* +- L2*, intersect: L+ passes at p+, nearest to
    the origin, along u, and of L- it takes the height along u alone, m+ . (m- x t-)/(m-^2 m+^2). Differences of
    nearly parallel lines are exact, so no digits are lost with the angle. L2 is first turned to L1's side.
    NOT_UNIQUE: parallel lines; the point of the middle line that is nearest the origin.
    """
    d1, d2 = as_computed(twist_of(l1)), as_computed(twist_of(l2))  # their lengths are one to rounding only
    m1, m2, t1, t2 = direction_part(d1), direction_part(d2), attached_part(d1), attached_part(d2)
    side = select(dot(m1, m2) < 0, l1.constant(-1), l1.constant(1))
    m_sum, t_sum = m1 + side * m2, t1 + side * t2
    m_gap, t_gap = m1 - side * m2, t1 - side * t2
    square = dot(m_sum, m_sum)
    scale = dot(m_gap, m_sum) / square  # rounding of the lines' own lengths: equal lengths have none
    m_gap, t_gap = m_gap - scale * m_sum, t_gap - scale * t_sum
    gap = dot(m_gap, m_gap)
    noise = NOISE * epsilon(l1)
    crossing = gap > noise * noise
    nearest = cross(m_sum, t_sum) / square
    height = dot(m_sum, cross(m_gap, t_gap)) / (where_or_nan(crossing, gap) * square)
    position = nearest + select(crossing, height, l1.constant(0)) * m_sum
    finite = is_finite(l1) & is_finite(l2)
    position = position * where_or_nan(finite, l1.constant(1))
    return point(position), outcome(l1, (~finite, Status.INVALID), (~crossing, Status.NOT_UNIQUE))


def line_equations(line: Multivector) -> tuple[Result, Result]:
    """Equations of a point's distance from a unit line: the matrix of x -> (x ^ m) m, and a point of it."""
    twist = twist_of(line)
    m = direction_part(twist)
    frame = axes(line)
    matrix = matrix_of(lambda x: rejection(x, m), frame, frame)
    return row([entry for entries in matrix for entry in entries], "matrix"), named(
        "point", cross(m, attached_part(twist))
    )
