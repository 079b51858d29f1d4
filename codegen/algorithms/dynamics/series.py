"""Simulations: Taylor coefficients of a motion, order by order: rates of motors, wrenches, reactions, accelerations.

Time is in units of a step, so that coefficients fall from order to order. A state is a motor for each body, then a
twist for each; of a body by itself that only turns, a rotor, a spin, and a zero. Annotations are evaluated: sizes are
those of the kind of simulation.
"""

from typing import Any, NamedTuple

from ...ir.loops.algorithm import Algorithm as algorithm
from ...ir.loops.algorithm import inlined, with_tangent
from ...ir.loops.language import InOut, Int, IntRows, IntVector, Out, Real, Reals, Rows, Vector, empty, zeros
from ..series.functions import SeriesFunction
from ..series.recurrences import HIGHEST_ORDER
from .acceleration import RateAlgorithms
from .records import Body, Code, Constraint, Parts, Spring, work_records

OK = int(Code.OK)
SPRING_SIZE = Spring.size


class MotionSeries(NamedTuple):
    """Series functions of a kind of simulation.

    Attributes
    ----------
    motion : SeriesFunction
        Of rows motor, twist, momentum and `Body`: rates of the motor, and the sum of the wrenches, as a row. Of a body
        that only turns, of rows rotor, spin, inverse moments and `Body`: rates of the rotor and of the spin.
    spring : SeriesFunction or None
        Of motor and twist of one end and of the other and `Spring`: wrenches on both, as rows.
    layouts : tuple of (int, int, SeriesFunction)
        Number and size of each layout; of rows motor, twist and object: `moved_rates` and `turned_rate` of what is
        pinned.
    power : SeriesFunction or None
        Of motor and wrench: the power of the wrench on unit twists.
    relation : SeriesFunction or None
        Of motor and twist of a body and of the one that sees it: motor and twist there, the bracket, `adjoint`.
    """

    motion: SeriesFunction
    spring: SeriesFunction | None = None
    layouts: tuple[tuple[int, int, SeriesFunction], ...] = ()
    power: SeriesFunction | None = None
    relation: SeriesFunction | None = None


def series_shapes(
    parts: Parts, series: MotionSeries, springs: int, constraints: int
) -> tuple[tuple[str, tuple[int, ...]], ...]:
    """What is kept from order to order, in the work of a simulation with so many springs and constraints.

    ``motion_terms``, ``spring_terms``, ``held_terms``, ``relation_terms``: of the functions of each body, spring and
    constraint; ``bends``, ``adjoints``: of relations; ``jacobians``: rows of the constraints, of all orders;
    ``accelerations``, ``multipliers``; ``goals``: what the rows times the accelerations must be.
    """
    if parts.in_flight:
        return ()
    shapes: dict[str, tuple[int, ...]] = {"motion_terms": (parts.bodies, series.motion.size)}
    if series.spring is not None:
        shapes["spring_terms"] = (max(springs, 1), series.spring.size)
    if parts.mode == "constrained":
        held = [function for _, _, function in series.layouts] + ([series.power] if series.power else [])
        shapes["held_terms"] = (constraints, max([1, *(function.size for function in held)]))
        if series.relation is not None:
            shapes["relation_terms"] = (constraints, series.relation.size)
            shapes["bends"] = (constraints, 6 * HIGHEST_ORDER)
            shapes["adjoints"] = (constraints, 36 * HIGHEST_ORDER)
        shapes["jacobians"] = (HIGHEST_ORDER * parts.rows, parts.size)
        shapes["accelerations"] = (HIGHEST_ORDER, parts.size)
        shapes["multipliers"] = (HIGHEST_ORDER, min(parts.rows, parts.size))
        shapes["goals"] = (parts.rows,)
    return tuple(shapes.items())


