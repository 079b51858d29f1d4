"""Where a model's frame stands: the point of least squared distances from all its objects but a few far ones."""

from __future__ import annotations

from ...algorithms.dense import diagonalize, select_rank
from ...algorithms.registration_layout import ELEMENT, POSITION
from ...ir.loops.algorithm import Algorithm as algorithm
from ...ir.loops.language import InOut, Int, Ints, Out, Real, Reals, Rows, Static, Vector, empty, zeros
from .registration import KIND_SETS

#: Numbers of the upper half of a matrix of positions.
MATRIX = 6


@algorithm
def square_off(
    kinds: Static,
    kind: Int,
    point: Vector[POSITION],
    element: Vector[ELEMENT],
    square: Out[Vector[1]],
    gradient: Out[Vector[POSITION]],
    matrix: Out[Vector[MATRIX]],
) -> None:
    """How far a point is off an object, squared, and halves of the first and second rates by the point."""
    for each in KIND_SETS[kinds]:
        if kind == each.number:
            square[:], gradient[:], matrix[:] = each.off(point, element)
            return


@algorithm
def nearest_point(
    kinds: Static,
    object_kinds: Ints,
    elements: Rows[ELEMENT],
    near: Ints,
    rank_tolerance: Real,
    point: Out[Vector[POSITION]],
) -> None:
    """The nearest point to objects that are near; it starts between them, and stays where they say nothing."""
    about = zeros(POSITION)
    count = 0
    for i in range(len(object_kinds)):
        if near[i] != 0:
            for k in range(POSITION):
                about[k] += elements[i, k]
            count += 1
    for k in range(POSITION):
        about[k] /= float(count)
    pull = zeros(POSITION)
    a = zeros(POSITION, POSITION)
    square = empty(1)
    gradient = empty(POSITION)
    matrix = empty(MATRIX)
    for i in range(len(object_kinds)):
        if near[i] != 0:
            square_off(kinds, object_kinds[i], about, elements[i], square, gradient, matrix)
            at = 0
            for p in range(POSITION):
                pull[p] += gradient[p]
                for q in range(p, POSITION):
                    a[p, q] += matrix[at]
                    at += 1
    for p in range(POSITION):
        for q in range(p):
            a[p, q] = a[q, p]
    v = empty(POSITION, POSITION)
    diagonalize(a, v, POSITION)
    most = 0.0
    for p in range(POSITION):
        most = a[p, p] if a[p, p] > most else most
    point[:] = about
    for p in range(POSITION):
        if not a[p, p] > rank_tolerance * most:
            continue
        along = 0.0
        for k in range(POSITION):
            along += v[k, p] * pull[k]
        for k in range(POSITION):
            point[k] -= v[k, p] * (along / a[p, p])


@algorithm
def robust_center(
    kinds: Static,
    object_kinds: Ints,
    elements: Rows[ELEMENT],
    rounds: Int,
    rank: Int,
    outlier_factor: Real,
    rounding: Real,
    rank_tolerance: Real,
    squares: InOut[Reals],
    ordered: InOut[Reals],
    near: InOut[Ints],
    point: Out[Vector[POSITION]],
) -> None:
    """The center of least squared distances from all objects except outliers, which are left out in rounds.

    As far as is usual is the object of some rank; ``rounding`` is relative to the largest coordinate, and
    ``rank_tolerance`` to the direction of which objects say most.
    """
    smallest = 0.0
    for i in range(len(object_kinds)):
        near[i] = 1
        for k in range(POSITION):
            far = abs(elements[i, k])
            smallest = far if far > smallest else smallest
    smallest *= rounding
    square = empty(1)
    gradient = empty(POSITION)
    matrix = empty(MATRIX)
    for _ in range(rounds):
        nearest_point(kinds, object_kinds, elements, near, rank_tolerance, point)
        for i in range(len(object_kinds)):
            square_off(kinds, object_kinds[i], point, elements[i], square, gradient, matrix)
            squares[i] = ordered[i] = square[0]
        usual = select_rank(ordered, rank)
        least = smallest * smallest
        limit = outlier_factor * outlier_factor * (usual if usual > least else least)
        changed = 0
        for i in range(len(object_kinds)):
            is_near = 1 if squares[i] <= limit else 0
            changed = 1 if is_near != near[i] else changed
            near[i] = is_near
        if changed == 0:
            break
