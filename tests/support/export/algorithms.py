"""Algorithms to export: every statement and every kind of argument, with inputs and what C makes of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from bladesmith import cga3d as cga
from bladesmith import codegen
from bladesmith.codegen import algorithm
from bladesmith.codegen.algorithm_api.compiled import CompiledAlgorithm
from bladesmith.codegen.ir.loops.nodes import Function
from bladesmith.codegen.ir.loops.types import ArrayType
from bladesmith.codegen.language import (
    Bool,
    Bytes,
    InOut,
    Int,
    Ints,
    Ints32,
    IntVector,
    Matrix,
    Out,
    Real,
    Reals,
    Rows,
    Vector,
    cos,
    empty,
    epsilon,
    exp,
    int_empty,
    int_zeros,
    largest,
    log,
    sin,
    sqrt,
    zeros,
)

ITEMS = 40


@codegen.kernel(cga.kind("motor"), cga.kind("point"))
def move(m: Any, x: Any) -> Any:
    return m * x * ~m


@algorithm
def total(rows: Rows[3], start: Int) -> tuple[Real, Int, Bool]:
    """Of all rows from one on; how many there are; whether there is one."""
    found = 0.0
    for i in range(len(rows)):
        found += rows[i, 0] - rows[i, 1] * rows[i, 2]
    return found, len(rows) + start, len(rows) > 0


@algorithm
def shift(source: Vector[3], target: InOut[Vector[3]], by: Real) -> Real:
    """Three numbers added to three others."""
    for i in range(3):
        target[i] += source[i] * by
    return target[0]


@algorithm
def exchange(a: InOut[Vector[2]], b: InOut[Vector[2]], k: Int) -> None:
    """Exchange two parts of an array, turned round."""
    a[0], a[1], b[0], b[1] = b[1 - k], b[k], a[k], a[1 - k]


@algorithm
def spread(target: InOut[Reals], source: Reals) -> None:
    """Numbers of two parts whose lengths are known at run time."""
    for i in range(min(len(target), len(source))):
        target[i] -= 0.5 * source[i]


@algorithm
def sign_of(x: Real) -> Int:
    """Sign; leaves a loop without an end."""
    k = 0
    while True:
        k += 1
        if x < 0.0:
            return -1
        if k > 2:
            break
    return 1 if x > 0.0 else 0


@algorithm
def everything(
    points: Rows[3], order: InOut[Ints], flags: InOut[Bytes], stored: InOut[Ints32], work: InOut[Vector[8]],
    kind: Int, is_far: Bool, D_x: Real, out: Out[Matrix[2, 3]], counts: Out[IntVector[4]],
) -> tuple[Real, Int, Bool]:  # fmt: skip
    """Loops that are left, skipped, nested and counted down; parts of arrays; integers of all sizes."""
    match = empty(2, 3)
    used = int_zeros(3)
    last = int_empty(2)
    match[0][:] = (D_x, -D_x, 0.1)
    match[1][:] = points[1]
    last[1] = -7
    for i in range(len(points) - 1, 0, -2):
        if points[i, 0] < 0.0:
            continue
        local = zeros(2)
        for j in range(0, 8, 3):
            if j > kind:
                break
            local[j % 2] += work[j] / 3.0
            used[j // 3] += 1
        match[i % 2, 1] = local[0] - local[1]
        flags[i] = flags[i] + 200
        stored[i] = stored[i] * 65537 - i
    type, many, has = total(points[kind % 3 :], kind)
    work[7] = shift(work[0:3], work[3:6], work[2])
    exchange(work[4:6], work[2:4], order[0] % 2)
    spread(work[5:8], work[0:5])
    moved = shift(match[1], match[0], work[1])
    steps = 0
    while steps < 5 and not (type > 1e3 or is_far):
        type = type * 2.0 + cos(type) - sin(D_x)
        steps += sign_of(D_x) * sign_of(D_x)
        if steps == 0:
            steps = 9
    for i in range(len(order)):
        order[i] = (order[i] // 3 - order[i] % -4) * (kind - 2) + abs(-i) + min(kind, i) - max(-kind, last[1])
    counts[:] = (many, steps, used[0] - used[1] + used[2], int(moved * 10.0) if abs(moved) < 1e9 else -1)
    out[0][:] = match[0]
    out[1][:] = (sqrt(abs(type)), log(abs(D_x) + epsilon()), exp(-abs(moved)) if is_far else largest())
    return type - float(steps), order[0], has and not is_far


@algorithm
def move_again(m: Vector[8], x: InOut[Vector[5]], n: Int) -> Int:
    """Move a point n times."""
    for _ in range(n):
        x[:] = move(m, x)
    return n


@algorithm
def digits(n: Int, k: Int, x: Real) -> tuple[Int, Int, Real]:
    """Operations on bits, of small integers."""
    mixed = ((n << 3) ^ (k & 255)) | 16
    for i in range(4):
        mixed = (mixed >> 1) + (mixed & (i + 1)) * 3 - (n // 7) + n % 5
    return mixed, abs(min(n, k)) + max(n, 3), x * float(mixed)


@algorithm
def wrapping(seed: InOut[Ints], x: Real) -> tuple[Int, Real]:
    """Integers that leave 64 bits."""
    for i in range(len(seed)):
        seed[i] = (seed[i] * 6364136223846793005 + 1442695040888963407) ^ (seed[i] >> 17)
        seed[i] = -seed[i] - (seed[i] << 5) - abs(seed[i])
    return (seed[0] >> 40) // -3 + seed[1] % 1000, x * float(seed[0] >> 12)


def arguments(name: str) -> tuple[np.ndarray[Any, Any], ...]:
    """Items of one of these algorithms."""
    rng = np.random.default_rng(3)
    if name == "everything":
        points = rng.normal(size=(ITEMS, 6, 3))
        points[1, 2, 1], points[2, 1, 2], points[3, 1, 1] = np.nan, np.inf, -0.0
        numbers = rng.normal(size=ITEMS) * 10.0 ** rng.integers(-3, 9, ITEMS)
        return (
            points, rng.integers(-50, 50, (ITEMS, 4)), rng.integers(0, 256, (ITEMS, 6)).astype(np.uint8),
            rng.integers(-(2**31), 2**31, (ITEMS, 6)).astype(np.int32), rng.normal(size=(ITEMS, 8)),
            rng.integers(0, 9, ITEMS), rng.integers(0, 2, ITEMS).astype(bool), numbers,
        )  # fmt: skip
    if name == "move_again":
        return rng.normal(size=(ITEMS, 8)), rng.normal(size=(ITEMS, 5)), rng.integers(0, 4, ITEMS)
    if name == "digits":
        return rng.integers(-(10**6), 10**6, ITEMS), rng.integers(-300, 300, ITEMS), rng.normal(size=ITEMS)
    return rng.integers(-(2**53), 2**53, (ITEMS, 3)), rng.normal(size=ITEMS)


@dataclass(frozen=True)
class AlgorithmCase:
    """An algorithm on items: the numbers of each as a row of float64, and those that C gives.

    ``sizes``: how many numbers each parameter has.
    """

    name: str
    function: Function
    sizes: tuple[int, ...]
    inputs: np.ndarray[Any, Any]
    results: np.ndarray[Any, Any]


def algorithm_case(given: CompiledAlgorithm, items: Sequence[np.ndarray[Any, Any]]) -> AlgorithmCase:
    """What to give to an exported algorithm, and to expect of it."""
    function, count = given.function_for(given.declared_arguments()), len(items[0])
    found = given(*items)
    rest, sizes, rows = iter(items), [], []
    for p in function.parameters:
        size = p.type.size if isinstance(p.type, ArrayType) else 1
        numbers = np.zeros((count, size)) if p.access == "out" else next(rest).astype(np.float64).reshape(count, -1)
        sizes.append(numbers.shape[1])
        rows.append(numbers)
    results = [np.asarray(r).astype(np.float64).reshape(count, -1) for r in found]
    return AlgorithmCase(
        function.name, function, tuple(sizes), np.concatenate(rows, axis=1), np.concatenate(results, axis=1)
    )


def assert_same_results(case: AlgorithmCase, folder: Path) -> None:
    """The bits of the file of results, but for those of a NaN."""
    found = np.fromfile(folder / "results.bin").reshape(case.results.shape)
    same = (found.view(np.uint64) == case.results.view(np.uint64)) | (np.isnan(found) & np.isnan(case.results))
    assert same.all(), f"{case.name}: {np.argwhere(~same)[:5].tolist()}: {found[~same][:5]}, {case.results[~same][:5]}"
