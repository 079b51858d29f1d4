"""Joints of several freedoms among the coordinates of a tree: balls, planes, roots that float.

Their coordinates are those of Pinocchio: x, y, z, then a unit quaternion x, y, z, w (floating); the quaternion (ball);
x, y, cosine and sine (planar). Speeds are components of a twist in the frame of the child: velocity of its origin, then
angular velocity (floating); angular velocity (ball); two of the velocity and that of the rotation (planar).
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import InputError

Array = NDArray[Any]
#: Numbers of coordinates and of speeds by type of joint.
SIZES = {"ball": (4, 3), "planar": (4, 3), "floating": (7, 6)}
#: Coordinates where the joint is at zero.
NEUTRAL = {
    "ball": (0.0, 0.0, 0.0, 1.0), "planar": (0.0, 0.0, 1.0, 0.0), "floating": (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0),
}  # fmt: skip
#: A rotation whose squared norm is so far from 1 is not unit, even if it was rounded to single precision.
NOT_UNIT = 1e-5
#: Quaternions whose real part is first look so: the first number of each is nearly all of its length.
NEAR_ONE = 0.99
#: Numbers of a frame in the tree's own coordinates: position and rotor.
FRAME_SIZE = 7
_UNIT = np.eye(3)


def freedoms(kind: str) -> list[tuple[Array, float, float]]:
    """Axis, rotation and advance of each freedom, in the frame of the joint."""
    slides, turns = [(e, 0.0, 1.0) for e in _UNIT], [(e, 1.0, 0.0) for e in _UNIT]
    return {"ball": turns, "planar": [*slides[:2], turns[2]], "floating": [*slides, *turns]}[kind]


@dataclass(frozen=True, eq=False)
class FrameJoint:
    """A joint of several freedoms.

    Attributes
    ----------
    name, kind : str
    start : int
        Index of its first number among the coordinates that users give.
    place : int
        The same among those of the tree's driver, where it has seven: position and rotor.
    row : int
        Its first freedom among the driver's joints.
    rotation : array (3, 3)
        From the joint's axes to those of the driver.
    """

    name: str
    kind: str
    start: int
    place: int
    row: int
    rotation: Array

    def frame(self, q: Array) -> Array:
        """Positions and rotors (..., 7) in the driver's axes, from the coordinates (..., n) of all joints.

        Raises
        ------
        InputError
            If a quaternion, or a cosine and sine, is not unit.
        """
        x = q[..., self.start : self.start + SIZES[self.kind][0]]
        self._check(x)
        position, quaternion = np.zeros((*x.shape[:-1], 3)), np.zeros((*x.shape[:-1], 4))
        if self.kind == "planar":
            position[..., :2] = x[..., :2]
            half = np.arctan2(x[..., 3], x[..., 2]) / 2
            quaternion[..., 2], quaternion[..., 3] = np.sin(half), np.cos(half)
        else:
            quaternion[...] = x[..., -4:]
            if self.kind == "floating":
                position[...] = x[..., :3]
        i, j, k = np.moveaxis(quaternion[..., :3] @ self.rotation.T, -1, 0)
        rotor = np.stack([quaternion[..., 3], -k, j, -i], -1)
        return np.concatenate([position @ self.rotation.T, rotor], -1)

    def coordinates(self, position: Array, rotor: Array) -> Array:
        """The joint's coordinates (..., k) of a displacement: position (..., 3) and rotor (..., 4) in driver's axes."""
        w, k, j, i = np.moveaxis(rotor * (1, -1, 1, -1), -1, 0)
        vector, p = np.stack([i, j, k], -1) @ self.rotation, position @ self.rotation
        if self.kind == "planar":
            angle = 2 * np.arctan2(vector[..., 2], w)
            return np.concatenate([p[..., :2], np.cos(angle)[..., None], np.sin(angle)[..., None]], -1)
        quaternion = np.concatenate([vector, w[..., None]], -1)
        return quaternion if self.kind == "ball" else np.concatenate([p, quaternion], -1)

    def _check(self, x: Array) -> None:
        unit = x[..., 2:] if self.kind == "planar" else x[..., -4:]
        if self.kind != "planar" and x.size and bool((np.abs(unit[..., 0]) > NEAR_ONE).all()):
            warnings.warn(
                f"the quaternions of {self.name!r} are half turns about x: their order is x, y, z, w, real part last.",
                stacklevel=5,
            )
        off = np.abs((unit * unit).sum(-1) - 1) >= NOT_UNIT  # false where it is not finite: those items are INVALID
        if not off.any():
            return
        first = unit[tuple(np.argwhere(off)[0])] if off.ndim else unit
        what, order = ("cosine and sine", "x, y, cos, sin")
        if self.kind != "planar":
            what, order = "quaternion", "x, y, z, qx, qy, qz, qw" if self.kind == "floating" else "qx, qy, qz, qw"
        raise InputError(
            f"the {what} {np.array2string(first, precision=6)} of {self.name!r} is not unit: its length is "
            f"{np.linalg.norm(first):.6g}.",
            remedy=f"Coordinates of a joint that is {self.kind} are {order}; or give a motor by name",
        )

    def rate(self, frames: Array, joint: Array) -> Array:
        """Rate (..., 7) of frames (..., 7) of the driver at a unit of speed of one of its joints (8,)."""
        axis, turns, advance = joint[3:6], joint[6], joint[7]
        w, k, j, i = np.moveaxis(frames[..., 3:] * (1, -1, 1, -1), -1, 0)
        v = np.stack([i, j, k], -1)
        square = (w * w + (v * v).sum(-1))[..., None]
        t = 2 * np.cross(v, axis) / square
        position = advance * (axis + w[..., None] * t + np.cross(v, t))
        real = -(v @ axis) * (turns / 2)
        i, j, k = np.moveaxis((w[..., None] * axis + np.cross(v, axis)) * (turns / 2), -1, 0)
        return np.concatenate([position, np.stack([real, -k, j, -i], -1)], -1)
