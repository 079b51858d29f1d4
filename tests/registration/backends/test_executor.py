"""Registration shared over executors: threads, processes, a cluster."""

from __future__ import annotations

import multiprocessing
import os
import signal
import time
from collections import Counter
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor

import numpy as np
import pytest

from bladesmith import registration
from bladesmith.common import executors
from bladesmith.errors import BladesmithError, ExecutorError, InputError, Interrupted
from bladesmith.registration.backends import executor as distributed
from bladesmith.registration.search import query_sets

from ...support.registration import noisy_lines, random_lines, same


@pytest.fixture
def small_pieces(monkeypatch):
    """Also few samples are shared, and models are asked for before they are sent."""
    for name, value in (("SAMPLES_PER_CALL", 2), ("OBJECTS_PER_CALL", 400), ("MAX_ATTACHED_BYTES", 0)):
        monkeypatch.setattr(distributed, name, value)


@pytest.fixture(scope="module")
def expected(models):
    return registration.register(*models, seed=7)


class Counting(Executor):
    """Counts what is sent on; may end the worker that gets a certain call."""

    def __init__(self, pool, deadly=None):
        self.pool, self.deadly, self.sent, self.payloads = pool, deadly, 0, []

    def submit(self, function, /, *arguments):
        self.sent += 1
        self.payloads.append(arguments[1])
        return self.pool.submit(os._exit, 3) if self.sent == self.deadly else self.pool.submit(function, *arguments)


@pytest.mark.parametrize("start", ["global", "proximity"])
def test_threads_of_an_executor_give_the_same(start, models, small_pieces):
    expected = registration.register(*models, seed=7, start=start)
    with ThreadPoolExecutor(2) as pool:
        counting = Counting(pool)
        same(registration.register(*models, seed=7, start=start, executor=counting), expected)
    assert counting.sent > 20


def test_little_work_is_not_shared(models, expected):
    counting = Counting(None)
    same(registration.register(*models, seed=7, executor=counting), expected)
    assert counting.sent == 0


def test_processes_give_the_same_are_sent_models_once_and_their_death_is_told(models, expected, small_pieces):
    with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("spawn")) as pool:
        counting = Counting(pool)
        same(registration.register(*models, seed=7, executor=counting), expected)
        carried = [p for p in counting.payloads if p is not None]
        assert counting.sent > 20 and len(carried) < counting.sent / 2 and len(set(carried)) <= 2
        with pytest.raises(ExecutorError, match="were not computed: BrokenProcessPool: .*without executor="):
            registration.register(*models, seed=7, executor=Counting(pool, 15))
        with pytest.raises(ExecutorError, match="were not computed: BrokenProcessPool"):
            registration.register(*models, seed=7, executor=pool)


@pytest.mark.compiles
def test_a_cluster_gives_the_same_also_when_a_worker_dies(models, expected, small_pieces, tmp_path):
    dask = pytest.importorskip("dask.distributed")
    from dask import config

    with (
        config.set({"temporary-directory": str(tmp_path), "distributed.scheduler.allowed-failures": 3}),
        dask.Client(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=":0") as client,
    ):
        executor, living = client.get_executor(), list(client.run(os.getpid).values())
        assert len(set(living)) == 2 and os.getpid() not in living
        same(registration.register(*models, seed=7, executor=executor), expected)

        def kill_one(progress):
            while len(living) > 1:
                os.kill(living.pop(), signal.SIGTERM if os.name == "nt" else signal.SIGKILL)

        same(registration.register(*models, seed=7, executor=executor, progress=kill_one), expected)


def test_what_is_no_executor_is_refused(models, small_pieces):
    for wrong, message in (
        (object(), "an object"),
        (ThreadPoolExecutor, "the class ThreadPoolExecutor"),
        (3, "3"),
    ):
        with pytest.raises(InputError, match=f"executor is {message}; an open concurrent.futures.Executor is needed"):
            registration.register(*models, executor=wrong)
    pool = ThreadPoolExecutor(1)
    pool.shutdown()
    with pytest.raises(InputError, match="takes no work: RuntimeError.*shutdown"):
        registration.register(*models, executor=pool)


def test_workers_of_another_version_say_so(models, small_pieces, monkeypatch):
    with ThreadPoolExecutor(1) as pool:
        for name, value, message in (
            ("__version__", "0.0.1", "a worker has bladesmith 0.0.1, the work comes from"),
            ("_digest", lambda task: "other", "a worker has another bladesmith"),
        ):
            packed = executors.Payload.of

            def swapped(task, packed=packed, name=name, value=value):
                found = packed(task)
                monkeypatch.setattr(executors, name, value)
                return found

            monkeypatch.setattr(executors.Payload, "of", swapped)
            with pytest.raises(BladesmithError, match=message):
                registration.register(*models, executor=pool)
            monkeypatch.undo()
            for part, small in (("SAMPLES_PER_CALL", 2), ("OBJECTS_PER_CALL", 400), ("MAX_ATTACHED_BYTES", 0)):
                monkeypatch.setattr(distributed, part, small)


