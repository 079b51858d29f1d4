"""How near poses of the Delta robot are to singular ones, and what is lost there."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from . import delta_calls as calls

if TYPE_CHECKING:
    from .delta import DeltaRobot

Array = NDArray[Any]


class Singularity(NamedTuple):
    """Measures of poses; NaN where there is no pose.

    Attributes
    ----------
    sines : array (..., 3)
        Of each arm, forearm against the elbow's path, between -1 and 1: zero where upper arm and forearm's projection
        are in one line (an inverse singularity). The motor then cannot move the platform along this forearm.
    volume : array (...)
        Of the parallelepiped of the three unit forearms, between -1 and 1: zero where they are parallel to one plane
        (a forward singularity). The motors then do not hold the platform across it.
    forearms : array (..., 3, 3)
        Unit vectors along the forearms, from elbow to platform: the direction lost where an arm's sine is zero.
    free : array (..., 3)
        Unit vector along which the motors hold the platform least: the direction left free where the volume is zero.
    hold : array (...)
        How much they do, the least singular value of the forearms' directions: from 0 to 1.
    """

    sines: Array
    volume: Array
    forearms: Array
    free: Array
    hold: Array

    @property
    def lost(self) -> Array:
        """Direction (..., 3) of the arm whose sine is nearest zero: the worst to move along."""
        worst = np.abs(np.nan_to_num(self.sines, nan=np.inf)).argmin(-1)
        return np.take_along_axis(self.forearms, worst[..., None, None], -2)[..., 0, :]


def singularity(robot: DeltaRobot, theta: Array, y: Array) -> Singularity:
    """The measures of poses whose angles and positions belong together."""
    (sines, volume, forearms), _ = calls.evaluate("delta_frame.singularities", [y, theta, robot._row])
    known = np.asarray(np.isfinite(y).all(-1) & np.isfinite(theta).all(-1))
    sines, forearms = (np.where(known[..., None], x, np.nan) for x in (sines, forearms))
    forearms = forearms.reshape(*forearms.shape[:-1], 3, 3)
    _, values, rows = np.linalg.svd(np.where(known[..., None, None], forearms, np.eye(3)))
    free = np.where(known[..., None], rows[..., 2, :], np.nan)
    volume = np.where(known, volume[..., 0], np.nan)
    return Singularity(sines, volume, forearms, free, np.where(known, values[..., 2], np.nan))


__all__ = ["Singularity", "singularity"]
