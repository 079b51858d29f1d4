"""Kernels on all pairs of rows, and nearest rows: compiled loops, numba, columns, CUDA, against plain loops."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from bladesmith import cga3d as cga
from bladesmith import codegen, errors
from bladesmith.codegen.execute.cuda_driver import CudaKernel, CudaModule
from bladesmith.codegen.execute.pairs import all_pairs, nearest
from bladesmith.codegen.formulas.products.outcome import outcome, where_or_nan
from bladesmith.codegen.targets.c.printer import symbol
from bladesmith.codegen.trace.kernel import interface
from bladesmith.common import parallel
from bladesmith.status import Status

from ...support import cuda as cuda_support

RANDOM = np.random.default_rng(5)
#: Below, at and beyond the rows that the compiled loops take at a time.
COUNTS = (1, 7, 255, 256, 257, 600)
TARGETS = ("c", pytest.param("numba", marks=pytest.mark.peers), "numpy", pytest.param("cuda", marks=pytest.mark.gpu))


@codegen.kernel(cga.kind("euclidean"), cga.kind("euclidean"))
def squared_distance(a: Any, b: Any) -> Any:
    return ((a - b) * (a - b)).grade(0)


@codegen.kernel(cga.kind("euclidean"), cga.kind("euclidean"))
def quotient(a: Any, b: Any) -> Any:
    scale = (a * b).grade(0)
    return a ^ b, b / where_or_nan(scale > 0, scale), outcome(a, (~(scale > 0), Status.SINGULAR))


@codegen.kernel(codegen.scalar, codegen.scalar, algebra=cga)
def difference(a: Any, b: Any) -> Any:
    return a - b


def bound(kernel: Any, target: str, *arrays: np.ndarray) -> Any:
    if target == "cuda":  # behind a stand-in for the GPU
        variant = kernel.variant
        device = cuda_support.stand_in_of_kernels(f"pairs_{kernel.name}_stand_in", [variant])
        return CudaKernel(CudaModule(device, b"no image"), symbol(variant.kernel), *interface(variant.kernel))
    return kernel.bound(target, arrays)


def distances(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return ((a[:, None].astype(float) - b[None]) ** 2).sum(-1)


@pytest.mark.slow
@pytest.mark.parametrize("target", TARGETS)
@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_all_pairs_and_nearest(target: str, dtype: Any) -> None:
    for n, m in [(3, c) for c in COUNTS] + [(300, 5), (1, 1)]:
        a, b = RANDOM.normal(size=(n, 3)).astype(dtype), RANDOM.normal(size=(m, 3)).astype(dtype)
        kernel = bound(squared_distance, target, a, b)
        values = all_pairs(kernel, a, b)
        assert values.shape == (n, m, 1) and values.dtype == dtype
        np.testing.assert_allclose(values[..., 0], distances(a, b), rtol=8 * np.finfo(dtype).eps)
        index, least = nearest(kernel, a, b)
        assert index.dtype == np.int64 and least.dtype == dtype
        np.testing.assert_array_equal(index, values[..., 0].argmin(1))
        np.testing.assert_array_equal(least, values[..., 0].min(1))


@pytest.mark.slow
@pytest.mark.parametrize("target", TARGETS)
def test_several_results_and_statuses(target: str) -> None:
    a, b = RANDOM.normal(size=(4, 3)), RANDOM.normal(size=(300, 3))
    kernel = bound(quotient, target, a, b)
    found = all_pairs(kernel, a, b)
    for i in range(4):
        for part, whole in zip(kernel(a[i], b), found, strict=True):
            np.testing.assert_array_equal(whole[i], part)
    assert found[2].dtype == np.uint8 and set(np.unique(found[2])) == {0, Status.SINGULAR}
    with pytest.raises(errors.InputError, match="one number"):
        nearest(kernel, a, b)


@pytest.mark.parametrize("target", TARGETS)
def test_nan_never_wins_and_the_first_of_equals_does(target: str) -> None:
    b = np.zeros((513, 3))
    b[:, 0] = 2.0
    b[[0, 40, 256]] = np.nan
    b[[70, 300, 512], 0] = 1.0
    a = np.array([[0.0, 0, 0], [np.nan, 0, 0], [9.0, 0, 0]])
    kernel = bound(squared_distance, target, a, b)
    index, least = nearest(kernel, a, b)
    assert index.tolist() == [70, -1, 1]
    assert least.tolist() == [1.0, np.inf, 49.0]
    assert nearest(kernel, a, b[:1])[0].tolist() == [-1, -1, -1]
    many, of_many = nearest(kernel, a[np.arange(1200) % 3], b)  # more rows than others: these are lanes
    assert many.tolist() == 400 * [70, -1, 1]
    assert of_many.tolist() == 400 * [1.0, np.inf, 49.0]


@pytest.mark.parametrize("target", TARGETS)
def test_plain_numbers(target: str) -> None:
    a, b = RANDOM.normal(size=5), RANDOM.normal(size=270)
    kernel = bound(difference, target, a, b)
    np.testing.assert_array_equal(all_pairs(kernel, a, b)[..., 0], a[:, None] - b)
    np.testing.assert_array_equal(nearest(kernel, a, b)[0], np.full(5, b.argmax()))


@pytest.mark.parametrize("target", TARGETS)
def test_nothing(target: str) -> None:
    none, some = np.empty((0, 3)), RANDOM.normal(size=(2, 3))
    kernel = bound(squared_distance, target, some, some)
    assert all_pairs(kernel, none, some).shape == (0, 2, 1) and all_pairs(kernel, some, none).shape == (2, 0, 1)
    assert nearest(kernel, none, some)[0].shape == (0,)
    assert nearest(kernel, some, none)[0].tolist() == [-1, -1]


def test_threads_give_the_same_bits() -> None:
    a, b = RANDOM.normal(size=(1000, 3)), RANDOM.normal(size=(70, 3))
    kernel = bound(squared_distance, "c", a, b)

    def split(part: Any, n: int) -> None:
        parallel.run(part, n, threads=2, chunk=13)

    np.testing.assert_array_equal(all_pairs(kernel, a, b, split), all_pairs(kernel, a, b))
    for shared, plain in zip(nearest(kernel, a, b, split), nearest(kernel, a, b), strict=True):
        np.testing.assert_array_equal(shared, plain)


def test_rows_are_taken_as_they_come() -> None:
    a, b = RANDOM.normal(size=(8, 3)), RANDOM.normal(size=(9, 3))
    kernel = bound(squared_distance, "c", a, b)
    expected = all_pairs(kernel, a, b)
    np.testing.assert_array_equal(all_pairs(kernel, np.asfortranarray(a)[::-1], b.tolist())[::-1], expected)
    assert all_pairs(kernel, a.astype(np.float32), b).dtype == np.float64


def test_what_is_no_pair_of_rows() -> None:
    a = RANDOM.normal(size=(8, 3))
    kernel = bound(squared_distance, "c", a, a)
    for bad in (a[0], a[:, :2], a[None]):
        with pytest.raises(errors.ShapeError, match=r"b has shape .* rows \(n, 3\)"):
            all_pairs(kernel, a, bad)
    with pytest.raises(errors.InputError, match="complex"):
        all_pairs(kernel, a, a * 1j)

    @codegen.kernel(cga.kind("euclidean"))
    def one(x: Any) -> Any:
        return (x * x).grade(0)

    with pytest.raises(errors.InputError, match="takes 1 arrays"):
        nearest(bound(one, "c", a), a, a)
