"""Simulations: how far a state is off the constraints, and the nearest state that obeys them.

Annotations are evaluated: sizes are those of the kind of simulation.
"""

from typing import Any, NamedTuple

from ...ir.loops.algorithm import Algorithm as algorithm
from ...ir.loops.algorithm import inlined, still, still_inlined
from ...ir.loops.language import (
    INFINITY,
    Bool,
    InOut,
    Int,
    IntRows,
    IntVector,
    Out,
    Real,
    Reals,
    Rows,
    Vector,
    empty,
    epsilon,
    sqrt,
)  # fmt: skip
from ..weighted_rows import COARSE, NO_MOTION, ROUNDINGS
from .acceleration import RateAlgorithms
from .records import FINE, Body, Code, Constraint, Parts, work_records

OK, RANK_CHANGED, VIOLATED = int(Code.OK), int(Code.RANK_CHANGED), int(Code.VIOLATED)
#: In place of `FINE`, from the start on: a part of the least independent fraction there, at most so much. It is coarser
#: where no body is much lighter than its neighbors, so that singular poses of mechanisms are passed in a step or two. A
#: single body has none, and flies further along a line, in its own sizes, than that.
PART, COARSEST = 1e-2, 1e-5
#: Added to what may be zero.
TINY = 1e-300
#: Rounds of a projection, at most.
PROJECTIONS = 20
#: A row that is so many times its rounding says how far a pose is off.
SIGNIFICANT = 1e3
#: Fraction of a body's size, or angle, that a pose may be off after a projection.
MOST_VIOLATED = 1e-6
#: Error of a pose that counts as rounding.
ROUNDING = 8.0
#: A round of a projection that leaves more than this fraction of an error comes to nothing.
GAIN = 0.7


class ProjectionAlgorithms(NamedTuple):
    """Constraints of one kind of simulation, where it has any.

    Attributes
    ----------
    radius_of_gyration : algorithm
        Of a body: the length that its errors are measured by.
    project : algorithm or None
        The nearest state that obeys the constraints.
    bring_back : algorithm or None
        The same, which must succeed.
    move_back : algorithm or None
        One round of it, of poses (0) or of twists (1).
    observe : algorithm
        Reactions and violation at a stored state.
    check_start : algorithm or None
        How far the start is off.
    """

    radius_of_gyration: algorithm
    project: algorithm | None
    bring_back: algorithm | None
    move_back: algorithm | None
    observe: algorithm
    check_start: algorithm | None


def _observe_free(parts: Parts) -> algorithm:
    """What there is to observe where nothing is constrained."""
    size, motors_size, work = parts.size, 8 * parts.bodies, work_records(parts)
    Work: Any = work.numbers
    Integers: Any = work.integers

    @algorithm
    def observe(
        numbers: Reals, bodies: Rows[Body], springs: IntRows[2], user_loads: IntRows[3], constraints: Rows[Constraint],
        w: InOut[Work], p: InOut[Integers], stop: IntVector[1], t: Real, motors: Vector[motors_size],
        twists: Vector[size], reactions: Out[Vector[size]],
    ) -> tuple[Int, Real]:  # fmt: skip
        """Reactions of free bodies: none."""
        reactions[:] = 0.0
        return OK, 0.0

    return observe


