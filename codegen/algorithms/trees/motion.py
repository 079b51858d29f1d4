"""Motion of trees of links over time: from store to store, one simulation of a batch at a time."""

from __future__ import annotations

from typing import NamedTuple

from ...ir.loops.algorithm import Algorithm as algorithm
from ...ir.loops.language import INFINITY, Bool, InOut, Int, IntRows, Ints, Real, Reals, Rows, Vector, sqrt
from ..chain_records import Joint
from ..dynamics.advance import ALMOST, NO_PROGRESS, WATCHED
from ..dynamics.projection import TINY
from ..dynamics.records import Code, Control, Progress, Reached, Spring
from ..dynamics.simulations import LEAST_TIME
from .accelerations import MotionAlgorithms
from .closing import ClosingAlgorithms
from .motion_records import JointLaw, KeptMotion, LinkWork, Loop, LoopRow, Options, RowWork, Settings, TreeBody
from .records import Link
from .steps import StepAlgorithms

OK, STOPPED, PAUSED, STALLED = int(Code.OK), int(Code.STOPPED), int(Code.PAUSED), int(Code.STALLED)
#: Steps of an interval, at most.
MOST_STEPS = 100_000
#: Told as the independent fraction of a row where a mechanism is singular.
SINGULAR = 1e-4


class TreeMotion(NamedTuple):
    """What callers call.

    Attributes
    ----------
    run : algorithm
        States at times, from where a simulation stands.
    steps : algorithm
        Some steps of a scheme with a fixed one; a status.
    intervals : algorithm
        Times of a length, each in as many steps as it takes; a status.
    """

    run: algorithm
    steps: algorithm
    intervals: algorithm


