"""Exponential, logarithm and square root of motors, in CGA and in PGA alike.

A motor's bivector b has b^2 = -w + q with a scalar w and q of grade 4, q^2 = 0; so every function of it is a
function of w and its derivative. No case is split: rotations, translations, screws, and any angle.
"""

from __future__ import annotations

from ..errors import GradeError
from ..multivector import (
    Mask,
    Multivector,
    absolute,
    atan2,
    select,
    sqrt,
    stumpff0,
    stumpff1,
    stumpff2,
    stumpff3,
)
from ..status import Status
from ..trace import Result
from .euclidean import attached_part, axes, null_vector, space
from .outcome import epsilon, only_if, outcome, unless
from .products import absolute_product


def square_parts(b: Multivector) -> tuple[Multivector, Multivector]:
    """w and q of b^2 = -w + q.

    Raises
    ------
    GradeError
        If q^2 does not vanish by the blades of b: then b is no bivector of a motor.
    """
    square = b * b
    q = square.grade(4)
    if (q * q).terms:
        raise GradeError("the square of this bivector is not -w + q with q^2 = 0; exp is for bivectors of motors.")
    return -square.grade(0), q


def exp_bivector(b: Multivector) -> Multivector:
    """exp(b) = c0(w) + b c1(w) + q (c1(w) + b (c2(w) - c3(w)))/2, with Stumpff functions c_k."""
    w, q = square_parts(b)
    c1 = stumpff1(w)
    regular = stumpff0(w) + b * c1
    if not q.terms:
        return regular
    return regular + q * (c1 + b * (stumpff2(w) - stumpff3(w))) / 2


def log_motor(r: Multivector) -> tuple[Multivector, Result]:
    """The b with exp(b) = r whose angle 2 |b| is in [0, 2 pi): exact for translations, good near pi and 2 pi.

    With r = c + v + q (grades 0, 2, 4), s = |v| and the half angle f = atan2(s, c):
    b = (k - k^3 (c2(f^2) - c3(f^2)) q) v, k = f/s. The sign of r counts: exp(b) = r, not -r.

    Where v has no rotation and c < 0, r is a full turn about any axis along its translation: the axis through the
    origin is taken (about e3 where nothing moves), with status NOT_UNIQUE. In the plane there is none: SINGULAR.
    INVALID: r ~r differs from 1 by more than the square root of the rounding unit.
    """
    c, v, q = r.grade(0), r.grade(2), r.grade(4)
    valid = is_unit(r)
    s = sqrt(-(v * v).grade(0))
    if not s.terms:  # translators, by their blades
        return v / only_if(valid, c), outcome(r, (unless(valid), Status.INVALID))
    half_angle = atan2(s, c)
    moves = s > 0
    full_turn = ~moves & (c < 0)
    k = select(moves, half_angle / s, select(c < 0, r.constant(-1), r.constant(1)))
    k = only_if(valid, k)
    b = k * v
    if q.terms:
        w = half_angle * half_angle
        b = b - (k * k * k * (stumpff2(w) - stumpff3(w))) * (q * v)
    axis, possible = _turn_axis(v)
    b = b - axis * select(full_turn, half_angle, r.constant(0))
    return _finished(r, b, valid, full_turn, possible)


def sqrt_motor(r: Multivector) -> tuple[Multivector, Result]:
    """exp(log(r)/2): the unit motor of half the motion, normalised from 1 + r.

    (1 + r)(1 + ~r) = 2 h + 2 q with h = 1 + c, which is s^2/(1 - c) where c < 0. A full turn has the half turn
    about the axis that `log_motor` takes, with the same status.
    """
    c, v, q = r.grade(0), r.grade(2), r.grade(4)
    valid = is_unit(r)
    square = -(v * v).grade(0)
    if not square.terms:
        return 1 + v / (2 * only_if(valid, c)), outcome(r, (unless(valid), Status.INVALID))
    h = select(c < 0, square / (1 - c), 1 + c)
    h = only_if(valid, h)
    root = (h + v + q) * (1 - q / (2 * h)) / sqrt(2 * h)
    full_turn = (square <= 0) & (c < 0)
    axis, possible = _turn_axis(v)
    half_turn = -axis * (1 - _translation(v) / 2)
    if valid is not None:
        full_turn = full_turn & valid
    return _finished(r, select(full_turn, half_turn, root), valid, full_turn, possible)


def is_unit(r: Multivector) -> Mask | None:
    """Whether r ~r = 1 to half of the digits, each coefficient on the scale of its terms; None where it is proved."""
    defect = r * ~r - 1
    scale = absolute_product(r, ~r)
    tolerance = sqrt(epsilon(r))
    mask = None
    for blade, value in defect.terms.items():
        near = absolute(r.new({0: value})) <= tolerance * r.new({0: scale.terms[blade]})
        mask = near if mask is None else mask & near
    return mask


def _translation(v: Multivector) -> Multivector:
    """The part of a bivector that holds the null vector."""
    t = attached_part(v)
    return t ^ null_vector(v) if t.terms else t


def _turn_axis(v: Multivector) -> tuple[Multivector, Mask | None]:
    """Unit bivector of a rotation about an axis along the translation in v, and where there is one (None: always)."""
    basis = axes(v)
    plane = basis[0] * basis[1]
    t = attached_part(v)
    if not t.terms:
        return plane, None
    square = (t * t).grade(0)
    if len(basis) != 3:
        return plane, square <= 0
    along = square > 0
    scale = select(along, 1 / sqrt(square), v.constant(0))
    return t * space(v) * scale + plane * select(along, v.constant(0), v.constant(1)), None


def _finished(
    r: Multivector, value: Multivector, valid: Mask | None, full_turn: Mask, possible: Mask | None
) -> tuple[Multivector, Result]:
    cases = [(unless(valid), Status.INVALID), (full_turn, Status.NOT_UNIQUE)]
    if possible is not None:
        nowhere = full_turn & ~possible
        value = value * only_if(~nowhere, r.constant(1))
        cases.insert(1, (nowhere, Status.SINGULAR))
    return value, outcome(r, *cases)
