"""Rows of constants of many surfaces at once: gathered by kind, prepared by the compiled program, bounded."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ..codegen.programs.scene import TREE_PAYS_WIDE
from ..codegen.programs.surface_kinds import surface_kind
from ..errors import SceneError
from .bounds import bounded
from .engine import Engine
from .spans import checked
from .tree import Tree, tree_over

Array = NDArray[Any]
#: Rows of one scene: the driver numbers them, and one that stands for none, in 32 bits.
MOST_ROWS = 2**31 - 2


class HasRows(Protocol):
    """What a surface hands over."""

    @property
    def program_kind(self) -> str:
        """Name of its kind in programs."""

    @property
    def parameters(self) -> NDArray[np.float64]:
        """Rows of parameters (n, parameters)."""


@dataclass(frozen=True, eq=False)
class Rows:
    """Rows of constants of one kind of surface.

    Attributes
    ----------
    constants : (n, constants) array
    ids : (n,) array of int32
        The surface of each, by its place in the scene's list; ascending.
    boxes : (n, 6) array
        Low and high corner of each, in the world; infinite where it is unbounded.
    """

    constants: Array
    ids: Array
    boxes: Array


class SceneRows(dict[str, Rows]):
    """Rows by kind, and the tree over their boxes, which is built once."""

    _tree: Tree | None = None

    @property
    def reach(self) -> float:
        """Largest absolute coordinate of a box; 1 where there is none, never 0."""
        sides = [np.abs(rows.boxes) for rows in self.values()]
        return max((float(np.max(x, initial=0.0, where=np.isfinite(x))) for x in sides), default=0.0) or 1.0

    def tree(self, engine: Engine) -> Tree:
        """The tree; its items number the kinds in the order of the rows."""
        if self._tree is None:
            self._tree = tree_over(engine, [rows.boxes for rows in self.values()])
        return self._tree


def gathered(engine: Engine, surfaces: Sequence[HasRows]) -> SceneRows:
    """Rows of all surfaces by kind; they are the same from every program that has the kinds.

    Raises
    ------
    SceneError
        If they are more than the driver can count.
    """
    count = sum(len(surface.parameters) for surface in surfaces)
    if count > MOST_ROWS:
        raise SceneError(
            f"the surfaces have {count} facets and pieces of curves; a scene has {MOST_ROWS} at most.",
            remedy="Make several scenes",
        )
    members: dict[str, list[int]] = {}
    for place, surface in enumerate(surfaces):
        members.setdefault(surface.program_kind, []).append(place)
    found = SceneRows()
    for name, places in members.items():
        kind = surface_kind(name)
        parameters = [surfaces[place].parameters for place in places]
        ids = np.repeat(np.array(places, np.int32), [len(rows) for rows in parameters])
        given = _stacked(parameters)
        if any(part == "spans" for part, _ in kind.layout):
            given = checked(kind, given, ids, surfaces)
        constants, boxes = bounded(kind, engine.prepare(name, given))
        found[name] = Rows(constants, ids, boxes)
    return found


def row_count(surfaces: Sequence[HasRows]) -> int:
    """Rows of all surfaces, or of enough that they are many."""
    count = len(surfaces)
    for surface in surfaces:
        if count >= TREE_PAYS_WIDE:
            break
        count += len(surface.parameters) - 1
    return count


def _stacked(parts: Sequence[Array]) -> Array:
    return parts[0] if len(parts) == 1 else np.concatenate(parts)
