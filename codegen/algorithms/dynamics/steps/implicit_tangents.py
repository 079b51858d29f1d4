"""Simulations: tangents of implicit steps, which solve the equations of the stages along directions of parameters.

A step's stages obey A^-1 Z/h = F(Z). Along a direction these equations are linear, with the derivatives J of the rates
that the iteration for the stages has, and are solved by the same triangle: see collocated.py. What each iteration
leaves is by exact derivatives, so that tangents do not depend on how old J is.

Annotations are evaluated: sizes are those of the kind of simulation.
"""

from typing import Any

from ....ir.loops.algorithm import Algorithm as algorithm
from ....ir.loops.language import (
    INFINITY,
    InOut,
    Int,
    IntRows,
    IntVector,
    Real,
    Reals,
    Rows,
    Vector,
    empty,
    sqrt,
    unrolled,
)  # fmt: skip
from ..records import Body, Code, Constraint, Parts, kept_record, work_records
from .charts import ChartAlgorithms
from .collocated import (
    GO_ON,
    IS_SOLVED,
    TANGENT_ITERATIONS,
    TANGENT_SHARE,
    diagonal,
    estimate_error,
    judge_tangents,
    subtract_slopes,
)  # fmt: skip
from .error_scales import ErrorScales

OK = int(Code.OK)


