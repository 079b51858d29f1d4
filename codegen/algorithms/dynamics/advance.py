"""Simulations: from where one stands to a time, step by step, with what comes after each.

Annotations are evaluated: sizes are those of the kind of simulation.
"""

from typing import Any, NamedTuple

from ...ir.loops.algorithm import Algorithm as algorithm
from ...ir.loops.language import Bool, InOut, Int, IntRows, IntVector, Out, Real, Reals, Rows, Vector, sqrt
from .records import Body, Code, Constraint, Parts, Progress, kept_record, work_records

OK, NOT_FINITE, RANK_CHANGED = int(Code.OK), int(Code.NOT_FINITE), int(Code.RANK_CHANGED)
STOPPED, VIOLATED, PAUSED, STALLED = int(Code.STOPPED), int(Code.VIOLATED), int(Code.PAUSED), int(Code.STALLED)
#: Steps of a body in flight between two looks at what else there is.
STEPS_IN_FLIGHT = 4096
#: A step that is so much shorter than what is left is not the last one.
ALMOST = 1.0 - 1e-12
#: Steps that are watched for progress; what counts as none: of the duration in all of them, and of a radian or of a
#: body's size in any.
WATCHED, NO_PROGRESS = 1000.0, 1e-5


class MethodAlgorithms(NamedTuple):
    """What a method of integration is to the loop over steps; what a method has not is None.

    Attributes
    ----------
    fixed_step : algorithm or None
        One step of a length on motors and twists.
    chart_step : algorithm or None
        The same in a chart.
    composed_step, to_momenta, to_twist : algorithm or None
        The same on momenta.
    flight_steps : algorithm or None
        Some steps of a body in flight.
    first_step, adaptive_step, find_state_between : algorithm or None
        Of Runge-Kutta pairs.
    start_series, series_step, find_state_of_series : algorithm or None
        Of Taylor series.
    project_tangents, tangents_far, step_tangents, momenta_tangents, twist_tangents : algorithm or None
        See `TangentAlgorithms`.
    """

    fixed_step: Any = None
    chart_step: Any = None
    composed_step: Any = None
    to_momenta: Any = None
    to_twist: Any = None
    flight_steps: Any = None
    first_step: Any = None
    adaptive_step: Any = None
    find_state_between: Any = None
    start_series: Any = None
    series_step: Any = None
    find_state_of_series: Any = None
    project_tangents: Any = None
    tangents_far: Any = None
    step_tangents: Any = None
    momenta_tangents: Any = None
    twist_tangents: Any = None


