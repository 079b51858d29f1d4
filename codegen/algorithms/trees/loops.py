"""Motion of trees of links: loops that joints close, and couplings, by multipliers.

A row is a rate that vanishes: the power of a wrench on the difference of two links' twists, or a combination of two
joints' speeds. The multipliers' matrix J M^-1 J' is what the tree does under unit rows, found by articulated bodies
from link to link, and factored within its envelope, a little softer than it is: rows that depend on others share their
multipliers, and the accelerations stay smooth where a mechanism is singular. Rounds with what is left of each row make
up for the softness elsewhere.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from ...ir.loops.algorithm import Algorithm as algorithm
from ...ir.loops.language import InOut, Int, IntRows, Ints, Real, Reals, Rows, Vector, empty, log, sqrt, zeros
from ..chain_records import Joint
from .motion_records import LinkWork, Loop, LoopRow, RowWork

#: Kinds of rows, and of rotations that a joint forbids: none, of its axis, all.
CLOSES, COUPLES = 0, 1
FREE, AXIS = 0.0, 1.0
#: What is added to a row's own compliance, as a part of it: rows may depend on others, and mechanisms pass singular
#: positions. Rounds that take its effect away where rows do not.
SOFTNESS, ROUNDS = 1e-7, 4
#: Of its own compliance, what is left of a row beside others where it nearly depends on them.
NEARLY = 1e-6
ORIGIN = (0.0, 0.0, 0.0)


class LoopAlgorithms(NamedTuple):
    """Loops.

    Attributes
    ----------
    find_rows : algorithm
        Wrenches, errors, rates of errors and their rates; the matrix of multipliers, factored.
    correct : algorithm
        What the tree does under multipliers that take something from each row.
    """

    find_rows: algorithm
    correct: algorithm


def loop_algorithms(k: Any, identity: tuple[float, ...]) -> LoopAlgorithms:
    """Loops of trees.

    Parameters
    ----------
    k : named tuple of KernelSpec
    identity : tuple of float
        The rotor 1.
    """

    @algorithm
    def clear(first: Int, last: Int, work: InOut[Rows[LinkWork]]) -> None:
        """No forces on a range of links."""
        for j in range(first, last):
            link = work[j]
            link.push[:] = 0.0
            link.given = 0.0

    @algorithm
    def add_push(c: Int, wrench: Vector[6], scale: Real, work: InOut[Rows[LinkWork]]) -> None:
        """A wrench of the world on a link, times a number."""
        link = work[c]
        own = k.screw_in_frame(link.rotor, link.position, wrench)
        for j in range(6):
            link.push[j] -= scale * own[j]

    @algorithm
    def respond(joints: Rows[Joint], parents: Ints, first: Int, last: Int, work: InOut[Rows[LinkWork]]) -> None:
        """Accelerations that forces give to a range of links, which hang together."""
        nothing = zeros(6)
        for j in range(last - 1, first - 1, -1):
            joint = joints[j]
            link = work[j]
            i = parents[j]
            own = k.joint_force(joint.axis, joint.rotation, joint.advance, link.push)
            link.pushed = link.given - own
            if i >= 0:
                parent = work[i]
                parent.push[:] = k.pass_wrench(
                    link.turn, link.displacement, link.push, link.momentum, link.compliance, link.pushed, parent.push
                )
        for j in range(first, last):
            joint = joints[j]
            link = work[j]
            i = parents[j]
            if i >= 0:
                link.answer, link.response[:] = k.joint_acceleration(
                    link.turn, link.displacement, joint.axis, joint.rotation, joint.advance, nothing, link.momentum,
                    link.compliance, link.pushed, work[i].response,
                )  # fmt: skip
            else:
                link.answer, link.response[:] = k.joint_acceleration(
                    link.turn, link.displacement, joint.axis, joint.rotation, joint.advance, nothing, link.momentum,
                    link.compliance, link.pushed, nothing,
                )  # fmt: skip

    @algorithm
    def world_twist(c: Int, work: Rows[LinkWork], which: Int, start: Vector[6], twist: InOut[Vector[6]]) -> None:
        """Twist of a link in the world, its rate, or its response; -1 is the world."""
        if c < 0:
            twist[:] = start
        elif which == 0:
            twist[:] = k.screw_from_frame(work[c].rotor, work[c].position, work[c].omega)
        elif which == 1:
            twist[:] = k.screw_from_frame(work[c].rotor, work[c].position, work[c].rate)
        else:
            twist[:] = k.screw_from_frame(work[c].rotor, work[c].position, work[c].response)

    @algorithm
    def apply_row(i: Int, scale: Real, rows: Rows[LoopRow], places: IntRows[8], row_work: Rows[RowWork],
                  work: InOut[Rows[LinkWork]]) -> None:  # fmt: skip
        """The force of a row on the tree, times a number."""
        a = places[i, 1]
        b = places[i, 2]
        if places[i, 0] == COUPLES:
            work[a].given += scale * rows[i].angular[0]
            if b >= 0:
                work[b].given += scale * rows[i].angular[1]
        else:
            if b >= 0:
                add_push(b, row_work[i].wrench, scale, work)
            if a >= 0:
                add_push(a, row_work[i].wrench, -scale, work)

    @algorithm
    def is_within(c: Int, i: Int, places: IntRows[8]) -> Int:
        """Whether a link is in the ranges of a row."""
        first = c >= places[i, 4] and c < places[i, 5]
        second = c >= places[i, 6] and c < places[i, 7]
        return 1 if first or second else 0

    @algorithm
    def row_of_response(
        i: Int, m: Int, rows: Rows[LoopRow], places: IntRows[8], row_work: Rows[RowWork], work: Rows[LinkWork]
    ) -> Real:
        """What a row says about the response to another, whose ranges alone have one."""
        nothing = zeros(6)
        twist = empty(6)
        other = empty(6)
        a = places[m, 1]
        b = places[m, 2]
        total = 0.0
        in_a = is_within(a, i, places)
        in_b = is_within(b, i, places)
        if places[m, 0] == COUPLES:
            if in_a != 0:
                total += rows[m].angular[0] * work[a].answer
            if b >= 0 and in_b != 0:
                total += rows[m].angular[1] * work[b].answer
        else:
            twist[:] = 0.0
            if b >= 0 and in_b != 0:
                world_twist(b, work, 2, nothing, twist)
            if a >= 0 and in_a != 0:
                world_twist(a, work, 2, nothing, other)
                for j in range(6):
                    twist[j] -= other[j]
            total = k.screw_power(twist, row_work[m].wrench)
        return total

    @algorithm
    def place_rows(
        loops: Rows[Loop], rows: Rows[LoopRow], places: IntRows[8], start: Vector[6], x: Reals, rates: Reals, at: Int,
        work: Rows[LinkWork], row_work: InOut[Rows[RowWork]],
    ) -> None:  # fmt: skip
        """Wrenches of rows; errors, their rates, and the rates of these without multipliers."""
        nothing = zeros(6)
        q = empty(4)
        p = empty(3)
        other_q = empty(4)
        place = empty(3)
        twist = empty(6)
        other_twist = empty(6)
        difference = empty(6)
        n = len(x) // 2
        for i in range(len(rows)):
            row = rows[i]
            own = row_work[i]
            a = places[i, 1]
            b = places[i, 2]
            if places[i, 0] == COUPLES:
                own.error = row.angular[0] * x[a]
                own.rate = row.angular[0] * x[n + a]
                own.right = row.angular[0] * rates[at + n + a]
                if b >= 0:
                    own.error += row.angular[1] * x[b]
                    own.rate += row.angular[1] * x[n + b]
                    own.right += row.angular[1] * rates[at + n + b]
            else:
                loop = loops[places[i, 3]]
                q[:] = identity
                p[:] = ORIGIN
                if a >= 0:
                    q[:] = work[a].rotor
                    p[:] = work[a].position
                other_q[:] = identity
                place[:] = loop.other_point
                if b >= 0:
                    other_q[:] = work[b].rotor
                    place[:] = k.point_in_world(work[b].rotor, work[b].position, loop.other_point)
                own.wrench[:] = k.loop_wrench(q, row.angular, row.linear, place)
                gap, tilt, turn = k.loop_errors(q, p, loop.point, loop.axis, other_q, place)
                own.error = 0.0
                for j in range(3):
                    own.error += row.linear[j] * gap[j]
                    if loop.rotations == AXIS:
                        own.error += row.angular[j] * tilt[j]
                    elif loop.rotations != FREE:
                        own.error += row.angular[j] * turn[j]
                world_twist(a, work, 0, nothing, twist)
                world_twist(b, work, 0, nothing, other_twist)
                for j in range(6):
                    difference[j] = other_twist[j] - twist[j]
                rate = k.screw_power(difference, own.wrench)
                own.rate = rate
                turned = k.loop_wrench_rate(q, row.angular, row.linear, place, twist, other_twist)
                convected = k.screw_power(difference, turned)
                world_twist(a, work, 1, start, twist)
                world_twist(b, work, 1, start, other_twist)
                for j in range(6):
                    difference[j] = other_twist[j] - twist[j]
                pulled = k.screw_power(difference, own.wrench)
                own.right = pulled + convected

    @algorithm
    def find_rows(
        joints: Rows[Joint], parents: Ints, loops: Rows[Loop], rows: Rows[LoopRow], places: IntRows[8], firsts: Ints,
        start: Vector[6], x: Reals, rates: Reals, at: Int, work: InOut[Rows[LinkWork]], row_work: InOut[Rows[RowWork]],
        matrix: InOut[Reals],
    ) -> Real:  # fmt: skip
        """Rows at a state whose rates were found, and the factors of their matrix; by what these magnify rounding."""
        count = len(rows)
        place_rows(loops, rows, places, start, x, rates, at, work, row_work)
        for i in range(count):
            clear(places[i, 4], places[i, 5], work)
            clear(places[i, 6], places[i, 7], work)
            apply_row(i, 1.0, rows, places, row_work, work)
            respond(joints, parents, places[i, 4], places[i, 5], work)
            respond(joints, parents, places[i, 6], places[i, 7], work)
            for m in range(firsts[i], i + 1):
                entry = row_of_response(i, m, rows, places, row_work, work)
                matrix[count * i + m] = entry
        largest = 1.0
        soft = 0.0
        depth = 0.0
        below = count * count
        for i in range(count):
            own = matrix[count * i + i]
            for m in range(firsts[i], i + 1):
                total = matrix[count * i + m]
                if m == i:
                    total += SOFTNESS * own
                for j in range(max(firsts[i], firsts[m]), m):
                    total -= matrix[below + count * i + j] * matrix[below + count * m + j]
                if m < i:
                    matrix[below + count * i + m] = total / matrix[below + count * m + m]
                else:
                    total = max(total, 0.5 * SOFTNESS * own)
                    matrix[below + count * i + i] = sqrt(total)
                    largest = max(largest, own / total)
                    soft += 1.0 if total < NEARLY * own else 0.0
                    depth += log(own / total)
        row_work[0].soft = soft
        row_work[0].depth = depth
        return sqrt(largest)

    @algorithm
    def correct(
        joints: Rows[Joint], parents: Ints, rows: Rows[LoopRow], places: IntRows[8], firsts: Ints,
        work: InOut[Rows[LinkWork]], row_work: InOut[Rows[RowWork]], matrix: Reals,
    ) -> None:  # fmt: skip
        """What the joints do so that each row changes as is wanted, and the multipliers that this takes."""
        count = len(rows)
        below = count * count
        for i in range(count):
            row_work[i].multiplier = 0.0
        for _ in range(ROUNDS):
            for i in range(count):
                row_work[i].change = row_work[i].wanted
            for i in range(count):
                for m in range(firsts[i], i + 1):
                    entry = matrix[count * i + m]
                    row_work[i].change -= entry * row_work[m].multiplier
                    if m < i:
                        row_work[m].change -= entry * row_work[i].multiplier
            for i in range(count):
                total = row_work[i].change
                for m in range(firsts[i], i):
                    total -= matrix[below + count * i + m] * row_work[m].change
                row_work[i].change = total / matrix[below + count * i + i]
            for i in range(count - 1, -1, -1):
                own = row_work[i]
                own.change /= matrix[below + count * i + i]
                for m in range(firsts[i], i):
                    row_work[m].change -= matrix[below + count * i + m] * own.change
            for i in range(count):
                row_work[i].multiplier += row_work[i].change
        clear(0, len(joints), work)
        for i in range(count):
            apply_row(i, row_work[i].multiplier, rows, places, row_work, work)
        respond(joints, parents, 0, len(joints), work)

    return LoopAlgorithms(find_rows, correct)
