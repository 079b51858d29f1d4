"""Models of objects laid over each other by a motor (thesis chapter 5): what one pair of objects says about it.

A motor leaves a round its radius: what tells the motor is its carriers, the center and the axis. Flats and points are
their own.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import NamedTuple

from ...algebra.algebra import Algebra
from ...algebra.multivector import Multivector, absolute, select, sqrt
from ...trace.derivatives import derivative_formula
from ...trace.outputs import Result, row
from ..motions.motions import translator
from ..objects.blades import norm_squared
from ..objects.conformal import infinity, origin, point, round_center
from ..objects.costs import align, any_rotor, is_plain, parallel, positive_product
from ..objects.euclidean import (
    attached_part,
    axes,
    canonical_sign,
    coordinates,
    euclidean_part,
    space,
    vector,
)
from ..objects.local import anchor, curvature, inward
from ..products.outcome import where_or_nan


def motor_blades(algebra: Algebra) -> list[int]:
    """Blades of a motor, those of a rotor about the origin first: a translation changes only the others."""
    null = 1 << algebra.vectors.index("ni")
    return sorted(algebra.kind("motor").blades, key=lambda blade: bool(blade & null))


# -- what a motor sees of an object ------------------------------------------------------------------------


def center(x: Multivector) -> Multivector:
    """Position of a point, center of a round; NaN for a flat of a round's kind."""
    if x.grades == (1,):
        return euclidean_part(x)
    if x.grades == (4,):
        dual = x.dual()
        weight = -(dual | infinity(x))
        return euclidean_part(dual) / where_or_nan(absolute(weight) > 0, weight)
    return round_center(x if x.grades == (2,) else x.dual())[0]


def is_flat(x: Multivector) -> bool:
    """Return whether x is a flat by its blades: they all hold n_inf."""
    return not curvature(x).terms


def direction(x: Multivector) -> Multivector:
    """Unit direction of a line or a point pair, normal of a plane or a circle; nothing for points and spheres."""
    if x.grades == (1,) or (x.grades == (4,) and not is_flat(x)):
        return x.new({})
    if not is_flat(x):
        along = round_center(x if x.grades == (2,) else x.dual())[1]
        return along / sqrt((along * along).grade(0))
    attitude = euclidean_part((origin(x) | x) | infinity(x))
    return (attitude * space(x)).grade(1) if attitude.grades == (2,) else -attitude


def carriers(x: Multivector, sign: Multivector) -> list[Multivector]:
    """The points and flats that move with x, turned round where the sign is -1; points have no orientation."""
    if x.grades == (1,):
        return [x]
    if is_flat(x):
        return [sign * x]
    middle = point(center(x)).grade(1)
    return [middle] if x.grades == (4,) else [middle, sign * (middle ^ direction(x) ^ infinity(x)).grade(3)]


def element(x: Multivector) -> Result:
    """Position (3), direction (3) and radius (1): of flats the point nearest to the origin; zeros for what is not."""
    place = anchor(x) if is_flat(x) else center(x)
    along = coordinates(direction(x)) if direction(x).terms else [x.constant(0)] * 3
    bent = x.constant(0)
    if x.grades != (1,) and not is_flat(x):
        bent = 1 / sqrt(norm_squared(curvature(x)))
    return row([*coordinates(place), *along, bent], "element")


def moved_element(r: Multivector, x: Multivector) -> Result:
    """`element` of R x ~R."""
    return element((r >> x).grade(*x.grades))


# -- elements: position, direction and radius as numbers -------------------------------------------------------


class Element(NamedTuple):
    """Position, direction and radius of an object (`element`)."""

    e1: Multivector
    e2: Multivector
    e3: Multivector
    along_e1: Multivector
    along_e2: Multivector
    along_e3: Multivector
    radius: Multivector


class Weights(NamedTuple):
    """Factors of squared differences of positions, of 1 - cos, and of squared differences of radii."""

    position: Multivector
    direction: Multivector
    radius: Multivector


def apart(
    a: Element, b: Element, weights: Weights, whole: Multivector, other: Multivector
) -> tuple[Result, Result]:  # fmt: skip
    """Weighted square of how far two elements are apart, and the cosine of the angle between their directions.

    ``whole`` is 1 for kinds that have a direction, else 0; ``other`` is -1 where x and -x are one, else 1.
    """
    between, size = vector(b[:3]) - vector(a[:3]), b.radius - a.radius
    cosine = (vector(a[3:6]) * vector(b[3:6])).grade(0)
    turned, nothing = other * cosine, whole.constant(0)
    away = whole - select(turned > cosine, turned, cosine)
    turn = select(away > nothing, away, nothing)  # rounding leaves no negative ones
    total = weights.position * (between * between).grade(0) + weights.direction * turn + weights.radius * (size * size)
    return row([total], "square"), row([cosine], "cosine")


def off_position(p: Multivector, a: Element) -> tuple[Result, Result, Result]:
    """|p - a|^2 for a position p, half its gradient by p, and half its second rates (upper half)."""
    return _off(p - vector(a[:3]), lambda v: v)


