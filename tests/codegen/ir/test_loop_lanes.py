"""Several items at once: every lane has the bits of its item computed by itself."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from bladesmith import cga3d as cga
from bladesmith import codegen
from bladesmith.codegen import algorithm
from bladesmith.codegen.build import extension
from bladesmith.codegen.errors import AlgorithmError
from bladesmith.codegen.execute.items import CLoop
from bladesmith.codegen.language import (
    Bool,
    InOut,
    Int,
    IntVector,
    Out,
    Real,
    Reals,
    Rows,
    Vector,
    empty,
    sin,
    sqrt,
    zeros,
)
from bladesmith.codegen.programs.algorithms import algorithm_extension
from bladesmith.codegen.targets.c.instances import BY_TAG

from ...support.build.programs import warnings_of
from ...support.targets.lanes import TAGS, by_lanes

pytestmark = pytest.mark.skipif(extension.compiler() is None, reason="no C compiler")
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
def halve(x: InOut[Vector[3]], k: Int) -> Bool:
    """An element that differs, of an array of the caller, and a return before the end."""
    if x[k] > 8.0:
        return True
    x[k] *= 0.5
    return False


@algorithm
def parting(
    table: IntVector[4], limits: Rows[1], x: InOut[Vector[3]], n: InOut[IntVector[2]], way: Int
) -> tuple[Real, Int, Bool]:
    """All that parts items: branches, loops that end at different times, jumps, indices, and parts of arrays."""
    total = 0.0
    found = False
    steps = 0
    for k in range(way, 3):
        if x[k] < 0.0:
            continue
        while x[k] > 1.0 and steps < 20:
            steps += 1
            stops = halve(x, table[k])
            if stops:
                found = True
                break
            total += limits[k, 0] if x[k] < limits[k, 0] else x[table[way]]
        for j in range(table[k]):
            n[j % 2] += j
            if n[0] > 40:
                return total, -steps, found
    if way > 0 and limits[way - 1, 0] < x[way - 1]:
        n[1] = n[1] << way
    own = zeros(2)
    own[:] = x[way % 2 : way % 2 + 2]
    return total + own[0] / own[1], steps, found or n[0] > 3


@algorithm
def add_halves(to: InOut[Reals], other: InOut[Reals], x: Reals) -> None:
    """Parts of one array, of which two may be the same."""
    for i in range(len(x)):
        other[i] -= 0.5 * x[i]
        to[i] = x[i] + other[i]


@algorithm
def stacked(x: InOut[Vector[3]], way: Int) -> Real:
    """Rows of a stack whose height differs between items, and that one call gets twice."""
    c = zeros(4, 3)
    height = way % 3
    c[height][:] = x
    while height > 0 or x[0] > 4.0:
        add_halves(c[height], c[height + 1], c[height])
        if height == 0:
            x[0] *= 0.25
            continue
        height -= 1
        add_halves(c[height], c[height], c[height + 1])
    for i in range(3):
        x[i] = c[way % 3, i]
    return c[0, 1] - c[1, 2]


@algorithm
def common(x: Real, sums: InOut[Vector[2]]) -> Real:
    """What all items share, changed by some."""
    if x > 0.0:
        sums[0] += 1.0
    return x


@algorithm
def sums_of_two(a: Rows[2], b: Rows[2], x: Rows[1]) -> Real:
    """Rows that all items share, and others, for one algorithm."""
    sums = zeros(3)
    first = weighted(a, x, sums)
    second = weighted(b, x, sums)
    return first + second


@algorithm
def rows_of_items(weights: Rows[2], x: Rows[1], k: Int) -> Real:
    """Rows that begin where each item says."""
    sums = zeros(3)
    return weighted(weights, x[k:], sums)


def arguments(items: int) -> list[np.ndarray]:
    rng = np.random.default_rng(items)
    motor = (cga.translator([1.0, 2.0, 3.0]) * cga.rotor([1.0, 0.5, 0.2], 0.7)).as_kind("motor").values
    return [
        rng.normal(size=(4, 2)), np.array(3), np.array(0.7), motor, rng.normal(size=(items, 4, 1)),
        rng.normal(size=(items, 3)), rng.normal(size=items),
    ]  # fmt: skip


def function_of(declared, given=()):
    return declared.function_for(given or declared.declared_arguments())


@pytest.mark.parametrize("tag", TAGS)
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


@pytest.mark.parametrize("tag", TAGS)
@pytest.mark.parametrize("shared", [("table", "limits"), ("table", "limits", "way"), ()])
def test_items_that_part_have_the_bits_of_single_items(tag: str, shared: tuple[str, ...]) -> None:
    items, rng = 203, np.random.default_rng(2)
    table, limits = np.array([2, 0, 1, 2]), rng.uniform(0.0, 4.0, (4, 1))
    x, n, way = rng.normal(scale=9.0, size=(items, 3)), rng.integers(-3, 45, (items, 2)), rng.integers(0, 4, items)
    x[::7, 1] = np.nan
    given: list[np.ndarray] = [table, limits, x, n, way]
    if "way" in shared:
        given[4] = np.array(1)
    expected = parting(*given)
    if not shared:
        given[:2] = np.tile(table, (items, 1)), np.tile(limits, (items, 1, 1))
    for found, value in zip(by_lanes(parting, tuple(given), items, tag, shared), expected, strict=True):
        np.testing.assert_array_equal(found.reshape(value.shape), value)
    for found, value in zip(by_lanes(parting, tuple(given), items, tag, shared)[:1], expected[:1], strict=True):
        assert found.tobytes() == value.tobytes()


@pytest.mark.parametrize("tag", TAGS)
def test_parts_of_arrays_that_begin_where_each_item_says(tag: str) -> None:
    rng = np.random.default_rng(4)
    given = rng.normal(scale=9.0, size=(101, 3)), rng.integers(0, 9, 101)
    for found, value in zip(by_lanes(stacked, given, 101, tag), stacked(*given), strict=True):
        assert found.tobytes() == value.tobytes()


@pytest.mark.parametrize(
    ("declared", "shared", "match"), [
        (common, ("sums",), "said to be shared, but differs"), (sums_of_two, ("a",), "shared by items, and differs"),
        (rows_of_items, ("weights",), "has no fixed length"),
    ]
)  # fmt: skip
def test_what_items_cannot_share_is_refused(declared, shared, match) -> None:
    with pytest.raises(AlgorithmError, match=match):
        algorithm_extension(function_of(declared), (BY_TAG["f64_base"],), shared)


@pytest.mark.compiles
@pytest.mark.parametrize("tag", ["f64_scalar", "f64_base", "f64_v3", "f32_v3"])
@pytest.mark.parametrize(("declared", "shared"), [(several, SHARED), (parting, ("table", "limits")), (parting, ())])
def test_the_text_compiles_without_a_warning(declared, shared, tag: str, tmp_path: Path) -> None:
    made = algorithm_extension(function_of(declared), (BY_TAG[tag],), shared)
    assert warnings_of([made.main()], tmp_path) == ""
