"""Registration of models, error against run time: `register`, REFORM as in the text, and other packages."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from ....registration.matching.icp import iterate
from ...harness.study import Array, Case, Method, Study
from . import pose_peers
from .poses import Scenes, describe, register_each, right_poses, scenes, true_poses

#: Settings of `register`, of REFORM as in the text, of RANSAC on points, and of `clifford`.
SAMPLES, TEXT_SAMPLES, RANSAC_SAMPLES, CLIFFORD_SAMPLES = (8, 16, 64, 256), (64, 256), (10_000, 100_000), (5,)
#: Settings of sweeps.
USUAL, USUAL_RANSAC = 64, 100_000
#: Largest number of objects for RANSAC on points and for `clifford`.
FEW_OBJECTS = 50
#: Largest number of objects for other methods that take long.
MOST_OBJECTS = 100
#: Number of scenes of a case for methods that take long.
MOST_SCENES = 10
#: Number of scenes of a case for `clifford`.
FEWEST_SCENES = 2
#: Displacement for local methods: a tenth of the models.
NEAR = 0.1
WRONG: dict[str, Any] = {"outliers": 0.3, "missing": 0.3}


def run_register(inputs: Scenes, samples: int, start: str = "global") -> Array | None:
    """`register` on one thread; in sweeps at one setting."""
    if inputs.is_swept and samples != USUAL:
        return None
    return np.stack([result.motor.to_matrix() for result in register_each(inputs, samples=samples, start=start)])


def by_proximity(inputs: Scenes, samples: int) -> Array | None:
    """REFORM as in the text (5.5): `register` from the present pose; large models in sweeps only."""
    if inputs.size > MOST_OBJECTS and not inputs.is_swept:
        return None
    return run_register(inputs, samples, "proximity")


def run_iterate(inputs: Scenes, _: None) -> Array | None:
    """Iterative matching alone (5.4); large models in sweeps only."""
    if inputs.size > MOST_OBJECTS and not inputs.is_swept:
        return None
    return np.stack([iterate(s.query, s.reference, threads=1).motor.to_matrix() for s in inputs.items])


def run_peer(
    inputs: Scenes, setting: Any, *, peer: Callable[..., Array], most: int = FEW_OBJECTS, swept: Any = None
) -> Array | None:
    """Poses (n, 4, 4) of another package, for few lines because it takes long; in sweeps at one setting, if any.

    Parameters
    ----------
    peer : callable
        ``peer(scene, setting)``.
    most : int
        Largest number of lines.
    swept
        Setting in sweeps: others are left out there.
    """
    if not inputs.is_of_lines or inputs.size > most or (inputs.is_swept and setting != swept):
        return None
    return np.stack([peer(scene, setting) for scene in inputs.items])


LINES, MIXED = {"line": 20}, {"line": 10, "plane": 10}
EVERY = {"point": 5, "point_pair": 5, "line": 5, "circle": 5, "plane": 5, "sphere": 5}
_long = partial(Method, most=MOST_SCENES, repeats=0)

STUDY = Study(
    name="registrations",
    title="The pose of one model in another",
    methods=(
        Method("register", run_register, "samples", SAMPLES, repeats=1),
        _long("REFORM by proximity", by_proximity, "samples", TEXT_SAMPLES),
        _long("iterative matching", run_iterate),
        _long(
            "points: GICP", partial(run_peer, peer=pose_peers.local, most=MOST_OBJECTS), requires="small_gicp"
        ),
        _long(
            "points: FPFH, RANSAC, GICP", partial(run_peer, peer=pose_peers.anywhere, swept=USUAL_RANSAC), "samples",
            RANSAC_SAMPLES, slow=True, requires="open3d",
        ),
        Method(
            "REFORM of clifford", partial(run_peer, peer=pose_peers.with_clifford), "samples", CLIFFORD_SAMPLES,
            slow=True, most=FEWEST_SCENES, repeats=0, prepare=pose_peers.clifford_tools, requires="clifford",
        ),
    ),
    cases=tuple(
        Case(name, partial(scenes, counts=counts, **options), "extreme" if options.get("outliers") else "ordinary")
        for name, counts, options in (
            ("20 lines, a tenth away", LINES, {"displacement": NEAR}),
            ("20 lines, anywhere", LINES, {}),
            ("the same, 30 % wrong, 30 % missing", LINES, WRONG),
            ("the same, noise 0.01", LINES, {"noise": 1e-2, **WRONG}),
            ("10 lines, 10 planes, 30 % wrong and missing", MIXED, WRONG),
            ("5 of each kind, 30 % wrong and missing", EVERY, WRONG),
            ("100 lines, 30 % wrong and missing, noise 0.01", {"line": 100}, {"noise": 1e-2, **WRONG}),
            ("400 lines, 30 % wrong and missing", {"line": 400}, WRONG),
        )
    ),
    reference=true_poses,
    error=right_poses,
    describe=describe,
    unit="of half the models' width",
    count=20,
    source="thesis chapter 5",
    notes="The error of a pose is the greatest displacement of a corner of the models' cube; lost are poses with more "
    "than a tenth of half its width. Points for the others are sampled from the same segments of the lines of both "
    "models: ends are known to them, which lines do not have.",
)  # fmt: skip
