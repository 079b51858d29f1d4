"""Arguments of `draw` as groups of objects of one kind with their parameters, read in one call for each kind.

Items that are not real, finite objects are dropped and counted by kind or status.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..core.multivector import Multivector
from ..dispatch.coefficients import normalize_exponents
from ..errors import InputError
from ..status import Status
from .tessellation import FARTHEST

#: Kinds whose parameters are read, by the names from `classify`.
KINDS = {
    "point": "point", "flat point": "flat_point", "direction": "direction", "point pair": "point_pair", "line": "line",
    "circle": "circle", "plane": "plane", "sphere": "sphere", "dual plane": "plane", "dual sphere": "sphere",
}  # fmt: skip
#: Kinds of motions, which are drawn as frames.
MOTIONS = ("motor", "rotor", "translator", "dilator", "homothety")
#: Kinds that are not objects.
NOTHING = ("scalar", "pseudoscalar")
#: Number of drawn objects for each segment of a curve.
CURVE_SAMPLES = 48
#: Number of samples for each segment of a curve of points.
PATH_SAMPLES = 128


@dataclass(frozen=True)
class Group:
    """Objects of one kind: parameters with one row for each, and their indices among the items of the argument."""

    sort: str
    parameters: tuple[NDArray[np.float64], ...]
    indices: NDArray[np.intp]


@dataclass(frozen=True)
class ItemGroups:
    """An argument as groups: ``count`` items in all, of which ``skipped`` have no picture."""

    groups: list[Group]
    count: int
    skipped: Counter[str]
    values: NDArray[np.float64] | None = None


def group_items(thing: Any, samples: int | None = None) -> ItemGroups:
    """Group the items of a multivector, an array of positions (..., 3), a curve, or a list of these.

    Raises
    ------
    InputError
        If the argument is something else, or belongs to an algebra without pictures.
    """
    if isinstance(thing, Multivector):
        return _multivector(thing)
    if is_curve(thing):
        return _curve(thing, samples)
    if isinstance(thing, np.ndarray):
        return _positions(thing)
    if isinstance(thing, list | tuple):
        return _sequence(thing, samples)
    raise InputError(
        f"a {type(thing).__name__} cannot be drawn.",
        remedy="Objects of cga3d and pga3d, curves, arrays (..., 3) of positions, and lists of them can",
    )


def is_curve(thing: Any) -> bool:
    """A function of a parameter that says over which domain: what is drawn as a curve."""
    return callable(thing) and not isinstance(thing, type) and (hasattr(thing, "domain") or hasattr(thing, "segments"))


def _sequence(things: Any, samples: int | None) -> ItemGroups:
    groups: list[Group] = []
    count, skipped = 0, Counter[str]()
    for thing in things:
        part = group_items(thing, samples)
        groups += [Group(g.sort, g.parameters, g.indices + count) for g in part.groups]
        count += part.count
        skipped += part.skipped
    return ItemGroups(_merge_groups(groups), count, skipped)


def _merge_groups(groups: list[Group]) -> list[Group]:
    """Merge groups of the same kind; items in their order."""
    merged = []
    for sort in dict.fromkeys(g.sort for g in groups):
        members = [g for g in groups if g.sort == sort]
        if sort == "path" or len(members) == 1:  # paths are of different lengths
            merged += members
            continue
        indices = np.concatenate([g.indices for g in members])
        order = indices.argsort()
        parameters = (np.concatenate(rows)[order] for rows in zip(*(g.parameters for g in members), strict=True))
        merged.append(Group(sort, tuple(parameters), indices[order]))
    return merged


def _positions(xyz: NDArray[Any]) -> ItemGroups:
    if xyz.ndim == 0 or xyz.shape[-1] != 3 or xyz.dtype.kind not in "fiu":
        raise InputError(f"an array of shape {xyz.shape} cannot be drawn; positions have a last axis of 3 numbers.")
    rows = xyz.reshape(-1, 3).astype(float)
    return _finite("point", (rows,), np.arange(len(rows)), len(rows), Counter())


def _finite(sort: str, parameters: Any, indices: Any, count: int, skipped: Counter[str]) -> ItemGroups:
    """Make one group, without items that are not finite, or too large or too far for a picture."""
    flat = np.concatenate([rows.reshape(len(indices), int(np.prod(rows.shape[1:]))) for rows in parameters], axis=1)
    usable = np.asarray((np.abs(flat) <= FARTHEST).all(-1))
    if sort == "plane":
        usable &= parameters[0].any(-1)  # a huge sphere may become a plane without a normal by rounding
    if usable.all() and count:
        return ItemGroups([Group(sort, tuple(parameters), indices)], count, skipped)
    finite = np.isfinite(flat).all(-1)
    for name, items in (("not finite", ~finite), ("too far", finite & ~usable)):
        if items.any():
            skipped = skipped + Counter({name: int(items.sum())})
    selected = tuple(rows[usable] for rows in parameters)
    return ItemGroups([Group(sort, selected, indices[usable])] if usable.any() else [], count, skipped)


def _multivector(x: Multivector) -> ItemGroups:
    x = x.reshape(-1)
    classify = getattr(x.algebra, "classify", None)
    if classify is None or getattr(x.algebra, "space", 0) != 3:
        raise InputError(f"{x.algebra.name} has no pictures; those of cga3d and pga3d have.")
    if len(x.grades) == 1:
        x = normalize_exponents(x)[0]  # of any scale
    groups: list[Group] = []
    skipped: Counter[str] = Counter()
    for name, indices in _by_name(x, classify):
        if name in NOTHING and len(x.grades) == 1:
            raise InputError(f"a {name} of {x.algebra.name} cannot be drawn.")
        if name not in KINDS and name not in MOTIONS:
            skipped[name] += len(indices)
            continue
        part = x if len(indices) == x.size else x[indices]
        parameters = _frames(part) if name in MOTIONS else _read(part, name)
        part_groups = _finite("frame" if name in MOTIONS else KINDS[name], parameters, indices, x.size, skipped)
        groups += part_groups.groups
        skipped = part_groups.skipped
    return ItemGroups(_merge_groups(groups), x.size, skipped)


def _by_name(x: Multivector, classify: Any) -> Iterator[tuple[str, NDArray[np.intp]]]:
    """Kinds of items, and the indices of each; invalid items go by their status."""
    if not x.size:
        return
    is_motion = x.kind.name in MOTIONS and bool(x.kind.constraints)  # the identity would classify as a scalar
    names = np.full(x.shape, "motor", object) if is_motion else np.asarray(classify(x), object)
    if x._status is not None:
        for code in np.unique(x._status):
            if code not in (Status.OK, Status.NOT_UNIQUE):
                names[x._status == code] = Status(int(code)).name
    for name in dict.fromkeys(names.tolist()):
        yield str(name), np.flatnonzero(names == name)


def _read(x: Multivector, name: str) -> tuple[NDArray[np.float64], ...]:
    """Read parameters, and the orientation of spheres, as the narrowest kind of the items."""
    if name.startswith("dual "):
        x = x.undual()
    kind = x.algebra.kind(KINDS[name])
    if x.kind != kind:
        if not x.kind.constraints or not kind.constraints:
            x = x.as_kind(kind.layout, check=False)
            x = x.normalized(kind) if kind.constraints else x.as_kind(kind)
        else:
            x = x.as_kind(kind, check=False)
    parameters = x.parameters()
    rows = tuple(np.asarray(field, float) for field in parameters)
    return (*rows, np.asarray(parameters.orientation, float)) if kind.name == "sphere" else rows


def _frames(motion: Multivector) -> tuple[NDArray[np.float64], ...]:
    """Images of the origin and of the three unit vectors under motions: (n, 3) and (n, 3, 3), axes as rows."""
    algebra: Any = motion.algebra
    images = (motion[:, None] >> algebra.point(np.concatenate([np.zeros((1, 3)), np.eye(3)])[None])).normalized("point")
    xyz = np.asarray(images.parameters().xyz, float)
    return xyz[:, 0], xyz[:, 1:] - xyz[:, :1]


def _curve(curve: Any, samples: int | None) -> ItemGroups:
    """Sample a curve of objects, with their parameters; a curve of points becomes a polyline."""
    start, end = getattr(curve, "domain", None) or (0.0, float(curve.segments))
    pieces = max(1, int(np.ceil(getattr(curve, "segments", 1))))
    of_points = _is_of_points(curve(np.array([start])))
    count = pieces * (samples or (PATH_SAMPLES if of_points else CURVE_SAMPLES)) + 1
    t = np.linspace(float(start), float(end), count)
    if not of_points:
        return replace(group_items(curve(t)), values=t)
    xyz = np.asarray(curve(t).parameters().xyz, float)
    return ItemGroups([Group("path", (xyz[None],), np.zeros(1, np.intp))], 1, Counter())


def _is_of_points(x: Any) -> bool:
    return isinstance(x, Multivector) and x.kind.name == "point"
