"""The workspace of a Delta robot, sampled in a box: what is reached, and how well the arms move the platform there."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .. import arrays
from ..codegen.errors import InputError, ShapeError
from ..status import Status

if TYPE_CHECKING:
    from .delta import DeltaRobot

Array = NDArray[Any]
#: The most positions along a side, and in all: some 2 GB.
MOST, MOST_IN_ALL = 2001, 20_000_000


@dataclass(frozen=True, eq=False)
class Workspace:
    """Samples on a grid of positions.

    Attributes
    ----------
    robot : DeltaRobot
    x, y, z : array (nx,), (ny,), (nz,)
        Coordinates of the samples.
    reachable : bool array (nx, ny, nz)
    condition : array (nx, ny, nz)
        Condition number of the Jacobian, 1 at best; infinite at singular poses, NaN where none is.
    inverse : array (nx, ny, nz)
        The least sine of an arm, 0 where one is stretched or folded: see `Singularity.sines`.
    forward : array (nx, ny, nz)
        The volume of the unit forearms without its sign, 0 where the platform is not held: see `Singularity.volume`.
    arms : uint8 array (nx, ny, nz, 3)
        `Status` of each arm.
    """

    robot: DeltaRobot
    x: Array
    y: Array
    z: Array
    reachable: NDArray[np.bool_]
    condition: Array
    inverse: Array
    forward: Array
    arms: NDArray[np.uint8]

    @property
    def positions(self) -> Array:
        """All samples, (nx, ny, nz, 3)."""
        return np.stack(np.meshgrid(self.x, self.y, self.z, indexing="ij"), -1)

    @property
    def volume(self) -> float:
        """Of what is reached, each sample standing for a cell of the grid."""
        sides = [float(a[-1] - a[0]) / max(len(a) - 1, 1) for a in (self.x, self.y, self.z)]
        return float(self.reachable.sum()) * float(np.prod(sides))

    def well(self, condition: float) -> NDArray[np.bool_]:
        """Where the condition number is at most so much."""
        with np.errstate(invalid="ignore"):
            return np.asarray(self.condition <= condition)

    def __repr__(self) -> str:
        share = float(self.reachable.mean()) if self.reachable.size else 0.0
        return f"<Workspace of {self.robot!r}: {' x '.join(map(str, self.reachable.shape))}, {share:.1%} reached>"


def workspace(robot: DeltaRobot, bounds: Any, points: Any, elbow: Any, threads: int | None) -> Workspace:
    """Sample a box.

    Parameters
    ----------
    bounds : array (3, 2), optional
        Least and greatest coordinate along e1, e2, e3. Default: the box of all that the arms might reach on the e3
        side of the base.
    points : int, or three of them
        Samples along each side.
    elbow, threads
        As of `DeltaRobot.inverse`.

    Raises
    ------
    InputError, ShapeError
        For bounds that are no box, or numbers of samples that are none or too many.
    """
    counts = _counts(points)
    low, high = _box(robot, bounds)
    axes = [
        np.linspace(a, b, n) if n > 1 else np.array([(a + b) / 2]) for a, b, n in zip(low, high, counts, strict=True)
    ]
    places = np.stack(np.meshgrid(*axes, indexing="ij"), -1)
    jacobian, codes = robot.inverse_jacobian(places, elbow=elbow, status=True, threads=threads)
    measures = robot.singularity_at(places, elbow)
    reachable = (codes == Status.OK) | (codes == Status.SINGULAR)
    known = codes == Status.OK
    condition = np.where(reachable, np.inf, np.nan)
    condition[known] = np.linalg.cond(jacobian[known]) if known.any() else 0.0
    least, volume = np.abs(measures.sines).min(-1), np.abs(measures.volume)
    x, y, z = axes
    return Workspace(robot, x, y, z, reachable, condition, least, volume, robot.arm_status(places, elbow))


def _counts(points: Any) -> tuple[int, int, int]:
    given = [points] * 3 if np.ndim(points) == 0 else list(points)
    if len(given) != 3:
        raise ShapeError(f"points has {len(given)} entries; one, or one for each of the three sides, is meant.")
    for n in given:
        if isinstance(n, bool) or not isinstance(n, int | np.integer) or not 1 <= n <= MOST:
            raise InputError(f"points is {points!r}; a side has from 1 to {MOST} of them.")
    if int(np.prod([int(n) for n in given], dtype=np.int64)) > MOST_IN_ALL:
        raise InputError(
            f"points is {points!r}; a box has at most {MOST_IN_ALL}.", remedy="Take fewer, or parts of the box"
        )
    return int(given[0]), int(given[1]), int(given[2])


def _box(robot: DeltaRobot, bounds: Any) -> tuple[Array, Array]:
    if bounds is None:
        arm = robot.upper_arm + robot.forearm
        side = max(arm - abs(robot.base_radius - robot.effector_radius), 0.0)
        return np.array([-side, -side, 0.0]), np.array([side, side, arm])
    box = np.asarray(arrays.real(bounds, "bounds"), np.float64)
    if box.shape != (3, 2):
        raise ShapeError(f"bounds has shape {box.shape}; it is (3, 2), the least and greatest of each coordinate.")
    if not np.isfinite(box).all() or (box[:, 0] > box[:, 1]).any():
        raise InputError("bounds are no box: each row is a least and a greatest finite coordinate.")
    return box[:, 0], box[:, 1]


__all__ = ["Workspace", "workspace"]
