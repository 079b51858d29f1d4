"""What joints take and leave, each seen from its own place and in its own unit of length.

Far from the origin the coefficients of an object hold little of its shape: a joint is looked at where it is, and the
relation that it gives is moved to the mechanism's frame as a linear map of twists. Joints of one sort go together.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..calls import call
from ..codegen.errors import InputError
from ..dynamics.layouts import layout_of, matrix_of, on_layout
from ..dynamics.pins import is_turn, rates_of
from ..lengths import in_units
from ..multivector import Multivector
from .joints import Condition, Joint
from .places import midst_of, places_of, spread_of, units_of

if TYPE_CHECKING:
    from ..algebras import Algebra

Array = NDArray[Any]
#: Shares of what a joint takes away that count as rounding.
NOISE = 1e-7
#: A twist that turns less than this slides.
SLIDE = 1e-6


@dataclass(frozen=True)
class Frame:
    """Where twists are measured from, and in what unit of length."""

    center: Array
    unit: float


@dataclass(frozen=True)
class Relation:
    """A joint as a linear relation, on the twist of its second body against its first, in a common frame.

    Attributes
    ----------
    rows : array (m, 6)
        What it forbids, orthonormal in the frame.
    free : array (6, f)
        Twists that it leaves, of unit speed: turns first, in radians, then slides, in the frame's unit of length.
    speeds : array (f,)
        What one of these is in the world's units: 1 for turns, the frame's unit for slides.
    place : array (3,)
    unit : float
        Of the joint's own.
    """

    rows: Array
    free: Array
    speeds: Array
    place: Array
    unit: float


def relations(algebra: Algebra, joints: Sequence[Joint], frame: Frame | None = None) -> tuple[list[Relation], Frame]:
    """The relations of joints, in a frame in their midst if none is given."""
    groups: dict[tuple[Any, ...], list[int]] = {}
    conditions = [joint.conditions() for joint in joints]
    for i, (joint, found) in enumerate(zip(joints, conditions, strict=True)):
        plain = all(c.product is None for c in found)
        sort = (type(joint), type(getattr(joint, "joint", None)), *(c.x.kind for c in found))
        groups.setdefault(sort if plain else (i,), []).append(i)
    objects = [
        _objects(algebra, [joints[i] for i in where], [conditions[i] for i in where]) for where in groups.values()
    ]
    near = midst_of(objects)
    places = [places_of(own, len(where), near) for where, own in zip(groups.values(), objects, strict=True)]
    spread = spread_of(np.concatenate(places), near)
    looked = [
        (where, _looked_at(algebra, [joints[i] for i in where], conditions[where[0]], own, found, spread))
        for where, own, found in zip(groups.values(), objects, places, strict=True)
    ]
    if frame is None:
        frame = _midst(np.concatenate([own.places for _, own in looked]), np.concatenate([x.units for _, x in looked]))
    made: list[Relation | None] = [None] * len(joints)
    for where, own in looked:
        to = _carried(algebra, own, frame)
        back = np.linalg.inv(to)
        for k, i in enumerate(where):
            rows = own.rows[k] @ back[k]
            rows = np.linalg.qr((rows / np.sqrt((rows * rows).sum(-1, keepdims=True))).T)[0].T
            free = to[k] @ own.free[k]
            sizes = np.where(own.slides[k], own.units[k] / frame.unit, 1.0)
            speeds = np.where(own.slides[k], frame.unit, 1.0)
            made[i] = Relation(rows, free / sizes, speeds, own.places[k], float(own.units[k]))
    return [x for x in made if x is not None], frame


def to_world(algebra: Algebra, frame: Frame) -> Array:
    """The matrix (6, 6) that takes twists of a frame to the world's."""
    matrix: Array = shifts(algebra, frame.center[None])[0] * np.where(_turns(algebra), 1.0, frame.unit)
    return matrix


