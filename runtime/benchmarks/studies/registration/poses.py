"""Pairs of models with a known pose between them, and how far a pose is from it: what studies of registration share."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...reform.model import Model
from ...reform.parameters import DIRECTIONS, FIELDS, PLURALS, SHAPES, columns, moved
from ..study import Errors

Array = NDArray[Any]
#: A pose is right if it displaces no corner of the models' cube by more than a twentieth of the cube's width.
RIGHT = 0.1
#: Corners of that cube: positions of the objects of a reference are between -1 and 1.
CORNERS = np.array(list(product((-1.0, 1.0), repeat=3)))
#: Radii of circles and spheres.
RADII = (0.1, 0.5)
#: Half the length of the segment of a line that others sample with points.
HALF_SEGMENT = 1.0


@dataclass(frozen=True)
class Scene:
    """A query, a reference, and the pose that takes the one to the other.

    Attributes
    ----------
    query, reference : Model
    pose : array (4, 4)
    true : mapping of kind to int array (n,)
        For each query object the row of its counterpart, -1 for none.
    query_ends, reference_ends : arrays (n, 2, 3)
        Ends of segments of the lines, the same piece of both: for methods that know points alone.
    symmetries : array (k, 3, 3)
        Rotations that take the reference to itself.
    """

    query: Model
    reference: Model
    pose: Array
    true: Mapping[str, Array]
    query_ends: Array
    reference_ends: Array
    symmetries: Array = field(default_factory=lambda: np.eye(3)[None])


@dataclass(frozen=True)
class Scenes:
    """Scenes of one nature.

    Attributes
    ----------
    items : list of Scene
    is_swept : bool
        One of a sweep: methods run at one setting alone.
    """

    items: list[Scene]
    is_swept: bool = False

    @property
    def is_of_lines(self) -> bool:
        """Whether there is nothing else."""
        return all(set(scene.reference.counts) == {"line"} for scene in self.items)

    @property
    def size(self) -> int:
        """Objects of a query."""
        return len(self.items[0].query)


def directions(rng: np.random.Generator, count: int) -> Array:
    """Random unit vectors."""
    v = rng.normal(size=(count, 3))
    return np.asarray(v / np.linalg.norm(v, axis=1, keepdims=True))


def objects(rng: np.random.Generator, kind: str, count: int) -> Array:
    """Parameters of random objects in the cube, as rows of a model."""
    parts = []
    for name, size in FIELDS[kind]:
        if name in DIRECTIONS:
            parts.append(directions(rng, count))
        else:
            low, high = RADII if name == "radius" else (-1.0, 1.0)
            parts.append(rng.uniform(low, high, (count, size)))
    return np.concatenate(parts, axis=1)


def rigid(rng: np.random.Generator, displacement: float | None = None) -> tuple[Array, Array]:
    """Rotation (3, 3) and translation of a random motion.

    Parameters
    ----------
    displacement : float, optional
        The angle in radians, and the length against half the models' width. None: any rotation, and a translation
        of the size of a model.
    """
    if displacement is None:
        turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        return np.asarray(turn * np.sign(np.linalg.det(turn))), rng.normal(size=3)
    axis, way = directions(rng, 2)
    cross = np.cross(np.eye(3), -axis)
    turn = np.eye(3) + np.sin(displacement) * cross + (1 - np.cos(displacement)) * cross @ cross
    return turn, displacement * way


def scene(rng: np.random.Generator, counts: Mapping[str, int], **options: Any) -> Scene:
    """A scene of random objects: so many of each kind, with the options of `scene_of`."""
    return scene_of(rng, {kind: objects(rng, kind, count) for kind, count in counts.items()}, **options)


def scene_of(
    rng: np.random.Generator, rows: Mapping[str, Array], displacement: float | None = None, noise: float = 0.0,
    outliers: float = 0.0, missing: float = 0.0, slide: float = 0.0,
) -> Scene:  # fmt: skip
    """A scene of these objects.

    Parameters
    ----------
    rows : mapping of kind to array (n, k)
        Parameters of the objects of both models, in the cube.
    displacement
        As of `rigid`.
    noise : float
        Standard deviation of what is added to each parameter of a query object, before it is moved.
    outliers : float
        Share of query objects in whose place others stand.
    missing : float
        Share of reference objects that are left out.
    slide : float
        Segments of the query are moved along their lines by up to this: another piece of the same line is seen.
    """
    turn, shift = rigid(rng, displacement)
    back = turn.T, -turn.T @ shift
    query, reference, true = {}, {}, {}
    ends = [np.empty((0, 2, 3))] * 2
    for kind, whole in rows.items():
        count, order = len(whole), rng.permutation(len(whole))
        wrong = round(outliers * count)
        own = np.concatenate([objects(rng, kind, wrong), whole[wrong:]])
        own = moved(own + noise * rng.normal(size=own.shape), kind, 1.0, *back)
        kept = np.sort(rng.permutation(count)[: count - round(missing * count)])
        rank = np.full(count, -1)
        rank[kept] = np.arange(len(kept))
        rank[:wrong] = -1
        query[kind], reference[kind], true[kind] = own[order], whole[kept], rank[order]
        if kind == "line":
            ends = [segments(query[kind], slide * rng.uniform(-1, 1, count)), segments(reference[kind])]
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = turn, shift
    return Scene(model(query), model(reference), pose, true, ends[0], ends[1])


def model(rows: Mapping[str, Array]) -> Model:
    """A model of parameters by kind."""
    given: dict[str, Any] = {
        PLURALS[kind]: part.reshape(-1, *SHAPES.get(kind, part.shape[1:])) for kind, part in rows.items()
    }
    return Model(**given)


def segments(lines: Array, slide: Any = 0.0) -> Array:
    """Ends (n, 2, 3) of segments about the points that lines (n, 6) are given by, or moved along them."""
    place = columns("line")
    along = lines[:, place["direction"]]
    along = HALF_SEGMENT * along / np.linalg.norm(along, axis=1, keepdims=True)
    middle = lines[:, place["point"]] + np.asarray(slide)[..., None] * along
    return np.stack([middle - along, middle + along], axis=1)


def scenes(counts: Mapping[str, int], is_swept: bool = False, **options: Any) -> Callable[..., Scenes]:
    """Maker of scenes of one nature, with the options of `scene`."""

    def make(rng: np.random.Generator, count: int) -> Scenes:
        return Scenes([scene(rng, counts, **options) for _ in range(count)], is_swept)

    return make


def true_poses(inputs: Scenes) -> Array:
    """Poses (n, 4, 4), as the scenes were made."""
    return np.stack([s.pose for s in inputs.items])


def pose_errors(found: Array, true: Array) -> Errors:
    """By how much poses (n, 4, 4) displace a corner of the models, at most; infinite where no pose was found."""
    away = CORNERS - true[:, None, :3, 3]
    corners = away @ true[:, :3, :3]  # of the query: the inverse motion
    there = corners @ found[:, :3, :3].swapaxes(1, 2) + found[:, None, :3, 3]
    errors = np.linalg.norm(there - CORNERS, axis=-1).max(-1)
    return np.where(np.isfinite(errors), errors, np.inf)


def right_poses(found: Array, true: Array, _: Scenes | None = None) -> Errors:
    """Their errors, infinite where they are not `RIGHT`."""
    errors = pose_errors(found, true)
    return np.where(errors <= RIGHT, errors, np.inf)


def describe(inputs: Scenes, index: int) -> str:
    """One scene."""
    one = inputs.items[index]
    angle = np.arccos(np.clip((np.trace(one.pose[:3, :3]) - 1) / 2, -1, 1))
    return f"scene {index}: turned by {angle:.3g} rad, moved by {one.pose[:3, 3].tolist()}"
