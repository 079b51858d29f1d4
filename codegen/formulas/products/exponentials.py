"""Exponential, logarithm and square root of motors, in CGA and in PGA alike.

A motor's bivector b has b^2 = -w + q with a scalar w and q of grade 4, q^2 = 0: a rotation, a translation along its
axis, and one across that only moves the axis. General rotors are in `invariant`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...algebra.multivector import Mask, Multivector, absolute, atan2, cos, select, sin, sqrt, stumpff0, stumpff1
from ...errors import GradeError
from ...status import Status
from ...trace.outputs import Result, named, row, status
from ..motions.commuting_planes import commuting_axis
from ..motions.motions import translation_of
from ..objects.euclidean import (
    attached_part,
    axes,
    coordinates,
    cross,
    direction_of,
    dot,
    euclidean_part,
    null_vector,
    space,
)
from .outcome import NOISE, as_computed, epsilon, is_finite, outcome, size, where_or_nan, without_negative_zeros
from .products import absolute_product


def square_signs(b: Multivector) -> tuple[bool, bool]:
    """Return whether the scalar part of b^2 can be negative, and whether it can be positive, by the blades of b."""
    blades = list(b.terms)
    if not blades:
        return False, False
    table = [[float(dict(b.algebra.product(x, y)).get(0, 0)) for y in blades] for x in blades]
    values = np.linalg.eigvalsh(np.array(table))
    noise = len(blades) * float(np.finfo(float).eps) * float(np.abs(values).max())
    return bool(values.min() < -noise), bool(values.max() > noise)


def is_motion(b: Multivector) -> bool:
    """Return whether b is the bivector of a motor, by its blades: b^2 = -w + q with w >= 0 and q^2 = 0."""
    q = (b * b).grade(4)
    return not (q * q).terms and not square_signs(b)[1]


def exp_bivector(b: Multivector) -> Multivector:
    """exp(b) = cos s + S b + q (S + b (S - cos s)/s^2)/2, where b^2 = -s^2 + q and S = sin(s)/s.

    Where the rotation is so small that its square is lost against 1, that is (1 + b + q/2)/sqrt(1 + s^2), a motor
    too. Simple bivectors of either sign of b^2 are done by Stumpff functions.

    Raises
    ------
    GradeError
        If q^2 does not vanish by the blades of b, or b^2 has q and may be positive: see `invariant.exp_bivector`.
    """
    square = b * b
    w, q = -square.grade(0), square.grade(4)
    if not is_motion(b):
        if q.terms:
            raise GradeError("the square of this bivector is not -w + q with q^2 = 0; exp is for bivectors of motors.")
        return stumpff0(w) + b * stumpff1(w)
    if not w.terms:
        return 1 + b
    rotates = w > epsilon(b)
    s = sqrt(w)
    c, sine = cos(s), sin(s) / s
    small = 1 / sqrt(1 + w)
    regular = select(rotates, c, small)
    first = select(rotates, sine, small)
    if not q.terms:
        return regular + b * first
    second = select(rotates, (sine - c) / w, b.constant(0))
    return regular + b * first + q * (first + b * second) / 2


class Screw(NamedTuple):
    """A motor r = c + v + q in parts: r = (c + p) (1 + shift), p = plane + across, p^2 = -square.

    ``plane`` is the rotation, ``across`` moves its axis, ``shift`` is the translation along it. Where ``rotates`` is
    false, r is a translation and all of v is in p.
    """

    c: Multivector
    p: Multivector
    shift: Multivector
    square: Multivector
    rotates: Mask


def screw_parts(r: Multivector) -> Screw:
    """Rotation, axis and translation of a motor, each to rounding, also next to a full turn.

    The part across is found twice: what rounding leaves of the one along in it is divided by the sine later, and
    exp(log(r)) would miss r by eps/sine.
    """
    c, v, q = r.grade(0), r.grade(2), r.grade(4)
    plane = euclidean_part(v)
    across = v - plane
    square = -(plane * plane).grade(0)
    if not square.terms or not across.terms:
        return Screw(c, v, v.new({}), square, _is_rotation(c, square))
    rotates = _is_rotation(c, square)
    inverse = select(rotates, 1 / square, r.constant(0))
    along = _along(across, plane) * inverse
    if along.terms:
        across = as_computed(across - along)
        rest = _along(across, plane) * inverse
        across, along = across - rest, along + rest
    return Screw(c, plane + across, c * along - (plane * q).grade(2), square, rotates)


def _along(v: Multivector, plane: Multivector) -> Multivector:
    """The part of v along the axis of a turn, times the turn's |square|."""
    return -((v ^ plane) * plane).grade(2)


