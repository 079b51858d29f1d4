"""Simulations: steps of methods whose step is fixed, on motors and twists.

Annotations are evaluated: sizes are those of the kind of simulation.
"""

from typing import Any

from ....ir.algorithm_derivative import derivative_of
from ....ir.loops.algorithm import Algorithm as algorithm
from ....ir.loops.algorithm import inlined, with_tangent
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
    zeros,
)  # fmt: skip
from ..acceleration import RateAlgorithms
from ..records import Body, Code, Constraint, Parts, work_records

OK, NOT_SOLVED = int(Code.OK), int(Code.NOT_SOLVED)
#: The classical method: time of a stage, how far ahead the next one is, and its weight.
CLASSICAL = ((0.0, 2.0, 1.0), (0.5, 2.0, 2.0), (0.5, 1.0, 2.0), (1.0, 1.0, 1.0))
#: Stages of the commutator-free method of order four of Celledoni, Marthinsen and Owren: number, time, whether it
#: begins at the second stage, weights of the twists in the exponential, and of the accelerations.
STAGES = (
    (0, 0.0, False, (0.0, 0.0, 0.0, 0.0), ()),
    (1, 0.5, False, (0.5, 0.0, 0.0, 0.0), ((0, 0.5),)),
    (2, 0.5, False, (0.0, 0.5, 0.0, 0.0), ((0, 0.0), (1, 0.5))),
    (3, 1.0, True, (-0.5, 0.0, 1.0, 0.0), ((0, 0.0), (1, 0.0), (2, 1.0))),
)  # fmt: skip
#: Its two exponentials at the end.
FIRST = (3.0 / 12.0, 2.0 / 12.0, 2.0 / 12.0, -1.0 / 12.0)
SECOND = (-1.0 / 12.0, 2.0 / 12.0, 2.0 / 12.0, 3.0 / 12.0)
BOTH = tuple((i, a + b) for i, (a, b) in enumerate(zip(FIRST, SECOND, strict=True)))
#: Squares of relative changes of the implicit midpoint rule: solved, and good enough where it changes no more.
SOLVED, NEARLY_SOLVED = 1e-32, 1e-20
#: Rounds of it: at least, and at most.
FEWEST, MOST = 3, 100


def fixed_step_algorithm(parts: Parts, k: Any, rates: RateAlgorithms) -> algorithm:
    """One step of the classical, the commutator-free or the implicit midpoint method; a status.

    Parameters
    ----------
    parts : Parts
    k : named tuple of KernelSpec
    rates : RateAlgorithms
    """
    return METHODS[parts.methods[0]](parts, k, rates)


def _rotor_step(parts: Parts, k: Any, rates: RateAlgorithms) -> algorithm:
    count, n, size, accelerate = parts.bodies, 8 * parts.bodies, parts.size, rates.accelerate
    work = work_records(parts)
    Work: Any = work.numbers
    Integers: Any = work.integers
    is_large = parts.is_large

    @algorithm
    def fixed_step(
        numbers: Reals, bodies: Rows[Body], springs: IntRows[2], user_loads: IntRows[3], constraints: Rows[Constraint],
        w: InOut[Work], p: InOut[Integers], stop: IntVector[1], t: Real, h: Real, motors: InOut[Vector[n]],
        twists: InOut[Vector[size]],
    ) -> Int:  # fmt: skip
        """The classical step on the coefficients of the motors, brought back to motors at its end."""
        if is_large:
            r = w.scratch[0:n]
            dr = w.scratch[n : 2 * n]
            sum_r = w.scratch[2 * n : 3 * n]
            rate = w.scratch[3 * n : 3 * n + size]
            change = w.scratch[3 * n + size : 3 * n + 2 * size]
            total = w.scratch[3 * n + 2 * size : 3 * n + 3 * size]
            rows = w.scratch[3 * n + 3 * size : 3 * n + 4 * size]
        else:
            r = empty(n)
            dr = empty(n)
            sum_r = empty(n)
            rate = empty(size)
            change = empty(size)
            total = empty(size)
            rows = empty(size)
        r[:] = motors
        sum_r[:] = motors
        rate[:] = twists
        total[:] = twists
        for time, part, weight in CLASSICAL:
            ahead = h / part
            fraction = h * weight / 6.0
            status = accelerate(
                numbers, bodies, springs, user_loads, constraints, w, p, stop, t + time * h, r, rate, rows, change
            )
            if status != OK:
                return int(status)
            for b in range(count):
                dr[8 * b : 8 * b + 8] = k.motor_rate(r[8 * b : 8 * b + 8], rate[6 * b : 6 * b + 6])
            for j in range(n):
                sum_r[j] += fraction * dr[j]
                r[j] = motors[j] + ahead * dr[j]
            for j in range(size):
                total[j] += fraction * change[j]
                rate[j] = twists[j] + ahead * change[j]
        for b in range(count):
            motors[8 * b : 8 * b + 8] = k.near_motor(sum_r[8 * b : 8 * b + 8])
        twists[:] = total
        return OK

    return fixed_step


