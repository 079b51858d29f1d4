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
from .outcome import NOISE, as_computed, epsilon, is_finite, only_if, outcome
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

    Where the rotation in v is rounding noise and c < 0, r is a full turn about any axis along its translation: the
    axis through the origin is taken (about e3 where nothing moves), with status NOT_UNIQUE. In the plane there is
    none: SINGULAR. Before that the axis moves away, and rounding b moves exp(b) by |t|/s units of it.
    INVALID: r ~r differs from 1 by more than the square root of the rounding unit.
    """
    c, v, q = _parts(r)
    valid = is_unit(c + v + q)
    s = sqrt(-(v * v).grade(0))
    if not s.terms:  # translators, by their blades
        valid = valid & (c > 0)
        return v / only_if(valid, c), outcome(r, (~valid, Status.INVALID))
    full_turn = (s <= NOISE * epsilon(r)) & (c < 0)
    s = select(full_turn, r.constant(0), s)
    half_angle = atan2(s, c)
    moves = s > 0
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
    """exp(log(r)/2): the unit motor of half the motion, 1 + r normalised.

    1 + r = h + v + q with h = 1 + c, which is |v|^2/(1 - c) where c < 0: no digits are lost towards -1. A full
    turn has the half turn about the axis that `log_motor` takes, with the same statuses.
    """
    c, v, q = _parts(r)
    valid = is_unit(c + v + q)
    square = -(v * v).grade(0)
    if not square.terms:
        valid = valid & (c > 0)
        return 1 + v / (2 * only_if(valid, c)), outcome(r, (~valid, Status.INVALID))
    h = select(c < 0, square / (1 - c), 1 + c)
    middle = only_if(valid, h) + v + q
    norm = middle * ~middle
    s0, s4 = norm.grade(0), norm.grade(4)
    root = middle * (1 - s4 / (2 * s0)) / sqrt(s0)
    noise = NOISE * epsilon(r)
    full_turn = (square <= noise * noise) & (c < 0) & valid
    axis, possible = _turn_axis(v)
    half_turn = -axis * (1 - _translation(v) / 2)
    return _finished(r, select(full_turn, half_turn, root), valid, full_turn, possible)


def _parts(r: Multivector) -> tuple[Multivector, Multivector, Multivector]:
    """Grades 0, 2 and 4 as computed: r ~r = 1 holds to rounding only, and nothing may be simplified with it.

    (1 - c^2 for |v|^2 would lose every digit of a small angle.)
    """
    rounded = as_computed(r)
    return rounded.grade(0), rounded.grade(2), rounded.grade(4)


def is_unit(r: Multivector) -> Mask:
    """Whether r ~r = 1 to half of the digits, each coefficient on the scale of its terms."""
    defect = r * ~r - 1
    scale = absolute_product(r, ~r)
    tolerance = sqrt(epsilon(r))
    mask = is_finite(r)
    for blade, value in defect.terms.items():
        mask = mask & (absolute(r.new({0: value})) <= tolerance * r.new({0: scale.terms[blade]}))
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
    r: Multivector, value: Multivector, valid: Mask, full_turn: Mask, possible: Mask | None
) -> tuple[Multivector, Result]:
    cases = [(~valid, Status.INVALID), (full_turn, Status.NOT_UNIQUE)]
    if possible is not None:
        nowhere = full_turn & ~possible
        value = value * only_if(~nowhere, r.constant(1))
        cases.insert(1, (nowhere, Status.SINGULAR))
    return value, outcome(r, *cases)
