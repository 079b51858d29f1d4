"""Work in pieces on the workers of an executor."""

from __future__ import annotations

import os
import signal
import threading
from collections import Counter
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from dataclasses import dataclass

import pytest

from bladesmith.codegen.interrupts import keep_partial
from bladesmith.common import executors
from bladesmith.errors import BladesmithError, ExecutorError, InputError, Interrupted

prepared: Counter[str] = Counter()


@dataclass(frozen=True)
class Scale(executors.Task):
    factor: int
    own: bool = False

    def prepare(self):
        prepared[str(self.factor)] += 1
        return self.factor

    @property
    def per_thread(self):
        return self.own


def times(factor, number):
    return factor * number


def failing(factor, number):
    if number == 2:
        raise BladesmithError("number 2") if factor == 3 else ZeroDivisionError("number 2")
    return factor * number


def dying(factor, number):
    return os._exit(3) if number == 2 else factor * number


def run(executor, function=times, task=Scale(2), count=6):
    found = {}
    pieces = [((i,), f"number {i}") for i in range(count)]
    with keep_partial(lambda: dict(found)):
        executors.run_pieces(executor, executors.Payload.of(task), function, pieces, found.__setitem__)
    return found


@pytest.mark.parametrize("pool", [ThreadPoolExecutor, ProcessPoolExecutor])
def test_every_piece_is_computed_once(pool):
    with pool(2) as executor:
        assert run(executor) == {i: 2 * i for i in range(6)}
        assert executors.workers(executor) == 2
        assert executors.ranges(executor, 100, 30) == [(0, 33), (33, 66), (66, 100)]
        assert len(executors.ranges(executor, 1000)) == 2 * executors.PIECES_PER_WORKER


def test_a_task_is_prepared_once_for_a_worker_or_each_of_its_threads():
    prepared.clear()
    with ThreadPoolExecutor(1) as executor:
        run(executor, task=Scale(11))
        run(executor, task=Scale(11))
        run(executor, task=Scale(12, own=True))
    with ThreadPoolExecutor(1) as executor:
        run(executor, task=Scale(11))
        run(executor, task=Scale(12, own=True))
    assert prepared == {"11": 1, "12": 2}


def test_a_task_is_sent_to_those_who_ask():
    class Counting(Executor):
        sent = 0

        def submit(self, function, digest, data, *rest):
            self.sent += data is not None
            return pool.submit(function, digest, data, *rest)

    found, counting = {}, Counting()
    with ThreadPoolExecutor(1) as pool:
        calls = executors.Calls(counting, executors.Payload.of(Scale(13)), attached=False)
        for i in range(3):
            calls.send(i, times, (i,), f"number {i}")
            calls.wait([i], found.__setitem__)
    assert found == {0: 0, 1: 13, 2: 26} and counting.sent == 1


def test_errors_carry_what_others_computed():
    with ThreadPoolExecutor(1) as executor:
        with pytest.raises(ExecutorError, match=r"number 2 were not computed: ZeroDivisionError: number 2\.") as caught:
            run(executor, failing)
        assert isinstance(caught.value.__cause__, ZeroDivisionError)
        assert {0: 0, 1: 2}.items() <= caught.value.partial.items() and 2 not in caught.value.partial
        with pytest.raises(BladesmithError, match="number 2") as own:
            run(executor, failing, Scale(3))
        assert not isinstance(own.value, ExecutorError)


def test_dead_workers_are_told_and_their_pool_as_well():
    with ProcessPoolExecutor(1) as executor:
        for function in (dying, times):
            with pytest.raises(ExecutorError, match=r"number \d were not computed: BrokenProcessPool"):
                run(executor, function)


def test_a_piece_that_fails_is_tried_again():
    tries = Counter()

    class Weak(Executor):
        def submit(self, function, *arguments):
            index = arguments[-1].split()[1]
            tries[index] += 1
            return pool.submit(divmod, 1, 0) if (index, tries[index]) == ("3", 1) else pool.submit(function, *arguments)

    with ThreadPoolExecutor(2) as pool:
        assert run(Weak()) == {i: 2 * i for i in range(6)}
    assert tries["3"] == 2 and tries["4"] == 1


def test_an_executor_without_results_ends_with_an_error():
    class Silent(Executor):
        calls = 0

        def submit(self, function, *arguments):
            self.calls += 1
            assert self.calls < 100
            (future := Future()).set_result(None)
            return future

    with pytest.raises(ExecutorError, match="gives None"):
        run(Silent())


def test_causes_are_told_on_one_line():
    class Verbose(Executor):
        def submit(self, function, *arguments):
            raise RuntimeError("one\ntwo")

    with pytest.raises(BladesmithError, match="RuntimeError: one two"):
        run(Verbose())


def test_an_interrupt_drops_what_waits_and_keeps_what_is_done():
    go, futures = threading.Event(), []

    class Slow(Executor):
        def submit(self, function, *arguments):
            index = int(arguments[-1].split()[1])
            futures.append(pool.submit(function, *arguments) if index < 2 else Future())
            return futures[-1]

    found = {}

    def done(index, result):
        found[index] = result
        if len(found) == 2 and not go.is_set():
            go.set()
            signal.raise_signal(signal.SIGINT)

    with ThreadPoolExecutor(1) as pool, pytest.raises(Interrupted) as caught, keep_partial(lambda: dict(found)):
        pieces = [((i,), f"number {i}") for i in range(5)]
        executors.run_pieces(Slow(), executors.Payload.of(Scale(2)), times, pieces, done)
    assert caught.value.partial == {0: 0, 1: 2} and isinstance(caught.value, KeyboardInterrupt)
    assert all(future.cancelled() for future in futures[2:])


@pytest.mark.parametrize("wrong", [3, None, ThreadPoolExecutor, object()])
def test_what_is_no_executor_is_refused(wrong):
    with pytest.raises(InputError, match=r"executor is .*; an open concurrent\.futures\.Executor is needed"):
        run(wrong)


def test_what_takes_no_work_is_refused():
    pool = ThreadPoolExecutor(1)
    pool.shutdown()
    with pytest.raises(InputError, match="the executor takes no work: RuntimeError"):
        run(pool)


def test_nothing_of_another_version_is_unpickled(monkeypatch):
    loaded = []
    monkeypatch.setattr(executors.pickle, "loads", loaded.append)
    with pytest.raises(BladesmithError, match=r"the work comes from 0\.0\.1"):
        executors.run_piece("x", b"0.0.1\n\n" + b"no pickle", False, times, (1,), "")
    assert not loaded


def test_what_cannot_be_sent_is_refused():
    with pytest.raises(InputError, match="cannot be sent to workers"):
        executors.Payload.of(Scale(lambda: 3))
