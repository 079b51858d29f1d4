"""Objects as binary parts of a picture, for a front end; what is as it was in the last picture is not made again."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..core.multivector import Multivector
from . import drawing, palette
from .glyphs import Drawable, Faces, Marks, Strokes
from .input_groups import group_items
from .style import shade_triangles
from .tessellation import Array, Box

#: Objects drawn along each segment of a curve: fewer than in still pictures.
SAMPLES = 24
#: Pixels of a point of line width.
PIXELS = 1.4
#: Radius of points, in widths of lines.
RADIUS = 1.6
KINDS = {Strokes: "strokes", Faces: "faces", Marks: "marks"}

#: Binary positions about the center of the box, float32, and colors, uint8, with their kind, number and size.
Part = dict[str, Any]


@dataclass
class PackedObjects:
    """The objects of a picture in a box: the parts of each, and what they were made from.

    Attributes
    ----------
    box : Box
    parts : list
        The parts of each object; the same list as before where nothing of it changed.
    """

    box: Box
    parts: list[list[Part]] = field(default_factory=list)
    _contents: list[Any] = field(default_factory=list)

    def update(self, things: Sequence[Any]) -> None:
        """Make the parts of these objects; an object that cannot be drawn raises, and all is as it was."""
        contents = [content(thing) for thing in things]
        parts: list[list[Part]] = [[] for _ in things]
        changed = []
        for i, new in enumerate(contents):
            if new is not None and i < len(self.parts) and new == self._contents[i]:
                parts[i] = self.parts[i]
            else:
                changed.append(i)
        colors = palette.classes(np.arange(len(things)))
        for members in _batches(things, changed):
            for i, part in self._pack(things, members, colors[members]):
                parts[i].append(part)
        self.parts, self._contents = parts, contents

    def _pack(self, things: Sequence[Any], members: list[int], colors: palette.Rgba) -> Iterator[tuple[int, Part]]:
        """The parts of one object, or of several single ones of one type; each with the object's index."""
        thing, indices = things[members[0]], np.array(members)
        if is_mesh(thing):
            triangles = vertices(thing)[np.asarray(thing.faces)]
            faces = Faces(triangles, shade_triangles(triangles, palette.SERIES[members[0] % len(palette.SERIES)], 1.0))
            yield from self._split(faces, np.repeat(indices, len(triangles)))
            return
        batch = thing if len(members) == 1 else _joined([things[i] for i in members])
        for drawable in drawables(batch, colors, len(members) == 1):
            rows = drawable.group.indices
            owners = np.repeat(indices, len(rows)) if len(members) == 1 else indices[rows]
            for outline in drawable.outline(self.box):
                yield from self._split(outline, np.repeat(owners, len(outline.positions) // len(owners)))

    def _split(self, part: Strokes | Faces | Marks, owners: NDArray[np.intp]) -> Iterator[tuple[int, Part]]:
        """What is in view of a part, by the object that each row belongs to."""
        positions, colors, owners = drawing.present(part.positions, part.colors, owners)
        relative = np.ascontiguousarray(positions - self.box.center, "<f4")
        shades = np.rint(255 * colors).astype(np.uint8)
        width = part.width if isinstance(part, Strokes) else RADIUS * part.size if isinstance(part, Marks) else 0
        starts = np.flatnonzero(np.diff(owners, prepend=-1)).tolist()
        for begin, end in pairwise([*starts, len(owners)]):
            yield int(owners[begin]), {
                "kind": KINDS[type(part)], "count": end - begin, "size": PIXELS * drawing.WIDTH * width,
                "corners": 1 if positions.ndim == 2 else positions.shape[1],
                "positions": relative[begin:end].tobytes(),
                "colors": (shades if len(shades) == 1 else shades[begin:end]).tobytes(),
            }  # fmt: skip


def content(thing: Any) -> Any:
    """A copy of all that a picture depends on, to be compared; None for what is not known so well, as curves."""
    if isinstance(thing, Multivector):
        return thing._type, thing.shape, thing._data.tobytes(), thing._status is not None and thing._status.tobytes()
    if isinstance(thing, np.ndarray):
        return thing.dtype.str, thing.shape, thing.tobytes()
    if isinstance(thing, list | tuple):
        inside = [content(x) for x in thing]
        return None if None in inside else inside
    return [vertices(thing).tobytes(), np.asarray(thing.faces).tobytes()] if is_mesh(thing) else None


def drawables(thing: Any, colors: palette.Rgba, is_one: bool = True) -> list[Drawable]:
    """The groups of an object, or of a batch of objects that are drawn as if each was alone, each of its color."""
    part = group_items(thing, SAMPLES)
    rows = colors if part.values is None else palette.per_item(part.values, part.count, "")
    return [
        Drawable(group, palette.take_rows(rows, group.indices), coarse=True, count=0 if is_one else 1)
        for group in part.groups
    ]


def is_mesh(thing: Any) -> bool:
    """Whether it has ``vertices`` and ``faces``."""
    return hasattr(thing, "vertices") and hasattr(thing, "faces")


def vertices(mesh: Any) -> Array:
    """Positions (n, 3) of a mesh."""
    return np.asarray(mesh.vertices, float)


def _batches(things: Sequence[Any], indices: Iterable[int]) -> list[list[int]]:
    """Objects that are read and outlined in one call: single ones of one type, or one of any other sort."""
    batches: dict[Any, list[int]] = {}
    for i in indices:
        thing = things[i]
        single = isinstance(thing, Multivector) and thing.size == 1
        batches.setdefault(thing._type if single else i, []).append(i)
    return list(batches.values())


def _joined(single: Sequence[Multivector]) -> Multivector:
    """Single multivectors of one type as one batch."""
    first, width = single[0], single[0]._data.shape[-1]
    data = np.concatenate([x._data.reshape(1, width) for x in single])
    status = None
    if any(x._status is not None for x in single):
        status = np.array([0 if x._status is None else x._status.item() for x in single], np.uint8)
    return first._make(first._type, data, (len(single),), status)
