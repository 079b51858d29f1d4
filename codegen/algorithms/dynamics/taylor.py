"""Simulations: steps along the Taylor series of the motion, of the size that its last coefficients allow.

Jorba and Zou (2005). The series itself says what is between two steps. Annotations are evaluated: sizes are those of
the kind of simulation.
"""

from typing import Any, NamedTuple

from ...ir.algorithm_derivative import derivative_of
from ...ir.loops.algorithm import Algorithm as algorithm
from ...ir.loops.language import (
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
)  # fmt: skip
from ..series.recurrences import ROWS
from .acceleration import RateAlgorithms
from .meeting_springs import meeting_algorithm
from .records import Body, Code, Constraint, Parts, kept_record, work_records
from .series import MotionSeries, coefficient_algorithm
from .series_sizes import series_sizes

OK, NOT_FINITE, UNDERFLOW = int(Code.OK), int(Code.NOT_FINITE), int(Code.UNDERFLOW)
MEETING = int(Code.MEETING)
#: Other units of time than the step may be so many times longer or shorter.
FAR = 1e6
#: Changes of the units.
MOST_CHANGES = 40
#: A step that is so much shorter than what is left is not the last one.
ALMOST = 1.0 + 1e-9
#: A step from a singular pose goes so far, in units of the distance from it at which constraints are told apart.
PASSING = 4.0
#: Roundings of the time that a step takes, at least.
FEWEST_ROUNDINGS = 16.0


class TaylorAlgorithms(NamedTuple):
    """Steps along series; see `MethodAlgorithms`.

    Attributes
    ----------
    find_coefficients, coefficients_along : algorithm
        See series.py; the same with a tangent, or None.
    start_series : algorithm
        Before the first step, for a duration: what is kept, and the length of the step; a status.
    series_step : algorithm
        One step, that ends at a time at most: what is kept is that at its end; a status.
    find_state_of_series : algorithm
        Motors and twists at a time within the last step; where there was none, those that are kept.
    """

    find_coefficients: algorithm
    coefficients_along: Any
    start_series: algorithm
    series_step: algorithm
    find_state_of_series: algorithm


