"""Jacobians of the exponential and the logarithm of poses, on twists phi and as matrices on rows (w, v).

With ad = phi x . (of screws: less the commutator), a small change d of the twist moves exp(-phi/2) by the twist J d of
the world, J = (exp(ad) - 1)/ad, and by the body's twist J(-phi) d. Since ad^2 = -(w - q) on all that ad does not annul,
as in `maps`, its functions are those of dual numbers.
"""

from __future__ import annotations

from ...algebra.multivector import Multivector, select
from ...status import Status
from ...trace.outputs import Result, status
from ..motions.maps import bend, square_parts
from ..motions.twists import ScrewRow, screw_of_row
from ..products.outcome import is_finite
from .pose_maps import matrix_of_columns, unit_twists

Matrix = tuple[Result, Result]


def _stumpff(k: int, w: Multivector) -> Multivector:
    return w.new({0: w.ring.apply(f"stumpff{k}", w.scalar())})


def jacobian_on(phi: Multivector, twist: Multivector, side: int) -> Multivector:
    """d + c2 ad d + c3 ad^2 d with c(w - q) = c(w) - q c'(w), 2 c_k' = k c_(k+2) - c_(k+1); side -1: of -phi."""
    w, q = square_parts(phi)
    turned = -side * phi.commutator(twist)
    twice = -side * phi.commutator(turned)
    c2, c3, c4, c5 = (_stumpff(k, w) for k in (2, 3, 4, 5))
    slope2, slope3 = (2 * c4 - c3) / 2, (3 * c5 - c4) / 2
    lifted = (q * (slope2 * turned + slope3 * twice)).grade(2)
    return twist + c2 * turned + c3 * twice - lifted


def inverse_jacobian_on(phi: Multivector, twist: Multivector, side: int) -> tuple[Multivector, Result]:
    """d - ad d/2 + k ad^2 d, with k of `bend`. SINGULAR: a full turn. INVALID: not finite."""
    k = bend(square_parts(phi)[0])
    _, q = square_parts(phi)
    turned = phi.commutator(twist)
    twice = phi.commutator(turned)
    code = select(is_finite(phi), k.status.value, phi.constant(Status.INVALID))
    return twist + side * turned / 2 + k.value * twice - k.slope * (q * twice).grade(2), status(code)


def left_jacobian_matrix(twist: ScrewRow) -> Result:
    """Matrix (6, 6) of J on (w, v), row by row."""
    phi = screw_of_row(twist)
    return matrix_of_columns([jacobian_on(phi, e, 1) for e in unit_twists(phi)])


def right_jacobian_matrix(twist: ScrewRow) -> Result:
    """The same of J(-phi)."""
    phi = screw_of_row(twist)
    return matrix_of_columns([jacobian_on(phi, e, -1) for e in unit_twists(phi)])


def inverse_left_jacobian_matrix(twist: ScrewRow) -> Matrix:
    """The same of 1/J. SINGULAR: a full turn."""
    return _inverse_jacobian_matrix(twist, 1)


def inverse_right_jacobian_matrix(twist: ScrewRow) -> Matrix:
    """The same of 1/J(-phi). SINGULAR: a full turn."""
    return _inverse_jacobian_matrix(twist, -1)


def _inverse_jacobian_matrix(twist: ScrewRow, side: int) -> Matrix:
    phi = screw_of_row(twist)
    columns = [inverse_jacobian_on(phi, e, side) for e in unit_twists(phi)]
    return matrix_of_columns([column for column, _ in columns]), columns[0][1]
