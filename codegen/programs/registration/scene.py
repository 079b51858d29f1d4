"""How well a motor lays a query over a reference; `algorithms.registration_layout` says what their arrays hold.

``kinds`` is the name of the set of kinds that a program has.
"""

from __future__ import annotations

from ...algorithms.motor_form import FORM, minimize_form
from ...algorithms.registration_layout import ELEMENT, MOTOR, POSITION, VECTORS, Grid, Head, Selected, Settings
from ...formulas.registration import registration
from ...ir.loops.algorithm import Algorithm as algorithm
from ...ir.loops.algorithm import inlined
from ...ir.loops.language import (
    InOut,
    Int,
    Ints,
    Out,
    Real,
    Reals,
    Rows,
    Static,
    Vector,
    empty,
    sqrt,
    zeros,
)
from .. import KernelSpec, cga3d
from .registration import KIND_SETS

apart = KernelSpec(registration.apart, ("numbers7", "numbers7", "numbers3", "number", "number"), "apart")
ends_apart = KernelSpec(registration.ends_apart, ("position",) * 4, "ends_apart")
near_motor = KernelSpec(registration.near_motor, ("layout motor",), "near_motor")
#: Where the coefficients of q, then those of q', stand in a motor q + q', and which of them.
PLACES = tuple((cga3d().kind("motor").blades.index(b), k) for k, b in enumerate(registration.motor_blades(cga3d())))
#: Objects after which a motor may be given up for the first time, and how many times as many they are the next time.
FIRST_LOOK = 8
NEXT_LOOK = 4


@inlined
def move_element(
    kinds: Static, kind: Int, motor: Vector[MOTOR], reals: Reals, at: Int, element: Out[Vector[ELEMENT]]
) -> None:
    """The element of a moved object."""
    for each in KIND_SETS[kinds]:
        if kind == each.number:
            element[:] = each.moved(motor, reals[at : at + each.length])
            return


@algorithm
def motor_form(
    kinds: Static, kind: Int, reals: Reals, x: Int, y: Int, sign: Vector[1], form: Out[Vector[FORM]]
) -> None:
    """The form of motors that take x to y, where their coefficients begin."""
    for each in KIND_SETS[kinds]:
        if kind == each.number:
            form[:] = each.form(reals[x : x + each.length], reals[y : y + each.length], sign)
            return


@algorithm
def add_form(
    kinds: Static, kind: Int, reals: Reals, x: Int, y: Int, sign: Vector[1], weight: Real, total: InOut[Vector[FORM]]
) -> None:
    """Add the form of motors that take x to y."""
    form = empty(FORM)
    motor_form(kinds, kind, reals, x, y, sign, form)
    for k in range(FORM):
        total[k] += weight * form[k]


@algorithm
def form_motor(form: Vector[FORM], motor: Out[Vector[MOTOR]]) -> Real:
    """The unit motor of least form, and the form there; negative if the form leaves the rotation free."""
    minimizer = empty(MOTOR)
    least = minimize_form(form, minimizer)
    sum_of_blades = empty(MOTOR)
    for place, k in PLACES:
        sum_of_blades[place] = minimizer[k]
    motor[:] = near_motor(sum_of_blades)
    return least


@algorithm
def cell(grid: Grid, head: Head, axis: Int, x: Real) -> Int:
    """The cell along an axis that holds x."""
    place = (x - grid.corner[axis]) * grid.scale
    last = head.sides[axis] - 1
    return (int(place) if place < float(last) else last) if place > 0.0 else 0