def projection_algorithms(parts: Parts, k: Any, rates: RateAlgorithms) -> ProjectionAlgorithms:
    """Projections of a kind of simulation.

    Parameters
    ----------
    parts : Parts
    k : named tuple of KernelSpec
    rates : RateAlgorithms
    """
    bodies_count, size, motors_size = parts.bodies, parts.size, 8 * parts.bodies
    angular, linear, a_velocity = parts.angular, parts.linear, parts.linear[0]
    is_constrained, row_count = parts.mode == "constrained", parts.rows
    work = work_records(parts)
    Work: Any = work.numbers
    Integers: Any = work.integers
    system = work.rows
    numbers_size, integers_size = (0, 0) if system is None else (system.numbers.size, system.integers.size)
    accelerate, find_reactions = rates.accelerate, rates.find_reactions

    @inlined
    def radius_of_gyration(body: Body) -> Real:
        """Length that errors of a body are measured by."""
        moment = 0.0
        mass = 0.0
        for axis in angular:
            moment = max(moment, body.metric[axis])
        for axis in linear:
            mass = max(mass, body.metric[axis])
        return sqrt(moment / mass) if mass > 0.0 else 1.0

    if system is None:
        return ProjectionAlgorithms(radius_of_gyration, None, None, None, _observe_free(parts), None)
    assert rates.rows is not None
    fill_rows, constrain, least_change = rates.rows.fill_rows, rates.rows.constrain, system.least_change

    @inlined
    def is_significant(w: Work, row: Int) -> Bool:
        """Whether a row says more than its rounding."""
        more: Bool = w.scale[row] > SIGNIFICANT * w.noise[row]
        return more

    @still_inlined
    def true_error(w: Work, row: Int) -> Real:
        """Error of a row beyond its rounding."""
        return max(0.0, abs(w.errors[row]) - ROUNDINGS * w.rounding[row])

    @still
    def position_error(
        bodies: Rows[Body], w: Work, p: Integers, motors: Vector[motors_size], row: Int, error: Real
    ) -> Real:
        """How far a row's error is a body off, as a fraction of its size and distance from the origin, or in radians.

        An error that no motion mends, but for rounding, is measured by itself.
        """
        if not w.scale[row] > NO_MOTION * w.longest:
            return error / (w.largest + TINY)
        b = p.bodies[row]
        body = bodies[b]
        distance = k.distance_of(motors[8 * b : 8 * b + 8])
        return error / (w.scale[row] * sqrt(body.metric[a_velocity]) * (radius_of_gyration(body) + distance))

    @still
    def velocity_scale(bodies: Rows[Body], w: Work, twists: Vector[size], b: Int) -> Real:
        """Rates of bodies by energy, and those that count as none."""
        energy = 0.0
        for a in range(bodies_count):
            for j in range(6):
                energy += bodies[a].metric[j] * twists[6 * a + j] * twists[6 * a + j]
        body = bodies[b]
        return sqrt(energy) + sqrt(body.metric[a_velocity]) * radius_of_gyration(body) * w.pace + TINY

    @still
    def constraint_violation(bodies: Rows[Body], w: Work, p: Integers, twists: Vector[size], row: Int) -> Real:
        """How far a row is off that no motion mends, beyond rounding.

        The body as a fraction of its size or in radians; or the row as a fraction of what errors are made of. Rows of
        rates as a fraction of the bodies' own.
        """
        b = p.bodies[row]
        body = bodies[b]
        error = true_error(w, row)
        moves = w.scale[row] > NO_MOTION * w.longest and w.scale[row] > SIGNIFICANT * w.noise[row]
        if p.powers[row] != 0:
            rate = w.rates[row]
            for j in range(size):
                rate -= w.matrix[row, j] * w.step[j]
            fraction = abs(rate) / (w.scale[row] * velocity_scale(bodies, w, twists, b) + TINY)
            if moves and w.pace > 0.0:
                return max(0.0, fraction - ROUNDINGS * w.noise[row] / w.scale[row])
            return 0.0
        if not moves:
            return error / (w.largest + TINY)
        return error / (w.scale[row] * sqrt(body.metric[a_velocity]) * radius_of_gyration(body))

    @algorithm
    def move_poses(w: InOut[Work], p: InOut[Integers], motors: InOut[Vector[motors_size]]) -> None:
        """Poses by the least motion that makes the errors of the rows at hand zero, to first order."""
        w.step[:] = 0.0
        least_change(w[0:numbers_size], p[0:integers_size], 0, w.weights, w.errors, w.step)
        for b in range(bodies_count):
            moved = k.move_by_twist(motors[8 * b : 8 * b + 8], w.step[6 * b : 6 * b + 6])
            motors[8 * b : 8 * b + 8] = k.near_motor(moved)

    @algorithm
    def move_twists(w: InOut[Work], p: InOut[Integers], twists: InOut[Vector[size]]) -> None:
        """Twists by the least change that makes the rates of the rows' errors zero."""
        w.step[:] = 0.0
        least_change(w[0:numbers_size], p[0:integers_size], 0, w.weights, w.rates, w.step)
        for j in range(size):
            twists[j] += w.step[j]

    @algorithm
    def move_back(
        numbers: Reals, bodies: Rows[Body], constraints: Rows[Constraint], w: InOut[Work], p: InOut[Integers],
        stop: IntVector[1], t: Real, part: Int, motors: InOut[Vector[motors_size]], twists: InOut[Vector[size]],
    ) -> Int:  # fmt: skip
        """One round of a projection, of poses (0) or of twists (1); a status."""
        status = constrain(numbers, bodies, constraints, w, p, stop, t, motors, twists, w.tolerance)
        if status != OK:
            return int(status)
        if part == 0:
            move_poses(w, p, motors)
        else:
            move_twists(w, p, twists)
        return OK

    @algorithm
    def project(
        numbers: Reals, bodies: Rows[Body], constraints: Rows[Constraint], w: InOut[Work], p: InOut[Integers],
        stop: IntVector[1], t: Real, tolerance: Real, motors: InOut[Vector[motors_size]], twists: InOut[Vector[size]],
    ) -> tuple[Int, Int]:  # fmt: skip
        """Poses, then twists, to the nearest ones that the constraints allow: a status, and the rank."""
        last = INFINITY
        attempts = 0
        while True:
            worst = 0.0
            status = constrain(numbers, bodies, constraints, w, p, stop, t, motors, twists, tolerance)
            if status != OK:
                return status, 0
            for i in range(row_count):
                if is_significant(w, i):
                    worst = max(worst, position_error(bodies, w, p, motors, i, abs(w.errors[i])))
            if not worst > ROUNDING * epsilon() or attempts == PROJECTIONS:
                break
            if not worst < last * GAIN and worst < MOST_VIOLATED:
                break
            last = worst
            attempts += 1
            move_poses(w, p, motors)
        move_twists(w, p, twists)
        w.off = 0.0
        p.off_row = 0
        for i in range(row_count):
            violation = constraint_violation(bodies, w, p, twists, i)
            if violation > w.off:
                w.off = violation
                p.off_row = i
        w.independent = 1.0
        for m in range(p.rank):
            w.independent = min(w.independent, w.upper[m, m])
        return OK, p.rank + p.excess

    @algorithm
    def bring_back(
        numbers: Reals, bodies: Rows[Body], constraints: Rows[Constraint], w: InOut[Work], p: InOut[Integers],
        stop: IntVector[1], t: Real, motors: InOut[Vector[motors_size]], twists: InOut[Vector[size]],
    ) -> tuple[Int, Int]:  # fmt: skip
        """A state back to the constraints, which must be possible: as `project`."""
        status, rank = project(numbers, bodies, constraints, w, p, stop, t, w.tolerance, motors, twists)
        if status == OK and w.off > MOST_VIOLATED:
            status = VIOLATED if rank == p.known_rank else RANK_CHANGED
        return status, rank

    @algorithm
    def observe(
        numbers: Reals, bodies: Rows[Body], springs: IntRows[2], user_loads: IntRows[3], constraints: Rows[Constraint],
        w: InOut[Work], p: InOut[Integers], stop: IntVector[1], t: Real, motors: Vector[motors_size],
        twists: Vector[size], reactions: Out[Vector[size]],
    ) -> tuple[Int, Real]:  # fmt: skip
        """A status, and the violation of the constraints at a stored state; reactions as wrenches of the world."""
        rows = empty(size)
        accelerations = empty(size)
        own = empty(size)
        status = accelerate(
            numbers, bodies, springs, user_loads, constraints, w, p, stop, t, motors, twists, rows, accelerations
        )
        if status != OK:
            return status, 0.0
        find_reactions(bodies, w, p, rows, accelerations, own)
        for b in range(bodies_count):
            reactions[6 * b : 6 * b + 6] = k.world_wrench(motors[8 * b : 8 * b + 8], own[6 * b : 6 * b + 6])
        status = fill_rows(numbers, bodies, constraints, w, p, t, motors, twists)
        if status != OK:
            return status, 0.0
        violation = 0.0
        for i in range(row_count):
            error = abs(w.errors[i]) + w.unknown[i]
            if p.powers[i] != 0:  # of rates: as a fraction of the bodies' own
                square = TINY
                for b in range(bodies_count):
                    for j in range(6):
                        root = bodies[b].roots[j]
                        square += w.matrix[i, 6 * b + j] * w.matrix[i, 6 * b + j] * root * root
                error = abs(w.rates[i]) / (sqrt(square) * velocity_scale(bodies, w, twists, p.bodies[i]))
            violation = max(violation, error)
        if is_constrained and p.rank > p.known_rank:
            return RANK_CHANGED, violation
        return OK, violation

    @algorithm
    def check_start(
        numbers: Reals, bodies: Rows[Body], constraints: Rows[Constraint], w: InOut[Work], p: InOut[Integers],
        stop: IntVector[1], t: Real, projects: Bool, motors: InOut[Vector[motors_size]], twists: InOut[Vector[size]],
        start: Out[Vector[2]], start_rows: Out[IntVector[2]],
    ) -> Int:  # fmt: skip
        """How far the start is off the constraints, and their rank; it is brought to them first if that is wished.

        Off: poses as fractions of the bodies' sizes and distances or in radians, rates as fractions of the bodies' own.
        """
        if is_constrained and projects:
            status, rank = project(numbers, bodies, constraints, w, p, stop, t, COARSE, motors, twists)
            if status == OK:
                status, rank = project(numbers, bodies, constraints, w, p, stop, t, w.tolerance, motors, twists)
            if status != OK:
                return int(status)
        status = constrain(numbers, bodies, constraints, w, p, stop, t, motors, twists, w.tolerance)
        if status != OK:
            return int(status)
        start[:] = 0.0
        start_rows[:] = 0
        for i in range(row_count):
            distance = position_error(bodies, w, p, motors, i, true_error(w, i))
            pace = w.scale[i] * velocity_scale(bodies, w, twists, p.bodies[i])
            rate = abs(w.rates[i]) / pace if pace > 0.0 else 0.0
            if distance > start[0]:
                start[0] = distance
                start_rows[0] = i
            if rate > start[1]:
                start[1] = rate
                start_rows[1] = i
        first = p.rank
        if is_constrained:
            # a start that is off by rounding makes rows say more than on the constraints, where later states are
            near_motors = empty(motors_size)
            near_twists = empty(size)
            near_motors[:] = motors
            near_twists[:] = twists
            status, rank = project(numbers, bodies, constraints, w, p, stop, t, w.tolerance, near_motors, near_twists)
            if status != OK:
                return int(status)
            first = min(rank, first)
            if bodies_count > 1:
                w.tolerance = max(FINE, min(COARSEST, PART * w.independent))
        p.known_rank = first
        return OK

    if not is_constrained:
        return ProjectionAlgorithms(radius_of_gyration, None, None, None, observe, check_start)
    return ProjectionAlgorithms(radius_of_gyration, project, bring_back, move_back, observe, check_start)
