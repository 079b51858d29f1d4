"""Algorithm 1 of the thesis, corrected: through the matches in turn, at each half of the way that is left."""

from __future__ import annotations

from ...algorithms.registration_layout import MOTOR, Head
from ...formulas.registration import estimation
from ...ir.loops.algorithm import Algorithm as algorithm
from ...ir.loops.language import Bool, InOut, Int, Ints, Out, Real, Reals, Rows, Static, Vector, empty, zeros
from .. import KernelSpec
from .registration import KIND_SETS
from .scene import near_motor

change = KernelSpec(estimation.change, ("motor", "motor"), "change")


@algorithm
def is_finite(motor: Vector[MOTOR]) -> Bool:
    """Whether all coefficients are."""
    total = 0.0
    for k in range(MOTOR):
        total += motor[k]
    return total - total == 0.0


@algorithm
def half_step_of_two(
    kinds: Static,
    kind: Int,
    motor: Vector[MOTOR],
    reals: Reals,
    x: Int,
    y: Int,
    x2: Int,
    y2: Int,
    following: Out[Vector[MOTOR]],
) -> Bool:
    """Half of the way of a match of a kind without a direction, with another one that gives it an axis."""
    for each in KIND_SETS[kinds]:
        if not each.directed and kind == each.number:
            following[:] = each.half_step_of_two(
                motor, reals[x : x + each.length], reals[y : y + each.length], reals[x2 : x2 + each.length],
                reals[y2 : y2 + each.length],
            )  # fmt: skip
            is_done: Bool = is_finite(following)
            return is_done
    return False


@algorithm
def half_step(
    kinds: Static,
    kind: Int,
    motor: Vector[MOTOR],
    reals: Reals,
    x: Int,
    y: Int,
    sign: Vector[1],
    following: Out[Vector[MOTOR]],
) -> Bool:
    """Half of the way of a match; where it is not finite, objects face each other or their centres are one."""
    for each in KIND_SETS[kinds]:
        if kind == each.number:
            following[:] = each.half_step(motor, reals[x : x + each.length], reals[y : y + each.length], sign)
    is_done: Bool = is_finite(following)
    return is_done


@algorithm
def direct(
    kinds: Static,
    pair_kinds: Ints,
    query: Ints,
    reference: Ints,
    partners: Ints,
    signs: Reals,
    tolerance: Real,
    heads: Rows[Head],
    reals: Reals,
    motor: InOut[Vector[MOTOR]],
    mean: InOut[Vector[MOTOR]],
    changes: InOut[Reals],
) -> tuple[Int, Int]:
    """Rounds until the motor stays, as many as there are changes to note; steps of the last that were not finite.

    ``partners`` are other matches of the kind, or -1; ``mean`` is the middle of all motors of the last round.
    """
    following = empty(MOTOR)
    taken = 0
    skipped = 0
    while taken < len(changes):
        before = empty(MOTOR)
        before[:] = motor
        total = zeros(MOTOR)
        skipped = 0
        for i in range(len(pair_kinds)):
            kind = pair_kinds[i]
            head = heads[kind]
            x = head.query + head.length * query[i]
            y = head.reference + head.length * reference[i]
            is_done = False
            if partners[i] >= 0:
                x2 = head.query + head.length * query[partners[i]]
                y2 = head.reference + head.length * reference[partners[i]]
                is_done = half_step_of_two(kinds, kind, motor, reals, x, y, x2, y2, following)
            if not is_done:
                is_done = half_step(kinds, kind, motor, reals, x, y, signs[i : i + 1], following)
            if is_done:
                motor[:] = following
            else:
                skipped += 1
            for k in range(MOTOR):
                total[k] += motor[k]
        mean[:] = near_motor(total)
        distance = change(motor, before)
        changes[taken] = distance
        taken += 1
        if distance < tolerance:
            break
    return taken, skipped
