"""Simulations: tangents of a state along a direction of its numbers and of its start.

A tangent of a motor is a twist in its own frame, dR = -R delta/2, so that motors stay motors. One direction has such
twists of all bodies, then the tangents of their twists. Rates and steps along it are the derivatives of their
algorithms; the directions of rows are found once for all: see ``held`` of the work.

Annotations are evaluated: sizes are those of the kind of simulation.
"""

from collections.abc import Mapping
from typing import Any, NamedTuple

from ...ir.algorithm_derivative import derivative_of
from ...ir.loops.algorithm import Algorithm as algorithm
from ...ir.loops.language import Bool, InOut, Int, IntRows, IntVector, Out, Real, Reals, Rows, Vector, empty
from ..weighted_rows import COARSE
from .projection import ProjectionAlgorithms
from .records import Body, Code, Constraint, Parts, kept_record, work_records

OK = int(Code.OK)
BODY = Body.size


class TangentAlgorithms(NamedTuple):
    """Tangents of one kind of simulation.

    Attributes
    ----------
    project_tangents : algorithm or None
        Tangents to the nearest ones that the constraints allow.
    tangents_far : algorithm or None
        The same before a state is brought to the constraints, which may be far.
    step_tangents : algorithm or None
        Tangents at the end of one step of a fixed length, or of some in flight, of methods without a chart.
    momenta_tangents, twist_tangents : algorithm or None
        Of compositions, which keep momenta: from tangents of twists to those of momenta, and back.
    """

    project_tangents: algorithm | None
    tangents_far: algorithm | None
    step_tangents: algorithm | None
    momenta_tangents: algorithm | None
    twist_tangents: algorithm | None


