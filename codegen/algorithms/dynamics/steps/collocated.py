"""Steps of Radau IIA collocation: what does not depend on what moves.

Stages are increments Z of the state, with F(Z) = A^-1 Z/h where F are the rates at them. Stiff directions may turn
within a step, and an iteration must know them where they are: each stage has derivatives of its own, J, and all are
solved in turn by a lower triangle L in place of A^-1, (L/h - J) D = F - A^-1 Z/h. The triangle is that of Crout's
factors of A, with which the iteration converges on all that is stable, at once on what is stiff (van der Houwen and de
Swart, Triangularly implicit iteration methods for ODE-IVP solvers, SIAM J. Sci. Comput. 18, 1997).

States are kept row by row: n of the stages of the last step, n of those of the step at hand, n of their changes, and
`MORE_ROWS`: what rounding does to a state, the rates at the start, two for estimates of errors and derivatives, and the
start of the last step.
"""

from __future__ import annotations

from ....ir.loops.algorithm import Algorithm as algorithm
from ....ir.loops.language import INFINITY, InOut, Int, Out, Real, Reals, Vector, empty, exp, log
from ..records import MOST_STAGES, Iteration
from .error_scales import SAFETY

#: States that are kept beside three for each stage.
MORE_ROWS = 5
#: Error of the solution of a step that counts as none, in units of what is allowed; where iterations come to nothing
#: by rounding, it is good enough below the second. Tangents need the forces of stiff springs, which are errors times
#: their stiffness: the last.
SOLVED, NEARLY_SOLVED, SOLVED_FOR_TANGENTS = 1e-2, 0.1, 1e-7
#: Iterations, at most: for three stages, and for each more.
ITERATIONS, MORE_ITERATIONS = 12, 3
#: How fast a first iteration converges, at best.
LEAST_RATE = 0.1
#: Iterations that converge slower have their derivatives renewed.
SLOW = 0.5
#: Steps for which they are renewed at every iteration, once one was slow.
TURNS = 20.0
#: Iterations that converge faster than this keep the derivatives for the next step.
FAST = 0.4
#: Changes of a step, at least and at most; within the last two it stays, with its factors.
LEAST_CHANGE, MOST_CHANGE, KEPT_FROM, KEPT_TO = 0.125, 4.0, 1.0, 1.2
#: Estimates that are smaller count as this, where steps follow from two of them.
LEAST_ERROR = 1e-2
#: Iterations of the tangents of a step, at most; of the tolerance, what they are solved to; changes of tangents, as
#: fractions of these, that may be rounding, and that come to nothing: at first they may grow.
TANGENT_ITERATIONS, TANGENT_SHARE, ROUNDED, MOST_TANGENT_CHANGE = 60, 1e-3, 1e-9, 1e12
#: What follows from an iteration: the next one, with new derivatives; that the step is solved; that it will not be.
GO_ON, RENEW, IS_SOLVED, IS_LOST = 0, 1, 2, 3


@algorithm
def lagrange(scheme: Reals, n: Int, x: Real, weights: Out[Vector[MOST_STAGES]]) -> None:
    """Weights at x of the stages of a step, in the polynomial that is zero at 0."""
    for i in range(n):
        product = x / scheme[i]
        for m in range(n):
            if m != i:
                product *= (x - scheme[m]) / (scheme[i] - scheme[m])
        weights[i] = product


@algorithm
def guess_stages(scheme: Reals, n: Int, size: Int, h: Real, last: Real, has_last: Real, stages: InOut[Reals]) -> None:
    """Stages at first: on the polynomial of the last step, if there was one, or the state at the start."""
    weights = empty(MOST_STAGES)
    for i in range(n):
        own = size * (n + i)
        for j in range(size):
            stages[own + j] = 0.0
        if has_last != 0.0:
            lagrange(scheme, n, 1.0 + scheme[i] * h / last, weights)
            for m in range(n):
                weight = weights[m] - (1.0 if m == n - 1 else 0.0)
                for j in range(size):
                    stages[own + j] += weight * stages[size * m + j]


@algorithm
def subtract_slopes(
    scheme: Reals, n: Int, size: Int, first: Int, last: Int, h: Real, i: Int, stages: InOut[Reals]
) -> None:
    """Rates at a stage, which are in the place of its change: what is left of them beside the stages' slopes."""
    inverse = scheme[2 * n :]
    triangle = scheme[2 * n + n * n :]
    for j in range(first, last):
        total = 0.0
        for m in range(n):
            total += inverse[n * i + m] * stages[size * (n + m) + j]
        for m in range(i):
            total += triangle[n * i + m] * stages[size * (2 * n + m) + j]
        stages[size * (2 * n + i) + j] -= total / h


