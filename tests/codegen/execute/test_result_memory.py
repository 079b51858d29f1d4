"""Memory of large results: used again when nothing is on it, and never before."""

from __future__ import annotations

import ctypes
import gc
import operator
import pickle
import signal
import subprocess
import sys
import threading
from functools import partial

import numpy as np
import pytest

from bladesmith import cga3d
from bladesmith.codegen.execute import result_memory
from bladesmith.codegen.execute.result_memory import LEAST, ResultMemory

SHAPE = (LEAST // 64, 8)


def address(array: np.ndarray) -> int:
    return int(array.__array_interface__["data"][0])


def test_a_block_is_used_again_once_its_array_is_gone() -> None:
    store = ResultMemory(4 * LEAST)
    first = store.empty(SHAPE, float)
    at = address(first)
    assert first.shape == SHAPE and first.dtype == float and first.flags.c_contiguous and first.flags.writeable
    second = store.empty(SHAPE, float)
    assert address(second) != at and store.kept == 0
    del first
    assert store.kept == LEAST
    third = store.empty((LEAST // 4,), np.float32)
    assert address(third) == at and store.kept == 0


@pytest.mark.parametrize(
    "view",
    [lambda a: a[5:6], lambda a: a.reshape(-1)[::2], lambda a: memoryview(a), lambda a: a.T.view(np.int64),
     lambda a: np.broadcast_to(a[0], (3, 8)), lambda a: a.data.toreadonly()],
)  # fmt: skip
def test_what_is_on_a_block_keeps_it(view) -> None:
    store = ResultMemory(4 * LEAST)
    array = store.empty(SHAPE, float)
    array.fill(7.0)
    held = view(array)
    del array
    gc.collect()
    store.empty(SHAPE, float).fill(0.0)
    assert (np.asarray(held).view(float) if not isinstance(held, memoryview) else np.asarray(held)).max() == 7.0
    kept = store.kept
    del held
    assert store.kept == kept + LEAST


def test_small_results_and_those_beyond_half_of_the_limit_are_as_usual() -> None:
    store = ResultMemory(4 * LEAST)
    for shape in ((10, 8), (2 * LEAST,)):
        array = store.empty(shape, np.uint8)
        assert array.flags.owndata
        del array
        assert store.kept == 0
    for most in (0, LEAST, 3 * LEAST):
        assert ResultMemory(most).empty(SHAPE, float).flags.owndata


def test_no_more_is_kept_than_the_limit() -> None:
    store = ResultMemory(16 * LEAST)
    sizes = [size for size in (LEAST, 2 * LEAST - 1, 2 * LEAST, 4 * LEAST - 1, 7 * LEAST) for _ in range(4)]
    arrays = [store.empty((size,), np.uint8) for size in sizes]
    largest = {address(a) for a in arrays[-4:]}
    assert store.kept == 0
    arrays.clear()
    assert 10 * LEAST < store.kept <= 16 * LEAST
    assert address(store.empty((7 * LEAST,), np.uint8)) in largest


def test_blocks_are_not_given_to_much_smaller_results() -> None:
    store = ResultMemory(8 * LEAST)
    big = store.empty((2 * LEAST - 1,), np.uint8)
    at = address(big)
    del big
    assert address(store.empty((LEAST,), np.uint8)) != at
    assert address(store.empty((2 * LEAST - LEAST // 4,), np.uint8)) == at


def test_an_interrupt_is_not_lost_where_an_array_goes() -> None:
    """Python would run a method `__del__` there, raise the interrupt in it, and drop it."""
    store, raised = ResultMemory(4 * LEAST), partial(ctypes.CDLL(None)["raise"], signal.SIGINT)
    for _ in range(20):
        arrays = [store.empty(SHAPE, float)]
        with pytest.raises(KeyboardInterrupt):
            list(map(operator.call, [raised, arrays.clear]))  # the signal comes, the array goes, then Python looks
        assert not arrays and store.kept == LEAST


def test_threads_never_share_a_block() -> None:
    store, wrong = ResultMemory(6 * LEAST), []

    def work(number: int) -> None:
        for _ in range(30):
            array = store.empty((LEAST,), np.uint8)
            array[::4096] = number
            if (array[::4096] != number).any():
                wrong.append(number)

    threads = [threading.Thread(target=work, args=(n,)) for n in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not wrong and store.kept <= 6 * LEAST


def test_arrays_on_blocks_are_pickled_and_copied() -> None:
    array = ResultMemory(4 * LEAST).empty(SHAPE, float)
    array.fill(1.0)
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(array))[:3], array[:3])
    assert array.copy().flags.owndata


@pytest.mark.parametrize(("value", "megabytes"), [("0", 0), ("64", 64), ("", 256), ("many", 256)])
def test_the_environment_says_how_much(value, megabytes) -> None:
    code = "from bladesmith.codegen.execute.result_memory import STORE; print(STORE.most >> 20)"
    command = [sys.executable, "-c", code]
    done = subprocess.run(
        command, env={result_memory.LIMIT_VARIABLE: value, "PATH": ""}, capture_output=True, text=True, check=True
    )
    assert done.stdout.split() == [str(megabytes)]


@pytest.mark.parametrize(
    "operation", [lambda r: r * r, lambda r: ~r, lambda r: r >> r], ids=["product", "reverse", "motion"]
)
def test_operations_on_many_items_use_it(operation) -> None:
    r = cga3d.translator(np.random.default_rng(0).normal(size=(LEAST // 64, 3))).as_kind("motor")
    first = operation(r)
    at, values = address(first._data), first._data[-1].tolist()
    del first
    again = operation(r)
    assert address(again._data) == at and again._data[-1].tolist() == values
