"""Simulations: springs whose ends meet, where their direction jumps and the motion has no series.

A spring that has a length at rest pulls by it along the direction of its gap; on a line through its anchor that
direction turns round at once, and damping along it has none there. Series go on as if nothing was: the distance is then
a smooth function with a sign. Next to the line all is smooth, and seen by the steps.

Annotations are evaluated: sizes are those of the kind of simulation.
"""

from typing import Any

from ...ir.loops.algorithm import Algorithm as algorithm
from ...ir.loops.algorithm import inlined
from ...ir.loops.language import Bool, Int, IntRows, Out, Reals, Vector, empty
from .loads import POINT, SPRING_SIZE
from .records import Parts, Spring, work_records

LENGTH, DAMPING = Spring.extent("length")[0], Spring.extent("damping")[0]
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

    @inlined
    def motor_of(b: Int, motors: Vector[motors_size], r: Out[Vector[8]]) -> None:
        """Motor of a spring's body, or of the world."""
        if b >= 0:
            r[:] = motors[8 * b : 8 * b + 8]
        else:
            r[:] = identity

    @algorithm
    def springs_meet(
        numbers: Reals, springs: IntRows[2], p: Integers, before: Vector[motors_size], after: Vector[motors_size]
    ) -> Bool:  # fmt: skip
        """Whether the ends of a spring with a direction met in a step, or nearly: series go on as if it had none."""
        r = empty(8)
        s = empty(8)
        met: Bool = False
        for i in range(p.springs):
            at = p.spring_offset + SPRING_SIZE * i
            if numbers[at + LENGTH] == 0.0 and numbers[at + DAMPING] == 0.0:
                continue
            point = numbers[at : at + 3]
            anchor = numbers[at + POINT : at + POINT + 3]
            motor_of(springs[i, 0], before, r)
            motor_of(springs[i, 1], before, s)
            old = k.spring_gap(r, point, s, anchor)
            motor_of(springs[i, 0], after, r)
            motor_of(springs[i, 1], after, s)
            new = k.spring_gap(r, point, s, anchor)
            first = 0.0
            second = 0.0
            along = 0.0
            for j in range(3):
                first += old[j] * old[j]
                second += new[j] * new[j]
                along += old[j] * new[j]
            off = 0.0  # of the second from the line of the first, times their lengths
            for j in range(3):
                side = first * new[j] - along * old[j]
                off += side * side
            if first == 0.0 or (along <= 0.0 and off <= IN_LINE * IN_LINE * first * first * second):
                met = True
        return met

    return springs_meet