@inlined
def nearest(
    kind: Int,
    element: Vector[ELEMENT],
    settings: Settings,
    grids: Rows[Grid],
    heads: Rows[Head],
    reals: Reals,
    integers: Ints,
) -> tuple[Int, Real, Real]:
    """The row of the nearest reference object within the limit, or -1; its weighted square, and its sign."""
    grid = grids[kind]
    head = heads[kind]
    found = -1
    best = settings.limit
    side = 1.0
    if element[0] - element[0] != 0.0 or head.objects == 0:
        return found, best, side
    reach = sqrt(settings.limit / settings.weights[0])
    low_x = cell(grid, head, 0, element[0] - reach)
    high_x = cell(grid, head, 0, element[0] + reach)
    low_y = cell(grid, head, 1, element[1] - reach)
    high_y = cell(grid, head, 1, element[1] + reach)
    low_z = cell(grid, head, 2, element[2] - reach)
    high_z = cell(grid, head, 2, element[2] + reach)
    for x in range(low_x, high_x + 1):
        for y in range(low_y, high_y + 1):
            starts = head.starts + (x * head.sides[1] + y) * head.sides[2]
            for j in range(integers[starts + low_z], integers[starts + high_z + 1]):
                at = head.elements + ELEMENT * j
                square, cosine = apart(
                    element, reals[at : at + ELEMENT], settings.weights, grid.directed, settings.other
                )
                if square < best or (square == best and found > integers[head.order + j]):
                    best = square
                    side = cosine
                    found = integers[head.order + j]
    return found, best, -1.0 if settings.other[0] < 0.0 and side < 0.0 else 1.0


@algorithm
def fitting_segment(
    kind: Int,
    element: Vector[ELEMENT],
    ends: Vector[VECTORS],
    reference_ends: Rows[VECTORS],
    settings: Settings,
    grids: Rows[Grid],
    heads: Rows[Head],
    reals: Reals,
    integers: Ints,
) -> tuple[Int, Real]:
    """The reference segment that a moved one fits best, of those whose lines are within the limit, or -1; the mean
    square by which ends are off.

    What sticks out counts up to half the range of matches: less than another line, but it decides between segments
    of one line.
    """
    grid = grids[kind]
    head = heads[kind]
    found = -1
    best = 0.0
    square = 0.0
    if element[0] - element[0] != 0.0 or head.objects == 0:
        return found, square
    reach = sqrt(settings.limit / settings.weights[0])
    for x in range(cell(grid, head, 0, element[0] - reach), cell(grid, head, 0, element[0] + reach) + 1):
        for y in range(cell(grid, head, 1, element[1] - reach), cell(grid, head, 1, element[1] + reach) + 1):
            starts = head.starts + (x * head.sides[1] + y) * head.sides[2]
            begin = integers[starts + cell(grid, head, 2, element[2] - reach)]
            for j in range(begin, integers[starts + cell(grid, head, 2, element[2] + reach) + 1]):
                at = head.elements + ELEMENT * j
                apart_, _ = apart(element, reals[at : at + ELEMENT], settings.weights, grid.directed, settings.other)
                if not apart_ <= settings.limit:
                    continue
                row = integers[head.order + j]
                others = reference_ends[row]
                off, out = ends_apart(ends[:POSITION], ends[POSITION:], others[:POSITION], others[POSITION:])
                misfit = off + min(out * out, 0.25 * reach * reach)
                if found < 0 or misfit < best or (misfit == best and found > row):
                    best = misfit
                    square = off
                    found = row
    return found, square


@inlined
def score(
    kinds: Static,
    motor: Vector[MOTOR],
    first: Int,
    selected: Rows[Selected],
    settings: Settings,
    grids: Rows[Grid],
    heads: Rows[Head],
    reals: Reals,
    integers: Ints,
) -> tuple[Real, Int, Int]:
    """How well a motor lays the query over the reference; objects with a counterpart, of how many.

    It is given up, with the score -1, where too few of the first 8, 32, 128 ... objects have a counterpart. They are
    asked in turn from a first one on, which should differ between samples: else a query whose first few objects have
    no counterpart is never found.
    """
    element = zeros(ELEMENT)
    count = len(selected)
    total = 0.0
    hits = 0
    tested = 0
    look = FIRST_LOOK
    i = first % count if count > 0 else 0
    for n in range(count):
        if n == look:
            if float(hits) < settings.least * float(n):
                break
            look *= NEXT_LOOK
        kind = selected[i].kind
        at = heads[kind].query + heads[kind].length * selected[i].row
        move_element(kinds, kind, motor, reals, at, element)
        found, square, _ = nearest(kind, element, settings, grids, heads, reals, integers)
        if found >= 0:
            total += 1.0 - square / settings.limit
            hits += 1
        tested += 1
        i = i + 1 if i + 1 < count else 0
    return -1.0 if tested < count else total, hits, tested
