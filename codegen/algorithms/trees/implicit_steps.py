"""Motion of trees of links: steps of Radau IIA collocation in the coordinates of the joints, for what is stiff.

See algorithms/dynamics/steps/collocated.py. Coordinates of balls begin at zero in each step.
"""

from __future__ import annotations

from ...ir.loops.algorithm import Algorithm as algorithm
from ...ir.loops.language import (
    INFINITY,
    InOut,
    Int,
    IntRows,
    Ints,
    Real,
    Reals,
    Rows,
    Vector,
    empty,
    epsilon,
    sqrt,
)  # fmt: skip
from ..chain_records import Joint
from ..dynamics.records import MOST_STAGES, Code, Spring
from ..dynamics.steps.collocated import (
    IS_LOST,
    IS_SOLVED,
    RENEW,
    SOLVED,
    accept_step,
    begin_iterations,
    change_of_step,
    diagonal,
    estimate_error,
    guess_stages,
    judge_iteration,
    lagrange,
    most_iterations,
    subtract_slopes,
)  # fmt: skip
from ..dynamics.steps.error_scales import ALMOST, FEWEST_ROUNDINGS
from .closing import ClosingAlgorithms
from .motion_records import JointLaw, KeptMotion, LinkWork, Loop, LoopRow, Options, RowWork, Settings, TreeBody
from .records import Link
from .stage_systems import stage_systems
from .steps import SLOWEST, StepAlgorithms

#: Steps of the least length that may follow each other before one whose error is allowed.
MOST_LEAST = 8.0
OK, NOT_FINITE, UNDERFLOW = int(Code.OK), int(Code.NOT_FINITE), int(Code.UNDERFLOW)


