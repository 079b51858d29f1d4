"""The one place that shares work over threads: a range [0, n) in chunks over a pool.

Compiled loops take a range [begin, end) and release the GIL; nothing here knows what they do. A call from
inside a chunk runs serially, so that nothing is ever shared twice.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from contextlib import contextmanager
from functools import partial
from time import perf_counter
from typing import TypeVar

from ..codegen.execute.ranges import FIRST, FIRST_CHEAP, TimedRanges, install_splitter, run_serially
from ..codegen.interrupts import deferred_interrupts
from .validation import as_int

T = TypeVar("T")
Part = Callable[[int, int], None]
#: Chunks per thread where the caller names no size: enough for progress, few enough to cost nothing.
CHUNKS_PER_THREAD = 16
#: Cheap items that are worth a chunk: some 100 microseconds of work.
GRAIN = 16384
#: Cheap items that are one call, whatever.
FEW = 1024
#: More threads than any machine runs at once: a count beyond is a mistake, and their stacks would not fit.
MOST_THREADS = 4096
#: How often a waiting main thread looks up, in seconds, so that an interrupt is seen at once everywhere.
POLL = 0.1
_inside = threading.local()
#: A pool that no call uses now, by number of threads: to start threads takes longer than many a batch does. A process
#: that was forked has none.
_idle: dict[int, ThreadPoolExecutor] = {}
#: Pools of more threads are not kept.
MOST_KEPT = 256
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_idle.clear)
#: Number of threads that `set_threads` was given; None: all processors.
_default: int | None = None


def thread_count(threads: int | None = None) -> int:
    """Number of threads: as requested, else the package's default: see `set_threads`.

    Raises
    ------
    InputError
        If the count is no whole number from 1 to `MOST_THREADS`.
    """
    if threads is not None:
        return as_int(threads, "threads", 1, MOST_THREADS)
    if _default is not None:
        return _default
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:  # macOS, Windows
        return os.cpu_count() or 1


def run(
    part: Part,
    n: int,
    threads: int | None = None,
    chunk: int | None = None,
    progress: Callable[[int], None] | None = None,
    grain: int = 1,
    stop: Callable[[], None] | None = None,
    unit: int = 1,
) -> None:
    """Call ``part(begin, end)`` until [0, n) is covered.

    Ranges have as many items as take some 0.1 s, by the time that those before them took: an interrupt is seen between
    them.

    Parameters
    ----------
    part : callable
        Works on items begin to end - 1. Chunks must not depend on each other.
    n : int
    threads : int, optional
        Default: that of `set_threads`. Inside another `run`: one.
    chunk : int, optional
        Items of the first call, and of any at most.
    progress : callable, optional
        Called in the calling thread with the number of items that are done.
    grain : int, optional
        Items that are worth another thread.
    stop : callable, optional
        Called at an interrupt, or when a range has failed, before those that run are waited for: it may end them. With
        it the calling thread does no work of its own, so that an interrupt is seen while a range runs.
    unit : int
        Ranges begin at multiples of it, whatever they take: where items in between share a result.

    Raises
    ------
    InputError
        If ``threads`` is no whole number from 1 to `MOST_THREADS`.
    KeyboardInterrupt
        Between chunks; those that run are waited for, the others are dropped.
    Exception
        The first that a chunk raised.
    """
    count = thread_count(threads)  # checked also where nothing is to be done
    if n <= 0:
        return
    if n <= grain and chunk is None and progress is None and stop is None:  # the short way
        _call(part, 0, n)
        return
    if getattr(_inside, "running", False):
        count = 1
    most = chunk or max(grain, -(-n // (count * CHUNKS_PER_THREAD)))
    if count == 1 and chunk is None:
        most = n
    ranges = TimedRanges(n, chunk or max(grain, FIRST), most, unit)
    if stop is None and (count == 1 or n <= most):
        _run_serial(part, ranges, progress)
    else:
        _run_threaded(part, ranges, count, progress, stop)


def set_threads(count: int | None) -> None:
    """Set the package's default number of threads: of all functions whose ``threads`` is None, products and kernels.

    Before the first call these are all processors of this process, but batches of products and of kernels stay in the
    calling thread. Results are the same bits for any number. Batches of fewer than 32768 products are not shared.

    Parameters
    ----------
    count : int or None
        None: all processors of this process.

    Raises
    ------
    InputError
        If the count is not a positive whole number.
    """
    global _default
    _default = None if count is None else thread_count(count)
    threads = thread_count()
    install_splitter(partial(split, threads=threads) if threads > 1 else None)


def interruptible(function: Callable[[], T]) -> T:
    """Result of a function that runs for seconds in compiled code of others, such as LAPACK's.

    It runs in another thread, so that an interrupt is seen at once; what was begun then ends by itself.
    """
    if threading.current_thread() is not threading.main_thread():
        return function()
    future: Future[T] = Future()

    def work() -> None:
        try:
            future.set_result(function())
        except BaseException as error:
            future.set_exception(error)

    threading.Thread(target=work, name="bladesmith", daemon=True).start()
    while not wait((future,), timeout=POLL).done:
        pass
    return future.result()


def serially(function: Callable[[], T]) -> T:
    """Result of a function, all of whose work is done in this thread: for workers, of which there are several."""
    found: list[T] = []
    _call(lambda begin, end: found.append(function()), 0, 1)
    return found[0]


def split(
    part: Part,
    n: int,
    first: int | None = None,
    unit: int = 1,
    threads: int | None = None,
    is_whole: bool = False,
) -> None:
    """`run` for loops over cheap items, such as batches of products: few chunks, each worth a thread.

    Parameters
    ----------
    part, n, threads : see `run`
    first : int, optional
        Items of the first range of each thread, where they take long.
    unit : int
        Ranges begin at multiples of it.
    is_whole : bool
        Whether all items are one call, as on a GPU.
    """
    count = thread_count(threads) if threads is not None or n >= 2 * GRAIN else 1
    if is_whole or n <= FEW:
        part(0, n)
    elif n < 2 * GRAIN or count == 1 or getattr(_inside, "running", False):

        def timed(begin: int, end: int) -> None:
            _call(part, begin, end)

        run_serially(timed, n, first, unit)
    else:
        least = min(first or 2 * GRAIN, 2 * GRAIN)
        _run_threaded(part, TimedRanges(n, first or FIRST_CHEAP, n, unit, count, least), count)


def _run_serial(part: Part, ranges: TimedRanges, progress: Callable[[int], None] | None) -> None:
    for begin, end in ranges:
        ranges.timed(end - begin, _call(part, begin, end))
        if progress:
            with deferred_interrupts():
                progress(end)


def _run_threaded(
    part: Part,
    ranges: TimedRanges,
    threads: int,
    progress: Callable[[int], None] | None = None,
    stop: Callable[[], None] | None = None,
) -> None:
    """Two chunks for each thread, one running and one waiting; the rest stays here and can be dropped."""
    pending: dict[Future[float], int] = {}
    finished = 0
    with deferred_interrupts() as tell, _pool(threads, stop) as pool:
        while True:
            tell()
            while len(pending) < 2 * threads and (piece := next(ranges, None)) is not None:
                pending[pool.submit(_call, part, *piece)] = piece[1] - piece[0]
            if not pending:
                return
            done, _ = wait(pending, timeout=POLL, return_when=FIRST_COMPLETED)
            for future in done:
                size = pending.pop(future)
                ranges.timed(size, future.result())
                finished += size
                if progress:
                    progress(finished)


@contextmanager
def _pool(threads: int, stop: Callable[[], None] | None = None) -> Iterator[ThreadPoolExecutor]:
    """A pool of threads, an idle one where there is; what fails waits for what runs in it, and drops the rest."""
    pool = _idle.pop(threads, None) or ThreadPoolExecutor(threads, thread_name_prefix="bladesmith")
    try:
        yield pool
    except BaseException:
        if stop is not None:
            stop()
        pool.shutdown(wait=True, cancel_futures=True)
        raise
    if threads > MOST_KEPT or _idle.setdefault(threads, pool) is not pool:
        pool.shutdown()


def _call(part: Part, begin: int, end: int) -> float:
    """Run a range; seconds that it took."""
    outer, start = getattr(_inside, "running", False), perf_counter()
    _inside.running = True
    try:
        part(begin, end)
    finally:
        _inside.running = outer
    return perf_counter() - start
