"""Simulations: compositions of exact flows, and the flight of a free body, of one body each.

Annotations are evaluated: sizes are those of the kind of simulation.
"""

from typing import Any, NamedTuple

from ....ir.algorithm_derivative import derivative_of
from ....ir.loops.algorithm import Algorithm as algorithm
from ....ir.loops.algorithm import inlined, with_tangent
from ....ir.loops.language import InOut, Int, IntRows, Out, Real, Reals, Rows, Vector, empty
from ..acceleration import RateAlgorithms
from ..records import Body, Code, Parts, work_records
from .fixed_steps import CLASSICAL

OK = int(Code.OK)


class FlowAlgorithms(NamedTuple):
    """A composition of flows for one body, free or turning about a point, under loads that do not depend on velocity.

    Attributes
    ----------
    composed_step : algorithm
        One step; a status.
    to_momenta, to_twist : algorithm
        The momenta of a state, linear and angular, and back.
    """

    composed_step: algorithm
    to_momenta: algorithm
    to_twist: algorithm


def flow_algorithms(parts: Parts, k: Any, rates: RateAlgorithms) -> FlowAlgorithms:
    """Compositions of flows.

    Parameters
    ----------
    parts : Parts
    k : named tuple of KernelSpec
    rates : RateAlgorithms
    """
    loads, a_velocity, add_wrenches = parts.loads, parts.linear[0], rates.add_wrenches
    work = work_records(parts)
    Work: Any = work.numbers
    Integers: Any = work.integers

    @algorithm
    def push(
        numbers: Reals, bodies: Rows[Body], springs: IntRows[2], user_loads: IntRows[3], w: InOut[Work],
        p: InOut[Integers], t: Real, h: Real, motor: Vector[8], twist: Vector[6], momenta: InOut[Vector[6]],
    ) -> Int:  # fmt: skip
        """What the loads add to the momenta; a status."""
        if loads:
            rows = empty(6)
            status = add_wrenches(numbers, bodies, springs, user_loads, w, p, t, motor, twist, rows)
            if status != OK:
                return int(status)
            force, moment = k.parts_of_momentum(motor, rows)
            for j in range(3):
                momenta[j] += h * force[j]
                momenta[3 + j] += h * moment[j]
        return OK

    @inlined
    def turn_about(flow: Vector[4], h: Real, momenta: Vector[6], motor: InOut[Vector[8]]) -> None:
        """The flow of one axis of the body: its direction, and what is left of its rate."""
        r = empty(8)
        r[:] = motor
        motor[:] = k.axial_flow(r, momenta[3:6], flow[0:3], h * flow[3])

    turn_about_axis_along: Any = None
    if parts.tangents:
        turn_along = derivative_of(turn_about, "flow", "momenta", "motor")

        @algorithm
        def turn_about_axis_along(
            flow: Vector[4], h: Real, momenta: Vector[6], motor: InOut[Vector[8]], d_flow: Vector[4],
            d_momenta: Vector[6], d_motor: InOut[Vector[8]],
        ) -> None:  # fmt: skip
            """The same with its tangent, also where two moments of inertia are equal and nothing is left."""
            turn_along(flow, h, momenta, motor, d_flow, d_momenta, d_motor)

    @with_tangent(turn_about_axis_along)
    def turn_about_axis(flow: Vector[4], h: Real, momenta: Vector[6], motor: InOut[Vector[8]]) -> None:
        """The same, unless nothing is left of the rate."""
        if h * flow[3] != 0.0:
            turn_about(flow, h, momenta, motor)

    @algorithm
    def move_centrally(body: Body, h: Real, momenta: Vector[6], motor: InOut[Vector[8]]) -> None:
        """The flow of a body with equal moments of inertia, and its linear motion."""
        path = empty(3)
        turned = k.central_flow(motor, momenta[3:6], h * body.flows[0])
        for j in range(3):
            path[j] = h * body.inverse[a_velocity] * momenta[j]
        motor[:] = k.translate(turned, path)

    @algorithm
    def composed_step(
        numbers: Reals, bodies: Rows[Body], springs: IntRows[2], user_loads: IntRows[3], w: InOut[Work],
        p: InOut[Integers], t: Real, h: Real, fractions: Reals, count: Int, motor: InOut[Vector[8]], twist: Vector[6],
        momenta: InOut[Vector[6]],
    ) -> Int:  # fmt: skip
        """A step; a status. Parts in order: loads, second axis, first axis, central; a flow and its adjoint in turn."""
        body = bodies[0]
        r = empty(8)
        now = t
        status = push(numbers, bodies, springs, user_loads, w, p, now, h * fractions[0], motor, twist, momenta)
        for i in range(0, count, 2):
            if status != OK:
                return int(status)
            there = h * fractions[i]
            back = h * fractions[i + 1]
            turn_about_axis(body.flows[5:9], there, momenta, motor)
            turn_about_axis(body.flows[1:5], there, momenta, motor)
            move_centrally(body, there + back, momenta, motor)
            now += there + back
            turn_about_axis(body.flows[1:5], back, momenta, motor)
            turn_about_axis(body.flows[5:9], back, momenta, motor)
            r[:] = motor
            motor[:] = k.near_motor(r)
            following = fractions[i + 2] if i + 2 < count else 0.0
            part = h * (fractions[i + 1] + following)
            status = push(numbers, bodies, springs, user_loads, w, p, now, part, motor, twist, momenta)
        return int(status)

    @algorithm
    def to_momenta(body: Body, motor: Vector[8], twist: Vector[6], momenta: Out[Vector[6]]) -> None:
        """Linear and angular momentum of a state."""
        row = empty(6)
        for j in range(6):
            row[j] = body.metric[j] * twist[j]
        momenta[0:3], momenta[3:6] = k.parts_of_momentum(motor, row)

    @algorithm
    def to_twist(body: Body, motor: Vector[8], momenta: Vector[6], twist: Out[Vector[6]]) -> None:
        """The twist of a state."""
        row = k.momentum_row(motor, momenta[0:3], momenta[3:6])
        for j in range(6):
            twist[j] = body.inverse[j] * row[j]

    return FlowAlgorithms(composed_step, to_momenta, to_twist)


