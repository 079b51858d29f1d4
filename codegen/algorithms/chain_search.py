"""Serial chains: the search for coordinates that bring the tool to a pose, by damped Newton steps.

The error is a rotation and the path of the tool's origin. A length of the chain counts as a radian, so that metres
or microns make no difference.
"""

from __future__ import annotations

from typing import Any

from ..ir.loops.algorithm import Algorithm as algorithm
from ..ir.loops.language import (
    INFINITY,
    NAN,
    Bool,
    InOut,
    Int,
    Matrix,
    Out,
    Real,
    Reals,
    Rows,
    Vector,
    empty,
    sqrt,
    zeros,
)  # fmt: skip
from ..status import Status
from .chain_records import Frame, Goal, Joint, Search
from .dense import rank_of, solve_damped

#: Damping at first, relative to the square of the error,
DAMPING = 1e-2
#: or to this: translations bring far goals near in steps that are exact.
LARGEST_SQUARE = 16.0
LEAST_DAMPING = 1e-6
#: Where no step helps.
LARGEST_DAMPING = 1e12
#: Square of the damping of what no joint moves: less is rounding.
DAMPING_FLOOR = 1e-16
#: Fractions of what a step was to gain: damping increases below the first,
POOR = 0.25
#: decreases above,
GOOD = 0.75
#: and a step is not taken below.
SUFFICIENT = 1e-4
#: A step that gains no more than this fraction comes to nothing.
REST = 1e-9
#: An attempt, but the first, ends where so many steps leave more than this fraction of the square of the error each.
SLOW = 0.9
MOST_SLOW = 4
#: What came nearer than this square of the error is followed for so many times the iterations of an attempt: poses at
#: which the arm is singular are approached slowly.
NEAR = 1e-6
PATIENT = 50
#: What the square of a distance counts beside that of half an angle, where a restart is chosen: positions say more of
#: joints than rotations do.
NEARNESS = 7.5
#: Restarts of which the nearest is chosen; further ones follow in their order.
MOST_RANKED = 256
#: Of a rotating joint in one step, in radians or lengths of the chain.
LONGEST_ROTATION = 1.5
#: For each joint: nothing is known better.
ROUNDING = 4.4e-16
#: A direction with less of its own is lost: next to one, joints are known to half the digits.
DEPENDENT = 1e-7

REACHED = int(Status.OK)
UNREACHABLE = int(Status.UNREACHABLE)
NOT_CONVERGED = int(Status.NOT_CONVERGED)
INVALID = int(Status.INVALID)
#: A motor whose squared norm is so far from 1 is not unit, even if it was rounded to single precision.
NOT_UNIT = 1e-5


