"""Constraint rows and free twists of joints, each computed in a local frame and in its own unit of length.

Far from the origin the coefficients of an object resolve little of its shape: a joint is evaluated at its own position,
and its relation is transformed to the mechanism's frame as a linear map of twists. Joints of one type form a batch.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import InputError
from ...core.geometry.scaling import in_units
from ...core.multivector import Multivector
from ...dispatch.formulas import evaluate
from ..motion_closed_kinds import layout_of, matrix_of, on_layout
from ..twists import commutator_matrix, rotational_mask, screw_vectors
from .base import Condition, Joint
from .joint_locations import extent, joint_locations, least_squares_center, length_scales

if TYPE_CHECKING:
    from ...core.multivector import Algebra

Array = NDArray[Any]
#: Singular values of constraint rows below this fraction of the largest are rounding errors.
NOISE = 1e-7
#: A unit twist with a smaller angular part is a translation.
SLIDE = 1e-6


@dataclass(frozen=True)
class Frame:
    """Origin and unit of length of twists."""

    center: Array
    unit: float


@dataclass(frozen=True)
class Relation:
    """A joint as a linear relation, on the twist of its second body against its first, in a common frame.

    Attributes
    ----------
    rows : array (m, 6)
        Forbidden directions, orthonormal in the frame.
    free : array (6, f)
        Free twists of unit speed: rotations first, in radians, then translations, in the frame's unit of length.
    speeds : array (f,)
        Each of these in the world's units: 1 for rotations, the frame's unit for translations.
    """

    rows: Array
    free: Array
    speeds: Array

    @cached_property
    def to_coordinates(self) -> Array:
        """Matrix (f, 6) from relative twists to speeds of the coordinates, in the world's units."""
        return np.asarray(self.speeds[:, None] * np.linalg.pinv(self.free))


def relations(algebra: Algebra, joints: Sequence[Joint]) -> tuple[list[Relation], Frame]:
    """Relations of joints, and the frame in which they are expressed: at the center of the joints' positions.

    Raises
    ------
    InputError
        If the geometry of a joint does not have the mobility of its type.
    """
    groups: dict[tuple[Any, ...], list[int]] = {}
    conditions = [joint.conditions() for joint in joints]
    for i, (joint, each) in enumerate(zip(joints, conditions, strict=True)):
        plain = all(c.product is None for c in each)
        key = (type(joint), type(getattr(joint, "joint", None)), *(c.x.kind for c in each))
        groups.setdefault(key if plain else (i,), []).append(i)
    objects = [
        _objects(algebra, [joints[i] for i in members], [conditions[i] for i in members]) for members in groups.values()
    ]
    near = least_squares_center(objects)
    positions = [joint_locations(x, len(members), near) for members, x in zip(groups.values(), objects, strict=True)]
    size = extent(np.concatenate(positions), near)
    batches = [
        _local_constraints(algebra, [joints[i] for i in members], conditions[members[0]], x, where, size)
        for members, x, where in zip(groups.values(), objects, positions, strict=True)
    ]
    frame = _common_frame(np.concatenate([b.positions for b in batches]), np.concatenate([b.units for b in batches]))
    by_joint: dict[int, Relation] = {}
    for members, batch in zip(groups.values(), batches, strict=True):
        by_joint.update(zip(members, _in_frame(algebra, batch, frame), strict=True))
    return [by_joint[i] for i in range(len(joints))], frame


def _in_frame(algebra: Algebra, batch: _LocalBatch, frame: Frame) -> list[Relation]:
    """Relations of a batch in a common frame."""
    matrices = _local_to_frame(algebra, batch, frame)
    inverses = np.linalg.inv(matrices)
    found = []
    for k, (rows, free, slides) in enumerate(zip(batch.rows, batch.free, batch.slides, strict=True)):
        rows = rows @ inverses[k]
        rows = np.linalg.qr((rows / np.sqrt((rows * rows).sum(-1, keepdims=True))).T)[0].T
        sizes = np.where(slides, batch.units[k] / frame.unit, 1.0)
        speeds = np.where(slides, frame.unit, 1.0)
        found.append(Relation(rows, matrices[k] @ free / sizes, speeds))
    return found


def to_world(algebra: Algebra, frame: Frame) -> Array:
    """The matrix (6, 6) from twists of a frame to twists of the world."""
    units = np.where(rotational_mask(algebra), 1.0, frame.unit)
    matrix: Array = translation_adjoints(algebra, frame.center[None])[0] * units
    return matrix