def tree_motion_algorithms(
    motion: MotionAlgorithms, closing: ClosingAlgorithms, stepping: StepAlgorithms
) -> TreeMotion:
    """Motion of trees.

    Parameters
    ----------
    motion : MotionAlgorithms
    closing : ClosingAlgorithms
    stepping : StepAlgorithms
    """
    find_rates, observe, unit_of = closing.find_rates, motion.observe, stepping.unit_of
    adaptive_step, find_state_between, step = stepping.adaptive_step, stepping.find_state_between, stepping.step

    @algorithm
    def first_step(joints: Rows[Joint], settings: Settings, duration: Real, fresh: Reals) -> Real:
        """A first step that is short: a hundredth of what the rates would take to change the state by its own size."""
        n = len(joints)
        least = duration
        for j in range(n):
            unit = unit_of(joints[j], settings.length)
            moved = max(abs(fresh[j]), sqrt(unit * abs(fresh[n + j]))) / unit
            if moved > 0.0:
                least = min(least, 0.01 / moved)
        return least

    @algorithm
    def is_stalled(
        joints: Rows[Joint], settings: Settings, duration: Real, state: Reals, kept: InOut[KeptMotion]
    ) -> Bool:
        """Whether steps have become so small that they come to no end, and the joints hardly move."""
        n = len(joints)
        now = kept.time
        is_slow = now - kept.watched[1] < NO_PROGRESS * duration
        kept.watched[0] += 1.0
        if is_slow:
            for j in range(n):
                unit = unit_of(joints[j], settings.length)
                pace = abs(state[n + j]) / unit
                kept.watched[2] = max(kept.watched[2], pace * (now - kept.dense_time))
        if kept.watched[0] < WATCHED:
            return False
        stalled: Bool = is_slow and kept.watched[2] < NO_PROGRESS
        kept.watched[0] = 0.0
        kept.watched[2] = 0.0
        kept.watched[1] = now
        return stalled

    @algorithm
    def note_singular(row: RowWork, kept: InOut[KeptMotion]) -> None:
        """Keep the time at which rows depend on each other more than at the start, and most."""
        if row.depth > kept.depth:
            kept.depth = row.depth
            kept.singular[0] = SINGULAR if row.soft > kept.soft else 1.0
            kept.singular[1] = kept.time
        if row.soft < kept.soft:  # it began there
            kept.depth = INFINITY
            kept.singular[:] = (SINGULAR, 0.0)

    @algorithm
    def advance_motion(
        joints: Rows[Joint], parents: Ints, balls: Ints, joint_laws: Rows[JointLaw], torques: Reals, links: Rows[Link],
        bodies: Rows[TreeBody], carriers: Ints, spring_ends: IntRows[2], springs: Rows[Spring], loops: Rows[Loop],
        rows: Rows[LoopRow], places: IntRows[8], firsts: Ints, gravity: Vector[3], settings: Settings, options: Options,
        scheme: Reals, control: Control, end_time: Real, duration: Real, until: Real, left: Int,
        kept: InOut[KeptMotion], state: InOut[Reals], references: InOut[Reals], old_references: InOut[Reals],
        x: InOut[Reals], end: InOut[Reals], fresh: InOut[Reals], stages: InOut[Reals], work: InOut[Rows[LinkWork]],
        acting: InOut[Rows[6]], row_work: InOut[Rows[RowWork]], matrix: InOut[Reals], progress: InOut[Progress],
    ) -> tuple[Int, Int]:  # fmt: skip
        """Steps until a time is reached, or the budget is spent: a status, and what is left of it."""
        begin = kept.time
        path = until - begin
        count = 0
        if options.adapts == 0 and path > 0.0:
            enough = path / settings.longest_step * ALMOST
            count = 1
            if not enough < 1.0:
                count = int(enough)
                if float(count) < enough:
                    count += 1
        done = 0
        while kept.time < until:
            if control.stop[0] != 0:
                return STOPPED, left
            if left == 0:
                return PAUSED, left
            left -= 1
            if options.adapts != 0:
                status = adaptive_step(
                    joints, parents, balls, joint_laws, torques, links, bodies, carriers, spring_ends, springs, loops,
                    rows, places, firsts, gravity, settings, options, scheme, end_time, kept, state, references,
                    old_references, x, end, fresh, stages, work, acting, row_work, matrix,
                )  # fmt: skip
                if status == OK:
                    stalled = is_stalled(joints, settings, duration, state, kept)
                    if stalled:
                        status = STALLED
            else:
                status = step(
                    joints, parents, balls, joint_laws, torques, links, bodies, carriers, spring_ends, springs, loops,
                    rows, places, firsts, gravity, options, scheme, path / float(count), state, references, x, end,
                    stages, work, acting, row_work, matrix,
                )  # fmt: skip
                done += 1
                kept.time = begin + path * (float(done) / float(count)) if done < count else until
            progress.steps += 1
            if status != OK:
                return int(status), left
            if len(rows) > 0:
                note_singular(row_work[0], kept)
        return OK, left

    @algorithm
    def run(
        joints: Rows[Joint], parents: Ints, balls: Ints, joint_laws: Rows[JointLaw], torques: Reals, links: Rows[Link],
        bodies: Rows[TreeBody], carriers: Ints, ends: IntRows[2], spring_ends: IntRows[2], springs: Rows[Spring],
        loops: Rows[Loop], rows: Rows[LoopRow], places: IntRows[8], firsts: Ints, gravity: Vector[3],
        settings: Settings, options: Options, scheme: Reals, control: Control, times: Reals, kept: InOut[KeptMotion],
        state: InOut[Reals], references: InOut[Reals], old_references: InOut[Reals], x: InOut[Reals], end: InOut[Reals],
        fresh: InOut[Reals], stages: InOut[Reals], work: InOut[Rows[LinkWork]], acting: InOut[Rows[6]],
        row_work: InOut[Rows[RowWork]], matrix: InOut[Reals], progress: InOut[Progress], reached: InOut[Reached],
        motors: InOut[Rows[8]], twists: InOut[Rows[6]], reactions: InOut[Rows[6]], coordinates: InOut[Reals],
        violations: InOut[Reals],
    ) -> None:  # fmt: skip
        """States at times before the last, from where the simulation stands, within a budget of steps."""
        n = len(joints)
        size = 2 * n
        count = len(bodies)
        end_time = times[len(times) - 1]
        duration = end_time - times[0]
        if progress.has_begun == 0:
            progress.has_begun = 1
            kept.time = times[0]
            kept.watched[1] = times[0]
            kept.least_time = LEAST_TIME * duration
            kept.pace = 1.0 / (duration + TINY)
            find_rates(
                joints, parents, balls, joint_laws, torques, links, bodies, carriers, spring_ends, springs, loops, rows,
                places, firsts, gravity, options, options.poses, references, state, work, acting, row_work, matrix,
                fresh, 0,
            )  # fmt: skip
            kept.next_step = first_step(joints, settings, duration, fresh)
            kept.singular[0] = 1.0
            if len(rows) > 0:
                kept.soft = row_work[0].soft
        left = control.budget
        while progress.stored < control.last and progress.status == OK:
            i = progress.stored
            status, left = advance_motion(
                joints, parents, balls, joint_laws, torques, links, bodies, carriers, spring_ends, springs, loops, rows,
                places, firsts, gravity, settings, options, scheme, control, end_time, duration, times[i], left, kept,
                state, references, old_references, x, end, fresh, stages, work, acting, row_work, matrix, progress,
            )  # fmt: skip
            reached.reached = min(kept.time, times[i])
            reached.singular[:] = kept.singular
            if status == PAUSED:
                return
            progress.status = status
            if status == OK:
                if kept.time > times[i]:
                    find_state_between(
                        joints, parents, balls, joint_laws, torques, links, bodies, carriers, spring_ends, springs,
                        loops, rows, places, firsts, gravity, options, scheme, times[i], kept, old_references, x, end,
                        stages, work, acting, row_work, matrix,
                    )  # fmt: skip
                    find_rates(
                        joints, parents, balls, joint_laws, torques, links, bodies, carriers, spring_ends, springs,
                        loops, rows, places, firsts, gravity, options, 1, old_references, x, work, acting, row_work,
                        matrix, end, 0,
                    )  # fmt: skip
                else:
                    for j in range(size):
                        x[j] = state[j]
                    find_rates(
                        joints, parents, balls, joint_laws, torques, links, bodies, carriers, spring_ends, springs,
                        loops, rows, places, firsts, gravity, options, 1, references, x, work, acting, row_work, matrix,
                        end, 0,
                    )  # fmt: skip
                observe(
                    joints, bodies, carriers, ends, work, acting, motors, twists, reactions, count * i
                )
                for j in range(size):
                    coordinates[size * i + j] = x[j]
                violations[i] = 0.0
                for j in range(len(rows)):
                    violations[i] = max(violations[i], abs(row_work[j].error))
                progress.stored = i + 1

    @algorithm
    def steps(
        joints: Rows[Joint], parents: Ints, balls: Ints, joint_laws: Rows[JointLaw], torques: Reals, links: Rows[Link],
        bodies: Rows[TreeBody], carriers: Ints, spring_ends: IntRows[2], springs: Rows[Spring], loops: Rows[Loop],
        rows: Rows[LoopRow], places: IntRows[8], firsts: Ints, gravity: Vector[3], options: Options, scheme: Reals,
        h: Real, count: Int, state: InOut[Reals], references: InOut[Reals], x: InOut[Reals], end: InOut[Reals],
        stages: InOut[Reals], work: InOut[Rows[LinkWork]], acting: InOut[Rows[6]], row_work: InOut[Rows[RowWork]],
        matrix: InOut[Reals],
    ) -> Int:  # fmt: skip
        """Some steps of a scheme with a fixed one; a status."""
        for _ in range(count):
            status = step(
                joints, parents, balls, joint_laws, torques, links, bodies, carriers, spring_ends, springs, loops, rows,
                places, firsts, gravity, options, scheme, h, state, references, x, end, stages, work, acting, row_work,
                matrix,
            )  # fmt: skip
            if status != OK:
                return int(status)
        return OK

    @algorithm
    def intervals(
        joints: Rows[Joint], parents: Ints, balls: Ints, joint_laws: Rows[JointLaw], torques: Reals, links: Rows[Link],
        bodies: Rows[TreeBody], carriers: Ints, spring_ends: IntRows[2], springs: Rows[Spring], loops: Rows[Loop],
        rows: Rows[LoopRow], places: IntRows[8], firsts: Ints, gravity: Vector[3], settings: Settings, options: Options,
        scheme: Reals, h: Real, count: Int, kept: InOut[KeptMotion], state: InOut[Reals], references: InOut[Reals],
        old_references: InOut[Reals], x: InOut[Reals], end: InOut[Reals], fresh: InOut[Reals], stages: InOut[Reals],
        work: InOut[Rows[LinkWork]], acting: InOut[Rows[6]], row_work: InOut[Rows[RowWork]], matrix: InOut[Reals],
    ) -> Int:  # fmt: skip
        """Times of a length, each from a state without a past, in as many steps as it takes; a status."""
        for _ in range(count):
            kept[:] = 0.0
            kept.next_step = h
            kept.least_time = LEAST_TIME * h
            kept.pace = 1.0 / (h + TINY)
            done = 0
            while kept.time < h:
                status = adaptive_step(
                    joints, parents, balls, joint_laws, torques, links, bodies, carriers, spring_ends, springs, loops,
                    rows, places, firsts, gravity, settings, options, scheme, h, kept, state, references,
                    old_references, x, end, fresh, stages, work, acting, row_work, matrix,
                )  # fmt: skip
                if status != OK:
                    return int(status)
                done += 1
                if done == MOST_STEPS:
                    return STALLED
        return OK

    return TreeMotion(run, steps, intervals)
