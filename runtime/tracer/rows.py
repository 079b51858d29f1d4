"""Rows of constants of many surfaces at once: gathered by kind, prepared by the compiled program, bounded."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ..codegen.programs.surface_kinds import surface_kind
from .bounds import completed
from .driver import Rows
from .engine import Engine


class HasRows(Protocol):
    """What a surface hands over."""

    @property
    def program_kind(self) -> str:
        """Name of its kind in programs."""

    @property
    def parameters(self) -> NDArray[np.float64]:
        """Rows of parameters (n, parameters)."""


def gathered(engine: Engine, surfaces: Sequence[HasRows]) -> dict[str, Rows]:
    """Rows of all surfaces by kind; they are the same from every program that has the kinds."""
    members: dict[str, list[int]] = {}
    for place, surface in enumerate(surfaces):
        members.setdefault(surface.program_kind, []).append(place)
    found = {}
    for kind, places in members.items():
        parameters = [surfaces[place].parameters for place in places]
        constants = engine.prepare(kind, np.concatenate(parameters))
        ids = np.repeat(np.array(places, np.int32), [len(rows) for rows in parameters])
        found[kind] = Rows(completed(surface_kind(kind), constants), ids)
    return found
