"""The pose of least cost over given matches, by Gauss-Newton, and what each match has to say in its covariance."""

from __future__ import annotations

from ...algorithms.dense import diagonalize
from ...algorithms.registration_layout import MOTOR, RATES, TWIST, Head
from ...ir.loops.algorithm import Algorithm as algorithm
from ...ir.loops.language import (
    INFINITY,
    InOut,
    Int,
    Ints,
    Matrix,
    Out,
    Real,
    Reals,
    Rows,
    Static,
    Vector,
    empty,
    sqrt,
    zeros,
)
from .stages import rates, step_motor

#: A motion is free if its eigenvalue is at most this, relative to the largest one.
FREE = 1e-9
#: A smaller change of the twist ends the steps.
MIN_STEP = 1e-14
#: After a smaller step the eigenmodes of the matrix are reused: the error of the next step is as small, relative to it.
MODE_REUSE_STEP = 1e-6
#: Largest number of halvings of a step.
MAX_HALVINGS = 8
#: Rounding of a cost, relative to it; its square is the absolute one.
COST_SLACK = 1e-14
#: Smallest fraction of its own residual that a match leaves: less where it alone determines a motion.
MIN_OWN_RESIDUAL = 1e-3


@algorithm
def weighted_rates(
    kinds: Static,
    pair_kinds: Ints,
    query: Ints,
    reference: Ints,
    weights: Reals,
    motor: Vector[MOTOR],
    heads: Rows[Head],
    reals: Reals,
    found: InOut[Rows[RATES]],
) -> Real:
    """Rates of all matches times their weights, and the sum of their costs; zeros for a match without a rotor, or of
    no weight.
    """
    total = 0.0
    for i in range(len(pair_kinds)):
        row = found[i]
        rates(kinds, pair_kinds[i], motor, query[i], reference[i], heads, reals, row)
        finite = 0.0
        for k in range(RATES):
            row[k] *= weights[i]
            finite += row[k] - row[k]
        if not (finite == 0.0 and weights[i] > 0.0):
            row[:] = 0.0
        total += row[0]
    return total


@algorithm
def summed_rates(rows: Rows[RATES], gradient: Out[Vector[TWIST]], matrix: Out[Matrix[TWIST, TWIST]]) -> None:
    """Gradient and Gauss-Newton matrix of all matches, added in their order."""
    total = zeros(RATES)
    for i in range(len(rows)):
        for k in range(RATES):
            total[k] += rows[i, k]
    at = 1 + TWIST
    for i in range(TWIST):
        gradient[i] = total[1 + i]
        for j in range(i, TWIST):
            matrix[i, j] = matrix[j, i] = total[at]
            at += 1


@algorithm
def descend(
    kinds: Static,
    steps: Int,
    pair_kinds: Ints,
    query: Ints,
    reference: Ints,
    weights: Reals,
    heads: Rows[Head],
    reals: Reals,
    motor: InOut[Vector[MOTOR]],
    found: InOut[Rows[RATES]],
    trial: InOut[Rows[RATES]],
) -> Int:
    """Gauss-Newton on the costs of matches; a step that makes them greater is halved. Steps that were made.

    ``found`` are the rates at the motor in the end, ``trial`` is room for as many.
    """
    cost = weighted_rates(kinds, pair_kinds, query, reference, weights, motor, heads, reals, found)
    size = INFINITY
    gradient = empty(TWIST)
    matrix = empty(TWIST, TWIST)
    values = zeros(TWIST)
    vectors = zeros(TWIST, TWIST)
    step = empty(TWIST)
    moved = empty(MOTOR)
    for taken in range(steps):
        summed_rates(found, gradient, matrix)
        if size > MODE_REUSE_STEP:
            diagonalize(matrix, vectors, TWIST)
            for p in range(TWIST):
                values[p] = matrix[p, p]
        most = 0.0
        for p in range(TWIST):
            most = values[p] if values[p] > most else most
        step[:] = 0.0
        for p in range(TWIST):
            if values[p] > FREE * most:
                along = 0.0
                for k in range(TWIST):
                    along += vectors[k, p] * gradient[k]
                for k in range(TWIST):
                    step[k] -= vectors[k, p] * (along / values[p])
        limit = cost * (1.0 + COST_SLACK) + COST_SLACK * COST_SLACK
        is_lower = False
        for _ in range(MAX_HALVINGS):
            moved[:] = step_motor(motor, step)
            changed = weighted_rates(kinds, pair_kinds, query, reference, weights, moved, heads, reals, trial)
            if changed <= limit:
                is_lower = True
                cost = changed
                break
            for k in range(TWIST):
                step[k] *= 0.5
        if not is_lower:
            return taken + 1
        motor[:] = moved
        for i in range(len(found)):
            found[i][:] = trial[i]
        size = 0.0
        for k in range(TWIST):
            size = abs(step[k]) if abs(step[k]) > size else size
        if size < MIN_STEP:
            return taken + 1
    return steps


@algorithm
def influences(rates: Vector[RATES], whiten: Matrix[TWIST, TWIST], influence: Out[Vector[TWIST]]) -> tuple[Real, Real]:
    """What a match moves the twist by, in place of its error, where its influence on its own residual is removed.

    Columns of ``whiten`` are the modes of the sum of all matrices over the roots of their eigenvalues; zero for free
    ones. Returned are the trace of the match's information, and its sum of squares.
    """
    half = empty(TWIST, TWIST)
    at = 1 + TWIST
    for i in range(TWIST):
        for j in range(i, TWIST):
            half[i, j] = half[j, i] = rates[at]
            at += 1
    side = empty(TWIST, TWIST)
    for i in range(TWIST):
        for q in range(TWIST):
            side[i, q] = 0.0
            for j in range(TWIST):
                side[i, q] += half[i, j] * whiten[j, q]
    left = empty(TWIST, TWIST)
    trace = 0.0
    squares = 0.0
    for p in range(TWIST):
        for q in range(p, TWIST):
            own = 0.0
            for i in range(TWIST):
                own += whiten[i, p] * side[i, q]
            left[p, q] = left[q, p] = (1.0 if p == q else 0.0) - own
            trace += own if p == q else 0.0
            squares += own * own if p == q else 2.0 * own * own
    axes = empty(TWIST, TWIST)
    diagonalize(left, axes, TWIST)
    gradient = zeros(TWIST)
    for p in range(TWIST):
        for i in range(TWIST):
            gradient[p] += whiten[i, p] * rates[1 + i]
    spread = zeros(TWIST)
    for p in range(TWIST):
        along = 0.0
        for k in range(TWIST):
            along += axes[k, p] * gradient[k]
        remaining = left[p, p] if left[p, p] > MIN_OWN_RESIDUAL else MIN_OWN_RESIDUAL
        for k in range(TWIST):
            spread[k] += axes[k, p] * (along / sqrt(remaining))
    for i in range(TWIST):
        influence[i] = 0.0
        for p in range(TWIST):
            influence[i] += whiten[i, p] * spread[p]
    return trace, squares
