"""Integrators by name, and the choice of one for a simulation."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...codegen.algorithms.series.recurrences import HIGHEST_ORDER
from ...codegen.errors import InputError
from ...codegen.programs.dynamics.loads import ANALYTIC_LAWS, LAW_PLACES
from ...common.validation import as_choice
from ..assembly.data import Assembly
from ..assembly.decay import fastest_decay
from .collocation import Collocation, radau, stages_of
from .tableaus import CLASSICAL, COMPOSITIONS, FIXED_SCHEMES, ORDER8, Scheme

Array = NDArray[np.float64]
#: Public names, and the driver's method of each.
INTEGRATORS = {
    "rk4": "rk4", **dict.fromkeys(FIXED_SCHEMES, "chart"), "cf4": "cf4", "midpoint": "midpoint",
    **dict.fromkeys(COMPOSITIONS, "composition"), "adaptive": "adaptive", "implicit": "implicit",
    "taylor": "taylor",
}  # fmt: skip
#: Methods with a fixed step.
FIXED = ("chart", "rk4", "cf4", "midpoint", "composition")
MAPS = ("exponential", "bortz", "cayley", "outer")
STABILIZATIONS = ("auto", "null-space", "projection", "baumgarte", "none")
#: Default step of methods with a fixed step, in seconds.
STEP = 1e-3
#: Default relative error of a step of the others.
RTOL = 1e-12
#: Bodies, springs and constraints up to which "auto" is Taylor series, whose products grow with all pairs of orders;
#: constraints between two bodies count four times.
MAX_SERIES = 64
#: Time constants of the fastest decay in a run from which on "auto" is implicit, and bodies up to which it is: steps
#: cost their cube.
STIFF, MAX_IMPLICIT = 1e5, 24


@dataclass(frozen=True)
class Method:
    """An integrator as the driver reads it."""

    name: str
    step: float
    rtol: float
    atol: float

    @property
    def driver(self) -> str:
        """Name of the driver's method."""
        return INTEGRATORS[self.name]

    @property
    def scheme(self) -> Scheme | Collocation:
        """Runge-Kutta coefficients of methods that have them."""
        if self.driver == "implicit":
            return radau(stages_of(self.rtol))
        if self.driver == "taylor":
            return replace(CLASSICAL, order=order_of(self.rtol))
        return ORDER8 if self.driver == "adaptive" else FIXED_SCHEMES.get(self.name, CLASSICAL)

    @property
    def numbers(self) -> Array:
        """What its algorithms read of it: coefficients of the scheme, or fractions of a step of a composition."""
        return COMPOSITIONS[self.name][0] if self.driver == "composition" else self.scheme.numbers


def order_of(rtol: float) -> int:
    """Order of the Taylor series that serves a tolerance with the least work (Jorba and Zou 2005)."""
    return int(np.clip(np.ceil(1 - np.log(rtol) / 2), 4, HIGHEST_ORDER))


def _no_series(assembly: Assembly) -> str:
    """Reason why a motion has no Taylor series; empty if it has one."""
    if assembly.callbacks.functions:
        return "functions of users have none"
    if assembly.couplings:
        return "dampers between bodies have none"
    for name in assembly.loads:
        if name in LAW_PLACES and name not in ANALYTIC_LAWS:
            return f"the law {name} has none where the body rests"
    return ""


def _many(assembly: Assembly) -> bool:
    """True if there are too many bodies, springs and constraints for "auto" to use series."""
    return (
        len(assembly.bodies)
        + len(assembly.springs)
        + sum(4 if row.other >= 0 else 1 for row in assembly.driver_constraints)
        > MAX_SERIES
    )


def _check_series(assembly: Assembly) -> None:
    """Raise `InputError` if the motion has no Taylor series."""
    if why := _no_series(assembly):
        raise InputError(f"taylor makes series of the motion; {why}.", remedy="Use integrator='adaptive'")


def splits(assembly: Assembly) -> bool:
    """True if the motion is composed of exact flows: one body, free or rotating about a point, that nothing brakes.

    Loads that are functions of the state might depend on velocities; those of time alone do not.
    """
    brakes = any(name in LAW_PLACES and LAW_PLACES[name].has_twist for name in assembly.loads)
    if len(assembly.bodies) > 1 or assembly.mode == "constrained" or brakes:
        return False
    allowed = assembly.frames[0].allowed
    rotates = allowed is None or (int(allowed.sum()) == 3 and assembly.rotates_freely)
    return rotates and not assembly.damped and not assembly.depends_on_state


def _is_stiff(assembly: Assembly, duration: float) -> bool:
    """True if a run of so many seconds is many times as long as what loads damp takes to decay, and has few bodies."""
    return len(assembly.bodies) <= MAX_IMPLICIT and fastest_decay(assembly) * duration > STIFF


def select_integrator(integrator: str, assembly: Assembly, duration: float, sensitivities: bool = False) -> str:
    """Integrator by name, for a run of so many seconds.

    "auto" is implicit where loads damp so fast that explicit steps would be many, else Taylor series where the motion
    has them and no sensitivities are wanted, else steps of order 8. All adapt their steps to the tolerances, so that
    fast spins and slow swings need no choice of step. The studies `tops`, `pendulums` and `stiffness` compare them with
    all others.

    Raises
    ------
    InputError
        If this simulation cannot be split, has no series, or there is no such integrator.
    """
    as_choice(integrator, "integrator", ("auto", *INTEGRATORS))
    if integrator == "auto":
        if _is_stiff(assembly, duration):
            return "implicit"
        return "adaptive" if sensitivities or _no_series(assembly) or _many(assembly) else "taylor"
    if INTEGRATORS[integrator] == "composition" and not splits(assembly):
        raise InputError(
            f"{integrator} composes exact flows: of one body, free or rotating about one pinned point, under loads "
            "that do not depend on its velocity.",
            remedy="Use integrator='adaptive', or another",
        )
    if INTEGRATORS[integrator] == "taylor":
        _check_series(assembly)
    return integrator
