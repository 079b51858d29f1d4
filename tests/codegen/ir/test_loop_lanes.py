"""Several items at once: every lane has the bits of its item computed by itself."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from bladesmith import cga3d as cga
from bladesmith import codegen
from bladesmith.codegen import algorithm
from bladesmith.codegen.build import extension
from bladesmith.codegen.build.cpu_features import runs
from bladesmith.codegen.errors import AlgorithmError
from bladesmith.codegen.execute.items import CLoop
from bladesmith.codegen.language import InOut, Int, Out, Real, Rows, Vector, empty, sin, sqrt, zeros
from bladesmith.codegen.programs.algorithms import algorithm_extension
from bladesmith.codegen.targets.c.instances import BY_TAG, OF_KERNELS

from ...support.build.programs import warnings_of

pytestmark = pytest.mark.skipif(extension.compiler() is None, reason="no C compiler")
INSTANCES = ["f64_scalar", *(i.tag for i in OF_KERNELS if i.bits == 64 and runs(i))]
SHARED = ("weights", "count", "scale", "motor")


@codegen.kernel(cga.kind("motor"), cga.layout("euclidean"))
def rotated(m, x):
    """A direction moved."""
    return (m * x * ~m).grade(1)


@algorithm
def weighted(weights: Rows[2], x: Rows[1], sums: Out[Vector[3]]) -> Real:
    """Sums with weights, which decide what is added."""
    total = 0.0
    for j in range(len(weights)):
        if weights[j, 0] > 0.0:
            total += weights[j, 0] * x[j, 0]
        sums[j % 3] = total - weights[j, 1]
    return sqrt(total * total)


@algorithm
def several(
    weights: Rows[2], count: Int, scale: Real, motor: Vector[8], x: Rows[1], y: InOut[Vector[3]], z: Real
) -> tuple[Real, Real]:
    """Numbers that items share among those that differ: in sums, selections, calls, rows, functions and results."""
    sums = zeros(3)
    first = weighted(weights, x, sums)
    for k in range(3):
        y[k] = scale * y[k] + sums[k] if count > 2 else 1.0
    own = empty(5, 1)
    for k in range(5):
        own[k, 0] = weights[0, 1] if k % 2 == 0 else y[0] / scale
    second = weighted(weights, own, sums)
    moved = rotated(motor, y)
    turned = rotated(motor, (weights[0, 0], 2.0, scale))
    common = empty(5, 1)
    common[:] = scale
    all_share = zeros(3)
    decides = weighted(weights, common[1:5], all_share)  # has no lanes
    third = weighted(weights, common, all_share)
    if sqrt(decides) + sin(scale) > 0.1 and turned[0] < 100.0:  # nor has what kernels make of it: it may decide
        all_share[0] += 1.0
    third -= z
    for k in range(3):
        y[k] = -moved[k] + sin(scale) * turned[k] - z + all_share[k]
    return first + second * z + third, scale


@algorithm
def branching(x: Real) -> Real:
    """A path that differs."""
    if x > 0.0:
        return 1.0
    return 2.0


@algorithm
def indexed(x: Vector[3], k: Int) -> Real:
    """An index that differs."""
    return x[k]


@algorithm
def counted(x: Real) -> Int:
    """A result that is no real number."""
    return int(x)


def arguments(items: int) -> list[np.ndarray]:
    rng = np.random.default_rng(items)
    motor = (cga.translator([1.0, 2.0, 3.0]) * cga.rotor([1.0, 0.5, 0.2], 0.7)).as_kind("motor").values
    return [
        rng.normal(size=(4, 2)), np.array(3), np.array(0.7), motor, rng.normal(size=(items, 4, 1)),
        rng.normal(size=(items, 3)), rng.normal(size=items),
    ]  # fmt: skip


def function_of(declared, given=()):
    return declared.function_for(given or declared.declared_arguments())


@pytest.mark.parametrize("tag", INSTANCES)
@pytest.mark.parametrize("items", [1, 2, 3, 4, 9, 32])
def test_lanes_have_the_bits_of_single_items(tag: str, items: int) -> None:
    given = arguments(items)
    library = extension.load(algorithm_extension(function_of(several, given), (BY_TAG[tag],), SHARED))
    loop = CLoop(library, tag)
    arrays = [np.array(a, order="C") for a in given]
    arrays += [np.full(items + 1, np.nan), np.full(items + 1, np.nan)]
    strides, counts = (0, 0, 0, 0, 4, 3, 1, 1, 1), (4, 0, 0, 0, 4, 0, 0, 0, 0)
    run = loop.bind([loop.hold(a) for a in arrays], loop.integers(strides), loop.integers(counts))
    run(0, items)
    expected = several(*given)
    for found, value in zip((arrays[5], arrays[7][:items], arrays[8][:items]), expected, strict=True):
        assert found.tobytes() == np.ascontiguousarray(value).tobytes()
    assert np.isnan(arrays[7][items]) and np.isnan(arrays[8][items])  # nothing beyond the last item
    again = [np.array(a, order="C") for a in given] + [np.zeros(items), np.zeros(items)]
    run = loop.bind([loop.hold(a) for a in again], loop.integers(strides), loop.integers(counts))
    for begin in range(0, items, 3):  # parts of any size
        run(begin, min(begin + 3, items))
    assert again[5].tobytes() == arrays[5].tobytes()


@pytest.mark.parametrize(
    ("declared", "shared"), [(branching, ()), (indexed, ("x",)), (indexed, ()), (counted, ()), (several, ("count",))]
)
def test_paths_that_differ_are_refused(declared, shared) -> None:
    with pytest.raises(AlgorithmError, match="differs between items"):
        algorithm_extension(function_of(declared), (BY_TAG["f64_base"],), shared)


@pytest.mark.compiles
@pytest.mark.parametrize("tag", ["f64_scalar", "f64_base", "f64_v3", "f32_v3"])
def test_the_text_compiles_without_a_warning(tag: str, tmp_path: Path) -> None:
    made = algorithm_extension(function_of(several), (BY_TAG[tag],), SHARED)
    assert warnings_of([made.main()], tmp_path) == ""
