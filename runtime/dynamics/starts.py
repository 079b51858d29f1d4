"""Whether a simulation may begin: constraints obeyed by the start, and none against another."""

from __future__ import annotations

from functools import reduce

import numpy as np
from numpy.typing import NDArray

from ..codegen.errors import ConstraintError
from . import engine
from .assembly import Assembly, Row

Array = NDArray[np.float64]
#: How far a start may be off its constraints: rounding of what users give.
ROUNDING = 1e-9
#: Rates may be off by so much more: those of paths come from differences.
OF_DIFFERENCES = 10.0
_REMEDY = "Give project=True, and the start is moved to the nearest one that obeys the constraints"


def check_start(run: engine.Run, projected: bool) -> None:
    """Raise `ConstraintError` if a simulation does not start on its constraints: which, and by how much."""
    made = run.driver.made
    if not made.rows or run.status.any():
        return
    for kind, what in enumerate(("", "the rate of ")):
        allowed = _rounding(made) * (OF_DIFFERENCES if kind else 1.0)
        worst = int(np.argmax(run.start[:, kind] / allowed))
        share = float(run.start[worst, kind])
        if not (run.start[:, kind] > allowed).any():
            continue
        unit = "of the body's velocity" if kind else "of the body's size and distance (or radians)"
        label = _label(made, int(run.start_rows[worst, kind]))
        where = None if len(run.start) == 1 else f"simulation {worst}"
        if projected:
            raise ConstraintError(
                f"the constraints contradict each other: {what}{label} stays violated, by {share:.3g} {unit}.",
                where=where,
                remedy="Leave it out, or one of the others",
            )
        raise ConstraintError(
            f"{what}{label} is violated at the start, by {share:.3g} {unit}.", where=where, remedy=_REMEDY
        )


def contradiction(run: engine.Run, item: int) -> str:
    """Which constraint a simulation that ended stays off, and by how much."""
    share, row = run.off[item]
    made = run.driver.made
    label, unit = _label(made, int(row)), "of the body's size, or in radians"
    if _row_of(made, int(row)).power:
        label, unit = f"the rate of {label}", "of the bodies' velocity"
    return f"the constraints contradict each other: {label} stays violated, by {share:.3g} {unit}"


def _rounding(made: Assembly) -> Array:
    """What the coefficients of an object of the world far from its origin can say, and differences of them for rates:
    those of CGA hold squares."""
    reaches = (np.sqrt(b.moments.max(-1) / b.mass) for b in made.bodies)  # of a system one may be a batch, one not
    reach = reduce(np.minimum, reaches)
    far = np.linalg.norm(made.origin, axis=-1) / reach
    power = 1 if made.algebra.is_degenerate else 2
    found: Array = np.broadcast_to(ROUNDING + 8 * np.finfo(float).eps * far**power, made.size)
    return found


def check_pinned_twist(given: Array, kept: Array, units: Array) -> None:
    """Raise `ConstraintError` if a start's twists (n, 6) are not those that pins leave.

    ``units`` (n, 6) or (6,) are what coefficients are measured by.
    """
    size = np.abs(given / units).max(-1)
    off = np.abs((given - kept) / units).max(-1)
    share = np.divide(off, size, out=np.zeros_like(off), where=size > 0)
    worst = int(np.argmax(share))
    if share[worst] > ROUNDING:
        raise ConstraintError(
            f"the velocities at the start move what is pinned: {share[worst]:.3g} of them is not free.",
            where=None if len(share) == 1 else f"simulation {worst}",
            remedy=_REMEDY,
        )


def _label(made: Assembly, row: int) -> str:
    """Which constraint a row belongs to."""
    own = _row_of(made, row).constraint
    place = next(i for i, c in enumerate(made.constraints) if c is own)
    return f"constraint {place} ({own.label})"


def _row_of(made: Assembly, row: int) -> Row:
    """What the driver reads as one that holds this equation."""
    ends = np.cumsum([each.rows for each in made.rows])
    return made.rows[int(np.searchsorted(ends, row, side="right"))]