def off_line(p: Multivector, a: Element) -> tuple[Result, Result, Result]:
    """The square of the distance of p from the line of an element, half its gradient by p, half its second rates."""
    return _off(p - vector(a[:3]), lambda v: v ^ vector(a[3:6]))


def off_plane(p: Multivector, a: Element) -> tuple[Result, Result, Result]:
    """The square of the distance of p from the plane of an element, half its gradient by p, half its second rates."""
    return _off(p - vector(a[:3]), lambda v: v | vector(a[3:6]))


def _off(between: Multivector, part: Callable[[Multivector], Multivector]) -> tuple[Result, Result, Result]:
    """Square of a linear function of a difference of positions, with its gradient and second rates, halved."""

    def form(u: Multivector, v: Multivector) -> Multivector:
        return (part(u) * ~part(v)).grade(0)

    basis = axes(between)
    gradient, matrix = [form(e, between) for e in basis], [form(e, f) for i, e in enumerate(basis) for f in basis[i:]]
    return row([form(between, between)], "square"), row(gradient, "gradient"), row(matrix, "matrix")


# -- segments: two ends of a stretch of a line -------------------------------------------------------------


def ends_apart(a: Multivector, b: Multivector, c: Multivector, d: Multivector) -> tuple[Result, Result]:
    """How far the segments a b and c d are from stretches of one line: the mean square of the distances of the ends of
    the shorter from the line of the longer, and how far the shorter sticks out of the longer along the latter.
    """
    first, second = b - a, d - c
    lengths = [(v * v).grade(0) for v in (first, second)]
    squares = [
        sum_of_squares([(p - q) ^ along for p in ends]) / (2 * square)
        for ends, q, along, square in (((c, d), a, first, lengths[0]), ((a, b), c, second, lengths[1]))
    ]
    is_longer = lengths[0] > lengths[1]
    square = select(is_longer, squares[0], squares[1])
    along = select(is_longer, *(v / sqrt(s) for v, s in zip((first, second), lengths, strict=True)))
    middles = absolute(((a + b - c - d) | along).grade(0)) / 2
    halves = absolute(absolute((first | along).grade(0)) - absolute((second | along).grade(0))) / 2
    out = middles - halves
    nothing = out.constant(0)
    return row([square], "square"), row([select(out > nothing, out, nothing)], "out")


def sum_of_squares(parts: list[Multivector]) -> Multivector:
    """Sum of the squared norms of Euclidean blades."""
    total = (parts[0] * ~parts[0]).grade(0)
    for x in parts[1:]:
        total = total + (x * ~x).grade(0)
    return total


# -- frames: models as seen from a position ----------------------------------------------------------------


def coefficients_at(x: Multivector, o: Multivector) -> Result:
    """Coefficients of an object, on its own blades, as seen from the position o: `local.inward`."""
    y = inward(x, o)
    return row([y.new({0: y.terms[b]} if b in y.terms else {}) for b in x.terms], "seen")


def unseen(r: Multivector, to: Multivector, back: Multivector) -> Multivector:
    """A motor from a frame about the position ``back`` to one about ``to`` as a motor of the world; the first
    coefficient that is not zero is positive.
    """
    moved = (translator(to) * r * translator(-back)).grade(0, 2, 4)
    return canonical_sign(moved) * moved


def unseen_twist(b: Multivector, o: Multivector) -> Multivector:
    """A twist of the frame about o as a twist of the world."""
    return (translator(o) >> b).grade(2)


# -- the motor of some pairs -------------------------------------------------------------------------------


def motor_form(x: Multivector, y: Multivector, sign: Multivector) -> Result:
    """Coefficients A_kl, k <= l, of the quadratic form |R X - Y R|^2 in R, for the carriers X of x, Y of (sign) y.

    It is zero for the motor that takes the carriers over. |.|^2 is `costs.magnitude`, k that of `motor_blades`.
    """
    total: list[Multivector] | None = None
    basis = [x.new({b: x.ring.constant(Fraction(1))}) for b in motor_blades(x.algebra)]
    for a, b in zip(carriers(x, x.constant(1)), carriers(y, sign), strict=True):
        errors = [e * a - b * e for e in basis]
        form = [positive_product(p, q) for i, p in enumerate(errors) for q in errors[i:]]
        total = form if total is None else [u + v for u, v in zip(total, form, strict=True)]
    assert total is not None
    return row(total, "form")


def near_motor(r: Multivector) -> Multivector:
    """(r ~r)^(-1/2) r: the motor next to any multivector on a motor's blades."""
    square = r * ~r
    s0, s4 = square.grade(0), square.grade(4)
    return ((1 - s4 / (2 * s0)) * r / sqrt(s0)).grade(0, 2, 4)


def step_motor(r: Multivector, b: Multivector) -> Multivector:
    """The motor next to (1 + b) R: exp(b) R to first order in the twist b."""
    return near_motor((1 + b) * r)


