"""Joints over time: coordinates, rates and reactions, from the motions of the bodies that they connect."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from ...codegen.errors import InputError
from ...core.multivector import Multivector
from ...mechanics.joints.freedoms import Freedoms
from ...mechanics.system import System
from .states import TrajectoryStates

Array = NDArray[Any]


class JointMotion:
    """Motion of a joint's second body relative to its first, over time.

    Parameters
    ----------
    system : System
    index : int
        Of the joint.
    bodies : mapping of str to TrajectoryStates
    """

    def __init__(self, system: System, index: int, bodies: Mapping[str, TrajectoryStates]) -> None:
        self._joint, self._system, self._bodies = system.joints[index], system, bodies
        freedoms = system.freedoms[index]
        if freedoms is None:
            raise InputError(
                f"{self._joint.label} has no coordinates: it is no sequence of rotations and translations.",
                remedy="Take the motors of its bodies",
            )
        self.freedoms: Freedoms = freedoms

    def _displacement(self, name: str) -> tuple[Array, Array, Array, Array]:
        """Rotation and translation of a body since the start, its angular velocity and that of the world's origin."""
        if name == self._system.fixed:
            return np.eye(3), np.zeros(3), np.zeros(3), np.zeros(3)
        body, states = self._system.bodies[name], self._bodies[name]
        start = body.rotation if body.rotation.ndim == 2 else body.rotation[:, None]
        center = body.position if body.position.ndim == 1 else body.position[:, None]
        rotation = states.orientation @ np.swapaxes(start, -1, -2)
        position = states.position
        spin = np.einsum("...ij,...j->...i", states.orientation, states.angular_velocity)
        translation = position - np.einsum("...ij,...j->...i", rotation, center)
        return rotation, translation, spin, states.velocity - np.cross(spin, position)

    def _relative(self) -> tuple[Array, Array, Array, Array]:
        """Rotation, path of the joint's point, angular velocity and its velocity, along axes of the first body."""
        (ra, ta, wa, va), (rb, tb, wb, vb) = (self._displacement(name) for name in (self._joint.a, self._joint.b))
        back, point = np.swapaxes(ra, -1, -2), self.freedoms.position
        moved = rb @ point + tb
        path = np.einsum("...ij,...j->...i", back, moved - ta) - point
        velocity = vb - va + np.cross(wb - wa, moved)
        turned = [np.einsum("...ij,...j->...i", back, x) for x in (wb - wa, velocity)]
        return back @ rb, path, turned[0], turned[1]

    def coordinates(self) -> Array:
        """Coordinates (..., stores, k) from those at the start."""
        rotation, path, _, _ = self._relative()
        freedoms = self.freedoms
        axes, turning = freedoms.axes[~freedoms.turns], freedoms.axes[freedoms.turns]
        found = [path @ axis for axis in axes]
        if freedoms.is_ball:
            flat = np.reshape(rotation, (-1, 3, 3))
            return np.asarray(Rotation.from_matrix(flat).as_rotvec().reshape(*rotation.shape[:-2], 3))
        if len(turning) == 2:  # where the first axis has turned the second one, which that leaves as it is
            image = rotation @ turning[1]
            angle = _angle(turning[0], np.broadcast_to(turning[1], image.shape), image)
            found.append(np.unwrap(angle))
            first = Rotation.from_rotvec(np.reshape(angle[..., None] * turning[0], (-1, 3))).as_matrix()
            rotation = np.swapaxes(first.reshape(rotation.shape), -1, -2) @ rotation
        if len(turning):
            axis = turning[-1]
            across = np.cross(axis, np.eye(3)[np.abs(axis).argmin()])
            angle = np.unwrap(_angle(axis, np.broadcast_to(across, rotation.shape[:-1]), rotation @ across))
            if freedoms.pitch:  # how far it has come says which turn
                angle += 2 * np.pi * np.round((path @ axis / freedoms.pitch - angle) / (2 * np.pi))
            found.append(angle)
        return np.stack(found, -1) if found else np.zeros((*path.shape[:-1], 0))

    def rates(self) -> Array:
        """Speeds (..., stores, k); those of a ball are the angular velocity along the second body's axes."""
        rotation, _, spin, velocity = self._relative()
        freedoms = self.freedoms
        if freedoms.is_ball:
            return np.asarray(np.einsum("...ji,...j->...i", rotation, spin))
        axes, turning = freedoms.axes[~freedoms.turns], freedoms.axes[freedoms.turns]
        found = [velocity @ axis for axis in axes] + [spin @ axis for axis in turning[:1]]
        if len(turning) == 2:
            found.append(((rotation @ turning[1]) * spin).sum(-1))
        return np.stack(found, -1) if found else np.zeros((*spin.shape[:-1], 0))


def _angle(axis: Array, before: Array, after: Array) -> Array:
    """Angles about an axis that take vectors across it to others."""
    return np.asarray(np.arctan2(np.cross(before, after) @ axis, (before * after).sum(-1)))


def reaction_of_joint(system: System, index: int, bodies: Mapping[str, TrajectoryStates]) -> Multivector:
    """Wrench of a joint on its second body, in the world, moments about its origin; of what pulls along it no part.

    Raises
    ------
    InputError
        If the joint is in a loop.
    """
    cut = system.joints[index]
    behind, before = (_side(system, index, name) for name in (cut.b, cut.a))
    if cut.a in behind or (system.fixed in behind and system.fixed in before):
        raise InputError(
            f"{cut.label} is in a loop, whose joints share their reactions.", remedy="Take those of the bodies"
        )
    if system.fixed in behind:
        return -_sum_of_reactions(bodies, before)
    return _sum_of_reactions(bodies, behind)


def _side(system: System, index: int, start: str) -> list[str]:
    """Bodies, and the world, that hang together with one of them if a joint is cut; nothing goes through the world."""
    found, waiting = [start], [start]
    while waiting:
        name = waiting.pop()
        if name == system.fixed:
            continue
        for i, joint in enumerate(system.joints):
            if i != index and name in (joint.a, joint.b):
                other = joint.b if joint.a == name else joint.a
                if other not in found:
                    found.append(other)
                    waiting.append(other)
    return found


def _sum_of_reactions(bodies: Mapping[str, TrajectoryStates], names: list[str]) -> Multivector:
    first, *others = names
    total: Multivector = bodies[first].reaction
    for name in others:
        total = total + bodies[name].reaction
    return total


__all__ = ["JointMotion", "reaction_of_joint"]
