"""Simulations from store to store, one of a batch at a time: what callers call.

Annotations are evaluated: sizes are those of the kind of simulation.
"""

from typing import Any, NamedTuple

from ...ir.loops.algorithm import Algorithm as algorithm
from ...ir.loops.algorithm import inlined
from ...ir.loops.language import Bool, InOut, Int, IntRows, IntVector, Out, Real, Reals, Rows, Vector, empty
from .acceleration import RateAlgorithms
from .advance import MethodAlgorithms
from .projection import TINY, ProjectionAlgorithms
from .records import (
    FINE,
    Body,
    Code,
    Constraint,
    Control,
    Parts,
    Progress,
    Reached,
    kept_record,
    state_record,
    work_records,
)  # fmt: skip

OK, STOPPED, PAUSED = int(Code.OK), int(Code.STOPPED), int(Code.PAUSED)
#: Of the duration: times below are none, where their rounding is measured.
LEAST_TIME = 1e-3


class SimulationAlgorithms(NamedTuple):
    """The algorithms of one kind of simulation that callers call.

    Attributes
    ----------
    run : algorithm
        States at times, from where a simulation stands; at first its start is looked at.
    evaluate : algorithm
        Accelerations, reactions and rows of the constraints at one state; their rank, or -1.
    project : algorithm or None
        The nearest state that obeys the constraints; a status.
    """

    run: algorithm
    evaluate: algorithm
    project: algorithm | None