def _free_step(parts: Parts, k: Any, rates: RateAlgorithms) -> algorithm:
    count, n, size, accelerate = parts.bodies, 8 * parts.bodies, parts.size, rates.accelerate
    work = work_records(parts)
    Work: Any = work.numbers
    Integers: Any = work.integers
    is_large = parts.is_large

    @algorithm
    def turn(motors: Vector[n], h: Real, weights: Vector[4], stages: Vector[8 * size], moved: Out[Vector[n]]) -> None:
        """Motors turned by h times a sum of weighted twists: R exp(-(...)/2)."""
        phi = empty(6)
        for b in range(count):
            phi[:] = 0.0
            for i in range(4):
                if weights[i] != 0.0:
                    for j in range(6):
                        phi[j] += h * weights[i] * stages[2 * size * i + 6 * b + j]
            moved[8 * b : 8 * b + 8] = k.move_by_twist(motors[8 * b : 8 * b + 8], phi)

    @algorithm
    def fixed_step(
        numbers: Reals, bodies: Rows[Body], springs: IntRows[2], user_loads: IntRows[3], constraints: Rows[Constraint],
        w: InOut[Work], p: InOut[Integers], stop: IntVector[1], t: Real, h: Real, motors: InOut[Vector[n]],
        twists: InOut[Vector[size]],
    ) -> Int:  # fmt: skip
        """A step of the commutator-free method: two exponentials make it."""
        if is_large:
            stages = w.scratch[0 : 8 * size]
            rows = w.scratch[8 * size : 9 * size]
            own = w.scratch[9 * size : 9 * size + n]
            second = w.scratch[9 * size + n : 9 * size + 2 * n]
        else:
            stages = zeros(8 * size)  # the first stage adds none of them
            rows = empty(size)
            own = empty(n)
            second = empty(n)
        for i, time, is_behind, weights, ahead in STAGES:
            rate = stages[2 * size * i : 2 * size * i + size]
            if is_behind:
                turn(second, h, weights, stages, own)
            else:
                turn(motors, h, weights, stages, own)
            if i == 1:
                second[:] = own
            for j in range(size):
                rate[j] = twists[j]
                for m, weight in ahead:
                    rate[j] += h * weight * stages[2 * size * m + size + j]
            status = accelerate(
                numbers, bodies, springs, user_loads, constraints, w, p, stop, t + time * h, own, rate, rows,
                stages[2 * size * i + size : 2 * size * i + 2 * size],
            )  # fmt: skip
            if status != OK:
                return int(status)
        turn(motors, h, FIRST, stages, own)
        turn(own, h, SECOND, stages, second)
        for b in range(count):
            motors[8 * b : 8 * b + 8] = k.near_motor(second[8 * b : 8 * b + 8])
        for j in range(size):
            for i, weight in BOTH:
                twists[j] += h * weight * stages[2 * size * i + size + j]
        return OK

    return fixed_step