def advance_algorithm(parts: Parts, method: MethodAlgorithms, bring_back: Any, radius_of_gyration: Any) -> algorithm:
    """The state at a time, from where a simulation stands; a status.

    Parameters
    ----------
    parts : Parts
    method : MethodAlgorithms
    bring_back : algorithm or None
        See `ProjectionAlgorithms`.
    radius_of_gyration : algorithm
    """
    count, size, motors_size, state = parts.bodies, parts.size, 8 * parts.bodies, parts.state
    is_constrained, has_tangents = parts.mode == "constrained", parts.tangents > 0
    angular, linear = parts.angular, parts.linear
    in_flight, is_composed = method.flight_steps is not None, method.composed_step is not None
    has_chart, is_adaptive, has_series = (
        each is not None for each in (method.chart_step, method.adaptive_step, method.series_step)
    )
    adapts = is_adaptive or has_series
    work = work_records(parts)
    Kept: Any = kept_record(parts)
    Work: Any = work.whole
    own_size = work.numbers.size
    Integers: Any = work.integers
    fixed_step, chart_step, composed_step = method.fixed_step, method.chart_step, method.composed_step
    flight_steps, to_twist, project_tangents = method.flight_steps, method.to_twist, method.project_tangents
    step_tangents, twist_tangents, tangents_far = method.step_tangents, method.twist_tangents, method.tangents_far
    is_exact = step_tangents is not None  # a chart's tangents have the errors of its steps anyway
    adaptive_step, find_state_between = method.adaptive_step, method.find_state_between
    series_step, find_state_of_series = method.series_step, method.find_state_of_series
    restore: Any = None
    take_fixed_steps: Any = None
    is_stalled: Any = None

    @algorithm
    def is_finite(kept: Kept) -> Bool:
        """Whether the state is."""
        total = 0.0
        for j in range(motors_size):
            total += kept.motors[j] - kept.motors[j]
        for j in range(size):
            total += kept.twists[j] - kept.twists[j]
        if is_composed:
            for j in range(6):
                total += kept.momenta[j] - kept.momenta[j]
        if has_tangents:
            for j in range(len(kept.tangents)):
                total += kept.tangents[j] - kept.tangents[j]
        finite: Bool = total == 0.0
        return finite

    if is_constrained:

        @algorithm
        def restore(
            numbers: Reals, bodies: Rows[Body], constraints: Rows[Constraint], w: InOut[Work], p: InOut[Integers],
            stop: IntVector[1], t: Real, kept: InOut[Kept], motors: InOut[Vector[motors_size]],
            twists: InOut[Vector[size]],
        ) -> tuple[Int, Int]:  # fmt: skip
            """A state back to the constraints, which must be possible: a status, and the rank."""
            status, rank = bring_back(numbers, bodies, constraints, w[0:own_size], p, stop, t, motors, twists)
            if status == VIOLATED or status == RANK_CHANGED:  # noqa: SIM109
                kept.off[0] = w.off
                kept.off[1] = float(p.off_row)
            return status, rank

    @algorithm
    def end_step(
        numbers: Reals, bodies: Rows[Body], springs: IntRows[2], user_loads: IntRows[3], constraints: Rows[Constraint],
        directions: Reals, w: InOut[Work], p: InOut[Integers], stop: IntVector[1], kept: InOut[Kept],
    ) -> Int:  # fmt: skip
        """What comes after each step: back to the constraints, and a look at the state; a status."""
        if is_constrained and p.project != 0:
            if has_tangents and is_exact:
                far = tangents_far(
                    numbers, bodies, springs, user_loads, constraints, directions, w, p, stop, kept.time, kept.motors,
                    kept.twists, kept.tangents, False,
                )  # fmt: skip
                if far != OK:
                    return int(far)
            status, rank = restore(numbers, bodies, constraints, w, p, stop, kept.time, kept, kept.motors, kept.twists)
            if status != OK:
                return int(status)
            if rank > p.known_rank:
                return RANK_CHANGED
            if w.independent < kept.singular[0]:
                kept.singular[:] = (w.independent, kept.time)
            if has_tangents:
                status = project_tangents(
                    numbers, bodies, springs, user_loads, constraints, directions, w, p, stop, kept.time, kept.motors,
                    kept.twists, kept.tangents,
                )  # fmt: skip
                if status != OK:
                    return int(status)
        return OK if is_finite(kept) else NOT_FINITE

    if not adapts:

        @algorithm
        def take_fixed_steps(
            numbers: Reals, bodies: Rows[Body], springs: IntRows[2], user_loads: IntRows[3],
            constraints: Rows[Constraint], directions: Reals, w: InOut[Work], p: InOut[Integers],
            stop: IntVector[1], scheme: Reals, until: Real,
            kept: InOut[Kept], stages: InOut[Rows[state]], progress: InOut[Progress],
        ) -> Int:  # fmt: skip
            """Equal steps up to a time; a status."""
            t = kept.time
            path = until - t
            enough = path / w.longest_step * ALMOST
            n = 1
            if not enough < 1.0:
                n = int(enough)
                if float(n) < enough:
                    n += 1
            now = min(n, p.left)
            h = path / float(n)
            for i in range(0, now, STEPS_IN_FLIGHT if in_flight else 1):
                if stop[0] != 0:
                    return STOPPED
                part = min(now - i, STEPS_IN_FLIGHT) if in_flight else 1
                if has_tangents and not has_chart:
                    trouble = step_tangents(
                        numbers, bodies, springs, user_loads, constraints, directions, scheme, w, p, stop,
                        t + path * (float(i) / float(n)), h, part, kept,
                    )  # fmt: skip
                    if trouble != OK:
                        return int(trouble)
                if in_flight:
                    flight_steps(bodies[0], h, part, kept.motors, kept.twists)
                else:
                    at = t + path * (float(i) / float(n))
                    if has_chart:
                        status = chart_step(
                            numbers, bodies, springs, user_loads, constraints, directions, w, p, stop, scheme, at, h,
                            kept, stages,
                        )  # fmt: skip
                    elif is_composed:
                        status = composed_step(
                            numbers, bodies, springs, user_loads, w[0:own_size], p, at, h, scheme, len(scheme),
                            kept.motors, kept.twists, kept.momenta,
                        )  # fmt: skip
                    else:
                        status = fixed_step(
                            numbers, bodies, springs, user_loads, constraints, w[0:own_size], p, stop, at, h,
                            kept.motors, kept.twists,
                        )  # fmt: skip
                    if status != OK:
                        return int(status)
                progress.steps += part
                kept.time = t + path * (float(i + part) / float(n)) if i + part < n else until
                ending = end_step(numbers, bodies, springs, user_loads, constraints, directions, w, p, stop, kept)
                if ending != OK:
                    return int(ending)
            p.left -= now
            return PAUSED if now < n else OK

    if adapts:

        @algorithm
        def is_stalled(bodies: Rows[Body], duration: Real, kept: InOut[Kept]) -> Bool:
            """Whether steps have become so small that they come to no end, and the bodies hardly move."""
            now = kept.time
            is_slow = now - kept.watched[1] < NO_PROGRESS * duration
            kept.watched[0] += 1.0
            if is_slow:
                for b in range(count):
                    rotation = 0.0
                    path = 0.0
                    for j in angular:
                        rotation += kept.twists[6 * b + j] * kept.twists[6 * b + j]
                    for j in linear:
                        path += kept.twists[6 * b + j] * kept.twists[6 * b + j]
                    pace = sqrt(rotation) + sqrt(path) / radius_of_gyration(bodies[b])
                    kept.watched[2] = max(kept.watched[2], pace * (now - kept.dense_time))
            if kept.watched[0] < WATCHED:
                return False
            stalled: Bool = is_slow and kept.watched[2] < NO_PROGRESS
            kept.watched[0] = 0.0
            kept.watched[2] = 0.0
            kept.watched[1] = now
            return stalled

    @algorithm
    def advance(
        numbers: Reals, bodies: Rows[Body], springs: IntRows[2], user_loads: IntRows[3], constraints: Rows[Constraint],
        directions: Reals, w: InOut[Work], p: InOut[Integers], stop: IntVector[1], scheme: Reals, times: Reals,
        until: Real, kept: InOut[Kept], stages: InOut[Rows[state]], progress: InOut[Progress],
        motors: Out[Vector[motors_size]], twists: Out[Vector[size]],
    ) -> Int:  # fmt: skip
        """The state at a time, from where the simulation stands; a status."""
        if adapts:
            end_time = times[len(times) - 1]
            duration = end_time - times[0]
            while kept.time < until:
                if stop[0] != 0:
                    return STOPPED
                if p.left == 0:
                    return PAUSED
                if is_adaptive and kept.ends > 0.0:
                    return int(kept.ends)
                p.left -= 1
                if is_adaptive:
                    status = adaptive_step(
                        numbers, bodies, springs, user_loads, constraints, directions, w, p, stop, scheme, end_time,
                        kept, stages,
                    )  # fmt: skip
                else:
                    status = series_step(
                        numbers, bodies, springs, user_loads, constraints, directions, w, p, stop, end_time, kept
                    )
                progress.steps += 1
                if status == OK and (is_adaptive or is_constrained):
                    status = end_step(numbers, bodies, springs, user_loads, constraints, directions, w, p, stop, kept)
                if status == OK:
                    stalled = is_stalled(bodies, duration, kept)
                    if stalled:
                        status = STALLED
                if is_adaptive and status == VIOLATED and kept.time > until:
                    kept.ends = float(status)  # states within may do
                elif status != OK:
                    return int(status)
            if is_adaptive and kept.ends > 0.0 and kept.time == until:
                return int(kept.ends)
            if has_series or kept.time > until:
                if is_adaptive:
                    status = find_state_between(
                        numbers, bodies, springs, user_loads, constraints, directions, w, p, stop, scheme, until, kept,
                        stages, motors, twists,
                    )  # fmt: skip
                else:
                    status = find_state_of_series(
                        numbers, bodies, springs, user_loads, constraints, directions, w, p, stop, until, kept, motors,
                        twists,
                    )  # fmt: skip
                if is_constrained and status == OK and p.project != 0:
                    status, _ = restore(numbers, bodies, constraints, w, p, stop, until, kept, motors, twists)
                    if has_tangents and status == OK:
                        status = project_tangents(
                            numbers, bodies, springs, user_loads, constraints, directions, w, p, stop, until, motors,
                            twists, kept.seen_tangents,
                        )  # fmt: skip
                return int(status)
        elif until > kept.time:
            status = take_fixed_steps(
                numbers, bodies, springs, user_loads, constraints, directions, w, p, stop, scheme, until, kept, stages,
                progress,
            )  # fmt: skip
            if status != OK:
                return int(status)
        if is_composed:
            to_twist(bodies[0], kept.motors, kept.momenta, kept.twists)
        motors[:] = kept.motors
        twists[:] = kept.twists
        if has_tangents and is_composed:
            twist_tangents(bodies, directions, p, kept, kept.seen_tangents)
        elif has_tangents:
            kept.seen_tangents[:] = kept.tangents
        return OK

    return advance