def implicit_step_algorithms(closing: ClosingAlgorithms, explicit: StepAlgorithms) -> StepAlgorithms:
    """Steps of trees, called as the explicit ones are.

    Parameters
    ----------
    closing : ClosingAlgorithms
    explicit : StepAlgorithms
    """
    find_rates, close_loops = closing.find_rates, closing.close_loops
    unit_of, rounding_of, land = explicit.unit_of, explicit.rounding_of, explicit.land
    differentiate_stages, factor_stages, solve_stage = stage_systems(find_rates)

    # -- errors ------------------------------------------------------------------------------------------------------

    @algorithm
    def find_rounding(
        joint_laws: Rows[JointLaw], options: Options, state: Reals, work: Rows[LinkWork], rounding: InOut[Reals],
    ) -> None:  # fmt: skip
        """Rounding of accelerations that were found at a state."""
        n = len(joint_laws)
        for j in range(n):
            rounding[j] = 0.0
            rounding[n + j] = rounding_of(joint_laws[j], options, state[j], state[n + j], work[j])

    @algorithm
    def error_of(
        joints: Rows[Joint], settings: Settings, options: Options, pace: Real, start: Reals, end: Reals, at: Int,
        stages: Reals,
    ) -> Real:  # fmt: skip
        """An error, from a place of the stages on, in units of what is allowed."""
        n = len(joints)
        blur = 2 * n * 3 * options.stages
        fastest = 0.0
        for j in range(n):
            fastest = max(fastest, max(abs(start[n + j]), abs(end[n + j])) / unit_of(joints[j], settings.length))
        square = 0.0
        for j in range(n):
            unit = unit_of(joints[j], settings.length)
            error = stages[at + j]
            allowed = max((settings.atol + settings.rtol) * unit, abs(stages[blur + j]))
            square += error * error / (allowed * allowed) if error != 0.0 else 0.0
            # speeds that move a joint no more than by its unit in the whole run count as none
            scale = max(max(abs(start[n + j]), abs(end[n + j])), unit * max(SLOWEST * fastest, pace))
            allowed = max(settings.atol * unit + settings.rtol * scale, abs(stages[blur + n + j]))
            error = stages[at + n + j]
            square += error * error / (allowed * allowed) if error != 0.0 else 0.0
        return sqrt(square / float(2 * n)) if square == square else INFINITY

    # -- steps -------------------------------------------------------------------------------------------------------

    @algorithm
    def solve_stages(
        joints: Rows[Joint], parents: Ints, balls: Ints, joint_laws: Rows[JointLaw], torques: Reals, links: Rows[Link],
        bodies: Rows[TreeBody], carriers: Ints, spring_ends: IntRows[2], springs: Rows[Spring], loops: Rows[Loop],
        rows: Rows[LoopRow], places: IntRows[8], firsts: Ints, gravity: Vector[3], settings: Settings, options: Options,
        scheme: Reals, h: Real, pace: Real, references: Reals, start: Reals,
        work: InOut[Rows[LinkWork]], acting: InOut[Rows[6]], row_work: InOut[Rows[RowWork]], matrix: InOut[Reals],
        x: InOut[Reals], end: InOut[Reals], kept: InOut[KeptMotion], stages: InOut[Reals],
    ) -> Int:  # fmt: skip
        """Solve the equations of a step; the number of iterations, 0 where they do not converge."""
        size = len(start)
        n = options.stages
        begin_iterations(kept.iteration)
        for round in range(most_iterations(n)):
            for i in range(n):
                for j in range(size):
                    x[j] = start[j] + stages[size * (n + i) + j]
                find_rates(
                    joints, parents, balls, joint_laws, torques, links, bodies, carriers, spring_ends, springs, loops,
                    rows, places, firsts, gravity, options, options.poses, references, x, work, acting, row_work,
                    matrix, stages, size * (2 * n + i),
                )  # fmt: skip
            square = 0.0
            for i in range(n):
                subtract_slopes(scheme, n, size, 0, size, h, i, stages)
                solve_stage(size, n, i, size * (2 * n + i), stages)
            for j in range(size * n):
                stages[size * n + j] += stages[2 * size * n + j]
            for j in range(size):
                end[j] = start[j] + stages[size * (2 * n - 1) + j]
            for i in range(n):
                error = error_of(joints, settings, options, pace, start, end, size * (2 * n + i), stages)
                square += error * error
            change = sqrt(square / float(n))
            verdict = judge_iteration(round, change, SOLVED, kept.iteration)
            if verdict == IS_LOST:
                return 0
            if verdict == IS_SOLVED:
                return round + 1
            if verdict == RENEW:
                differentiate_stages(
                    joints, parents, balls, joint_laws, torques, links, bodies, carriers, spring_ends, springs, loops,
                    rows, places, firsts, gravity, settings, options, references, start, work, acting, row_work, matrix,
                    x, end, kept, stages,
                )  # fmt: skip
                factor_stages(size, options, scheme, h, kept, stages)
        return 0

    @algorithm
    def error_of_step(
        joints: Rows[Joint], parents: Ints, balls: Ints, joint_laws: Rows[JointLaw], torques: Reals, links: Rows[Link],
        bodies: Rows[TreeBody], carriers: Ints, spring_ends: IntRows[2], springs: Rows[Spring], loops: Rows[Loop],
        rows: Rows[LoopRow], places: IntRows[8], firsts: Ints, gravity: Vector[3], settings: Settings, options: Options,
        scheme: Reals, h: Real, pace: Real, is_careful: Int, references: Reals, start: Reals,
        work: InOut[Rows[LinkWork]], acting: InOut[Rows[6]], row_work: InOut[Rows[RowWork]], matrix: InOut[Reals],
        x: InOut[Reals], end: Reals, stages: InOut[Reals],
    ) -> Real:  # fmt: skip
        """The error of a step in units of what is allowed, as a formula of lower order has it.

        A careful one takes the rates where the error leads to: its stiff part is then gone (Hairer and Wanner, IV.8).
        """
        size = len(start)
        n = options.stages
        at = size * (3 * n + 2)
        estimate_error(scheme, n, size, diagonal(scheme, n, 0, h), stages, x)
        solve_stage(size, n, 0, at, stages)
        error = error_of(joints, settings, options, pace, start, end, at, stages)
        if error >= 1.0 and error < INFINITY and is_careful != 0:
            moved = at + size
            for j in range(size):
                stages[moved + j] = x[j]
                x[j] = start[j] + stages[at + j]
            find_rates(
                joints, parents, balls, joint_laws, torques, links, bodies, carriers, spring_ends, springs, loops, rows,
                places, firsts, gravity, options, options.poses, references, x, work, acting, row_work, matrix,
                stages, at,
            )  # fmt: skip
            for j in range(size):
                stages[at + j] += stages[moved + j]
            solve_stage(size, n, 0, at, stages)
            error = error_of(joints, settings, options, pace, start, end, at, stages)
        return error

    @algorithm
    def adaptive_step(
        joints: Rows[Joint], parents: Ints, balls: Ints, joint_laws: Rows[JointLaw], torques: Reals, links: Rows[Link],
        bodies: Rows[TreeBody], carriers: Ints, spring_ends: IntRows[2], springs: Rows[Spring], loops: Rows[Loop],
        rows: Rows[LoopRow], places: IntRows[8], firsts: Ints, gravity: Vector[3], settings: Settings, options: Options,
        scheme: Reals, end_time: Real, kept: InOut[KeptMotion], state: InOut[Reals],
        references: InOut[Reals], old_references: InOut[Reals], x: InOut[Reals], end: InOut[Reals],
        fresh: InOut[Reals], stages: InOut[Reals],
        work: InOut[Rows[LinkWork]], acting: InOut[Rows[6]], row_work: InOut[Rows[RowWork]], matrix: InOut[Reals],
    ) -> Int:  # fmt: skip
        """One step that is accepted: the state at its end, and its stages; a status."""
        size = len(state)
        n = options.stages
        blur = size * 3 * n
        it = kept.iteration
        pace = kept.pace
        t = kept.time
        h = kept.next_step
        guesses = kept.has_dense
        rejected = 0
        error = 0.0
        change = 1.0
        caution = 1.0
        find_rates(
            joints, parents, balls, joint_laws, torques, links, bodies, carriers, spring_ends, springs, loops, rows,
            places, firsts, gravity, options, options.poses, references, state, work, acting, row_work, matrix,
            stages, blur + size,
        )  # fmt: skip
        find_rounding(joint_laws, options, state, work, fresh)
        while True:
            if not t + h * ALMOST < end_time:
                h = end_time - t
            least = FEWEST_ROUNDINGS * epsilon() * max(abs(t), kept.least_time)
            is_least = not h > least
            if is_least:  # a jump, as of a damped limit that is met: one such step passes it
                if kept.least_steps >= MOST_LEAST:
                    return UNDERFLOW
                kept.least_steps += 1.0
                h = least
            guess_stages(scheme, n, size, h, kept.dense_step, guesses, stages)
            was_new = it.has_jacobian == 0.0
            if was_new:
                differentiate_stages(
                    joints, parents, balls, joint_laws, torques, links, bodies, carriers, spring_ends, springs, loops,
                    rows, places, firsts, gravity, settings, options, references, state, work, acting, row_work, matrix,
                    x, end, kept, stages,
                )  # fmt: skip
            factor_stages(size, options, scheme, h, kept, stages)
            for j in range(size):
                stages[blur + j] = fresh[j]
            solve_stage(size, n, 0, blur, stages)
            rounds = solve_stages(
                joints, parents, balls, joint_laws, torques, links, bodies, carriers, spring_ends, springs, loops, rows,
                places, firsts, gravity, settings, options, scheme, h, pace, references, state, work, acting, row_work,
                matrix, x, end, kept, stages,
            )  # fmt: skip
            if rounds == 0:
                if was_new:
                    h *= 0.5
                    rejected = 1
                it.has_jacobian = 0.0  # what they have come to is no place to differentiate at
                it.rate = 0.0
                guesses = 0.0  # behind a bend, as of dry friction, the last polynomial leads astray
                continue
            is_careful = 1 if rejected != 0 or kept.has_dense == 0.0 else 0
            error = error_of_step(
                joints, parents, balls, joint_laws, torques, links, bodies, carriers, spring_ends, springs, loops, rows,
                places, firsts, gravity, settings, options, scheme, h, pace, is_careful, references, state, work,
                acting, row_work, matrix, x, end, stages,
            )  # fmt: skip
            if error < INFINITY:
                change, caution = change_of_step(error, n, rounds, options.method_order)
                if error < 1.0 or is_least:
                    break
                h *= change
            else:
                h /= 10.0
            it.has_jacobian = 0.0
            rejected = 1
        if error < 1.0:
            kept.least_steps = 0.0
        kept.next_step = accept_step(h, error, options.method_order, change, caution, rejected, it)
        for j in range(size * n):
            stages[j] = stages[size * n + j]
        for j in range(size):
            stages[size * (3 * n + 4) + j] = state[j]
        for j in range(len(references)):
            old_references[j] = references[j]
        kept.dense_time = t
        kept.dense_step = h
        kept.has_dense = 1.0
        finite = land(balls, end, state, references)
        kept.time = t + h if h < end_time - t else end_time
        if not finite:
            return NOT_FINITE
        if len(rows) > 0:
            status = close_loops(
                joints, parents, balls, joint_laws, torques, links, bodies, carriers, spring_ends, springs, loops, rows,
                places, firsts, gravity, options, state, references, work, acting, row_work, matrix, end,
            )  # fmt: skip
            return int(status)
        return OK

    @algorithm
    def find_state_between(
        joints: Rows[Joint], parents: Ints, balls: Ints, joint_laws: Rows[JointLaw], torques: Reals, links: Rows[Link],
        bodies: Rows[TreeBody], carriers: Ints, spring_ends: IntRows[2], springs: Rows[Spring], loops: Rows[Loop],
        rows: Rows[LoopRow], places: IntRows[8], firsts: Ints, gravity: Vector[3], options: Options, scheme: Reals,
        t: Real, kept: InOut[KeptMotion], old_references: Reals, x: InOut[Reals], end: InOut[Reals],
        stages: InOut[Reals], work: InOut[Rows[LinkWork]], acting: InOut[Rows[6]], row_work: InOut[Rows[RowWork]],
        matrix: InOut[Reals],
    ) -> None:  # fmt: skip
        """The state at a time within the last step, on the polynomial of its stages."""
        size = len(x)
        n = options.stages
        weights = empty(MOST_STAGES)
        lagrange(scheme, n, (t - kept.dense_time) / kept.dense_step, weights)
        for j in range(size):
            x[j] = stages[size * (3 * n + 4) + j]
            for i in range(n):
                x[j] += weights[i] * stages[size * i + j]

    return explicit._replace(adaptive_step=adaptive_step, find_state_between=find_state_between)
