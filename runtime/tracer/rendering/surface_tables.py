"""Tables of surface constants: rows of all surfaces by kind, prepared by the compiled program, with their bounds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ...codegen.programs.tracer.scene import TREE_PAYS_WIDE
from ...codegen.programs.tracer.surface_kinds import surface_kind
from ...errors import SceneError
from ..acceleration.bounds import compute_bounds
from ..acceleration.bvh import Tree, tree_over
from ..sweeps.real_intervals import with_real_intervals
from .engines import Engine

Array = NDArray[Any]
#: Largest number of rows of a scene: the driver numbers them, and the missing row, in 32 bits.
MOST_ROWS = 2**31 - 2


class HasRows(Protocol):
    """A surface, as far as tables need it."""

    @property
    def program_kind(self) -> str:
        """Name of the kind in programs."""

    @property
    def parameters(self) -> NDArray[np.float64]:
        """Rows of parameters (n, parameters)."""


@dataclass(frozen=True, eq=False)
class SurfaceTable:
    """Constants of all surfaces of one kind, a row for each facet or piece of a curve.

    Attributes
    ----------
    constants : (n, constants) array
    ids : (n,) array of int32
        Index of the surface of each row in the scene's list; ascending.
    boxes : (n, 6) array
        Low and high corner of each row, in the world; infinite where it is unbounded.
    """

    constants: Array
    ids: Array
    boxes: Array


class SurfaceTables(dict[str, SurfaceTable]):
    """Tables by kind, and the tree over their boxes, which is built once."""

    _tree: Tree | None = None

    @property
    def largest_coordinate(self) -> float:
        """Largest absolute coordinate of a finite box; 1 if there is none, never 0."""
        sides = [np.abs(rows.boxes) for rows in self.values()]
        return max((float(np.max(x, initial=0.0, where=np.isfinite(x))) for x in sides), default=0.0) or 1.0

    def tree(self, engine: Engine) -> Tree:
        """Tree over all boxes; its items number the kinds in the order of the tables."""
        if self._tree is None:
            self._tree = tree_over(engine, [rows.boxes for rows in self.values()])
        return self._tree


def build_surface_tables(engine: Engine, surfaces: Sequence[HasRows]) -> SurfaceTables:
    """Build the tables of all surfaces by kind; every program that has the kinds gives the same.

    Raises
    ------
    SceneError
        If there are more rows than the driver can count.
    """
    count = sum(len(surface.parameters) for surface in surfaces)
    if count > MOST_ROWS:
        raise SceneError(
            f"the surfaces have {count} facets and pieces of curves; a scene has {MOST_ROWS} at most.",
            remedy="Make several scenes",
        )
    members: dict[str, list[int]] = {}
    for index, surface in enumerate(surfaces):
        members.setdefault(surface.program_kind, []).append(index)
    tables = SurfaceTables()
    for name, indices in members.items():
        kind = surface_kind(name)
        parameters = [surfaces[index].parameters for index in indices]
        ids = np.repeat(np.array(indices, np.int32), [len(rows) for rows in parameters])
        stacked = _concatenate(parameters)
        if any(part == "spans" for part, _ in kind.layout):
            stacked = with_real_intervals(kind, stacked, ids, surfaces)
        constants, boxes = compute_bounds(kind, engine.prepare(name, stacked))
        tables[name] = SurfaceTable(constants, ids, boxes)
    return tables


def row_count(surfaces: Sequence[HasRows]) -> int:
    """Count the rows of all surfaces, but stop where a tree is certain to pay."""
    count = len(surfaces)
    for surface in surfaces:
        if count >= TREE_PAYS_WIDE:
            break
        count += len(surface.parameters) - 1
    return count


def _concatenate(parts: Sequence[Array]) -> Array:
    return parts[0] if len(parts) == 1 else np.concatenate(parts)
