"""Objects that are there twice: found by numbers that are equal for one object, however it is written."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from .parameters import POSITIONS, Rows, columns

Indices = NDArray[np.int64]
#: Features of objects that differ by less than this are rounding (of coordinates relative to the model's size).
SAME = 1e-12
#: Rounding units of the coordinates that differences never count below.
NOISE = 64


def first_of_each(rows: Mapping[str, Rows], tolerance: float = SAME) -> dict[str, Indices]:
    """By kind, for each object the first one that is the same."""
    center, size, reach = extent(rows)
    limit = max(float(tolerance), NOISE * float(np.finfo(float).eps) * reach / size)
    return {kind: same(features(part, kind, center, size), limit) for kind, part in rows.items()}


def extent(rows: Mapping[str, Rows]) -> tuple[Rows, float, float]:
    """A middle of all objects, the size about it, and the greatest coordinate."""
    fields = [(field, part[:, place]) for kind, part in rows.items() for field, place in columns(kind).items()]
    places = [values for field, values in fields if field in POSITIONS]
    center = np.concatenate(places).mean(0) if places else np.zeros(3)
    spread = [float(np.abs(values - center).max()) for values in places]
    spread += [float(values.max()) for field, values in fields if field == "radius"]
    reach = [float(np.abs(values).max()) for field, values in fields if field in (*POSITIONS, "radius", "offset")]
    size = max(spread, default=0.0) or max(reach, default=0.0) or 1.0
    return center, size, max(size, *reach, 0.0)


def features(rows: Rows, kind: str, center: Rows, size: float) -> Rows:
    """Numbers (n, m) that are equal for one object, however it is written or turned, about a centre in a unit."""
    part = {name: rows[:, place] for name, place in columns(kind).items()}
    places = {name: (part[name] - center) / size for name in POSITIONS if name in part}
    if kind == "point_pair":
        middle, half = (places["a"] + places["b"]) / 2, (places["b"] - places["a"]) / 2
        return np.concatenate([middle, _squares(half)], 1)
    along = part.get("direction", part.get("normal"))
    found = [] if along is None else [_squares(along)]
    if kind == "line":
        assert along is not None
        place = places["point"]
        found.append(place - (place * along).sum(1, keepdims=True) * along)
    elif kind == "plane":
        assert along is not None
        found.append((part["offset"] - along @ center[:, None]) / size * along)
    else:
        found += [places.get("xyz", places.get("center", np.empty((len(rows), 0))))]
    if "radius" in part:
        found.append(part["radius"] / size)
    return np.concatenate(found, 1)


def _squares(v: Rows) -> Rows:
    """Products of the entries of vectors: the same for v and -v."""
    i, j = np.triu_indices(3)
    return np.asarray(v[:, i] * v[:, j])


def same(found: Rows, tolerance: float = SAME) -> NDArray[np.int64]:
    """For each row of features the first row that is one with it: by chains of rows that differ by less."""
    group = np.zeros(len(found), np.int64)
    count = 0 if not len(found) else 1
    while True:  # rows within the tolerance are neighbours in every column: what no column parts is one
        for column in found.T:
            order = np.lexsort((column, group))
            value, own = column[order], group[order]
            apart = np.concatenate([[True], (np.diff(value) > tolerance) | (np.diff(own) != 0)]) if len(own) else own
            group[order] = np.cumsum(apart) - 1
        parts = int(group.max(initial=-1)) + 1
        if parts == count:
            break
        count = parts
    first = np.full(count, len(found))
    np.minimum.at(first, group, np.arange(len(found)))
    return np.asarray(first[group], np.int64)
