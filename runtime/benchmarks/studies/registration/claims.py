"""Reliability of `converged`: scenes that are hard or have no answer, and the claims of the results."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from ...harness.study import Array, Case, Errors, Method, Study
from .poses import (
    Scene,
    Scenes,
    describe,
    listed_poses,
    model,
    objects,
    pose_errors,
    register_each,
    scene,
    scene_of,
    scenes,
    true_poses,
)

#: Largest displacement of a corner by a correct pose, with any noise. Wrong poses displace corners by 1 to 4.
NEAR = 0.3
#: Lines of a window.
WINDOW = np.array(
    [(0, 0, 0, 1, 0, 0), (0, 0.2, 0, 1, 0, 0), (0, 0, 0, 0, 1, 0), (0.13, 0, 0, 0, 1, 0), (0.06, 0.1, 0, 0, 0, 1)]
)
#: Number of windows of a front.
WINDOWS = 6
#: Number of other lines of a query.
OTHERS = 10


@dataclass(frozen=True)
class Claims:
    """Poses (k, 4, 4) of each scene, the motor's and the ambiguous ones; and a mask of the scenes of which a claim is
    made."""

    poses: list[Array]
    believed: Array


def claims(inputs: Scenes, _: None, *, only_converged: bool) -> Claims:
    """Register, and claim all poses, or those of converged results."""
    results = register_each(inputs)
    return Claims(
        [listed_poses(result) for result in results], np.array([r.converged or not only_converged for r in results])
    )


def unrelated_models(rng: np.random.Generator, count: int, counts: dict[str, int]) -> Scenes:
    """Scenes of two unrelated models: no pose is correct."""
    pairs = [(scene(rng, counts), scene(rng, counts)) for _ in range(count)]
    return Scenes([replace(one, reference=other.reference, pose=np.full((4, 4), np.nan)) for one, other in pairs])


def windows(rng: np.random.Generator, count: int, noise: float) -> Scenes:
    """Scenes of a front with equal windows; the query contains one of them, among other lines."""

    def make_scene() -> Scene:
        whole = np.tile(WINDOW, (WINDOWS, 1))
        whole[:, :3] += np.repeat(rng.uniform(-1, 1, (WINDOWS, 3)), len(WINDOW), 0)
        query = np.concatenate([whole[: len(WINDOW)], objects(rng, "line", OTHERS)])
        one = scene_of(rng, {"line": query}, noise=noise)
        true = {"line": np.where(one.true["line"] < len(WINDOW), one.true["line"], -1)}
        return replace(one, reference=model({"line": whole}), true=true)

    return Scenes([make_scene() for _ in range(count)])


def error(answer: Claims, true: Array, _: Scenes) -> Errors:
    """Error of the pose or of the nearest ambiguous one; infinite if none is correct; 0 without a claim."""
    errors = []
    for poses, is_believed, pose in zip(answer.poses, answer.believed, true, strict=True):
        off = pose_errors(poses, np.tile(pose, (len(poses), 1, 1))).min()
        errors.append(0.0 if not is_believed else off if off <= NEAR else np.inf)
    return np.array(errors)


def describe_claim(inputs: Scenes, index: int) -> str:
    """Description of a scene."""
    one: Scene = inputs.items[index]
    return describe(inputs, index) if np.isfinite(one.pose).all() else f"scene {index}: two strangers"


HARD: tuple[tuple[str, dict[str, int], dict[str, Any]], ...] = (
    ("6 lines, 30 % wrong and missing", {"line": 6}, {"outliers": 0.3, "missing": 0.3}),
    ("20 lines, 70 % wrong", {"line": 20}, {"outliers": 0.7}),
    ("20 lines, noise 0.05, 30 % wrong", {"line": 20}, {"noise": 0.05, "outliers": 0.3}),
    ("10 points, 10 planes, 60 % wrong, 40 % missing", {"point": 10, "plane": 10}, {"outliers": 0.6, "missing": 0.4}),
    ("100 lines, 80 % wrong, 60 % missing", {"line": 100}, {"outliers": 0.8, "missing": 0.6}),
)

STUDY = Study(
    name="claims",
    title="Reliability of `converged`",
    methods=(
        Method("all poses", partial(claims, only_converged=False), repeats=0),
        Method("converged ones", partial(claims, only_converged=True), repeats=0),
    ),
    cases=(
        Case("20 lines, two strangers", partial(unrelated_models, counts={"line": 20}), "singular"),
        Case("5 planes, two strangers", partial(unrelated_models, counts={"plane": 5}), "singular"),
        Case(
            "60 lines and planes, two strangers",
            partial(unrelated_models, counts={"line": 30, "plane": 30}),
            "singular",
        ),
        Case("six equal windows, one of them seen", partial(windows, noise=1e-3), "singular"),
        Case("the same, noise 0.01", partial(windows, noise=1e-2), "singular"),
        *(Case(name, partial(scenes, counts=counts, **options), "extreme") for name, counts, options in HARD),
    ),
    reference=true_poses,
    error=error,
    describe=describe_claim,
    unit="of half the models' width",
    count=60,
    source="thesis 5.5",
    notes="Lost of all poses are those that are false, or cannot be right; lost of the converged ones are false "
    "claims. A pose that is listed as ambiguous counts.",
)