def _is_rotation(c: Multivector, square: Multivector) -> Mask:
    """Mask of rotations: the square does not underflow, and it is no rounding noise on a full turn."""
    least, noise = epsilon(c), NOISE * epsilon(c)
    return (square > least * least * least * least) & ((c > 0) | (square > noise * noise))


def log_motor(r: Multivector) -> tuple[Multivector, Result]:
    """The b with exp(b) = r whose angle 2 |b| is in [0, 2 pi): exact for translations, good near pi and 2 pi.

    With r = (c + p) (1 + t), a rotation p about its axis and a translation t along it, s = |p| and the half angle
    f = atan2(s, c): b = f p/s + t. The sign of r counts: exp(b) = r, not -r.

    Where the rotation in r is rounding noise and c < 0, r is a full turn about any axis along its translation: the
    axis through the origin is taken (about e3 where nothing moves), with status NOT_UNIQUE. In the plane there is
    none: SINGULAR. Before that the axis moves away, and rounding b moves exp(b) by |t|/s units of it.
    INVALID: r ~r differs from 1 by more than the square root of the rounding unit.

    Raises
    ------
    GradeError
        If by its blades r need not be a motor: see `invariant.log`.
    """
    r = _with_rounding(r)
    valid = is_unit(r)
    c, p, shift, square, rotates = screw_parts(r)
    if not square.terms:  # translators, by their blades
        valid = valid & (c > 0)
        return p / where_or_nan(valid, c), outcome(r, (~valid, Status.INVALID))
    full_turn = ~rotates & (c < 0)
    s = sqrt(select(full_turn, r.constant(0), square))
    half_angle = atan2(s, c)
    k = select(rotates, half_angle / s, select(c < 0, r.constant(-1), r.constant(1)))
    axis, possible = commuting_axis(r.grade(2))
    b = where_or_nan(valid, k) * p + shift - axis * select(full_turn, half_angle, r.constant(0))
    return _results(r, b, valid, full_turn, possible)


def motor_parameters(r: Multivector) -> tuple[Result, Result, Result, Result, Result]:
    """Screw of a motor: unit axis, angle in [0, 2 pi), point of the axis nearest the origin, translation along it.

    A translation has its direction as axis and the angle 0. NOT_UNIQUE: the identity, whose axis is the last vector of
    the basis; a full turn, whose axis goes through the origin. INVALID: as `log_motor`.
    """
    b, logarithm = log_motor(r)
    turn = (euclidean_part(b) * space(r)).grade(1)
    turned, plane = size(turn), euclidean_part(r.grade(2))
    a, inverse = direction_of(turn)
    turns = inverse > 0
    angle = 2 * select(turns, 1 / inverse, turned)
    axis, rest = select(turns, a, axes(r)[-1]), turned <= 0
    advance, point = r.constant(0), r.new({})
    t = translation_of(r)
    if t.terms:
        direction, scale = direction_of(t)
        moves = scale > 0
        axis, rest = select(turns | ~moves, axis, direction), rest & (size(t) <= 0)
        advance = dot(axis, t)
        across = t - advance * axis
        # the nearest point c of the axis is moved by `across`: (1 - rotation) c = across, c perpendicular to it
        cotangent = r.grade(0) * direction_of((plane * space(r)).grade(1))[1]
        full_turn = ~_is_rotation(r.grade(0), -(plane * plane).grade(0)) & (r.grade(0) < 0)
        found = (across + cross(axis, across) * cotangent) / 2
        point = select(turns & ~full_turn, found, r.constant(0))
    code = select(rest, r.constant(Status.NOT_UNIQUE), r.constant(Status.OK))
    return (
        row(coordinates(without_negative_zeros(axis)), "axis"),
        named("angle", angle),
        row(coordinates(without_negative_zeros(point)), "point"),
        named("advance", without_negative_zeros(advance)),
        status(select(logarithm.value > 0, logarithm.value, code)),
    )


