"""Maps from twist bivectors to motors, and their rates (thesis 6.11). The formulas are in `codegen.formulas.maps`."""

from __future__ import annotations

import numpy as np

from ..arrays import truth
from ..calls import call, finite, merged, raise_first
from ..multivector import Multivector
from ..objects.inputs import chosen
from .screws import as_screw, same_algebra

MAPS = ("exponential", "bortz", "cayley", "outer")
FRAMES = ("world", "body")
#: Forms of the exponential's rate: the one that is used, and those of the thesis, to compare with.
FORMS = ("dual", "series", "split")


def map_motor(phi: Multivector, map: str = "exponential", strict: bool = False) -> Multivector:
    """The motor of a twist bivector Phi.

    Parameters
    ----------
    phi : Multivector, shape (...)
        Twist bivectors w I3 + v n of CGA or PGA.
    map : str
        "exponential": exp(-Phi/2), a screw motion by the angle |w|. "bortz": the same on orientations, with the place
        of the origin beside it: (1 - v n/2) exp(-w I3/2). "cayley": (1 - Phi)(1 + Phi)^-1, near exp(-2 Phi), with
        |w| = tan(angle/4). "outer": (1 + Phi + Phi ^ Phi/2)/sqrt(1 + w^2), near exp(Phi), with |w| = tan(angle/2).

    Returns
    -------
    Multivector, shape (...)
        Unit motors. `INVALID`: not finite.

    Notes
    -----
    (6.25), (6.26) and (6.28); each map has the scale that the thesis gives it. The charts of the simulations are scaled
    alike.
    """
    x = as_screw(phi, "Phi")
    motor = finite(call(x.algebra, f"maps.{chosen(map, MAPS, 'map')}_motor", x).value)
    if truth(strict, "strict"):
        raise_first(motor._status, "map_motor")
    return motor


def map_rate(
    phi: Multivector,
    twist: Multivector,
    map: str = "exponential",
    frame: str = "world",
    form: str = "dual",
    strict: bool = False,
) -> Multivector:
    """The rate of Phi while the motor of `map_motor` moves with a twist.

    Parameters
    ----------
    phi, twist : Multivector, shapes broadcasting to (...)
        Phi, and the twist Omega: dR = -Omega R/2 in the world's frame, dR = -R Omega/2 in the body's.
    map : str
        As of `map_motor`.
    frame : "world" or "body"
        Which of the two the twist is.
    form : "dual", "series" or "split"
        Of the exponential's rate, which all give the same: in two commutators with dual numbers as coefficients, in
        four as (6.24) has it, or by parts along and across the plane of rotation as in the set after (6.25), mended.
        The series loses digits near full turns, the split form those of angles near 0.

    Returns
    -------
    Multivector, shape (...)
        dPhi. `SINGULAR`: exponential and bortz at full turns (of the split form, also where nothing turns). Cayley's
        map is singular at full turns too, the outer exponential at half turns, where Phi is infinite.
    """
    name, side = chosen(map, MAPS, "map"), chosen(frame, FRAMES, "frame")
    x, omega = as_screw(phi, "Phi"), as_screw(twist, "the twist")
    same_algebra(x, omega)
    formula = f"maps.{name}_rate_{side}"
    if chosen(form, FORMS, "form") != "dual":
        chosen(name, ("exponential",), f"map with form {form!r}")
        formula = f"map_forms.{form}_rate_{side}"
    outcome = call(x.algebra, formula, x, omega)
    rate = outcome.value
    invalid = merged(*(s if s is None else np.broadcast_to(s, rate.shape) for s in (x._status, omega._status)))
    rate = finite(rate._make(rate._type, rate._data, rate.shape, merged(invalid, outcome.status)))
    if truth(strict, "strict"):
        raise_first(rate._status, "map_rate")
    return rate


__all__ = ["FORMS", "FRAMES", "MAPS", "map_motor", "map_rate"]
