"""Simulations: springs whose ends meet, where their direction jumps and the motion has no series.

A spring that has a length at rest pulls by it along the direction of its gap; on a line through its anchor that
direction turns round at once, and damping along it has none there. Series go on as if nothing was: the distance is then
a smooth function with a sign. Next to the line all is smooth, and seen by the steps.

Annotations are evaluated: sizes are those of the kind of simulation.
"""

from typing import Any

from ...ir.loops.algorithm import Algorithm as algorithm
from ...ir.loops.language import Bool, IntRows, Reals, Vector, empty
from .loads import LAW, POINT, SPRING_SIZE
from .records import Parts, work_records

#: Sine of the angle off a line up to which a passage counts as one through the anchor.
IN_LINE = 1e-9


def meeting_algorithm(parts: Parts, k: Any) -> algorithm:
    """Whether the ends of a spring met in a step.

    Parameters
    ----------
    parts : Parts
    k : named tuple of KernelSpec
    """
    motors_size, identity = 8 * parts.bodies, parts.identity
    Integers: Any = work_records(parts).integers

    @algorithm
    def springs_meet(
        numbers: Reals, springs: IntRows[2], p: Integers, before: Vector[motors_size], after: Vector[motors_size]
    ) -> Bool:  # fmt: skip
        """Whether the ends of a spring with a direction met in a step, or nearly: series go on as if it had none."""
        r = empty(8)
        s = empty(8)
        gaps = empty(2, 3)
        met: Bool = False
        for i in range(p.springs):
            at = p.spring_offset + SPRING_SIZE * i
            if numbers[at + LAW + 1] == 0.0 and numbers[at + LAW + 2] == 0.0:
                continue
            a, b = springs[i, 0], springs[i, 1]
            for n in range(2):
                r[:] = identity
                s[:] = identity
                if a >= 0:
                    for j in range(8):
                        r[j] = before[8 * a + j] if n == 0 else after[8 * a + j]
                if b >= 0:
                    for j in range(8):
                        s[j] = before[8 * b + j] if n == 0 else after[8 * b + j]
                gaps[n][:] = k.spring_gap(r, numbers[at : at + 3], s, numbers[at + POINT : at + POINT + 3])
            first = 0.0
            second = 0.0
            along = 0.0
            for j in range(3):
                first += gaps[0, j] * gaps[0, j]
                second += gaps[1, j] * gaps[1, j]
                along += gaps[0, j] * gaps[1, j]
            off = 0.0  # of the second from the line of the first, times their lengths
            for j in range(3):
                side = first * gaps[1, j] - along * gaps[0, j]
                off += side * side
            if first == 0.0 or (along <= 0.0 and off <= IN_LINE * IN_LINE * first * first * second):
                met = True
        return met

    return springs_meet