def shifts(algebra: Algebra, ways: Array) -> Array:
    """Matrices (n, 6, 6) of T S ~T on twists S, T a translation by each of the ways (n, 3)."""
    motors = algebra.translator(-ways).as_kind("motor", check=False)
    rows: Array = call(algebra, "mechanics.adjoint", motors).value
    return rows.reshape(-1, 6, 6)


@dataclass(frozen=True)
class _Own:
    """Joints of one sort, each in its own frame."""

    places: Array
    units: Array
    rows: list[Array]
    free: list[Array]
    slides: list[Array]


def _midst(places: Array, units: Array) -> Frame:
    center = (places.min(0) + places.max(0)) / 2
    return Frame(center, spread_of(places, center) or float(units.max()))


def _carried(algebra: Algebra, own: _Own, frame: Frame) -> Array:
    turn = _turns(algebra)
    found: Array = shifts(algebra, own.places - frame.center)
    found = found * np.where(turn, 1.0, own.units[:, None])[:, None, :]
    return found / np.where(turn, 1.0, frame.unit)[:, None]


def _objects(algebra: Algebra, joints: list[Joint], conditions: list[list[Condition]]) -> list[Multivector]:
    """The objects of joints of one sort, as batches: those of the first bodies, and of a single joint with a product
    those of the second."""
    label = f"the object of {joints[0].label}"
    found = [_stacked(algebra, [own[k].x for own in conditions], label) for k in range(len(conditions[0]))]
    if len(joints) == 1:
        found += [_stacked(algebra, [c.y], label) for c in conditions[0] if c.product is not None]
    return found


def _looked_at(
    algebra: Algebra, joints: list[Joint], conditions: list[Condition], objects: list[Multivector], places: Array,
    spread: float,
) -> _Own:  # fmt: skip
    """Rows, orthonormal, and twists left, of joints that differ in their numbers alone, at their places; those that
    have no length are looked at in the spread of all."""
    reach = np.linalg.norm(places, axis=-1)
    local = [~algebra.translator(places) >> x for x in objects]
    units = units_of(local, places, spread)
    matrices = []
    for first, x in zip(conditions, local, strict=False):
        if first.product is None:
            scaled = in_units(x, units)
            matrix = rates_of(scaled, layout_of([scaled], joints[0].label))
        else:
            matrix = _bilinear(algebra, joints[0], first, places[0], float(units[0]))
        norms = np.linalg.norm(matrix, axis=(-1, -2), keepdims=True)
        matrices.append(np.divide(matrix, norms, out=np.zeros_like(matrix), where=norms > 0))
    _, sizes, basis = np.linalg.svd(np.concatenate(matrices, 1))
    sizes = np.concatenate([sizes, np.zeros((len(joints), 6 - sizes.shape[-1]))], -1)
    noise = np.maximum(NOISE, 100 * np.finfo(float).eps * (reach / units) ** 2)[:, None]
    ranks = (sizes > np.minimum(noise, 0.1) * sizes[:, :1]).sum(-1)
    turn, axes = _turns(algebra), joints[0].axes(local[: len(conditions)])
    rows, free = [np.zeros((0, 6))] * len(joints), [np.zeros((6, 0))] * len(joints)
    slides: list[Array] = [np.zeros(0, bool)] * len(joints)
    for rank in set(ranks.tolist()):
        alike = np.flatnonzero(ranks == rank)
        found = _coordinates(algebra, basis[alike, rank:], None if axes is None else axes[alike])
        sliding = np.abs(found[:, turn]).max(1, initial=0) < SLIDE
        held = basis[alike, :rank]
        mix, _, _ = np.linalg.svd(held[..., turn])  # what forbids slides alone apart: units then change nothing of it
        held = np.swapaxes(mix, -1, -2) @ held
        for k, own, those, left in zip(alike.tolist(), held, sliding, found, strict=True):
            _check(joints[k], 6 - rank, int(those.sum()))
            rows[k], free[k], slides[k] = own, left, those
    return _Own(places, units, rows, free, slides)


