"""Compiled algorithms of mechanisms, with the arrays that all calls share and those that each thread brings along."""

from __future__ import annotations

import math
from functools import cache
from typing import Any

from numpy.typing import NDArray

from ...codegen.execute.in_place import Entry, entry_of
from ...codegen.execute.items import STORED, Loop
from ...codegen.programs.mechanisms.program import mechanism_extension, mechanism_function
from ...dispatch.algorithm_loops import compiled_loop

Array = NDArray[Any]
#: Bytes of work arrays that are kept for the next call.
MOST_KEPT = 1 << 20


@cache
def mechanism_loop(algebra: str, room: int, name: str, target: str) -> tuple[Loop, Entry]:
    """One of the algorithms, compiled: one for all mechanisms of a class."""
    function = mechanism_function(algebra, room, name)
    loop = compiled_loop(
        f"mechanism_{algebra}_{room}_{name}", f"{name} of mechanisms",
        "poses of mechanisms are compiled at their first use", target,
        lambda: mechanism_extension(algebra, room, name), lambda: function,
    )  # fmt: skip
    return loop, entry_of(function)


class LoopCall:
    """An algorithm, with the tables of a mechanism and the arrays that each thread brings along.

    Parameters
    ----------
    loop : Loop
    entry : Entry
    tables : dict of str to array
    work : dict of str to tuple of int
        Shapes of work arrays.
    """

    def __init__(self, loop: Loop, entry: Entry, tables: dict[str, Array], work: dict[str, tuple[int, ...]]) -> None:
        self._loop = loop
        self._held: list[Any] = []
        self._counts: list[int] = []
        self._varying: list[tuple[int, str]] = []
        self._work: list[tuple[int, int, Any]] = []
        self._free: list[list[Any]] = []  # sets of work arrays that no thread uses
        for k, (name, type, _) in enumerate(entry.parameters):
            if name in work:
                self._work.append((k, math.prod(work[name]), STORED[type]))
            elif name not in tables:
                self._varying.append((k, name))
            self._held.append(loop.hold(tables[name]) if name in tables else None)
            self._counts.append(len(tables.get(name, ())))
        self._strides = loop.integers([0] * len(self._held))
        self.size = 8 * sum(size for _, size, _ in self._work)
        self.is_on_gpu = loop.runs_whole

    def __call__(self, each: dict[str, Array], same: dict[str, Array]) -> None:
        """Run on items of a part: arrays without gaps, of rows where they have three axes, and what items share."""
        if self.is_on_gpu:
            self._run_apart(each, same)
            return
        loop, held, counts = self._loop, list(self._held), list(self._counts)
        try:
            work = self._free.pop()
        except IndexError:
            work = [loop.work(size, type) for _, size, type in self._work]
        for (k, _, _), own in zip(self._work, work, strict=True):
            held[k] = own
        for k, name in self._varying:
            array = each[name] if name in each else same[name]
            held[k], counts[k] = loop.hold(array), _rows(array)
        loop.bind(held, self._strides, loop.integers(counts))(0, 1)
        if self.size <= MOST_KEPT:
            self._free.append(work)

    def _run_apart(self, each: dict[str, Array], same: dict[str, Array]) -> None:
        """Run each item by itself, with work arrays of its own."""
        loop, held, counts = self._loop, list(self._held), list(self._counts)
        strides = [0] * len(held)
        n = len(next(iter(each.values())))
        for k, size, type in self._work:
            held[k], strides[k] = loop.work(n * size, type), size
        for k, name in self._varying:
            if name in each:
                array = each[name]
                held[k], counts[k], strides[k] = loop.hold(array), _rows(array) // n, array.size // n
            else:
                held[k] = loop.hold(same[name])
        loop.bind(held, loop.integers(strides), loop.integers(counts))(0, n)


def _rows(array: Array) -> int:
    """How many rows an argument has, or numbers."""
    return array.size // max(1, array.shape[-1]) if array.ndim == 3 else array.size
