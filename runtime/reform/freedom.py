"""Motions that leave a model, or matches, as they are: found from how they resist, and told in words."""

from __future__ import annotations

import math
from collections.abc import Iterable
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..algebras import Algebra
from ..multivector import Multivector
from ..objects.screws import screw

Array = NDArray[Any]
#: A motion is free if it is resisted less than this, relative to the most; and nearly free.
FREE, NEARLY_FREE = 1e-9, 1e-6
#: A motion is as good as free if its twist is known no better than this (standard deviation; half of an angle, or of
#: a shift in the models' unit of length): too far for what is linear in it.
UNKNOWN = 0.1
#: Angles, against shifts by the unit of length, that count as none: what is left is a translation.
NO_TURN = 0.05
#: Pitches below this, in units of length, are none: the motion is a rotation.
NO_PITCH = 1e-3
#: Digits of numbers in words.
DIGITS = 4


@cache
def generators(algebra: Algebra) -> Array:
    """Twists (6, 6), as rows: of a unit rotation about each axis through the origin, then of unit translations."""
    axes = np.eye(3)
    turns = algebra.rotor(axes, np.ones(3)).log()
    shifts = algebra.translator(axes).log()
    blades = list(algebra.kind("twist").blades)
    rows = np.zeros((6, 6))
    for k, part in enumerate((turns, shifts)):
        places = [blades.index(blade) for blade in part._type.blades]
        rows[3 * k : 3 * k + 3, places] = part._data
    return rows


def free_motions(modes: tuple[Array, Array], covariance: Array | None = None, least: float = FREE) -> Array:
    """Twists (m, 6) that a symmetric matrix, given by its modes (`polish.modes_of`), resists less than that, or that a
    covariance does not tell.
    """
    values, vectors = modes
    free = values <= least * max(float(values[-1]), 0.0)
    if not free.any() and covariance is not None and covariance.trace() > UNKNOWN * UNKNOWN:  # else none is unknown
        values, vectors = np.linalg.eigh(covariance)
        free = values > UNKNOWN * UNKNOWN
    found: Array = vectors[:, free].T
    return found


def told(twists: Array, algebra: Algebra) -> Array:
    """A basis (m, 6) of what some twists span that reads well: translations first, then turns about lines.

    Translations and the axes of the others are at right angles. A turn that is small against its shift is none.
    """
    if not len(twists):
        return twists
    rows = twists @ np.linalg.inv(generators(algebra))
    u, sizes, _ = np.linalg.svd(rows[:, :3])
    count = int((sizes > NO_TURN * np.linalg.norm(rows, axis=1).max()).sum())
    turns, rest = u[:, :count].T @ rows, u[:, count:].T @ rows
    shifts = np.linalg.svd(rest[:, 3:])[2][: len(rest)] if len(rest) else np.empty((0, 3))
    turns /= np.linalg.norm(turns[:, :3], axis=1, keepdims=True)
    turns[:, 3:] -= turns[:, 3:] @ shifts.T @ shifts
    named = np.concatenate([np.hstack([np.zeros_like(shifts), shifts]), turns])
    found: Array = named @ generators(algebra)
    return found


def in_words(twists: Iterable[Multivector]) -> str:
    """What some twists do: "the translation along (0, 0, 1) and the rotation about the line through .."."""
    parts = [_words(twist) for twist in twists]
    return " and ".join([", ".join(parts[:-1]), parts[-1]] if len(parts) > 1 else parts)


def _words(twist: Multivector) -> str:
    found = screw(-twist)  # exp(b) turns about the axis of -b
    axis, pitch = found.axis.parameters(), float(found.pitch)
    if math.isinf(pitch):
        return f"the translation along {_vector(axis.direction)}"
    line = f"the line through {_vector(axis.point)} along {_vector(axis.direction)}"
    if abs(pitch) <= NO_PITCH * max(1.0, math.hypot(*axis.point, pitch)):
        return f"the rotation about {line}"
    return f"the screw motion about {line} by {2 * math.pi * pitch:.{DIGITS}g} a turn"


def _vector(v: Array) -> str:
    rounded = np.round(v, DIGITS - 1) + 0.0  # no -0
    return f"({', '.join(f'{x:.{DIGITS}g}' for x in rounded)})"
