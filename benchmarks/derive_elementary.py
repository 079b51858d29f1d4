"""Derives the constants of codegen/elementary/constants.py.

Minimax polynomials by Remez exchange at 40 digits. On intervals that start at zero they are rounded one coefficient
at a time, and each rounding is made good by the coefficients that are still free (on others z, z^2, ... is no basis
in which an exchange works). `python benchmarks/derive_elementary.py` prints them.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias

import mpmath as mp

mp.mp.dps = 40
Real: TypeAlias = Any  # mpmath's number
POINTS_PER_TERM = 16  # of the grid on which the exchange looks for extrema
EXCHANGES = 8
SLACK = mp.mpf("1e-6")  # intervals are this much wider, relatively: a reduced argument may fall just outside


@dataclass(frozen=True)
class Fit:
    """A polynomial to find: `name` among the constants, its function on an interval, the weight of its error."""

    name: str
    function: Callable[[Real], Real]
    low: Real
    high: Real
    weight: Callable[[Real], Real]  # error of the polynomial -> relative error of the result
    terms: dict[int, int]  # bits of the precision -> number of coefficients


def stumpff(k: int, w: Real) -> Real:
    """c_k(w) = sum over n of (-w)^n / (2n + k)!."""
    total, term, n = mp.mpf(0), 1 / mp.factorial(k), 0
    while abs(term) > mp.eps / 1000:
        total += term
        n += 1
        term *= -w / ((2 * n + k - 1) * (2 * n + k))
    return total


def power_series(z: Real, coefficient: Callable[[int], Real]) -> Real:
    """Sum of coefficient(n) z^n, |z| < 1."""
    total, n, power = mp.mpf(0), 0, mp.mpf(1)
    while abs(power) > mp.eps / 1000:
        total += coefficient(n) * power
        power *= z
        n += 1
    return total


def fits() -> list[Fit]:
    """All polynomials; codegen/elementary/functions.py says how each is used."""
    quarter = (mp.pi / 4) ** 2 * (1 + SLACK)
    half_ln2 = mp.log(2) / 2 * (1 + SLACK)
    log_range = ((mp.sqrt(2) - 1) / (mp.sqrt(2) + 1)) ** 2 * (1 + SLACK)
    below, above = mp.mpf(-9), mp.mpf(3) / 2
    return [
        Fit("sine", lambda z: stumpff(3, z), mp.mpf(0), quarter, lambda z: z / stumpff(1, z), {64: 6, 32: 3}),
        Fit(
            "cosine", lambda z: stumpff(4, z), mp.mpf(0), quarter, lambda z: z**2 / stumpff(0, z), {64: 6, 32: 3}
        ),
        Fit("stumpff4", lambda w: stumpff(4, w), below, above, lambda w: abs(w) / stumpff(2, w), {64: 10, 32: 6}),
        Fit("stumpff5", lambda w: stumpff(5, w), below, above, lambda w: abs(w) / stumpff(3, w), {64: 10, 32: 5}),
        Fit(
            "stumpff6",
            lambda q: stumpff(6, q),
            below,
            -below,
            lambda q: (1 + abs(q) / 6) / (64 * stumpff(7, 4 * q)),
            {64: 10, 32: 6},
        ),
        Fit(
            "stumpff7",
            lambda q: stumpff(7, q),
            below,
            -below,
            lambda q: (1 + abs(q) * (1 + stumpff(1, q))) / (32 * stumpff(6, 4 * q)),
            {64: 10, 32: 5},
        ),
        Fit(
            "exponential",
            lambda r: power_series(r, lambda n: 1 / mp.factorial(n + 2)),
            -half_ln2,
            half_ln2,
            lambda r: r**2 / mp.exp(r),
            {64: 10, 32: 5},
        ),
        Fit(
            "logarithm",
            lambda z: power_series(z, lambda n: mp.mpf(2) / (2 * n + 3)),
            mp.mpf(0),
            log_range,
            lambda z: z / 2 + mp.mpf("1e-30"),
            {64: 7, 32: 3},
        ),
        Fit(
            "arctangent",
            lambda z: power_series(z, lambda n: mp.mpf((-1) ** n) / (2 * n + 3)),
            mp.mpf(0),
            mp.mpf(1) / 4 * (1 + SLACK),
            lambda z: z,
            {64: 12, 32: 5},
        ),
    ]


def minimax(fit: Fit, count: int, fixed: list[Real]) -> tuple[list[Real], Real]:
    """Coefficients after the fixed ones that minimise the largest weighted error, and that error.

    One exchange: solve for equal and alternating errors on count + 1 points, then move the points to the extrema.
    """
    free = count - len(fixed)
    size = POINTS_PER_TERM * count
    middle, radius = (fit.low + fit.high) / 2, (fit.high - fit.low) / 2
    grid = [middle - radius * mp.cos(mp.pi * (i + mp.mpf(1) / 2) / size) for i in range(size)]
    values = [fit.function(x) for x in grid]
    weights = [fit.weight(x) for x in grid]
    rest = [v - mp.polyval(fixed[::-1], x) if fixed else v for v, x in zip(values, grid, strict=True)]
    chosen = [round(i * (size - 1) / free) for i in range(free + 1)]
    best: tuple[list[Real], Real] = ([], mp.inf)
    for _ in range(EXCHANGES):
        rows = [
            [grid[i] ** (len(fixed) + j) for j in range(free)]
            + [(-1) ** number / max(weights[i], mp.mpf("1e-40"))]
            for number, i in enumerate(chosen)
        ]
        solution = mp.lu_solve(mp.matrix(rows), mp.matrix([rest[i] for i in chosen]))
        found = [solution[j] for j in range(free)]
        full = fixed + found
        errors = [w * (mp.polyval(full[::-1], x) - v) for w, x, v in zip(weights, grid, values, strict=True)]
        worst = max(abs(e) for e in errors)
        if worst < best[1]:
            best = (found, worst)
        chosen = extrema(errors, free + 1)
        if len(chosen) < free + 1:
            break
    return best


def extrema(errors: list[Real], wanted: int) -> list[int]:
    """Places of the largest error in each run of one sign; of too many, an alternating `wanted` with the largest."""
    runs: list[int] = []
    for i, error in enumerate(errors):
        if runs and mp.sign(errors[runs[-1]]) == mp.sign(error):
            if abs(error) > abs(errors[runs[-1]]):
                runs[-1] = i
        else:
            runs.append(i)
    while len(runs) > wanted:
        runs.pop(0 if abs(errors[runs[0]]) < abs(errors[runs[-1]]) else -1)
    return runs


def rounded(x: Real, bits: int) -> Real:
    """The nearest float64 or float32."""
    if bits == 64:
        return mp.mpf(float(x))
    with mp.workprec(24):
        return +mp.mpf(x)


def polynomial(fit: Fit, bits: int) -> tuple[list[float], float]:
    """Rounded coefficients, lowest first, and the base 2 logarithm of the largest relative error of the result."""
    count = fit.terms[bits]
    fixed: list[Real] = []
    if fit.low < 0:
        fixed = [rounded(c, bits) for c in minimax(fit, count, [])[0]]
    while len(fixed) < count:
        found, _ = minimax(fit, count, fixed)
        fixed.append(rounded(found[0], bits))
    size = 4 * POINTS_PER_TERM * count
    grid = [fit.low + (fit.high - fit.low) * i / size for i in range(size + 1)]
    worst = max(abs(fit.weight(x) * (mp.polyval(fixed[::-1], x) - fit.function(x))) for x in grid)
    return [float(c) for c in fixed], float(mp.log(worst, 2))


def head(x: Real, bits: int) -> Real:
    """x cut to this many significant bits, toward zero."""
    exponent = mp.floor(mp.log(abs(x), 2)) + 1
    return mp.floor(x * mp.mpf(2) ** (bits - exponent)) / mp.mpf(2) ** (bits - exponent)


def parts(x: Real, short: int, count: int, bits: int) -> list[float]:
    """x as `count` parts: all but the last have `short` bits, so that small integers times them are exact."""
    result: list[Real] = []
    for _ in range(count - 1):
        result.append(head(x - sum(result), short))
    result.append(rounded(x - sum(result), bits))
    return [float(part) for part in result]


def constants(bits: int) -> dict[str, list[float]]:
    """Everything but the polynomials.

    Short parts leave bits to the integer that they are multiplied by: 16 (float32: 11) of a count of half turns, 11
    (8) of an exponent, 3 of a count of eighths of a turn.
    """
    digits, spare, count, exponent = (53, 16, 3, 11) if bits == 64 else (24, 11, 4, 8)
    half_pi, ln2 = mp.pi / 2, mp.log(2)

    return {
        "half_pi": parts(half_pi, digits - spare, count, bits),
        "ln2": parts(ln2, digits - spare, count, bits),
        "ln2_pair": parts(ln2, digits - exponent, 2, bits),
        "quarter_pi": parts(mp.pi / 4, digits - 3, 2, bits),
        "per_half_pi": [float(rounded(1 / half_pi, bits))],
        "per_ln2": [float(rounded(1 / ln2, bits))],
    }


def two_over_pi(words: int) -> list[int]:
    """Binary places of 2/pi, in words of 32 bits, after two words of zeros."""
    with mp.workprec(32 * words + 64):
        places = int(mp.floor(2 / mp.pi * mp.mpf(2) ** (32 * words)))
    return [0, 0] + [places >> (32 * (words - 1 - i)) & (2**32 - 1) for i in range(words)]


def hexadecimal(x: float) -> str:
    """Exact text; float32 values have short mantissas."""
    text = float(x).hex()
    mantissa, exponent = text.split("p")
    mantissa = mantissa.rstrip("0") if "." in mantissa else mantissa
    return f"{mantissa.rstrip('.')}p{exponent}"


def python_block(bits: int) -> str:
    """The constants of one precision, as arguments of `Constants`."""
    exact = f"float{bits}"
    lines = []
    named = [(fit.name, polynomial(fit, bits)[0]) for fit in fits()] + list(constants(bits).items())
    for name, values in named:
        if bits == 64 and name in ("half_pi", "ln2"):
            values = [*values, 0.0]
        texts = [f'"{hexadecimal(value)}"' for value in values]
        if len(texts) == 1:
            lines.append(f"    {name}={exact}({texts[0]})[0],")
        elif len(texts) <= 4:
            lines.append(f"    {name}={exact}({', '.join(texts)}),")
        else:
            lines.append(f"    {name}={exact}(")
            lines += ["        " + ", ".join(texts[i : i + 4]) + "," for i in range(0, len(texts), 4)]
            lines.append("    ),")
    return "\n".join(lines)


def main() -> None:
    """Print what belongs into the file."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--bits", type=int, choices=(32, 64), help="only this precision's blocks")
    chosen = parser.parse_args().bits
    for bits in (64, 32) if chosen is None else (chosen,):
        print(f"# {bits} bits\n{python_block(bits)}\n")
    words = [f"0x{word:08X}" for word in two_over_pi(38)]
    print(",\n".join(", ".join(words[i : i + 8]) for i in range(0, len(words), 8)))


if __name__ == "__main__":
    main()
