"""What joints take and leave, each seen from its own place and in its own unit of length.

Far from the origin the coefficients of an object hold little of its shape: a joint is looked at where it is, and the
relation that it gives is moved to the mechanism's frame as a linear map of twists. Joints of one sort go together.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..calls import call
from ..codegen.errors import InputError
from ..dynamics.layouts import layout_of, matrix_of, on_layout
from ..dynamics.pins import is_turn, rates_of
from ..lengths import in_units, length_of
from ..multivector import Multivector
from .joints import Condition, Joint

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
        What it forbids.
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
        key = (type(joint), *(layout_of([c.x], joint.label) for c in found)) if plain else (i,)
        groups.setdefault(key, []).append(i)
    looked = [(where, _looked_at(algebra, [joints[i] for i in where], [conditions[i] for i in where]))
              for where in groups.values()]  # fmt: skip
    if frame is None:
        frame = _midst(np.concatenate([own.places for _, own in looked]), np.concatenate([x.units for _, x in looked]))
    made: list[Relation | None] = [None] * len(joints)
    for where, own in looked:
        to = _carried(algebra, own, frame)
        for k, i in enumerate(where):
            rows = own.rows[k] @ np.linalg.inv(to[k])
            rows /= np.linalg.norm(rows, axis=-1, keepdims=True)
            free = to[k] @ own.free[k]
            sizes = np.where(own.slides[k], own.units[k] / frame.unit, 1.0)
            speeds = np.where(own.slides[k], frame.unit, 1.0)
            made[i] = Relation(rows, free / sizes, speeds, own.places[k], float(own.units[k]))
    return [x for x in made if x is not None], frame


def to_world(algebra: Algebra, frame: Frame) -> Array:
    """The matrix (6, 6) that takes twists of a frame to the world's."""
    matrix: Array = shifts(algebra, frame.center[None])[0] * np.where(is_turn(algebra), 1.0, frame.unit)
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
    reach = float(np.abs(places - center).max(initial=0))
    return Frame(center, reach or float(units.max()))


def _carried(algebra: Algebra, own: _Own, frame: Frame) -> Array:
    turn = is_turn(algebra)
    found: Array = shifts(algebra, own.places - frame.center)
    found = found * np.where(turn, 1.0, own.units[:, None])[:, None, :]
    return found / np.where(turn, 1.0, frame.unit)[:, None]


def _looked_at(algebra: Algebra, joints: list[Joint], conditions: list[list[Condition]]) -> _Own:
    """Rows, orthonormal, and twists left, of joints that differ in their numbers alone."""
    objects = [_stacked(algebra, [found[k].x for found in conditions]) for k in range(len(conditions[0]))]
    if len(joints) == 1:
        objects += [_stacked(algebra, [c.y]) for c in conditions[0] if c.product is not None]
    places = places_of(objects, len(joints))
    reach = np.linalg.norm(places, axis=-1)
    local = [~algebra.translator(places) >> x for x in objects]
    units = length_of(local)
    matrices = []
    for k, x in enumerate(local[: len(conditions[0])]):
        first = conditions[0][k]
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
    rows, free = [], []
    for k, joint in enumerate(joints):
        _check(joint, 6 - int(ranks[k]))
        rows.append(basis[k, : ranks[k]])
        free.append(_coordinates(algebra, basis[k, ranks[k] :], joint.axis()))
    turn = is_turn(algebra)
    slides = [np.abs(x[turn]).max(0, initial=0) < SLIDE for x in free]
    return _Own(places, units, rows, free, slides)


def _check(joint: Joint, left: int) -> None:
    if joint.mobility >= 0 and left != joint.mobility:
        raise InputError(
            f"{joint.label}: its geometry leaves a mobility of {left}, not of {joint.mobility}.",
            remedy=joint.remedy or "Give geometry that is not degenerate",
        )


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
        turn = is_turn(algebra)
        matrix = matrix @ (shifts(algebra, place[None])[0] * np.where(turn, 1.0, unit))
    return np.asarray(matrix[None])


def _stacked(algebra: Algebra, objects: list[Multivector]) -> Multivector:
    layout = layout_of(objects, "a joint's object")
    return algebra.wrap(algebra.kind(layout).layout, np.stack([on_layout(x, layout) for x in objects]))


def places_of(objects: list[Multivector], count: int) -> Array:
    """A point near each joint: of the first object that says where it is."""
    for x in objects:
        found = _position(x)
        if found is not None:
            return np.where(np.isfinite(found), found, 0.0)
    return np.zeros((count, 3))


def _position(x: Multivector) -> Array | None:
    for kind in ("point", "sphere", "circle", "point_pair", "line", "plane"):
        if kind in x.algebra.kinds and set(x.kind.blades) == set(x.algebra.kind(kind).blades):
            p = x.as_kind(kind, check=False).parameters()
            for name in ("xyz", "center", "point"):
                if hasattr(p, name):
                    return np.asarray(getattr(p, name), float)
            if hasattr(p, "a"):
                return np.asarray((p.a + p.b) / 2, float)
            return np.asarray(p.offset[..., None] * p.normal, float)
    if set(x.kind.blades) == set(x.algebra.kind("twist").blades):
        turn, way = (v.values for v in call(x.algebra, "mechanics.screw_vectors", x).values)
        square = (turn * turn).sum(-1, keepdims=True)
        return np.cross(turn, way) / np.where(square > 0, square, np.inf)
    return None


def _coordinates(algebra: Algebra, basis: Array, axis: Array | None) -> Array:
    """The same twists (6, f) as turns, then slides, of unit speed, along an axis where there is one."""
    turn = is_turn(algebra)
    if not len(basis):
        return np.zeros((6, 0))
    _, sizes, mix = np.linalg.svd(basis[:, turn].T)
    mixed = mix @ basis
    count = int((sizes > SLIDE).sum())
    turns, slides = mixed[:count], mixed[count:]
    if count == 3:
        turns = np.linalg.inv(turns[:, turn]) @ turns
    else:
        turns = turns / np.linalg.norm(turns[:, turn], axis=-1, keepdims=True)
    slides = slides / np.linalg.norm(slides, axis=-1, keepdims=True)
    for part, which in ((turns, turn), (slides, ~turn)):
        if len(part) == 1:
            part *= _sign(algebra, part[0], which, axis)
    return np.concatenate([turns, slides]).T


def _sign(algebra: Algebra, twist: Array, which: Array, axis: Array | None) -> float:
    names = call(
        algebra, "mechanics.screw_vectors", algebra.wrap(algebra.kind("twist"), np.where(which, twist, 0)[None])
    )
    way = sum(v.values[0] for v in names.values)
    along = way @ axis if axis is not None else way[np.argmax(np.abs(way))]
    return -1.0 if along < 0 else 1.0
