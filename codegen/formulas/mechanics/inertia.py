"""Inertia of a rigid body in any frame: the inverse and the rate of Q, matrices, and solids (thesis 6.4).

A body has a mass, moments about its principal axes (mass included, a vector) and a motor ``frame`` that takes the frame
along these axes at the center of mass to the one that twists and momenta are in. Q itself is `mechanics.momentum_in`.
"""

from __future__ import annotations

from ...algebra.multivector import Mask, Multivector
from ...status import Status
from ...trace.outputs import Result, named, row
from ..motions.motions import translation_of
from ..motions.twists import screw_row
from ..objects.euclidean import attached_part, axes, coordinates, dot, euclidean_part, null_vector, space
from ..products.frames import matrix_of
from ..products.outcome import outcome, where_or_nan
from .mechanics import bracket, momentum_in, power, principal_momentum, twist_in


def velocity(
    frame: Multivector, mass: Multivector, moments: Multivector, momentum: Multivector
) -> tuple[Multivector, Result]:
    """Q^-1(Psi) = R Q_B^-1(~R Psi R) ~R (6.15, 6.16). SINGULAR: a moment of inertia is zero."""
    moments, solid = _only_solid(moments)
    return twist_in(frame, mass, moments, momentum), outcome(mass, (~solid, Status.SINGULAR))


def _only_solid(moments: Multivector) -> tuple[Multivector, Mask]:
    """The moments, NaN where one is zero, and where none is."""
    solid = moments.constant(1) > 0
    for moment in coordinates(moments):
        solid = solid & (moment > 0)
    return where_or_nan(solid, moments.constant(1)) * moments, solid


def velocity_rate(
    frame: Multivector, mass: Multivector, moments: Multivector, momentum: Multivector, wrench: Multivector,
    twist: Multivector,
) -> tuple[Multivector, Result]:  # fmt: skip
    """d/dt of Q^-1(Psi) in a frame that moves with ``twist`` while dPsi = wrench: (6.17) with what it had lost.

    Q^-1(dPsi + Omega x Psi) + Q^-1(Psi) x Omega: dR = -Omega R/2 on both sides of Q_B^-1. For the body's own twist the
    last term vanishes: Euler's equations.
    """
    moments, solid = _only_solid(moments)
    carried = twist_in(frame, mass, moments, wrench + bracket(twist, momentum))
    rate = carried + bracket(twist_in(frame, mass, moments, momentum), twist)
    return rate, outcome(mass, (~solid, Status.SINGULAR))


def momentum_rate(
    frame: Multivector, mass: Multivector, moments: Multivector, velocity: Multivector, acceleration: Multivector,
    twist: Multivector,
) -> Multivector:  # fmt: skip
    """d/dt of Q(V) in a frame that moves with ``twist`` while dV = acceleration: Q(dV + Omega x V) + Q(V) x Omega."""
    carried = momentum_in(frame, mass, moments, acceleration + bracket(twist, velocity))
    return carried + bracket(momentum_in(frame, mass, moments, velocity), twist)


def energy(frame: Multivector, mass: Multivector, moments: Multivector, twist: Multivector) -> Multivector:
    """Half the power of Q(Omega) on Omega: (m u^2 + w . I w)/2 in the frame at the center of mass."""
    own = (~frame >> twist).grade(2)
    return power(own, principal_momentum(mass, moments, own)) / 2


# -- as matrices -------------------------------------------------------------------------------------------


def inertia_matrix(frame: Multivector, mass: Multivector, moments: Multivector) -> Result:
    """The matrix of Q from (w, v) to (f, tau), row by row (6.14)."""
    units = [e * space(mass) for e in axes(mass)] + [e * null_vector(mass) for e in axes(mass)]
    columns = [screw_row(momentum_in(frame, mass, moments, e)).values for e in units]
    return row([column[i] for i in range(6) for column in columns], "matrix")


def center_and_tensor(frame: Multivector, moments: Multivector) -> tuple[Result, Result]:
    """Center of mass, and the tensor about it along the axes of the frame, row by row."""
    turn = euclidean_part(frame)

    def angular(w: Multivector) -> Multivector:
        own = principal_momentum(w.constant(0), moments, (~turn >> w).grade(1) * space(w))
        return (turn >> attached_part(own)).grade(1)

    matrix = matrix_of(angular, axes(frame), axes(frame))
    return named("center", translation_of(frame)), row([m for entries in matrix for m in entries], "tensor")


def principal_screws(frame: Multivector) -> tuple[Result, ...]:
    """R e_i I3 ~R and R e_i n ~R: the lines of the principal axes, and the couples about them (6.4.4)."""
    lines = [frame >> (e * space(frame)) for e in axes(frame)]
    couples = [frame >> (e * null_vector(frame)) for e in axes(frame)]
    return tuple(named(f"screw{i}", x.grade(2)) for i, x in enumerate([*lines, *couples], 1))


# -- of solids ---------------------------------------------------------------------------------------------


def tetrahedron(a: Multivector, b: Multivector, c: Multivector) -> tuple[Result, Result, Result]:
    """Volume and moments of the tetrahedron of a triangle and the origin, signed by the side that the triangle shows.

    Six volumes are a ^ b ^ c; its center is at s/4, s = a + b + c, and the integral of x (x . y) is
    V/20 (a (a . y) + b (b . y) + c (c . y) + s (s . y)). (Row by row.)
    """
    volume = ((a ^ b ^ c) * ~space(a)).grade(0) / 6
    total = a + b + c
    matrix = matrix_of(lambda y: a.sum(x * dot(x, y) for x in (a, b, c, total)), axes(a), axes(a))
    second = [volume * entry / 20 for entries in matrix for entry in entries]
    return named("volume", volume), named("first", volume * total / 4), row(second, "second")