def sqrt_motor(r: Multivector) -> tuple[Multivector, Result]:
    """exp(log(r)/2), the unit motor of half the motion: (h + p) (1 + t/2) normalized, for r = (c + p) (1 + t).

    h = 1 + c, which is |p|^2/(1 - c) where c < 0: no digits are lost towards -1. A full turn has the half turn about
    the axis that `log_motor` takes, with the same statuses.
    """
    r = _with_rounding(r)
    valid = is_unit(r)
    c, p, shift, square, rotates = screw_parts(r)
    if not square.terms:
        valid = valid & (c > 0)
        return 1 + p / (2 * where_or_nan(valid, c)), outcome(r, (~valid, Status.INVALID))
    h = select(c < 0, square / (1 - c), 1 + c)
    middle = (where_or_nan(valid, h) + p) * (1 + shift / 2)
    norm = middle * ~middle
    s0, s4 = norm.grade(0), norm.grade(4)
    root = middle * (1 - s4 / (2 * s0)) / sqrt(s0)
    full_turn = ~rotates & (c < 0) & valid
    v = r.grade(2)
    axis, possible = commuting_axis(v)
    half_turn = -axis * (1 - _translation(v) / 2)
    return _results(r, select(full_turn, half_turn, root), valid, full_turn, possible)


def is_motor(r: Multivector) -> bool:
    """Return whether a unit r is a motor by its blades: one rotation, and translations."""
    v = r.grade(2)
    turn = euclidean_part(v)
    return is_motion(v) and not (turn * turn).grade(4).terms


def _with_rounding(r: Multivector) -> Multivector:
    """r as computed: r ~r = 1 holds to rounding only, and nothing may be simplified with it.

    (1 - c^2 for |p|^2 would lose every digit of a small angle.)
    """
    if not is_motor(r):
        raise GradeError("by its blades this need not be a motor.")
    return as_computed(r)


def is_unit(r: Multivector) -> Mask:
    """Return whether r ~r = 1 to half of the digits, each coefficient on the scale of its rounding error.

    Coefficients that scale alike (with n, without, ..) stand for each other: a half turn may have a cosine of 1e-17,
    whose product with a translation is no measure of rounding. Nor are translations by much less than 1.
    """
    defect = r * ~r - 1
    alike = _sizes(r)
    scale = absolute_product(alike, alike)
    tolerance = sqrt(epsilon(r))
    mask = is_finite(scale)  # and so is r
    for blade, value in defect.terms.items():
        mask = mask & (absolute(r.new({0: value})) <= tolerance * (1 + r.new({0: scale.terms[blade]})))
    return mask


def _sizes(r: Multivector) -> Multivector:
    """In place of each coefficient the size of all those whose blades differ from its own by Euclidean axes only."""
    (every_axis,) = space(r).terms
    rooms: dict[int, list[int]] = {}
    for blade in r.terms:
        rooms.setdefault(blade & ~every_axis, []).append(blade)
    sizes = {key: size(r.new({b: r.terms[b] for b in blades})) for key, blades in rooms.items()}
    return r.new({b: sizes[b & ~every_axis].terms[0] for b in r.terms})


def _translation(v: Multivector) -> Multivector:
    """The part of a bivector that holds the null vector."""
    t = attached_part(v)
    return t ^ null_vector(v) if t.terms else t


def _results(
    r: Multivector, value: Multivector, valid: Mask, full_turn: Mask, possible: Mask | None
) -> tuple[Multivector, Result]:
    cases = [(~valid, Status.INVALID), (full_turn, Status.NOT_UNIQUE)]
    if possible is not None:
        nowhere = full_turn & ~possible
        value = value * where_or_nan(~nowhere, r.constant(1))
        cases.insert(1, (nowhere, Status.SINGULAR))
    return value, outcome(r, *cases)