def translation_adjoints(algebra: Algebra, displacements: Array) -> Array:
    """Matrices (n, 6, 6) of T S ~T on twists S, T the translations by displacements (n, 3)."""
    motors = algebra.translator(-displacements).as_kind("motor", check=False)
    rows: Array = evaluate(algebra, "mechanics.adjoint", motors).value
    return rows.reshape(-1, 6, 6)


@dataclass(frozen=True)
class _LocalBatch:
    """Joints of one type, each in its own frame."""

    positions: Array
    units: Array
    rows: list[Array]
    free: list[Array]
    slides: list[Array]


def _common_frame(positions: Array, units: Array) -> Frame:
    center = (positions.min(0) + positions.max(0)) / 2
    return Frame(center, extent(positions, center) or float(units.max()))


def _local_to_frame(algebra: Algebra, batch: _LocalBatch, frame: Frame) -> Array:
    """Matrices (n, 6, 6) from twists of the joints' own frames to those of a common one."""
    angular = rotational_mask(algebra)
    matrices: Array = translation_adjoints(algebra, batch.positions - frame.center)
    matrices = matrices * np.where(angular, 1.0, batch.units[:, None])[:, None, :]
    return matrices / np.where(angular, 1.0, frame.unit)[:, None]


def _objects(algebra: Algebra, joints: list[Joint], conditions: list[list[Condition]]) -> list[Multivector]:
    """Objects of joints of one type, as batches: those of the first bodies, and for a single joint with a product also
    those of the second."""
    label = f"the object of {joints[0].label}"
    batches = [_stack(algebra, [each[k].x for each in conditions], label) for k in range(len(conditions[0]))]
    if len(joints) == 1:
        batches += [_stack(algebra, [c.y], label) for c in conditions[0] if c.product is not None]
    return batches


def _local_constraints(
    algebra: Algebra, joints: list[Joint], conditions: list[Condition], objects: list[Multivector], positions: Array,
    extent_of_all: float,
) -> _LocalBatch:  # fmt: skip
    """Orthonormal constraint rows and free twists of joints of one type, each in its own frame.

    Joints without a length scale use the extent of the mechanism.
    """
    local = [~algebra.translator(positions) >> x for x in objects]
    units = length_scales(local, positions, extent_of_all)
    sizes, basis = _singular_values(algebra, joints, conditions, local, positions, units)
    ranks = _ranks(sizes, np.linalg.norm(positions, axis=-1) / units)
    angular, axes = rotational_mask(algebra), joints[0].axes(local[: len(conditions)])
    rows, free = [np.zeros((0, 6))] * len(joints), [np.zeros((6, 0))] * len(joints)
    slides: list[Array] = [np.zeros(0, bool)] * len(joints)
    for rank in set(ranks.tolist()):
        members = np.flatnonzero(ranks == rank)
        twists = _coordinates(algebra, basis[members, rank:], None if axes is None else axes[members])
        translational = np.abs(twists[:, angular]).max(1, initial=0) < SLIDE
        forbidden = basis[members, :rank]
        # rows that forbid translations alone are separated: units then change nothing of them
        mix, _, _ = np.linalg.svd(forbidden[..., angular])
        forbidden = np.swapaxes(mix, -1, -2) @ forbidden
        for i, k in enumerate(members.tolist()):
            _check_mobility(joints[k], 6 - rank, int(translational[i].sum()))
            rows[k], free[k], slides[k] = forbidden[i], twists[i], translational[i]
            if (pitch := joints[k].pitch) is not None:
                rows[k], free[k], slides[k] = _along_screw(forbidden[i], twists[i], pitch / float(units[k]))
    return _LocalBatch(positions, units, rows, free, slides)


def _singular_values(
    algebra: Algebra, joints: list[Joint], conditions: list[Condition], local: list[Multivector], positions: Array,
    units: Array,
) -> tuple[Array, Array]:  # fmt: skip
    """Singular values (n, 6) and right singular vectors (n, 6, 6) of the normalized constraint matrices."""
    matrices = []
    for condition, x in zip(conditions, local, strict=False):
        if condition.product is None:
            scaled = in_units(x, units)
            matrix = commutator_matrix(scaled, layout_of([scaled], joints[0].label))
        else:
            matrix = _bilinear(algebra, joints[0], condition, positions[0], float(units[0]))
        norms = np.linalg.norm(matrix, axis=(-1, -2), keepdims=True)
        matrices.append(np.divide(matrix, norms, out=np.zeros_like(matrix), where=norms > 0))
    _, sizes, basis = np.linalg.svd(np.concatenate(matrices, 1))
    return np.concatenate([sizes, np.zeros((len(joints), 6 - sizes.shape[-1]))], -1), basis


