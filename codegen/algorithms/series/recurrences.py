"""Coefficient k of functions of power series, from coefficients 0 to k of the arguments and those before k of itself.

Coefficients are normalised, x(t) = sum of x_k t^k; each series is in one piece.
"""

from __future__ import annotations

from ...ir.loops.algorithm import Algorithm, in_library, inlined
from ...ir.loops.language import InOut, Int, Real, Reals, atan2, cos, exp, log, sin, sqrt

#: Highest order of a series, and so rows of its history: more than any tolerance of doubles asks for.
HIGHEST_ORDER = 24
ROWS = HIGHEST_ORDER + 1


@in_library
def convolve(k: Int, count: Int, x: Reals, y: Reals, products: InOut[Reals]) -> None:
    """Products of a number of pairs of series, which stand beside each other in rows of that length."""
    for i in range(count):
        total = x[i] * y[count * k + i]
        for j in range(1, k + 1):
            total += x[count * j + i] * y[count * (k - j) + i]
        products[i] = total


@inlined
def convolved(k: Int, first: Int, last: Int, x: Reals, y: Reals) -> Real:
    """Sum of x_j y_(k - j) for j from first to last, both included."""
    total = 0.0
    for j in range(first, last + 1):
        total += x[j] * y[k - j]
    return total


@inlined
def integrated(k: Int, first: Int, last: Int, x: Reals, y: Reals) -> Real:
    """Sum of j x_j y_(k - j)/k likewise: the integral of x' y."""
    total = 0.0
    for j in range(first, last + 1):
        total += float(j) * x[j] * y[k - j]
    return total / float(k)


@inlined
def series_reciprocal(k: Int, x: Reals, y: InOut[Reals]) -> None:
    """From y x = 1."""
    if k > 0:
        y[k] = -convolved(k, 1, k, x, y) * y[0]
    else:
        y[0] = 1.0 / x[0]


@inlined
def series_sqrt(k: Int, x: Reals, y: InOut[Reals]) -> None:
    """From y y = x."""
    if k > 0:
        y[k] = (x[k] - convolved(k, 1, k - 1, y, y)) / (2.0 * y[0])
    else:
        y[0] = sqrt(x[0])


@inlined
def series_exp(k: Int, x: Reals, y: InOut[Reals]) -> None:
    """From y' = x' y."""
    if k > 0:
        y[k] = integrated(k, 1, k, x, y)
    else:
        y[0] = exp(x[0])


@inlined
def series_log(k: Int, x: Reals, y: InOut[Reals]) -> None:
    """From y' x = x'."""
    if k > 0:
        y[k] = (x[k] - integrated(k, 1, k - 1, y, x)) / x[0]
    else:
        y[0] = log(x[0])


@inlined
def series_sin_cos(k: Int, x: Reals, s: InOut[Reals], c: InOut[Reals]) -> None:
    """From s' = x' c, c' = -x' s."""
    if k > 0:
        sine = integrated(k, 1, k, x, c)
        c[k] = -integrated(k, 1, k, x, s)
        s[k] = sine
    else:
        s[0] = sin(x[0])
        c[0] = cos(x[0])


@inlined
def series_atan2(k: Int, y: Reals, x: Reals, square: InOut[Reals], a: InOut[Reals]) -> None:
    """From a' (x x + y y) = x y' - y x'; the square is kept."""
    square[k] = convolved(k, 0, k, x, x) + convolved(k, 0, k, y, y)
    if k > 0:
        change = integrated(k, 1, k, y, x) - integrated(k, 1, k, x, y)
        a[k] = (change - integrated(k, 1, k - 1, a, square)) / square[0]
    else:
        a[0] = atan2(y[0], x[0])


#: By the functions of rings.
RECURRENCES: dict[str, Algorithm] = {
    "reciprocal": series_reciprocal, "sqrt": series_sqrt, "exp": series_exp, "log": series_log,
    "sin": series_sin_cos, "cos": series_sin_cos, "atan2": series_atan2,
}  # fmt: skip
