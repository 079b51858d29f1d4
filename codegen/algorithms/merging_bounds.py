"""Landmarks of objects, and the least cost that the landmarks of two objects leave possible.

R takes X1 to X2 (or to -X2) along the shortest way: R X1 = X2 R, R^2 = P = +-X2 X1^-1. |A| is the norm of the
coefficients on the orthonormal basis, in which |A B| <= 2 |A| |B| (twice as large is the norm of the 4 x 4 matrix
that A stands for, and that is no less than the operator's norm). The cost is |R - 1|^2 + |R . e_+|^2.

Flats and points. R is a screw: an angle t about an axis a at the distance q from the origin, a shift d along it.
The cost is 4 sin^2(t/4) + 3 (q^2 sin^2(t/2) + d^2/4), for what has n_inf as a factor counts three times. The
directions differ by 2 sin(t/2) <= 4 sin(t/4). The points p of both objects next to the origin, projected along a,
lie on the circle of diameter q from the origin to the axis (Thales), and see the angle t: they differ by
q sin t <= 2 q sin(t/2) across a and by d along it. Hence

    cost >= |m2 - m1|^2/4 + 3 |p2 - p1|^2/4,

with equality for translations, and nearly so for small angles. For points R is the translator.

Rounds. Give n0 the weight -1 and n_inf +1; products add weights, and translations only raise them, so the part of
least weight of P - 1 does not change if both objects are moved. With the first centred at the origin,
X1 = (n0 + r^2/2 n_inf) ^ A1, that part is n0 times a product of A1, A2 and the difference of the centres, of the
norm |c2 - c1|/(sqrt(2) r1 r2). Of a round and a flat it is 1/(sqrt(2) r). The inversion in the unit sphere keeps
all norms, so the same holds of centres and radii of the inverses. P - 1 = (R - 1)(2 + (R - 1)) gives

    |P - 1| <= 2 d + 2 d^2,  d = |R - 1|, so  cost >= d^2 >= ((sqrt(1 + 2 |P - 1|) - 1)/2)^2.

That leaves out how rounds are turned. For all: X2 - X1 = (R - 1) X1 - X2 (R - 1), and so

    cost >= (|X2 - X1|/(N1 + N2))^2,  N the operator's norm: N^2 = |X|^2 + sqrt(|X|^4 - 1) for a unit blade, which

is a unit blade of Euclidean vectors times a single vector with a part along e_-, or the dual of such a one.
"""

from __future__ import annotations

from ..ir.loops.algorithm import Algorithm as algorithm
from ..ir.loops.language import Int, Real, Static, Vector, sqrt
from .merging_layout import COEFFICIENTS, CURVATURE, DIRECTION, FLAT_MARKS, INVERSE, INVERSE_CURVATURE, NORM

#: Weights of squares in the cost, see above.
OF_POSITION = 0.75
OF_DIRECTION = 0.25
#: Bounds and costs are rounded,
SURELY = 1.0 - 1e-9
#: and coefficients and landmarks, relative to their size.
NOISE = 64 * 2.0**-52
#: Rounds whose radii differ more are parted by radius before position.
RADII = 8.0


@algorithm
def gap_squared(x: Vector, sign: Real, least: Vector, most: Vector) -> Real:
    """Square of the distance of sign * x from a box."""
    total = 0.0
    for i in range(len(x)):
        gap = max(0.0, max(sign * x[i] - most[i], least[i] - sign * x[i]))
        total += gap * gap
    return total


@algorithm
def gap_of_axis(x: Vector, least: Vector, most: Vector) -> Real:
    """`gap_squared` of whichever of x and -x is nearer."""
    same = gap_squared(x, 1.0, least, most)
    turned = gap_squared(x, -1.0, least, most)
    return min(turned, same)


@algorithm
def least_flat_cost(x: Vector, least: Vector, most: Vector, slack: Real) -> Real:
    """`least_cost` of flats and points."""
    distance = max(0.0, sqrt(gap_squared(x[:DIRECTION], 1.0, least[:DIRECTION], most[:DIRECTION])) - slack)
    directions = gap_of_axis(x[DIRECTION:CURVATURE], least[DIRECTION:CURVATURE], most[DIRECTION:CURVATURE])
    return OF_POSITION * distance * distance + OF_DIRECTION * directions


