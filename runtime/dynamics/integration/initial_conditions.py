"""Initial conditions: constraints that the start obeys, and that do not contradict each other."""

from __future__ import annotations

from functools import reduce

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import ConstraintError
from ..assembly.data import Assembly, DriverConstraint
from . import runs

Array = NDArray[np.float64]
#: Relative error of the constraints at the start that counts as rounding of the user's numbers.
ROUNDING = 1e-9
#: Factor of that for rates, because those of paths may be differences.
RATE_FACTOR = 10.0
_REMEDY = "Give project=True, and the start is moved to the nearest one that obeys the constraints"


def check_start(run: runs.Run, projected: bool) -> None:
    """Raise `ConstraintError` if a simulation does not start on its constraints, with the worst one and its error."""
    assembly = run.driver.assembly
    if not assembly.driver_constraints or run.status.any():
        return
    for kind, what in enumerate(("", "the rate of ")):
        allowed = _rounding(assembly) * (RATE_FACTOR if kind else 1.0)
        worst = int(np.argmax(run.start[:, kind] / allowed))
        error = float(run.start[worst, kind])
        if not (run.start[:, kind] > allowed).any():
            continue
        unit = "of the body's velocity" if kind else "of the body's size and distance (or radians)"
        label = _label(assembly, int(run.start_rows[worst, kind]))
        where = None if len(run.start) == 1 else f"simulation {worst}"
        if projected:
            raise ConstraintError(
                f"the constraints contradict each other: {what}{label} keeps a residual of {error:.3g} {unit}.",
                where=where,
                remedy="Leave it out, or one of the others",
            )
        raise ConstraintError(
            f"{what}{label} is violated at the start, by {error:.3g} {unit}.", where=where, remedy=_REMEDY
        )


def contradiction(run: runs.Run, item: int) -> str:
    """Message of a simulation that ended off its constraints: the constraint and its error."""
    error, row = run.off[item]
    assembly = run.driver.assembly
    label, unit = _label(assembly, int(row)), "of the body's size, or in radians"
    if _constraint_of(assembly, int(row)).power:
        label, unit = f"the rate of {label}", "of the bodies' velocity"
    return f"the constraints contradict each other: {label} keeps a residual of {error:.3g} {unit}"


def _rounding(assembly: Assembly) -> Array:
    """Rounding (n,) of constraints far from the world's origin: coefficients of CGA hold squares of distances."""
    radii = (np.sqrt(b.moments.max(-1) / b.mass) for b in assembly.bodies)  # of a system one may be a batch, one not
    gyration = reduce(np.minimum, radii)
    far = np.linalg.norm(assembly.origin, axis=-1) / gyration
    power = 1 if assembly.algebra.is_degenerate else 2
    rounding: Array = np.broadcast_to(ROUNDING + 8 * np.finfo(float).eps * far**power, assembly.size)
    return rounding


def check_pinned_twist(twists: Array, admissible: Array, units: Array) -> None:
    """Raise `ConstraintError` if the twists (n, 6) at the start differ from those that pins allow.

    ``units`` (n, 6) or (6,) are the units of the coefficients.
    """
    size = np.abs(twists / units).max(-1)
    off = np.abs((twists - admissible) / units).max(-1)
    fraction = np.divide(off, size, out=np.zeros_like(off), where=size > 0)
    worst = int(np.argmax(fraction))
    if fraction[worst] > ROUNDING:
        raise ConstraintError(
            f"the velocities at the start move what is pinned: {fraction[worst]:.3g} of them is not free.",
            where=None if len(fraction) == 1 else f"simulation {worst}",
            remedy=_REMEDY,
        )


def _label(assembly: Assembly, row: int) -> str:
    """Index and type of the constraint of an equation."""
    constraint = _constraint_of(assembly, row).constraint
    index = next(i for i, c in enumerate(assembly.constraints) if c is constraint)
    return f"constraint {index} ({constraint.label})"


def _constraint_of(assembly: Assembly, row: int) -> DriverConstraint:
    """Constraint of the driver that has an equation."""
    ends = np.cumsum([each.equations for each in assembly.driver_constraints])
    return assembly.driver_constraints[int(np.searchsorted(ends, row, side="right"))]
