"""What algorithms compute: C and numba against the text run as Python, bit for bit, in both precisions."""

from __future__ import annotations

import subprocess
from pathlib import Path
from typing import Any, NamedTuple

import mpmath
import numpy as np
import pytest

from bladesmith.codegen import algorithm
from bladesmith.codegen.build import extension
from bladesmith.codegen.language import (
    INFINITY,
    Bool,
    InOut,
    Int,
    IntRows,
    Ints,
    IntVector,
    Matrix,
    Out,
    Real,
    Reals,
    Rows,
    Static,
    Vector,
    atan2,
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
    unrolled,
    zeros,
)  # fmt: skip
from bladesmith.codegen.programs.algorithms import algorithm_extension

from ...support.targets.algorithms import needs_compiler, references, same

SCALE = 3
WEIGHTS = (0.5, 0.25)


@algorithm
def arithmetic(x: Vector[4], n: Int, m: Int, flag: Bool, out: Out[Vector[8]]) -> tuple[Int, Int, Real]:
    """Every operator, precedence, selections, and chained comparisons."""
    a, b, c, d = x[0], x[1], x[2], x[3]
    out[0] = a - (b - c) - d * (a + b) / (c - -d)
    out[1] = -a * -(b + c) - (-(d + a))
    out[2] = a if a < b <= c or not (c > d and flag) else -b
    out[3] = min(a, b) - max(c, d) + abs(a - b)
    out[4] = n / m + float(n) * SCALE + n if n > m else float(n)
    out[5] = (a if flag else b) * (c if a != c else d)
    out[6] = 1.0 if a == b else (2.0 if (a < b) and (c < d or flag) else 3.0)
    out[7] = a / (b * c) / d
    return n // m - 7 // 2, n % m + min(n, m) * abs(m), (int(a * 10.0) if abs(a) < 1e6 else -1) + 0.5


