"""Sharing a range over threads."""

from __future__ import annotations

import os
import signal
import threading
import time

import numpy as np
import pytest

import bladesmith
from bladesmith import cga3d
from bladesmith.codegen.execute import ranges
from bladesmith.codegen.execute.ranges import TimedRanges
from bladesmith.common import parallel
from bladesmith.errors import InputError

N = 2 * parallel.GRAIN + 7  # items enough to be shared


@pytest.mark.parametrize(("n", "threads", "chunk"), [(0, 2, 3), (1, 2, 3), (10, 1, 3), (100, 3, 7), (100, 3, None)])
def test_every_item_is_done_once(n, threads, chunk):
    done = []
    parallel.run(lambda begin, end: done.extend(range(begin, end)), n, threads, chunk)
    assert sorted(done) == list(range(n))


@pytest.mark.parametrize("threads", [1, 3])
@pytest.mark.parametrize("n", [1, 7, 8, 1001])
def test_ranges_begin_at_multiples_of_a_unit(n, threads, monkeypatch):
    monkeypatch.setattr(ranges, "LONGEST", 1e-9)
    for chunk in (None, 24):
        found = []
        parallel.run(lambda begin, end, to=found: to.append((begin, end)), n, threads, chunk, unit=8)
        assert all(begin % 8 == 0 and (end % 8 == 0 or end == n) for begin, end in found)
        assert sorted(i for pair in found for i in range(*pair)) == list(range(n))


def test_progress_adds_up_in_the_calling_thread():
    told, names = [], set()

    def progress(count):
        told.append(count)
        names.add(threading.current_thread())

    parallel.run(lambda begin, end: None, 1000, 2, 10, progress)
    assert told[-1] == 1000 and told == sorted(told) and names == {threading.current_thread()}


def test_several_threads_work_at_once():
    meeting = threading.Barrier(2, timeout=20)
    parallel.run(lambda begin, end: meeting.wait() and None, 2, threads=2, chunk=1)


def test_nested_calls_run_serially():
    threads = []

    def inner(begin, end):
        threads.append(threading.current_thread())

    def outer(begin, end):
        before = len(threads)
        parallel.run(inner, 8, threads=4, chunk=1)
        assert set(threads[before:]) >= {threading.current_thread()}

    parallel.run(outer, 1, threads=1)
    assert set(threads) == {threading.current_thread()}


def test_the_first_error_stops_the_rest():
    started = []

    def part(begin, end):
        started.append(begin)
        if begin == 3:
            raise ValueError("item 3")

    with pytest.raises(ValueError, match="item 3"):
        parallel.run(part, 10_000, threads=2, chunk=1)
    assert len(started) < 100


def test_an_interrupt_waits_for_running_chunks_and_drops_the_others():
    started, ended = [], []

    def part(begin, end):
        started.append(begin)
        time.sleep(0.01)
        ended.append(begin)

    def progress(count):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        parallel.run(part, 10_000, threads=2, chunk=1, progress=progress)
    assert sorted(started) == sorted(ended) and len(started) < 100


@pytest.mark.parametrize(("cost", "n"), [(0.0, 3000), (1e-4, 3000), (0.03, 4)])
def test_ranges_take_as_long_as_is_said_however_long_an_item_takes(cost, n):
    sizes = []

    def part(begin, end):
        sizes.append(end - begin)
        time.sleep(cost * (end - begin))

    parallel.run(part, n, 1)
    assert sum(sizes) == n and max(sizes) * cost <= 3 * ranges.LONGEST
    assert len(sizes) < 6 + n * cost / ranges.LONGEST * 4


@pytest.mark.parametrize("threads", [1, 2])
def test_what_runs_is_told_to_stop_at_an_interrupt(threads):
    stopped = threading.Event()

    def part(begin, end):
        assert stopped.wait(20)

    start = time.monotonic()
    threading.Timer(0.1, signal.raise_signal, (signal.SIGINT,)).start()
    with pytest.raises(KeyboardInterrupt):
        parallel.run(part, 4, threads, stop=stopped.set)
    assert time.monotonic() - start < 5


@pytest.mark.parametrize("n", [0, 10, parallel.GRAIN, 5 * parallel.GRAIN + 3])
def test_cheap_items_come_in_large_chunks(n, monkeypatch):
    monkeypatch.setattr(parallel, "thread_count", lambda threads=None: threads or 2)
    found = []
    parallel.split(lambda begin, end: found.append((begin, end)), n)
    assert sum(end - begin for begin, end in found) == n and len(found) <= 3


def test_threads_end_together():
    ranges, left = TimedRanges(100, first=40, most=100, unit=10, shares=2, least=20), []
    for begin, end in ranges:
        assert begin % 10 == 0
        left.append(end - begin)
    assert left == [40, 30, 20, 10]


def threads_of(count):
    found = set()
    meeting = threading.Barrier(count, timeout=20)

    def part(begin, end):
        found.add(threading.get_ident())
        meeting.wait()

    parallel.run(part, count, count, chunk=1)
    return found


def test_threads_stay_for_the_next_call_unless_one_fails():
    assert threads_of(3) == threads_of(3)

    def fail(begin, end):
        raise RuntimeError

    before = threads_of(3)
    with pytest.raises(RuntimeError):
        parallel.run(fail, 3, 3, chunk=1)
    assert not {t.ident for t in threading.enumerate()} & before


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system does not fork")
@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_a_forked_process_starts_threads_of_its_own():
    threads_of(2)
    child = os.fork()
    if not child:
        signal.alarm(20)
        os._exit(0 if len(threads_of(2)) == 2 else 1)
    assert os.waitpid(child, 0)[1] == 0


