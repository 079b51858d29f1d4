"""Simulations: steps of explicit Runge-Kutta schemes in the chart at their start.

A state of a chart are motions and twists of all bodies; behind it are those of its tangents, which schemes step
together with it. In C their rates are computed several directions at once, each a lane of vectors: of each group of
directions, numbers of one place are side by side. Annotations are evaluated: sizes are those of the kind of simulation.
"""

from dataclasses import replace
from typing import Any, NamedTuple

from ....ir.algorithm_derivative import derivative_of
from ....ir.loops.algorithm import Algorithm as algorithm
from ....ir.loops.algorithm import CFunction, inlined
from ....ir.loops.language import InOut, Int, IntRows, IntVector, Out, Real, Reals, Rows, Vector, empty
from ....ir.loops.types import ArrayType, Parameter
from ..acceleration import RateAlgorithms
from ..records import Body, Code, Constraint, Parts, kept_record, work_records

OK = int(Code.OK)


class ChartAlgorithms(NamedTuple):
    """Steps in a chart.

    Attributes
    ----------
    state_rates, chart_rates : algorithm
        Rates of a state of the chart at some motors; with those of its tangents.
    end_tangents : algorithm or None
        Tangents of a state of a chart as tangents of motors and twists.
    start_of_step, land : algorithm
        The state of a chart where a step begins; a simulation at the state where it ends.
    add_stages, end_of_step : algorithm
        Stages of a scheme; the state that they give.
    chart_step : algorithm
        One step; a status.
    place_of_tangent : algorithm
        Where the first number of a tangent is in a state; the next ones are ``lanes`` apart.
    rates_along, rates_of_lanes : DerivativeCall, CFunction or None
        Rates along one direction, and what C computes several with.
    """

    state_rates: algorithm
    chart_rates: Any
    end_tangents: Any
    start_of_step: algorithm
    land: algorithm
    add_stages: algorithm
    end_of_step: algorithm
    chart_step: algorithm
    place_of_tangent: algorithm
    rates_along: Any
    rates_of_lanes: Any


