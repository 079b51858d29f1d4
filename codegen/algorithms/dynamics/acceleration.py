"""Simulations: accelerations of all bodies at one state, and the reactions of constraints.

Annotations are evaluated: sizes are those of the kind of simulation.
"""

from typing import Any, NamedTuple

from ...ir.loops.algorithm import Algorithm as algorithm
from ...ir.loops.algorithm import still
from ...ir.loops.language import InOut, Int, IntRows, IntVector, Out, Real, Reals, Rows, Vector, epsilon, sqrt
from .loads import load_algorithms
from .records import Body, Code, Constraint, Parts, work_records
from .rows import RowAlgorithms, row_algorithms

OK = int(Code.OK)


class RateAlgorithms(NamedTuple):
    """Rates of one kind of simulation.

    Attributes
    ----------
    add_wrenches, free_accelerations : algorithm
        See `LoadAlgorithms`.
    rows : RowAlgorithms or None
        Of constraints, where there are any.
    blur_by_constraints : algorithm or None
        What constraints add to the rounding of accelerations.
    accelerate : algorithm
        Accelerations, with rows of the wrenches.
    find_reactions : algorithm
        Rows of the reactions, behind `accelerate`.
    """

    add_wrenches: algorithm
    free_accelerations: algorithm
    rows: RowAlgorithms | None
    blur_by_constraints: algorithm | None
    accelerate: algorithm
    find_reactions: algorithm


def rate_algorithms(parts: Parts, k: Any) -> RateAlgorithms:
    """Rates of a kind of simulation.

    Parameters
    ----------
    parts : Parts
    k : named tuple of KernelSpec
    """
    bodies_count, size, row_count, blurs = parts.bodies, parts.size, parts.rows, parts.blurs
    is_constrained, in_subspace = parts.mode == "constrained", parts.mode == "subspace"
    work = work_records(parts)
    Work: Any = work.numbers
    Integers: Any = work.integers
    system = work.rows
    add_wrenches, free_accelerations = load_algorithms(parts, k)
    rows_of = row_algorithms(parts, k) if system is not None else None
    constrain: Any = None if rows_of is None else rows_of.constrain
    least_change: Any = None if system is None else system.least_change
    numbers_size, integers_size = (0, 0) if system is None else (system.numbers.size, system.integers.size)
    blur_by_constraints: Any = None

    if is_constrained and blurs:

        @still
        def blur_by_constraints(
            bodies: Rows[Body], w: InOut[Work], p: InOut[Integers], wanted: Vector[row_count],
            accelerations: Vector[size],
        ) -> None:  # fmt: skip
            """What constraints add to the rounding of accelerations, which come from free ones.

            Each direction adds that of the row that it came from, over the fraction of the row that is new.
            """
            square = 0.0
            total = 0.0
            for b in range(bodies_count):
                for j in range(6):
                    square += bodies[b].metric[j] * accelerations[6 * b + j] * accelerations[6 * b + j]
            length = sqrt(square)
            for m in range(p.rank):
                i = p.order[m]
                change = length + abs(wanted[i]) / w.scale[i]
                off = (epsilon() + w.noise[i] / w.scale[i]) * change / w.upper[m, m]
                total += off * off
            for b in range(bodies_count):
                w.blur[b] += sqrt(total)

    @algorithm
    def accelerate(
        numbers: Reals, bodies: Rows[Body], springs: IntRows[2], user_loads: IntRows[3], constraints: Rows[Constraint],
        w: InOut[Work], p: InOut[Integers], stop: IntVector[1], t: Real, motors: Vector[8 * bodies_count],
        twists: Vector[size], rows: Out[Vector[size]], accelerations: Out[Vector[size]],
    ) -> Int:  # fmt: skip
        """Accelerations of all bodies, and rows of the wrenches; a status."""
        status = add_wrenches(numbers, bodies, springs, user_loads, w, p, t, motors, twists, rows)
        if status != OK:
            return int(status)
        free_accelerations(bodies, w, p, twists, rows, accelerations)
        if is_constrained:
            decay = w.baumgarte
            status = constrain(numbers, bodies, constraints, w, p, stop, t, motors, twists, w.tolerance)
            if status != OK:
                return int(status)
            for i in range(row_count):
                w.wanted[i] = w.right[i] + 2.0 * decay * w.rates[i] + decay * decay * w.errors[i]
            if blurs and p.blurred != 0:
                blur_by_constraints(bodies, w, p, w.wanted, accelerations)
            least_change(w[0:numbers_size], p[0:integers_size], 0, w.weights, w.wanted, accelerations)
        return OK

    @algorithm
    def find_reactions(
        bodies: Rows[Body], w: InOut[Work], p: InOut[Integers], rows: Vector[size], accelerations: Vector[size],
        reactions: Out[Vector[size]],
    ) -> None:  # fmt: skip
        """Rows of the reactions, from accelerations and rows of the wrenches that have just been computed."""
        if is_constrained:
            for j in range(size):
                reactions[j] = w.change[j] / w.weights[j]
        elif in_subspace:
            for i in range(6):
                reactions[i] = -rows[i]
                for j in range(6):
                    reactions[i] += bodies[0].mass[i, j] * accelerations[j]
        else:
            reactions[:] = 0.0

    return RateAlgorithms(add_wrenches, free_accelerations, rows_of, blur_by_constraints, accelerate, find_reactions)
