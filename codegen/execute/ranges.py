"""Ranges of a batch, one compiled call each: short enough for interrupts to be seen between them, however long an
item takes."""

from __future__ import annotations

from collections.abc import Callable
from time import perf_counter
from typing import Protocol

#: Seconds that a call of compiled code takes at most, as far as those before it tell.
LONGEST = 0.1
#: A range has at most so many times as many items as the one that was timed.
GROWTH = 8
#: Items of a first range, of which nothing is known.
FIRST = 16
#: The same for cheap items, such as products: less than a call of Python costs beside them.
FIRST_CHEAP = 1 << 16


class TimedRanges:
    """Ranges that cover [0, n).

    Parameters
    ----------
    n : int
    first, most : int
        Items of the first range, and of the longest.
    unit : int
        Ranges begin at multiples of it.
    shares, least : int
        A range is such a part of what is left at most, so that threads end together, but it may have ``least`` items.
    """

    def __init__(self, n: int, first: int, most: int, unit: int = 1, shares: int = 1, least: int = 1) -> None:
        self.n, self.most, self.unit, self.shares, self.least = n, most, unit, shares, least
        self.size, self.begin = self._whole(first), 0

    def __iter__(self) -> TimedRanges:
        return self

    def __next__(self) -> tuple[int, int]:
        begin = self.begin
        if begin >= self.n:
            raise StopIteration
        share = self._whole(max(self.least, -(-(self.n - begin) // self.shares)))
        self.begin = min(begin + min(self.size, share), self.n)
        return begin, self.begin

    def timed(self, items: int, seconds: float) -> None:
        """Say how long a range took."""
        times = min(GROWTH, LONGEST / max(seconds, 1e-9))
        self.size = self._whole(int(items * times))

    def _whole(self, items: int) -> int:
        return max(1, min(items, self.most) // self.unit) * self.unit


def run_serially(run: Callable[[int, int], None], n: int, first: int | None = None, unit: int = 1) -> None:
    """Run items 0 .. n - 1 in this thread, in calls of some 0.1 s, of ``first`` items at first."""
    first = first or FIRST_CHEAP
    if n <= first:
        run(0, n)
        return
    ranges = TimedRanges(n, first, n, unit)
    for begin, end in ranges:
        start = perf_counter()
        run(begin, end)
        ranges.timed(end - begin, perf_counter() - start)


class Splitter(Protocol):
    """Splits ``run(begin, end)`` over threads; the runtime installs its own."""

    def __call__(self, run: Callable[[int, int], None], n: int, first: int | None = None, unit: int = 1, /) -> None:
        """Run items 0 .. n - 1, ``first`` of them in a thread's first call; calls begin at multiples of ``unit``."""


#: None: this thread.
splitter: Splitter | None = None


def install_splitter(new: Splitter | None) -> None:
    """Let ``new`` share large batches over threads."""
    global splitter
    splitter = new


def parallel_for(run: Callable[[int, int], None], n: int, first: int | None = None, unit: int = 1) -> None:
    """Run items 0 .. n - 1: over threads where a splitter is installed, else in this one.

    A call runs as many items as take some 0.1 s, as far as is known, and ``first`` of them before anything is. It
    begins at a multiple of ``unit``.
    """
    if splitter is None:
        run_serially(run, n, first, unit)
    else:
        splitter(run, n, first, unit)
