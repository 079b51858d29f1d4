"""Algorithms on the CUDA target: NVRTC compiles the text without a word, and the text computes the bits of C.

What would run on a GPU runs here through the C compiler, behind a stand-in for the driver.
"""

from __future__ import annotations

import gc
import re
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import codegen, kinematics
from bladesmith.codegen import algorithm
from bladesmith.codegen.algorithms.table_product import multiply_by_table
from bladesmith.codegen.errors import DeviceError, InputError
from bladesmith.codegen.execute import cuda_driver, cuda_items
from bladesmith.codegen.execute.cuda_driver import unavailable
from bladesmith.codegen.language import InOut, Int, IntVector, Matrix, Out, Real, Reals, Vector, exp, sin, sqrt, zeros
from bladesmith.codegen.programs import chains, trees
from bladesmith.codegen.programs.algorithms import algorithm_cuda
from bladesmith.codegen.programs.chains import chain_function
from bladesmith.codegen.programs.mechanisms.program import CLASSES, NAMES, mechanism_function
from bladesmith.codegen.programs.merging.program import merge_program
from bladesmith.codegen.targets.c.instances import ONE_BY_ONE
from bladesmith.codegen.targets.cuda.printer import stock_source
from bladesmith.dispatch import product_tables, stock_algorithms
from bladesmith.dispatch.product_tables import product_table
from bladesmith.kinematics.mechanism import loop_calls
from bladesmith.kinematics.mechanism.poses.jacobians import METHODS
from bladesmith.kinematics.serial import driver as chain_driver

from ...support import cuda as cuda_support
from ...support.kinematics import FourBar, four_bar
from ...support.objects.merging import clustered
from ...support.targets.pullbacks import walk

pytestmark = pytest.mark.gpu
cga = bs.cga3d
rng = np.random.default_rng(7)
#: More than two blocks of threads.
COUNT = 300


@codegen.kernel(cga.kind("motor"), cga.kind("point"))
def moved(m, x):
    return m * x * ~m


@algorithm
def everything(
    m: Vector[8], x: InOut[Vector[5]], n: Int, table: IntVector[3], length: Out[Vector[2]]
) -> tuple[Real, Int]:
    """A kernel, elementary functions, integers, a local array, several results."""
    last = zeros(3)
    steps = 0
    for i in range(n):
        x[:] = moved(m, x)
        last[table[i % 3]] = sin(x[1]) + exp(-x[1] * x[1]) + x[2]
        if last[1] > 1.5:
            break
        steps += i // 2 - i % 2
    length[0] = sqrt(last[0] * last[0] + last[1] * last[1])
    length[1] = last[2] / (1.0 + length[0])
    return length[0] - length[1], steps


@algorithm
def accumulated(rows: InOut[Reals], weights: Matrix[2, 2]) -> Real:
    """Rows whose number is known at run time, and an argument that all items share."""
    total = 0.0
    for i in range(len(rows)):
        total += weights[i % 2, 0] * rows[i]
        rows[i] = total + weights[1, i % 2]
    return total


def everything_arguments(dtype: Any) -> list[Any]:
    motors = cga.translator(rng.normal(size=(COUNT, 3))) * cga.rotor(
        rng.normal(size=(COUNT, 3)), rng.normal(size=COUNT)
    )
    points = cga.point(rng.normal(size=(COUNT, 3)))
    coefficients = [motors.as_kind(cga.kind("motor")).values, points.as_kind(cga.kind("point")).values]
    tables = rng.integers(0, 3, (COUNT, 3))
    return [*(c.astype(dtype) for c in coefficients), rng.integers(0, 6, COUNT), tables]


def accumulated_arguments(dtype: Any) -> list[Any]:
    return [rng.normal(size=(COUNT, 5)).astype(dtype), rng.normal(size=(2, 2)).astype(dtype)]


def table_arguments(dtype: Any) -> list[Any]:
    a, b = rng.normal(size=(2, COUNT, 4)).astype(dtype)
    starts, left, right = np.array([0, 2, 5, 6]), np.array([0, 1, 2, 3, 0, 1]), np.array([3, 2, 1, 0, 1, 1])
    return [starts, left, right, np.array([1, -1, 2, 1, -1, 0.5], dtype), a, b, np.zeros((COUNT, 3), dtype)]


CASES: dict[str, tuple[Any, Callable[[Any], list[Any]]]] = {
    "everything": (everything, everything_arguments),
    "accumulated": (accumulated, accumulated_arguments),
    "table product": (algorithm(multiply_by_table.text.function), table_arguments),
}
each_case = pytest.mark.parametrize("name", CASES)
each_dtype = pytest.mark.parametrize("dtype", [np.float64, np.float32], ids=["f64", "f32"])


