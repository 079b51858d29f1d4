"""Other packages on the scenes of `poses`: REFORM of `clifford`, and registration of points that are sampled from the
lines, by Open3D and small_gicp; those that are installed.

They get easier inputs: lines of both models have the same orientation, and points come from the same segments of both
models, whose ends lines do not have.
"""

from __future__ import annotations

import contextlib
import io
import random
import warnings
from functools import cache
from typing import Any

import numpy as np

from ....interchange.clifford import from_clifford
from ...harness.algebras import cga3d
from ...harness.study import Array, optional_module
from .poses import Scene

#: Distance between points of a line.
SPACING = 0.05
#: Radius within which normals are estimated.
NORMALS = 0.2
#: Radius within which features are estimated.
FEATURES = 0.5
#: Largest distance of matching points.
MAX_DISTANCE = 0.1
#: The same for local registration, in turn: the first for displacements of a tenth of the models.
LOCAL_DISTANCES = (0.2, 0.1)
#: The same for refinement.
FINAL_DISTANCES = (0.1, 0.05)
#: Largest number of neighbors for a normal.
NEAR_NORMAL = 30
#: Largest number of neighbors for a feature.
NEAR_FEATURE = 100
#: Points of a sample.
SAMPLE = 3
#: Smallest ratio of the lengths of matching edges of samples.
EDGES = 0.9
#: Confidence at which RANSAC ends.
CONFIDENCE = 0.999
#: Largest number of iterations of GICP.
GICP_ITERATIONS = 100
#: `clifford`: rounds of matching.
ROUNDS = 10
#: `clifford`: objects of a sample (its default).
OBJECTS = 5


def points(ends: Array, rng: np.random.Generator) -> Array:
    """Points of segments (n, 2, 3) at distances of `SPACING`, with a random offset in each segment."""
    lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    count = max(2, round(float(lengths.mean()) / SPACING))
    along = (np.arange(count) + rng.random((len(ends), 1))) / count
    return np.reshape(ends[:, None, 0] + along[..., None] * (ends[:, None, 1] - ends[:, None, 0]), (-1, 3))


def clouds(scene: Scene) -> tuple[Array, Array]:
    """Points of the query and of the reference, at different positions on a line."""
    rng = np.random.default_rng(len(scene.query))
    return points(scene.query_ends, rng), points(scene.reference_ends, rng)


# -- points, from the present pose -------------------------------------------------------------------


def refine_with_gicp(query: Array, reference: Array, pose: Array, distances: tuple[float, ...]) -> Array:
    """GICP from a pose, with decreasing distances of matches."""
    gicp = optional_module("small_gicp")
    for distance in distances:
        found = gicp.align(
            reference, query, pose, registration_type="GICP", downsampling_resolution=SPACING / 2,
            max_correspondence_distance=distance, num_threads=1, max_iterations=GICP_ITERATIONS,
        )  # fmt: skip
        pose = np.asarray(found.T_target_source)
    return pose


def local(scene: Scene, _: None = None) -> Array:
    """GICP of small_gicp from the present pose of the query."""
    return refine_with_gicp(*clouds(scene), np.eye(4), LOCAL_DISTANCES)


# -- points, from anywhere ---------------------------------------------------------------------------------


def anywhere(scene: Scene, samples: int) -> Array:
    """FPFH features and RANSAC of Open3D, then GICP of small_gicp, or ICP of Open3D."""
    o3d = optional_module("open3d")
    steps = o3d.pipelines.registration
    o3d.utility.random.seed(0)
    query, reference = clouds(scene)
    (first, first_features), (second, second_features) = (_with_features(o3d, x) for x in (query, reference))
    with o3d.utility.VerbosityContextManager(o3d.utility.VerbosityLevel.Error):
        found = steps.registration_ransac_based_on_feature_matching(
            first, second, first_features, second_features, True, MAX_DISTANCE,
            steps.TransformationEstimationPointToPoint(False), SAMPLE,
            [
                steps.CorrespondenceCheckerBasedOnEdgeLength(EDGES),
                steps.CorrespondenceCheckerBasedOnDistance(MAX_DISTANCE),
            ],
            steps.RANSACConvergenceCriteria(samples, CONFIDENCE),
        )  # fmt: skip
    pose = np.asarray(found.transformation)
    if optional_module("small_gicp"):
        return refine_with_gicp(query, reference, pose, FINAL_DISTANCES)
    for distance in FINAL_DISTANCES:
        pose = np.asarray(steps.registration_icp(first, second, distance, pose).transformation)
    return pose


def _with_features(o3d: Any, points: Array) -> tuple[Any, Any]:
    search = o3d.geometry.KDTreeSearchParamHybrid
    cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points))
    cloud.estimate_normals(search(NORMALS, NEAR_NORMAL))
    return cloud, o3d.pipelines.registration.compute_fpfh_feature(cloud, search(FEATURES, NEAR_FEATURE))


# -- clifford ----------------------------------------------------------------------------------------------


@cache
def clifford_tools() -> Any:
    """REFORM of `clifford`, compiled by a first run."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # numba warns of missing threading layers
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

    return cga3d.line(rows[:, :3], rows[:, 3:]).to_clifford(layout)


def with_clifford(scene: Scene, samples: int) -> Array:
    """`clifford.tools.g3c.model_matching.REFORM`; NaN if it gives no motor."""
    tools = clifford_tools()
    query, reference = (clifford_lines(m.parameters["line"]) for m in (scene.query, scene.reference))
    random.seed(0)
    with contextlib.redirect_stdout(io.StringIO()), np.errstate(all="ignore"):
        found = tools.REFORM(
            reference, query, n_samples=samples, objects_per_sample=OBJECTS, iterations=ROUNDS, object_type="lines"
        )[2]
    return clifford_pose(found)


def clifford_pose(rotor: Any) -> Array:
    """The matrix (4, 4) of a motor of `clifford`; NaN if it is not a motor."""
    motor = from_clifford([rotor], algebra=cga3d).as_kind(cga3d.kind("motor").layout, check=False)
    if not np.isfinite(motor.values).all():
        return np.full((4, 4), np.nan)
    return np.asarray(motor[0].normalized("motor").to_matrix())
