"""Motion of trees of links: steps of Runge-Kutta schemes, and states between their ends.

Steps go in the coordinates of the joints; those of balls begin at zero in each step. The step control is that of
algorithms/dynamics/steps/adaptive_steps.py.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from ...ir.loops.algorithm import Algorithm as algorithm
from ...ir.loops.algorithm import inlined
from ...ir.loops.language import (
    INFINITY,
    Bool,
    InOut,
    Int,
    IntRows,
    Ints,
    Real,
    Reals,
    Rows,
    Vector,
    epsilon,
    exp,
    log,
    sqrt,
)  # fmt: skip
from ..chain_records import Joint
from ..dynamics.records import Code, Spring
from ..dynamics.steps.adaptive_steps import CUBIC
from ..dynamics.steps.error_scales import ALMOST, BLURS, FEWEST_ROUNDINGS, LEAST_CHANGE, MOST_CHANGE, SAFETY
from .closing import ClosingAlgorithms
from .motion_records import JointLaw, KeptMotion, LinkWork, Loop, LoopRow, Options, RowWork, Settings, TreeBody
from .records import Link

OK, NOT_FINITE, UNDERFLOW = int(Code.OK), int(Code.NOT_FINITE), int(Code.UNDERFLOW)
#: Of the fastest joint's speed, what that of another counts for at least where its error is measured.
SLOWEST = 1e-3


class StepAlgorithms(NamedTuple):
    """Steps.

    Attributes
    ----------
    unit_of : algorithm
        What counts as one of a joint's coordinate.
    rounding_of : algorithm
        Rounding of a joint's acceleration.
    adaptive_step : algorithm
        One that is accepted; a status.
    find_state_between : algorithm
        The state at a time within it.
    step : algorithm
        One of a scheme with a fixed step; a status.
    land : algorithm
        The state at the end of a step becomes the simulation's.
    """

    unit_of: algorithm
    rounding_of: algorithm
    adaptive_step: algorithm
    find_state_between: algorithm
    step: algorithm
    land: algorithm


def step_algorithms(k: Any, closing: ClosingAlgorithms) -> StepAlgorithms:
    """Steps of trees.

    Parameters
    ----------
    k : named tuple of KernelSpec
    closing : ClosingAlgorithms
    """
    find_rates, close_loops, ball_reference = closing.find_rates, closing.close_loops, k.ball_reference

    @algorithm
    def add_stages(
        joints: Rows[Joint], parents: Ints, balls: Ints, joint_laws: Rows[JointLaw], torques: Reals, links: Rows[Link],
        bodies: Rows[TreeBody], carriers: Ints, spring_ends: IntRows[2], springs: Rows[Spring], loops: Rows[Loop],
        rows: Rows[LoopRow], places: IntRows[8], firsts: Ints, gravity: Vector[3], options: Options, scheme: Reals,
        h: Real, first: Int, last: Int, references: Reals, start: Reals, work: InOut[Rows[LinkWork]],
        acting: InOut[Rows[6]], row_work: InOut[Rows[RowWork]], matrix: InOut[Reals], x: InOut[Reals],
        stages: InOut[Reals],
    ) -> None:  # fmt: skip
        """Rates of the stages of a step, from one on."""
        size = 2 * len(joints)
        for i in range(first, last):
            for j in range(size):
                x[j] = start[j]
            for m in range(i):
                weight = h * scheme[options.all_stages * i + m]
                if weight != 0.0:
                    for j in range(size):
                        x[j] += weight * stages[size * m + j]
            find_rates(
                joints, parents, balls, joint_laws, torques, links, bodies, carriers, spring_ends, springs, loops, rows,
                places, firsts, gravity, options, options.poses, references, x, work, acting, row_work, matrix, stages,
                size * i,
            )  # fmt: skip

    @algorithm
    def end_of_step(options: Options, scheme: Reals, h: Real, start: Reals, stages: Reals, end: InOut[Reals]) -> None:
        """The state that stages give."""
        size = len(start)
        weights = options.all_stages * options.all_stages + options.all_stages
        for j in range(size):
            total = 0.0
            for i in range(options.stages):
                total += scheme[weights + i] * stages[size * i + j]
            end[j] = start[j] + h * total

    @algorithm
    def land(balls: Ints, end: Reals, state: InOut[Reals], references: InOut[Reals]) -> Bool:
        """The state at the end of a step becomes the simulation's; whether it is finite."""
        n = len(balls)
        total = 0.0
        for j in range(2 * n):
            state[j] = end[j]
            total += end[j] - end[j]
        for j in range(n):
            b = balls[j]
            if b >= 0:
                turned = ball_reference(references[4 * b : 4 * b + 4], end[j : j + 3])
                for i in range(4):
                    references[4 * b + i] = turned[i]
                for i in range(3):
                    state[j + i] = 0.0
        finite: Bool = total == 0.0
        return finite

    @inlined
    def unit_of(joint: Joint, length: Real) -> Real:
        """What counts as one of a joint's coordinate: a radian, or a length."""
        return length if joint.rotation == 0.0 else 1.0

    @inlined
    def rounding_of(law: JointLaw, options: Options, x: Real, v: Real, link: LinkWork) -> Real:
        """Rounding of a joint's acceleration that was found at a state, also of what is subtracted in its laws."""
        lost = 0.0
        if options.joint_laws != 0:
            lost = law.stiffness * (abs(x) + abs(law.rest)) + law.damping * abs(v)
            if x > law.upper:
                lost += law.stop_stiffness * (abs(x) + abs(law.upper)) + law.stop_damping * abs(v)
            if x < law.lower:
                lost += law.stop_stiffness * (abs(x) + abs(law.lower)) + law.stop_damping * abs(v)
        rounding: Real = BLURS * (link.blur + epsilon() * lost * link.compliance)
        return rounding

    @algorithm
    def error_of_step(
        joints: Rows[Joint], joint_laws: Rows[JointLaw], settings: Settings, options: Options, scheme: Reals, h: Real,
        start: Reals, end: Reals, stages: Reals, work: Rows[LinkWork],
    ) -> Real:  # fmt: skip
        """The error of a step in units of what is allowed."""
        n = len(joints)
        size = 2 * n
        first = options.all_stages * options.all_stages + options.all_stages + options.stages
        second = first + options.stages + 1
        fastest = 0.0
        for j in range(n):
            own = max(abs(start[n + j]), max(abs(end[n + j]), h * abs(stages[n + j])))
            unit = unit_of(joints[j], settings.length)
            fastest = max(fastest, own / unit)
        first_square = 0.0
        second_square = 0.0
        for j in range(size):
            error = 0.0
            other = 0.0
            for i in range(options.stages + 1):
                error += scheme[first + i] * stages[size * i + j]
                other += scheme[second + i] * stages[size * i + j]
            if j < n:
                unit = unit_of(joints[j], settings.length)
                allowed = settings.atol * unit + settings.rtol * max(unit, h * abs(start[n + j]))
            else:
                at = j - n
                unit = unit_of(joints[at], settings.length)
                own = max(abs(start[j]), max(abs(end[j]), h * abs(stages[j])))
                allowed = settings.atol * unit + settings.rtol * max(own, SLOWEST * unit * fastest)
                allowed = max(allowed, h * rounding_of(joint_laws[at], options, end[at], end[j], work[at]))
            # not a quotient of squares: those of the least speeds are zero
            error = error / allowed if error != 0.0 else 0.0
            other = other / allowed if other != 0.0 else 0.0
            first_square += error * error
            second_square += other * other
        both = first_square + 0.01 * second_square
        result = 0.0
        if both > 0.0:
            result = h * first_square / sqrt(both * float(size))
        elif both != 0.0:
            result = INFINITY
        return result

    @algorithm
    def adaptive_step(
        joints: Rows[Joint], parents: Ints, balls: Ints, joint_laws: Rows[JointLaw], torques: Reals, links: Rows[Link],
        bodies: Rows[TreeBody], carriers: Ints, spring_ends: IntRows[2], springs: Rows[Spring], loops: Rows[Loop],
        rows: Rows[LoopRow], places: IntRows[8], firsts: Ints, gravity: Vector[3], settings: Settings, options: Options,
        scheme: Reals, end_time: Real, kept: InOut[KeptMotion], state: InOut[Reals], references: InOut[Reals],
        old_references: InOut[Reals], x: InOut[Reals], end: InOut[Reals], fresh: InOut[Reals], stages: InOut[Reals],
        work: InOut[Rows[LinkWork]], acting: InOut[Rows[6]], row_work: InOut[Rows[RowWork]], matrix: InOut[Reals],
    ) -> Int:  # fmt: skip
        """One step that is accepted, and what an interpolant needs; a status."""
        n = len(joints)
        size = 2 * n
        stage_count = options.stages
        change = size * options.all_stages
        for j in range(size):
            stages[j] = fresh[j]
            stages[change + size + j] = state[j]
        t = kept.time
        h = kept.next_step
        is_rejected = False
        while True:
            if not t + h * ALMOST < end_time:
                h = end_time - t
            if not h > FEWEST_ROUNDINGS * epsilon() * max(abs(t), kept.least_time):
                return UNDERFLOW
            add_stages(
                joints, parents, balls, joint_laws, torques, links, bodies, carriers, spring_ends, springs, loops, rows,
                places, firsts, gravity, options, scheme, h, 1, stage_count, references, state, work, acting, row_work,
                matrix, x, stages,
            )  # fmt: skip
            end_of_step(options, scheme, h, state, stages, end)
            find_rates(
                joints, parents, balls, joint_laws, torques, links, bodies, carriers, spring_ends, springs, loops, rows,
                places, firsts, gravity, options, options.poses, references, end, work, acting, row_work, matrix,
                stages, size * stage_count,
            )  # fmt: skip
            error = error_of_step(joints, joint_laws, settings, options, scheme, h, state, end, stages, work)
            if not error < INFINITY:  # nor what is not a number
                h /= 10.0
                is_rejected = True
                continue
            factor = SAFETY * exp(-log(error) / float(options.method_order)) if error > 0.0 else MOST_CHANGE
            if error < 1.0:
                kept.next_step = h * min(max(factor, LEAST_CHANGE), 1.0 if is_rejected else MOST_CHANGE)
                break
            h *= max(factor, LEAST_CHANGE)
            is_rejected = True
        kept.dense_time = t
        kept.dense_step = h
        kept.has_dense = 0.0
        for j in range(len(references)):
            old_references[j] = references[j]
        for j in range(n):
            # behind the step coordinates of balls are zero, and their rates are the speeds
            fresh[j] = end[n + j]
            fresh[n + j] = stages[size * stage_count + n + j]
        for j in range(size):
            stages[change + j] = end[j] - state[j]
        finite = land(balls, end, state, references)
        kept.time = t + h if h < end_time - t else end_time
        if not finite:
            return NOT_FINITE
        if len(rows) > 0:
            status = close_loops(
                joints, parents, balls, joint_laws, torques, links, bodies, carriers, spring_ends, springs, loops, rows,
                places, firsts, gravity, options, state, references, work, acting, row_work, matrix, end,
            )  # fmt: skip
            if status != OK:
                return int(status)
            find_rates(
                joints, parents, balls, joint_laws, torques, links, bodies, carriers, spring_ends, springs, loops, rows,
                places, firsts, gravity, options, options.poses, references, state, work, acting, row_work, matrix,
                fresh, 0,
            )  # fmt: skip
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
        """The state at a time within the last step, its coordinates from where that step began."""
        size = 2 * len(joints)
        h = kept.dense_step
        count = options.all_stages
        change = size * count
        start = change + size
        if kept.has_dense == 0.0:
            for j in range(size):
                end[j] = stages[start + j]
            add_stages(
                joints, parents, balls, joint_laws, torques, links, bodies, carriers, spring_ends, springs, loops, rows,
                places, firsts, gravity, options, scheme, h, options.stages + 1, count, old_references, end, work,
                acting, row_work, matrix, x, stages,
            )  # fmt: skip
            dense = count * count + count + 3 * options.stages + 2
            for j in range(size):
                delta = stages[change + j]
                first = h * stages[j]
                last = h * stages[size * options.stages + j]
                stages[start + size + j] = first - delta
                stages[start + 2 * size + j] = 2.0 * delta - (last + first)
                for r in range(options.dense_rows):
                    total = 0.0
                    for i in range(count):
                        total += scheme[dense + count * r + i] * stages[size * i + j]
                    stages[size * (count + CUBIC + r) + j] = h * total
            kept.has_dense = 1.0
        part = (t - kept.dense_time) / h
        for j in range(size):
            total = 0.0
            for i in range(2 + options.dense_rows, 0, -1):
                total = (total + stages[start + size * i + j]) * (1.0 - part if i % 2 == 1 else part)
            x[j] = stages[start + j] + (total + stages[change + j]) * part

    @algorithm
    def step(
        joints: Rows[Joint], parents: Ints, balls: Ints, joint_laws: Rows[JointLaw], torques: Reals, links: Rows[Link],
        bodies: Rows[TreeBody], carriers: Ints, spring_ends: IntRows[2], springs: Rows[Spring], loops: Rows[Loop],
        rows: Rows[LoopRow], places: IntRows[8], firsts: Ints, gravity: Vector[3], options: Options, scheme: Reals,
        h: Real, state: InOut[Reals], references: InOut[Reals], x: InOut[Reals], end: InOut[Reals],
        stages: InOut[Reals], work: InOut[Rows[LinkWork]], acting: InOut[Rows[6]], row_work: InOut[Rows[RowWork]],
        matrix: InOut[Reals],
    ) -> Int:  # fmt: skip
        """One step of a scheme with a fixed one; a status."""
        add_stages(
            joints, parents, balls, joint_laws, torques, links, bodies, carriers, spring_ends, springs, loops, rows,
            places, firsts, gravity, options, scheme, h, 0, options.stages, references, state, work, acting, row_work,
            matrix, x, stages,
        )  # fmt: skip
        end_of_step(options, scheme, h, state, stages, end)
        finite = land(balls, end, state, references)
        if not finite:
            return NOT_FINITE
        if len(rows) > 0:
            status = close_loops(
                joints, parents, balls, joint_laws, torques, links, bodies, carriers, spring_ends, springs, loops, rows,
                places, firsts, gravity, options, state, references, work, acting, row_work, matrix, end,
            )  # fmt: skip
            return int(status)
        return OK

    return StepAlgorithms(unit_of, rounding_of, adaptive_step, find_state_between, step, land)