def _check(joint: Joint, left: int, slides: int) -> None:
    """Check that a joint leaves what its sort does."""
    remedy = joint.remedy or "Give geometry that is not degenerate"
    if joint.mobility >= 0 and left != joint.mobility:
        raise InputError(
            f"{joint.label}: its geometry leaves a mobility of {left}, not of {joint.mobility}.", remedy=remedy
        )
    if joint.sliding not in (None, slides):
        raise InputError(f"{joint.label}: its geometry leaves a turn, not a slide.", remedy=remedy)


def _bilinear(algebra: Algebra, joint: Joint, condition: Condition, place: Array, unit: float) -> Array:
    """B(X, Y x E) of unit twists E in the joint's frame: what a function asks for is seen from the first body."""
    product, x, y = condition.product, condition.x, condition.y
    assert product is not None
    if condition.equivariant:
        away = ~algebra.translator(place)
        x, y = (in_units(away >> v, unit) for v in (x, y))
    layout = layout_of([y], joint.label)
    function = matrix_of(lambda v: product(x, v), algebra, layout, joint.label)
    matrix = function @ rates_of(y, layout)
    if not condition.equivariant:
        turn = _turns(algebra)
        matrix = matrix @ (shifts(algebra, place[None])[0] * np.where(turn, 1.0, unit))
    return np.asarray(matrix[None])


def _stacked(algebra: Algebra, objects: list[Multivector], what: str) -> Multivector:
    """Objects of one kind as a batch, on a layout that motions keep."""
    together = algebra.wrap(objects[0].kind.layout, np.stack([x.values for x in objects]).astype(float))
    layout = layout_of([together], what)
    return algebra.wrap(algebra.kind(layout).layout, on_layout(together, layout))


def _coordinates(algebra: Algebra, basis: Array, axes: Array | None) -> Array:
    """The same twists (n, 6, f) as bases (n, f, 6), as turns, then slides, of unit speed, along axes (n, 3) where
    there are such."""
    turn, (count, free, _) = _turns(algebra), basis.shape
    found = np.zeros((count, free, 6))
    if not free:
        return np.swapaxes(found, -1, -2)
    _, sizes, mix = np.linalg.svd(np.swapaxes(basis[..., turn], -1, -2))
    mixed, turns = mix @ basis, (sizes > SLIDE).sum(-1)
    for n in set(turns.tolist()):
        alike = np.flatnonzero(turns == n)
        own, axis = mixed[alike], None if axes is None else axes[alike]
        if n == 3:  # about the axes of the world
            own[:, :3] = np.linalg.inv(_vectors(algebra, own[:, :3])[0]) @ own[:, :3]
        for first, last, which in ((0, n, turn), (n, free, ~turn)):
            part = own[:, first:last]
            if n < 3 or first:
                part = part / np.linalg.norm(part[..., which], axis=-1, keepdims=True)
            if last - first == 1:
                part = part * _signs(algebra, part[:, 0], which, axis)[:, None, None]
            own[:, first:last] = part
        found[alike] = own
    return np.swapaxes(found, -1, -2)


def _signs(algebra: Algebra, twists: Array, which: Array, axes: Array | None) -> Array:
    """Signs (n,) that let turns, or slides, of twists (n, 6) go along axes (n, 3), or mostly along a positive one."""
    ways = sum(_vectors(algebra, np.where(which, twists, 0)))
    if axes is None:
        along = np.take_along_axis(ways, np.abs(ways).argmax(-1)[:, None], -1)[:, 0]
    else:
        along = (ways * axes).sum(-1)
    return np.where(along < 0, -1.0, 1.0)


@cache
def _turns(algebra: Algebra) -> Array:
    """Which coefficients of a twist are turns."""
    return is_turn(algebra)


def _vectors(algebra: Algebra, twists: Array) -> tuple[Array, Array]:
    """w and v (..., 3) of twists (..., 6), w I3 + v n."""
    found = call(algebra, "mechanics.screw_vectors", algebra.wrap(algebra.kind("twist"), np.ascontiguousarray(twists)))
    return found.values[0].values, found.values[1].values
