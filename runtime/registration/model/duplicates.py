"""Detection of duplicate objects by features that do not depend on the parametrization of an object."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from .parameters import POSITIONS, Rows, columns

Indices = NDArray[np.int64]
#: Default of the largest difference of features of equal objects, relative to the model's size.
TOLERANCE = 1e-12
#: Smallest tolerance, in rounding units of the coordinates.
ROUNDING_UNITS = 64


def first_occurrences(rows: Mapping[str, Rows], tolerance: float = TOLERANCE) -> dict[str, Indices]:
    """Index of the first equal object, for each object by kind."""
    center, size, magnitude = extent(rows)
    limit = max(float(tolerance), ROUNDING_UNITS * float(np.finfo(float).eps) * magnitude / size)
    return {kind: first_equal_rows(features(part, kind, center, size), limit) for kind, part in rows.items()}


def extent(rows: Mapping[str, Rows]) -> tuple[Rows, float, float]:
    """Center of all objects, their size about it, and the largest absolute coordinate."""
    fields = [(field, part[:, place]) for kind, part in rows.items() for field, place in columns(kind).items()]
    positions = [values for field, values in fields if field in POSITIONS]
    center = np.concatenate(positions).mean(0) if positions else np.zeros(3)
    sizes = [float(np.abs(values - center).max()) for values in positions]
    sizes += [float(values.max()) for field, values in fields if field == "radius"]
    magnitudes = [float(np.abs(values).max()) for field, values in fields if field in (*POSITIONS, "radius", "offset")]
    size = max(sizes, default=0.0) or max(magnitudes, default=0.0) or 1.0
    return center, size, max(size, *magnitudes, 0.0)


def features(rows: Rows, kind: str, center: Rows, size: float) -> Rows:
    """Features (n, m) that are equal for every parametrization and orientation of an object, relative to a center and a
    size."""
    part = {name: rows[:, point] for name, point in columns(kind).items()}
    positions = {name: (part[name] - center) / size for name in POSITIONS if name in part}
    if kind in ("point_pair", "segment"):
        middle, half = (positions["a"] + positions["b"]) / 2, (positions["b"] - positions["a"]) / 2
        return np.concatenate([middle, _sign_free(half)], 1)
    direction = part.get("direction", part.get("normal"))
    columns_ = [] if direction is None else [_sign_free(direction)]
    if kind == "line":
        assert direction is not None
        point = positions["point"]
        columns_.append(point - (point * direction).sum(1, keepdims=True) * direction)
    elif kind == "plane":
        assert direction is not None
        columns_.append((part["offset"] - direction @ center[:, None]) / size * direction)
    else:
        columns_ += [positions.get("xyz", positions.get("center", np.empty((len(rows), 0))))]
    if "radius" in part:
        columns_.append(part["radius"] / size)
    return np.concatenate(columns_, 1)


def _sign_free(v: Rows) -> Rows:
    """Products of the entries of vectors, which are equal for v and -v."""
    i, j = np.triu_indices(3)
    return np.asarray(v[:, i] * v[:, j])


def first_equal_rows(features_: Rows, tolerance: float = TOLERANCE) -> NDArray[np.int64]:
    """Index of the first equal row, for each row of features: rows are equal through chains of smaller differences."""
    group = np.zeros(len(features_), np.int64)
    count = 0 if not len(features_) else 1
    while True:  # rows within the tolerance are adjacent in every column: groups that no column splits
        for column in features_.T:
            order = np.lexsort((column, group))
            value, group_of = column[order], group[order]
            starts_group = (
                np.concatenate([[True], (np.diff(value) > tolerance) | (np.diff(group_of) != 0)])
                if len(group_of)
                else group_of
            )
            group[order] = np.cumsum(starts_group) - 1
        parts = int(group.max(initial=-1)) + 1
        if parts == count:
            break
        count = parts
    first = np.full(count, len(features_))
    np.minimum.at(first, group, np.arange(len(features_)))
    return np.asarray(first[group], np.int64)
