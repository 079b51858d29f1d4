"""Registration of models against run time: ours, REFORM as in the text, and what others offer."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from importlib.util import find_spec
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..study import Case, Method, Study
from . import pose_peers
from .poses import Scene, Scenes, describe, right_poses, scenes, true_poses

Array = NDArray[Any]
#: Values of the knobs; the setting at which sweeps are run.
SAMPLES, TEXT_SAMPLES, RANSAC_SAMPLES, CLIFFORD_SAMPLES = (8, 16, 64, 256), (64, 256), (10_000, 100_000), (5,)
USUAL, USUAL_RANSAC = 64, 100_000
#: Objects up to which methods that take long are run: by RANSAC and by `clifford`, by GICP. Scenes of a case for those
#: that take long, and for `clifford`.
FEW_OBJECTS, MOST_OBJECTS = 50, 100
MOST_SCENES, FEWEST_SCENES = 10, 2
#: What the text's methods are made for: a displacement of a tenth of the models.
NEAR = 0.1
WRONG: dict[str, Any] = {"outliers": 0.3, "missing": 0.3}


def poses_of(inputs: Scenes, find: Callable[[Scene], Any]) -> Array:
    """Poses (n, 4, 4), one scene at a time."""
    return np.stack([find(scene) for scene in inputs.items])


def registered(inputs: Scenes, samples: int, start: str = "global") -> Array | None:
    """`reform.register` on one thread, at the usual setting alone in sweeps."""
    from ... import reform

    if inputs.is_swept and samples != USUAL:
        return None

    def find(scene: Scene) -> Any:
        return reform.register(scene.query, scene.reference, samples, start=start, threads=1).motor.to_matrix()

    return poses_of(inputs, find)


def by_proximity(inputs: Scenes, samples: int) -> Array | None:
    """REFORM of the text (5.5): `reform.register` from where the query stands; of large models in sweeps alone."""
    if inputs.size > MOST_OBJECTS and not inputs.is_swept:
        return None
    return registered(inputs, samples, "proximity")


def iterated(inputs: Scenes, _: None) -> Array | None:
    """Iterative matching alone (5.4); of large models in sweeps alone."""
    if inputs.size > MOST_OBJECTS and not inputs.is_swept:
        return None
    from ...reform.iterate import iterate

    return poses_of(inputs, lambda scene: iterate(scene.query, scene.reference, threads=1).motor.to_matrix())


def points_near(inputs: Scenes, _: None) -> Array | None:
    """Points of lines, from where the query stands."""
    if not inputs.is_of_lines or inputs.size > MOST_OBJECTS:
        return None
    return poses_of(inputs, pose_peers.local)


def points_anywhere(inputs: Scenes, samples: int) -> Array | None:
    """Points of lines, by features and RANSAC: of few lines, for it takes long."""
    if not inputs.is_of_lines or inputs.size > FEW_OBJECTS:
        return None
    if inputs.is_swept and samples != USUAL_RANSAC:
        return None
    return poses_of(inputs, lambda scene: pose_peers.anywhere(scene, samples))


def by_clifford(inputs: Scenes, samples: int) -> Array | None:
    """REFORM of `clifford`: of few lines, for it takes long."""
    if not inputs.is_of_lines or inputs.is_swept or inputs.size > FEW_OBJECTS:
        return None
    return poses_of(inputs, lambda scene: pose_peers.with_clifford(scene, samples))


def methods() -> tuple[Method, ...]:
    """Ours, and those of others that are installed."""
    long = partial(Method, most=MOST_SCENES, repeats=0)
    found: tuple[Method, ...] = (
        Method("register", registered, "samples", SAMPLES, repeats=1),
        long("REFORM by proximity", by_proximity, "samples", TEXT_SAMPLES),
        long("iterative matching", iterated),
    )
    if pose_peers.installed("small_gicp"):
        found += (long("points: GICP", points_near),)
    if pose_peers.installed("open3d"):
        found += (long("points: FPFH, RANSAC, GICP", points_anywhere, "samples", RANSAC_SAMPLES, slow=True),)
    if find_spec("clifford") is not None:
        found += (
            Method(
                "REFORM of clifford", by_clifford, "samples", CLIFFORD_SAMPLES, slow=True, most=FEWEST_SCENES,
                repeats=0, prepare=pose_peers.clifford_tools,
            ),
        )  # fmt: skip
    return found


LINES, MIXED = {"line": 20}, {"line": 10, "plane": 10}
EVERY = {"point": 5, "point_pair": 5, "line": 5, "circle": 5, "plane": 5, "sphere": 5}

STUDY = Study(
    name="registrations",
    title="The pose of one model in another",
    methods=methods(),
    cases=(
        Case("20 lines, a tenth away", scenes(LINES, displacement=NEAR), "ordinary", describe),
        Case("20 lines, anywhere", scenes(LINES), "ordinary", describe),
        Case("the same, 30 % wrong, 30 % missing", scenes(LINES, **WRONG), "extreme", describe),
        Case("the same, noise 0.01", scenes(LINES, noise=1e-2, **WRONG), "extreme", describe),
        Case("10 lines, 10 planes, 30 % wrong and missing", scenes(MIXED, **WRONG), "extreme", describe),
        Case("5 of each kind, 30 % wrong and missing", scenes(EVERY, **WRONG), "extreme", describe),
        Case("100 lines, 30 % wrong and missing, noise 0.01", scenes({"line": 100}, noise=1e-2, **WRONG), "extreme",
             describe),
        Case("400 lines, 30 % wrong and missing", scenes({"line": 400}, **WRONG), "extreme", describe),
    ),
    reference=true_poses,
    error=lambda found, true, _: right_poses(found, true),
    unit="of half the models' width",
    count=20,
    source="thesis chapter 5",
    notes="The error of a pose is the greatest displacement of a corner of the models' cube; lost are poses with more "
    "than a tenth of half its width. Points for the others are sampled from the same segments of the lines of both "
    "models: ends are known to them, which lines do not have.",
)  # fmt: skip