def search_algorithm(k: Any, joint_axes: algorithm, room: int) -> algorithm:
    """The search in chains of up to ``room`` joints.

    Parameters
    ----------
    k : ChainKernels
    joint_axes : algorithm
        Axes and positions of joints, and the pose of the tool.
    room : int
    """

    @algorithm
    def compute_error(
        joints: Rows[Joint], tool: Frame, goal: Goal, length: Real, x: Reals,
        axes: Out[Matrix], positions: Out[Matrix], p: Out[Vector[3]], error: Out[Vector[6]],
    ) -> Real:  # fmt: skip
        """Rotation and displacement from the tool to its goal, a length worth a radian: the square of both."""
        q = empty(4)
        joint_axes(joints, tool, x, axes, positions, q, p)
        error[:] = k.pose_error(q, p, goal.rotor, goal.position)
        square = 0.0
        for r in range(6):
            if r >= 3:
                error[r] /= length
            square += error[r] * error[r]
        return square

    @algorithm
    def compute_rows(
        joints: Rows[Joint], limits: Rows[2], units: Vector, length: Real, x: Reals,
        axes: Matrix, positions: Matrix, p: Vector[3], error: Vector[6],
        rows: Out[Matrix],
    ) -> None:  # fmt: skip
        """The Jacobian at the tool, without joints that are at a limit and would go beyond."""
        column = empty(6)
        for j in range(len(joints)):
            joint = joints[j]
            column[:] = k.column(axes[j], positions[j], p, joint.rotation, joint.advance)
            gradient = 0.0
            for r in range(6):
                column[r] *= units[j] / length if r >= 3 else units[j]
                gradient += column[r] * error[r]
            held = (gradient > 0.0 and x[j] >= limits[j, 1]) or (gradient < 0.0 and x[j] <= limits[j, 0])
            for r in range(6):
                rows[r, j] = 0.0 if held else column[r]

    @algorithm
    def take_step(
        joints: Rows[Joint], limits: Rows[2], units: Vector, x: Reals, step: Vector,
        trial: Out[Reals],
    ) -> None:  # fmt: skip
        """Where a step leads, within the limits. Translations may be of any length: what they move is linear."""
        most = 0.0
        for j in range(len(joints)):
            if joints[j].rotation != 0.0:
                most = max(most, abs(step[j]))
        fraction = LONGEST_ROTATION / most if most > LONGEST_ROTATION else 1.0
        for j in range(len(joints)):
            part = fraction if joints[j].rotation != 0.0 else 1.0
            trial[j] = min(max(limits[j, 0], x[j] + part * units[j] * step[j]), limits[j, 1])

    @algorithm
    def remainders(error: Vector[6], length: Real) -> tuple[Real, Real]:
        """Rotation and distance that remain."""
        angle = sqrt(error[0] * error[0] + error[1] * error[1] + error[2] * error[2])
        return angle, sqrt(error[3] * error[3] + error[4] * error[4] + error[5] * error[5]) * length

    @algorithm
    def is_reached(error: Vector[6], goal: Goal, search: Search, count: Int) -> Bool:
        """Whether what remains is tolerated, or rounding."""
        rounding = ROUNDING * float(count)
        most = max(search.tolerance, rounding)
        square = 0.0
        for i in range(3):
            square += goal.position[i] * goal.position[i]
        angle, distance = remainders(error, search.length)
        is_near: Bool = angle <= most and distance <= max(most * search.length, rounding * sqrt(square))
        return is_near

    @algorithm
    def attempt(
        joints: Rows[Joint], tool: Frame, limits: Rows[2], units: Vector, goal: Goal, search: Search,
        iterations: Int, most_slow: Int, x: InOut[Reals], error: Out[Vector[6]],
    ) -> tuple[Int, Real, Int, Int]:  # fmt: skip
        """Damped Newton steps until the goal is reached, nothing moves, most are slow, or iterations end.

        Status, square of the error, steps, and where the goal is reached the rank of the Jacobian, joints at limits
        included.
        """
        n = len(joints)
        axes = empty(room, 3)
        positions = empty(room, 3)
        p = empty(3)
        rows = empty(6, room)
        step = empty(room)
        trial = empty(room)
        kept = empty(6)
        nothing = zeros(6)
        damping = DAMPING
        steps = 0
        slow = 0
        square = compute_error(joints, tool, goal, search.length, x, axes, positions, p, error)
        for _ in range(iterations):
            if not square < INFINITY:
                return INVALID, square, steps, 0
            if is_reached(error, goal, search, n):
                break
            compute_rows(joints, limits, units, search.length, x, axes, positions, p, error, rows)
            before = square
            kept[:] = error
            while True:
                root = sqrt(max(damping * min(before, LARGEST_SQUARE), DAMPING_FLOOR))
                left = solve_damped(rows, n, error, root, step)
                if not before - left > REST * before:
                    return NOT_CONVERGED, square, steps, 0
                take_step(joints, limits, units, x, step, trial)
                square = compute_error(joints, tool, goal, search.length, trial, axes, positions, p, error)
                steps += 1
                gain = (before - square) / (before - left)
                if not gain >= POOR:
                    damping *= 4.0 if gain >= SUFFICIENT else 16.0
                elif gain > GOOD:
                    damping = max(damping / 4.0, LEAST_DAMPING)
                if gain >= SUFFICIENT:
                    break
                error[:] = kept
                square = before
                if damping > LARGEST_DAMPING:
                    return NOT_CONVERGED, square, steps, 0
            for j in range(n):
                x[j] = trial[j]
            slow = slow + 1 if square > SLOW * before else 0
            if slow == most_slow:
                return NOT_CONVERGED, square, steps, 0
        if not is_reached(error, goal, search, n):
            return NOT_CONVERGED, square, steps, 0
        before = square  # one step more, down to rounding
        compute_rows(joints, limits, units, search.length, x, axes, positions, p, error, rows)
        left = solve_damped(rows, n, error, sqrt(DAMPING_FLOOR), step)
        take_step(joints, limits, units, x, step, trial)
        square = compute_error(joints, tool, goal, search.length, trial, axes, positions, p, error)
        stays = is_reached(error, goal, search, n)
        if stays and square < before:
            for j in range(n):
                x[j] = trial[j]
        else:
            square = compute_error(joints, tool, goal, search.length, x, axes, positions, p, error)
        compute_rows(joints, limits, units, search.length, x, axes, positions, p, nothing, rows)
        rank = rank_of(rows, n, DEPENDENT)
        return REACHED, square, steps, rank

    @algorithm
    def rank_restarts(poses: Rows[Goal], goal: Goal, length: Real, ranks: Out[Vector[MOST_RANKED]]) -> None:
        """How near the poses of restarts are to the goal: less is nearer."""
        for i in range(min(len(poses), MOST_RANKED)):
            pose = poses[i]
            cosine = 0.0
            for r in range(4):
                cosine += pose.rotor[r] * goal.rotor[r]
            square = 0.0
            for r in range(3):
                square += (pose.position[r] - goal.position[r]) * (pose.position[r] - goal.position[r])
            ranks[i] = NEARNESS * square / (length * length) - cosine * cosine

    @algorithm
    def next_restart(ranks: InOut[Vector[MOST_RANKED]], count: Int, a: Int) -> Int:
        """Index of the nearest restart that is left, which is taken; those without a rank follow."""
        if a > count:
            return a - 1
        least = 0
        for i in range(1, count):
            least = i if ranks[i] < ranks[least] else least
        ranks[least] = INFINITY
        return least

    @algorithm
    def inverse(
        joints: Rows[Joint], tool: Frame, base: Vector[3], limits: Rows[2], restarts: Reals, poses: Rows[Goal],
        search: Search, iterations: Int, nearest: Int, motor: Vector[8], start: Reals, solution: InOut[Reals],
    ) -> tuple[Int, Real, Real, Int, Int]:  # fmt: skip
        """Coordinates that bring the tool to a motor: status, rotation and distance that remain, steps, rank.

        The first attempt begins at the start, the next ones at the restarts, that with the nearest pose first. What is
        slow among these ends early, unless the nearest pose is requested.
        """
        n = len(joints)
        units = empty(room)
        x = empty(room)
        ranks = empty(MOST_RANKED)
        goal = empty(7)
        error = empty(6)
        status = INVALID
        angle = NAN
        distance = NAN
        steps = 0
        rank = 0
        goal[:4], goal[4:] = k.decompose(motor, base)
        square = 0.0
        for i in range(4, 7):
            square += goal[i] * goal[i]
        unit = 0.0
        for i in range(4):
            unit += goal[i] * goal[i]
        magnitude = 0.0
        for i in range(8):
            magnitude += abs(motor[i])
        for j in range(n):
            magnitude += abs(start[j])
        if not (magnitude < INFINITY and abs(unit - 1.0) < NOT_UNIT):
            return status, angle, distance, steps, rank
        is_beyond = sqrt(square) > search.reach
        if is_beyond and nearest == 0:
            return UNREACHABLE, angle, distance, steps, rank
        for j in range(n):
            joint = joints[j]
            units[j] = 1.0 / max(abs(joint.rotation), abs(joint.advance) / search.length)
        best = INFINITY
        count = len(poses)
        # the start; restarts; on from what came nearest; if that is near restarts again
        for a in range(2 * count + 2 if count > 0 else 1):
            if a == count + 1 and not best < INFINITY or a == count + 2 and not best < NEAR:
                break
            is_last = a == count + 1
            if (a == 1 or a == count + 2) and not is_last:
                rank_restarts(poses, goal, search.length, ranks)
            r = -1
            if a > 0 and not is_last:
                r = next_restart(ranks, min(count, MOST_RANKED), a if a <= count else a - count - 1)
            for j in range(n):
                begin = restarts[n * r + j] if r >= 0 else start[j]
                x[j] = min(max(solution[j] if is_last else begin, limits[j, 0]), limits[j, 1])
            most_slow = MOST_SLOW if a > 0 and a <= count and nearest == 0 else PATIENT * iterations
            most = PATIENT * iterations if is_last and (best < NEAR or nearest != 0) else iterations
            outcome, left, taken, free = attempt(joints, tool, limits, units, goal, search, most, most_slow, x, error)
            steps += taken
            if outcome == INVALID or not (left < best or outcome == REACHED):
                continue
            status = outcome
            best = left
            rank = free
            for j in range(n):
                solution[j] = x[j]
            angle, distance = remainders(error, search.length)
            if outcome == REACHED:
                break
        return UNREACHABLE if is_beyond else status, angle, distance, steps, rank

    return inverse
