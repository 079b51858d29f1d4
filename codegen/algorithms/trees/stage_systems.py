"""Motion of trees of links: the systems of the stages of implicit steps.

Behind the states that are kept there are, for each stage, the derivatives J of the rates by coordinates and speeds, the
factors of m - J, and the order and scales of these. Tangents of the work of links, bodies, rows are behind that work.
"""

from __future__ import annotations

from typing import NamedTuple

from ...ir.algorithm_derivative import derivative_of
from ...ir.loops.algorithm import Algorithm as algorithm
from ...ir.loops.algorithm import inlined
from ...ir.loops.language import InOut, Int, IntRows, Ints, Real, Reals, Rows, Vector
from ..chain_records import Joint
from ..dense import factor, solve_factored
from ..dynamics.records import Spring
from ..dynamics.steps.collocated import MORE_ROWS, diagonal
from .motion_records import JointLaw, KeptMotion, LinkWork, Loop, LoopRow, Options, RowWork, Settings, TreeBody
from .records import Link


def numbers_of_stages(stages: int, size: int) -> int:
    """Numbers that a simulation of a state of a size keeps for its stages."""
    return (3 * stages + MORE_ROWS) * size + stages * (2 * size * size + 2 * size)


class StageSystems(NamedTuple):
    """Systems of the stages of a step.

    Attributes
    ----------
    differentiate_stages : algorithm
        The derivatives of the rates at all stages.
    factor_stages : algorithm
        Factors for a step of a length.
    solve_stage : algorithm
        The solution of one.
    """

    differentiate_stages: algorithm
    factor_stages: algorithm
    solve_stage: algorithm


def stage_systems(find_rates: algorithm) -> StageSystems:
    """Systems of the stages of trees, of the rates of coordinates and speeds."""
    rates_along = derivative_of(find_rates, "x")

    @inlined
    def system_of(n: Int, size: Int, stage: Int) -> Int:
        """Where what a stage's system takes begins."""
        return (3 * n + MORE_ROWS) * size + stage * (2 * size * size + 2 * size)

    @algorithm
    def differentiate_stages(
        joints: Rows[Joint], parents: Ints, balls: Ints, joint_laws: Rows[JointLaw], torques: Reals, links: Rows[Link],
        bodies: Rows[TreeBody], carriers: Ints, spring_ends: IntRows[2], springs: Rows[Spring], loops: Rows[Loop],
        rows: Rows[LoopRow], places: IntRows[8], firsts: Ints, gravity: Vector[3], settings: Settings, options: Options,
        references: Reals, start: Reals,
        work: InOut[Rows[LinkWork]], acting: InOut[Rows[6]], row_work: InOut[Rows[RowWork]], matrix: InOut[Reals],
        x: InOut[Reals], unit: InOut[Reals], kept: InOut[KeptMotion], stages: InOut[Reals],
    ) -> None:  # fmt: skip
        """The derivatives of the rates at all stages where they are now, column by column."""
        size = len(start)
        n = options.stages
        slopes = stages[size * (3 * n + 2) :]
        column = stages[size * (3 * n + 3) :]
        for j in range(size):
            unit[j] = 0.0
        for i in range(n):
            at = system_of(n, size, i)
            for j in range(size):
                x[j] = start[j] + stages[size * (n + i) + j]
            for j in range(size):
                unit[j] = 1.0
                rates_along(
                    joints, parents, balls, joint_laws, torques, links, bodies, carriers, spring_ends, springs, loops,
                    rows, places, firsts, gravity, options, options.poses, references, x, work, acting, row_work,
                    matrix, slopes, 0, unit, work[len(joints) :], acting[len(bodies) :], row_work[len(rows) :],
                    matrix[2 * len(rows) * len(rows) :], column,
                )  # fmt: skip
                unit[j] = 0.0
                for m in range(size):
                    stages[at + size * m + j] = column[m]
        it = kept.iteration
        it.has_jacobian = 2.0
        it.factored_step = 0.0

    @algorithm
    def factor_stages(size: Int, options: Options, scheme: Reals, h: Real, kept: InOut[KeptMotion],
                      stages: InOut[Reals]) -> None:  # fmt: skip
        """Factors of the systems m - J for a step of a length."""
        n = options.stages
        it = kept.iteration
        if it.factored_step != h:
            for i in range(n):
                at = system_of(n, size, i)
                own = at + size * size
                for j in range(size * size):
                    stages[own + j] = -stages[at + j]
                m = diagonal(scheme, n, i, h)
                for j in range(size):
                    stages[own + (size + 1) * j] += m
                factor(stages[own:], size, stages[own + size * size :], stages[own + size * size + size :])
            it.factored_step = h

    @algorithm
    def solve_stage(size: Int, n: Int, i: Int, at: Int, stages: InOut[Reals]) -> None:
        """Replace numbers of a place by the solution of a stage's system."""
        own = system_of(n, size, i) + size * size
        order = own + size * size
        solve_factored(stages[own:], size, stages[order:], stages[order + size :], stages[at:])

    return StageSystems(differentiate_stages, factor_stages, solve_stage)
