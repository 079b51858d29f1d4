"""Motors from what people have and back: translations, turns about axes, rotation matrices, 4x4 matrices.

One text for CGA and PGA: n is n_inf or e0 (see `euclidean`). Rotors act by x -> r x ~r.
"""

from __future__ import annotations

from fractions import Fraction

from ...algebra.multivector import Mask, Multivector, absolute, cos, select, sin, sqrt
from ...status import Status
from ...trace.outputs import Result, named, row
from ..objects.euclidean import (
    attached_part,
    axes,
    canonical_sign,
    coordinates,
    direction_of,
    euclidean_part,
    null_vector,
    space,
)
from ..products.outcome import outcome, where_or_nan

#: How far f_i . f_j of a matrix's columns may be from the unit matrix: matrices are often read from text.
MATRIX_TOLERANCE = Fraction(1, 1000)


def translator(t: Multivector) -> Multivector:
    """1 - t n/2: translation by the vector t."""
    return 1 - t * null_vector(t) / 2


def rotor(axis: Multivector, angle: Multivector) -> tuple[Multivector, Result]:
    """cos(angle/2) - sin(angle/2) a I3: counter-clockwise about the unit vector a along ``axis``, at the origin.

    The sign is the angle's: a full turn is -1. INVALID: the axis has no direction.
    """
    a, scale = direction_of(axis)
    turn = cos(angle / 2) - sin(angle / 2) * (a * space(axis))
    return turn, outcome(axis, (~(scale > 0), Status.INVALID))


def rotor_about(axis: Multivector, angle: Multivector, point: Multivector) -> tuple[Multivector, Result]:
    """The same about the axis through a point (the Euclidean vector to it)."""
    turn, status = rotor(axis, angle)
    return translator(point) >> turn, status


def planar_rotor(angle: Multivector, point: Multivector) -> Multivector:
    """Rotation of the plane about a point, counter-clockwise from e1 to e2."""
    return translator(point) >> turn(angle)


def turn(angle: Multivector) -> Multivector:
    """Rotation of the plane about the origin: cos(angle/2) - sin(angle/2) e12."""
    return cos(angle / 2) - sin(angle / 2) * space(angle)


def motor_parts(r: Multivector) -> tuple[Result, Result]:
    """Rotor about the origin and translation vector t of a unit motor, r = (1 - t n/2) rotor."""
    turn = euclidean_part(r)
    return named("rotor", turn), named("translation", translation_of(r))


def translation_of(r: Multivector) -> Multivector:
    """Image of the origin under a unit motor."""
    return -2 * attached_part(r * ~euclidean_part(r)).grade(1)


def translator_parameters(r: Multivector) -> Result:
    """The vector of a translation."""
    return row(coordinates(translation_of(r)), "t")


def motor_to_matrix(r: Multivector) -> Result:
    """The homogeneous matrix of a unit motor, row by row: rotation columns r e_k ~r, then the translation."""
    turn = euclidean_part(r)
    columns = [coordinates(turn >> e) for e in axes(r)] + [coordinates(translation_of(r))]
    size = len(columns)
    entries = [columns[j][i] for i in range(size - 1) for j in range(size)]
    last = [r.constant(int(j == size - 1)) for j in range(size)]
    return row(entries + last, "matrix")


def rotor_from_columns(columns: list[Multivector]) -> Multivector:
    """The unit rotor with <R>_0 >= 0 that takes e_k to the k-th column of a rotation matrix, at every angle.

    For every even A, A + sum_k f_k A e_k = 4 <~R A>_0 R. The A among 1, e12, e13, e23 with the
    largest factor is taken, so nothing cancels (no angle is special).
    """
    basis = axes(columns[0])
    planes = [a ^ b for i, a in enumerate(basis) for b in basis[i + 1 :]]
    candidates = []
    for a in [columns[0].constant(1), *planes]:
        multiple = a.sum([a, *(f * a * e for f, e in zip(columns, basis, strict=True))])
        candidates.append((multiple.scalar_product(~a), multiple))  # (4 <~R A>_0^2, 4 <~R A>_0 R)
    weight, best = candidates[0]
    for other_weight, other in candidates[1:]:
        better = other_weight > weight
        weight, best = select(better, other_weight, weight), select(better, other, best)
    unit = best / sqrt(best.scalar_product(~best))
    return unit * canonical_sign(unit)


def is_rotation(columns: list[Multivector]) -> Mask:
    """Return whether the columns are orthonormal and right-handed, to `MATRIX_TOLERANCE`."""
    volume = columns[0]
    for f in columns[1:]:
        volume = volume ^ f
    mask = volume.scalar_product(~space(volume)) > 0
    for i, f in enumerate(columns):
        for j, g in enumerate(columns[i:], i):
            mask = mask & (absolute((f * g).grade(0) - int(i == j)) <= MATRIX_TOLERANCE)
    return mask


def motor_from_matrix(
    e1: Multivector, e2: Multivector, e3: Multivector, origin: Multivector
) -> tuple[Multivector, Result]:
    """Unit motor with <R>_0 >= 0 from the images of e1, e2, e3 (columns) and of the origin, as vectors.

    The tie <R>_0 = 0 is broken by the first coefficient that is not zero. INVALID: the columns are no rotation.
    """
    columns = [e1, e2, e3]
    valid = is_rotation(columns)
    turn = rotor_from_columns(columns)
    unit = where_or_nan(valid, origin.constant(1))
    return translator(origin) * (turn * unit), outcome(origin, (~valid, Status.INVALID))


def rotor_from_matrix(e1: Multivector, e2: Multivector, e3: Multivector) -> tuple[Multivector, Result]:
    """The same for a rotation matrix, from the images of e1, e2, e3."""
    columns = [e1, e2, e3]
    valid = is_rotation(columns)
    return rotor_from_columns(columns) * where_or_nan(valid, e1.constant(1)), outcome(e1, (~valid, Status.INVALID))
