"""Pairs of models with a known relative pose, and the error of a pose: shared by the studies of registration."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import product
from typing import Any

import numpy as np

from ....registration import Model, Registration, register
from ....registration.model.parameters import DIRECTIONS, FIELDS, PLURALS, SHAPES, columns, transform_rows
from ...harness.study import Array, Errors, lost_beyond
from ...harness.vectors import directions

#: Largest displacement of a corner of the models' cube by a correct pose: a twentieth of the cube's width.
RIGHT = 0.1
#: Corners of this cube: positions of the objects of a reference are between -1 and 1.
CORNERS = np.array(list(product((-1.0, 1.0), repeat=3)))
#: Radii of circles and spheres.
RADII = (0.1, 0.5)
#: Half the length of the segment of a line from which points are sampled.
HALF_SEGMENT = 1.0


@dataclass(frozen=True)
class Scene:
    """A query, a reference, and the pose from the one to the other.

    Attributes
    ----------
    query, reference : Model
    pose : array (4, 4)
    true : mapping of kind to int array (n,)
        Row of each query object's counterpart, -1 for none.
    query_ends, reference_ends : arrays (n, 2, 3)
        Ends of segments of the lines, the same piece of both: for methods that register points.
    symmetries : array (k, 3, 3)
        Rotations that map the reference to itself.
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
        True for a case of a sweep: methods run at one setting.
    """

    items: list[Scene]
    is_swept: bool = False

    @property
    def is_of_lines(self) -> bool:
        """True if all objects are lines."""
        return all(set(scene.reference.counts) == {"line"} for scene in self.items)

    @property
    def size(self) -> int:
        """Number of objects of a query."""
        return len(self.items[0].query)


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
        The angle in radians, and the length relative to half the models' width. None: any rotation, and a
        translation of the size of a model.
    """
    if displacement is None:
        rotation, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        return np.asarray(rotation * np.sign(np.linalg.det(rotation))), rng.normal(size=3)
    axis, direction = directions(rng, 2)
    cross = np.cross(np.eye(3), -axis)
    rotation = np.eye(3) + np.sin(displacement) * cross + (1 - np.cos(displacement)) * cross @ cross
    return rotation, displacement * direction


def scene(rng: np.random.Generator, counts: Mapping[str, int], **options: Any) -> Scene:
    """Scene of random objects, by their numbers of each kind, with the options of `scene_of`."""
    return scene_of(rng, {kind: objects(rng, kind, count) for kind, count in counts.items()}, **options)


def scene_of(
    rng: np.random.Generator, rows: Mapping[str, Array], displacement: float | None = None, noise: float = 0.0,
    outliers: float = 0.0, missing: float = 0.0, offset: float = 0.0,
) -> Scene:  # fmt: skip
    """Scene of given objects.

    Parameters
    ----------
    rows : mapping of kind to array (n, k)
        Parameters of the objects of both models, in the cube.
    displacement
        See `rigid`.
    noise : float
        Standard deviation of the noise of each parameter of a query object.
    outliers : float
        Fraction of the query objects that are replaced by random ones.
    missing : float
        Fraction of the reference objects that are left out.
    offset : float
        Largest displacement of the query's segments along their lines: the two models contain different pieces.
    """
    rotation, shift = rigid(rng, displacement)
    inverse = rotation.T, -rotation.T @ shift
    query, reference, true = {}, {}, {}
    ends = [np.empty((0, 2, 3))] * 2
    for kind, whole in rows.items():
        count, order = len(whole), rng.permutation(len(whole))
        wrong = round(outliers * count)
        part = np.concatenate([objects(rng, kind, wrong), whole[wrong:]])
        part = transform_rows(part + noise * rng.normal(size=part.shape), kind, 1.0, *inverse)
        kept = np.sort(rng.permutation(count)[: count - round(missing * count)])
        rank = np.full(count, -1)
        rank[kept] = np.arange(len(kept))
        rank[:wrong] = -1
        query[kind], reference[kind], true[kind] = part[order], whole[kept], rank[order]
        if kind == "line":
            ends = [segments(query[kind], offset * rng.uniform(-1, 1, count)), segments(reference[kind])]
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = rotation, shift
    return Scene(model(query), model(reference), pose, true, ends[0], ends[1])


def model(rows: Mapping[str, Array]) -> Model:
    """Model of parameters by kind."""
    shapes = {kind: SHAPES.get(kind, part.shape[1:]) for kind, part in rows.items()}
    parameters: dict[str, Any] = {PLURALS[kind]: part.reshape(-1, *shapes[kind]) for kind, part in rows.items()}
    return Model(**parameters)


def segments(lines: Array, offset: Any = 0.0) -> Array:
    """Ends (n, 2, 3) of segments of lines (n, 6), centered at the points of the lines or displaced along them."""
    fields = columns("line")
    along = lines[:, fields["direction"]]
    along = HALF_SEGMENT * along / np.linalg.norm(along, axis=1, keepdims=True)
    middle = lines[:, fields["point"]] + np.asarray(offset)[..., None] * along
    return np.stack([middle - along, middle + along], axis=1)


def scenes(
    rng: np.random.Generator, count: int, counts: Mapping[str, int], is_swept: bool = False, **options: Any
) -> Scenes:
    """Scenes of one nature, with the options of `scene`."""
    return Scenes([scene(rng, counts, **options) for _ in range(count)], is_swept)


def register_each(inputs: Scenes, **options: Any) -> list[Registration]:
    """Results of `registration.register` on one thread, scene by scene."""
    return [register(s.query, s.reference, threads=1, **options) for s in inputs.items]


def listed_poses(result: Registration) -> Array:
    """Poses (k, 4, 4): the motor's, and the ambiguous ones."""
    return np.stack([motor.to_matrix() for motor in (result.motor, *result.ambiguous)])


def true_poses(inputs: Scenes) -> Array:
    """True poses (n, 4, 4) of scenes."""
    return np.stack([s.pose for s in inputs.items])


def pose_errors(poses: Array, true: Array) -> Errors:
    """Largest displacement of a corner of the models by poses (n, 4, 4); infinite without a pose."""
    away = CORNERS - true[:, None, :3, 3]
    corners = away @ true[:, :3, :3]  # of the query: the inverse motion
    moved = corners @ poses[:, :3, :3].swapaxes(1, 2) + poses[:, None, :3, 3]
    errors = np.linalg.norm(moved - CORNERS, axis=-1).max(-1)
    return lost_beyond(errors, np.inf)


def right_poses(poses: Array, true: Array, _: Scenes | None = None) -> Errors:
    """Errors of poses, infinite where they are not `RIGHT`."""
    errors = pose_errors(poses, true)
    return np.where(errors <= RIGHT, errors, np.inf)


def describe(inputs: Scenes, index: int) -> str:
    """Description of a scene."""
    one = inputs.items[index]
    angle = np.arccos(np.clip((np.trace(one.pose[:3, :3]) - 1) / 2, -1, 1))
    return f"scene {index}: rotated by {angle:.3g} rad, moved by {one.pose[:3, 3].tolist()}"
