"""Stages of a registration, each of one item: a sample, a candidate, an object, a match. Items are independent."""

from __future__ import annotations

from ...algorithms.motor_form import FORM, least_pivot
from ...algorithms.registration_layout import (
    ELEMENT,
    MOTOR,
    POSITION,
    RATES,
    RESIDUAL,
    RESIDUALS,
    TWIST,
    VECTORS,
    Grid,
    Head,
    Selected,
    Settings,
)
from ...formulas.registration import registration
from ...ir.loops.algorithm import Algorithm as algorithm
from ...ir.loops.language import InOut, Int, Ints, Matrix, Out, Real, Reals, Rows, Static, Vector, empty, zeros
from .. import KernelSpec
from .registration import KIND_SETS
from .scene import add_form, apart, fitting_segment, form_motor, move_element, nearest, score

step_motor = KernelSpec(registration.step_motor, ("motor", "twist"), "stepped")
position_rates = KernelSpec(registration.position_rates, ("motor", "position"), "position_rates")
direction_rates = KernelSpec(registration.vector_rates, ("motor", "position"), "direction_rates")
unseen = KernelSpec(registration.unseen, ("motor", "position", "position"), "unseen")
unseen_twist = KernelSpec(registration.unseen_twist, ("twist", "position"), "unseen_twist")


# -- of objects, without a scene ---------------------------------------------------------------------------------------


@algorithm
def elements(kinds: Static, kind: Int, row: Reals, element: Out[Vector[ELEMENT]]) -> None:
    """Position, direction and radius of a unit object."""
    for each in KIND_SETS[kinds]:
        if kind == each.number:
            element[:] = each.element(row[: each.length])
            return


@algorithm
def to_frame(kinds: Static, kind: Int, row: Reals, origin: Vector[3], found: InOut[Reals]) -> None:
    """Coefficients of an object in a frame at an origin."""
    for each in KIND_SETS[kinds]:
        if kind == each.number:
            found[: each.length] = each.in_frame(row[: each.length], origin)
            return


@algorithm
def squared_distances(a: Vector[ELEMENT], b: Vector[ELEMENT], settings: Settings, directed: Vector[1]) -> Real:
    """Weighted square of how far two elements of a kind are apart."""
    square, _ = apart(a, b, settings.weights, directed, settings.other)
    return square


@algorithm
def motors_to_world(motor: Vector[MOTOR], to: Vector[3], back: Vector[3], found: Out[Vector[MOTOR]]) -> None:
    """The motor of the world, of one from a frame at ``back`` to a frame at ``to``."""
    found[:] = unseen(motor, to, back)


@algorithm
def twists_to_world(twist: Vector[TWIST], origin: Vector[3], found: Out[Vector[TWIST]]) -> None:
    """The twist of the world, of one of a frame at an origin."""
    found[:] = unseen_twist(twist, origin)


@algorithm
def step(motor: Vector[MOTOR], twist: Vector[TWIST], found: Out[Vector[MOTOR]]) -> None:
    """The motor next to (1 + twist) motor."""
    found[:] = step_motor(motor, twist)


# -- of a query and a reference ----------------------------------------------------------------------------------------


@algorithm
def rates(
    kinds: Static,
    kind: Int,
    motor: Vector[MOTOR],
    query: Int,
    reference: Int,
    heads: Rows[Head],
    reals: Reals,
    found: Out[Vector[RATES]],
) -> None:
    """Cost of a match given by its rows, its gradient and its Gauss-Newton matrix by the twist."""
    x = heads[kind].query + heads[kind].length * query
    y = heads[kind].reference + heads[kind].length * reference
    for each in KIND_SETS[kinds]:
        if kind == each.number:
            found[:1], found[1 : 1 + TWIST], found[1 + TWIST :] = each.rates(
                motor, reals[x : x + each.length], reals[y : y + each.length]
            )
            return


@algorithm
def residual_rates(
    motor: Vector[MOTOR],
    vectors: Vector[VECTORS],
    directed: Int,
    residuals: Matrix[RESIDUALS, RESIDUAL],
    found: Out[Vector[RATES]],
) -> None:
    """Sum of squared residuals of a match, its gradient and its Gauss-Newton matrix by the twist.

    Residuals are linear forms of two vectors that the motor moves: a position, and another one or a direction.
    """
    moved = empty(VECTORS)
    moved_rates = empty(2, TWIST * POSITION)
    moved[:POSITION], moved_rates[0] = position_rates(motor, vectors[:POSITION])
    if directed != 0:
        moved[POSITION:], moved_rates[1] = direction_rates(motor, vectors[POSITION:])
    else:
        moved[POSITION:], moved_rates[1] = position_rates(motor, vectors[POSITION:])
    found[:] = 0.0
    slope = empty(TWIST)
    for k in range(RESIDUALS):
        value = -residuals[k, VECTORS]
        for j in range(VECTORS):
            value += residuals[k, j] * moved[j]
        for i in range(TWIST):
            slope[i] = 0.0
            for j in range(POSITION):
                slope[i] += residuals[k, j] * moved_rates[0, POSITION * i + j]
                slope[i] += residuals[k, POSITION + j] * moved_rates[1, POSITION * i + j]
        found[0] += value * value
        at = 1 + TWIST
        for i in range(TWIST):
            found[1 + i] += 2.0 * value * slope[i]
            for j in range(i, TWIST):
                found[at] += 2.0 * slope[i] * slope[j]
                at += 1


