"""Algorithms that have every statement and expression of the language, for tests of what they compute."""

from __future__ import annotations

from typing import Any, NamedTuple

from bladesmith.codegen import algorithm
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
