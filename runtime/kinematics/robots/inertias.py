"""Inertias of files made possible: the nearest that a body can have, where they are not, within a tolerance or asked.

Principal moments of a body are not negative, and none exceeds the sum of the other two. A simulation needs positive
ones. Files break both by rounding, and some by much.
"""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls

from ...codegen.errors import InputError
from ...mechanics.arguments import MATRIX_TOLERANCE
from .description import LinkInertia

Array = NDArray[Any]
#: What becomes of inertias that no body can have: `system` refuses them or takes the nearest ones;
CHOICES = ("given", "nearest")
#: torques and accelerations refuse them, compute with them as they are, or take the nearest ones.
IMPOSSIBLE = ("error", "keep", "nearest")
#: Moments may break the rules by this fraction of the largest one: files have three digits and more.
TOLERANCE = 1e-3
#: Moments are at least those of a ball with this radius of gyration, as a fraction of the robot's size: a point mass
#: or a thin rod has none about some axis, and a body that a simulation moves needs one.
GYRATION = 1e-4
#: Moments of a smaller radius of gyration, or a smaller fraction of the largest one, are zero but for rounding.
ZERO_GYRATION = 1e-8
ZERO = 1e-12
#: Principal moments from the second moments along the axes.
_MOMENTS = np.ones((3, 3)) - np.eye(3)


def refuse_impossible(inertia: LinkInertia, what: str, size: float, where: str) -> None:
    """Refuse an inertia that no body can have, by more than `TOLERANCE`. A body may be massless, a point or a rod.

    Raises
    ------
    InputError
    """
    fault = ""
    if not inertia.mass >= 0:
        fault = f"the mass of {what} is {inertia.mass:g}; a mass is positive, or zero."
    elif inertia.mass == 0 and inertia.tensor.any():
        fault = f"{what} has moments of inertia, and no mass."
    elif inertia.mass > 0:
        fault = _fault(np.linalg.eigvalsh(inertia.tensor), inertia.mass * (GYRATION * size) ** 2, what)
    if fault:
        raise InputError(
            fault, where=where,
            remedy="Mend it, or keep such inertias as they are with impossible='keep', or take 'nearest'",
        )  # fmt: skip


def _fault(moments: Array, floor: float, what: str) -> str:
    """Text about principal moments (3,) in ascending order that no body can have; empty if rounding explains them."""
    allowed = max(TOLERANCE * float(np.abs(moments).max()), floor)
    if moments[0] < -allowed:
        return f"the inertia of {what} has a principal moment of {moments[0]:.3g}: no body has such an inertia."
    if 2 * moments[2] - moments.sum() > allowed:
        return (
            f"the inertia of {what} has a principal moment of {moments[2]:.3g}, which exceeds the sum of the others, "
            f"{moments[0] + moments[1]:.3g}: no body has such an inertia."
        )
    return ""


def possible_inertia(inertia: LinkInertia, what: str, size: float, choice: str, changes: list[str]) -> LinkInertia:
    """The inertia itself, if a body can have it and move; or the nearest one.

    Parameters
    ----------
    inertia : LinkInertia
    what : str
        For messages.
    size : float
        Length of the robot.
    choice : {"given", "nearest"}
        "given": refuse what is impossible by more than `TOLERANCE`.
    changes : list of str
        Gets a line for what has changed.

    Raises
    ------
    InputError
    """
    if not inertia.mass > 0:
        raise InputError(f"the mass of {what} is {inertia.mass:.3g}; it is positive.")
    moments, axes = np.linalg.eigh((inertia.tensor + inertia.tensor.T) / 2)
    largest = float(np.abs(moments).max())
    floor = inertia.mass * (GYRATION * size) ** 2
    zero = max(inertia.mass * (ZERO_GYRATION * size) ** 2, ZERO * largest)
    if moments[0] > zero and 2 * moments[2] - moments.sum() <= MATRIX_TOLERANCE * largest:
        return inertia
    fault = _fault(moments, floor, what)
    if fault and choice != "nearest":
        raise InputError(
            fault,
            remedy="Correct it: moments are about the center of mass, mass included; or take the nearest possible one, "
            "with system(inertia='nearest')",
        )
    second, _ = nnls(_MOMENTS, moments)
    nearest = np.maximum(_MOMENTS @ second, max(floor, zero))
    by = float(np.abs(nearest - moments).max())
    changes.append(f"{what} (by {by:.3g} of {largest:.3g})")
    return LinkInertia(inertia.mass, (axes * nearest) @ axes.T, inertia.origin)


def warn_of_changes(changes: list[str], path: str, stacklevel: int) -> None:
    """Warn once of the inertias that were replaced."""
    if changes:
        shown = ", ".join(changes[:5]) + (f" and {len(changes) - 5} more" if len(changes) > 5 else "")
        warnings.warn(
            f"{path}: no body that moves has such moments of inertia, and the nearest ones are taken: {shown}.",
            stacklevel=stacklevel,
        )
