"""Poses of mechanisms by Newton's method, in steps that stay near where the loops are closed.

Driven coordinates and targets are approached a little at a time, and errors are taken back along the way.
"""

# Annotations are evaluated here: sizes of records are those of the call of `pose_algorithm`.
from math import pi
from typing import Any

from ...algorithms.weighted_rows import WeightedRows
from ...ir.loops.algorithm import Algorithm as algorithm
from ...ir.loops.language import InOut, Int, Ints, Out, Real, Reals, Rows, Vector, empty, sqrt
from .records import Cut, Driven, Link, Loop, PathStep, Shared, Sizes, Target, Tolerances
from .rows import MechanismKernels, MechanismRows, fill_matrix

#: Rounds in which errors may fail to halve.
STALLED = 6
#: Rounds without any progress, after which there is none to come.
PATIENCE = 50
#: Fraction of an error, or of a step, that is progress.
PROGRESS = 1e-3
#: Rows contradict each other where more than this fraction of the largest value is left.
CONTRADICTION = 0.1
#: Weight of rows of loops, where rows of targets have 1.
LOOP_WEIGHT = 8.0
#: Radians of a turn.
TURN = 2.0 * pi
#: Added, it leaves a number's nearest integer in the last bits; taken off again, the number is rounded.
SHIFTER = 1.5 * 2.0**52
#: Larger numbers are not finite.
HUGE = 1e300

DONE, STUCK, LATE, NOT_FINITE = range(4)


@algorithm
def scale_down(x: Reals, first: Int, count: Int, most: Real) -> Real:
    """The factor that brings numbers down to a size; 1 if they have it."""
    size = 0.0
    for i in range(first, first + count):
        size = max(size, abs(x[i]))
    return most / size if size > most else 1.0


