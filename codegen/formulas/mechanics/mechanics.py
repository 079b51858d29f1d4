"""A rigid body in motion: rates of its motor, momentum, and the wrenches that act on it (thesis 6.3 to 6.5).

X = R X' ~R takes the body's frame to the world's. A twist is w I3 + v n, dX = X x Omega; a wrench f I3 + tau n, tau
about the frame's origin. Linear functions of twists stand as rows of six numbers, one for each of a twist's blades:
the row of a wrench holds its power on each of them, and no metric is needed to go back. One text for CGA and PGA.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Annotated, NamedTuple

from ...algebra.algebra import Algebra
from ...algebra.multivector import Multivector, select, sqrt
from ...trace.outputs import Result, named, row
from ...trace.rows import BladesOf
from ..motions.motions import translation_of
from ..motions.screws import direction_part
from ..objects.euclidean import attached_part, axes, cross, dot, euclidean_part, length, null_vector, space
from ..products.exponentials import exp_bivector

#: Numbers for each of a twist's blades.
Covector = Annotated[tuple[Multivector, ...], BladesOf("twist")]


class SpringLaw(NamedTuple):
    """Numbers of a spring with a damper along it."""

    stiffness: Multivector
    rest: Multivector
    damping: Multivector


def twist_blades(algebra: Algebra) -> tuple[int, ...]:
    """Blades of a twist, in the order of rows."""
    return algebra.kind("twist").blades


def basis_twists(like: Multivector) -> list[Multivector]:
    """A unit twist for each blade."""
    return [like.new({b: like.ring.constant(Fraction(1))}) for b in twist_blades(like.algebra)]


def power(twist: Multivector, wrench: Multivector) -> Multivector:
    """w . tau + v . f: the coefficient of I3 n in Omega ^ W."""
    volume = space(twist) * null_vector(twist)
    ((blade, sign),) = volume.terms.items()
    joint = (twist ^ wrench).terms.get(blade)
    return twist.new({} if joint is None else {0: twist.ring.multiply(sign, joint)})  # in PGA I3 e0 = -e0123


def covector(wrench: Multivector) -> list[Multivector]:
    """Power of a wrench on each unit twist."""
    return [power(e, wrench) for e in basis_twists(wrench)]


def of_covector(powers: Covector) -> Multivector:
    """The wrench with these powers: unit twists and unit wrenches pair off, up to signs."""
    like = powers[0]
    basis = basis_twists(like)
    return like.sum(c * power(e, f) * f for c, e in zip(powers, basis, strict=True) for f in basis)


# -- motion ------------------------------------------------------------------------------------------------


def motor_rate(r: Multivector, omega: Multivector) -> Multivector:
    """dR = -R Omega/2, Omega in the body's frame (6.6)."""
    return -(r * omega) / 2


def twist_of(r: Multivector, rate: Multivector) -> Multivector:
    """-2 ~R dR, the twist in the body's frame that moves a motor so: `motor_rate` read backwards."""
    return (-2 * (~r * rate)).grade(2)


def move_by_twist(r: Multivector, omega: Multivector) -> Multivector:
    """R exp(-Omega/2)."""
    return r * exp_bivector(-omega / 2)


def relative(r: Multivector, s: Multivector) -> Multivector:
    """~R S: the frame of S as seen from that of R."""
    return ~r * s


def to_body_frame(r: Multivector, screw: Multivector) -> Multivector:
    """~R S R: a screw of the world in the body's frame."""
    return (~r >> screw).grade(2)


def distance_of(r: Multivector) -> Multivector:
    """Distance of the frame's origin from the world's."""
    return length(translation_of(r))


def adjoint(r: Multivector) -> Result:
    """The matrix of S -> ~R S R on coefficients, row by row."""
    columns = [(~r >> e).grade(2) for e in basis_twists(r)]
    return row([coefficient(c, b) for b in twist_blades(r.algebra) for c in columns], "adjoint")


def coefficient(x: Multivector, blade: int) -> Multivector:
    """Coefficient of a blade, zero where x has none."""
    return x.new({0: x.terms[blade]} if blade in x.terms else {})


# -- momentum ----------------------------------------------------------------------------------------------


def gyroscopic(omega: Multivector, momentum: Covector) -> Result:
    """Omega x Psi, the wrench that turning a momentum takes: Q dOmega = W + Omega x Psi."""
    psi = of_covector(momentum)
    return row(covector(omega.commutator(psi).grade(2)), "gyroscopic")


def central_gyroscopic(omega: Multivector, momentum: Covector) -> Result:
    """`gyroscopic` in a frame at the center of mass.

    There Psi = m v I3 + L n, and v n x Psi = (v x m v) n is zero: left out, for its rounding is a torque too, which in
    fast flight of a small body is as large as those that turn it.
    """
    psi = of_covector(momentum)
    turning = direction_part(omega) * space(omega)
    return row(covector(turning.commutator(psi).grade(2)), "gyroscopic")


def covector_of(wrench: Multivector) -> Result:
    """`covector`, as a row."""
    return row(covector(wrench), "covector")


def world_wrench(r: Multivector, powers: Covector) -> Multivector:
    """R W ~R of the wrench with these powers in the body's frame."""
    return (r >> of_covector(powers)).grade(2)


