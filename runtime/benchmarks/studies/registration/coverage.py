"""Coverage of the 95 % ellipsoid of a registration's covariance: the fraction of trials whose true pose is inside."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from ...harness.algebras import cga3d
from ...harness.study import Array, Case, Method, Study
from .poses import RIGHT, Scenes, describe, pose_errors, register_each, scenes, true_poses

#: Squared radius of the 95 % ellipsoid of six normal variables (chi squared, six degrees of freedom).
LIMIT = 12.591587243743977
WRONG: dict[str, Any] = {"outliers": 0.3, "missing": 0.3}


def squared_radii(inputs: Scenes, _: None) -> Array:
    """b . C^-1 b for each scene, with b the twist from the estimated pose to the true one and C its covariance."""
    radii = np.full(len(inputs.items), np.nan)
    for i, (scene, result) in enumerate(zip(inputs.items, register_each(inputs), strict=True)):
        if pose_errors(result.motor.to_matrix()[None], scene.pose[None])[0] <= RIGHT:
            away = cga3d.motor_from_matrix(scene.pose) * ~result.motor
            twist = np.asarray((away if away["1"] > 0 else -away).log().values)
            radii[i] = twist @ np.linalg.solve(result.covariance, twist)
    return radii


def error(squares: Array, _: Array, __: Scenes) -> Array:
    """Radii over that of the 95 % ellipsoid; infinite outside it."""
    radii = np.sqrt(squares / LIMIT)
    return np.where(radii <= 1, radii, np.inf)


MIXED = {"line": 10, "plane": 10}
NATURES: tuple[tuple[str, dict[str, int], dict[str, Any]], ...] = (
    ("20 lines, noise 0.01", {"line": 20}, {"noise": 1e-2}),
    ("20 lines, noise 0.01, 30 % wrong and missing", {"line": 20}, {"noise": 1e-2, **WRONG}),
    ("100 lines, noise 0.001, 30 % wrong and missing", {"line": 100}, {"noise": 1e-3, **WRONG}),
    ("10 lines, 10 planes, noise 0.01", MIXED, {"noise": 1e-2}),
    ("30 points, noise 0.01, 30 % wrong and missing", {"point": 30}, {"noise": 1e-2, **WRONG}),
    ("30 planes, noise 0.01", {"plane": 30}, {"noise": 1e-2}),
)

STUDY = Study(
    name="coverage",
    title="How far a pose is off, and what its covariance says",
    methods=(Method("95 % ellipsoid", squared_radii, repeats=0),),
    cases=tuple(Case(name, partial(scenes, counts=counts, **options)) for name, counts, options in NATURES),
    reference=true_poses,
    error=error,
    describe=describe,
    unit="of the 95 % ellipsoid's radius",
    count=200,
    promised=0.95,
    source="thesis chapter 5",
    notes="Lost are trials whose true pose is outside the 95 % ellipsoid of the pose that was found: one of twenty is "
    "right, fewer or more is not. Poses that are not right at all are lost too.",
)