def pose_algorithm(
    k: MechanismKernels, r: MechanismRows, identity: tuple[float, ...], system: WeightedRows, room: int
) -> algorithm:
    """The search for poses.

    Parameters
    ----------
    k : MechanismKernels
    r : MechanismRows
    identity : tuple of float
        The motor 1.
    system : WeightedRows
        Of up to ``room`` rows and columns.
    room : int
    """
    Numbers: Any = system.numbers
    Indices: Any = system.integers
    find_directions, least_change = system.find_directions, system.least_change

    @algorithm
    def reduce_contradiction(
        s: InOut[Numbers], indices: Indices, count: Int, columns: Int, cuts: Int, values: Vector[room],
        x: InOut[Vector[room]],
    ) -> None:  # fmt: skip
        """Make the least of what is left of all rows together, where rows contradict each other.

        As those of targets out of reach do, or far ones that are dependent; loops count for more. By modified
        Gram-Schmidt on the rows along their directions (Golub and Van Loan 5.3.5).
        """
        rest = empty(room)
        y = empty(room)
        most = 0.0
        largest = 0.0
        for i in range(count):
            value = values[i]
            for j in range(columns):
                value -= s.matrix[i, j] * x[j]
            rest[i] = value
            most = max(most, abs(value))
            largest = max(largest, abs(values[i]))
        if not most > CONTRADICTION * largest:
            return
        for i in range(count):
            weight = LOOP_WEIGHT if i < cuts else 1.0
            rest[i] *= weight
            for n in range(indices.rank):
                total = 0.0
                for j in range(columns):
                    total += weight * s.matrix[i, j] * s.direction[n, j]
                s.remainder[n, i] = total
        for n in range(indices.rank):
            column = s.remainder[n]
            square = 0.0
            for i in range(count):
                square += column[i] * column[i]
            length = sqrt(square)
            s.taken[n, n] = length
            y[n] = 0.0
            if not length > 0.0:
                continue
            total = 0.0
            for i in range(count):
                column[i] /= length
                total += column[i] * rest[i]
            y[n] = total
            for i in range(count):
                rest[i] -= total * column[i]
            for m in range(n + 1, indices.rank):
                other = s.remainder[m]
                c = 0.0
                for i in range(count):
                    c += column[i] * other[i]
                for i in range(count):
                    other[i] -= c * column[i]
                s.taken[n, m] = c
        for last in range(min(count, columns) - 1, -1, -1):
            if last >= indices.rank or not s.taken[last, last] > 0.0:
                continue
            value = y[last]
            for m in range(last + 1, indices.rank):
                value -= s.taken[last, m] * y[m]
            y[last] = value / s.taken[last, last]
            for j in range(columns):
                x[j] += s.direction[last, j] * y[last]

    @algorithm
    def apply_step(links: Rows[Link], numbers: Reals, off: Reals, x: Vector[room], relative: InOut[Rows[8]]) -> None:
        """Move links by speeds of coordinates, and take errors of their own joints back."""
        twist = empty(6)
        for b in range(len(links)):
            link = links[b]
            for j in range(6):
                total = 0.0
                for c in range(link.count):
                    total += numbers[link.free + 6 * c + j] * x[link.first + c]
                if link.rows > 0:
                    back = 0.0
                    for i in range(link.rows):
                        back += numbers[link.inverse + link.rows * j + i] * off[6 * b + i]
                    total -= back
                twist[j] = total
            relative[b][:] = k.move_by_twist(twist, relative[b])

    @algorithm
    def set_start(
        driven: Rows[Driven], numbers: Reals, relative: Rows[8], wanted: Reals, start: Out[Vector[room]]
    ) -> None:  # fmt: skip
        """Given coordinates as they are now, with the whole turns that those that are wanted have."""
        one = empty(8)
        one[:] = identity
        for n in range(len(driven)):
            each = driven[n]
            total = 0.0
            if each.measure >= 0:
                twist = k.twist_between(one, relative[each.link])
                for j in range(6):
                    total += numbers[each.measure + j] * twist[j]
                if each.turns > 0:
                    turns = (wanted[n] - total) / TURN
                    if abs(turns) < SHIFTER:  # others are whole
                        turns = (turns + SHIFTER) - SHIFTER
                    total += turns * TURN
            start[n] = total

    @algorithm
    def solve_pose(
        links: Rows[Link], shared: Rows[Shared], cuts: Rows[Cut], targets: Rows[Target], loops: Rows[Loop],
        path: Rows[PathStep], driven: Rows[Driven], sizes: Sizes, numbers: Reals, tolerances: Tolerances, rounds: Int,
        to_go: InOut[Vector[room]], goals: Reals, goal: Int, relative: InOut[Rows[8]], motors: InOut[Rows[8]],
        carry: InOut[Rows[36]], free: InOut[Rows[6]], rows: InOut[Rows[6]], errors: InOut[Reals], off: InOut[Reals],
        s: InOut[Numbers], indices: InOut[Indices],
    ) -> tuple[Int, Real]:  # fmt: skip
        """Move links until driven coordinates and targets are met: status, and the largest error that is left."""
        x = empty(room)
        weights = empty(room)
        values = empty(room)
        step = tolerances.step
        last = 0.0
        best = HUGE
        stalled = 0
        since = 0
        count = 0
        while True:
            r.forward_kinematics(links, numbers, relative, motors, carry, free)
            off_joints = r.link_residuals(links, shared, numbers, relative, off)
            off_loops = r.loop_residuals(cuts, shared, numbers, motors, errors, rows)
            off_targets = r.target_residuals(targets, numbers, goals, goal, motors, errors, rows)
            worst = max(max(off_joints, off_loops), off_targets)
            left = 0.0
            for n in range(len(driven)):
                left = max(left, abs(to_go[n]))
            residual = max(worst, left)
            total = 0.0  # the largest of numbers is not the one that is NaN
            for b in range(len(links)):
                for j in range(8):
                    total += motors[b, j]
            if not (residual < HUGE and abs(total) < HUGE):
                return NOT_FINITE, residual
            if residual <= tolerances.closed:
                return DONE, residual
            if count >= rounds:
                return LATE, residual
            if residual < best - PROGRESS * min(best, step):
                best = residual
                since = count
            if count - since > PATIENCE:
                return DONE if residual <= tolerances.nearly else STUCK, residual
            slow = left == 0.0 and worst > last / 2.0 and worst < step  # far targets are approached slowly
            stalled = stalled + 1 if slow else 0
            last = worst
            if stalled > STALLED:
                return DONE if worst <= tolerances.nearly else STUCK, residual
            share = step / left if left > step else 1.0
            for j in range(sizes.columns):
                x[j] = 0.0
                weights[j] = 1.0
            for n in range(len(driven)):
                x[driven[n].column] = to_go[n] * share
                weights[driven[n].column] = 0.0
            if sizes.rows > 0:
                fill_matrix(loops, path, links, free, rows, sizes.columns, s.matrix)
                for n in range(len(loops)):
                    loop = loops[n]
                    less = scale_down(errors, loop.first, loop.rows, step)
                    for i in range(loop.first, loop.first + loop.rows):
                        values[i] = -errors[i] * less
                for i in range(sizes.rows):
                    s.sizes[i] = 0.0
                    s.noise[i] = 0.0
                find_directions(s, indices, sizes.rows, sizes.columns, weights, tolerances.redundant, 0)
                least_change(s, indices, sizes.columns, weights, values, x)
                reduce_contradiction(s, indices, sizes.rows, sizes.columns, sizes.cuts, values, x)
            less = scale_down(x, 0, sizes.columns, 4.0 * step)
            for j in range(sizes.columns):
                x[j] *= less
            for n in range(len(driven)):
                to_go[n] -= x[driven[n].column]
            apply_step(links, numbers, off, x, relative)
            count += 1

    @algorithm
    def poses(
        links: Rows[Link], shared: Rows[Shared], cuts: Rows[Cut], targets: Rows[Target], loops: Rows[Loop],
        path: Rows[PathStep], driven: Rows[Driven], sizes: Sizes, numbers: Reals, tolerances: Tolerances, rounds: Int,
        follows: Int, given: Rows[8], wanted: Reals, goals: Reals, found: Out[Rows[8]],
        residuals: Out[Reals], statuses: Out[Ints],
        relative: InOut[Rows[8]], motors: InOut[Rows[8]], carry: InOut[Rows[36]], free: InOut[Rows[6]],
        rows: InOut[Rows[6]], errors: InOut[Reals], off: InOut[Reals], s: InOut[Numbers], indices: InOut[Indices],
    ) -> None:  # fmt: skip
        """Poses of a path: each starts from the one before it, the first from given motors, of which coordinates count
        if it follows them; else they are zero.
        """
        before = empty(room)
        to_go = empty(room)
        r.set_links(links, given, relative)
        for n in range(len(driven)):
            before[n] = 0.0
            to_go[n] = 0.0
        if follows > 0:
            set_start(driven, numbers, relative, wanted, before)
        for step in range(len(residuals)):
            for n in range(len(driven)):  # what was not done is still to do
                value = wanted[len(driven) * step + n]
                to_go[n] += value - before[n]
                before[n] = value if driven[n].measure >= 0 else 0.0
            status, residual = solve_pose(
                links, shared, cuts, targets, loops, path, driven, sizes, numbers, tolerances, rounds, to_go, goals,
                sizes.goals * step, relative, motors, carry, free, rows, errors, off, s, indices,
            )  # fmt: skip
            statuses[step] = status
            residuals[step] = residual
            for b in range(len(links)):
                found[len(links) * step + links[b].body][:] = motors[b]

    return poses
