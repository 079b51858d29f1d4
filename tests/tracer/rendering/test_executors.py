"""Pictures in bands over executors: threads, processes, a cluster, and the death of workers."""

from __future__ import annotations

import multiprocessing
import os
import signal
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import contextmanager

import numpy as np
import pytest

from bladesmith.common import executors
from bladesmith.errors import BladesmithError, InputError
from bladesmith.tracer.rendering import row_bands
from bladesmith.tracer.rendering.canvas import RenderError, RenderInterrupted
from bladesmith.tracer.scene import render_options

from ...support.tracer.rendering import ALL, SIZE, same, small_scene
from ...support.tracer.scenes import SCENE


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    return small_scene(tmp_path_factory.mktemp("scene"))


def test_bands_cover_the_rows_once():
    for width, height, grid, payload in (
        (640, 480, 1, 1000),
        (1, 1, 1, 10),
        (9, 50000, 3, 10),
        (4000, 3000, 4, 1 << 27),
    ):
        pieces = row_bands.bands(width, height, grid, payload)
        assert [a for a, _ in pieces] == [0, *(b for _, b in pieces[:-1])] and pieces[-1][1] == height
        assert all(a < b for a, b in pieces) and len(pieces) <= row_bands.MAX_BANDS
    assert len(row_bands.bands(4000, 3000, 4, 1 << 27)) == row_bands.MIN_BANDS


@pytest.mark.compiles
def test_threads_of_an_executor_render_the_same(scene, expected, small_bands):
    told = []
    with ThreadPoolExecutor(2) as pool:
        found = scene.layers(*SIZE, ALL, executor=pool, progress=lambda p: told.append((p.done, p.total)))
        np.testing.assert_array_equal(scene.render(*SIZE, executor=pool, threads=2), expected["color"])
        single = scene.layers(*SIZE, ALL, executor=pool, dtype=np.float32, antialias=2)
        same(single, scene.layers(*SIZE, ALL, dtype=np.float32, antialias=2))
    same(found, expected)
    assert told[-1] == (2400, 2400) and len(told) > 5


def test_processes_render_the_same_and_their_death_is_told(scene, expected, small_bands):
    with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("spawn")) as pool:
        same(scene.layers(*SIZE, ALL, executor=pool), expected)
        with pytest.raises(RenderError, match=r"rows \d+ to \d+ were not computed: BrokenProcessPool") as caught:
            scene.layers(*SIZE, ALL, executor=Deadly(pool))
    partial = caught.value.partial
    assert partial.fraction_done < 1 and np.isnan(partial.image[~partial.done]).all()
    np.testing.assert_array_equal(partial.image[partial.done], expected["color"][partial.done])


class Deadly(Executor):
    """Sends work on, but for one band calls that end the worker."""

    def __init__(self, pool):
        self.pool = pool

    def submit(self, function, /, *arguments, **named):
        deadly = arguments[-1].split()[1] == "4"  # whenever this band is sent
        return self.pool.submit(os._exit, 3) if deadly else self.pool.submit(function, *arguments)


# -- a cluster ------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def distributed():
    return pytest.importorskip("dask.distributed")


@pytest.fixture(scope="module")
def started(distributed, tmp_path_factory):
    """Starts clusters on this machine; calls are given up when a second worker has died of them."""
    from dask import config

    @contextmanager
    def start(**ways):
        with config.set(options), distributed.Client(threads_per_worker=1, dashboard_address=":0", **ways) as client:
            yield client

    folder = tmp_path_factory.mktemp("cluster")
    options = {"distributed.scheduler.allowed-failures": 1, "temporary-directory": str(folder)}
    return start


@pytest.fixture(scope="module")
def cluster(started):
    with started(processes=True, n_workers=2) as client:
        yield client


