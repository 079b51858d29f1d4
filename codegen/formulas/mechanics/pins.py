"""Objects that are pinned between a body and the world, or another body (thesis 6.7 to 6.10): rates for the driver.

Rows of numbers stand for multivectors on the blades of the pinned object, in their order.
"""

from __future__ import annotations

from ...algebra.multivector import Multivector
from ...trace.outputs import Result, named, row
from .mechanics import adjoint, basis_twists, bracket, coefficient, covector, to_body_frame


def body_object(r: Multivector, v: Multivector) -> Result:
    """U = ~R V R: an object of the world as the body sees it (6.7)."""
    return _row(~r >> v, v, "u")


def moved_rate(u: Multivector, omega: Multivector) -> Result:
    """U x Omega: how an object that is fixed to the body moves."""
    return _row(u.commutator(omega), u, "rate")


def moved_rates(u: Multivector) -> Result:
    """U x E for each unit twist E, one after the other: U x Omega is linear in Omega."""
    rates = [u.commutator(e) for e in basis_twists(u)]
    return row([coefficient(x, blade) for x in rates for blade in u.terms], "rates")


def turned_rate(u: Multivector, omega: Multivector) -> Result:
    """(U x Omega) x Omega = Omega^2 U/4 + U Omega^2/4 - Omega U Omega/2 ((6.21), its last sign mended)."""
    return _row(u.commutator(omega).commutator(omega), u, "turned")


def held_rates(r: Multivector, omega: Multivector, v: Multivector) -> tuple[Result, Result]:
    """`moved_rates` and `turned_rate` of what is pinned."""
    u = _restrict(~r >> v, v)
    return moved_rates(u), turned_rate(u, omega)


def relation(
    r: Multivector, omega: Multivector, s: Multivector, psi: Multivector
) -> tuple[Result, Result, Result, Result]:
    """A body as another one sees it: ~S R, its twist there, the bracket of the other's twist with that, `adjoint`."""
    motor = ~s * r
    carried = to_body_frame(motor, psi)
    own = omega - carried
    bend = _row(bracket(carried, own), omega, "bend")
    return named("motor", motor), _row(own, omega, "own"), bend, adjoint(motor)


def held_power(r: Multivector, v: Multivector) -> Result:
    """Power of a wrench of the world on each unit twist of the body."""
    return row(covector(to_body_frame(r, v)), "power")


def path_rates(
    r: Multivector, omega: Multivector, v: Multivector, dv: Multivector, ddv: Multivector
) -> tuple[Result, Result]:
    """b(dV) and (U x Omega) x Omega + b(ddV) - 2 b(dV) x Omega of a moving object, b(X) = ~R X R (6.9).

    dU = b(dV) - U x Omega, and U x dOmega is the second one less ddU.
    """
    u, du, ddu = (_restrict(~r >> x, v) for x in (v, dv, ddv))
    acceleration = u.commutator(omega).commutator(omega) + ddu - 2 * du.commutator(omega)
    return _row(du, v, "rate"), _row(acceleration, v, "acceleration")


def _restrict(x: Multivector, like: Multivector) -> Multivector:
    return x.new({b: c for b, c in x.terms.items() if b in like.terms})


def _row(x: Multivector, like: Multivector, name: str) -> Result:
    return row([coefficient(x, blade) for blade in like.terms], name)
