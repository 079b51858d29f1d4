"""A scene as the two flat arrays that its program reads; codegen/programs/tracer/records.py says what stands where."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.programs.tracer.records import BOUNDS, SCENE, TABLE
from ..acceleration.bvh import CACHE_LINE, Tree, round_outward
from .surface_tables import SurfaceTables

Array = NDArray[Any]
#: Integers of 64 bits in a line of the processor's cache.
_LINE = CACHE_LINE // 8


class _Chunks:
    """Arrays that are put one behind the other."""

    def __init__(self, dtype: Any, used: int) -> None:
        self.dtype, self.used, self._parts = np.dtype(dtype), used, [(0, np.zeros(used, dtype))]

    def add(self, array: Array) -> int:
        """Where an array begins."""
        at = self.used
        self._parts.append((at, array))
        self.used += array.size
        return at

    def align(self) -> None:
        """Begin the next array on a line of the processor's cache."""
        self.used += -self.used % _LINE

    def whole(self) -> Array:
        """All of them; the first begins on a line of the cache."""
        memory = np.zeros(self.used * self.dtype.itemsize + CACHE_LINE, np.uint8)
        whole: Array = memory[-memory.ctypes.data % CACHE_LINE :][: self.used * self.dtype.itemsize].view(self.dtype)
        with np.errstate(over="ignore"):
            for at, array in self._parts:
                whole[at : at + array.size] = array.reshape(-1)
        return whole


def scene_arrays(
    kinds: Sequence[str],
    tables: SurfaceTables,
    tree: Tree | None,
    dtype: Any,
    pictures: Mapping[str, Array | None],
    settings: Mapping[str, int],
    is_c: bool,
) -> tuple[Array, Array]:
    """Integers and real numbers of a scene.

    Parameters
    ----------
    kinds : sequence of str
        Of the program.
    tables : SurfaceTables
    tree : Tree, optional
        For programs with one.
    dtype : dtype
        Of the real numbers.
    pictures : mapping of str to array, optional
        Rows of materials, lights, the camera and the sky, as far as the program reads them.
    settings : mapping of str to int
        Fields of `SCENE`.
    is_c : bool
        C has a tree of its own.
    """
    integers, reals = _Chunks(np.int64, SCENE.size + TABLE.size * len(kinds)), _Chunks(dtype, BOUNDS.size)
    layout = dict(settings)
    for name, values in pictures.items():
        layout[f"{name}_at"] = reals.add(np.empty(0) if values is None else values)
    own = TABLE.zeros(len(kinds))
    for kind, rows in tables.items():
        table = own[kinds.index(kind)]
        table.rows = len(rows.constants)
        table.constants_at, table.ids_at = reals.add(rows.constants), integers.add(rows.ids)
        table.boxes_at = reals.add(round_outward(rows.boxes[..., None], np.dtype(dtype).type))
    if tree is not None:
        items = tree.items.copy()
        items[:, 0] = np.array([kinds.index(kind) for kind in tables], np.int32)[tree.items[:, 0]]
        layout |= {"items": len(items), "unbounded": tree.unbounded, "nodes": len(tree.parts)}
        layout["items_at"] = integers.add(items)
        if is_c:
            integers.align()
            layout["tree_at"] = integers.add(tree.packed)
        else:
            layout["boxes_at"], layout["parts_at"] = reals.add(tree.boxes), integers.add(tree.parts)
    numbers, places = reals.whole(), integers.whole()
    bounds = BOUNDS.view(numbers[: BOUNDS.size])
    bounds.reach = tables.largest_coordinate
    bounds.whole = np.zeros(6) if tree is None else tree.whole
    scene = SCENE.view(places[: SCENE.size])
    for name, value in layout.items():
        setattr(scene, name, value)
    places[SCENE.size : SCENE.size + own.size] = np.asarray(own).reshape(-1)
    return places, numbers