@each_case
@pytest.mark.parametrize("arch", cuda_support.ARCHITECTURES)
def test_users_algorithms_compile_without_a_warning(name: str, arch: str) -> None:
    tried, arguments = CASES[name]
    files = algorithm_cuda(tried.function_for(arguments(np.float64)))
    cuda_support.assert_clean(files, arch, {"launch_bs_loop_f64", "launch_bs_loop_f32"}, optimise=True)
    assert not re.search(r'#\s*include\s*"', tried.source("cuda", *arguments(np.float64)))


@pytest.mark.parametrize("name", ["forward", "jacobian", "twists", "inverse"])
def test_chains_compile_without_a_warning(name: str) -> None:
    files = algorithm_cuda(chain_function("cga3d", chains.CLASSES[0], name))
    cuda_support.assert_clean(files, "compute_90", {"launch_bs_loop_f64", "launch_bs_loop_f32"})


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_mechanisms_compile_without_a_warning(name: str) -> None:
    files = algorithm_cuda(mechanism_function("cga3d", CLASSES[0], name), ONE_BY_ONE[:1])
    cuda_support.assert_clean(files, "compute_90", {"launch_bs_loop_f64"})


@pytest.mark.parametrize(
    ("name", "by", "has_frames"),
    [*((name, "", name in trees.VARIED) for name in trees.SHARED), ("forward_dynamics", "x", False)],
)
def test_trees_of_links_compile_without_a_warning(name: str, by: str, has_frames: bool) -> None:
    files = algorithm_cuda(trees.tree_function("cga3d", trees.CLASSES[0], name, by, has_frames))
    cuda_support.assert_clean(files, "compute_90", {"launch_bs_loop_f64", "launch_bs_loop_f32"})


def test_merging_compiles_without_a_warning() -> None:
    program = merge_program()
    names = re.findall(r"void (bs_\w+_f64)\(", program.files["kernels.cdef"])
    assert len(names) > 8
    cuda_support.assert_clean(stock_source(program.files), "compute_90", {f"launch_{name}" for name in names})


def test_a_derivative_has_cuda_text_too() -> None:
    text = accumulated.derivative("weights").source("cuda", *accumulated_arguments(np.float64))
    assert "launch_bs_loop_f64" in text


def test_reverse_derivatives_compile_without_a_warning() -> None:
    derived = walk.pullback()
    files = algorithm_cuda(derived.function_for(derived.declared_arguments()))
    cuda_support.assert_clean(files, "compute_90", {"launch_bs_loop_f64", "launch_bs_loop_f32"})


# -- the text, run -------------------------------------------------------------------------------------


def assert_same_bits(found: Any, expected: Any) -> None:
    for a, b in zip(*(r if isinstance(r, tuple) else (r,) for r in (found, expected)), strict=True):
        assert a.dtype == b.dtype
        np.testing.assert_array_equal(a, b)


