"""Whether `converged` can be believed: scenes that are hard or have no answer, and what is said of the poses found."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..study import Case, Errors, Method, Study
from .poses import Scene, Scenes, describe, model, objects, pose_errors, scene, scene_of, scenes, true_poses

Array = NDArray[Any]
#: A pose is the one that was asked for, however much noise displaces it, if it displaces no corner by more. False ones
#: do so by 1 to 4.
NEAR = 0.3
#: A window's lines, how many windows a front has, and other lines of a query.
WINDOW = np.array(
    [(0, 0, 0, 1, 0, 0), (0, 0.2, 0, 1, 0, 0), (0, 0, 0, 0, 1, 0), (0.13, 0, 0, 0, 1, 0), (0.06, 0.1, 0, 0, 0, 1)]
)
WINDOWS, OTHERS = 6, 10


@dataclass(frozen=True)
class Claims:
    """Poses (k, 4, 4) of each scene, the motor's and those listed beside it; and which are believed to be right."""

    poses: list[Array]
    believed: Array


def claims(only_converged: bool) -> Callable[..., Claims]:
    """A method: register; believe all, or those that say that they have converged."""

    def run(inputs: Scenes, _: None) -> Claims:
        from ... import reform

        found = [reform.register(s.query, s.reference, threads=1) for s in inputs.items]
        poses = [np.stack([motor.to_matrix() for motor in (r.motor, *r.ambiguous)]) for r in found]
        return Claims(poses, np.array([r.converged or not only_converged for r in found]))

    return run


def strangers(counts: dict[str, int]) -> Callable[..., Scenes]:
    """Maker of scenes of two models that have nothing to do with each other: no pose is right."""

    def make(rng: np.random.Generator, count: int) -> Scenes:
        pairs = [(scene(rng, counts), scene(rng, counts)) for _ in range(count)]
        return Scenes([replace(one, reference=other.reference, pose=np.full((4, 4), np.nan)) for one, other in pairs])

    return make


def windows(noise: float) -> Callable[..., Scenes]:
    """Maker of scenes of a front with equal windows, of which the query has one, among other lines."""

    def made(rng: np.random.Generator) -> Scene:
        whole = np.tile(WINDOW, (WINDOWS, 1))
        whole[:, :3] += np.repeat(rng.uniform(-1, 1, (WINDOWS, 3)), len(WINDOW), 0)
        seen = np.concatenate([whole[: len(WINDOW)], objects(rng, "line", OTHERS)])
        one = scene_of(rng, {"line": seen}, noise=noise)
        true = {"line": np.where(one.true["line"] < len(WINDOW), one.true["line"], -1)}
        return replace(one, reference=model({"line": whole}), true=true)

    return lambda rng, count: Scenes([made(rng) for _ in range(count)])


def error(answer: Claims, true: Array, _: Scenes) -> Errors:
    """Error of the pose, or of the nearest that is listed; infinite where none is right; 0 where it is not believed."""
    found = []
    for poses, is_believed, pose in zip(answer.poses, answer.believed, true, strict=True):
        off = pose_errors(poses, np.tile(pose, (len(poses), 1, 1))).min()
        found.append(0.0 if not is_believed else off if off <= NEAR else np.inf)
    return np.array(found)


def describe_claim(inputs: Scenes, index: int) -> str:
    """One scene."""
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
    title="Whether `converged` can be believed",
    methods=(Method("all poses", claims(False), repeats=0), Method("converged ones", claims(True), repeats=0)),
    cases=(
        Case("20 lines, two strangers", strangers({"line": 20}), "singular", describe_claim),
        Case("5 planes, two strangers", strangers({"plane": 5}), "singular", describe_claim),
        Case("60 lines and planes, two strangers", strangers({"line": 30, "plane": 30}), "singular", describe_claim),
        Case("six equal windows, one of them seen", windows(1e-3), "singular", describe_claim),
        Case("the same, noise 0.01", windows(1e-2), "singular", describe_claim),
        *(Case(name, scenes(counts, **options), "extreme", describe_claim) for name, counts, options in HARD),
    ),
    reference=true_poses,
    error=error,
    unit="of half the models' width",
    count=60,
    source="thesis 5.5",
    notes="Lost of all poses are those that are false, or cannot be right; lost of the converged ones are false "
    "claims. A pose that is listed as ambiguous counts.",
)