@pytest.mark.compiles
def test_a_cluster_renders_the_same_also_when_a_worker_dies(scene, expected, small_bands, cluster):
    executor, workers = cluster.get_executor(), cluster.run(os.getpid)
    assert len(set(workers.values())) == 2 and os.getpid() not in workers.values()
    same(scene.layers(*SIZE, ALL, executor=executor), expected)
    living = list(workers.values())

    def kill_one(progress):
        while len(living) > 1:
            os.kill(living.pop(), signal.SIGTERM if os.name == "nt" else signal.SIGKILL)

    same(scene.layers(*SIZE, ALL, executor=executor, progress=kill_one), expected)


@pytest.mark.compiles
def test_calls_that_kill_the_workers_of_a_cluster_are_told_and_the_next_picture_is_whole(
    scene, expected, small_bands, cluster
):
    executor = cluster.get_executor()
    with pytest.raises(RenderError, match=r"rows \d+ to \d+ were not computed: KilledWorker: ") as caught:
        scene.layers(*SIZE, ALL, executor=Deadly(executor))
    partial = caught.value.partial
    assert partial.fraction_done < 1 and np.isnan(partial.image[~partial.done]).all()
    np.testing.assert_array_equal(partial.image[partial.done], expected["color"][partial.done])
    same(scene.layers(*SIZE, ALL, executor=executor), expected)


@pytest.mark.peers
def test_a_picture_does_not_end_with_an_equal_one_that_is_given_up(scene, expected, small_bands, cluster):
    """Clusters take calls with equal arguments for one."""
    executor = cluster.get_executor()

    def stop(progress):
        raise KeyboardInterrupt

    for _ in range(3):
        with pytest.raises(RenderInterrupted):
            scene.layers(*SIZE, ALL, executor=executor, progress=stop)
        same(scene.layers(*SIZE, ALL, executor=executor), expected)


@pytest.mark.peers
def test_a_cluster_that_is_closed_is_told(scene, expected, small_bands, started):
    def close(progress):
        client.cluster.close()

    with (
        started(processes=False, n_workers=1) as client,
        pytest.raises(RenderError, match=r"rows \d+ to \d+ were not computed: CancelledError\b(?!: \.)") as caught,
    ):
        scene.layers(*SIZE, ALL, executor=client.get_executor(), progress=close)
    partial = caught.value.partial
    assert 0 < partial.fraction_done < 1
    np.testing.assert_array_equal(partial.image[partial.done], expected["color"][partial.done])


# -- what is refused ------------------------------------------------------------------------------------------


def test_what_is_no_executor_is_refused(scene):
    with pytest.raises(InputError, match="executor is an object; an open"):
        scene.render(*SIZE, executor=object())
    pool = ThreadPoolExecutor(1)
    pool.shutdown()
    with pytest.raises(InputError, match="takes no work.*shutdown"):
        scene.render(*SIZE, executor=pool)


@pytest.mark.compiles
def test_workers_of_another_version_say_so(scene, small_bands, monkeypatch):
    how = render_options.picture_options({}, *SIZE, ("color",), "isolate", 64, 1, np.float64)
    sent = executors.Payload.of(scene._task(how)).data
    monkeypatch.setattr(executors, "__version__", "0.0.1")
    with pytest.raises(BladesmithError, match="a worker has bladesmith 0.0.1, the work comes from"):
        executors.run_piece("new", sent, False, row_bands.render_band, (SIZE, (0, 4), 1), "")
    monkeypatch.undo()
    monkeypatch.setattr(row_bands.RenderTask, "source", lambda *_: "of other sources")
    with pytest.raises(BladesmithError, match="a worker has another bladesmith"):
        executors.run_piece("new", sent, False, row_bands.render_band, (SIZE, (0, 4), 1), "")


class Odd:
    """What has a method `submit` and is no executor."""

    def __init__(self, found):
        self.found = found

    def submit(self, *_):
        if isinstance(self.found, Exception):
            raise self.found
        return self.found


@pytest.mark.parametrize("executor", [5, ThreadPoolExecutor, Odd(3), Odd(ValueError("no")), Odd(None)])
def test_what_is_no_executor_takes_no_work(executor):
    with pytest.raises(InputError, match="takes no work|an open concurrent"):
        SCENE.render(8, 6, executor=executor)
