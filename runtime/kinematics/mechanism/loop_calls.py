"""Compiled algorithms of mechanisms, with the arrays that all calls share and those that each thread brings along."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any, NamedTuple

from numpy.typing import NDArray

from ...codegen.build.cpu_features import best_instances
from ...codegen.execute.items import STORED, CLoop, Loop
from ...codegen.ir.loops.types import ArrayType
from ...codegen.programs.mechanisms.program import mechanism_extension, mechanism_function
from ...codegen.targets.c.instances import ONE_BY_ONE, Instance
from ...dispatch.algorithm_loops import compiled_loop

Array = NDArray[Any]
#: Rows or columns beyond which mechanisms are computed one by one: their numbers would leave the near caches.
MOST_WIDE = 32
#: Bytes of work arrays that are kept for the next call.
MOST_KEPT = 1 << 20


class LoopParameter(NamedTuple):
    """A parameter of an algorithm: its name, the type of its numbers, and how many are a row."""

    name: str
    dtype: Any
    row: int


class ItemFrame(NamedTuple):
    """A compiled loop, and its arguments for a single item.

    Attributes
    ----------
    run : callable
    pointers, strides, counts
        For `run`; pointers at ``places`` are set before each call.
    places : dict of str to int
        By names of arrays.
    held : list
        What the other pointers know.
    """

    run: Any
    pointers: Any
    strides: Any
    counts: Any
    places: dict[str, int]
    held: list[Any]


def wide_instance(room: int, target: str) -> Instance | None:
    """What several items at once are compiled for; None where the processor, or large mechanisms, gain nothing."""
    (instance,) = best_instances("f64")
    return instance if target == "c" and room <= MOST_WIDE and instance.wide else None


@cache
def mechanism_loop(
    algebra: str, room: int, name: str, target: str, instance: Instance = ONE_BY_ONE[0]
) -> tuple[Loop, tuple[LoopParameter, ...]]:
    """One of the algorithms, compiled: one for all mechanisms of a class."""
    function = mechanism_function(algebra, room, name)
    loop = compiled_loop(
        f"mechanism_{algebra}_{room}_{name}", f"{name} of mechanisms",
        "poses of mechanisms are compiled at their first use", target,
        lambda: mechanism_extension(algebra, room, name, instance), lambda: function,
    )  # fmt: skip
    parameters = []
    for p in function.parameters:
        storage, row = (p.type.storage, p.type.size) if isinstance(p.type, ArrayType) else (str(p.type), 1)
        parameters.append(LoopParameter(p.name, STORED[storage], row))
    return loop, tuple(parameters)


class LoopCall:
    """An algorithm, with the tables of a mechanism and the arrays that each thread brings along.

    Parameters
    ----------
    loop : Loop
    parameters : sequence of LoopParameter
    tables : dict of str to array
    work : dict of str to tuple of int
        Shapes of work arrays.
    lanes : int
        How many items are computed at once.
    """

    def __init__(
        self, loop: Loop, parameters: Sequence[LoopParameter], tables: dict[str, Array],
        work: dict[str, tuple[int, ...]], lanes: int = 1,
    ) -> None:  # fmt: skip
        self._loop, self.lanes = loop, lanes
        self._held: list[Any] = []
        self._counts: list[int] = []
        self._varying: list[tuple[int, str, int]] = []
        self._work: list[tuple[int, int, Any]] = []
        self._free: list[list[Any]] = []  # sets of work arrays that no thread uses
        for k, (name, dtype, row) in enumerate(parameters):
            if name in work:
                size = math.prod(work[name])
                self._work.append((k, size if lanes == 1 else lanes * (size + 1), dtype))
            elif name not in tables:
                self._varying.append((k, name, row))
            self._held.append(loop.hold(tables[name]) if name in tables else None)
            self._counts.append(len(tables.get(name, ())))
        self.size = 8 * sum(size for _, size, _ in self._work)
        self.is_on_gpu = loop.runs_whole

    def frame(self, sizes: Mapping[str, int], same: Mapping[str, Array]) -> ItemFrame | None:
        """What one call after the other of single items takes; None where there is no such call.

        Parameters
        ----------
        sizes : mapping of str to int
            Numbers of the arrays that are an item's own.
        same : mapping of str to array
            What all items share.
        """
        loop = self._loop
        if not isinstance(loop, CLoop) or self.size > MOST_KEPT:
            return None
        held, counts, places = list(self._held), list(self._counts), {}
        for k, size, dtype in self._work:
            held[k] = loop.work(size, dtype)
        for k, name, row in self._varying:
            if name in same:
                held[k], counts[k] = loop.hold(same[name]), same[name].size // row
            else:
                counts[k], places[name] = sizes[name] // row, k
        integers = loop.integers([0] * len(held)), loop.integers(counts)
        return ItemFrame(loop.run, loop.pointers(held), *integers, places, held)

    def __call__(self, each: dict[str, Array], same: dict[str, Array]) -> None:
        """Run on items of a part: arrays without gaps, whose first axis is that of items, and what items share."""
        loop, held, counts = self._loop, list(self._held), list(self._counts)
        strides = [0] * len(held)
        n = len(next(iter(each.values())))
        for k, name, row in self._varying:
            if name in each:
                array = each[name]
                held[k], strides[k] = loop.hold(array), array.size // n
                counts[k] = strides[k] // row
            else:
                held[k], counts[k] = loop.hold(same[name]), same[name].size // row
        if self.is_on_gpu:  # each item has work arrays of its own
            for k, size, dtype in self._work:
                held[k], strides[k] = loop.work(n * size, dtype), size
            loop.bind(held, loop.integers(strides), loop.integers(counts))(0, n)
            return
        try:
            work = self._free.pop()
        except IndexError:
            work = [loop.work(size, dtype) for _, size, dtype in self._work]
        for (k, _, _), own in zip(self._work, work, strict=True):
            held[k] = own
        loop.bind(held, loop.integers(strides), loop.integers(counts))(0, n)
        if self.size <= MOST_KEPT:
            self._free.append(work)
