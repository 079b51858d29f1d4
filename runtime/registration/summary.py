"""A registration told to a person: the pose, what was matched, and how far it is to be believed."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..multivector import Multivector
from .freedom import generators, in_words
from .model import Model
from .parameters import PLURALS
from .result import Registration
from .similarities import ROTOR, similarity

Array = NDArray[Any]
#: Other poses that are told one by one; they are all in the file.
SHOWN = 8
#: Digits of positions and angles.
DIGITS = 6
#: Smaller angles (in radians) are no rotation, which has no axis then; smaller coordinates, over the largest, are zero.
NO_TURN, NOTHING = 1e-12, 1e-12
#: Width of what a line is about.
COLUMN = 13


def summary(result: Registration, query: Model, reference: Model) -> str:
    """Some lines of text.

    Parameters
    ----------
    result : Registration
    query, reference : Model
        As they were registered.
    """
    unit = f" {query.unit}" if query.unit and query.unit == reference.unit else ""
    return "\n".join(f"{f'{about}:':{COLUMN}}{text}" if about else text for about, text in _lines(result, query, unit))


def _lines(result: Registration, query: Model, unit: str) -> Iterator[tuple[str, str]]:
    yield "pose", pose_text(result.motor, unit, result.scale)
    yield "matches", _matches(result, query)
    yield "cost", f"{result.cost:.4g}, matched within {result.threshold:.3g}{unit}"
    yield "converged", "yes" if result.converged else f"no: {result.message or 'the pose may be chance'}"
    yield "doubt", _doubt(result.doubt)
    free = result.undetermined
    if free is not None and len(free):
        yield "undetermined", in_words(free)
    elif np.isfinite(result.covariance).all() and np.asarray(result.inliers).any():
        angle, length = deviations(result)
        yield "known to", f"{math.degrees(angle):.2g} degrees and {length:.2g}{unit} (standard deviations)"
    others = result.ambiguous
    if others:
        count = f"{len(others)} other pose{'s serve' if len(others) > 1 else ' serves'} as well"
        yield "ambiguous", f"{count} (the models are symmetric, or nearly):"
        for motor in others[:SHOWN]:
            yield "", f"{'':{COLUMN}}{pose_text(motor, unit, result.scale)}"
        if len(others) > SHOWN:
            yield "", f"{'':{COLUMN}}and {len(others) - SHOWN} more"


def pose_text(motor: Multivector, unit: str = "", size: float = 1.0) -> str:
    """A motor after a scaling, or the rotor of a similarity, in words: scale and turn about the origin, then shift."""
    own, _, translation = similarity(motor)
    scale = own * size
    axis, angle = axis_angle(motor)
    turn = "no turn"
    if angle > NO_TURN:
        turn = f"turn by {math.degrees(angle):.{DIGITS}g} degrees about {vector_text(axis)}"
    grow = "" if abs(scale - 1) < NOTHING else f"scale by {scale:.{DIGITS}g}, "
    return f"{grow}{turn}, then move by {vector_text(translation)}{unit}"


def axis_angle(motor: Multivector) -> tuple[Array, float]:
    """Unit axis, and angle in [0, pi], of a motor's rotation, or of a similarity's."""
    algebra: Any = motor.algebra
    turn = algebra.multivector({name: motor[name] for name in ROTOR if name in map(str, motor.blades)})
    found = turn.normalized("rotor").parameters()
    axis, angle = np.asarray(found.axis), math.remainder(float(found.angle), 2 * math.pi)
    return (-axis, -angle) if angle < 0 else (axis, angle)


def vector_text(v: Array) -> str:
    """Three numbers, without the digits that rounding leaves of zeros."""
    v = np.where(np.abs(v) <= NOTHING * max(1.0, float(np.abs(v).max())), 0.0, v)
    return f"({', '.join(f'{x:.{DIGITS}g}' for x in v)})"


def deviations(result: Registration) -> tuple[float, float]:
    """Standard deviations in the direction that is known worst: of the rotation, in radians; of where the middle of the
    reference's objects is, in the models' unit of length."""
    algebra = result.motor.algebra
    rows = np.linalg.inv(generators(algebra))  # a twist as turn and shift of the origin
    turn, shift = rows[:, :3], rows[:, 3:]
    jacobians = turn, shift + np.cross(turn, result.center)
    parts = (j.T @ result.covariance @ j for j in jacobians)
    angle, length = (math.sqrt(max(float(np.linalg.eigvalsh(part)[-1]), 0.0)) for part in parts)
    return angle, length


def _matches(result: Registration, query: Model) -> str:
    inside = result.inliers
    parts = [f"{int(inside[kind].sum())} of {n} {PLURALS[kind].replace('_', ' ')}" for kind, n in query.counts.items()]
    return ", ".join(parts)


def _doubt(doubt: float) -> str:
    if not math.isfinite(doubt):
        return "nothing speaks for this pose"
    return f"chance alone would give 10^{doubt:.3g} poses as good as this one"