def _midpoint_step(parts: Parts, k: Any, rates: RateAlgorithms) -> algorithm:
    count, n, size, accelerate = parts.bodies, 8 * parts.bodies, parts.size, rates.accelerate
    work = work_records(parts)
    Work: Any = work.numbers
    Integers: Any = work.integers
    is_large = parts.is_large

    @algorithm
    def middle_rates(
        numbers: Reals, bodies: Rows[Body], springs: IntRows[2], user_loads: IntRows[3], constraints: Rows[Constraint],
        w: InOut[Work], p: InOut[Integers], stop: IntVector[1], t: Real, h: Real, motors: Vector[n],
        middle: Vector[size], change: Out[Vector[size]],
    ) -> Int:  # fmt: skip
        """Accelerations in the middle of a step with these twists; a status."""
        if is_large:
            rows = w.scratch[2 * size : 3 * size]
            moved = w.scratch[3 * size : 3 * size + n]
        else:
            rows = empty(size)
            moved = empty(n)
        phi = empty(6)
        for b in range(count):
            for j in range(6):
                phi[j] = h / 2.0 * middle[6 * b + j]
            moved[8 * b : 8 * b + 8] = k.move_by_twist(motors[8 * b : 8 * b + 8], phi)
        status = accelerate(
            numbers, bodies, springs, user_loads, constraints, w, p, stop, t + h / 2.0, moved, middle, rows, change
        )
        return int(status)

    @inlined
    def improve(h: Real, twists: Vector[size], change: Vector[size], middle: InOut[Vector[size]]) -> tuple[Real, Real]:
        """The next twists in the middle; squares of their change and of themselves."""
        off = 0.0
        length = 0.0
        for j in range(size):
            better = twists[j] + h / 2.0 * change[j]
            off += (better - middle[j]) * (better - middle[j])
            length += better * better
            middle[j] = better
        return off, length

    @algorithm
    def solve_middle(
        numbers: Reals, bodies: Rows[Body], springs: IntRows[2], user_loads: IntRows[3], constraints: Rows[Constraint],
        w: InOut[Work], p: InOut[Integers], stop: IntVector[1], t: Real, h: Real, motors: Vector[n],
        twists: Vector[size], middle: Out[Vector[size]],
    ) -> Int:  # fmt: skip
        """What `find_middle` does."""
        if is_large:  # noqa: SIM108
            change = w.scratch[size : 2 * size]
        else:
            change = empty(size)
        middle[:] = twists
        last = INFINITY
        rounds = 0
        while True:
            status = middle_rates(
                numbers, bodies, springs, user_loads, constraints, w, p, stop, t, h, motors, middle, change
            )
            if status != OK:
                return int(status)
            off, length = improve(h, twists, change, middle)
            if off <= SOLVED * length or (rounds > FEWEST and off >= last):
                return OK if off <= NEARLY_SOLVED * length else NOT_SOLVED
            if rounds == MOST:
                return NOT_SOLVED
            last = off
            rounds += 1

    find_middle_along: Any = None
    if parts.tangents:
        rates_along = derivative_of(middle_rates, "numbers", "bodies", "w", "motors", "middle")

        @algorithm
        def find_middle_along(
            numbers: Reals, bodies: Rows[Body], springs: IntRows[2], user_loads: IntRows[3],
            constraints: Rows[Constraint], w: InOut[Work], p: InOut[Integers], stop: IntVector[1], t: Real, h: Real,
            motors: Vector[n], twists: Vector[size], middle: Out[Vector[size]], d_numbers: Reals, d_bodies: Rows[Body],
            d_w: InOut[Work], d_motors: Vector[n], d_twists: Vector[size], d_middle: Out[Vector[size]],
        ) -> Int:  # fmt: skip
            """The same with its tangent, by rounds at the solution: the solution's own may end too soon for it."""
            if is_large:
                change = w.scratch[size : 2 * size]
                d_change = d_w.scratch[size : 2 * size]
            else:
                change = empty(size)
                d_change = empty(size)
            status = solve_middle(
                numbers, bodies, springs, user_loads, constraints, w, p, stop, t, h, motors, twists, middle
            )
            d_middle[:] = d_twists
            last = INFINITY
            rounds = 0
            more = status == OK
            while more:
                status = rates_along(
                    numbers, bodies, springs, user_loads, constraints, w, p, stop, t, h, motors, middle, change,
                    d_numbers, d_bodies, d_w, d_motors, d_middle, d_change,
                )  # fmt: skip
                off, length = improve(h, d_twists, d_change, d_middle)
                more = status == OK and not (off <= SOLVED * length or (rounds > FEWEST and off >= last))
                if not more and status == OK and not off <= NEARLY_SOLVED * length:
                    status = NOT_SOLVED
                if more and rounds == MOST:
                    more = False
                    status = NOT_SOLVED
                last = off
                rounds += 1
                p.held = 1
            p.held = 0
            return int(status)

    @with_tangent(find_middle_along)
    def find_middle(
        numbers: Reals, bodies: Rows[Body], springs: IntRows[2], user_loads: IntRows[3], constraints: Rows[Constraint],
        w: InOut[Work], p: InOut[Integers], stop: IntVector[1], t: Real, h: Real, motors: Vector[n],
        twists: Vector[size], middle: Out[Vector[size]],
    ) -> Int:  # fmt: skip
        """Twists in the middle of a step, which are half of its beginning and half of its end; a status."""
        status = solve_middle(
            numbers, bodies, springs, user_loads, constraints, w, p, stop, t, h, motors, twists, middle
        )
        return int(status)

    @algorithm
    def fixed_step(
        numbers: Reals, bodies: Rows[Body], springs: IntRows[2], user_loads: IntRows[3], constraints: Rows[Constraint],
        w: InOut[Work], p: InOut[Integers], stop: IntVector[1], t: Real, h: Real, motors: InOut[Vector[n]],
        twists: InOut[Vector[size]],
    ) -> Int:  # fmt: skip
        """The implicit midpoint rule on the group: symmetric; energy and momentum of a free body are kept."""
        if is_large:  # noqa: SIM108
            middle = w.scratch[0:size]
        else:
            middle = empty(size)
        phi = empty(6)
        status = find_middle(
            numbers, bodies, springs, user_loads, constraints, w, p, stop, t, h, motors, twists, middle
        )
        if status != OK:
            return int(status)
        for b in range(count):
            for j in range(6):
                phi[j] = h * middle[6 * b + j]
            turned = k.move_by_twist(motors[8 * b : 8 * b + 8], phi)
            motors[8 * b : 8 * b + 8] = k.near_motor(turned)
        for j in range(size):
            twists[j] = 2.0 * middle[j] - twists[j]
        return OK

    return fixed_step


#: What makes the step of each method.
METHODS = {"rk4": _rotor_step, "cf4": _free_step, "midpoint": _midpoint_step}