def coefficient_algorithm(parts: Parts, series: MotionSeries, rates: RateAlgorithms) -> algorithm:
    """Taylor coefficients up to an order from those of order 0; a status.

    Parameters
    ----------
    parts : Parts
    series : MotionSeries
    rates : RateAlgorithms
    """
    if parts.in_flight:
        return _coefficients_of_turning(parts, series)
    bodies_count, size, state, largest = parts.bodies, parts.size, parts.series_state, parts.largest
    motors_size, row_count, identity, is_large = 8 * bodies_count, parts.rows, parts.identity, parts.is_large
    is_constrained, in_subspace, is_joined = parts.mode == "constrained", parts.mode == "subspace", bodies_count > 1
    rank, has_springs = min(row_count, size), series.spring is not None
    work = work_records(parts)
    Work: Any = work.numbers
    Integers: Any = work.integers
    system, layouts = work.rows, tuple((number, n, f.compute, f.size) for number, n, f in series.layouts)
    numbers_size, integers_size = (0, 0) if system is None else (system.numbers.size, system.integers.size)
    least_change: Any = None if system is None else system.least_change
    constrain: Any = None if rates.rows is None else rates.rows.constrain
    motion: Any = series.motion.compute
    spring: Any = series.spring and series.spring.compute
    power_of: Any = series.power and series.power.compute
    relate: Any = series.relation and series.relation.compute
    has_power, power_terms = power_of is not None, series.power.size if series.power else 0
    add_spring_series: Any = None
    fill_series_rows: Any = None
    find_multipliers: Any = None

    if has_springs:

        @inlined
        def end_series(
            k: Int, b: Int, motors: Vector[motors_size], twists: Vector[size], r: Out[Vector[8]], rate: Out[Vector[6]]
        ) -> None:
            """Motor and twist of a spring's body, or of the world."""
            if b >= 0:
                r[:] = motors[8 * b : 8 * b + 8]
                rate[:] = twists[6 * b : 6 * b + 6]
            else:
                r[:] = 0.0
                rate[:] = 0.0
                if k == 0:
                    r[:] = identity

        @inlined
        def add_spring_series(
            k: Int, numbers: Reals, springs: IntRows[2], w: InOut[Work], p: InOut[Integers],
            motors: Vector[motors_size], twists: Vector[size], rows: InOut[Vector[size]],
        ) -> None:  # fmt: skip
            """Rows of the wrenches of springs at their two ends."""
            s = empty(8)
            other_rate = empty(6)
            own = empty(6)
            other = empty(6)
            if is_joined:
                r = empty(8)
                rate = empty(6)
            else:
                r = motors
                rate = twists
                s[:] = identity
                other_rate[:] = 0.0
            for i in range(p.springs):
                at = p.spring_offset + SPRING_SIZE * i
                a, b = springs[i, 0], springs[i, 1]
                if is_joined:
                    end_series(k, a, motors, twists, r, rate)
                    end_series(k, b, motors, twists, s, other_rate)
                spring(k, w.spring_terms[i], own, other, r, rate, s, other_rate, numbers[at : at + SPRING_SIZE])
                for j in range(6):
                    if a >= 0:
                        rows[6 * a + j] += own[j]
                    if b >= 0:
                        rows[6 * b + j] += other[j]

    if is_constrained:

        @algorithm
        def fill_series_rows(
            k: Int, numbers: Reals, constraints: Rows[Constraint], w: InOut[Work], p: InOut[Integers],
            motors: Vector[motors_size], twists: Vector[size],
        ) -> None:  # fmt: skip
            """Rows of all constraints on the bodies' twists, and what they times the accelerations must be.

            What is pinned by itself does not move as the body sees it.
            """
            rates = empty(6 * largest)
            bent = empty(largest)
            power = zeros(6)
            motor = empty(8)
            twist = empty(6)
            if is_joined:
                seen = empty(8)
                relative = empty(6)
            to = 0
            for i in range(p.constraints):
                c = constraints[i]
                motor[:] = motors[8 * c.body : 8 * c.body + 8]
                twist[:] = twists[6 * c.body : 6 * c.body + 6]
                if is_joined and c.other >= 0:
                    relate(
                        k, w.relation_terms[i], seen, relative, w.bends[i][6 * k : 6 * k + 6],
                        w.adjoints[i][36 * k : 36 * k + 36], motor, twist, motors[8 * c.other : 8 * c.other + 8],
                        twists[6 * c.other : 6 * c.other + 6],
                    )  # fmt: skip
                    motor[:] = seen
                    twist[:] = relative
                n = 6
                for number, count, see, terms in layouts:
                    if c.layout == number:
                        n = count
                        see(
                            k, w.held_terms[i][0:terms], rates[0 : 6 * count], bent[0:count], motor, twist,
                            numbers[c.v : c.v + count],
                        )  # fmt: skip
                if has_power and c.layout < 0:
                    power_of(k, w.held_terms[i][0:power_terms], power, motor, numbers[c.v : c.v + 6])
                for m in range(c.rows):
                    row = w.jacobians[row_count * k + to + m]
                    block = row[6 * c.body : 6 * c.body + 6]
                    row[:] = 0.0
                    if c.layout < 0:
                        w.goals[to + m] = 0.0
                        block[:] = power
                    elif c.a >= 0:
                        w.goals[to + m] = 0.0
                        for x in range(n):
                            w.goals[to + m] += numbers[c.a + n * m + x] * bent[x]
                            for j in range(6):
                                block[j] += numbers[c.a + n * m + x] * rates[n * j + x]
                    else:
                        w.goals[to + m] = bent[m]
                    if k == 0:  # of these, too: see fill_constraint
                        for j in range(size):
                            row[j] = w.matrix[to + m, j]
                    if is_joined and c.other >= 0:
                        for j in range(k + 1):
                            before = w.jacobians[row_count * j + to + m]
                            for x in range(6):
                                entry = before[6 * c.body + x]
                                w.goals[to + m] -= entry * w.bends[i, 6 * (k - j) + x]
                                if k > 0:
                                    for y in range(6):
                                        row[6 * c.other + y] -= entry * w.adjoints[i, 36 * (k - j) + 6 * x + y]
                to += c.rows

        @inlined
        def solve_multipliers(w: Work, p: Integers, change: Vector[size], multipliers: Out[Vector[rank]]) -> None:
            """What pulls along the rows that directions came from."""
            for m in range(p.rank):
                i = p.rank - 1 - m
                value = 0.0
                for j in range(size):
                    value += w.direction[i, j] * change[j]
                for j in range(i + 1, p.rank):
                    value -= w.upper[i, j] * multipliers[j]
                multipliers[i] = value / w.upper[i, i]
            for i in range(p.rank):
                multipliers[i] /= w.scale[p.order[i]]

        @algorithm
        def find_multipliers_along(
            w: Work, p: Integers, multipliers: Out[Vector[rank]], d_w: Work, d_multipliers: Out[Vector[rank]]
        ) -> None:
            """The same with its tangent, of c = G A^T l with the weights G: G A^T dl = dc - dG A^T l - G dA^T l."""
            change = empty(size)
            solve_multipliers(w, p, w.change, multipliers)
            change[:] = d_w.change
            for m in range(p.rank):
                i = p.order[m]
                for j in range(size):
                    change[j] -= multipliers[m] * (d_w.weights[j] * w.matrix[i, j] + w.weights[j] * d_w.matrix[i, j])
            solve_multipliers(w, p, change, d_multipliers)

        @with_tangent(find_multipliers_along)
        def find_multipliers(w: Work, p: Integers, multipliers: Out[Vector[rank]]) -> None:
            """What pulls along the rows that directions came from, of the last change of a motion."""
            solve_multipliers(w, p, w.change, multipliers)

    @algorithm
    def find_coefficients(
        numbers: Reals, bodies: Rows[Body], springs: IntRows[2], constraints: Rows[Constraint], w: InOut[Work],
        p: InOut[Integers], stop: IntVector[1], t: Real, order: Int, unit: Real, x: InOut[Rows[state]],
    ) -> Int:  # fmt: skip
        """Coefficients up to an order from those of order 0, with this unit of time; a status."""
        if is_large:  # noqa: SIM108  (of arrays there are no expressions)
            rows = w.scratch[0:size]
        else:
            rows = empty(size)
        momentum = empty(6)
        for k in range(order):
            fraction = unit / float(k + 1)
            now = x[k]
            following = x[k + 1]
            motors = now[0:motors_size]
            twists = now[motors_size:state]
            next_motors = following[0:motors_size]
            rates = following[motors_size:state]
            for b in range(bodies_count):
                body = bodies[b]
                twist = twists[6 * b : 6 * b + 6]
                motor_rate = next_motors[8 * b : 8 * b + 8]
                if in_subspace:
                    for i in range(6):
                        momentum[i] = 0.0
                        for j in range(6):
                            momentum[i] += body.mass[i, j] * twist[j]
                else:
                    for j in range(6):
                        momentum[j] = body.metric[j] * twist[j]
                motion(
                    k, w.motion_terms[b], motor_rate, rows[6 * b : 6 * b + 6], motors[8 * b : 8 * b + 8], twist,
                    momentum, body,
                )  # fmt: skip
                for j in range(8):
                    motor_rate[j] = fraction * motor_rate[j]
            if has_springs:
                add_spring_series(k, numbers, springs, w, p, motors, twists, rows)
            if is_constrained:
                if k == 0:
                    status = constrain(numbers, bodies, constraints, w, p, stop, t, motors, twists, w.tolerance)
                    if status != OK:
                        return int(status)
                fill_series_rows(k, numbers, constraints, w, p, motors, twists)
                for j in range(1, k + 1):
                    for i in range(p.rank):
                        row = p.order[i]
                        for m in range(size):
                            rows[m] += w.jacobians[row_count * j + row, m] * w.multipliers[k - j, i]
                            w.goals[row] -= w.jacobians[row_count * j + row, m] * w.accelerations[k - j, m]
                for b in range(bodies_count):
                    for j in range(6):
                        w.accelerations[k, 6 * b + j] = bodies[b].inverse[j] * rows[6 * b + j]
                least_change(w[0:numbers_size], p[0:integers_size], 0, w.weights, w.goals, w.accelerations[k])
                find_multipliers(w, p, w.multipliers[k])
                for j in range(size):
                    rates[j] = fraction * w.accelerations[k, j]
            elif in_subspace:
                for i in range(6):
                    total = 0.0
                    for j in range(6):
                        total += bodies[0].compliance[i, j] * rows[j]
                    rates[i] = fraction * total
            else:
                for b in range(bodies_count):
                    for j in range(6):
                        rates[6 * b + j] = fraction * bodies[b].inverse[j] * rows[6 * b + j]
        return OK

    return find_coefficients