@algorithm
def whole(a: Int, b: Int, out: Out[IntVector[9]]) -> None:
    """Integers that may leave 64 bits."""
    out[:] = (a + b, a - b, a * b, -a, abs(a), a // b, a % b, a * 2 // 2, a // -1)


@algorithm
def control(x: Rows[2], limit: Real, found: Out[IntVector[3]]) -> Real:
    """Loops that are left, skipped and nested; bounds that change while the loop runs."""
    total = 0.0
    n = len(x)
    for i in range(n):
        if not x[i, 0] < limit:
            continue
        for j in range(n - 1, i, -2):
            if x[j, 1] > limit * 4.0:
                break
            total += x[i, 0] * x[j, 1]
            found[0] += 1
        row = x[i]
        total -= row[1]
    k = 0
    stop = 5
    for j in range(stop):
        stop -= 1
        k += stop * j
    found[1] = k
    steps = 0
    while True:
        steps += 1
        if steps * steps > n + 10:
            break
        if steps == 100:
            return INFINITY
    found[2] = steps
    return total


@algorithm
def arrays(a: InOut[Matrix[3, 3]], b: InOut[Vector[3]], indices: IntRows[1]) -> Real:
    """Rows, parts, swaps, fills, and local arrays that are new in every iteration."""
    for i in range(len(a)):
        square = zeros(3)
        partial = empty(2)
        order = int_zeros(2)
        for j in range(3):
            square[j] += a[i, j] * a[i, j]
        partial[:] = square[1:3]
        order[0] = i
        b[i] = partial[0] - partial[1] * float(order[0] + order[1])
    a[0, 0], a[1, 1] = a[1, 1], a[0, 0]
    x, y = b[0], b[1]
    x, y = y - x, x
    b[:2] = (x, y)
    third = a[2]
    third[:] = 0.25
    a[1][:] = b
    last = 0.0
    for k in range(len(indices)):
        last += b[indices[k, 0]]
        row = a[k]
        row[-1] = last
    return last + third[0]


@algorithm
def last_row(rows: Matrix, place: Ints) -> Real:
    """The last of some rows, of any length and number."""
    return rows[place[0] - 1][0]


@algorithm
def numbers(x: InOut[Reals], order: InOut[Ints], rows: Rows[2], unused: Ints) -> Real:
    """Single numbers, as many as there are at run time; some arrays whose number nothing asks for."""
    for i in range(len(x)):
        x[i] += rows[order[i]][1] - rows[order[i], 0]
        order[i] = len(order) - order[i]
    return last_row(rows, order)


@algorithm
def parts(x: InOut[Reals], work: InOut[Rows[2]], fixed: Vector[5], integers: IntVector[2], out: Out[Vector[4]]) -> Real:
    """Parts of arrays that begin where a number says, of any array or of one of fixed length."""
    k = integers[1]
    out[1:4] = x[integers[0] : integers[0] + 3]
    x[k : k + 3] = x[:3]
    out[0:2] = fixed[2 * k : 2 * k + 2]
    some = work[k : k + 2]
    some[1, 0] += some[0][1]
    return out[0] + sqrt(some[1, 0] * some[1, 0])


@algorithm
def ends_of_rows(rows: Rows[2]) -> Real:
    """The first number of rows, the last one, and how many rows there are."""
    return rows[0, 0] - rows[len(rows) - 1, 1] / 3.0 + float(len(rows))


@algorithm
def tails(x: Reals, table: InOut[Rows[3]], at: Int) -> Real:
    """What is behind a place: numbers as rows, an odd one left out, and rows that are changed."""
    rest = x[at:]
    rows = table[1:]
    rows[0, 2] = float(len(rest))
    return ends_of_rows(x[at:]) + 2.0 * ends_of_rows(rest[1:])


@algorithm
def weighted(x: Vector, kind: Static, weights: Static) -> Real:
    """Static branches and loops over static tuples; any size."""
    total = 0.0
    for w in weights:
        if kind == "sum":
            total += w * x[0]
        elif kind == "last" and len(x) > 1:
            last = len(x) - 1
            total += w * x[last]
        else:
            total -= w
    for i, j in ((0, 1), (1, 0)):
        total += float(10 * i + j)
    return total


@algorithm
def pair(x: Real, y: Real, flag: Bool) -> tuple[Real, Int, Bool]:
    """Several results of several types."""
    return x - y, 7 if flag else -7, x < y and not flag


@algorithm
def weighted_pair(x: Real, y: Real) -> Real:
    """Calls: of any size from tuples, with static values, with several results."""
    a, n, is_less = pair(x, y, True)
    total = weighted((x, y, a), "last", WEIGHTS)
    other = weighted((y,), "sum", (2.0,))
    return total - other + float(n) + (1.0 if is_less else 0.0)


@algorithm
def elementary(x: Real, y: Real) -> Real:
    """Functions of the package."""
    t = sin(x) * cos(y) + exp(-x * x) + log(1.0 + y * y)
    return sqrt(t * t + atan2(y, x) * epsilon()) + weighted_pair(x, y)


@algorithm
def aliases(a: InOut[Matrix[3, 2]], b: InOut[Vector[4]], out: Out[Vector[6]]) -> Real:
    """One storage under two names, and values that are computed before any is assigned."""
    b[:] = (b[3], b[0], b[1], b[2])
    b[1:4] = b[0:3]
    whole = b
    whole[0], b[1] = b[1], whole[0]
    p, q = a[0], a[1]
    for i in range(2):
        p = a[i]
        q = a[i + 1]
        p, q = q, p
        out[2 * i] = p[0] - q[0]
        p[1], q[1] = q[1], a[i + 1, 1]
    x = y = b[2] + 1.0
    x += y
    out[5] = out[1] = x * 0.5
    k, out[3] = 2, b[3]
    out[k + 2], k = float(k), 5
    return x - y + float(k)


@algorithm
def kind_of_static(x: Real, value: Static) -> Real:
    """1, 1.0 and True are three values."""
    if value is True:
        return x
    total = 0.5
    if value == 1:
        for k in (value, value + 1):
            if k == 2:
                return total + 7 / (2 * k) * x
            total += k
    return total


class Kind(NamedTuple):
    """A static value that holds an algorithm."""

    label: str
    steps: int
    measure: Any


KIND = Kind("weighed", 3, pair)


@algorithm
def bitwise(x: Vector[6], n: Int, m: Int, flag: Bool, out: Out[IntVector[4]]) -> tuple[Real, Bool]:
    """Integers and truth values bit by bit, loops that are written out, and the largest number."""
    order = int_empty(6)
    for i in unrolled(6):
        order[i] = (i + n) & 3
    out[0] = (n & m) + (n | m) * 2 - (n ^ m) // 3
    out[1] = 1 if n & 1 == 1 | m ^ n else 0
    is_odd = (n & 1 == 1) ^ flag
    out[2] = 1 if is_odd | (x[0] < x[1]) & (x[2] < 0.0) else 0
    out[3] = 0
    for i in unrolled(1, 20):
        out[3] += i * order[i & 3]
    return min(largest(), x[order[2]] * 1e308) / 2.0, is_odd and not (flag ^ (x[3] < 0.0))


@algorithm
def with_kind(x: Vector[3], kind: Static) -> Real:
    """An algorithm and a number of a static value."""
    total = 0.0
    for i in unrolled(kind.steps):
        a, n, is_less = kind.measure(x[i], float(i), True)
        total += a * float(n) if not is_less else 0.5
    return total


rng = np.random.default_rng(5)
SPECIAL = np.array([0.0, -0.0, 1.0, -1.0, np.inf, -np.inf, np.nan, 1e-310, 1e300])


CASES: list[tuple[Any, tuple[Any, ...], tuple[Any, ...]]] = [
    (arithmetic, (rng.normal(size=(40, 4)), rng.integers(-9, 9, 40), rng.integers(1, 9, 40), rng.random(40) < 0.5), ()),
    (arithmetic, (rng.choice(SPECIAL, (80, 4)), np.arange(80) - 40, np.full(80, -7), rng.random(80) < 0.5), ()),
    (control, (rng.normal(size=(12, 9, 2)), rng.normal(size=12)), ()),
    (arrays, (rng.normal(size=(9, 3, 3)), rng.normal(size=(9, 3)), np.array([[2], [0], [1]])), ()),
    (
        numbers,
        (rng.normal(size=(9, 4)), np.tile([2, 0, 1, 2], (9, 1)), rng.normal(size=(9, 4, 2)), np.zeros((9, 1), int)),
        (),
    ),
    (
        parts,
        (
            rng.normal(size=(9, 7)),
            rng.normal(size=(9, 3, 2)),
            rng.normal(size=(9, 5)),
            np.stack([rng.integers(0, 5, 9), rng.integers(0, 2, 9)], 1),
        ),
        (),
    ),
    (tails, (rng.normal(size=(9, 8)), rng.normal(size=(9, 2, 3)), rng.integers(0, 4, 9)), ()),
    (elementary, (rng.normal(size=50), rng.normal(size=50)), ()),
    (pair, (rng.normal(size=20), rng.normal(size=20), np.arange(20) % 2 == 0), ()),
    (weighted, (rng.normal(size=(7, 4)),), ("last", WEIGHTS)),
    (weighted, (rng.normal(size=(7, 1)),), ("none", (1.0, 2.0, 4.0))),
    (aliases, (rng.normal(size=(6, 3, 2)), rng.normal(size=(6, 4))), ()),
    (kind_of_static, (rng.normal(size=3),), (1,)),
    (kind_of_static, (rng.normal(size=3),), (1.0,)),
    (kind_of_static, (rng.normal(size=3),), (True,)),
    (
        bitwise,
        (rng.choice(SPECIAL, (60, 6)), rng.integers(-99, 99, 60), rng.integers(-99, 99, 60), rng.random(60) < 0.5),
        (),
    ),
    (with_kind, (rng.normal(size=(5, 3)),), (KIND,)),
]
#: Without an array of real numbers an algorithm runs in double precision.
SINGLE = [case for case in CASES if case[0] not in (elementary, pair, kind_of_static)]
IDS = [f"{case[0].name}{k}" for k, case in enumerate(CASES)]


@needs_compiler
@pytest.mark.parametrize("case", CASES, ids=IDS)
def test_c_has_the_bits_of_the_text(case: Any) -> None:
    function, arguments, static = case
    same(function(*arguments, *static), references(function, arguments, static, np.float64))


@needs_compiler
@pytest.mark.skipif(np.lib.NumpyVersion(np.__version__) < "2.0.0", reason="NumPy 1 takes numbers of Python for doubles")
@pytest.mark.parametrize("case", SINGLE, ids=[case[0].name for case in SINGLE])
def test_c_in_single_precision_has_the_bits_of_the_text(case: Any) -> None:
    function, arguments, static = case
    with np.errstate(over="ignore"):
        single = tuple(a.astype(np.float32) if a.dtype.kind == "f" else a for a in arguments)
    found, expected = function(*single, *static), references(function, single, static, np.float32)
    if function is arithmetic:  # quotients of integers are of single precision in C alone
        found[0][:, 4] = expected[0][:, 4] = 0.0
    same(found, expected)


@needs_compiler
@pytest.mark.parametrize("case", CASES, ids=IDS)
def test_c_compiles_without_a_warning(case: Any, tmp_path: Path) -> None:
    function, arguments, static = case
    program = algorithm_extension(function.function_for((*arguments, *static)))
    for name, text in {**program.headers, "main.c": program.source}.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    command = [*extension.required_compiler().command, "-std=c11", "-O1", "-Wall", "-Wextra", "-Werror", "-c", "main.c"]
    subprocess.run(command, cwd=tmp_path, check=True)


@pytest.mark.compiles
@pytest.mark.peers
@pytest.mark.parametrize("case", CASES, ids=IDS)
def test_numba_has_the_bits_of_the_text(case: Any) -> None:
    function, arguments, static = case
    same(function.on("numba")(*arguments, *static), references(function, arguments, static, np.float64))


def test_fifty_digits_from_the_same_text() -> None:
    context = mpmath.mp.clone()
    context.dps = 50
    x, y = context.mpf(1) / 3, context.mpf(2) / 7
    found = elementary.reference(x, y, numbers=context)
    t = context.sin(x) * context.cos(y) + context.exp(-x * x) + context.log(1 + y * y)
    rest = context.mpf(3) / 4 * (x - y) - 2 * y + 7
    expected = context.sqrt(t * t + context.atan2(y, x) * context.eps) + rest
    assert abs(found - expected) < context.mpf(10) ** -48
    double = elementary.reference(float(x), float(y))
    assert abs(float(found) - double) < 1e-14


@algorithm
def beyond(x: Real) -> tuple[Real, Real]:
    """Functions of a number that real numbers do not have there."""
    return sqrt(x), log(x)


def test_fifty_digits_are_real_numbers() -> None:
    for value in beyond.reference(-2.0, numbers=mpmath.mp):
        assert mpmath.isnan(value) and not isinstance(value, mpmath.mpc)


@algorithm
def weighted_sum(x: Vector[3], rows: Rows[2], y: Real) -> Real:
    """Arrays that all items share."""
    total = y
    for k in range(3):
        total += x[k]
    for i in range(len(rows)):
        total += rows[i, 0] * rows[i, 1]
    return total


@needs_compiler
@pytest.mark.parametrize("items", [1, 2, 3, 6])
def test_shared_arrays_may_have_as_many_numbers_as_there_are_items(items: int) -> None:
    x, rows, y = np.array([1.0, 2.0, 4.0]), np.arange(6.0).reshape(3, 2), np.arange(float(items))
    expected = y + 7.0 + (rows[:, 0] * rows[:, 1]).sum()
    assert np.array_equal(weighted_sum(x, rows, y), expected)
    assert np.array_equal(weighted_sum(x[None], rows[None], y), expected)
    assert np.array_equal(weighted_sum(np.tile(x, (items, 1)), rows, y), expected)
    unaligned = np.frombuffer(b"x" + x.tobytes(), np.float64, 3, 1)
    assert np.array_equal(weighted_sum(unaligned, rows, y), expected)


#: Those next to the ends of 64 bits, and some between.
INTEGERS = (-(2**63), -(2**63) + 1, -(2**40), -7, -1, 0, 1, 2, 7, 2**40 + 1, 2**63 - 2, 2**63 - 1)


@needs_compiler
@pytest.mark.parametrize("target", ["c", pytest.param("numba", marks=pytest.mark.peers)])
def test_integers_wrap_to_64_bits(target) -> None:
    a, b = (grid.ravel() for grid in np.meshgrid(np.array(INTEGERS), np.array(INTEGERS)))

    def wrapped(value: int) -> int:
        return (value + 2**63) % 2**64 - 2**63

    for m, n, found in zip(a.tolist(), b.tolist(), whole.on(target)(a, b).tolist(), strict=True):
        expected = [m + n, m - n, m * n, -m, abs(m), m // n if n else 0, m % n if n else 0, wrapped(2 * m) // 2, -m]
        assert found == [wrapped(value) for value in expected], (m, n)
