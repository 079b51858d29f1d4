"""Integrators by name, and which one a simulation takes by itself."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..codegen.errors import InputError, suggest
from ..codegen.taylor import HIGHEST_ORDER
from .assembly import Assembly
from .given import shown
from .tableaus import CLASSICAL, COMPOSITIONS, ORDER8, Scheme

Array = NDArray[np.float64]
#: Names of users, and the method of the driver behind each.
INTEGRATORS = {
    "rk4": "rk4", "rkmk4": "chart", "cf4": "cf4", "midpoint": "midpoint", "strang": "composition",
    "blanes-moan": "composition", "yoshida6": "composition", "adaptive": "adaptive", "taylor": "taylor",
}  # fmt: skip
#: As in templates/c/dynamics_run.j2.
NUMBERS = {"chart": 0, "rk4": 1, "cf4": 2, "midpoint": 3, "composition": 4, "adaptive": 5, "taylor": 6}
#: Those whose steps are all of one size.
FIXED = ("chart", "rk4", "cf4", "midpoint", "composition")
MAPS = ("exponential", "bortz", "cayley", "outer")
STABILIZATIONS = ("auto", "null-space", "projection", "baumgarte", "none")
#: Step of methods that do not choose their own, in seconds; error of those that do, by step.
STEP, RTOL = 1e-3, 1e-12
#: Bodies, springs and constraints of which Taylor series are kept on the stack: some 30 kB each; constraints between
#: two bodies count four times.
MOST_SERIES = 64
_NOTHING = np.zeros(1)


@dataclass(frozen=True)
class Method:
    """An integrator as the driver reads it."""

    name: str
    step: float
    rtol: float
    atol: float

    @property
    def driver(self) -> str:
        """What it is to the driver."""
        return INTEGRATORS[self.name]

    @property
    def scheme(self) -> Scheme:
        """Its Runge-Kutta coefficients, where it has any."""
        if self.driver == "taylor":
            return replace(CLASSICAL, order=order_of(self.rtol))
        return ORDER8 if self.driver == "adaptive" else CLASSICAL

    @property
    def composition(self) -> Array:
        """Its shares of a step, where it is made of flows."""
        return COMPOSITIONS[self.name][0] if self.driver == "composition" else _NOTHING


def order_of(rtol: float) -> int:
    """Order of the Taylor series that serves a tolerance with the least work (Jorba and Zou 2005)."""
    return int(np.clip(np.ceil(1 - np.log(rtol) / 2), 4, HIGHEST_ORDER))


def _no_series(made: Assembly) -> str:
    """Why a motion has no Taylor series here; nothing if it has."""
    if made.called.functions:
        return "functions of users have none"
    if len(made.bodies) + len(made.springs) + sum(4 if row.other >= 0 else 1 for row in made.rows) > MOST_SERIES:
        return f"those of {len(made.bodies)} bodies and what is between them would take too much room"
    return ""


def _check_series(made: Assembly) -> None:
    """Raise `InputError` for what has no Taylor series here."""
    if why := _no_series(made):
        raise InputError(f"taylor makes series of the motion; {why}.", remedy="Use integrator='adaptive'")


def check(value: str, known: tuple[str, ...], what: str) -> str:
    """A name of a list; -ise is -ize.

    Raises
    ------
    InputError
        If it is not there.
    """
    if not isinstance(value, str) or value not in known:
        near = suggest(value, known) if isinstance(value, str) else ""
        raise InputError(f"{shown(value)} is no {what}; there are: {', '.join(known)}.{near}")
    return value


def differentiable(integrator: str) -> str:
    """The integrator of a run with sensitivities: one that has a chart.

    Raises
    ------
    InputError
        If the chosen one has none.
    """
    if integrator == "auto":
        return "adaptive"
    if INTEGRATORS[integrator] not in ("chart", "adaptive"):
        raise InputError(
            f"{integrator} carries no sensitivities.", remedy="Use integrator='auto', 'adaptive' or 'rkmk4'"
        )
    return integrator


def splits(made: Assembly) -> bool:
    """Whether the motion is made of exact flows: one body, free or turning about a point, without drag.

    Loads that are functions of the state might depend on velocities; those of time alone do not.
    """
    if len(made.bodies) > 1 or made.mode == "constrained" or "drag" in made.loads:
        return False
    allowed = made.frames[0].allowed
    turning = allowed is None or (int(allowed.sum()) == 3 and made.turns_freely)
    return turning and not made.damped and not made.functions_of_state


def chosen(integrator: str, made: Assembly) -> str:
    """The integrator by name; "auto" is Taylor series where the motion has them, else steps of order 8.

    Both choose their own steps, by the error that is allowed: no step is too long for a fast spin, nor too short for a
    slow swing. The studies `tops`, `pendulums` and `stiffness` hold the choice against all others.

    Raises
    ------
    InputError
        If this simulation cannot be split, has no series, or there is no such integrator.
    """
    check(integrator, ("auto", *INTEGRATORS), "integrator")
    if integrator == "auto":
        return "adaptive" if _no_series(made) else "taylor"
    if INTEGRATORS[integrator] == "composition" and not splits(made):
        raise InputError(
            f"{integrator} composes exact flows: of one body, free or turning about one pinned point, under loads that "
            "do not depend on its velocity.",
            remedy="Use integrator='adaptive', or another",
        )
    if INTEGRATORS[integrator] == "taylor":
        _check_series(made)
    return integrator