def stage_tangents(parts: Parts, charts: ChartAlgorithms, scales: ErrorScales, solve_stage: algorithm) -> algorithm:
    """The tangents at the stages of a step that is solved, and at its end; a status, and the error of these.

    Parameters
    ----------
    parts : Parts
        With tangents.
    charts : ChartAlgorithms
    scales : ErrorScales
    solve_stage : algorithm
        See `StageSystems`.
    """
    count, size, state = parts.bodies, parts.size, parts.state
    chart, tangents, is_large = 2 * size, parts.tangents, parts.is_large
    work = work_records(parts)
    own_size = work.numbers.size
    Kept: Any = kept_record(parts)
    Work: Any = work.whole
    Integers: Any = work.integers
    groups, _, scale_of_state, scale_of_tangent, _, radius_of_gyration, _ = scales
    rates_along = charts.rates_along

    @algorithm
    def squares_of_block(
        bodies: Rows[Body], n: Int, b: Int, first: Int, start: Vector[state], stages: Rows[state]
    ) -> tuple[Real, Real]:  # fmt: skip
        """Of a body's motions or their rates along a direction: squares of the last change, and of all, at stages."""
        radius = radius_of_gyration(bodies[b])
        change = 0.0
        whole = 0.0
        for places, _, is_angular in groups:
            unit = 1.0
            if not is_angular:
                unit = 1.0 / (radius * radius)
            for i in range(n):
                for j in places:
                    at = first + j
                    value = start[at] + stages[n + i, at]
                    change += unit * stages[2 * n + i, at] * stages[2 * n + i, at]
                    whole += unit * value * value
        return change, whole

    @algorithm
    def change_of_tangents(
        bodies: Rows[Body], n: Int, h: Real, start: Vector[state], stages: Rows[state]
    ) -> Real:  # fmt: skip
        """The largest change of a body's tangent in an iteration, as a fraction of what it is."""
        worst = 0.0
        for q in range(tangents):
            most = 0.0  # of a motion in a step; what is a millionth of it is measured against that
            for b in range(count):
                for rate in range(2):
                    first = chart * (1 + q) + size * rate + 6 * b
                    _, whole = squares_of_block(bodies, n, b, first, start, stages)
                    most = max(most, whole * (h * h if rate == 1 else 1.0))
            for b in range(count):
                for rate in range(2):
                    first = chart * (1 + q) + size * rate + 6 * b
                    change, whole = squares_of_block(bodies, n, b, first, start, stages)
                    unit = h * h if rate == 1 else 1.0
                    if change > 0.0:
                        worst = max(worst, unit * change / max(unit * whole, 1e-12 * most))
                    elif change != 0.0:
                        worst = INFINITY
        return sqrt(worst)

    @algorithm
    def error_of_tangents(
        bodies: Rows[Body], w: Work, start: Vector[state], end: Vector[state], x: Vector[state]
    ) -> Real:  # fmt: skip
        """The worst error of a tangent in units of what is allowed."""
        worst = 0.0
        for q in range(tangents):
            square = 0.0
            for b in range(count):
                radius = radius_of_gyration(bodies[b])
                for rate in unrolled(2):
                    at = chart * (1 + q) + size * rate + 6 * b
                    for group in groups:
                        places, _, is_angular = group
                        error = 0.0
                        for j in places:
                            error += x[at + j] * x[at + j]
                        least = radius
                        if is_angular:
                            least = 1.0
                        of_state = scale_of_state(0.0, start, end, end, b, rate, group, radius)
                        if rate == 1:  # as of states: rates that move a body no more than by its size
                            of_state = max(of_state, least * w.pace)
                        scale = scale_of_tangent(0.0, start, end, end, at, group, radius, of_state)
                        allowed = w.atol * least + w.rtol * scale
                        if error > 0.0:
                            square += error / (allowed * allowed)
                        elif error != 0.0:
                            square = INFINITY
            worst = max(worst, square)
        return sqrt(worst / (4.0 * float(count)))

    @algorithm
    def improve_tangents(
        numbers: Reals, bodies: Rows[Body], springs: IntRows[2], user_loads: IntRows[3],
        constraints: Rows[Constraint], directions: Reals, w: InOut[Work], p: InOut[Integers], stop: IntVector[1],
        scheme: Reals, t: Real, h: Real, start: Vector[state], kept: Kept, stages: InOut[Rows[state]],
        x: InOut[Vector[state]],
    ) -> Int:  # fmt: skip
        """One iteration of the tangents of all stages, by the systems of these; a status."""
        if is_large:  # noqa: SIM108
            left = w.scratch[0:size]
        else:
            left = empty(size)
        n = p.stages
        slopes = stages[3 * n + 2]
        moved = stages[3 * n + 3]
        status = OK
        for i in range(n):
            change = stages[2 * n + i]
            for j in range(chart):
                x[j] = start[j] + stages[n + i, j]
            for q in range(tangents):
                at = chart * (1 + q)
                along = directions[p.stride * q :]
                for j in range(chart):
                    moved[j] = start[at + j] + stages[n + i, at + j]
                if status == OK:
                    status = rates_along(
                        numbers, bodies, springs, user_loads, constraints, w[0:own_size], p, stop,
                        t + scheme[i] * h, kept.motors, x[0:chart], slopes[0:chart], along, along, w.along,
                        moved[0:chart], change[at : at + chart],
                    )  # fmt: skip
                    p.held = 1
            p.held = 0
        for i in range(n):
            change = stages[2 * n + i]
            subtract_slopes(scheme, n, state, chart, state, h, i, stages)
            for q in range(tangents):
                at = chart * (1 + q)
                solve_stage(kept, diagonal(scheme, n, i, h), i, change[at : at + chart], left)
        for i in range(n):
            for j in range(chart, state):
                stages[n + i, j] += stages[2 * n + i, j]
        return int(status)

    @algorithm
    def solve_tangents(
        numbers: Reals, bodies: Rows[Body], springs: IntRows[2], user_loads: IntRows[3],
        constraints: Rows[Constraint], directions: Reals, w: InOut[Work], p: InOut[Integers], stop: IntVector[1],
        scheme: Reals, t: Real, h: Real, start: Vector[state], end: InOut[Vector[state]], kept: InOut[Kept],
        stages: InOut[Rows[state]], x: InOut[Vector[state]],
    ) -> tuple[Int, Real]:  # fmt: skip
        """The tangents at the stages of a step that is solved, and at its end; a status, and the error of these.

        The error is infinite where iterations do not converge.
        """
        if is_large:  # noqa: SIM108
            left = w.scratch[0:size]
        else:
            left = empty(size)
        n = p.stages
        last = INFINITY
        verdict = GO_ON
        for i in range(TANGENT_ITERATIONS):
            if verdict == GO_ON:
                status = improve_tangents(
                    numbers, bodies, springs, user_loads, constraints, directions, w, p, stop, scheme, t, h, start,
                    kept, stages, x,
                )  # fmt: skip
                if status != OK:
                    return int(status), INFINITY
                change = change_of_tangents(bodies, n, h, start, stages)
                verdict = judge_tangents(i, change, TANGENT_SHARE * w.rtol, last)
                last = change
        if verdict != IS_SOLVED:
            return OK, INFINITY
        for j in range(chart, state):
            end[j] = start[j] + stages[2 * n - 1, j]
        m = diagonal(scheme, n, 0, h)
        error = stages[3 * n + 2]
        estimate_error(scheme, n, state, m, stages, x)
        for q in range(tangents):
            at = chart * (1 + q)
            solve_stage(kept, m, 0, error[at : at + chart], left)
        return OK, error_of_tangents(bodies, w, start, end, error)

    return solve_tangents