# -- what does not change with the motor -------------------------------------------------------------------


def pair_invariants(x: Multivector, y: Multivector) -> Result:
    """Four numbers of two objects that no motor changes, zeros where there are fewer; but for the second one they are
    the same for x or y turned round.

    The distance between their positions, or of a position from a flat, or `line_twist` of two lines; cos of the angle
    between their directions; for two rounds how far along their axes the other one lies; for a round and a line the
    `line_twist` of its axis and that line.
    """
    nothing = x.constant(0)
    places = [center(a) if not is_flat(a) else None for a in (x, y)]
    along = [direction(a) for a in (x, y)]
    cosine = (along[0] * along[1]).grade(0) if along[0].terms and along[1].terms else None
    first = second = third = nothing
    if places[0] is not None and places[1] is not None:
        between = places[1] - places[0]
        first = sqrt((between * between).grade(0))
        second, third = (absolute((between * d).grade(0)) if d.terms else nothing for d in along)
    elif places[0] is not None or places[1] is not None:
        place, flat = (places[0], y) if places[0] is not None else (places[1], x)
        assert place is not None
        first = _distance(point(place), flat)
        if cosine is not None and flat.grades == (3,):
            axis, line = (carriers(a, x.constant(1))[-1] for a in (x, y))
            second = line_twist(axis, line, cosine)
    elif x.grades == y.grades == (3,):
        assert cosine is not None
        first = line_twist(x, y, cosine)
    return row([first, cosine if cosine is not None else nothing, second, third], "invariants")


def line_twist(x: Multivector, y: Multivector, cosine: Multivector) -> Multivector:
    """Distance between two unit lines times sin of their angle, the same for either turned round: positive where the
    way from one to the other is a right-handed screw, by the angle that is no more than a right one."""
    twist = (attached_part((x * y).grade(4)) * ~space(x)).grade(0)
    return select(cosine < 0, x.constant(-1), x.constant(1)) * twist


def _distance(p: Multivector, flat: Multivector) -> Multivector:
    """Distance of a point from a unit flat: the unit flat through both is as large as they are far apart."""
    joint = p ^ flat
    return absolute(joint.dual().grade(0)) if joint.grades == (5,) else sqrt(absolute(norm_squared(joint)))


# -- least cost --------------------------------------------------------------------------------------------


def moved_rates(r: Multivector, x: Multivector, y: Multivector) -> tuple[Result, Result, Result]:
    """`cost_rates` of R x ~R and y."""
    return cost_rates((r >> x).grade(*x.grades), y)


def cost_rates(x: Multivector, y: Multivector) -> tuple[Result, Result, Result]:
    """Positive cost from x to y or -y, its gradient and its Gauss-Newton matrix (upper half) by b in exp(b) x exp(-b).

    The cost is a sum of squares, of R - 1 and of R . e_+; so its matrix is twice that of their rates.
    """
    rotor, rates = rotor_rates(x, y)
    error = rotor - 1
    cost = positive_product(error, error) + positive_product(parallel(rotor), parallel(rotor))
    gradient = [2 * (positive_product(error, d) + positive_product(parallel(rotor), parallel(d))) for d in rates]
    matrix = [
        2 * (positive_product(p, q) + positive_product(parallel(p), parallel(q)))
        for i, p in enumerate(rates)
        for q in rates[i:]
    ]
    return row([cost], "cost"), row(gradient, "gradient"), row(matrix, "matrix")


def vector_rates(r: Multivector, x: Multivector) -> tuple[Result, Result]:
    """Coordinates of R x ~R for a point or a direction x, and their rates (6 x 3) by b in exp(b) R."""
    basis = [x.new({b: x.ring.constant(Fraction(1))}) for b in x.algebra.kind("twist").blades]
    moved = (r >> x).grade(1)
    rates = [c for e in basis for c in coordinates(euclidean_part((e * moved - moved * e).grade(1)))]
    return row(coordinates(euclidean_part(moved)), "moved"), row(rates, "rates")


def position_rates(r: Multivector, p: Multivector) -> tuple[Result, Result]:
    """`vector_rates` of the point at a position."""
    return vector_rates(r, point(p).grade(1))


def rotor_rates(x: Multivector, y: Multivector) -> tuple[Multivector, list[Multivector]]:
    """The rotor from x to y or -y, NaN where it needs care, and its rates by the twist b in exp(b) x exp(-b)."""
    basis = [x.new({b: x.ring.constant(Fraction(1))}) for b in x.algebra.kind("twist").blades]
    near = align(y, x)
    plain = x.constant(1) if x.grades == (1,) else where_or_nan(is_plain(x, near), x.constant(1))
    rotor = plain * any_rotor(x, near)
    rate_of = derivative_formula(any_rotor, ["x", "y"], "x", is_scalar=False)
    return rotor, [rate_of(x, near, (e * x - x * e).grade(*x.grades))[0].values[0] for e in basis]