def taylor_algorithms(
    parts: Parts, k: Any, rates: RateAlgorithms, series: MotionSeries, radius_of_gyration: algorithm,
    rotor_part: tuple[bool, ...],
) -> TaylorAlgorithms:  # fmt: skip
    """Steps of a kind of simulation.

    Parameters
    ----------
    parts : Parts
    k : named tuple of KernelSpec
    rates : RateAlgorithms
    series : MotionSeries
    radius_of_gyration : algorithm
        Of a body.
    rotor_part : tuple of bool
        Whether a coefficient of a motor is of its rotor.
    """
    bodies_count, size, state, in_flight = parts.bodies, parts.size, parts.series_state, parts.in_flight
    motors_size, is_large = 8 * bodies_count, parts.is_large
    is_constrained = parts.mode == "constrained"
    falls = parts.mode == "free" and "gravity" in parts.loads
    has_springs = "spring" in parts.loads
    springs_meet: Any = meeting_algorithm(parts, k) if has_springs else None
    last, measure_orders, measure_tangents, step_of, largest_step = series_sizes(parts, radius_of_gyration, rotor_part)
    a_velocity = parts.linear[0]
    tangents, has_tangents, chart = parts.tangents, parts.tangents > 0, 2 * size
    work = work_records(parts)
    own_size = work.numbers.size
    Kept: Any = kept_record(parts)
    Work: Any = work.whole
    Integers: Any = work.integers
    find_coefficients = coefficient_algorithm(parts, series, rates)
    coefficients_along: Any = None
    find_tangents: Any = None
    sum_tangents: Any = None

    @algorithm
    def sum_series(coefficients: Rows[state], order: Int, fraction: Real, x: Out[Vector[state]]) -> None:
        """The state at a fraction of the series' unit of time."""
        x[:] = coefficients[order]
        for i in range(order):
            for j in range(state):
                x[j] = x[j] * fraction + coefficients[order - 1 - i, j]

    if has_tangents:
        coefficients_along = derivative_of(find_coefficients, "numbers", "bodies", "w", "x")

        @algorithm
        def end_of_series(
            coefficients: Rows[state], order: Int, fraction: Real, motors: Out[Vector[motors_size]],
            twists: Out[Vector[size]],
        ) -> None:  # fmt: skip
            """Motors and twists at a fraction of the series' unit of time."""
            x = empty(state)
            sum_series(coefficients, order, fraction, x)
            for b in range(bodies_count):
                motors[8 * b : 8 * b + 8] = k.near_motor(x[8 * b : 8 * b + 8])
            twists[:] = x[motors_size:state]

        end_along = derivative_of(end_of_series, "coefficients")

        @algorithm
        def sum_tangents(kept: Kept, order: Int, fraction: Real, found: Out[Vector[chart * tangents]]) -> None:
            """Tangents at a fraction of the series' unit of time: of motors, as twists in their frames; of twists."""
            motors = empty(motors_size)
            twists = empty(size)
            rates = empty(motors_size)
            for q in range(tangents):
                own = found[chart * q : chart * q + chart]
                end_along(
                    kept.coefficients, order, fraction, motors, twists,
                    kept.coefficients_along[ROWS * q : ROWS * q + ROWS], rates, own[size:chart],
                )  # fmt: skip
                for b in range(bodies_count):
                    own[6 * b : 6 * b + 6] = k.twist_of(motors[8 * b : 8 * b + 8], rates[8 * b : 8 * b + 8])

        @algorithm
        def find_tangents(
            numbers: Reals, bodies: Rows[Body], springs: IntRows[2], constraints: Rows[Constraint], directions: Reals,
            w: InOut[Work], p: InOut[Integers], stop: IntVector[1], t: Real, unit: Real, kept: InOut[Kept],
        ) -> tuple[Int, Real]:  # fmt: skip
            """Tangents of the coefficients: a status, and the fraction of the unit after which they end."""
            squares = empty(last)
            status = OK
            first = p.method_order - last + 1
            for i in range(last):
                squares[i] = 0.0
            for q in range(tangents):
                along = kept.coefficients_along[ROWS * q : ROWS * q + ROWS]
                given = directions[p.stride * q :]
                own = kept.tangents[chart * q : chart * q + chart]
                for b in range(bodies_count):
                    along[0][8 * b : 8 * b + 8] = k.motor_rate(
                        kept.motors[8 * b : 8 * b + 8], own[6 * b : 6 * b + 6]
                    )
                along[0][motors_size:state] = own[size:chart]
                p.held = 1
                if status == OK:
                    status = coefficients_along(
                        numbers, bodies, springs, constraints, w[0:own_size], p, stop, t, p.method_order, unit,
                        kept.coefficients, given, given, w.along, along,
                    )  # fmt: skip
                measure_tangents(bodies, w, kept.coefficients, along, first, p.method_order, squares)
            p.held = 0
            return status, step_of(squares, p.method_order, last)

    @algorithm
    def start_series(
        numbers: Reals, bodies: Rows[Body], springs: IntRows[2], user_loads: IntRows[3], constraints: Rows[Constraint],
        directions: Reals, w: InOut[Work], p: InOut[Integers], stop: IntVector[1], duration: Real, kept: InOut[Kept],
    ) -> Int:  # fmt: skip
        """Before the first step: its units, from the first two coefficients; a status."""
        now = kept.now
        if in_flight:
            flight = kept.flight
            now[0:4], flight[0:3], flight[3:6], now[4:7] = k.flight(kept.motors, kept.twists)
            now[7] = 0.0
        else:
            now[0:motors_size] = kept.motors
            now[motors_size:state] = kept.twists
        kept.coefficients[0][:] = now
        kept.has_dense = 0.0
        status = find_coefficients(
            numbers, bodies, springs, constraints, w[0:own_size], p, stop, kept.time, 2, duration, kept.coefficients
        )
        if status != OK:
            return int(status)
        fraction = largest_step(bodies, w, kept.coefficients, 2, 2)
        kept.next_step = duration * fraction if 0.0 < fraction < 1.0 else duration
        return OK

    @algorithm
    def series_step(
        numbers: Reals, bodies: Rows[Body], springs: IntRows[2], user_loads: IntRows[3], constraints: Rows[Constraint],
        directions: Reals, w: InOut[Work], p: InOut[Integers], stop: IntVector[1], end_time: Real, kept: InOut[Kept],
    ) -> Int:  # fmt: skip
        """The series at the state that is kept, and the state at its end; a status."""
        t = kept.time
        unit = kept.next_step
        h = unit
        now = kept.now
        if not in_flight:
            now[0:motors_size] = kept.motors
            now[motors_size:state] = kept.twists
        kept.coefficients[0][:] = now
        changes = 0
        while True:
            status = find_coefficients(
                numbers, bodies, springs, constraints, w[0:own_size], p, stop, t, p.method_order, unit,
                kept.coefficients,
            )  # fmt: skip
            if status != OK:
                return int(status)
            fraction = largest_step(bodies, w, kept.coefficients, p.method_order, last)
            if changes == MOST_CHANGES:
                return UNDERFLOW if fraction >= 0.0 else NOT_FINITE
            changes += 1
            if not fraction >= 0.0:
                unit /= FAR  # too large for numbers
                continue
            h = min(unit * fraction, w.longest_step)
            if fraction >= 1.0 / FAR and (fraction <= FAR or h <= unit * FAR):
                break
            unit = h if fraction < 1.0 else unit * FAR
        if is_constrained and p.rank < p.known_rank:  # the series is that of a mechanism with more freedoms
            squares = empty(last)
            measure_orders(bodies, w, kept.coefficients, 1, 1, squares)
            if squares[0] > 0.0:
                h = min(h, PASSING * w.tolerance * unit / sqrt(squares[0]))
        if has_tangents:
            status, fraction = find_tangents(
                numbers, bodies, springs, constraints, directions, w, p, stop, t, unit, kept
            )
            if status != OK:
                return int(status)
            if not fraction >= 0.0:
                return NOT_FINITE
            h = min(h, unit * fraction)
        kept.next_step = h
        if not t + h * ALMOST < end_time:
            h = end_time - t
        if not h > FEWEST_ROUNDINGS * epsilon() * max(abs(t), kept.least_time):
            return UNDERFLOW
        kept.dense_time = t
        kept.dense_step = unit
        kept.has_dense = 1.0
        sum_series(kept.coefficients, p.method_order, h / unit, now)
        if in_flight:
            flight = kept.flight
            now[0:4] = k.renormalize(now[0:4])
            for j in range(6):
                flight[6 + j] = flight[j]
            for j in range(3):
                if falls:
                    fall = h * bodies[0].weight[j] * bodies[0].inverse[a_velocity]
                    flight[j] += h * (flight[9 + j] + fall / 2.0)
                    flight[3 + j] += fall
                else:
                    flight[j] += h * flight[3 + j]
        else:
            for b in range(bodies_count):
                now[8 * b : 8 * b + 8] = k.near_motor(now[8 * b : 8 * b + 8])
            if has_springs:
                met = springs_meet(numbers, springs, p, kept.motors, now[0:motors_size])
                if met:
                    return MEETING
            kept.motors[:] = now[0:motors_size]
            kept.twists[:] = now[motors_size:state]
        if has_tangents:
            sum_tangents(kept, p.method_order, h / unit, kept.tangents)
        kept.time = t + h if h < end_time - t else end_time
        total = 0.0
        for j in range(state):
            total += now[j] - now[j]
        if in_flight:
            for j in range(6):
                total += kept.flight[j] - kept.flight[j]
        return OK if total == 0.0 else NOT_FINITE

    @algorithm
    def find_state_of_series(
        numbers: Reals, bodies: Rows[Body], springs: IntRows[2], user_loads: IntRows[3], constraints: Rows[Constraint],
        directions: Reals, w: InOut[Work], p: InOut[Integers], stop: IntVector[1], t: Real, kept: InOut[Kept],
        motors: Out[Vector[motors_size]], twists: Out[Vector[size]],
    ) -> Int:  # fmt: skip
        """The state at a time within the last step; a status."""
        if kept.has_dense == 0.0:
            motors[:] = kept.motors
            twists[:] = kept.twists
            if has_tangents:
                kept.seen_tangents[:] = kept.tangents
            return OK
        if is_large:  # noqa: SIM108  (as in series.py)
            x = w.scratch[0:state]
        else:
            x = empty(state)
        past = t - kept.dense_time
        sum_series(kept.coefficients, p.method_order, past / kept.dense_step, x)
        if in_flight:
            position = empty(3)
            velocity = empty(3)
            for j in range(3):
                fall = past * bodies[0].weight[j] * bodies[0].inverse[a_velocity] if falls else 0.0
                position[j] = kept.flight[6 + j] + past * (kept.flight[9 + j] + fall / 2.0)
                velocity[j] = kept.flight[9 + j] + fall
            motors[:], twists[:] = k.state_after_flight(x[0:4], position, velocity, x[4:7])
        else:
            for b in range(bodies_count):
                motors[8 * b : 8 * b + 8] = k.near_motor(x[8 * b : 8 * b + 8])
            twists[:] = x[motors_size:state]
        if has_tangents:
            sum_tangents(kept, p.method_order, past / kept.dense_step, kept.seen_tangents)
        return OK

    return TaylorAlgorithms(find_coefficients, coefficients_along, start_series, series_step, find_state_of_series)
