"""A compiled tree of links, and the coordinates of its joints."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .driver import TreeDriver
from .frame_joints import FRAME_SIZE, NEUTRAL, SIZES, FrameJoint

Array = NDArray[Any]


@dataclass(frozen=True, eq=False)
class Tree:
    """Links on joints, compiled.

    Attributes
    ----------
    driver : TreeDriver
        Of joints in an order in which parents come first; a joint of several freedoms is one for each.
    movers : integer array (n,), optional
        For each of these its number in the order of speeds, of which several may share one; default: the same.
    frames : tuple of FrameJoint
        Joints of several freedoms.
    sources : integer array (n,), optional
        Where there are some, for each joint the index of its coordinate; -1 for theirs.
    """

    driver: TreeDriver
    movers: NDArray[np.int64] | None = None
    frames: tuple[FrameJoint, ...] = ()
    sources: NDArray[np.int64] | None = None

    @property
    def count(self) -> int:
        """Number of speeds, accelerations and forces."""
        return self.driver.count if self.movers is None else int(self.movers.max()) + 1

    @property
    def coordinate_count(self) -> int:
        """Number of coordinates: as many, but for joints of several freedoms."""
        return self.count + sum(a - b for a, b in (SIZES[frame.kind] for frame in self.frames))

    @property
    def neutral(self) -> Array:
        """Coordinates (n,) where all joints are at zero."""
        q = np.zeros(self.coordinate_count)
        for frame in self.frames:
            q[frame.start : frame.start + len(NEUTRAL[frame.kind])] = NEUTRAL[frame.kind]
        return q

    @property
    def is_shared(self) -> bool:
        """Whether joints share a coordinate."""
        return self.count < self.driver.count

    def positions(self, q: Array) -> Array:
        """Coordinates (..., m) as the driver has them, from those (..., n) that users give.

        Raises
        ------
        InputError
            If a quaternion is not unit.
        """
        if self.sources is None:
            return self.sorted(q)
        own = self.sources >= 0
        x = np.empty((*q.shape[:-1], int(own.sum()) + FRAME_SIZE * len(self.frames)))
        x[..., self.driver.places[own]] = q[..., self.sources[own]]
        for frame in self.frames:
            x[..., frame.place : frame.place + FRAME_SIZE] = frame.frame(q)
        return x

    def directions(self, x: Array) -> list[Array]:
        """Rates of the driver's coordinates, (m,) or (items, m), at a unit of speed of each of its joints.

        Parameters
        ----------
        x : array (m,) or (items, m)
            Of `positions`.
        """
        found = list[Array]()
        if not self.frames:
            return list(np.eye(self.driver.count))
        frames = {row: frame for frame in self.frames for row in range(frame.row, frame.row + SIZES[frame.kind][1])}
        for row in range(self.driver.count):
            frame = frames.get(row)
            rate = np.zeros(x.shape[-1] if frame is None else x.shape)
            if frame is None:
                rate[self.driver.places[row]] = 1.0
            else:
                part = slice(frame.place, frame.place + FRAME_SIZE)
                rate[..., part] = frame.rate(x[..., part], self.driver.joints[row])
            found.append(rate)
        return found

    def sorted(self, x: Array) -> Array:
        """Numbers of joints (..., n) in the driver's order, from those of speeds."""
        return x if self.movers is None else x[..., self.movers]

    def restored(self, x: Array) -> Array:
        """Numbers of coordinates (..., k): of each joint, or sums over those that share one."""
        if self.movers is None:
            return x
        result = np.zeros((*x.shape[:-1], self.count))
        for j, mover in enumerate(self.movers.tolist()):
            result[..., mover] += x[..., j]
        return result

    def restored_matrices(self, matrices: Array) -> Array:
        """Matrices (..., k, k) of coordinates, from those (..., n, n) of joints."""
        if self.movers is None:
            return matrices
        if not self.is_shared:
            back = np.argsort(self.movers)
            return np.ascontiguousarray(matrices[..., back[:, None], back])
        return np.swapaxes(self.restored(np.swapaxes(self.restored(matrices), -1, -2)), -1, -2)
