"""Algorithms to reverse: every operator, loops that are left, arrays in place, calls, rows of any number."""

from __future__ import annotations

from bladesmith import cga3d as cga
from bladesmith import codegen
from bladesmith.codegen import algorithm
from bladesmith.codegen.algorithms import dense
from bladesmith.codegen.language import (
    InOut,
    Int,
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
    exp,
    int_zeros,
    log,
    sin,
    sqrt,
    zeros,
)  # fmt: skip

from ..export.algorithms import move


@algorithm
def operators(x: Vector[3], y: Real, out: Out[Vector[2]]) -> Real:
    """Every operator and function, numbers that are replaced, and branches."""
    a = sin(x[0]) * cos(y) - exp(-x[1] * x[1]) / (2.0 + y * y)
    a = a * a - (x[2] - a) / (1.0 + abs(a))
    b = atan2(x[0], y) + log(1.0 + y * y) - sqrt(3.0 + x[2] * x[2])
    b += min(x[0], x[1]) * max(a, y)
    out[0] = b if a < b else -b * x[0]
    if x[0] < x[1]:
        out[1] = x[0] * x[1]
    else:
        out[1] = y
    out[1] *= a
    return -a / b


@algorithm
def first_above(v: InOut[Vector[3]], limit: Real) -> tuple[Real, Int]:
    """Loops that are left by break, continue and return, and what they have changed by then."""
    total = limit
    for i in range(4):
        for j in range(i, 3):
            if v[j] < limit - 3.0:
                continue
            total += v[j] * total
            v[j] -= 0.1 * total * total
            if j + i == 3 and total > 4.0:
                break
            if total > 9.0:
                return total * v[0], i
        total = sin(total) + limit
    return total, -1


@algorithm
def left_in_branches(x: Vector[3], n: Int) -> Real:
    """Loops that are left, in branches that are not."""
    total = x[0]
    if x[0] + x[1] > -1.0:
        for i in range(6):
            if total * total > 2.0:
                break
            if i % 2 == 1:
                continue
            total = total * total + x[i % 3] * total + 0.4
    else:
        for i in range(n, n + 3):
            total += sin(total) * x[i % 3]
            break
    return total * x[2]


@algorithm
def in_place(x: InOut[Vector[4]], a: InOut[Matrix[3, 3]], n: InOut[IntVector[4]], m: Int) -> Real:
    """Indices that are read from an array that changes, swaps, arrays made anew, loops of no steps."""
    k = 0
    s = x[0]
    for i in range(7, -2, -3):
        n[n[0] % 4] = (n[1] + i) % 4
        work = zeros(2)
        work[i % 2] = s * x[n[0] % 4]
        x[n[2] % 4], x[1] = x[1], work[0] - work[1] * s
        for _ in range(k, k - 1):
            s = 100.0
        s += x[k % 4] * a[k % 3, 1]
        a[(i + m) % 3][:] = (s, x[2], a[1, k % 3] * s)
        k += 1
    while k < 9 and s * s < 50.0:
        k += 2
        s = 1.1 * s + x[k % 4]
    return s / (1.0 + x[0] * x[0])


@algorithm
def scale(source: Vector[3], target: InOut[Vector[3]], by: Real) -> None:
    """Target plus by times source, where both may be one array."""
    for i in range(3):
        target[i] += by * source[2 - i] * source[i]


@codegen.kernel(codegen.numbers(3), codegen.numbers(3), codegen.scalar, algebra=cga)
def cross(a, b, s):
    return codegen.row([s * a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0] * s])


@algorithm
def calls(a: Matrix[3, 3], b: Vector[3], s: Real, x: Out[Vector[3]]) -> Real:
    """Kernels, algorithms with and without a declared derivative, of one array twice."""
    factor = empty(3, 3)
    factor[:] = a
    x[:] = b
    for _ in range(2):
        x[:] = cross(b, x, s * x[0])
        scale(x, x, s)
        scale(b, x, x[0])
    dense.cholesky(factor)
    dense.solve_cholesky(factor, x)
    return x[0] * factor[1, 1]


@algorithm
def of_any_size(x: Vector, shift: Static) -> Real:
    """A loss of neighbours."""
    total = 0.0
    for i in range(len(x) - 1):
        rest = x[i + 1] - x[i] * x[i] + shift
        total += rest * rest * rest
    return total


@algorithm
def of_rows(rows: Rows[2], weights: Reals, sums: Out[Vector[2]]) -> Real:
    """Rows whose number is known at a call; integers that are no index."""
    seen = int_zeros(1)
    best = 1.0
    for i in range(len(rows)):
        row = rows[i]
        best = best * cos(row[0] * weights[i]) + row[1]
        sums[0] += row[0] * best
        seen[0] += 1
    sums[1] = best * float(seen[0])
    return best


@algorithm
def walk(m: Vector[8], x: InOut[Vector[5]], limit: Real) -> Real:
    """A kernel in a loop that is left, and numbers that are kept."""
    total = limit
    for k in range(4):
        x[:] = move(m, x)
        if x[k] * x[0] > limit:
            break
        total = sin(total) + x[k] * total
    return total * x[1]
