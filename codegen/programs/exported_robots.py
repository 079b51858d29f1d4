"""What exported files of robots call beside the algorithms of chains and mechanisms: poses as matrices."""

# Annotations are evaluated here: sizes of records are those of the call.
from functools import cache
from typing import Any

from ..algorithms.chain_records import Frame, Joint
from ..algorithms.weighted_rows import weighted_rows
from ..ir.loops.algorithm import Algorithm as algorithm
from ..ir.loops.language import InOut, Int, Matrix, Out, Reals, Rows, Vector, empty, int_empty
from ..ir.loops.nodes import Function
from ..optimise.variants import Variant
from .chains import algorithms_of as chains_of
from .mechanisms.poses import HUGE, NOT_FINITE
from .mechanisms.program import algorithms_of as mechanisms_of
from .mechanisms.records import Cut, Driven, Link, Loop, PathStep, Shared, Sizes, Target, Tolerances


@cache
def chain_matrix(algebra: str, room: int, to_matrix: Variant) -> Function:
    """The homogeneous matrix of a chain's tool; ``to_matrix``: of a motor, as the package computes it."""
    forward = chains_of(algebra, room).forward

    @algorithm
    def tool_matrix(
        joints: Rows[Joint], tool: Rows[Frame], base: Vector[3], q: Reals, matrix: Out[Matrix[4, 4]]
    ) -> None:  # fmt: skip
        """Homogeneous matrix of the tool, row by row."""
        motors = empty(1, 8)
        forward(joints, tool, base, q, motors)
        matrix[:] = to_matrix(motors[0])

    return tool_matrix.instance()


@cache
def mechanism_matrices(algebra: str, room: int, to_matrix: Variant, carried: Variant) -> Function:
    """Homogeneous matrices of a mechanism's bodies in the world, at one pose.

    ``to_matrix`` as of `chain_matrix`; ``carried``: of a motor, carried along by another.
    """
    poses = mechanisms_of(algebra, room)["poses"]
    system = weighted_rows(room, room, is_open=True)
    Numbers: Any = system.numbers
    Indices: Any = system.integers

    @algorithm
    def body_matrices(
        links: Rows[Link], shared: Rows[Shared], cuts: Rows[Cut], targets: Rows[Target], loops: Rows[Loop],
        path: Rows[PathStep], driven: Rows[Driven], sizes: Sizes, numbers: Reals, tolerances: Tolerances, rounds: Int,
        scales: Vector[8], shift: Vector[8], speeds: Reals, goals: Reals, wanted: Reals, start: Rows[8],
        motors: Out[Rows[8]], matrices: Out[Rows[16]], relative: InOut[Rows[8]], own: InOut[Rows[8]],
        carry: InOut[Rows[36]], free: InOut[Rows[6]], rows: InOut[Rows[6]], errors: InOut[Reals], off: InOut[Reals],
        s: InOut[Numbers], indices: InOut[Indices],
    ) -> Int:  # fmt: skip
        """Poses of all bodies for coordinates of the driven joints, from motors of a pose near; 0, or why not."""
        statuses = int_empty(1)
        residuals = empty(1)
        world = empty(8)
        coordinates = empty(room)
        for n in range(len(driven)):
            coordinates[n] = wanted[n] / speeds[n]
            if not abs(coordinates[n]) < HUGE:
                return NOT_FINITE
        poses(
            links, shared, cuts, targets, loops, path, driven, sizes, numbers, tolerances, rounds, 1, start,
            coordinates, goals, motors, residuals, statuses, relative, own, carry, free, rows, errors, off, s, indices,
        )  # fmt: skip
        for b in range(len(motors)):
            for i in range(8):
                world[i] = motors[b, i] * scales[i]
            moved = carried(shift, world)
            matrices[b][:] = to_matrix(moved)
        return int(statuses[0])

    return body_matrices.instance()