@algorithm
def least_round_cost(x: Vector, least: Vector, most: Vector) -> Real:
    """`least_cost` of rounds and flats among them."""
    own, flattest, roundest = x[CURVATURE], least[CURVATURE], most[CURVATURE]
    norms = x[NORM] * most[NORM]
    defect = 0.0
    if own > 0.0 and flattest > 0.0:
        defect = sqrt(gap_squared(x[:DIRECTION], 1.0, least[:DIRECTION], most[:DIRECTION])) * own * flattest
    elif own == 0.0:
        defect = flattest
    elif roundest == 0.0:
        defect = own
    product = x[INVERSE_CURVATURE] * least[INVERSE_CURVATURE]
    if product > 0.0:
        inverse = gap_squared(
            x[INVERSE:INVERSE_CURVATURE], 1.0, least[INVERSE:INVERSE_CURVATURE], most[INVERSE:INVERSE_CURVATURE]
        )
        defect = max(defect, product * sqrt(inverse))
    defect = max(0.0, sqrt(0.5) * defect - NOISE * norms)
    by_place = (sqrt(1.0 + 2.0 * defect) - 1.0) / 2.0
    apart = sqrt(gap_of_axis(x[COEFFICIENTS:], least[COEFFICIENTS:], most[COEFFICIENTS:]))
    by_coefficients = max(0.0, apart / (x[NORM] + most[NORM]) - NOISE)
    d = max(by_coefficients, by_place)
    return d * d


@algorithm
def least_cost(x: Vector, least: Vector, most: Vector, slack: Real) -> Real:
    """No object whose landmark is in a box can have a lower cost with the object of landmark x.

    ``slack``: the rounding of positions, as a length.
    """
    if len(x) == FLAT_MARKS or (x[CURVATURE] == 0.0 and most[CURVATURE] == 0.0):
        return SURELY * least_flat_cost(x[:FLAT_MARKS], least[:FLAT_MARKS], most[:FLAT_MARKS], slack)
    return SURELY * least_round_cost(x, least, most)


@algorithm
def rounding_cost(x: Vector) -> Real:
    """A cost of this object that may be all rounding: of a motor at its distance, of products of its coefficients."""
    size = 1.0 + x[0] * x[0] + x[1] * x[1] + x[2] * x[2]
    if len(x) > FLAT_MARKS and x[NORM] > 1.0:
        size = x[NORM] * x[NORM] * x[NORM] * x[NORM]
    return NOISE * NOISE * size


@algorithm
def wider(
    least: Vector, most: Vector, begin: Static, end: Static, unit: Real, axis: Int, width: Real
) -> tuple[Int, Real]:
    """The widest of some parts of landmarks in units of the cost's root, and its width, if that is more than before."""
    for i in range(begin, end):
        w = unit * (most[i] - least[i])
        if w > width:
            width = w
            axis = i
    return axis, width


@algorithm
def widest(least: Vector, most: Vector) -> Int:
    """The part of the landmarks by which to part the objects of a box."""
    axis: Int = 0
    if most[CURVATURE] > RADII * least[CURVATURE]:
        return CURVATURE
    width = 0.0
    if most[CURVATURE] == 0.0:
        axis, width = wider(least, most, 0, DIRECTION, sqrt(OF_POSITION), axis, width)
        axis, width = wider(least, most, DIRECTION, CURVATURE, sqrt(OF_DIRECTION), axis, width)
        return axis
    if len(least) > FLAT_MARKS:
        curved = least[CURVATURE] * most[CURVATURE]
        inverse = least[INVERSE_CURVATURE] * most[INVERSE_CURVATURE]
        axis, width = wider(least, most, 0, DIRECTION, sqrt(0.125) * curved, axis, width)
        axis, width = wider(least, most, INVERSE, INVERSE_CURVATURE, sqrt(0.125) * inverse, axis, width)
        axis, width = wider(least, most, COEFFICIENTS, len(least), 0.5 / most[NORM], axis, width)
    return axis
