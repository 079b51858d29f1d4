"""Summary of a registration as text: the pose, the matches, and their reliability."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ..core.multivector import Multivector
from .estimation.gauge_freedom import describe_twists
from .model.similarity import ROTOR, similarity

Array = NDArray[Any]
#: Largest number of equivalent poses that are listed; they are all in the file.
MAX_LISTED = 8
#: Digits of positions and angles.
DIGITS = 6
#: Smallest angle of a rotation, in radians; below it there is no axis.
MIN_ANGLE = 1e-12
#: Smaller coordinates, relative to the largest one, are printed as zero.
RELATIVE_ZERO = 1e-12
#: Width of the column of labels.
COLUMN = 13


class Registered(Protocol):
    """What a summary reads of a `Registration`."""

    @property
    def motor(self) -> Multivector: ...
    @property
    def scale(self) -> float: ...
    @property
    def inliers(self) -> Any: ...
    @property
    def cost(self) -> float: ...
    @property
    def threshold(self) -> float: ...
    @property
    def converged(self) -> bool: ...
    @property
    def message(self) -> str: ...
    @property
    def doubt(self) -> float: ...
    @property
    def undetermined(self) -> Multivector | None: ...
    @property
    def covariance(self) -> Array: ...
    @property
    def pose_covariance(self) -> Array: ...
    @property
    def center(self) -> Array: ...
    @property
    def ambiguous(self) -> list[Multivector]: ...


def summary(result: Registered, unit: str = "") -> str:
    """Summary of a registration in some lines of text.

    Parameters
    ----------
    result : Registration
    unit : str
        Of length, of both models.
    """
    lines = _lines(result, f" {unit}" if unit else "")
    return "\n".join(f"{f'{about}:':{COLUMN}}{text}" if about else text for about, text in lines)


def _lines(result: Registered, unit: str) -> Iterator[tuple[str, str]]:
    yield "pose", pose_text(result.motor, unit, result.scale)
    yield "matches", _matches(result)
    yield "cost", f"{result.cost:.4g}, matched within {result.threshold:.3g}{unit}"
    yield "converged", "yes" if result.converged else f"no: {result.message or 'the pose may be chance'}"
    yield "doubt", _doubt_text(result.doubt)
    free = result.undetermined
    if free is not None and len(free):
        yield "undetermined", describe_twists(free)
    elif np.isfinite(result.covariance).all() and np.asarray(result.inliers).any():
        angle, length = deviations(result)
        yield "known to", f"{math.degrees(angle):.2g} degrees and {length:.2g}{unit} (standard deviations)"
    others = result.ambiguous
    if others:
        count = f"{len(others)} other pose{'s serve' if len(others) > 1 else ' serves'} as well"
        yield "ambiguous", f"{count} (the models are symmetric, or nearly):"
        for motor in others[:MAX_LISTED]:
            yield "", f"{'':{COLUMN}}{pose_text(motor, unit, result.scale)}"
        if len(others) > MAX_LISTED:
            yield "", f"{'':{COLUMN}}and {len(others) - MAX_LISTED} more"


def pose_text(motor: Multivector, unit: str = "", size: float = 1.0) -> str:
    """Description of a motor after a scaling, or of the rotor of a similarity."""
    rotor_scale, _, translation = similarity(motor)
    scale = rotor_scale * size
    axis, angle = axis_angle(motor)
    rotation = "no turn"
    if angle > MIN_ANGLE:
        rotation = f"turn by {math.degrees(angle):.{DIGITS}g} degrees about {vector_text(axis)}"
    scaling = "" if abs(scale - 1) < RELATIVE_ZERO else f"scale by {scale:.{DIGITS}g}, "
    return f"{scaling}{rotation}, then move by {vector_text(translation)}{unit}"


def axis_angle(motor: Multivector) -> tuple[Array, float]:
    """Unit axis, and angle in [0, pi], of the rotation of a motor or of a similarity."""
    algebra: Any = motor.algebra
    rotation = algebra.multivector({name: motor[name] for name in ROTOR if name in map(str, motor.blades)})
    found = rotation.normalized("rotor").parameters()
    axis, angle = np.asarray(found.axis), math.remainder(float(found.angle), 2 * math.pi)
    return (-axis, -angle) if angle < 0 else (axis, angle)


def vector_text(v: Array) -> str:
    """Three numbers, rounded to zero where they are rounding errors."""
    v = np.where(np.abs(v) <= RELATIVE_ZERO * max(1.0, float(np.abs(v).max())), 0.0, v)
    return f"({', '.join(f'{x:.{DIGITS}g}' for x in v)})"


def deviations(result: Registered) -> tuple[float, float]:
    """Largest standard deviations: of the rotation, in radians, and of the reference's center, in the models' unit."""
    across = np.cross(np.eye(3), result.center)  # the center moves by translation + rotation x center
    jacobians = np.eye(6)[:, :3], np.vstack([across, np.eye(3)])
    parts = (j.T @ result.pose_covariance @ j for j in jacobians)
    angle, length = (math.sqrt(max(float(np.linalg.eigvalsh(part)[-1]), 0.0)) for part in parts)
    return angle, length


def _matches(result: Registered) -> str:
    found = result.inliers.items()
    return ", ".join(f"{int(each.sum())} of {len(each)} {kinds.replace('_', ' ')}" for kinds, each in found)


def _doubt_text(doubt: float) -> str:
    if not math.isfinite(doubt):
        return "nothing speaks for this pose"
    return f"chance alone would give 10^{doubt:.3g} poses as good as this one"
