"""Algorithms whose items part in every way that the language has: lanes have the bits of single items."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from bladesmith import cga3d as cga
from bladesmith import codegen
from bladesmith.codegen import algorithm
from bladesmith.codegen.build import extension
from bladesmith.codegen.errors import AlgorithmError
from bladesmith.codegen.language import (
    Bool,
    Bytes,
    InOut,
    Int,
    Ints32,
    IntVector,
    Out,
    Real,
    Reals,
    Vector,
    sqrt,
    zeros,
)  # fmt: skip
from bladesmith.codegen.targets.c.lanes.varying import Lanes

from ...support.targets.lanes import TAGS, by_lanes

pytestmark = [
    pytest.mark.compiles, pytest.mark.skipif(extension.compiler() is None, reason="no C compiler"),
]  # fmt: skip
ITEMS = 97


@codegen.kernel(cga.kind("motor"), cga.layout("euclidean"))
def rotated(m, x):
    """A direction moved."""
    return (m * x * ~m).grade(1)


@algorithm
def void_returns(x: InOut[Vector[3]], k: Int) -> None:
    """Returns of nothing, from a loop that counts down."""
    if k < 0:
        return
    for i in range(k, -1, -2):
        if i < 3:
            x[i] = -x[i]
        if i == 1 and x[0] > 0.0:
            return
    x[2] += 1.0


@algorithm
def two(x: Real, k: Int) -> tuple[Real, Int]:
    """Two results, of returns inside and behind a loop."""
    while k > 0:
        if x > 3.0:
            return x, -k
        x = x * 1.5 + 0.1
        k -= 1
    return min(x, 2.0), k


@algorithm
def one_name(k: Int, n: Int, x: InOut[Vector[9]]) -> Real:
    """A number that differs, and loops that do not, by one name."""
    total = 0.0
    for m in range(2):
        i = k - m
        x[max(i, 0)] += 1.0
    for i in range(n):
        total += x[i] * float(i)
    for i in range(9):
        if x[i] > 1.0:
            break
        total -= x[i]
    for i in range(n - 1, k, -1):
        total += x[i]
    return total


@algorithm
def nest(x: InOut[Vector[3]], k: Int, flag: Bool) -> tuple[Real, Bool]:
    """Loops in loops, jumps out of each, and calls under masks."""
    a, n = two(x[0], k)
    for j in range(3):
        while True:
            b, m = two(x[j], n + 3)
            if m < 0 or flag:
                break
            if b > 1.0:
                return b, not flag
            x[j] += 0.7
            if not x[j] < 50.0:
                break
        if flag ^ (a > 1.0):
            void_returns(x, k - j)
        _, n = two(a, j)
    return max(a, x[1]), flag or x[2] > 0.0


@algorithm
def kern(m: Vector[8], x: InOut[Vector[4]], k: Int) -> Real:
    """Kernels of what items share and of what they do not, for some items."""
    s = zeros(4)
    if k > 1:
        s[:] = rotated(m, x[:3])
        x[:] = rotated(m, s[1:])
    elif k == 1:
        x[:] = rotated(m, (1.0, 2.0, 3.0))
    else:
        rows = zeros(3, 4)
        rows[0][:] = x
        rows[2][:] = x
        for i in range(2):
            at = (i - k) % 3
            rows[at][:] = rotated(m, rows[at][1:])
        x[:] = rows[(2 * k) % 3]
    return s[0] - x[2]


@algorithm
def narrow(codes: Bytes, ids: Ints32, out: InOut[Ints32], x: Real) -> Int:
    """Integers of 8 and 32 bits."""
    n = 0
    for i in range(len(codes)):
        if codes[i] > 100 or x < 0.0:
            n += ids[i]
        else:
            out[i] = n - codes[i]
            continue
        if n > 5000:
            break
        out[i] += 1
    return n


@algorithm
def guard(x: Reals, n: Int, t: IntVector[4]) -> Real:
    """Elements that a condition guards: there are none beyond."""
    s = 0.0
    i = 0
    while i < n and i < len(x) and x[i] >= 0.0:
        s += sqrt(x[i]) if i % 2 == 0 else -x[i]
        i += 1 if not (i + 1 < len(x) and x[i + 1] == 0.0) else 2
    k = t[n % 4]
    v = x[k] if k >= 0 and k < len(x) else -1.0
    return s + (x[n - 1] if n > 0 and n <= len(x) else v)


@algorithm
def sort_of(x: InOut[Vector[6]], order: Out[IntVector[6]]) -> Int:
    """Sorting by insertion."""
    swaps = 0
    for i in range(6):
        order[i] = i
    for i in range(1, 6):
        j = i
        while j > 0 and x[j - 1] > x[j]:
            x[j - 1], x[j] = x[j], x[j - 1]
            order[j - 1], order[j] = order[j], order[j - 1]
            swaps += 1
            j -= 1
    return swaps


@algorithm
def recount(x: InOut[Vector[6]], k: Int, n: Int) -> None:
    """Loops of one name, from one place for all items and from places of their own."""
    for i in range(n):
        x[i] *= 2.0
    for i in range(k, 6):
        x[max(i, 0)] += 1.0
    for i in range(max(k, 0)):
        if x[i % 6] > 4.0:
            break
        x[i % 6] -= float(i)


def cases() -> dict[str, tuple[Any, tuple[Any, ...], tuple[str, ...]]]:
    """Algorithms, arguments, and what is shared."""
    rng = np.random.default_rng(1)
    x = rng.normal(scale=3.0, size=(ITEMS, 3))
    x[::10, 1], x[::11, 0] = np.nan, -0.0
    x6 = rng.normal(scale=3.0, size=(ITEMS, 6))
    x4, k, flag = np.column_stack([x, x[:, 0]]), rng.integers(-3, 7, ITEMS), rng.integers(0, 2, ITEMS).astype(bool)
    motor = (cga.translator([1.0, 2.0, 3.0]) * cga.rotor([1.0, 0.5, 0.2], 0.7)).as_kind("motor").values
    motors = np.tile(motor, (ITEMS, 1))
    codes = rng.integers(0, 256, (ITEMS, 7)).astype(np.uint8)
    ids, out = (rng.integers(-n, n, (ITEMS, 7)).astype(np.int32) for n in (3000, 9))
    some = np.abs(rng.normal(size=(ITEMS, 5)))
    some[::3, 2], some[::5, 1] = 0.0, -1.0
    counts, places = rng.integers(0, 9, ITEMS), np.tile(np.array([-5, 3, 9, 0]), (ITEMS, 1))
    some_nine = rng.normal(size=(ITEMS, 9))
    return {
        "returns": (void_returns, (x, k), ()), "returns, from one place": (void_returns, (x, np.array(4)), ("k",)),
        "two results": (two, (x[:, 0], k), ()),
        "nested": (nest, (x, k, flag), ()), "nested, one flag": (nest, (x, k, np.array(True)), ("flag",)),
        "nested, one count": (nest, (x, np.array(2), flag), ("k",)),
        "kernels": (kern, (motors, x4, k), ()), "kernels, one motor": (kern, (motor, x4, k), ("m",)),
        "kernels, one way": (kern, (motor, x4, np.array(2)), ("m", "k")),
        "narrow": (narrow, (codes, ids, out, x[:, 0]), ()),
        "narrow, one table": (narrow, (codes[0], ids[0], out, x[:, 0]), ("codes", "ids")),
        "narrow, one number": (narrow, (codes[0], ids, out, np.array(0.5)), ("codes", "x")),
        "guarded": (guard, (some, counts, places), ()),
        "guarded, one row": (guard, (some[0], counts, places[0]), ("x", "t")),
        "guarded, one count": (guard, (some, np.array(3), places), ("n",)),
        "counting": (recount, (x6, k, np.array(5)), ("n",)),
        "counting, one start": (recount, (x6, np.array(2), k), ("k",)),
        "one name": (one_name, (counts % 9, np.array(7), some_nine), ("n",)),
        "one name, parted": (one_name, (counts % 9, counts, some_nine), ()),
        "sorting": (sort_of, (rng.normal(size=(ITEMS, 6)),), ()),
    }  # fmt: skip


@pytest.mark.parametrize("name", cases())
def test_lanes_have_the_bits_of_single_items(name: str) -> None:
    declared, given, shared = cases()[name]
    found = declared(*given)
    expected = [np.asarray(e) for e in (found if isinstance(found, (tuple, list)) else [found]) if e is not None]
    for tag in TAGS:
        for a, b in zip(by_lanes(declared, given, ITEMS, tag, shared), expected, strict=True):
            own = np.asarray(a).reshape(b.shape).astype(b.dtype)
            np.testing.assert_array_equal(own, b, err_msg=tag)
            if b.dtype.kind == "f":
                known = ~np.isnan(b)
                np.testing.assert_array_equal(np.signbit(own[known]), np.signbit(b[known]), err_msg=tag)


@algorithm
def grow(p: IntVector[3], x: InOut[Vector[2]]) -> None:
    """A number of steps that is behind another number."""
    for _ in range(p[1]):
        x[0] = x[0] * 1.5 + 0.1


@algorithm
def grow_all(p: InOut[IntVector[4]], x: InOut[Vector[2]]) -> None:
    """The same of a part, and a number that changes."""
    for _ in range(p[2]):
        grow(p[1:4], x)
        p[0] += 1


def test_elements_that_items_share_part_none() -> None:
    root = grow_all.instance()
    assert any(paths.divergent for paths in Lanes(root, ()).paths.values())
    assert not any(paths.divergent for paths in Lanes(root, (), {"p": [2]}).paths.values())
    with pytest.raises(AlgorithmError, match="grow_all changes an element of p that items share"):
        Lanes(root, (), {"p": [0, 2]})


def test_elements_that_items_share_leave_the_bits() -> None:
    rng = np.random.default_rng(4)
    p, x = rng.integers(0, 9, (ITEMS, 4)), rng.normal(size=(ITEMS, 2))
    p[:, 2] = 3
    expected = grow_all(p, x)
    for tag in TAGS:
        for a, b in zip(by_lanes(grow_all, (p, x), ITEMS, tag, (), {"p": [2]}), expected, strict=True):
            np.testing.assert_array_equal(a, b, err_msg=tag)
