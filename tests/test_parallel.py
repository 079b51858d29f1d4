"""Sharing a range over threads."""

from __future__ import annotations

import threading
import time

import numpy as np
import pytest

import bladesmith
from bladesmith import cga3d, parallel
from bladesmith.codegen import binding
from bladesmith.errors import InputError

N = 2 * parallel.GRAIN + 7  # items enough to be shared


@pytest.mark.parametrize(("n", "threads", "chunk"), [(0, 2, 3), (1, 2, 3), (10, 1, 3), (100, 3, 7), (100, 3, None)])
def test_every_item_is_done_once(n, threads, chunk):
    done = []
    parallel.run(lambda begin, end: done.extend(range(begin, end)), n, threads, chunk)
    assert sorted(done) == list(range(n))


def test_progress_adds_up_in_the_calling_thread():
    told, names = [], set()

    def progress(count):
        told.append(count)
        names.add(threading.current_thread())

    parallel.run(lambda begin, end: None, 1000, 2, 10, progress)
    assert sum(told) == 1000 and names == {threading.current_thread()}


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


@pytest.mark.parametrize("n", [0, 10, parallel.GRAIN, 5 * parallel.GRAIN + 3])
def test_cheap_items_come_in_large_chunks(n, monkeypatch):
    monkeypatch.setattr(parallel, "thread_count", lambda threads=None: threads or 2)
    ranges = []
    parallel.split(lambda begin, end: ranges.append((begin, end)), n)
    assert sum(end - begin for begin, end in ranges) == n and len(ranges) <= 2


def test_no_threads_is_an_error():
    with pytest.raises(ValueError, match="at least one"):
        parallel.run(lambda begin, end: None, 10, threads=0)


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
    ran = parallel.run
    monkeypatch.setattr(parallel, "run", lambda *a, **k: shared.append(a[1:3]) or ran(*a, **k))
    together = (motors * motors).values, (motors >> points).values
    assert shared and set(shared) == {(N, 3)}
    assert all(np.array_equal(a.view(np.uint64), b.view(np.uint64)) for a, b in zip(alone, together, strict=True))
    bladesmith.set_threads(1)
    assert binding._splitter is None
    bladesmith.set_threads(None)
    assert (binding._splitter is None) == (parallel.thread_count() == 1)


@pytest.mark.parametrize("count", [0, -2, 1.5, "two"])
def test_a_count_of_threads_is_a_positive_whole_number(count):
    with pytest.raises(InputError, match="threads is"):
        bladesmith.set_threads(count)
