"""Simulations: steps of a Runge-Kutta pair that choose their own size, and states between two of them.

Annotations are evaluated: sizes are those of the kind of simulation.
"""

from typing import Any

from ....ir.loops.algorithm import Algorithm as algorithm
from ....ir.loops.algorithm import inlined
from ....ir.loops.language import (
    INFINITY,
    InOut,
    Int,
    IntRows,
    IntVector,
    Matrix,
    Out,
    Real,
    Reals,
    Rows,
    Static,
    Vector,
    empty,
    epsilon,
    exp,
    log,
    sqrt,
    unrolled,
)  # fmt: skip
from ..records import Body, Code, Constraint, Parts, kept_record, work_records
from .charts import ChartAlgorithms
from .error_scales import (
    ALMOST,
    FEWEST_ROUNDINGS,
    LEAST_CHANGE,
    MOST_CHANGE,
    SAFETY,
    AdaptiveAlgorithms,
    ErrorScales,
)

OK, UNDERFLOW = int(Code.OK), int(Code.UNDERFLOW)
#: Rows of an interpolant that all schemes have: the change, the start, and two terms of the cubic one.
CUBIC = 4


def adaptive_algorithms(parts: Parts, k: Any, charts: ChartAlgorithms, scales: ErrorScales) -> AdaptiveAlgorithms:
    """Steps of a pair in the chart at their start.

    Parameters
    ----------
    parts : Parts
    k : named tuple of KernelSpec
    charts : ChartAlgorithms
    scales : ErrorScales
    """
    count, size, motors_size, state = parts.bodies, parts.size, 8 * parts.bodies, parts.state
    chart, tangents, has_tangents, lanes = 2 * size, parts.tangents, parts.tangents > 0, parts.lanes
    place_of_tangent = charts.place_of_tangent
    has_large_state = parts.has_large_state
    groups, _, scale_of_state, scale_of_tangent, rounding_of_rates, radius_of_gyration, first_step = scales
    work = work_records(parts)
    Kept: Any = kept_record(parts)
    Work: Any = work.whole
    Integers: Any = work.integers
    chart_rates, end_tangents, land = charts.chart_rates, charts.end_tangents, charts.land
    add_stages, start_of_step, end_of_step = charts.add_stages, charts.start_of_step, charts.end_of_step

    @inlined
    def add_squares(
        p: Integers, scheme: Reals, stages: Rows[state], at: Int, apart: Static, places: Static, allowed: Real,
        squares: InOut[Vector[2]],
    ) -> None:  # fmt: skip
        """Add squares of two error estimates of one group, in units of what is allowed."""
        first = p.all_stages * p.all_stages + p.all_stages + p.stages
        second = first + p.stages + 1
        for j in places:
            error = 0.0
            other = 0.0
            for i in range(p.stages + 1):
                error += scheme[first + i] * stages[i, at + apart * j]
                other += scheme[second + i] * stages[i, at + apart * j]
            # not a quotient of squares: those of the least speeds are zero
            if abs(error) > 0.0:
                error = error / allowed
                squares[0] += error * error
            if abs(other) > 0.0:
                other = other / allowed
                squares[1] += other * other

    @algorithm
    def measure(
        bodies: Rows[Body], w: Work, p: Integers, scheme: Reals, h: Real, start: Vector[state], end: Vector[state],
        stages: Rows[state], squares: Out[Matrix[1 + tangents, 2]],
    ) -> None:  # fmt: skip
        """Of the state, then of tangents: sums of squares of two error estimates, in units of what is allowed."""
        squares[:] = 0.0
        for b in range(count):
            body = bodies[b]
            radius = radius_of_gyration(body)
            for rate in unrolled(2):
                at = size * rate + 6 * b
                for group in groups:
                    places, _, is_angular = group
                    least = 0.0
                    if rate == 1:
                        least = h * rounding_of_rates(w, body, b, places)
                    scale = scale_of_state(h, start, end, stages[0], b, rate, group, radius)
                    atol = w.atol * (1.0 if is_angular else radius)
                    allowed = max(atol + w.rtol * scale, least)
                    add_squares(p, scheme, stages, at, 1, places, allowed, squares[0])
                    for q in range(tangents):
                        to = place_of_tangent(q) + lanes * at
                        own = scale_of_tangent(h, start, end, stages[0], to, group, radius, scale)
                        allowed = max(atol + w.rtol * own, least)
                        add_squares(p, scheme, stages, to, lanes, places, allowed, squares[1 + q])

    @algorithm
    def error_of_step(
        bodies: Rows[Body], w: Work, p: Integers, scheme: Reals, h: Real, start: Vector[state], end: Vector[state],
        stages: Rows[state],
    ) -> Real:  # fmt: skip
        """The error of a step in units of what is allowed, the worst of state and tangents."""
        worst = 0.0
        squares = empty(1 + tangents, 2)
        measure(bodies, w, p, scheme, h, start, end, stages, squares)
        for column in range(1 + tangents):
            first, second = squares[column, 0], squares[column, 1]
            both = first + 0.01 * second
            error = 0.0
            if both > 0.0:
                error = h * first / sqrt(both * 4.0 * float(count))
            elif both != 0.0:
                error = INFINITY
            if not error <= worst:
                worst = error
        return worst

    @algorithm
    def adaptive_step(
        numbers: Reals, bodies: Rows[Body], springs: IntRows[2], user_loads: IntRows[3], constraints: Rows[Constraint],
        directions: Reals, w: InOut[Work], p: InOut[Integers], stop: IntVector[1], scheme: Reals,
        end_time: Real, kept: InOut[Kept], stages: InOut[Rows[state]],
    ) -> Int:  # fmt: skip
        """One step that is accepted: the state at its end, and what an interpolant needs; a status."""
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
        t = kept.time
        h = kept.next_step
        is_rejected = False
        start_of_step(kept, start)
        p.blurred = 1
        status = add_stages(
            numbers, bodies, springs, user_loads, constraints, directions, w, p, stop, scheme, t, h, kept.motors, start,
            stages, 0, 1, x,
        )  # fmt: skip
        p.blurred = 0
        if status != OK:
            return int(status)
        while True:
            h = min(h, w.longest_step)
            if not t + h * ALMOST < end_time:
                h = end_time - t
            if not h > FEWEST_ROUNDINGS * epsilon() * max(abs(t), kept.least_time):
                return UNDERFLOW
            status = add_stages(
                numbers, bodies, springs, user_loads, constraints, directions, w, p, stop, scheme, t, h, kept.motors,
                start, stages, 1, p.stages, x,
            )  # fmt: skip
            if status != OK:
                return int(status)
            end_of_step(p, scheme, start, h, stages, end)
            status = chart_rates(
                numbers, bodies, springs, user_loads, constraints, directions, w, p, stop, t + h, kept.motors, end,
                stages[p.stages],
            )  # fmt: skip
            if status != OK:
                return int(status)
            error = error_of_step(bodies, w, p, scheme, h, start, end, stages)
            if not error < INFINITY:  # nor what is not a number
                h /= 10.0
                is_rejected = True
                continue
            factor = SAFETY * exp(-log(error) / float(p.method_order)) if error > 0.0 else MOST_CHANGE
            if error < 1.0:
                kept.next_step = h * min(max(factor, LEAST_CHANGE), 1.0 if is_rejected else MOST_CHANGE)
                break
            h *= max(factor, LEAST_CHANGE)
            is_rejected = True
        kept.old_motors[:] = kept.motors
        kept.dense_time = t
        kept.dense_step = h
        kept.has_dense = 0.0
        change = stages[p.all_stages]
        old = stages[p.all_stages + 1]
        for j in range(state):
            change[j] = end[j] - start[j]
            old[j] = start[j]
        land(kept, end, motors)
        kept.time = t + h if h < end_time - t else end_time
        return OK

    @algorithm
    def add_interpolant(
        numbers: Reals, bodies: Rows[Body], springs: IntRows[2], user_loads: IntRows[3], constraints: Rows[Constraint],
        directions: Reals, w: InOut[Work], p: InOut[Integers], stop: IntVector[1], scheme: Reals, kept: InOut[Kept],
        stages: InOut[Rows[state]], x: InOut[Vector[state]],
    ) -> Int:  # fmt: skip
        """The interpolant of the last step, made where a state within it is asked for; a status."""
        t = kept.dense_time
        h = kept.dense_step
        dense = p.all_stages * p.all_stages + p.all_stages + 3 * p.stages + 2
        change = stages[p.all_stages]
        start = stages[p.all_stages + 1]
        for i in range(p.stages + 1, p.all_stages):
            x[:] = start
            for m in range(i):
                weight = h * scheme[p.all_stages * i + m]
                for j in range(state):
                    x[j] += weight * stages[m, j]
            time = t + scheme[p.all_stages * p.all_stages + i] * h
            status = chart_rates(
                numbers,
                bodies,
                springs,
                user_loads,
                constraints,
                directions,
                w,
                p,
                stop,
                time,
                kept.old_motors,
                x,
                stages[i],
            )
            if status != OK:
                return int(status)
        for j in range(state):
            delta = change[j]
            first = h * stages[0, j]
            last = h * stages[p.stages, j]
            stages[p.all_stages + 2, j] = first - delta
            stages[p.all_stages + 3, j] = 2.0 * delta - (last + first)
            for r in range(p.dense_rows):
                total = 0.0
                for i in range(p.all_stages):
                    total += scheme[dense + p.all_stages * r + i] * stages[i, j]
                stages[p.all_stages + CUBIC + r, j] = h * total
        kept.has_dense = 1.0
        return OK

    @algorithm
    def find_state_between(
        numbers: Reals, bodies: Rows[Body], springs: IntRows[2], user_loads: IntRows[3], constraints: Rows[Constraint],
        directions: Reals, w: InOut[Work], p: InOut[Integers], stop: IntVector[1], scheme: Reals, t: Real,
        kept: InOut[Kept], stages: InOut[Rows[state]], motors: Out[Vector[motors_size]], twists: Out[Vector[size]],
    ) -> Int:  # fmt: skip
        """The state at a time within the last step; a status."""
        if has_large_state:
            end = w.chart_end
            z = w.chart_x
        else:
            end = empty(state)
            z = empty(state)
        if kept.has_dense == 0.0:
            status = add_interpolant(
                numbers, bodies, springs, user_loads, constraints, directions, w, p, stop, scheme, kept, stages, z
            )
            if status != OK:
                return int(status)
        x = (t - kept.dense_time) / kept.dense_step
        for j in range(state):
            total = 0.0
            for i in range(2 + p.dense_rows, 0, -1):
                total = (total + stages[p.all_stages + 1 + i, j]) * (1.0 - x if i % 2 == 1 else x)
            total = (total + stages[p.all_stages, j]) * x
            end[j] = stages[p.all_stages + 1, j] + total
        for b in range(count):
            moved = k.moved_chart(kept.old_motors[8 * b : 8 * b + 8], end[6 * b : 6 * b + 6])
            motors[8 * b : 8 * b + 8] = k.near_motor(moved)
        if has_tangents:
            end_tangents(kept.old_motors, end, motors, kept.seen_tangents)
        twists[:] = end[size:chart]
        return OK

    return AdaptiveAlgorithms(first_step, adaptive_step, find_state_between)