def chart_algorithms(parts: Parts, k: Any, rates: RateAlgorithms) -> ChartAlgorithms:
    """Steps in a chart.

    Parameters
    ----------
    parts : Parts
    k : named tuple of KernelSpec
    rates : RateAlgorithms
    """
    count, size, motors_size, state = parts.bodies, parts.size, 8 * parts.bodies, parts.state
    chart, has_tangents = 2 * size, parts.tangents > 0
    is_large, has_large_state = parts.is_large, parts.has_large_state
    work = work_records(parts)
    Kept: Any = kept_record(parts)
    tangents, own_size, lanes, columns = parts.tangents, work.numbers.size, parts.lanes, parts.columns
    has_lanes = lanes > 1
    Work: Any = work.whole
    Own: Any = work.numbers
    Integers: Any = work.integers
    accelerate = rates.accelerate
    end_tangents: Any = None
    rates_along: Any = None
    rates_of_lanes: Any = None

    @inlined
    def place_of_tangent(q: Int) -> Int:
        """Where the first number of a tangent is in a state."""
        return chart * (1 + lanes * (q // lanes)) + q % lanes

    @inlined
    def move_chart(base: Vector[motors_size], x: Vector[chart], motors: Out[Vector[motors_size]]) -> None:
        """Motors at x of the chart at some."""
        for b in range(count):
            motors[8 * b : 8 * b + 8] = k.moved_chart(base[8 * b : 8 * b + 8], x[6 * b : 6 * b + 6])

    @algorithm
    def state_rates(
        numbers: Reals, bodies: Rows[Body], springs: IntRows[2], user_loads: IntRows[3], constraints: Rows[Constraint],
        w: InOut[Own], p: InOut[Integers], stop: IntVector[1], t: Real, base: Vector[motors_size], x: Vector[chart],
        slopes: Out[Vector[chart]],
    ) -> Int:  # fmt: skip
        """Rates of a state x of the chart; a status."""
        if is_large:
            motors = w.chart_motors
            rows = w.chart_rows
        else:
            motors = empty(motors_size)
            rows = empty(size)
        move_chart(base, x, motors)
        for b in range(count):
            slopes[6 * b : 6 * b + 6] = k.chart_rate(x[6 * b : 6 * b + 6], x[size + 6 * b : size + 6 * b + 6])
        status = accelerate(
            numbers, bodies, springs, user_loads, constraints, w, p, stop, t, motors, x[size:chart], rows,
            slopes[size:chart],
        )  # fmt: skip
        return int(status)

    if has_tangents:
        rates_along = derivative_of(state_rates, "numbers", "bodies", "w", "x")
        move_along = derivative_of(move_chart, "x")
    if has_lanes:
        rates_of_lanes = CFunction(
            "rates_of_lanes", [_of_lanes(p, lanes) for p in rates_along.parameters], rates_along.function.results
        )

    @algorithm
    def chart_rates(
        numbers: Reals, bodies: Rows[Body], springs: IntRows[2], user_loads: IntRows[3], constraints: Rows[Constraint],
        directions: Reals, w: InOut[Work], p: InOut[Integers], stop: IntVector[1], t: Real, base: Vector[motors_size],
        x: Vector[state], slopes: Out[Vector[state]],
    ) -> Int:  # fmt: skip
        """Rates of a state of the chart, and of its tangents; a status."""
        status = OK
        if has_tangents:
            blurred = p.blurred
        if has_lanes:
            for q in range(0, columns, lanes):
                at = chart * (1 + q)
                along = directions[p.stride * (columns + q) :]
                if status == OK:
                    status = rates_of_lanes(
                        numbers, bodies, springs, user_loads, constraints, w[0:own_size], p, stop, t, base, x[0:chart],
                        slopes[0:chart], along, along, w.along_lanes, x[at : at + lanes * chart],
                        slopes[at : at + lanes * chart],
                    )  # fmt: skip
                    p.held = 1
                    p.blurred = 0
        elif has_tangents:
            for q in range(tangents):
                at = chart * (1 + q)
                along = directions[p.stride * q :]
                if status == OK:
                    status = rates_along(
                        numbers, bodies, springs, user_loads, constraints, w[0:own_size], p, stop, t, base, x[0:chart],
                        slopes[0:chart], along, along, w.along, x[at : at + chart], slopes[at : at + chart],
                    )  # fmt: skip
                    p.held = 1
                    p.blurred = 0
        else:
            status = state_rates(
                numbers, bodies, springs, user_loads, constraints, w[0:own_size], p, stop, t, base, x, slopes
            )
        if has_tangents:
            p.held = 0
            p.blurred = blurred
        return int(status)

    if has_tangents:

        @algorithm
        def end_tangents(
            base: Vector[motors_size], x: Vector[state], motors: Vector[motors_size],
            found: Out[Vector[chart * tangents]],
        ) -> None:  # fmt: skip
            """Tangents of a state of a chart as tangents of motors, twists in their frames, and of twists."""
            moved = empty(motors_size)
            rates = empty(motors_size)
            dx = empty(chart)
            for q in range(tangents):
                at = chart * q
                first = place_of_tangent(q)
                for j in range(chart):
                    dx[j] = x[first + lanes * j]
                move_along(base, x[0:chart], moved, dx, rates)
                for b in range(count):
                    found[at + 6 * b : at + 6 * b + 6] = k.twist_of(motors[8 * b : 8 * b + 8], rates[8 * b : 8 * b + 8])
                for j in range(size, chart):
                    found[at + j] = dx[j]

    @algorithm
    def add_stages(
        numbers: Reals, bodies: Rows[Body], springs: IntRows[2], user_loads: IntRows[3], constraints: Rows[Constraint],
        directions: Reals, w: InOut[Work], p: InOut[Integers], stop: IntVector[1], scheme: Reals, t: Real, h: Real,
        base: Vector[motors_size], start: Vector[state], stages: InOut[Rows[state]], first: Int, last: Int,
        x: InOut[Vector[state]],
    ) -> Int:  # fmt: skip
        """Stages of an explicit scheme from one to another; a status. What x holds is lost."""
        for i in range(first, last):
            x[:] = start
            for m in range(i):
                weight = h * scheme[p.all_stages * i + m]
                if weight == 0.0:
                    continue
                slopes = stages[m]
                for j in range(state):
                    x[j] += weight * slopes[j]
            time = t + scheme[p.all_stages * p.all_stages + i] * h
            status = chart_rates(
                numbers, bodies, springs, user_loads, constraints, directions, w, p, stop, time, base, x, stages[i]
            )
            if status != OK:
                return int(status)
        return OK

    @inlined
    def start_of_step(kept: Kept, x: Out[Vector[state]]) -> None:
        """The state of the chart at a simulation's own motors."""
        x[0:size] = 0.0
        x[size:chart] = kept.twists
        if has_tangents:
            for q in range(columns):
                first = place_of_tangent(q)
                for j in range(chart):
                    x[first + lanes * j] = kept.tangents[chart * q + j] if q < tangents else 0.0

    @algorithm
    def land(kept: InOut[Kept], x: Vector[state], motors: Out[Vector[motors_size]]) -> None:
        """The state at x becomes the simulation's, its motors before they are brought back to motors."""
        move_chart(kept.motors, x[0:chart], motors)
        if has_tangents:
            end_tangents(kept.motors, x, motors, kept.tangents)
        for b in range(count):
            kept.motors[8 * b : 8 * b + 8] = k.near_motor(motors[8 * b : 8 * b + 8])
        kept.twists[:] = x[size:chart]

    @inlined
    def end_of_step(
        p: Integers, scheme: Reals, start: Vector[state], h: Real, stages: Rows[state], x: Out[Vector[state]]
    ) -> None:
        """The state that stages give."""
        weights = p.all_stages * p.all_stages + p.all_stages
        for j in range(state):
            total = 0.0
            for i in range(p.stages):
                total += scheme[weights + i] * stages[i, j]
            x[j] = start[j] + h * total

    @algorithm
    def chart_step(
        numbers: Reals, bodies: Rows[Body], springs: IntRows[2], user_loads: IntRows[3], constraints: Rows[Constraint],
        directions: Reals, w: InOut[Work], p: InOut[Integers], stop: IntVector[1], scheme: Reals, t: Real, h: Real,
        kept: InOut[Kept], stages: InOut[Rows[state]],
    ) -> Int:  # fmt: skip
        """A step of a Runge-Kutta scheme in the chart at its start; a status."""
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
        start_of_step(kept, start)
        status = add_stages(
            numbers, bodies, springs, user_loads, constraints, directions, w, p, stop, scheme, t, h, kept.motors, start,
            stages, 0, p.stages, x,
        )  # fmt: skip
        if status != OK:
            return int(status)
        end_of_step(p, scheme, start, h, stages, end)
        land(kept, end, motors)
        return OK

    return ChartAlgorithms(
        state_rates, chart_rates, end_tangents, start_of_step, land, add_stages, end_of_step, chart_step,
        place_of_tangent, rates_along, rates_of_lanes,
    )  # fmt: skip


def _of_lanes(parameter: Parameter, lanes: int) -> Parameter:
    """A parameter of a derivative, of several directions where it is a tangent."""
    type = parameter.type
    if not parameter.name.startswith("d_") or not isinstance(type, ArrayType) or type.is_open:
        return parameter
    return replace(parameter, type=replace(type, shape=(lanes * type.size,), record=None))
