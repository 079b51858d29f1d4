"""Simulations: the systems of the stages of implicit steps, and the derivatives that they are made of.

Of a stage

    J = [C, B; K, D],    C and B blocks of 6 x 6,    E = 2 - B, which is B^-1 but for squares of the motion in a step,

so that a system of half the size remains:

    (m^2 E - m (D E + E C) - (K - D E C)) dx = r2 + (m - D) E r1,    dv = E ((m - C) dx - r1).

Annotations are evaluated: sizes are those of the kind of simulation.
"""

from typing import Any, NamedTuple

from ....ir.algorithm_derivative import derivative_of
from ....ir.loops.algorithm import Algorithm as algorithm
from ....ir.loops.language import InOut, Int, IntRows, IntVector, Real, Reals, Rows, Vector, empty
from ...dense import factor, solve_factored
from ..records import Body, Code, Constraint, Parts, kept_record, work_records
from .charts import ChartAlgorithms
from .collocated import diagonal

OK = int(Code.OK)


class StageSystems(NamedTuple):
    """Systems of the stages of a step.

    Attributes
    ----------
    differentiate_stages : algorithm
        What they take of the derivatives of the rates at all stages; a status.
    factor_stages : algorithm
        Their factors for a step of a length.
    solve_stage : algorithm
        The solution of one.
    """

    differentiate_stages: algorithm
    factor_stages: algorithm
    solve_stage: algorithm


def stage_systems(parts: Parts, charts: ChartAlgorithms) -> StageSystems:
    """Systems of the stages of a kind of simulation.

    Parameters
    ----------
    parts : Parts
    charts : ChartAlgorithms
    """
    count, size, state, chart = parts.bodies, parts.size, parts.state, 2 * parts.size
    work = work_records(parts)
    own_size = work.numbers.size
    Kept: Any = kept_record(parts)
    Work: Any = work.whole
    Integers: Any = work.integers
    rates_along = derivative_of(charts.state_rates, "w", "x")

    @algorithm
    def find_jacobian(
        numbers: Reals, bodies: Rows[Body], springs: IntRows[2], user_loads: IntRows[3], constraints: Rows[Constraint],
        w: InOut[Work], p: InOut[Integers], stop: IntVector[1], t: Real, x: Vector[chart], stage: Int,
        kept: InOut[Kept], unit: InOut[Vector[chart]], slopes: InOut[Vector[chart]], column: InOut[Vector[chart]],
    ) -> Int:  # fmt: skip
        """The derivatives of the rates at a stage, column by column, and what its system takes of them; a status."""
        stiffness = kept.stiffness[size * stage : size * stage + size]
        damping = kept.damping[size * stage : size * stage + size]
        turning = kept.turning[size * stage : size * stage + size]
        moving = kept.moving[size * stage : size * stage + size]
        block = empty(6)
        status = OK
        unit[:] = 0.0
        for j in range(chart):
            unit[j] = 1.0
            if status == OK:
                status = rates_along(
                    numbers, bodies, springs, user_loads, constraints, w[0:own_size], p, stop, t, kept.motors, x,
                    slopes, w.along, unit, column,
                )  # fmt: skip
                p.held = 1
            unit[j] = 0.0
            first = (j % size) - j % 6
            for i in range(size):
                if j < size:
                    stiffness[i, j] = column[size + i]
                else:
                    damping[i, j - size] = column[size + i]
            for i in range(6):
                if j < size:
                    turning[first + i, j % 6] = column[first + i]
                else:
                    moving[first + i, j % 6] = (2.0 if i == j % 6 else 0.0) - column[first + i]
        p.held = 0
        for b in range(count):
            for i in range(size):
                for j in range(6):
                    block[j] = 0.0
                    for m in range(6):
                        block[j] += damping[i, 6 * b + m] * moving[6 * b + m, j]
                for j in range(6):
                    damping[i, 6 * b + j] = block[j]
            for i in range(size):
                for j in range(6):
                    for m in range(6):
                        stiffness[i, 6 * b + j] -= damping[i, 6 * b + m] * turning[6 * b + m, j]
            for j in range(6):
                for i in range(6):
                    block[i] = 0.0
                    for m in range(6):
                        block[i] += moving[6 * b + i, m] * turning[6 * b + m, j]
                for i in range(6):
                    turning[6 * b + i, j] = block[i]
                    damping[6 * b + i, 6 * b + j] += block[i]
        return int(status)

    @algorithm
    def factor_stage(m: Real, stage: Int, kept: InOut[Kept]) -> None:
        """The factors of a stage's system."""
        at = size * stage
        factors = kept.factors[at : at + size]
        for i in range(size):
            first = i - i % 6
            for j in range(size):
                factors[i, j] = -m * kept.damping[at + i, j] - kept.stiffness[at + i, j]
            for j in range(6):
                factors[i, first + j] += m * m * kept.moving[at + i, j]
        factor(factors, size, kept.pivots[at : at + size], kept.divisors[at : at + size])

    @algorithm
    def solve_stage(kept: Kept, m: Real, stage: Int, r: InOut[Vector[chart]], x: InOut[Vector[size]]) -> None:
        """Replace r by the solution of a stage's system, of its factors."""
        at = size * stage
        for i in range(size):
            first = i - i % 6
            total = r[size + i]
            for j in range(size):
                total -= kept.damping[at + i, j] * r[j]
            for j in range(6):
                total += (m * kept.moving[at + i, j] + kept.turning[at + i, j]) * r[first + j]
            x[i] = total
        solve_factored(
            kept.factors[at : at + size], size, kept.pivots[at : at + size], kept.divisors[at : at + size], x
        )
        for i in range(size):
            first = i - i % 6
            total = 0.0
            for j in range(6):
                moving = kept.moving[at + i, j]
                total += (m * moving - kept.turning[at + i, j]) * x[first + j] - moving * r[first + j]
            r[size + i] = total
        for i in range(size):
            r[i] = x[i]

    @algorithm
    def differentiate_stages(
        numbers: Reals, bodies: Rows[Body], springs: IntRows[2], user_loads: IntRows[3], constraints: Rows[Constraint],
        w: InOut[Work], p: InOut[Integers], stop: IntVector[1], scheme: Reals, t: Real, h: Real, start: Vector[state],
        kept: InOut[Kept], stages: InOut[Rows[state]], x: InOut[Vector[state]], end: InOut[Vector[state]],
    ) -> Int:  # fmt: skip
        """The systems of all stages where they are now; a status. What x and end hold is lost."""
        n = p.stages
        slopes = stages[3 * n + 2]
        column = stages[3 * n + 3]
        status = OK
        for i in range(n):
            for j in range(chart):
                end[j] = start[j] + stages[n + i, j]
            if status == OK:
                status = find_jacobian(
                    numbers, bodies, springs, user_loads, constraints, w, p, stop, t + scheme[i] * h, end[0:chart], i,
                    kept, x[0:chart], slopes[0:chart], column[0:chart],
                )  # fmt: skip
        it = kept.iteration
        it.has_jacobian = 2.0
        it.factored_step = 0.0
        return int(status)

    @algorithm
    def factor_stages(p: Integers, scheme: Reals, h: Real, kept: InOut[Kept]) -> None:
        """Their factors for a step of a length."""
        n = p.stages
        it = kept.iteration
        if it.factored_step != h:
            for i in range(n):
                factor_stage(diagonal(scheme, n, i, h), i, kept)
            it.factored_step = h

    return StageSystems(differentiate_stages, factor_stages, solve_stage)
