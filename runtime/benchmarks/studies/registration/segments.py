"""Segments with errors at their ends, cut and wrong ones: how far poses are off, beside the least squares of the true
matches on end points.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from ....registration import Model
from ...harness.study import Array, Case, Method, Study, sweep_cases
from ...harness.vectors import directions
from .poses import Scene, Scenes, describe, register_each, right_poses, rigid, true_poses

#: Lengths of segments, in half widths of the models: 0.3 to 1.5 m in a room of 4 m.
LENGTHS = (0.15, 0.75)
#: Standard deviation of each coordinate of an end: 1 cm.
NOISE = 0.005
#: Cut segments keep at least this fraction of their lengths.
LEAST = 0.3
WRONG = 0.4
COUNT = 300
FRACTIONS = (0.1, 0.2, 0.4, 0.6, 0.8)
NOISES = (1e-4, 1e-3, 5e-3, 1e-2)
COUNTS = (10, 30, 100, 300, 1000)
#: Steps of Gauss and Newton of the least squares: they start from the true pose.
STEPS = 5


@dataclass(frozen=True)
class SegmentScene(Scene):
    """A scene of segments; ``query_ends`` and ``reference_ends`` (m, 2, 3) are those of the true matches, in one order.

    Attributes
    ----------
    is_cut : bool
        True if the query's segments are stretches of the reference's.
    """

    is_cut: bool = False


def stretches(rng: np.random.Generator, count: int) -> Array:
    """Random segments (n, 2, 3)."""
    begin = rng.uniform(-1, 1, (count, 3))
    return np.stack([begin, begin + directions(rng, count) * rng.uniform(*LENGTHS, (count, 1))], 1)


def scene(rng: np.random.Generator, count: int, noise: float, wrong: float, is_cut: bool) -> SegmentScene:
    """Scene of random segments: the query has others in place of some, and its ends in any order."""
    rotation, shift = rigid(rng)
    reference = stretches(rng, count)
    low, high = np.zeros((count, 1)), np.ones((count, 1))
    if is_cut:
        low = rng.uniform(0, 1 - LEAST, (count, 1))
        high = rng.uniform(low + LEAST, 1)
    begin, along = reference[:, 0], reference[:, 1] - reference[:, 0]
    query = np.stack([begin + low * along, begin + high * along], 1)
    n_wrong = round(wrong * count)
    query[:n_wrong] = stretches(rng, n_wrong)
    query = (query - shift) @ rotation + noise * rng.normal(size=query.shape)
    order, swapped = rng.permutation(count), rng.random((count, 1, 1)) < 0.5
    given = np.where(swapped, query[:, ::-1], query)[order]
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = rotation, shift
    true = np.where(order < n_wrong, -1, order)
    return SegmentScene(Model(segments=given), Model(segments=reference), pose, {"segment": true},
                        query[n_wrong:], reference[n_wrong:], is_cut=is_cut)  # fmt: skip


def scenes(
    rng: np.random.Generator, number: int, count: float = COUNT, noise: float = NOISE, wrong: float = WRONG,
    is_cut: bool = False,
) -> Scenes:  # fmt: skip
    """Scenes of one nature."""
    return Scenes([scene(rng, round(count), noise, wrong, is_cut) for _ in range(number)])


def as_segments(inputs: Scenes, _: None, **options: Any) -> Array:
    """`register` of segments, on one thread."""
    return np.stack([result.motor.to_matrix() for result in register_each(inputs, **options)])


def as_lines(inputs: Scenes, _: None) -> Array:
    """`register` of the lines through the ends."""

    def lines(model: Model) -> Model:
        return Model(lines=model.objects["segment"])

    models = [replace(s, query=lines(s.query), reference=lines(s.reference)) for s in inputs.items]
    return as_segments(Scenes(list(models)), None)


def least_squares(inputs: Scenes, _: None) -> Array:
    """Poses of least squares of the true matches on ends: off the other's ends, or off its line where it is cut."""
    return np.stack([_least_squares(s) for s in inputs.items if isinstance(s, SegmentScene)])


def _least_squares(one: SegmentScene) -> Array:
    pose, others = one.pose.copy(), one.reference_ends
    along = (others[:, 1] - others[:, 0])[:, None]
    along = along / np.linalg.norm(along, axis=-1, keepdims=True)
    across = np.eye(3) - float(one.is_cut) * along[..., :, None] * along[..., None, :]
    for _ in range(STEPS):
        moved = one.query_ends @ pose[:3, :3].T + pose[:3, 3]
        cross = np.cross(np.eye(3), moved[..., None, :]).swapaxes(-1, -2)  # of the rates e_k x moved, in columns
        jacobian = across @ np.concatenate([cross, np.broadcast_to(np.eye(3), cross.shape)], -1)
        residual = (across @ (moved - others)[..., None])[..., 0]
        twist = np.linalg.lstsq(jacobian.reshape(-1, 6), -residual.ravel(), rcond=None)[0]
        pose = _step(twist) @ pose
    return pose


def _step(twist: Array) -> Array:
    """A small motion by its rotation vector and translation: orthonormal by Cayley's map."""
    x, y, z = twist[:3] / 2
    skew = np.array([(0, -z, y), (z, 0, -x), (-y, x, 0)])
    found = np.eye(4)
    found[:3, :3], found[:3, 3] = np.linalg.solve(np.eye(3) - skew, np.eye(3) + skew), twist[3:]
    return found


STUDY = Study(
    name="segments",
    title="Segments: the pose by their ends",
    methods=(
        Method("segments", as_segments, repeats=0),
        Method("segments, Cauchy's loss", partial(as_segments, loss="cauchy"), repeats=0),
        Method("lines through their ends", as_lines, repeats=0),
        Method("true matches, least squares", least_squares, repeats=0),
    ),
    cases=(
        Case("300 segments, 40 % wrong", scenes, "extreme"),
        Case("the same, cut", partial(scenes, is_cut=True), "extreme"),
        Case("20 segments, 30 % wrong", partial(scenes, count=20, wrong=0.3), "extreme"),
        *sweep_cases("fraction of wrong segments", FRACTIONS, lambda rng, n, x: scenes(rng, n, wrong=x)),
        *sweep_cases("fraction of wrong ones, cut", FRACTIONS, lambda rng, n, x: scenes(rng, n, wrong=x, is_cut=True)),
        *sweep_cases("errors of the ends", NOISES, lambda rng, n, x: scenes(rng, n, noise=x)),
        *sweep_cases("number of segments", COUNTS, lambda rng, n, x: scenes(rng, n, count=x)),
    ),
    reference=true_poses,
    error=right_poses,
    describe=describe,
    unit="of half the models' width",
    count=10,
    draws_fractions=True,
    source="this package",
    notes="Segments of 0.15 to 0.75 half widths, with errors of 0.005 in each coordinate of their ends (1 cm in a room "
    "of 4 m). The last method knows the true matches, and starts from the true pose: it is the bound. Lost are poses "
    "that are off by more than a tenth of half the width.",
)  # fmt: skip