@algorithm
def stiffness(kinds: Static, set_kinds: Ints, query: Ints, heads: Rows[Head], reals: Reals) -> Real:
    """The least pivot of the form |B X - X B|^2 of twists of a set of query objects; kind -1 leaves one out."""
    form = zeros(FORM)
    for k in range(len(set_kinds)):
        kind = set_kinds[k]
        if kind >= 0:
            x = heads[kind].query + heads[kind].length * query[k]
            add_form(kinds, kind, reals, x, x, (1.0,), 1.0, form)
    return least_pivot(form)


@algorithm
def samples(
    kinds: Static,
    pair_kinds: Ints,
    query: Ints,
    reference: Ints,
    signs: Reals,
    residual: Real,
    selected: Rows[Selected],
    settings: Settings,
    grids: Rows[Grid],
    heads: Rows[Head],
    reals: Reals,
    integers: Ints,
    motor: Out[Vector[MOTOR]],
) -> tuple[Real, Int, Int]:
    """The motor of a sample of matches, and its `score`.

    Kind -1 leaves one out. ``residual`` is the mean of |R X - Y R|^2 up to which a sample is consistent.
    """
    form = zeros(FORM)
    first = 0
    for k in range(len(pair_kinds)):
        kind = pair_kinds[k]
        if kind < 0:
            continue
        first += query[k]
        x = heads[kind].query + heads[kind].length * query[k]
        y = heads[kind].reference + heads[kind].length * reference[k]
        add_form(kinds, kind, reals, x, y, signs[k : k + 1], 1.0, form)
    least = form_motor(form, motor)
    total = -1.0
    hits = 0
    tested = 0
    if least >= 0.0 and least <= residual * float(len(pair_kinds)):
        total, hits, tested = score(kinds, motor, first, selected, settings, grids, heads, reals, integers)
    return total, hits, tested


@algorithm
def add_matches(
    kinds: Static,
    motor: Vector[MOTOR],
    selected: Rows[Selected],
    settings: Settings,
    grids: Rows[Grid],
    heads: Rows[Head],
    reals: Reals,
    integers: Ints,
    form: InOut[Vector[FORM]],
) -> None:
    """Add the forms of all matches under a motor, near ones weighing more."""
    element = zeros(ELEMENT)
    for i in range(len(selected)):
        kind = selected[i].kind
        x = heads[kind].query + heads[kind].length * selected[i].row
        move_element(kinds, kind, motor, reals, x, element)
        row, square, sign = nearest(kind, element, settings, grids, heads, reals, integers)
        if row >= 0:
            near = 1.0 - square / settings.limit
            y = heads[kind].reference + heads[kind].length * row
            add_form(kinds, kind, reals, x, y, (sign,), near * near, form)


@algorithm
def replace_motor(motor: InOut[Vector[MOTOR]], other: Vector[MOTOR]) -> Real:
    """Put another motor, of the same sign, in a motor's place; the square of the change."""
    agreement = 0.0
    for k in range(MOTOR):
        agreement += other[k] * motor[k]
    change = 0.0
    for k in range(MOTOR):
        value = -other[k] if agreement < 0.0 else other[k]
        change += (value - motor[k]) * (value - motor[k])
        motor[k] = value
    return change


@algorithm
def refine(
    kinds: Static,
    rounds: Int,
    settled: Real,
    selected: Rows[Selected],
    settings: Settings,
    grids: Rows[Grid],
    heads: Rows[Head],
    reals: Reals,
    integers: Ints,
    motor: InOut[Vector[MOTOR]],
) -> tuple[Real, Int, Int]:
    """Match, and move by the motor of the matches, until it stays; the `score`, and rounds or -1 if it came to nothing.

    ``settled`` is the square of the motor's change that ends it.
    """
    taken = -1
    for k in range(rounds):
        form = zeros(FORM)
        add_matches(kinds, motor, selected, settings, grids, heads, reals, integers, form)
        following = empty(MOTOR)
        least = form_motor(form, following)
        if not least >= 0.0:
            break
        change = replace_motor(motor, following)
        taken = k + 1
        if change <= settled:
            break
    total, hits, _ = score(kinds, motor, 0, selected, settings, grids, heads, reals, integers)
    return total, hits, taken


@algorithm
def match(
    kinds: Static,
    selected: Selected,
    motor: Vector[MOTOR],
    settings: Settings,
    grids: Rows[Grid],
    heads: Rows[Head],
    reals: Reals,
    integers: Ints,
) -> tuple[Int, Real, Real]:
    """Row of the counterpart of a query object or -1, the weighted square, and -1 if it has the other orientation."""
    element = zeros(ELEMENT)
    at = heads[selected.kind].query + heads[selected.kind].length * selected.row
    move_element(kinds, selected.kind, motor, reals, at, element)
    row, square, sign = nearest(selected.kind, element, settings, grids, heads, reals, integers)
    return row, square, sign


@algorithm
def match_segments(
    kinds: Static,
    kind: Int,
    row: Int,
    motor: Vector[MOTOR],
    ends: Rows[VECTORS],
    reference_ends: Rows[VECTORS],
    settings: Settings,
    grids: Rows[Grid],
    heads: Rows[Head],
    reals: Reals,
    integers: Ints,
) -> tuple[Int, Real]:
    """Row of the counterpart of a query segment by its ends or -1, and the mean square by which ends are off."""
    element = zeros(ELEMENT)
    move_element(kinds, kind, motor, reals, heads[kind].query + heads[kind].length * row, element)
    moved = empty(VECTORS)
    rates = empty(TWIST * POSITION)
    own = ends[row]
    moved[:POSITION], rates[:] = position_rates(motor, own[:POSITION])
    moved[POSITION:], rates[:] = position_rates(motor, own[POSITION:])
    found, square = fitting_segment(kind, element, moved, reference_ends, settings, grids, heads, reals, integers)
    return found, square
