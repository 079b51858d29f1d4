"""Simulations: sizes of the coefficients of a motion's Taylor series, and the step that the last ones allow.

Annotations are evaluated: sizes are those of the kind of simulation.
"""

from typing import Any, NamedTuple

from ...ir.loops.algorithm import Algorithm as algorithm
from ...ir.loops.algorithm import inlined
from ...ir.loops.language import (
    INFINITY,
    NAN,
    InOut,
    Int,
    Out,
    Real,
    Rows,
    Vector,
    empty,
    exp,
    log,
    sqrt,
    unrolled,
)  # fmt: skip
from .records import Body, Parts, work_records


class SeriesSizes(NamedTuple):
    """Sizes of coefficients.

    Attributes
    ----------
    last : int
        How many orders are looked at: coefficients of one parity may vanish.
    measure_orders, measure_tangents : algorithm
        Squares of the coefficients of some orders in units of what they may change; of those of a tangent, or None.
    step_of, largest_step : algorithm
        The largest step, in units of the series' time, from squares of the last orders; of the motion's series.
    """

    last: int
    measure_orders: algorithm
    measure_tangents: Any
    step_of: algorithm
    largest_step: algorithm


def series_sizes(parts: Parts, radius_of_gyration: algorithm, rotor_part: tuple[bool, ...]) -> SeriesSizes:
    """Sizes of coefficients of a kind of simulation.

    Parameters
    ----------
    parts : Parts
    radius_of_gyration : algorithm
        Of a body.
    rotor_part : tuple of bool
        Whether a coefficient of a motor is of its rotor.
    """
    bodies_count, state, in_flight = parts.bodies, parts.series_state, parts.in_flight
    motors_size, has_tangents = 8 * parts.bodies, parts.tangents > 0
    last = 2 if in_flight and parts.mode == "free" else 4
    motor_groups = tuple((j, 0 if turns else 1) for j, turns in enumerate(rotor_part))
    twist_groups = tuple((j, 2 if j in parts.angular else 3) for j in range(6))
    Work: Any = work_records(parts).whole
    measure_tangents: Any = None

    if in_flight:

        @inlined
        def larger(a: Real, b: Real) -> Real:
            """The larger of two numbers, of which one may be NaN."""
            return a if a >= b or b != b else b

        @algorithm
        def measure_orders(
            bodies: Rows[Body], w: Work, x: Rows[state], first: Int, order: Int, squares: Out[Vector[last]]
        ) -> None:
            """Squares of the coefficients of some orders in units of what they may change.

            Rotations of one radian, and spins of their own size, as two coefficients have it.
            """
            loose = w.atol / w.rtol
            spin = sqrt(x[0, 4] * x[0, 4] + x[0, 5] * x[0, 5] + x[0, 6] * x[0, 6]) + sqrt(
                x[1, 4] * x[1, 4] + x[1, 5] * x[1, 5] + x[1, 6] * x[1, 6]
            )
            turn = 1.0 / ((1.0 + loose) * (1.0 + loose))
            rate = 1.0 / ((spin + loose) * (spin + loose)) if spin > 0.0 else 0.0
            for i in range(first, order + 1):
                q = x[i, 0] * x[i, 0] + x[i, 1] * x[i, 1] + x[i, 2] * x[i, 2] + x[i, 3] * x[i, 3]
                v = x[i, 4] * x[i, 4] + x[i, 5] * x[i, 5] + x[i, 6] * x[i, 6]
                squares[i - first] = larger(q * turn, v * rate)

    else:

        @inlined
        def size_groups(x: Rows[state], i: Int, b: Int, sums: Out[Vector[4]]) -> None:
            """Squares of a coefficient of a body: rotation, path, and their rates."""
            sums[:] = 0.0
            motor = x[i][8 * b : 8 * b + 8]
            twist = x[i][motors_size + 6 * b : motors_size + 6 * b + 6]
            for place, group in motor_groups:
                sums[group] += motor[place] * motor[place]
            for place, group in twist_groups:
                sums[group] += twist[place] * twist[place]

        @inlined
        def size_state(
            reach: Real, x: Rows[state], b: Int, first: Int, sums: InOut[Vector[4]], sizes: Out[Vector[4]]
        ) -> None:
            """What coefficients of a body are measured against: one radian, the body's size, rates as those before."""
            sizes[:] = (1.0, reach, 0.0, 0.0)
            for i in range(max(first, 2)):
                size_groups(x, i, b, sums)
                if i == 1:
                    sizes[1] += sqrt(sums[1])
                if i < first:
                    turning = sqrt(sums[2])
                    moving = sqrt(sums[3])
                    sizes[2] += turning + moving / reach
                    sizes[3] += turning * reach + moving

        @inlined
        def add_orders(
            reach: Real, loose: Real, x: Rows[state], b: Int, first: Int, order: Int, sizes: Vector[4],
            sums: InOut[Vector[4]], squares: InOut[Vector[last]],
        ) -> None:  # fmt: skip
            """The largest squares of the coefficients of some orders, in units of what they may change."""
            for i in range(first, order + 1):
                size_groups(x, i, b, sums)
                for j in range(4):
                    unit = sizes[j] + loose * (reach if j % 2 == 1 else 1.0)
                    if sums[j] > 0.0:
                        squares[i - first] = max(squares[i - first], sums[j] / (unit * unit))

        @algorithm
        def measure_orders(
            bodies: Rows[Body], w: Work, x: Rows[state], first: Int, order: Int, squares: Out[Vector[last]]
        ) -> None:
            """Squares of the coefficients of some orders in units of what they may change.

            Rotations of one radian, paths of the body's own size, rates of their own, as orders before have it.
            """
            loose = w.atol / w.rtol
            sizes = empty(4)  # rotation, path, and their rates
            sums = empty(4)
            for i in range(order + 1 - first):
                squares[i] = 0.0
            for b in range(bodies_count):
                reach = radius_of_gyration(bodies[b])
                size_state(reach, x, b, first, sums, sizes)
                add_orders(reach, loose, x, b, first, order, sizes, sums, squares)

        if has_tangents:

            @algorithm
            def measure_tangents(
                bodies: Rows[Body], w: Work, x: Rows[state], along: Rows[state], first: Int, order: Int,
                squares: InOut[Vector[last]],
            ) -> None:  # fmt: skip
                """The same of a tangent: against itself, down to a fraction of what the state is measured against."""
                loose = w.atol / w.rtol
                sizes = empty(4)
                own = empty(4)
                sums = empty(4)
                for b in range(bodies_count):
                    reach = radius_of_gyration(bodies[b])
                    size_state(reach, x, b, first, sums, sizes)
                    for j in range(4):
                        own[j] = 0.0
                    for i in range(first):
                        size_groups(along, i, b, sums)
                        for j in unrolled(2):
                            turning = sqrt(sums[2 * j])
                            moving = sqrt(sums[2 * j + 1])
                            own[2 * j] += turning + moving / reach
                            own[2 * j + 1] += turning * reach + moving
                    for j in range(4):
                        sizes[j] = max(own[j], 1e-2 * sizes[j])
                    add_orders(reach, loose, along, b, first, order, sizes, sums, squares)

    @inlined
    def step_of(squares: Vector[last], order: Int, count: Int) -> Real:
        """The largest step, in units of the series' time, after which the terms of the last orders are small enough."""
        most = -INFINITY
        first = order - count + 1
        for i in range(count):
            if not squares[i] < INFINITY:
                return NAN
            if squares[i] > 0.0:
                most = max(most, log(squares[i]) / float(2 * (first + i)))
        return exp(-most - 2.0 - 0.7 / float(order - 1))

    @algorithm
    def largest_step(bodies: Rows[Body], w: Work, x: Rows[state], order: Int, count: Int) -> Real:
        """The same of the series of the motion."""
        squares = empty(last)
        measure_orders(bodies, w, x, order - count + 1, order, squares)
        return step_of(squares, order, count)

    return SeriesSizes(last, measure_orders, measure_tangents, step_of, largest_step)