@pytest.fixture
def one_thread_again():
    yield
    parallel.set_threads(1)


def test_batches_on_several_threads_are_the_same_bits(one_thread_again, monkeypatch):
    rng = np.random.default_rng(5)
    motors = cga3d.rotor(rng.normal(size=(N, 3)), rng.normal(size=N))
    points = cga3d.point(rng.normal(size=(N, 3)))
    alone = (motors * motors).values, (motors >> points).values
    bladesmith.set_threads(3)
    shared = []
    ran = parallel._run_threaded
    monkeypatch.setattr(
        parallel, "_run_threaded", lambda part, ranges, *a: shared.append((ranges.n, *a)) or ran(part, ranges, *a)
    )
    together = (motors * motors).values, (motors >> points).values
    assert shared and set(shared) == {(N, 3)}
    assert all(np.array_equal(a.view(np.uint64), b.view(np.uint64)) for a, b in zip(alone, together, strict=True))
    bladesmith.set_threads(1)
    assert ranges.splitter is None
    bladesmith.set_threads(None)
    assert (ranges.splitter is None) == (parallel.thread_count() == 1)


WRONG_COUNTS = [
    (0, "threads is 0; a whole number from 1 to 4096 is needed"),
    (-1, "threads is -1; a whole number from 1 to 4096 is needed"),
    (np.int64(-2), "threads is -2; a whole number from 1 to 4096 is needed"),
    (2.5, "threads is 2.5; a whole number from 1 to 4096"),
    (float("nan"), "threads is nan; a whole number from 1 to 4096"),
    ("two", "threads is 'two'; a whole number from 1 to 4096"),
    (True, "threads is True; a whole number from 1 to 4096"),
    (np.True_, "threads is .*True_?; a whole number from 1 to 4096"),
    (np.arange(10_000).reshape(100, 100), r"threads is array.{,40}; a whole number from 1 to 4096"),
    (10**9, "threads is 1000000000; a whole number from 1 to 4096 is needed"),
    (10**4000, r"threads is 10+\.\.\.0+; a whole number from 1 to 4096"),
]


@pytest.mark.parametrize(("count", "message"), WRONG_COUNTS)
def test_a_count_of_threads_is_a_whole_number_of_at_least_one(count, message):
    def part(begin, end):
        pytest.fail("worked")

    with pytest.raises(InputError, match=f"^{message}"):
        bladesmith.set_threads(count)
    for n in (0, 1, 100):  # also where there is nothing to share
        with pytest.raises(InputError, match=f"^{message}"):
            parallel.run(part, n, threads=count)
    with pytest.raises(InputError, match=f"^{message}"):
        parallel.split(part, N, threads=count)


def test_counts_of_threads_of_any_integer_type_are_taken():
    assert [parallel.thread_count(count) for count in (3, np.int32(3), np.uint8(3), parallel.MOST_THREADS)] == [
        3,
        3,
        3,
        parallel.MOST_THREADS,
    ]


def test_an_interrupt_lets_progress_be_told_and_a_second_does_not():
    """A bar takes locks, which an exception between two lines would leave locked for ever."""

    def progress(count):
        signal.raise_signal(signal.SIGINT)
        told.append(count)

    for threads in (1, 2):
        told = []
        with pytest.raises(KeyboardInterrupt):
            parallel.run(lambda begin, end: None, 100, threads, 10, progress)
        assert told and len(told) <= 2 * threads
    told = []

    def insists(count):
        signal.raise_signal(signal.SIGINT)
        signal.raise_signal(signal.SIGINT)
        told.append(count)

    with pytest.raises(KeyboardInterrupt):
        parallel.run(lambda begin, end: None, 100, 2, 10, insists)
    assert told == []


def test_the_default_of_all_functions_is_that_of_set_threads(one_thread_again):
    bladesmith.set_threads(3)
    assert parallel.thread_count() == 3 and parallel.thread_count(2) == 2
    seen = set()
    parallel.run(lambda begin, end: seen.add(threading.current_thread()), 2, chunk=1, grain=5)
    assert threading.current_thread() not in seen
    ranges = []
    parallel.run(lambda begin, end: ranges.append((begin, end)), 10, grain=10)
    assert ranges == [(0, 10)]


def test_a_number_of_threads_is_that_number_also_for_kernels_inside(one_thread_again):
    bladesmith.set_threads(3)
    seen = set()

    def part(begin, end):
        seen.add(threading.current_thread())

    parallel.split(lambda begin, end: parallel.split(part, N), N, threads=1)
    assert seen == {threading.current_thread()}


@pytest.mark.service
def test_compiled_code_of_others_is_left_when_an_interrupt_comes():
    ended = threading.Event()
    threading.Timer(0.2, signal.raise_signal, (signal.SIGINT,)).start()
    start = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        parallel.interruptible(lambda: time.sleep(2) or ended.set())
    assert time.monotonic() - start < 1 and ended.wait(10)
    assert parallel.interruptible(lambda: 3) == 3
    with pytest.raises(ZeroDivisionError):
        parallel.interruptible(lambda: 1 // 0)