@each_case
@each_dtype
def test_the_text_computes_the_bits_of_c(name: str, dtype: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    tried, arguments = CASES[name]
    given = arguments(dtype)
    files = algorithm_cuda(tried.function_for(given))
    used = cuda_support.stand_in_of_loops(f"algorithm_{''.join(c for c in name if c.isalpha())}_stand_in", files)
    monkeypatch.setattr(cuda_driver, "first_gpu", lambda: used)
    monkeypatch.setattr(cuda_items, "compile_cached", lambda *_: b"no image")
    tried._compiled.clear()
    assert_same_bits(tried.on("cuda")(*given), tried.on("c")(*given))
    tried._compiled.clear()
    used.call("bs_left_open")  # fails unless it returns zero: nothing stays allocated


@cuda_support.each_device
def test_chains_run_on_it_with_the_bits_of_c(where: str) -> None:
    positions = [[0, 0, 0.1 + 0.2 * j] for j in range(7)]
    axes = kinematics.revolute_axis(positions, [[0, j % 2, (j + 1) % 2] for j in range(7)])
    tool = cga.translator([0, 0, 1.6])
    chains = [kinematics.Chain(axes, tool, target=target) for target in ("c", "cuda")]
    x = rng.uniform(-2, 2, (COUNT, 7))
    chain_driver._loop.cache_clear()
    with cuda_support.devices(where) as used:
        for name, call in {
            "forward": lambda chain: chain.forward(x).values,
            "jacobian": lambda chain: chain.jacobian(x),
            "inverse": lambda chain: chain.inverse(chains[0].forward(x[:20])).q,
        }.items():
            expected, found = (call(chain) for chain in chains)
            np.testing.assert_array_equal(found, expected, err_msg=name)
    assert len(used) == 3
    chain_driver._loop.cache_clear()


@pytest.mark.slow
@pytest.mark.compiles
@cuda_support.each_device
def test_mechanisms_run_on_it_with_the_bits_of_c(where: str) -> None:
    angles = np.append(rng.uniform(-2, 2, COUNT), [np.nan, np.inf])
    loop_calls.mechanism_loop.cache_clear()
    with cuda_support.devices(where) as used:
        found = mechanism_results("c", angles), mechanism_results("cuda", angles)
    assert len(used) == len(NAMES)
    for expected, own in zip(*found, strict=True):
        assert expected.tobytes() == own.tobytes()
    loop_calls.mechanism_loop.cache_clear()
    gc.collect()
    for device in used if where == cuda_support.STAND_IN else ():
        device.call("bs_left_open")


@pytest.mark.parametrize("kind", ["line", "circle"])
@cuda_support.each_device
def test_merging_searches_on_it_with_the_result_of_c(kind: str, where: str) -> None:
    lines = clustered(kind, 60, 5, 7, 0.05)[0]
    caches = (stock_algorithms._loops_on_gpu, stock_algorithms.stock_algorithm_on_gpu)
    with cuda_support.devices(where) as used:
        expected, found = (bs.objects.merge_similar(lines, 0.3, target=target) for target in ("c", "cuda"))
        assert not bs.objects.merge_similar(lines[:0], 0.3, target="cuda").counts.size
    assert len(used) == 1 and len(expected.merge_costs) > 200 and found.evaluations == expected.evaluations
    for name in ("groups", "counts", "merge_costs", "pairs"):
        np.testing.assert_array_equal(getattr(found, name), getattr(expected, name))
    assert found.objects.values.tobytes() == expected.objects.values.tobytes()
    for cache in caches:
        cache.cache_clear()


@each_dtype
@cuda_support.each_device
def test_products_by_table_run_on_it_with_the_bits_of_c(dtype: Any, where: str) -> None:
    algebra = bs.algebra(2, 1, 1)
    a, b = (algebra.multivector(rng.normal(size=(COUNT, 16)).astype(dtype)) for _ in range(2))
    blades = tuple(map(int, algebra.blades))
    with cuda_support.devices(where) as used:
        found = product_table(algebra, "geometric", blades, blades).on("cuda")(a.values, b.values)
        one = product_table(algebra, "geometric", blades, blades).on("cuda")(a.values, b[0].values)
    product_tables._table_algorithm.cache_clear()
    assert used and found.dtype == dtype
    assert found.tobytes() == (a * b).values.tobytes() and one.tobytes() == (a * b[0]).values.tobytes()


def mechanism_results(target: str, angles: Any) -> list[Any]:
    """Poses of a mechanism by a joint, along a path and by a body, and both kinds of Jacobians."""
    made = four_bar(FourBar().places(0.8))
    bars = kinematics.Mechanism(made.bodies, made.fixed, target=target)
    for joint, name in zip(made.joints, made.joint_names, strict=True):
        bars.add(joint, name)
    poses = bars.solve_pose({"a": angles})
    found = [x for p in (poses, bars.solve_pose({"a": angles[:9]}, path=True)) for x in (p.own, p.residual, p.status)]
    found += [bars.solve_pose(targets={"rocker": poses["rocker"]}).own]
    found += [bars.jacobian("a", ["c", "coupler"], poses=poses, method=m, strict=False) for m in METHODS]
    return [np.asarray(x) for x in found]


@pytest.mark.skipif(not unavailable(), reason="there is a GPU")
def test_without_a_gpu_the_error_says_so() -> None:
    with pytest.raises(DeviceError, match="is not there"):
        accumulated.on("cuda")(*accumulated_arguments(np.float64))
    with pytest.raises(DeviceError, match="is not there"):
        bs.objects.merge_similar(cga.line(rng.normal(size=(4, 3)), rng.normal(size=(4, 3))), 0.1, target="cuda")
    with pytest.raises(InputError, match="no target 'opencl'.*c, numba, cuda"):
        accumulated.on("opencl")


@pytest.mark.skipif(bool(unavailable()), reason=f"no GPU to run on: {unavailable()}")
@each_case
@each_dtype
def test_a_gpu_computes_the_bits_of_c(name: str, dtype: Any) -> None:
    tried, arguments = CASES[name]
    given = arguments(dtype)
    assert_same_bits(tried.on("cuda")(*given), tried.on("c")(*given))
