"""Simulations: equations of constraints at one state, and the directions of their rows.

Annotations are evaluated: sizes are those of the kind of simulation.
"""

from typing import Any, NamedTuple

from ...ir.loops.algorithm import Algorithm as algorithm
from ...ir.loops.algorithm import inlined, still, still_inlined
from ...ir.loops.language import (
    Bool,
    InOut,
    Int,
    IntVector,
    Out,
    Real,
    Reals,
    Rows,
    Vector,
    empty,
    epsilon,
    zeros,
)  # fmt: skip
from .loads import state_of, user_values
from .records import Body, Code, Constraint, Parts, work_records

OK, USER_FAILED, STOPPED = int(Code.OK), int(Code.USER_FAILED), int(Code.STOPPED)

#: Kernels of each layout.
_KERNELS = ("body_object", "moved_rates", "turned_rate", "path_rates")


class RowAlgorithms(NamedTuple):
    """Constraints of one kind of simulation.

    Attributes
    ----------
    fill_rows : algorithm
        Rows of all constraints, what they times the accelerations must be, errors and their rates; a status.
    constrain : algorithm
        These, and their directions.
    """

    fill_rows: algorithm
    constrain: algorithm


def row_algorithms(parts: Parts, k: Any) -> RowAlgorithms:
    """Constraints of a kind of simulation.

    Parameters
    ----------
    parts : Parts
    k : named tuple of KernelSpec
    """
    bodies_count, size, calls, largest = parts.bodies, parts.size, parts.calls, parts.largest
    angular, a_velocity, twist_layout, is_joined = parts.angular, parts.linear[0], parts.twist_layout, parts.bodies > 1
    keeps, row_count, most = parts.functions > 0, parts.rows, min(parts.rows, parts.size)
    work = work_records(parts)
    Work: Any = work.numbers
    Integers: Any = work.integers
    system = work.rows
    assert system is not None
    scale_rows, add_direction = system.scale_rows, system.add_direction
    numbers_size, integers_size = system.numbers.size, system.integers.size
    layouts = tuple(
        (x.number, x.size, tuple(enumerate(x.degrees)), *(getattr(k, f"{what}_{x.name}") for what in _KERNELS))
        for x in parts.layouts
    )

    @inlined
    def size_of(layout: Int) -> Int:
        """Coefficients of an object."""
        count = 0
        for number, n, _, _, _, _, _ in layouts:
            if layout == number:
                count = n
        return count

    @algorithm
    def see_object(
        layout: Int, motor: Vector[8], v: Vector[largest], fixed: Vector[largest], is_exact: Bool, velocity: Vector[6],
        u: Out[Vector[largest]], rates: Out[Vector[6 * largest]], bent: Out[Vector[largest]],
    ) -> None:  # fmt: skip
        """U = ~S V S; U x E for each unit twist E, or that of what is fixed to the body; and what rotation takes."""
        for number, n, _, body_object, moved_rates, turned_rate, _ in layouts:
            if layout == number:
                u[0:n] = body_object(motor, v[0:n])
                if is_exact:
                    rates[0 : 6 * n] = moved_rates(fixed[0:n])
                else:
                    rates[0 : 6 * n] = moved_rates(u[0:n])
                bent[0:n] = turned_rate(u[0:n], velocity)

    @algorithm
    def see_path(
        layout: Int, motor: Vector[8], velocity: Vector[6], path: Reals, rate: Out[Vector[largest]],
        bent: Out[Vector[largest]],
    ) -> None:  # fmt: skip
        """Rates of an object that moves by itself, of which V and two derivatives follow each other."""
        for number, n, _, _, _, _, path_rates in layouts:
            if layout == number:
                rate[0:n], bent[0:n] = path_rates(motor, velocity, path[0:n], path[n : 2 * n], path[2 * n : 3 * n])

    @algorithm
    def estimate_roundings(
        layout: Int, v: Vector[largest], distance: Real, farthest: Real, rounding: Out[Vector[3]]
    ) -> None:
        """Rounding of the coefficients that a body sees of an object V, by their degrees.

        The distance of the body from the frame that it is seen from, and the farthest of both from the world's origin.
        """
        sums = zeros(3)
        for number, _, degrees, _, _, _, _ in layouts:
            if layout == number:
                for j, degree in degrees:
                    sums[degree] += abs(v[j])
        rounding[0] = epsilon() * sums[0]
        rounding[1] = epsilon() * (sums[1] + farthest * sums[0])
        rounding[2] = epsilon() * (sums[2] + farthest * (sums[1] + distance * sums[0]))

    @still
    def see_roundings(
        layout: Int, c: Constraint, body: Body, motor: Vector[8], motors: Vector[8 * bodies_count],
        v: Vector[largest], fixed: Vector[largest], is_exact: Bool, blur: Out[Vector[largest]],
        noise: Out[Vector[largest]],
    ) -> Real:  # fmt: skip
        """Rounding of each coefficient, and of its rates by energy; that of the power of a wrench."""
        rotation = 0.0
        for axis in angular:
            rotation = max(rotation, body.roots[axis])
        path = body.roots[a_velocity]
        distance = k.distance_of(motor)
        farthest = distance
        if is_joined and c.other >= 0:
            own = k.distance_of(motors[8 * c.body : 8 * c.body + 8])
            others = k.distance_of(motors[8 * c.other : 8 * c.other + 8])
            farthest = own + others
        rounding = empty(3)
        of_rates = empty(3)
        estimate_roundings(layout, v, distance, farthest, rounding)
        if is_exact:
            estimate_roundings(layout, fixed, 0.0, 0.0, of_rates)
        else:
            of_rates[:] = rounding
        for number, _, degrees, _, _, _, _ in layouts:
            if layout == number:
                for j, degree in degrees:
                    blur[j] = rounding[degree]
                    if degree > 0:
                        noise[j] = of_rates[degree] * rotation + of_rates[degree - 1] * path
                    else:
                        noise[j] = of_rates[degree] * rotation + 0.0
        return of_rates[2] * rotation + of_rates[1] * path

    @still_inlined
    def term_size(weight: Real, value: Real) -> Real:
        """Size of a term of an error."""
        return abs(weight * value)

    @algorithm
    def fill_constraint(
        numbers: Reals, bodies: Rows[Body], c: Constraint, w: InOut[Work], p: InOut[Integers], first: Int, t: Real,
        motors: Vector[8 * bodies_count], twists: Vector[size],
    ) -> Int:  # fmt: skip
        """Rows of one constraint, from a first one on; a status.

        Of what is fixed to the body its rates are exact: seen through a pose that is slightly off, rows that depend on
        each other would seem to differ. Where nothing brings the pose back, matrix and right sides go together instead.
        """
        is_power = c.layout < 0
        layout = twist_layout if is_power else c.layout
        n = size_of(layout)
        has_matrix = c.a >= 0
        moves = False
        unknown = numbers[c.unknown] if c.unknown >= 0 else 0.0
        motor = empty(8)
        velocity = empty(6)
        if is_joined:
            change = empty(36)
            extra = empty(6)
        motor[:] = motors[8 * c.body : 8 * c.body + 8]
        velocity[:] = twists[6 * c.body : 6 * c.body + 6]
        if is_joined and c.other >= 0:
            carried = empty(6)
            motor[:] = k.relative(motors[8 * c.other : 8 * c.other + 8], motors[8 * c.body : 8 * c.body + 8])
            change[:] = k.adjoint(motor)
            for i in range(6):
                carried[i] = 0.0
                for j in range(6):
                    carried[i] += change[6 * i + j] * twists[6 * c.other + j]
            for j in range(6):
                velocity[j] -= carried[j]
            extra[:] = k.bracket(carried, velocity)
        if calls:
            values = w.values[max(c.user, 0) if keeps else 0]
            v = empty(largest)
            fixed = empty(largest)
            if c.user >= 0:
                moves = True
                state = empty(14)
                state_of(c.body, motors, twists, state)
                failed = 0
                if not keeps or p.held == 0:
                    failed = user_values(p.handle, c.user, p.item, t, state, values)
                if failed != 0:
                    return USER_FAILED
                unknown = values[3 * n + 3 * c.rows]
            for j in range(n):
                v[j] = values[j] if moves else numbers[c.v + j]
            for j in range(min(c.rows, n)):
                fixed[j] = values[3 * n + j] if moves else numbers[c.h + j]
        else:
            v = numbers[c.v : c.v + largest]
            fixed = numbers[c.h : c.h + largest]
        is_exact = not is_power and not has_matrix and p.project != 0
        u = zeros(largest)
        rate = zeros(largest)
        bent = empty(largest)
        rates = empty(6 * largest)
        see_object(layout, motor, v, fixed, is_exact, velocity, u, rates, bent)
        if calls and moves:
            see_path(layout, motor, velocity, values, rate, bent)
        blur = zeros(largest)
        noises = zeros(largest)
        of_power = 0.0
        if p.held == 0:
            of_power = see_roundings(layout, c, bodies[c.body], motor, motors, v, fixed, is_exact, blur, noises)
        bend = empty(6)
        pulled = empty(6)
        row = empty(6)
        for i in range(c.rows):
            to = first + i
            error = 0.0
            slope = 0.0
            right = 0.0
            made_of = 0.0
            blurred = 0.0
            noise = 0.0
            row[:] = 0.0
            if is_power:  # of unit twists against the wrench
                noise = of_power
                row[:] = k.covector_of(u[0:6])
                for j in range(6):
                    pulled[j] = rate[j]
                    for m in range(6):
                        pulled[j] -= rates[6 * m + j] * velocity[m]
                bend[:] = k.covector_of(pulled)
                for j in range(6):
                    right -= bend[j] * velocity[j]
            else:
                for m in range(0 if has_matrix else i, n if has_matrix else i + 1):
                    weight = numbers[c.a + n * i + m] if has_matrix else 1.0
                    error += weight * u[m]
                    made_of += term_size(weight, u[m])
                    blurred += term_size(weight, 1.0) * blur[m]
                    noise += term_size(weight, 1.0) * noises[m]
                    right += weight * bent[m]
                    if moves:
                        slope += weight * rate[m]
                    for j in range(6):
                        row[j] += weight * rates[n * j + m]
                goal = numbers[c.h + i]
                if calls and moves:
                    goal = values[3 * n + i]
                    slope -= values[3 * n + c.rows + i]
                    right -= values[3 * n + 2 * c.rows + i]
                error -= goal
                made_of += term_size(1.0, goal)
            for j in range(6):
                slope -= row[j] * velocity[j]
            for j in range(size):
                w.matrix[to, j] = 0.0
            for j in range(6):
                w.matrix[to, 6 * c.body + j] = row[j]
            if is_joined and c.other >= 0:
                for j in range(6):
                    right -= row[j] * extra[j]
                    for m in range(6):
                        w.matrix[to, 6 * c.other + m] -= row[j] * change[6 * j + m]
            w.right[to] = right
            w.errors[to] = error
            w.rates[to] = slope
            w.sizes[to] = made_of
            w.rounding[to] = blurred + epsilon() * made_of
            w.noise[to] = noise
            w.unknown[to] = unknown
        return OK

    @algorithm
    def fill_rows(
        numbers: Reals, bodies: Rows[Body], constraints: Rows[Constraint], w: InOut[Work], p: InOut[Integers], t: Real,
        motors: Vector[8 * bodies_count], twists: Vector[size],
    ) -> Int:  # fmt: skip
        """Rows of all constraints, what they times the accelerations must be, errors and their rates; a status."""
        first = 0
        for i in range(p.constraints):
            status = fill_constraint(numbers, bodies, constraints[i], w, p, first, t, motors, twists)
            if status != OK:
                return int(status)
            first += constraints[i].rows
        return OK

    @algorithm
    def constrain(
        numbers: Reals, bodies: Rows[Body], constraints: Rows[Constraint], w: InOut[Work], p: InOut[Integers],
        stop: IntVector[1], t: Real, motors: Vector[8 * bodies_count], twists: Vector[size], tolerance: Real,
    ) -> Int:  # fmt: skip
        """Rows of all constraints and their directions; a status. A stop that is not 0 ends it."""
        status = fill_rows(numbers, bodies, constraints, w, p, t, motors, twists)
        if status != OK:
            return int(status)
        for b in range(bodies_count):
            for j in range(6):
                w.weights[6 * b + j] = bodies[b].roots[j]
        if p.held != 0:
            return OK
        scale_rows(w[0:numbers_size], p[0:integers_size], row_count, 0, w.weights, tolerance)
        more = True
        for m in range(most + 1):
            if stop[0] != 0:
                return STOPPED
            if more:
                more = add_direction(w[0:numbers_size], p[0:integers_size], row_count, 0, m, p.known_rank)
        return OK

    return RowAlgorithms(fill_rows, constrain)