def _ranks(sizes: Array, distances: Array) -> Array:
    """Ranks (n,) of constraint matrices: singular values above rounding, which grows with the square of the distance
    from the origin, in units of the joint's length."""
    noise = np.maximum(NOISE, 100 * np.finfo(float).eps * distances**2)[:, None]
    return np.asarray((sizes > np.minimum(noise, 0.1) * sizes[:, :1]).sum(-1))


def _along_screw(rows: Array, twists: Array, pitch: float) -> tuple[Array, Array, Array]:
    """Rows, free twist (6, 1) and whether it is a translation, of a rotation and a translation that go together."""
    free = twists @ np.array([[1.0], [pitch]])
    within = twists - free @ (np.linalg.pinv(free) @ twists)  # of the two motions, what the screw has not
    extra = np.linalg.svd(within)[0][:, :1]
    return np.vstack([rows, extra.T]), free, np.zeros(1, bool)


def _check_mobility(joint: Joint, mobility: int, translations: int) -> None:
    """Check that the geometry of a joint has the mobility of its type."""
    remedy = joint.remedy or "Give geometry that is not degenerate"
    expected = joint.mobility + (joint.pitch is not None)
    if joint.mobility >= 0 and mobility != expected:
        raise InputError(
            f"{joint.label}: its geometry leaves a mobility of {mobility}, not of {expected}.", remedy=remedy
        )
    if joint.sliding not in (None, translations):
        raise InputError(f"{joint.label}: its geometry allows a rotation, not a translation.", remedy=remedy)


def _bilinear(algebra: Algebra, joint: Joint, condition: Condition, position: Array, unit: float) -> Array:
    """Matrix of B(X, Y x E) for unit twists E in the joint's frame, as seen from the first body."""
    product, x, y = condition.product, condition.x, condition.y
    assert product is not None
    if condition.equivariant:
        away = ~algebra.translator(position)
        x, y = (in_units(away >> v, unit) for v in (x, y))
    layout = layout_of([y], joint.label)
    function = matrix_of(lambda v: product(x, v), algebra, layout, joint.label)
    matrix = function @ commutator_matrix(y, layout)
    if not condition.equivariant:
        angular = rotational_mask(algebra)
        matrix = matrix @ (translation_adjoints(algebra, position[None])[0] * np.where(angular, 1.0, unit))
    return np.asarray(matrix[None])


def _stack(algebra: Algebra, objects: list[Multivector], what: str) -> Multivector:
    """Objects of one kind as a batch, on a layout that motions keep."""
    batch = algebra.wrap(objects[0].kind.layout, np.stack([x.values for x in objects]).astype(float))
    layout = layout_of([batch], what)
    return algebra.wrap(algebra.kind(layout).layout, on_layout(batch, layout))


def _coordinates(algebra: Algebra, basis: Array, axes: Array | None) -> Array:
    """Twists (n, 6, f) that span the same spaces as bases (n, f, 6): rotations, then translations, of unit speed, along
    axes (n, 3) if there are any."""
    angular, (count, free, _) = rotational_mask(algebra), basis.shape
    twists = np.zeros((count, free, 6))
    if not free:
        return np.swapaxes(twists, -1, -2)
    _, sizes, mix = np.linalg.svd(np.swapaxes(basis[..., angular], -1, -2))
    mixed, rotations = mix @ basis, (sizes > SLIDE).sum(-1)
    for n in set(rotations.tolist()):
        members = np.flatnonzero(rotations == n)
        rows, axis = mixed[members], None if axes is None else axes[members]
        if n == 3:  # about the axes of the world
            rows[:, :3] = np.linalg.inv(screw_vectors(algebra, rows[:, :3])[0]) @ rows[:, :3]
        for first, last, mask in ((0, n, angular), (n, free, ~angular)):
            part = rows[:, first:last]
            if n < 3 or first:
                part = part / np.linalg.norm(part[..., mask], axis=-1, keepdims=True)
            if last - first == 1:
                part = part * _axis_signs(algebra, part[:, 0], mask, axis)[:, None, None]
            rows[:, first:last] = part
        twists[members] = rows
    return np.swapaxes(twists, -1, -2)


def _axis_signs(algebra: Algebra, twists: Array, mask: Array, axes: Array | None) -> Array:
    """Signs (n,) for twists (n, 6), so that their masked part points along axes (n, 3), or has a positive largest
    component."""
    vectors = sum(screw_vectors(algebra, np.where(mask, twists, 0)))
    if axes is None:
        components = np.take_along_axis(vectors, np.abs(vectors).argmax(-1)[:, None], -1)[:, 0]
    else:
        components = (vectors * axes).sum(-1)
    return np.where(components < 0, -1.0, 1.0)