def simulation_algorithms(
    parts: Parts, rates: RateAlgorithms, projections: ProjectionAlgorithms, method: MethodAlgorithms, advance: algorithm
) -> SimulationAlgorithms:
    """Simulations of a kind.

    Parameters
    ----------
    parts : Parts
    rates : RateAlgorithms
    projections : ProjectionAlgorithms
    method : MethodAlgorithms
    advance : algorithm
        See `advance_algorithm`.
    """
    size, motors_size, state = parts.size, 8 * parts.bodies, parts.state
    is_constrained, has_rows, has_tangents = parts.mode == "constrained", bool(parts.layouts), parts.tangents > 0
    row_count = parts.rows
    tangents_size = max(1, 2 * size * parts.tangents)
    work = work_records(parts)
    Kept: Any = kept_record(parts)
    Work: Any = work.whole
    own_size = work.numbers.size
    Integers: Any = work.integers
    State: Any = state_record(parts.bodies)
    accelerate, find_reactions = rates.accelerate, rates.find_reactions
    constrain: Any = None if rates.rows is None else rates.rows.constrain
    observe = projections.observe
    check_start: Any = projections.check_start
    project_state: Any = projections.project
    to_momenta, first_step, start_series = method.to_momenta, method.first_step, method.start_series
    project_tangents, tangents_far = method.project_tangents, method.tangents_far
    momenta_tangents = method.momenta_tangents
    is_composed, is_adaptive, has_series = (each is not None for each in (to_momenta, first_step, start_series))
    find_nearest: Any = None

    @inlined
    def begin(w: InOut[Work], p: InOut[Integers], item: Int, pace: Real, rank: Int, tolerance: Real) -> None:
        """What is of one simulation in the work."""
        w.pace = pace
        w.off = 0.0
        p.known_rank = rank
        w.tolerance = max(tolerance, FINE)
        p.blurred = 0
        p.off_row = 0
        p.item = item

    @algorithm
    def prepare(
        numbers: Reals, bodies: Rows[Body], springs: IntRows[2], user_loads: IntRows[3], constraints: Rows[Constraint],
        directions: Reals, w: InOut[Work], p: InOut[Integers], stop: IntVector[1], times: Reals, projects: Bool,
        kept: InOut[Kept], stages: InOut[Rows[state]], progress: InOut[Progress], reached: InOut[Reached],
    ) -> None:  # fmt: skip
        """Look at a start, and prepare the first step."""
        duration = times[len(times) - 1] - times[0]
        kept.time = times[0]
        if has_tangents and is_constrained and projects:
            far = tangents_far(
                numbers, bodies, springs, user_loads, constraints, directions, w, p, stop, times[0], kept.motors,
                kept.twists, kept.tangents, True,
            )  # fmt: skip
            progress.status = int(far)
            if far != OK:
                return
        if has_rows:
            status = check_start(
                numbers, bodies, constraints, w[0:own_size], p, stop, times[0], projects, kept.motors, kept.twists,
                reached.start, progress.start_rows,
            )  # fmt: skip
            progress.status = int(status)
            if status != OK:
                return
            kept.rank_at_start = float(p.known_rank)
            kept.tolerance = w.tolerance
            kept.singular[:] = (1.0, times[0])
        if has_tangents and is_constrained and (p.project != 0 or projects):
            trouble = project_tangents(
                numbers, bodies, springs, user_loads, constraints, directions, w, p, stop, times[0], kept.motors,
                kept.twists, kept.tangents,
            )  # fmt: skip
            progress.status = int(trouble)
            if trouble != OK:
                return
        kept.watched[1] = times[0]
        kept.least_time = LEAST_TIME * duration
        if is_composed:
            if has_tangents:
                momenta_tangents(bodies, directions, p, kept)
            to_momenta(bodies[0], kept.motors, kept.twists, kept.momenta)
        if has_series:
            beginning = start_series(
                numbers, bodies, springs, user_loads, constraints, directions, w, p, stop, duration, kept
            )
            progress.status = int(beginning)
        if is_adaptive:
            kept.next_step = first_step(
                numbers, bodies, springs, user_loads, constraints, directions, w, p, stop, duration, kept, stages
            )

    @algorithm
    def run(
        numbers: Reals, bodies: Rows[Body], springs: IntRows[2], user_loads: IntRows[3], constraints: Rows[Constraint],
        directions: Reals, scheme: Reals, w: InOut[Work], p: InOut[Integers], control: Control, times: Reals,
        kept: InOut[Kept], stages: InOut[Rows[state]], progress: InOut[Progress], reached: InOut[Reached],
        states: InOut[Rows[State]], tangents: InOut[Rows[tangents_size]],
    ) -> None:  # fmt: skip
        """States at times before the last, from where the simulation stands, within a budget of steps."""
        stop = control.stop
        pace = 1.0 / (times[len(times) - 1] - times[0] + TINY)
        begin(w, p, progress.number, pace, int(kept.rank_at_start), kept.tolerance)
        if progress.has_begun == 0:
            progress.has_begun = 1
            prepare(
                numbers, bodies, springs, user_loads, constraints, directions, w, p, stop, times, control.projects != 0,
                kept, stages, progress, reached,
            )  # fmt: skip
        p.left = control.budget
        while progress.stored < control.last and progress.status == OK:
            i = progress.stored
            row = states[i]
            status = STOPPED
            if stop[0] == 0:
                status = advance(
                    numbers, bodies, springs, user_loads, constraints, directions, w, p, stop, scheme, times, times[i],
                    kept, stages, progress, row.motors, row.twists,
                )  # fmt: skip
            if status == OK:
                if has_tangents:
                    tangents[i][:] = kept.seen_tangents
                status, row.violations = observe(
                    numbers, bodies, springs, user_loads, constraints, w[0:own_size], p, stop, times[i], row.motors,
                    row.twists, row.reactions,
                )  # fmt: skip
            reached.reached = min(kept.time, times[i])
            if status == PAUSED:
                return
            progress.status = status
            reached.off[:] = kept.off
            reached.singular[:] = kept.singular
            if status == OK:
                progress.stored = i + 1

    @algorithm
    def evaluate(
        numbers: Reals, bodies: Rows[Body], springs: IntRows[2], user_loads: IntRows[3], constraints: Rows[Constraint],
        w: InOut[Work], p: InOut[Integers], stop: IntVector[1], t: Real, motors: Vector[motors_size],
        twists: Vector[size], accelerations: Out[Vector[size]], reactions: Out[Vector[size]],
        matrix: InOut[Rows[size]], right: InOut[Reals], errors: InOut[Reals], rates: InOut[Reals],
    ) -> Int:  # fmt: skip
        """Accelerations, reactions, and the constraints' rows, right sides, errors and their rates; the rank, or -1."""
        rows = empty(size)
        begin(w, p, 0, 0.0, 0, FINE)
        status = accelerate(
            numbers, bodies, springs, user_loads, constraints, w[0:own_size], p, stop, t, motors, twists, rows,
            accelerations,
        )  # fmt: skip
        if status != OK:
            return -1
        find_reactions(bodies, w[0:own_size], p, rows, accelerations, reactions)
        if has_rows:
            status = constrain(numbers, bodies, constraints, w[0:own_size], p, stop, t, motors, twists, w.tolerance)
            if status != OK:
                return -1
            for i in range(row_count):
                for j in range(size):
                    matrix[i, j] = w.matrix[i, j]
                right[i] = w.right[i]
                errors[i] = w.errors[i]
                rates[i] = w.rates[i]
            return int(p.rank)
        return 0

    if is_constrained:

        @algorithm
        def find_nearest(
            numbers: Reals, bodies: Rows[Body], constraints: Rows[Constraint], w: InOut[Work], p: InOut[Integers],
            stop: IntVector[1], t: Real, tolerance: Real, motors: InOut[Vector[motors_size]],
            twists: InOut[Vector[size]],
        ) -> Int:  # fmt: skip
            """The nearest state that obeys the constraints; a status."""
            begin(w, p, 0, 0.0, 0, FINE)
            status, _ = project_state(
                numbers, bodies, constraints, w[0:own_size], p, stop, t, tolerance, motors, twists
            )
            return int(status)

    return SimulationAlgorithms(run, evaluate, find_nearest)