def _coefficients_of_turning(parts: Parts, series: MotionSeries) -> algorithm:
    """The same of a body by itself that is free, or held at a point, where nothing but gravity acts."""
    work, state, size = work_records(parts), parts.series_state, series.motion.size
    Work: Any = work.numbers
    Integers: Any = work.integers
    motion = series.motion.compute

    @algorithm
    def find_coefficients(
        numbers: Reals, bodies: Rows[Body], springs: IntRows[2], constraints: Rows[Constraint], w: InOut[Work],
        p: InOut[Integers], stop: IntVector[1], t: Real, order: Int, unit: Real, x: InOut[Rows[state]],
    ) -> Int:  # fmt: skip
        """Coefficients up to an order from those of order 0, with this unit of time; a status."""
        body = bodies[0]
        inverse = empty(3)
        terms = empty(size)
        rotor_rate = empty(4)
        spin_rate = empty(3)
        for j in range(3):
            inverse[j] = 1.0 / body.moments[j]
        for k in range(order):
            fraction = unit / float(k + 1)
            motion(k, terms, rotor_rate, spin_rate, x[k][0:4], x[k][4:7], inverse, body)
            for j in range(4):
                x[k + 1, j] = fraction * rotor_rate[j]
            for j in range(3):
                x[k + 1, 4 + j] = fraction * spin_rate[j]
            x[k + 1, 7] = 0.0
        return OK

    return find_coefficients
