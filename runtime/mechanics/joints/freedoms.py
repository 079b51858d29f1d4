"""Freedoms of joints: the motions, one after the other, of which a joint's displacements are made."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...core.geometry.euclidean import perpendicular
from ..twists import screw_vectors
from .base import Joint
from .local_relations import Frame, Relation, relations

if TYPE_CHECKING:
    from ...core.multivector import Algebra

Array = NDArray[Any]


@dataclass(frozen=True, eq=False)
class Freedoms:
    """Motions of the second body of a joint relative to the first, in the world where the bodies are at the start.

    Attributes
    ----------
    position : array (3,)
        A point that all axes pass through.
    axes : array (k, 3)
        Unit vectors, in the order from the first body to the second.
    turns : bool array (k,)
        Rotations, counter-clockwise; others are translations.
    is_ball : bool
        Three rotations about axes x, y, z, whose coordinates are a rotation vector.
    pitch : float
        Of a rotation by itself: its translation along the axis, for each radian.
    """

    position: Array
    axes: Array
    turns: NDArray[np.bool_]
    is_ball: bool = False
    pitch: float = 0.0

    @property
    def advances(self) -> Array:
        """Translations along the axes (k,) for a unit of each coordinate."""
        return np.where(self.turns, self.pitch, 1.0)

    def columns(self) -> Array:
        """Unit twists (k, 6) at the start: angular velocity, and the velocity of the point."""
        return np.hstack([self.axes * self.turns[:, None], self.axes * self.advances[:, None]])

    def reversed(self) -> Freedoms:
        """The motions of the first body relative to the second, of the same coordinates."""
        if self.is_ball:  # the rotation vector changes its sign
            return self
        return Freedoms(self.position, -self.axes[::-1], self.turns[::-1], pitch=self.pitch)


def joint_freedoms(algebra: Algebra, joints: Sequence[Joint]) -> list[Freedoms | None]:
    """Freedoms of joints; None for one that is not made of a sequence of motions, or is not closed at the start."""
    known = [joint for joint in joints if _is_known(joint)]
    if not known:
        return [None] * len(joints)
    found, frame = relations(algebra, known)
    by_joint = {id(j): _freedoms(algebra, j, r, frame) for j, r in zip(known, found, strict=True)}
    return [by_joint.get(id(joint)) for joint in joints]


def _is_known(joint: Joint) -> bool:
    return joint.is_sequence and getattr(joint, "other", None) is None and getattr(joint, "other_point", None) is None


def _freedoms(algebra: Algebra, joint: Joint, relation: Relation, frame: Frame) -> Freedoms:
    given = joint.rotations()
    if given is not None:
        return Freedoms(*given, np.ones(len(given[1]), bool))
    turning, moment = screw_vectors(algebra, relation.free.T)
    turns = np.linalg.norm(turning, axis=-1) > 0.5
    axes = np.where(turns[:, None], turning, moment)
    axes = axes / np.linalg.norm(axes, axis=-1, keepdims=True) if len(axes) else np.zeros((0, 3))
    feet = np.cross(turning[turns], moment[turns])  # the point of an axis that is nearest to the frame's center
    count = int(turns.sum())
    position = frame.center if not count else frame.center + frame.unit * feet.sum(0) / max(1, count - 1)
    if joint.pitch is not None:
        return Freedoms(position, axes, turns, pitch=joint.pitch)
    if count == 3:
        return Freedoms(position, np.eye(3), turns, is_ball=True)
    if count == 1 and len(turns) == 3:  # along two directions of the plane
        first = perpendicular(axes[0])
        first = first / np.linalg.norm(first)
        axes = np.stack([axes[0], np.cross(axes[0], first), first])
    return Freedoms(position, axes[::-1], turns[::-1])