def flight_algorithm(parts: Parts, k: Any) -> algorithm:
    """The classical step of one free body under gravity alone.

    Parameters
    ----------
    parts : Parts
    k : named tuple of KernelSpec
    """
    falls, a_velocity = "gravity" in parts.loads, parts.linear[0]

    @algorithm
    def flight_steps(body: Body, h: Real, count: Int, motor: InOut[Vector[8]], twist: InOut[Vector[6]]) -> None:
        """The rotation by itself, and the flight of the centre, which a step of any length makes exactly."""
        inverse = empty(3)
        fall = empty(3)
        r = empty(4)
        rate = empty(3)
        dr = empty(4)
        change = empty(3)
        sum_r = empty(4)
        total = empty(3)
        q, x, v, spin = k.flight(motor, twist)
        for j in range(3):
            inverse[j] = 1.0 / body.moments[j]
            fall[j] = body.weight[j] * body.inverse[a_velocity] if falls else 0.0
        for _ in range(count):
            r[:] = q
            sum_r[:] = q
            rate[:] = spin
            total[:] = spin
            for _, part, weight in CLASSICAL:
                ahead = h / part
                fraction = h * weight / 6.0
                dr[:] = k.rotor_rate(r, rate)
                change[:] = k.spin_rate(rate, body.moments, inverse)
                for j in range(4):
                    sum_r[j] += fraction * dr[j]
                    r[j] = q[j] + ahead * dr[j]
                for j in range(3):
                    total[j] += fraction * change[j]
                    rate[j] = spin[j] + ahead * change[j]
            q[:] = k.renormalize(sum_r)
            for j in range(3):
                spin[j] = total[j]
                x[j] += h * (v[j] + h / 2.0 * fall[j])
                v[j] += h * fall[j]
        motor[:], twist[:] = k.state_after_flight(q, x, v, spin)

    return flight_steps
