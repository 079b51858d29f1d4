"""Means and landmarks for merging similar objects (thesis 3.12.2); costs are in `costs`.

A landmark is a few plain numbers of an object by which far ones are left out without their cost; which cost they
promise is said, and proved, in `algorithms.merging_bounds`.
"""

from __future__ import annotations

from ...algebra.multivector import Multivector, select, sqrt
from ...trace.outputs import Result, row
from ..products.outcome import where_or_nan
from .blades import Checked, norm_squared, project_sum, written_size
from .conformal import infinity, origin
from .costs import magnitude
from .euclidean import coordinates, euclidean_part, space
from .local import anchor, curvature


def mean_of_two(x1: Multivector, x2: Multivector, w1: Multivector, w2: Multivector) -> Checked:
    """S (w1 x1 + w2 x2), with the statuses of `blades.project_sum`."""
    a, b = w1 * x1, w2 * x2
    return project_sum(a + b, written_size(a, b))


def landmark(x: Multivector) -> Result:
    """Position (3), direction (3) and curvature (1) of a unit object; of kinds of rounds more.

    Rounds: center, zeros, 1/radius. Flats: the point nearest the origin, the unit direction of a line or normal of
    a plane (zeros for flat points), zero. Points: themselves, zeros, zero. Kinds of rounds have behind them position
    and curvature of the inverse in the unit sphere, the operator's norm, and the coefficients on the orthonormal basis.
    """
    nothing = [x.constant(0)] * 3
    if x.grades == (1,):
        return row([*coordinates(euclidean_part(x)), *nothing, x.constant(0)])
    foot, direction = anchor(x), _direction(x)
    if not curvature(x).terms:
        return row([*coordinates(foot), *direction, x.constant(0)])
    center, curved = _center(x, infinity(x))
    inverse_center, inverse_curved = _center(x, 2 * origin(x))  # the inversion takes n_inf and 2 n0 to each other
    is_round = curved > 0
    position = coordinates(select(is_round, center, foot))
    along = [select(is_round, x.constant(0), d) for d in direction]
    inverse_position = coordinates(select(inverse_curved > 0, inverse_center, x.new({})))
    on_orthonormal = [
        sqrt(magnitude(x.new({blade: x.constant(1).terms[0]}))) * x.new({0: c}) for blade, c in x.terms.items()
    ]
    return row(
        [*position, *along, curved, *inverse_position, inverse_curved, _operator_norm(on_orthonormal), *on_orthonormal]
    )


def _operator_norm(coefficients: list[Multivector]) -> Multivector:
    """N of a unit blade: N^2 = |X|^2 + sqrt(|X|^4 - 1)."""
    square = coefficients[0] * coefficients[0]
    for c in coefficients[1:]:
        square = square + c * c
    excess = square * square - 1
    return sqrt(square + select(excess > 0, sqrt(excess), square.constant(0)))


def _center(x: Multivector, n: Multivector) -> tuple[Multivector, Multivector]:
    """Center and 1/radius of a round where n stands for infinity; NaN and 0 for a flat there."""
    curved = sqrt(norm_squared(euclidean_part(n | x)))
    reflected = (n | x) | x
    return euclidean_part(reflected) / where_or_nan(curved > 0, -(reflected | n)), curved


def _direction(x: Multivector) -> list[Multivector]:
    """Attitude E of a flat (n0 + p) ^ E ^ n_inf: a vector, or the dual of a bivector; zeros for a number."""
    attitude = euclidean_part((origin(x) | x) | infinity(x))
    if attitude.grades == (2,):
        attitude = (attitude * space(x)).grade(1)
    return coordinates(attitude) if attitude.grades == (1,) else [x.constant(0)] * 3
