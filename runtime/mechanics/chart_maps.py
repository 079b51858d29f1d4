"""Maps from twist bivectors to motors, and their rates (thesis 6.11). The formulas are in `formulas.motions.maps`."""

from __future__ import annotations

import numpy as np

from ..common.validation import as_bool, as_choice
from ..core.multivector import Multivector
from ..dispatch.formulas import evaluate
from ..dispatch.item_statuses import invalidate_nonfinite, merge_statuses, raise_first
from .screws import as_screw, same_algebra

MAPS = ("exponential", "bortz", "cayley", "outer")
FRAMES = ("world", "body")
#: Formulas of the exponential's rate: the one that is used, and those of the thesis, for comparison.
FORMS = ("dual", "series", "split")


def map_motor(phi: Multivector, map: str = "exponential", strict: bool = False) -> Multivector:
    """Motor of a twist bivector Phi.

    Parameters
    ----------
    phi : Multivector, shape (...)
        Twist bivectors w I3 + v n of CGA or PGA.
    map : str
        "exponential": exp(-Phi/2), a screw motion by the angle ``|w|``. "bortz": the same on orientations, with the
        position of the origin separate: (1 - v n/2) exp(-w I3/2). "cayley": (1 - Phi)(1 + Phi)^-1, near exp(-2 Phi),
        with ``|w|`` = tan(angle/4). "outer": (1 + Phi + Phi ^ Phi/2)/sqrt(1 + w^2), near exp(Phi), with
        ``|w|`` = tan(angle/2).

    Returns
    -------
    Multivector, shape (...)
        Unit motors. `INVALID`: not finite.

    Notes
    -----
    (6.25), (6.26) and (6.28); each map has the scale that the thesis gives it; so have the charts of the
    simulations.
    """
    x = as_screw(phi, "Phi")
    motor = invalidate_nonfinite(evaluate(x.algebra, f"maps.{as_choice(map, 'map', MAPS)}_motor", x).value)
    if as_bool(strict, "strict"):
        raise_first(motor._status, "map_motor")
    return motor  # type: ignore[no-any-return]


def map_rate(
    phi: Multivector,
    twist: Multivector,
    map: str = "exponential",
    frame: str = "world",
    form: str = "dual",
    strict: bool = False,
) -> Multivector:
    """Rate of Phi while the motor of `map_motor` moves with a twist.

    Parameters
    ----------
    phi, twist : Multivector, shapes broadcasting to (...)
        Phi, and the twist Omega: dR = -Omega R/2 in the world's frame, dR = -R Omega/2 in the body's.
    map : str
        See `map_motor`.
    frame : "world" or "body"
        Frame of the twist.
    form : "dual", "series" or "split"
        Formula of the exponential's rate, all with the same value: two commutators with dual numbers as coefficients;
        four commutators (6.24); or parts along and across the plane of rotation, the set after (6.25), corrected.
        The series loses digits near full turns, the split form near angle 0.

    Returns
    -------
    Multivector, shape (...)
        dPhi. `SINGULAR`: exponential and bortz at full turns (the split form also without rotation). Cayley's
        map is singular at full turns too, the outer exponential at half turns, where Phi is infinite.
    """
    name, side = as_choice(map, "map", MAPS), as_choice(frame, "frame", FRAMES)
    x, omega = as_screw(phi, "Phi"), as_screw(twist, "the twist")
    same_algebra(x, omega)
    formula = f"maps.{name}_rate_{side}"
    if as_choice(form, "form", FORMS) != "dual":
        as_choice(name, f"map with form {form!r}", ("exponential",))
        formula = f"map_forms.{form}_rate_{side}"
    outcome = evaluate(x.algebra, formula, x, omega)
    rate = outcome.value
    invalid = merge_statuses(*(s if s is None else np.broadcast_to(s, rate.shape) for s in (x._status, omega._status)))
    rate = invalidate_nonfinite(rate._make(rate._type, rate._data, rate.shape, merge_statuses(invalid, outcome.status)))
    if as_bool(strict, "strict"):
        raise_first(rate._status, "map_rate")
    return rate  # type: ignore[no-any-return]


__all__ = ["FORMS", "FRAMES", "MAPS", "map_motor", "map_rate"]