def test_a_failing_piece_is_tried_twice(models, expected, small_pieces):
    class Failing(Counting):
        """The second piece of every stage fails, so often."""

        def submit(self, function, /, *arguments):
            _, place, tries, _ = arguments[-1].split()
            if place == "1" and int(tries) < self.deadly:
                self.sent += 1
                return self.pool.submit(divmod, 1, 0)
            return self.pool.submit(function, *arguments)

    with ThreadPoolExecutor(2) as pool:
        failing = Failing(pool, 1)
        same(registration.register(*models, seed=7, executor=failing), expected)
        assert failing.sent > 2
        with pytest.raises(ExecutorError, match="were not computed: ZeroDivisionError") as caught:
            registration.register(*models, seed=7, executor=Failing(pool, 2))
    assert isinstance(caught.value.__cause__, ZeroDivisionError)


def test_an_interrupt_leaves_an_executor_alone(models, small_pieces):
    def stop(progress):
        if progress.detail.hits > 10:
            raise KeyboardInterrupt

    with ThreadPoolExecutor(1) as pool, pytest.raises(Interrupted):  # the pool is left alone from then on
        registration.register(*models, progress=stop, executor=pool)


# -- searches that go on ---------------------------------------------------------------------------------------


@pytest.fixture
def small_lots(monkeypatch):
    """Lots of few sets, which workers try from the first on."""
    for name, value in (("PAIRS_PER_BATCH", 64), ("LOCAL_BATCHES", 0)):
        monkeypatch.setattr(query_sets, name, value)
    monkeypatch.setattr(distributed, "MAX_ATTACHED_BYTES", 0)


def hopeless():
    """Models of two kinds that have nothing in common: every set is tried, at every tolerance."""
    random = np.random.default_rng(8)
    return tuple(
        registration.Model(lines=random_lines(25, random), points=random.uniform(-1, 1, (15, 3))) for _ in range(2)
    )


class Stages(Counting):
    """Counts the calls of each stage."""

    def __init__(self, pool):
        super().__init__(pool)
        self.stages, self.futures = Counter(), []

    def submit(self, function, /, *arguments):
        self.stages[arguments[-2][1]] += 1
        self.futures.append(super().submit(function, *arguments))
        return self.futures[-1]


def test_workers_try_whole_lots_of_sets_and_give_the_same(small_lots):
    for models in (hopeless(), noisy_lines(noise=0.02, wrong=0.5)):
        expected = registration.register(*models, seed=7, samples=300)
        with ThreadPoolExecutor(3) as pool:
            stages = Stages(pool)
            same(registration.register(*models, seed=7, samples=300, executor=stages), expected)
        assert stages.stages["evaluate"] > 20


@pytest.mark.compiles
def test_other_processes_try_lots_and_give_the_same(small_lots, tmp_path):
    dask = pytest.importorskip("dask.distributed")
    from dask import config

    models = hopeless()
    expected = registration.register(*models, seed=7)
    with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("spawn")) as pool:
        same(registration.register(*models, seed=7, executor=pool), expected)
        assert executors.workers(pool) == 2
        with pytest.raises(ExecutorError, match="were not computed: BrokenProcessPool"):
            registration.register(*models, seed=7, executor=Counting(pool, 9))
    with (
        config.set({"temporary-directory": str(tmp_path)}),
        dask.Client(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=":0") as client,
    ):
        executor = client.get_executor()
        same(registration.register(*models, seed=7, executor=executor), expected)
        assert executors.workers(executor) == 2


def late(function, *arguments):
    time.sleep(0.02)
    return function(*arguments)


def test_lots_that_are_not_needed_any_more_are_dropped(small_lots):
    """Of what was sent ahead of a slow worker some has not begun when the search ends."""
    models = noisy_lines(wrong=0.1)
    expected = registration.register(*models, seed=7)
    with ThreadPoolExecutor(1) as pool:
        stages = Stages(pool)
        submit = pool.submit
        pool.submit = lambda *given: submit(late, *given)
        same(registration.register(*models, seed=7, executor=stages), expected)
    assert stages.stages["evaluate"] > 2
    assert any(future.cancelled() for future in stages.futures)


def test_workers_of_an_executor_that_does_not_tell_how_many_it_has():
    assert executors.workers(Counting(None)) == executors.DEFAULT_WORKERS
