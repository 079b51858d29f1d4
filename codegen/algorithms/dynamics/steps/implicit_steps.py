"""Simulations: steps of Radau IIA collocation in the chart at their start, for what is stiff; see collocated.py.

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
    Out,
    Real,
    Reals,
    Rows,
    Vector,
    empty,
    epsilon,
    sqrt,
    unrolled,
)  # fmt: skip
from ..records import MOST_STAGES, Body, Code, Constraint, Parts, kept_record, work_records
from .charts import ChartAlgorithms
from .collocated import (
    IS_LOST,
    IS_SOLVED,
    RENEW,
    SOLVED,
    SOLVED_FOR_TANGENTS,
    accept_step,
    begin_iterations,
    change_of_step,
    diagonal,
    estimate_error,
    guess_stages,
    judge_iteration,
    lagrange,
    most_iterations,
    subtract_slopes,
)  # fmt: skip
from .error_scales import ALMOST, FEWEST_ROUNDINGS, AdaptiveAlgorithms, ErrorScales
from .implicit_tangents import stage_tangents
from .stage_systems import stage_systems

OK, UNDERFLOW = int(Code.OK), int(Code.UNDERFLOW)


def implicit_algorithms(parts: Parts, k: Any, charts: ChartAlgorithms, scales: ErrorScales) -> AdaptiveAlgorithms:
    """Steps of a collocation method in the chart at their start.

    Parameters
    ----------
    parts : Parts
    k : named tuple of KernelSpec
    charts : ChartAlgorithms
    scales : ErrorScales
    """
    count, size, motors_size, state = parts.bodies, parts.size, 8 * parts.bodies, parts.state
    chart, has_tangents = 2 * size, parts.tangents > 0
    is_large, has_large_state = parts.is_large, parts.has_large_state
    work = work_records(parts)
    own_size = work.numbers.size
    Kept: Any = kept_record(parts)
    Work: Any = work.whole
    Integers: Any = work.integers
    groups, _, scale_of_state, _, rounding_of_rates, radius_of_gyration, first_step = scales
    state_rates, chart_rates, end_tangents = charts.state_rates, charts.chart_rates, charts.end_tangents
    start_of_step, land = charts.start_of_step, charts.land
    differentiate_stages, factor_stages, solve_stage = stage_systems(parts, charts)
    enough = SOLVED_FOR_TANGENTS if has_tangents else SOLVED
    solve_tangents: Any = stage_tangents(parts, charts, scales, solve_stage) if has_tangents else None

    # -- errors ----------------------------------------------------------------------------------------------

    @algorithm
    def square_of(
        bodies: Rows[Body], w: Work, start: Vector[state], end: Vector[state], blur: Vector[state], x: Vector[state]
    ) -> Real:  # fmt: skip
        """Sum of squares of an error in units of what is allowed: rotations, paths, their rates."""
        square = 0.0
        for b in range(count):
            body = bodies[b]
            radius = radius_of_gyration(body)
            for rate in unrolled(2):
                at = size * rate + 6 * b
                for group in groups:
                    places, _, is_angular = group
                    error = 0.0
                    rounding = 0.0
                    for j in places:
                        error += x[at + j] * x[at + j]
                        rounding += blur[at + j] * blur[at + j]
                    scale = scale_of_state(0.0, start, end, x, b, rate, group, radius)
                    least = radius
                    if is_angular:
                        least = 1.0
                    if rate == 1:  # rates that move a body no more than by its size in the whole run
                        scale = max(scale, least * w.pace)
                    allowed = max(w.atol * least + w.rtol * scale, sqrt(rounding))
                    if error > 0.0:
                        square += error / (allowed * allowed)
                    elif error != 0.0:
                        square = INFINITY
        return square

    @algorithm
    def find_blur(
        bodies: Rows[Body], w: Work, m: Real, kept: Kept, blur: Out[Vector[state]], x: InOut[Vector[size]]
    ) -> None:
        """What rounding of the accelerations does to a state that solves a step."""
        blur[:] = 0.0
        for b in range(count):
            for group in groups:
                places, _, _ = group
                for j in places:
                    blur[size + 6 * b + j] = rounding_of_rates(w, bodies[b], b, places)
        solve_stage(kept, m, 0, blur[0:chart], x)

    # -- steps -----------------------------------------------------------------------------------------------

    @algorithm
    def improve_stages(
        numbers: Reals, bodies: Rows[Body], springs: IntRows[2], user_loads: IntRows[3], constraints: Rows[Constraint],
        w: InOut[Work], p: InOut[Integers], stop: IntVector[1], scheme: Reals, t: Real, h: Real, start: Vector[state],
        kept: Kept, stages: InOut[Rows[state]], x: InOut[Vector[state]],
    ) -> Int:  # fmt: skip
        """One iteration: changes of the stages, behind them, which are added to them; a status."""
        if is_large:  # noqa: SIM108
            left = w.scratch[0:size]
        else:
            left = empty(size)
        n = p.stages
        for i in range(n):
            change = stages[2 * n + i]
            for j in range(chart):
                x[j] = start[j] + stages[n + i, j]
            status = state_rates(
                numbers, bodies, springs, user_loads, constraints, w[0:own_size], p, stop, t + scheme[i] * h,
                kept.motors, x[0:chart], change[0:chart],
            )  # fmt: skip
            if status != OK:
                return int(status)
        for i in range(n):
            change = stages[2 * n + i]
            subtract_slopes(scheme, n, state, 0, chart, h, i, stages)
            solve_stage(kept, diagonal(scheme, n, i, h), i, change[0:chart], left)
        for i in range(n):
            for j in range(chart):
                stages[n + i, j] += stages[2 * n + i, j]
        return OK

    @algorithm
    def solve_stages(
        numbers: Reals, bodies: Rows[Body], springs: IntRows[2], user_loads: IntRows[3], constraints: Rows[Constraint],
        w: InOut[Work], p: InOut[Integers], stop: IntVector[1], scheme: Reals, t: Real, h: Real, start: Vector[state],
        kept: InOut[Kept], stages: InOut[Rows[state]], x: InOut[Vector[state]], end: InOut[Vector[state]],
    ) -> tuple[Int, Int]:  # fmt: skip
        """Solve the equations of a step; a status, and the number of iterations, 0 where they do not converge."""
        n = p.stages
        begin_iterations(kept.iteration)
        for i in range(most_iterations(n)):
            status = improve_stages(
                numbers, bodies, springs, user_loads, constraints, w, p, stop, scheme, t, h, start, kept, stages, x
            )
            if status != OK:
                return int(status), 0
            for j in range(chart):
                end[j] = start[j] + stages[2 * n - 1, j]
            square = 0.0
            for m in range(n):
                square += square_of(bodies, w, start, end, stages[3 * n], stages[2 * n + m])
            change = sqrt(square / (4.0 * float(count * n)))
            verdict = judge_iteration(i, change, enough, kept.iteration)
            if verdict == IS_LOST:
                return OK, 0
            if verdict == IS_SOLVED:
                return OK, i + 1
            if verdict == RENEW:
                status = differentiate_stages(
                    numbers, bodies, springs, user_loads, constraints, w, p, stop, scheme, t, h, start, kept, stages,
                    x, end,
                )  # fmt: skip
                if status != OK:
                    return int(status), 0
                factor_stages(p, scheme, h, kept)
        return OK, 0

    @algorithm
    def error_of_step(
        numbers: Reals, bodies: Rows[Body], springs: IntRows[2], user_loads: IntRows[3], constraints: Rows[Constraint],
        w: InOut[Work], p: InOut[Integers], stop: IntVector[1], scheme: Reals, t: Real, h: Real, is_careful: Int,
        start: Vector[state], end: Vector[state], kept: InOut[Kept], stages: InOut[Rows[state]],
        x: InOut[Vector[state]],
    ) -> tuple[Int, Real]:  # fmt: skip
        """A status, and the error of a step in units of what is allowed, as a formula of lower order has it.

        A careful one takes the rates where the error leads to: its stiff part is then gone (Hairer and Wanner, IV.8).
        """
        if is_large:  # noqa: SIM108
            left = w.scratch[0:size]
        else:
            left = empty(size)
        n = p.stages
        m = diagonal(scheme, n, 0, h)
        error = stages[3 * n + 2]
        estimate_error(scheme, n, state, m, stages, x)
        solve_stage(kept, m, 0, error[0:chart], left)
        size_of_error = sqrt(square_of(bodies, w, start, end, stages[3 * n], error) / (4.0 * float(count)))
        status = OK
        if size_of_error >= 1.0 and size_of_error < INFINITY and is_careful != 0:
            moved = stages[3 * n + 3]
            for j in range(chart):
                moved[j] = start[j] + error[j]
            status = state_rates(
                numbers, bodies, springs, user_loads, constraints, w[0:own_size], p, stop, t, kept.motors,
                moved[0:chart], error[0:chart],
            )  # fmt: skip
            for j in range(chart):
                error[j] += x[j]
            solve_stage(kept, m, 0, error[0:chart], left)
            size_of_error = sqrt(square_of(bodies, w, start, end, stages[3 * n], error) / (4.0 * float(count)))
        return int(status), size_of_error

    @algorithm
    def adaptive_step(
        numbers: Reals, bodies: Rows[Body], springs: IntRows[2], user_loads: IntRows[3], constraints: Rows[Constraint],
        directions: Reals, w: InOut[Work], p: InOut[Integers], stop: IntVector[1], scheme: Reals,
        end_time: Real, kept: InOut[Kept], stages: InOut[Rows[state]],
    ) -> Int:  # fmt: skip
        """One step that is accepted: the state at its end, and its stages; a status."""
        if has_large_state:
            start = w.chart_start
            end = w.chart_end
            x = w.chart_x
            motors = w.chart_motors
        else:
            start = empty(state)
            end = empty(state)
            x = empty(state)
            motors = empty(motors_size)
        if is_large:  # noqa: SIM108
            left = w.scratch[0:size]
        else:
            left = empty(size)
        n = p.stages
        blur = stages[3 * n]
        rates = stages[3 * n + 1]
        it = kept.iteration
        t = kept.time
        h = kept.next_step
        is_rejected = False
        start_of_step(kept, start)
        p.blurred = 1
        status = chart_rates(
            numbers, bodies, springs, user_loads, constraints, directions, w, p, stop, t, kept.motors, start, rates
        )
        p.blurred = 0
        if status != OK:
            return int(status)
        while True:
            h = min(h, w.longest_step)
            if not t + h * ALMOST < end_time:
                h = end_time - t
            if not h > FEWEST_ROUNDINGS * epsilon() * max(abs(t), kept.least_time):
                return UNDERFLOW
            guess_stages(scheme, n, state, h, kept.dense_step, kept.has_dense, stages)
            was_new = it.has_jacobian == 0.0
            if was_new:
                status = differentiate_stages(
                    numbers, bodies, springs, user_loads, constraints, w, p, stop, scheme, t, h, start, kept, stages,
                    x, end,
                )  # fmt: skip
                if status != OK:
                    return int(status)
            factor_stages(p, scheme, h, kept)
            find_blur(bodies, w, diagonal(scheme, n, 0, h), kept, blur, left)
            status, rounds = solve_stages(
                numbers, bodies, springs, user_loads, constraints, w, p, stop, scheme, t, h, start, kept, stages, x,
                end,
            )  # fmt: skip
            if status != OK:
                return int(status)
            if rounds == 0:
                if was_new:
                    h *= 0.5
                    is_rejected = True
                it.has_jacobian = 0.0  # what they have come to is no place to differentiate at
                it.rate = 0.0
                continue
            is_careful = 1 if is_rejected or kept.has_dense == 0.0 else 0
            status, error = error_of_step(
                numbers, bodies, springs, user_loads, constraints, w, p, stop, scheme, t, h, is_careful, start, end,
                kept, stages, x,
            )  # fmt: skip
            if status != OK:
                return int(status)
            if not error < INFINITY:
                it.has_jacobian = 0.0
                h /= 10.0
                is_rejected = True
                continue
            if has_tangents and error < 1.0:
                status, error_along = solve_tangents(
                    numbers, bodies, springs, user_loads, constraints, directions, w, p, stop, scheme, t, h, start,
                    end, kept, stages, x,
                )  # fmt: skip
                if status != OK:
                    return int(status)
                if not error_along < INFINITY:
                    it.has_jacobian = 0.0
                    h *= 0.5
                    is_rejected = True
                    continue
                error = max(error, error_along)
            change, caution = change_of_step(error, n, rounds, p.method_order)
            if error < 1.0:
                break
            h *= change
            it.has_jacobian = 0.0
            is_rejected = True
        rejected = 1 if is_rejected else 0
        kept.next_step = accept_step(h, error, p.method_order, change, caution, rejected, it)
        for i in range(n):
            for j in range(state):
                stages[i, j] = stages[n + i, j]
        begin = stages[3 * n + 4]
        begin[:] = start
        kept.old_motors[:] = kept.motors
        kept.dense_time = t
        kept.dense_step = h
        kept.has_dense = 1.0
        land(kept, end, motors)
        kept.time = t + h if h < end_time - t else end_time
        return OK

    @algorithm
    def find_state_between(
        numbers: Reals, bodies: Rows[Body], springs: IntRows[2], user_loads: IntRows[3], constraints: Rows[Constraint],
        directions: Reals, w: InOut[Work], p: InOut[Integers], stop: IntVector[1], scheme: Reals, t: Real,
        kept: InOut[Kept], stages: InOut[Rows[state]], motors: Out[Vector[motors_size]], twists: Out[Vector[size]],
    ) -> Int:  # fmt: skip
        """The state at a time within the last step, on the polynomial of its stages; a status."""
        if has_large_state:  # noqa: SIM108
            x = w.chart_x
        else:
            x = empty(state)
        weights = empty(MOST_STAGES)
        lagrange(scheme, p.stages, (t - kept.dense_time) / kept.dense_step, weights)
        for j in range(state):
            x[j] = stages[3 * p.stages + 4, j]
            for i in range(p.stages):
                x[j] += weights[i] * stages[i, j]
        for b in range(count):
            moved = k.moved_chart(kept.old_motors[8 * b : 8 * b + 8], x[6 * b : 6 * b + 6])
            motors[8 * b : 8 * b + 8] = k.near_motor(moved)
        if has_tangents:
            end_tangents(kept.old_motors, x, motors, kept.seen_tangents)
        twists[:] = x[size:chart]
        return OK

    return AdaptiveAlgorithms(first_step, adaptive_step, find_state_between)
