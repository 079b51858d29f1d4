"""Algorithms of generated programs on arrays that their caller owns: changed where they lie, and not checked."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from ..ir.loops.nodes import Function
from ..ir.loops.types import ArrayType
from .arrays import Array
from .items import STORED, Loop, Run, numba_signature

#: Strides and counts that an algorithm keeps.
_LAYOUTS = 64


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


def entry_of(function: Function, part: str = "") -> Entry:
    """The entry of an algorithm."""
    parameters = []
    for p in function.parameters:
        is_array = isinstance(p.type, ArrayType)
        parameters.append((p.name, p.type.storage if isinstance(p.type, ArrayType) else str(p.type), is_array))
    return Entry(function.name, part, tuple(parameters), tuple(str(t) for t in function.results))


def read_entries(text: str) -> dict[str, Entry]:
    """Entries by name, from the JSON text of a program."""
    found = {}
    for name, entry in json.loads(text).items():
        parameters = tuple((own, type, is_array) for own, type, is_array in entry["parameters"])
        found[name] = Entry(name, entry["part"], parameters, tuple(entry["results"]))
    return found


#: Place of a parameter, its name, type of numbers, and whether it is an array.
Place = tuple[int, str, str, bool]


class Kept(NamedTuple):
    """An array that stays, as a loop holds it: an argument of many calls.

    Attributes
    ----------
    held : object
    rows : int
        Of each item.
    stride : int
        Numbers from item to item; 0: all items share it.
    """

    held: Any
    rows: int
    stride: int = 0


class Bound(NamedTuple):
    """A loop over items, and arrays for what it returns."""

    run: Run
    returned: list[Array]


class InPlace:
    """An algorithm of a compiled program.

    Parameters
    ----------
    entry : Entry
    loop : Loop
    kept : mapping of str to Kept, optional
        Arguments of all calls.
    """

    def __init__(self, entry: Entry, loop: Loop, kept: Mapping[str, Kept] | None = None) -> None:
        self.entry, self.loop = entry, loop
        self._integers = lru_cache(_LAYOUTS)(loop.integers)
        found = [(kept or {}).get(name) for name, _, _ in entry.parameters]
        self._open = [(k, *entry.parameters[k]) for k, each in enumerate(found) if each is None]
        filled = [each or Kept(None, 0) for each in found]
        self._held, self._counts, self._strides = ([each[i] for each in filled] for i in range(3))

    def holding(self, kept: Mapping[str, Kept]) -> InPlace:
        """The same with some arguments of all calls."""
        return InPlace(self.entry, self.loop, kept)

    def __call__(self, arguments: Mapping[str, Any]) -> Any:
        """Run on arguments by name, arrays in double precision or 64-bit integers, contiguous; what it returns."""
        bound = self.over(1, {}, arguments)
        bound.run(0, 1)
        results = tuple(r[0].item() for r in bound.returned)
        return results[0] if len(results) == 1 else results

    def over(self, n: int, each: Mapping[str, Any], shared: Mapping[str, Any]) -> Bound:
        """The loop over n items of some arguments.

        Parameters
        ----------
        n : int
            At least 1.
        each, shared : mapping of str to array or number
            Arguments as in a call: those that items have of their own, along a first axis, and those that all share.
        """
        loop, hold = self.loop, self.loop.hold
        held, strides, counts = self._held.copy(), self._strides.copy(), self._counts.copy()
        arrange(self._open, n, each, shared, hold, loop.number, held, strides, counts)
        returned = [np.empty(n, STORED[type]) for type in self.entry.results]
        for array in returned:
            held.append(hold(array))
            strides.append(1)
            counts.append(0)
        run = loop.bind(held, self._integers(tuple(strides)), self._integers(tuple(counts)))
        return Bound(run, returned)


def arrange(
    parameters: Iterable[Place],
    n: int,
    each: Mapping[str, Any],
    shared: Mapping[str, Any],
    hold: Callable[[Array], Any],
    number: Callable[[Any, str], Any],
    held: list[Any],
    strides: list[int],
    counts: list[int],
) -> None:
    """Put arguments, as they are held, numbers from item to item, and rows of arrays where the parameters are; what
    stays are strides of 0, and rows of what is no array. See `InPlace.over`."""
    for k, name, type, is_array in parameters:
        own = each.get(name)
        if own is not None:
            held[k], strides[k] = hold(own), own.size // n
            if is_array:
                counts[k] = own.shape[1]
            continue
        given = shared[name]
        if isinstance(given, Kept):
            held[k], counts[k] = given.held, given.rows
        elif is_array:
            held[k], counts[k] = hold(given), len(given)
        else:
            held[k] = number(given, type)