def mass_matrix(mass: Multivector, moments: Multivector, frame: Multivector) -> Result:
    """Q (6.15): powers of Q(Omega) on unit twists, for each unit twist Omega, row by row.

    ``frame`` is the motor from the frame along the principal axes at the center of mass to the body's own; ``moments``
    is the vector of the moments of inertia about those axes, mass included.
    """
    momenta = [frame >> principal_momentum(mass, moments, (~frame >> e).grade(2)) for e in basis_twists(mass)]
    return row([entry for psi in momenta for entry in covector(psi.grade(2))], "matrix")


def screw_of(first: Multivector, second: Multivector) -> Multivector:
    """a I3 + b n of two vectors."""
    return first * space(first) + second * null_vector(first)


def screw_vectors(screw: Multivector) -> tuple[Result, Result]:
    """a and b of a I3 + b n."""
    return named("first", direction_part(screw)), named("second", attached_part(screw))


def momentum_in(frame: Multivector, mass: Multivector, moments: Multivector, omega: Multivector) -> Multivector:
    """Q(Omega) where a motor takes the frame of the principal axes to the one at hand (6.15)."""
    own = principal_momentum(mass, moments, (~frame >> omega).grade(2))
    return (frame >> own).grade(2)


def twist_in(frame: Multivector, mass: Multivector, moments: Multivector, psi: Multivector) -> Multivector:
    """Q^-1(Psi), likewise (6.16)."""
    own = (~frame >> psi).grade(2)
    angular = attached_part(own)
    inverse = own.sum(angular.scalar_product(e) / moments.scalar_product(e) * e for e in axes(own))
    return (frame >> (inverse * space(own) + direction_part(own) / mass * null_vector(own))).grade(2)


def principal_momentum(mass: Multivector, moments: Multivector, omega: Multivector) -> Multivector:
    """m v I3 + (I w) n along the principal axes at the center of mass."""
    w, v = direction_part(omega), attached_part(omega)
    return mass * v * space(omega) + componentwise_product(moments, w) * null_vector(omega)


def componentwise_product(a: Multivector, b: Multivector) -> Multivector:
    """Products of the coordinates of two vectors."""
    return a.sum(a.scalar_product(e) * b.scalar_product(e) * e for e in axes(b))


def bracket(a: Multivector, b: Multivector) -> Multivector:
    """A x B of screws."""
    return a.commutator(b).grade(2)


# -- loads -------------------------------------------------------------------------------------------------


def pull(r: Multivector, center: Multivector, weight: Multivector) -> Result:
    """A force that is the same all over the world, as weight is, through a point of the body."""
    force = (~euclidean_part(r) >> weight).grade(1)
    return row(covector(wrench_at(force, center)), "pull")


def wrench_at(force: Multivector, position: Multivector) -> Multivector:
    """f I3 + (p x f) n."""
    return screw_of(force, cross(position, force))


def wrench_to_body(r: Multivector, wrench: Multivector) -> Result:
    """A wrench of the world as the body sees it."""
    return row(covector(to_body_frame(r, wrench)), "carried")


def given_row(powers: Covector) -> Result:
    """A wrench that the body sees as it is given."""
    return row(list(powers), "given")


def velocity_at(omega: Multivector, position: Multivector) -> Multivector:
    """v + w x p."""
    return attached_part(omega) + cross(direction_part(omega), position)


def spring(
    r: Multivector, omega: Multivector, point: Multivector, s: Multivector, psi: Multivector, other_point: Multivector,
    law: SpringLaw,
) -> tuple[Result, Result]:  # fmt: skip
    """Spring and damper between points of two bodies: stiffness, length at rest, damping along it.

    Forces on both. Where both points are one, a spring that has a length at rest has no direction: it pulls nowhere.
    """
    stiffness, rest, damping = law
    turns = [euclidean_part(r), euclidean_part(s)]
    gap = spring_gap(r, point, s, other_point)
    rate = (turns[1] >> velocity_at(psi, other_point)).grade(1) - (turns[0] >> velocity_at(omega, point)).grade(1)
    square = dot(gap, gap)
    long = square > 0
    inverse = select(long, 1 / sqrt(select(long, square, square.constant(1))), square.constant(0))
    force = (stiffness * (1 - rest * inverse) + damping * dot(rate, gap) * inverse * inverse) * gap
    on_own, on_other = (~turns[0] >> force).grade(1), (~turns[1] >> -force).grade(1)
    return row(covector(wrench_at(on_own, point)), "wrench"), row(
        covector(wrench_at(on_other, other_point)), "other_wrench"
    )


def spring_gap(r: Multivector, point: Multivector, s: Multivector, other_point: Multivector) -> Multivector:
    """From a spring's point to its other one."""
    return moved_point(s, other_point) - moved_point(r, point)


def relative_twist(r: Multivector, omega: Multivector, s: Multivector, psi: Multivector) -> Multivector:
    """Twist of a body as another body sees it, in the frame of the first."""
    return omega - (relative(r, s) >> psi).grade(2)


def counter_wrench(r: Multivector, s: Multivector, powers: Covector) -> Result:
    """What acts on another body where a wrench with these powers acts on the first, in the frame of that other."""
    return row(covector(-(relative(s, r) >> of_covector(powers)).grade(2)), "counter")


def moved_point(r: Multivector, point: Multivector) -> Multivector:
    """Position of a body's point that was at a place, for the body at R."""
    return (euclidean_part(r) >> point).grade(1) + translation_of(r)