def tangent_algorithms(
    parts: Parts, k: Any, projections: ProjectionAlgorithms, method: Mapping[str, Any]
) -> TangentAlgorithms:
    """Tangents of a kind of simulation.

    Parameters
    ----------
    parts : Parts
    k : named tuple of KernelSpec
    projections : ProjectionAlgorithms
    method : mapping of str to algorithm
        Of the method: see `MethodAlgorithms`.
    """
    count, n, size, tangents = parts.bodies, 8 * parts.bodies, parts.size, parts.tangents
    work = work_records(parts)
    own_size = work.numbers.size
    Work: Any = work.whole
    Integers: Any = work.integers
    Kept: Any = kept_record(parts)
    fixed_step, composed_step, flight_steps, to_momenta, to_twist = (
        method.get(name) for name in ("fixed_step", "composed_step", "flight_steps", "to_momenta", "to_twist")
    )
    in_flight, is_composed = flight_steps is not None, composed_step is not None
    project_tangents: Any = None
    tangents_far: Any = None
    step_tangents: Any = None
    momenta_tangents: Any = None
    twist_tangents: Any = None

    @algorithm
    def motor_tangents(motors: Vector[n], found: Vector[2 * size], rates: Out[Vector[n]]) -> None:
        """Tangents of motors from twists."""
        for b in range(count):
            rates[8 * b : 8 * b + 8] = k.motor_rate(motors[8 * b : 8 * b + 8], found[6 * b : 6 * b + 6])

    @algorithm
    def motor_twists(motors: Vector[n], rates: Vector[n], found: InOut[Vector[2 * size]]) -> None:
        """And back."""
        for b in range(count):
            found[6 * b : 6 * b + 6] = k.twist_of(motors[8 * b : 8 * b + 8], rates[8 * b : 8 * b + 8])

    if projections.move_back is not None and projections.project is not None:
        project_along = derivative_of(projections.project, "numbers", "bodies", "w", "motors", "twists")

        @algorithm
        def tangents_far(
            numbers: Reals, bodies: Rows[Body], springs: IntRows[2], user_loads: IntRows[3],
            constraints: Rows[Constraint], directions: Reals, w: InOut[Work], p: InOut[Integers], stop: IntVector[1],
            t: Real, motors: Vector[n], twists: Vector[size], found: InOut[Vector[2 * size * tangents]],
            is_start: Bool,
        ) -> Int:  # fmt: skip
            """Tangents of a state that will be brought to the constraints, a start or behind a step; a status."""
            rates = empty(n)
            moved = empty(n)
            changed = empty(size)
            status = OK
            for q in range(tangents):
                along = directions[p.stride * q :]
                own = found[2 * size * q : 2 * size * q + 2 * size]
                moved[:] = motors
                changed[:] = twists
                motor_tangents(moved, own, rates)
                for tolerance in (COARSE, 0.0):
                    if status == OK and (is_start or tolerance == 0.0):
                        status, _ = project_along(
                            numbers, bodies, constraints, w[0:own_size], p, stop, t,
                            tolerance if tolerance > 0.0 else w.tolerance, moved, changed, along, along, w.along,
                            rates, own[size : 2 * size],
                        )  # fmt: skip
                motor_twists(moved, rates, own)
            return int(status)

        move_back_along = derivative_of(projections.move_back, "numbers", "bodies", "w", "motors", "twists")

        @algorithm
        def project_tangents(
            numbers: Reals, bodies: Rows[Body], springs: IntRows[2], user_loads: IntRows[3],
            constraints: Rows[Constraint], directions: Reals, w: InOut[Work], p: InOut[Integers], stop: IntVector[1],
            t: Real, motors: Vector[n], twists: Vector[size], found: InOut[Vector[2 * size * tangents]],
        ) -> Int:  # fmt: skip
            """Tangents of a state on the constraints to the nearest ones that these allow; a status."""
            rates = empty(n)
            moved = empty(n)
            changed = empty(size)
            status = OK
            for q in range(tangents):
                along = directions[p.stride * q :]
                own = found[2 * size * q : 2 * size * q + 2 * size]
                for part in range(2):  # of poses first: those of twists depend on them
                    if status == OK:
                        moved[:] = motors
                        changed[:] = twists
                        motor_tangents(motors, own, rates)
                        status = move_back_along(
                            numbers, bodies, constraints, w[0:own_size], p, stop, t, part, moved, changed, along,
                            along, w.along, rates, own[size : 2 * size],
                        )  # fmt: skip
                        p.held = 1
                        if part == 0:
                            motor_twists(moved, rates, own)
            p.held = 0
            return int(status)

    if fixed_step is not None:
        step_along: Any = derivative_of(fixed_step, "numbers", "bodies", "w", "motors", "twists")
    elif composed_step is not None:
        step_along = derivative_of(composed_step, "numbers", "bodies", "w", "motor", "momenta")
    elif flight_steps is not None:
        step_along = derivative_of(flight_steps, "body", "motor", "twist")
    else:
        step_along = None

    if step_along is not None:

        @algorithm
        def step_tangents(
            numbers: Reals, bodies: Rows[Body], springs: IntRows[2], user_loads: IntRows[3],
            constraints: Rows[Constraint], directions: Reals, scheme: Reals, w: InOut[Work], p: InOut[Integers],
            stop: IntVector[1], t: Real, h: Real, steps: Int, kept: InOut[Kept],
        ) -> Int:  # fmt: skip
            """Tangents at the end of a step from the state that is kept, which stays; a status."""
            rates = empty(n)
            moved = empty(n)
            changed = empty(size)
            status = OK
            for q in range(tangents):
                along = directions[p.stride * q :]
                own = kept.tangents[2 * size * q : 2 * size * q + 2 * size]
                moved[:] = kept.motors
                motor_tangents(moved, own, rates)
                if status == OK:
                    if in_flight:
                        changed[:] = kept.twists
                        step_along(
                            bodies[0], h, steps, moved, changed, along[0:BODY], rates, own[size : 2 * size]
                        )
                    elif is_composed:
                        changed[:] = kept.momenta
                        status = step_along(
                            numbers, bodies, springs, user_loads, w[0:own_size], p, t, h, scheme, len(scheme), moved,
                            kept.twists, changed, along, along, w.along, rates, own[size : 2 * size],
                        )  # fmt: skip
                    else:
                        changed[:] = kept.twists
                        status = step_along(
                            numbers, bodies, springs, user_loads, constraints, w[0:own_size], p, stop, t, h, moved,
                            changed, along, along, w.along, rates, own[size : 2 * size],
                        )  # fmt: skip
                motor_twists(moved, rates, own)
            return int(status)

    if to_momenta is not None and to_twist is not None:
        momenta_along: Any = derivative_of(to_momenta, "body", "motor", "twist")
        twist_along: Any = derivative_of(to_twist, "body", "motor", "momenta")

        @algorithm
        def momenta_tangents(bodies: Rows[Body], directions: Reals, p: Integers, kept: InOut[Kept]) -> None:
            """Tangents of momenta in place of those of twists."""
            rates = empty(n)
            changed = empty(6)
            other = empty(6)
            for q in range(tangents):
                along = directions[p.stride * q :]
                own = kept.tangents[12 * q : 12 * q + 12]
                motor_tangents(kept.motors, own, rates)
                momenta_along(
                    bodies[0], kept.motors, kept.twists, changed, along[0:BODY], rates, own[6:12], other
                )
                for j in range(6):
                    own[6 + j] = other[j]

        @algorithm
        def twist_tangents(
            bodies: Rows[Body], directions: Reals, p: Integers, kept: Kept, found: Out[Vector[2 * size * tangents]]
        ) -> None:
            """Tangents of motors and twists from those that are kept, of motors and momenta."""
            rates = empty(n)
            changed = empty(6)
            other = empty(6)
            for q in range(tangents):
                along = directions[p.stride * q :]
                own = kept.tangents[12 * q : 12 * q + 12]
                motor_tangents(kept.motors, own, rates)
                twist_along(bodies[0], kept.motors, kept.momenta, changed, along[0:BODY], rates, own[6:12], other)
                for j in range(6):
                    found[12 * q + j] = own[j]
                    found[12 * q + 6 + j] = other[j]

    return TangentAlgorithms(project_tangents, tangents_far, step_tangents, momenta_tangents, twist_tangents)
