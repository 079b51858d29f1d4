"""From what users hand to `draw` to groups of objects of one sort with their parameters, read in one call per kind.

Items that are no real, finite objects are left out and counted by what they are.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..multivector import Multivector
from ..rows import levelled
from ..status import Status
from . import checks

#: What `classify` says to the kind whose parameters are read.
KINDS = {
    "point": "point", "flat point": "flat_point", "direction": "direction", "point pair": "point_pair", "line": "line",
    "circle": "circle", "plane": "plane", "sphere": "sphere", "dual plane": "plane", "dual sphere": "sphere",
}  # fmt: skip
MOTIONS = ("motor", "rotor", "translator", "dilator", "homothety")
#: Not objects at all, however many there are.
NOTHING = ("scalar", "pseudoscalar")
#: Values of the parameter at which a curve of objects is drawn, and one of points, for each segment.
CURVE_SAMPLES, PATH_SAMPLES = 48, 128


@dataclass(frozen=True)
class Group:
    """Objects of one sort: parameters with one row per object, and their places among the items of the thing."""

    sort: str
    parameters: tuple[NDArray[np.float64], ...]
    places: NDArray[np.intp]


@dataclass(frozen=True)
class Sorted:
    """A thing as groups; ``count`` items in all, of which ``skipped`` have no picture."""

    groups: list[Group]
    count: int
    skipped: Counter[str]
    values: NDArray[np.float64] | None = None


def sorted_out(thing: Any, samples: int | None = None) -> Sorted:
    """Groups of a multivector, an array of positions (..., 3), a curve, or a list of such things.

    Raises
    ------
    InputError
        If it is something else, or of an algebra that has no pictures.
    """
    if isinstance(thing, Multivector):
        return _multivector(thing)
    if callable(thing) and not isinstance(thing, type) and (hasattr(thing, "domain") or hasattr(thing, "segments")):
        return _curve(thing, samples)
    if isinstance(thing, np.ndarray):
        return _positions(thing)
    if isinstance(thing, list | tuple):
        return _several(thing, samples)
    raise InputError(
        f"a {type(thing).__name__} cannot be drawn.",
        remedy="Objects of cga3d and pga3d, curves, arrays (..., 3) of positions, and lists of them can",
    )


def _several(things: Any, samples: int | None) -> Sorted:
    groups: list[Group] = []
    count, skipped = 0, Counter[str]()
    for thing in things:
        part = sorted_out(thing, samples)
        groups += [Group(g.sort, g.parameters, g.places + count) for g in part.groups]
        count += part.count
        skipped += part.skipped
    return Sorted(_joined(groups), count, skipped)


def _joined(groups: list[Group]) -> list[Group]:
    """Groups of the same sort as one."""
    joined = []
    for sort in dict.fromkeys(g.sort for g in groups):
        own = [g for g in groups if g.sort == sort]
        if sort == "path":  # of different lengths
            joined += own
            continue
        parameters = tuple(np.concatenate(rows) for rows in zip(*(g.parameters for g in own), strict=True))
        joined.append(Group(sort, parameters, np.concatenate([g.places for g in own])))
    return joined


def _positions(xyz: NDArray[Any]) -> Sorted:
    if xyz.ndim == 0 or xyz.shape[-1] != 3 or xyz.dtype.kind not in "fiu":
        raise InputError(f"an array of shape {xyz.shape} holds no positions: those have a last axis of 3 numbers.")
    rows = xyz.reshape(-1, 3).astype(float)
    return _finite("point", (rows,), np.arange(len(rows)), len(rows), Counter())


def _finite(sort: str, parameters: Any, places: Any, count: int, skipped: Counter[str]) -> Sorted:
    """One group, without the items that are not finite, or too large or far for a picture."""
    flat = np.concatenate([rows.reshape(len(places), int(np.prod(rows.shape[1:]))) for rows in parameters], axis=1)
    finite = np.isfinite(flat).all(-1)
    known = np.asarray((np.abs(flat) <= checks.FARTHEST).all(-1))
    if sort == "plane":
        known &= parameters[0].any(-1)  # a sphere so large that rounding leaves a plane of it, but no normal
    for name, items in (("not finite", ~finite), ("too far", finite & ~known)):
        if items.any():
            skipped = skipped + Counter({name: int(items.sum())})
    kept = tuple(rows[known] for rows in parameters)
    return Sorted([Group(sort, kept, places[known])] if known.any() else [], count, skipped)


def _multivector(x: Multivector) -> Sorted:
    x = x.reshape(-1)
    classify = getattr(x.algebra, "classify", None)
    if classify is None or getattr(x.algebra, "space", 0) != 3:
        raise InputError(f"{x.algebra.name} has no pictures; those of cga3d and pga3d have.")
    if len(x.grades) == 1:
        x = levelled(x)[0]  # of any scale
    groups: list[Group] = []
    skipped: Counter[str] = Counter()
    for name, places in _by_name(x, classify):
        if name in NOTHING and len(x.grades) == 1:
            raise InputError(f"a {name} of {x.algebra.name} cannot be drawn.")
        if name not in KINDS and name not in MOTIONS:
            skipped[name] += len(places)
            continue
        part = x if len(places) == x.size else x[places]
        parameters = _frames(part) if name in MOTIONS else _read(part, name)
        found = _finite("frame" if name in MOTIONS else KINDS[name], parameters, places, x.size, skipped)
        groups += found.groups
        skipped = found.skipped
    return Sorted(_joined(groups), x.size, skipped)


def _by_name(x: Multivector, classify: Any) -> Iterator[tuple[str, NDArray[np.intp]]]:
    """What the items are, and which; those without an answer by their status."""
    if not x.size:
        return
    is_motion = x.kind.name in MOTIONS and bool(x.kind.constraints)  # which may be the identity, a scalar
    names = np.full(x.shape, "motor", object) if is_motion else np.asarray(classify(x), object)
    if x._status is not None:
        for code in np.unique(x._status):
            if code not in (Status.OK, Status.NOT_UNIQUE):
                names[x._status == code] = Status(int(code)).name
    for name in dict.fromkeys(names.tolist()):
        yield str(name), np.flatnonzero(names == name)


def _read(x: Multivector, name: str) -> tuple[NDArray[np.float64], ...]:
    """Parameters, and the orientation of spheres; of the kind that the items are, not of a wider one."""
    if name.startswith("dual "):
        x = x.undual()
    kind = x.algebra.kind(KINDS[name])
    if x.kind != kind:
        if not x.kind.constraints or not kind.constraints:
            x = x.as_kind(kind.layout, check=False)
            x = x.normalized(kind) if kind.constraints else x.as_kind(kind)
        else:
            x = x.as_kind(kind, check=False)
    found = x.parameters()
    rows = tuple(np.asarray(field, float) for field in found)
    return (*rows, np.asarray(found.orientation, float)) if kind.name == "sphere" else rows


def _frames(motion: Multivector) -> tuple[NDArray[np.float64], ...]:
    """Where motions take the origin and the ends of the three unit vectors: (n, 3) and (n, 3, 3), axes as rows."""
    algebra: Any = motion.algebra
    images = (motion[:, None] >> algebra.point(np.concatenate([np.zeros((1, 3)), np.eye(3)])[None])).normalized("point")
    xyz = np.asarray(images.parameters().xyz, float)
    return xyz[:, 0], xyz[:, 1:] - xyz[:, :1]


def _curve(curve: Any, samples: int | None) -> Sorted:
    """Objects along a curve, with their parameters; a polyline where they are points."""
    start, end = getattr(curve, "domain", None) or (0.0, float(curve.segments))
    pieces = max(1, int(np.ceil(getattr(curve, "segments", 1))))
    of_points = _is_of_points(curve(np.array([start])))
    count = pieces * (samples or (PATH_SAMPLES if of_points else CURVE_SAMPLES)) + 1
    t = np.linspace(float(start), float(end), count)
    if not of_points:
        return replace(sorted_out(curve(t)), values=t)
    xyz = np.asarray(curve(t).parameters().xyz, float)
    return Sorted([Group("path", (xyz[None],), np.zeros(1, np.intp))], 1, Counter())


def _is_of_points(x: Any) -> bool:
    return isinstance(x, Multivector) and x.kind.name == "point"
