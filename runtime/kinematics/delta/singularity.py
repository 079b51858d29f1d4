"""Singularity measures of the Delta robot, and the directions that are lost or free at singular poses."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...common.deprecation import renamed_attribute
from . import evaluation as calls
from .geometry import DeltaGeometry

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
    def lost_direction(self) -> Array:
        """Direction (..., 3) of the arm whose sine is nearest zero: the worst to move along."""
        worst = np.abs(np.nan_to_num(self.sines, nan=np.inf)).argmin(-1)
        return np.take_along_axis(self.forearms, worst[..., None, None], -2)[..., 0, :]


Singularity.lost = renamed_attribute("lost_direction")  # type: ignore[attr-defined]  # its body has fields only


def singularity(geometry: DeltaGeometry, theta: Array, y: Array) -> Singularity:
    """Measures of poses whose angles and positions belong together."""
    (sines, volume, forearms), _ = calls.evaluate("delta_frame.singularities", [y, theta, geometry.parameters])
    valid = np.asarray(np.isfinite(y).all(-1) & np.isfinite(theta).all(-1))
    sines, forearms = (np.where(valid[..., None], x, np.nan) for x in (sines, forearms))
    forearms = forearms.reshape(*forearms.shape[:-1], 3, 3)
    _, values, rows = np.linalg.svd(np.where(valid[..., None, None], forearms, np.eye(3)))
    free = np.where(valid[..., None], rows[..., 2, :], np.nan)
    volume = np.where(valid, volume[..., 0], np.nan)
    return Singularity(sines, volume, forearms, free, np.where(valid, values[..., 2], np.nan))


__all__ = ["Singularity", "singularity"]
