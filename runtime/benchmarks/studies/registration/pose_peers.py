"""What others do with the scenes of `poses`: REFORM of the package `clifford`, and registration of points that are
sampled from the lines, by Open3D and small_gicp. Each where it is installed.

They are treated well: lines of both models have one orientation, and points come from the same segments of both, so
that the ends are known, which lines do not have.
"""

from __future__ import annotations

import contextlib
import io
import random
import warnings
from functools import cache
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .poses import Scene

Array = NDArray[Any]
#: Distance between points of a line; within which normals and features are estimated; up to which points may be one.
SPACING, NORMALS, FEATURES, REACH = 0.05, 0.2, 0.5, 0.1
#: Reaches of local registration, in turn: the first for displacements of a tenth of the models.
LOCAL_REACHES, FINAL_REACHES = (0.2, 0.1), (0.1, 0.05)
#: Neighbours of a point at most, for its normal and for its feature.
NEAR_NORMAL, NEAR_FEATURE = 30, 100
#: Points of a sample; how alike its edges are at least; with which probability RANSAC ends.
SAMPLE, EDGES, CONFIDENCE = 3, 0.9, 0.999
DESCENTS = 100
#: `clifford`: rounds of matching, and objects of a sample (its default).
ROUNDS, OBJECTS = 10, 5


@cache
def installed(name: str) -> Any:
    """The module, or None: also where a library of the system that it needs is missing."""
    try:
        return import_module(name)
    except (ImportError, OSError):
        return None


def points(ends: Array, rng: np.random.Generator) -> Array:
    """Points of segments (n, 2, 3), `SPACING` apart; the first of each segment anywhere."""
    lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    count = max(2, round(float(lengths.mean()) / SPACING))
    along = (np.arange(count) + rng.random((len(ends), 1))) / count
    found: Array = ends[:, None, 0] + along[..., None] * (ends[:, None, 1] - ends[:, None, 0])
    return found.reshape(-1, 3)


def clouds(scene: Scene) -> tuple[Array, Array]:
    """Points of the query and of the reference: never the same ones of a line."""
    rng = np.random.default_rng(len(scene.query))
    return points(scene.query_ends, rng), points(scene.reference_ends, rng)


# -- points, from where the query stands -------------------------------------------------------------------


def descended(query: Array, reference: Array, pose: Array, reaches: tuple[float, ...]) -> Array:
    """GICP from a pose, at falling reaches."""
    gicp = installed("small_gicp")
    for reach in reaches:
        found = gicp.align(
            reference, query, pose, registration_type="GICP", downsampling_resolution=SPACING / 2,
            max_correspondence_distance=reach, num_threads=1, max_iterations=DESCENTS,
        )  # fmt: skip
        pose = np.asarray(found.T_target_source)
    return pose


def local(scene: Scene) -> Array:
    """GICP of small_gicp from where the query stands."""
    return descended(*clouds(scene), np.eye(4), LOCAL_REACHES)


# -- points, from anywhere ---------------------------------------------------------------------------------


def anywhere(scene: Scene, samples: int) -> Array:
    """FPFH features and RANSAC of Open3D, then GICP of small_gicp, or ICP of Open3D."""
    o3d = installed("open3d")
    steps = o3d.pipelines.registration
    o3d.utility.random.seed(0)
    query, reference = clouds(scene)
    (first, first_features), (second, second_features) = (_featured(o3d, x) for x in (query, reference))
    with o3d.utility.VerbosityContextManager(o3d.utility.VerbosityLevel.Error):
        found = steps.registration_ransac_based_on_feature_matching(
            first, second, first_features, second_features, True, REACH,
            steps.TransformationEstimationPointToPoint(False), SAMPLE,
            [steps.CorrespondenceCheckerBasedOnEdgeLength(EDGES), steps.CorrespondenceCheckerBasedOnDistance(REACH)],
            steps.RANSACConvergenceCriteria(samples, CONFIDENCE),
        )  # fmt: skip
    pose = np.asarray(found.transformation)
    if installed("small_gicp"):
        return descended(query, reference, pose, FINAL_REACHES)
    for reach in FINAL_REACHES:
        pose = np.asarray(steps.registration_icp(first, second, reach, pose).transformation)
    return pose


def _featured(o3d: Any, points: Array) -> tuple[Any, Any]:
    search = o3d.geometry.KDTreeSearchParamHybrid
    cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points))
    cloud.estimate_normals(search(NORMALS, NEAR_NORMAL))
    return cloud, o3d.pipelines.registration.compute_fpfh_feature(cloud, search(FEATURES, NEAR_FEATURE))


# -- clifford ----------------------------------------------------------------------------------------------


@cache
def clifford_tools() -> Any:
    """REFORM of `clifford`, compiled by a first run."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # numba tells of threading layers that it does without
        from clifford.tools.g3c import model_matching

        rng = np.random.default_rng(0)
        two = [
            clifford_lines(np.concatenate([x, rng.normal(size=x.shape)], 1)) for x in rng.random((2, 2 * OBJECTS, 3))
        ]
        with contextlib.redirect_stdout(io.StringIO()):
            model_matching.REFORM(*two, n_samples=1, objects_per_sample=OBJECTS, iterations=1, object_type="lines")
    return model_matching


def clifford_lines(rows: Array) -> Any:
    """Lines (n, 6) as multivectors of `clifford`."""
    from clifford.g3c import layout

    from ... import cga3d

    return cga3d.line(rows[:, :3], rows[:, 3:]).to_clifford(layout)


def with_clifford(scene: Scene, samples: int) -> Array:
    """`clifford.tools.g3c.model_matching.REFORM`; NaN where it gives no motor."""
    tools = clifford_tools()
    query, reference = (clifford_lines(m.parameters["line"]) for m in (scene.query, scene.reference))
    random.seed(0)
    with contextlib.redirect_stdout(io.StringIO()), np.errstate(all="ignore"):
        found = tools.REFORM(
            reference, query, n_samples=samples, objects_per_sample=OBJECTS, iterations=ROUNDS, object_type="lines"
        )[2]
    return clifford_pose(found)


def clifford_pose(rotor: Any) -> Array:
    """The matrix (4, 4) of a motor of `clifford`; NaN if it is none."""
    from ... import cga3d, from_clifford

    motor = from_clifford([rotor], algebra=cga3d).as_kind(cga3d.kind("motor").layout, check=False)
    if not np.isfinite(motor.values).all():
        return np.full((4, 4), np.nan)
    return np.asarray(motor[0].normalized("motor").to_matrix())
