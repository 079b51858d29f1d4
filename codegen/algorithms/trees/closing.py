"""Motion of trees of links with loops: rates that keep them closed, and the nearest closed state behind a step."""

from __future__ import annotations

from typing import Any, NamedTuple

from ...ir.loops.algorithm import Algorithm as algorithm
from ...ir.loops.language import INFINITY, InOut, Int, IntRows, Ints, Reals, Rows, Vector, empty, epsilon
from ..chain_records import Joint
from ..dynamics.records import Code, Spring
from .accelerations import MotionAlgorithms
from .loops import LoopAlgorithms
from .motion_records import PLAIN, JointLaw, LinkWork, Loop, LoopRow, Options, RowWork, TreeBody
from .records import Link

OK, VIOLATED = int(Code.OK), int(Code.VIOLATED)
#: Roundings that come together in what loops add to an acceleration, beside what their matrix magnifies: multipliers
#: are sums, and so is what they do.
SUMMED = 64.0
#: Errors of loops, in radians or lengths that count as one: rounding; what is no longer closed. Corrections of a step.
CLOSED, OPEN, ROUNDS = 1e-13, 1e-6, 8


class ClosingAlgorithms(NamedTuple):
    """Trees with loops.

    Attributes
    ----------
    find_rates : algorithm
        Rates of coordinates and speeds.
    close_loops : algorithm
        The nearest state whose loops are closed; a status.
    """

    find_rates: algorithm
    close_loops: algorithm


def closing_algorithms(k: Any, motion: MotionAlgorithms, loop: LoopAlgorithms) -> ClosingAlgorithms:
    """Trees with loops.

    Parameters
    ----------
    k : named tuple of KernelSpec
    motion : MotionAlgorithms
    loop : LoopAlgorithms
    """
    find_tree_rates, ball_reference = motion.find_rates, k.ball_reference
    find_rows, correct = loop.find_rows, loop.correct

    @algorithm
    def find_rates(
        joints: Rows[Joint], parents: Ints, balls: Ints, joint_laws: Rows[JointLaw], torques: Reals, links: Rows[Link],
        bodies: Rows[TreeBody], carriers: Ints, spring_ends: IntRows[2], springs: Rows[Spring], loops: Rows[Loop],
        rows: Rows[LoopRow], places: IntRows[8], firsts: Ints, gravity: Vector[3], options: Options, with_poses: Int,
        references: Reals, x: Reals, work: InOut[Rows[LinkWork]], acting: InOut[Rows[6]],
        row_work: InOut[Rows[RowWork]], matrix: InOut[Reals], rates: InOut[Reals], at: Int,
    ) -> None:  # fmt: skip
        """Rates of a state, into a row of numbers from a place on; loops take what would open them."""
        n = len(joints)
        find_tree_rates(
            joints, parents, balls, joint_laws, torques, links, bodies, carriers, spring_ends, springs, gravity,
            options, with_poses, references, x, work, acting, rates, at,
        )  # fmt: skip
        if len(rows) > 0:
            start = k.rest_rate(gravity)
            magnified = find_rows(
                joints, parents, loops, rows, places, firsts, start, x, rates, at, work, row_work, matrix
            )
            for i in range(len(rows)):
                row_work[i].wanted = -row_work[i].right
            correct(joints, parents, rows, places, firsts, work, row_work, matrix)
            most = 0.0
            for j in range(n):
                most = max(most, abs(work[j].answer))
            for j in range(n):
                link = work[j]
                link.blur += epsilon() * (SUMMED + magnified) * most
                rates[at + n + j] += link.answer
                for i in range(6):
                    link.rate[i] += link.response[i]

    @algorithm
    def close_loops(
        joints: Rows[Joint], parents: Ints, balls: Ints, joint_laws: Rows[JointLaw], torques: Reals, links: Rows[Link],
        bodies: Rows[TreeBody], carriers: Ints, spring_ends: IntRows[2], springs: Rows[Spring], loops: Rows[Loop],
        rows: Rows[LoopRow], places: IntRows[8], firsts: Ints, gravity: Vector[3], options: Options,
        state: InOut[Reals], references: InOut[Reals], work: InOut[Rows[LinkWork]], acting: InOut[Rows[6]],
        row_work: InOut[Rows[RowWork]], matrix: InOut[Reals], rates: InOut[Reals],
    ) -> Int:  # fmt: skip
        """The nearest state whose loops are closed, by kinetic energy, behind a step; a status."""
        n = len(joints)
        phi = empty(3)
        rounds = 0
        last = INFINITY
        while True:
            find_rates(
                joints, parents, balls, joint_laws, torques, links, bodies, carriers, spring_ends, springs, loops, rows,
                places, firsts, gravity, options, options.poses, references, state, work, acting, row_work, matrix,
                rates, 0,
            )  # fmt: skip
            off = 0.0
            for i in range(len(rows)):
                off = max(off, abs(row_work[i].error))
                row_work[i].wanted = -row_work[i].error
            if off <= CLOSED or rounds == ROUNDS or not off < 0.5 * last:
                break
            correct(joints, parents, rows, places, firsts, work, row_work, matrix)
            for j in range(n):
                b = balls[j]
                if b == PLAIN:
                    state[j] += work[j].answer
                elif b >= 0:
                    for i in range(3):
                        phi[i] = work[j + i].answer
                    turned = ball_reference(references[4 * b : 4 * b + 4], phi)
                    for i in range(4):
                        references[4 * b + i] = turned[i]
            last = off
            rounds += 1
        if not off < OPEN:
            return VIOLATED
        for i in range(len(rows)):
            row_work[i].wanted = -row_work[i].rate
        correct(joints, parents, rows, places, firsts, work, row_work, matrix)
        for j in range(n):
            state[n + j] += work[j].answer
        return OK

    return ClosingAlgorithms(find_rates, close_loops)
