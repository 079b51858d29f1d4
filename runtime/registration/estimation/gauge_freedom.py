"""Free motions of a model or of matches: the null space of a normal matrix, a basis of it, and a description."""

from __future__ import annotations

import math
from collections.abc import Iterable
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.programs.registration.pose import FREE
from ...core.multivector import Algebra, Multivector
from ...objects.screws import screw

Array = NDArray[Any]
#: A motion is nearly free up to this relative eigenvalue.
NEARLY_FREE = 1e-6
#: A motion counts as free above this standard deviation of its twist (half of an angle, or of a translation in the
#: models' unit of length): too large for linearization.
UNKNOWN = 0.1
#: Smallest angle of a rotation, relative to a translation by the unit of length; below it a motion is a translation.
MIN_ROTATION = 0.05
#: Smallest pitch of a screw motion, in units of length; below it a motion is a rotation.
MIN_PITCH = 1e-3
#: Digits of numbers in descriptions.
DIGITS = 4


@cache
def generators(algebra: Algebra) -> Array:
    """Twists (6, 6), as rows, of a unit rotation about each axis through the origin, then of unit translations."""
    axes = np.eye(3)
    rotations = algebra.rotor(axes, np.ones(3)).log()
    translations = algebra.translator(axes).log()
    blades = list(algebra.kind("twist").blades)
    rows = np.zeros((6, 6))
    for k, part in enumerate((rotations, translations)):
        columns = [blades.index(blade) for blade in part._type.blades]
        rows[3 * k : 3 * k + 3, columns] = part._data
    return rows


def free_motions(modes: tuple[Array, Array], covariance: Array | None = None, fraction: float = FREE) -> Array:
    """Twists (m, 6) of the smallest eigenvalues of a normal matrix, given by its eigenmodes, or of the largest ones
    of a covariance.
    """
    values, vectors = modes
    free = values <= fraction * max(float(values[-1]), 0.0)
    if not free.any() and covariance is not None and covariance.trace() > UNKNOWN * UNKNOWN:  # else none is unknown
        values, vectors = np.linalg.eigh(covariance)
        free = values > UNKNOWN * UNKNOWN
    twists: Array = vectors[:, free].T
    return twists


def canonical_twist_basis(twists: Array, algebra: Algebra) -> Array:
    """Canonical basis (m, 6) of the span of some twists: translations first, then rotations about lines.

    Translations are perpendicular to the axes of the rotations. A rotation that is small against its translation is
    omitted.
    """
    if not len(twists):
        return twists
    rows = twists @ np.linalg.inv(generators(algebra))
    u, sizes, _ = np.linalg.svd(rows[:, :3])
    count = int((sizes > MIN_ROTATION * np.linalg.norm(rows, axis=1).max()).sum())
    rotations, remaining = u[:, :count].T @ rows, u[:, count:].T @ rows
    translations = np.linalg.svd(remaining[:, 3:])[2][: len(remaining)] if len(remaining) else np.empty((0, 3))
    rotations /= np.linalg.norm(rotations[:, :3], axis=1, keepdims=True)
    rotations[:, 3:] -= rotations[:, 3:] @ translations.T @ translations
    canonical = np.concatenate([np.hstack([np.zeros_like(translations), translations]), rotations])
    basis: Array = canonical @ generators(algebra)
    return basis


def describe_twists(twists: Iterable[Multivector]) -> str:
    """Description of twists: "the translation along (0, 0, 1) and the rotation about the line through .."."""
    parts = [_describe(twist) for twist in twists]
    return " and ".join([", ".join(parts[:-1]), parts[-1]] if len(parts) > 1 else parts)


def _describe(twist: Multivector) -> str:
    decomposition = screw(-twist)  # exp(b) rotates about the axis of -b
    axis, pitch = decomposition.axis.parameters(), float(decomposition.pitch)
    if math.isinf(pitch):
        return f"the translation along {_vector_text(axis.direction)}"
    line = f"the line through {_vector_text(axis.point)} along {_vector_text(axis.direction)}"
    if abs(pitch) <= MIN_PITCH * max(1.0, math.hypot(*axis.point, pitch)):
        return f"the rotation about {line}"
    return f"the screw motion about {line} by {2 * math.pi * pitch:.{DIGITS}g} a turn"


def _vector_text(v: Array) -> str:
    rounded = np.round(v, DIGITS - 1) + 0.0  # no -0
    return f"({', '.join(f'{x:.{DIGITS}g}' for x in rounded)})"