@algorithm
def judge_tangents(i: Int, change: Real, enough: Real, last: Real) -> Int:
    """What follows from an iteration of tangents, which changed them by so much, as a fraction of what they are."""
    if not change < MOST_TANGENT_CHANGE:
        return IS_LOST
    rate = change / last if i > 0 else LEAST_RATE
    if change == 0.0 or (rate < 1.0 and rate / (1.0 - rate) * change <= enough):
        return IS_SOLVED
    return IS_SOLVED if i > 1 and rate > SLOW and change <= ROUNDED else GO_ON


@algorithm
def diagonal(scheme: Reals, n: Int, i: Int, h: Real) -> Real:
    """Of a stage's system L/h - J the number on the diagonal of the first."""
    return scheme[2 * n + n * n + n * i + i] / h


@algorithm
def estimate_error(scheme: Reals, n: Int, size: Int, m: Real, stages: InOut[Reals], x: InOut[Reals]) -> None:
    """Right side of the system of the first stage whose solution is an error, of lower order; x: without rates."""
    for j in range(size):
        total = 0.0
        for i in range(n):
            total += scheme[n + i] * stages[size * i + size * n + j]
        x[j] = m * total
        stages[size * (3 * n + 2) + j] = x[j] + stages[size * (3 * n + 1) + j]


# -- decisions -------------------------------------------------------------------------------------------------------


@algorithm
def most_iterations(n: Int) -> Int:
    """Iterations of a step, at most."""
    return ITERATIONS + MORE_ITERATIONS * (n - 3)


@algorithm
def begin_iterations(it: InOut[Iteration]) -> None:
    """Before the first one of a step."""
    it.last_change = INFINITY
    it.rate_now = max(it.rate, LEAST_RATE)
    it.worse = 0.0


@algorithm
def judge_iteration(i: Int, change: Real, enough: Real, it: InOut[Iteration]) -> Int:
    """What follows from an iteration of a number, which changed the stages by so much, in units of what is allowed.

    It goes on until what is left is enough.
    """
    last = it.last_change
    if not change < INFINITY:
        return IS_LOST
    if i > 0:
        it.rate_now = change / last
        it.rate = it.rate_now
    rate = it.rate_now
    if change == 0.0 or (rate < 1.0 and rate / (1.0 - rate) * change <= enough):
        return IS_SOLVED
    if change > 0.5 * last and change <= NEARLY_SOLVED:
        return IS_SOLVED
    if change > last:
        it.worse += 1.0
    if it.worse > 2.0:
        return IS_LOST
    if change > SLOW * last:
        it.turns = TURNS
    it.last_change = change
    return RENEW if change > SLOW * last or (i == 0 and it.turns > 0.0) else GO_ON


@algorithm
def change_of_step(error: Real, n: Int, rounds: Int, order: Int) -> tuple[Real, Real]:
    """By what a step of an error changes, for all but its predecessor; and the caution in it."""
    most = most_iterations(n)
    caution = SAFETY * float(2 * most + 1) / float(2 * most + rounds)
    change = MOST_CHANGE
    if error > 0.0:
        change = caution * exp(-log(error) / float(order))
    return min(max(change, LEAST_CHANGE), MOST_CHANGE), caution


@algorithm
def accept_step(
    h: Real, error: Real, order: Int, suggested: Real, caution: Real, is_rejected: Int, it: InOut[Iteration]
) -> Real:
    """Note a step that is accepted; the length of the next one."""
    change = suggested
    if it.last_step > 0.0 and error > 0.0:
        ratio = error * error / it.last_error
        predicted = caution * h / it.last_step * exp(-log(ratio) / float(order))
        change = max(min(change, predicted), LEAST_CHANGE)
    if is_rejected != 0:
        change = min(change, 1.0)
    it.last_step = h
    it.last_error = max(error, LEAST_ERROR)
    it.turns = max(it.turns - 1.0, 0.0)
    it.has_jacobian = 1.0 if it.rate < FAST and it.turns == 0.0 else 0.0
    if it.has_jacobian != 0.0 and change >= KEPT_FROM and change <= KEPT_TO:
        change = 1.0
    return h * change
