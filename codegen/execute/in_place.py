"""Algorithms of generated programs on arrays that their caller owns: changed where they lie, and not checked."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from .items import Loop, numba_signature

_DTYPES = {"Real": np.float64, "Int": np.int64, "Bool": np.int64}


@dataclass(frozen=True)
class Entry:
    """What callers of an algorithm know.

    Parameters
    ----------
    name, part : str
        In generated code, and of which part of the program it is.
    parameters : tuple of (str, str, bool)
        Name, type of numbers, and whether it is an array.
    results : tuple of str
        Types of numbers.
    """

    name: str
    part: str
    parameters: tuple[tuple[str, str, bool], ...]
    results: tuple[str, ...]

    def signature(self) -> Any:
        """Types for numba."""
        return numba_signature([*(type for _, type, _ in self.parameters), *self.results])


def read_entries(text: str) -> dict[str, Entry]:
    """Entries by name, from the JSON text of a program."""
    found = {}
    for name, entry in json.loads(text).items():
        parameters = tuple((own, type, is_array) for own, type, is_array in entry["parameters"])
        found[name] = Entry(name, entry["part"], parameters, tuple(entry["results"]))
    return found


class InPlace:
    """An algorithm of a compiled program.

    Parameters
    ----------
    entry : Entry
    loop : Loop
    """

    def __init__(self, entry: Entry, loop: Loop) -> None:
        self.entry, self.loop = entry, loop

    def __call__(self, arguments: Mapping[str, Any]) -> Any:
        """Run on arguments by name, arrays in double precision or 64-bit integers, contiguous; what it returns."""
        taken, counts = [], []
        for name, type, is_array in self.entry.parameters:
            given = arguments[name]
            taken.append(given.reshape(-1) if is_array else np.array([given], _DTYPES[type]))
            counts.append(len(given) if is_array else 0)
        returned = [np.empty(1, _DTYPES[type]) for type in self.entry.results]
        taken += returned
        counts += [0] * len(returned)
        loop, held = self.loop, [self.loop.hold(a) for a in taken]
        loop.bind(held, loop.integers([0] * len(taken)), loop.integers(counts))(0, 1)
        results = tuple(r[0].item() for r in returned)
        return results[0] if len(results) == 1 else results
