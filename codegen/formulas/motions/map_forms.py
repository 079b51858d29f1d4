"""The exponential map's rate as the thesis has it (6.11.1), mended: the series of commutators and the split form.

They are there to be compared with: `maps` has the form that is used, which is shorter and keeps its digits. Near a full
turn the series is the difference of large terms; the split form divides by the angle.
"""

from __future__ import annotations

from ...algebra.multivector import Multivector, absolute, cos, sin, sqrt
from ...status import Status
from ..objects.euclidean import attached_part, euclidean_part, null_vector
from ..products.outcome import NOISE, epsilon, outcome, where_or_nan
from .maps import Rate, bend, exponential_motor, square_parts


def series_rate_world(phi: Multivector, omega: Multivector) -> Rate:
    """omega + A omega/2 + c2 A^2 omega + c4 A^4 omega, A = phi x . (6.24), for exp(-phi/2)."""
    return _series(phi, omega, 1)


def series_rate_body(phi: Multivector, omega: Multivector) -> Rate:
    """The same with - A omega/2, for the body's twist."""
    return _series(phi, omega, -1)


def _series(phi: Multivector, omega: Multivector, side: int) -> Rate:
    """With k(w) = (1 - h cot h)/w, h = sqrt(w)/2: c4 = -k' and c2 = k - w k'. (As printed they cancel near 0.)"""
    w, _ = square_parts(phi)
    k = bend(w)
    powers = [omega]
    for _ in range(4):
        powers.append(phi.commutator(powers[-1]))
    return omega + side * powers[1] / 2 + (k.value - w * k.slope) * powers[2] - k.slope * powers[4], k.status


def split_rate_world(phi: Multivector, omega: Multivector) -> Rate:
    """`split_rate_body` of the twist as the body sees it."""
    return split_rate_body(phi, (~exponential_motor(phi) >> omega).grade(2))


def split_rate_body(phi: Multivector, omega: Multivector) -> Rate:
    """d(alpha B + t n) for exp(-phi/2), by the parts of t in and across the plane B (the set after (6.25), mended).

    SINGULAR: no rotation, or a full turn.
    """
    turn, n = euclidean_part(phi), null_vector(phi)
    alpha = sqrt(-(turn * turn).grade(0))
    c, s = cos(alpha / 2), sin(alpha / 2)
    regular = (alpha > 0) & ((c > 0) | (absolute(s) > NOISE * epsilon(phi)))
    plane = turn / where_or_nan(regular, alpha)
    own, r = c - plane * s, exponential_motor(phi)
    spin = euclidean_part(omega)
    d_own, d_r = -(own * spin) / 2, -(r * omega) / 2
    d_alpha = -plane.scalar_product(spin)
    along = spin.scalar_product(plane)
    d_plane = c / (2 * s) * (spin + along * plane) - plane.commutator(spin) / 2

    d = -2 * attached_part(r * ~own).grade(1)
    d_d = -2 * attached_part(d_r * ~own + r * ~d_own).grade(1)
    swept = (plane * d * plane).grade(1)
    d_swept = (d_plane * d * plane + plane * d_d * plane + plane * d * d_plane).grade(1)
    inside, d_inside = (d + swept) / 2, (d_d + d_swept) / 2
    shift = inside * own
    d_shift = d_alpha * shift / (2 * s) + alpha * (d_inside * own + inside * d_own) / (2 * s)
    d_shift = d_shift - alpha * d_alpha * c / (4 * s * s) * shift
    d_t = (d_shift + (d_d - d_swept) / 2).grade(1)
    return d_alpha * plane + alpha * d_plane + d_t * n, outcome(phi, (~regular, Status.SINGULAR))
