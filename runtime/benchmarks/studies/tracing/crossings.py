"""Intersections of rays with evolved surfaces, in integers of hundreds of bits: the reference of the ray studies.

From the definition and on nobody's formulas: the orthonormal basis e1 e2 e3 e+ e-, objects as skew matrices made from
points, planes and spheres, their sums as homogeneous polynomials in (1 - t, t), the projection to a blade as the part
in the invariant plane of larger square, B1 = U + s V with s = sqrt(D). The condition F is (L v C)^2, or L ^ P; the
roots of U^2 - D V^2 at which U and V have opposite signs are those of F.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from itertools import combinations
from math import comb, isqrt
from typing import Any

import mpmath
import numpy as np

from ...harness.vectors import cross, dot, scale, subtract

#: Bits to which unit objects and rays are rounded; from there on everything is exact.
BITS = 256
#: Bits of refined roots: more than twice what a sign of U V can hang on.
ROOT_BITS = 400
#: Limit of the refinement.
SETTLED = 1 << 32
#: Halvings of the curve; rays with roots closer than that are tangent, and refused.
DEEPEST = 120
METRIC = (1, 1, 1, 1, -1)
PAIRS = tuple(combinations(range(5), 2))
INFINITY = (0, 0, 0, 1, 1)
Polynomial = Any  # arrays of whole numbers: coefficients of (1 - t)^(n - k) t^k


def parity(order: Sequence[int]) -> int:
    """Sign of a permutation of 0 .. n - 1."""
    return -1 if sum(a > b for i, a in enumerate(order) for b in order[i + 1 :]) % 2 else 1


def circle(center: Any, normal: Any, radius: Any) -> list[list[Any]]:
    """The complement of a unit circle: its plane ^ its sphere."""
    c, n, r = _numbers(center), _numbers(normal), mpmath.mpf(float(radius))
    length = mpmath.sqrt(dot(n, n))
    n = [x / length for x in n]
    d = dot(c, n)
    e = (dot(c, c) - r * r) / 2
    return _wedge([*n, d, d], [x / r for x in (*c, e - 0.5, e + 0.5)])


def point_pair(a: Any, b: Any) -> list[list[Any]]:
    """A unit point pair a ^ b."""
    a, b = _numbers(a), _numbers(b)
    difference = subtract(a, b)
    size = dot(difference, difference) / 2
    return _wedge(_point(a), [x / size for x in _point(b)])


def _numbers(values: Any) -> list[Any]:
    return [mpmath.mpf(float(v)) for v in values]


def _point(x: list[Any]) -> list[Any]:
    square = dot(x, x) / 2
    return [*x, square - 0.5, square + 0.5]


def _wedge(x: list[Any], y: list[Any]) -> list[list[Any]]:
    return [[x[i] * y[j] - x[j] * y[i] for j in range(5)] for i in range(5)]


def _whole(x: Any) -> int:
    return int(mpmath.nint(mpmath.ldexp(x, BITS)))


class Surface:
    """One polynomial piece of an evolved surface.

    Parameters
    ----------
    kind : "circles" or "pairs"
    controls : sequence of tuples
        Bezier controls, unit objects by parameters: (center, normal, radius), or (a, b).
    """

    def __init__(self, kind: str, controls: Sequence[Sequence[Any]]) -> None:
        self.kind = kind
        n = len(controls) - 1
        with mpmath.workprec(2 * BITS):
            made = [circle(*c) if kind == "circles" else point_pair(*c) for c in controls]
            self.sums = [
                [np.array([comb(n, k) * _whole(made[k][i][j]) for k in range(n + 1)], object) for j in range(5)]
                for i in range(5)
            ]

    @cached_property
    def _blade(self) -> tuple[list[list[Polynomial]], list[list[Polynomial]], Polynomial, Polynomial]:
        """Multiples of U, V and D that belong together, and the sum of both squares in the units of s."""
        b, sign = self.sums, 1 if self.kind == "pairs" else -1
        m = [[METRIC[j] * b[i][j] for j in range(5)] for i in range(5)]
        m2 = _product(m, m)
        p2 = sign * sum(m2[i][i] for i in range(5))
        fourth = sum(np.convolve(m2[i][j], m2[j][i]) for i in range(5) for j in range(5))
        cubic = _product(m2, b)
        u = [[4 * cubic[i][j] - sign * np.convolve(p2, b[i][j]) for j in range(5)] for i in range(5)]
        return u, [[sign * b[i][j] for j in range(5)] for i in range(5)], 4 * fourth - np.convolve(p2, p2), p2

    def roots(self, origin: Any, direction: Any) -> list[tuple[Any, Any]]:
        """Parameters t in [0, 1] of all hits, rising, and how far along the direction they are; 50 digits and more."""
        with mpmath.workprec(2 * BITS):
            o, d = _numbers(origin), _numbers(direction)
            line = _line(o, d)
        even, odd = self._condition({k: _whole(x) for k, x in line.items()})
        _, _, square, p = self._blade
        product = np.convolve(p, p) - square
        is_one = all(abs(x) < abs(y) >> BITS // 2 for x, y in zip(product, np.convolve(p, p), strict=True))
        if is_one:  # one of the squares is zero: the objects are cospherical, s = p, and F itself is a polynomial
            norm = even + np.convolve(p, odd)
        else:
            norm = np.convolve(even, even) - np.convolve(square, np.convolve(odd, odd))
            ends = 2 if self.kind == "circles" else 1  # blades at both ends: (1 - t) t divides it, but for rounding
            norm = norm[ends:-ends]
        found = []
        with mpmath.workprec(ROOT_BITS):
            for low, high in isolate_roots(norm):
                t = refine_root(norm, low, high)
                if is_one or value(even, t) * value(odd, t) < 0:
                    away = self._distance(t, o, d)
                    if away is not None:
                        found.append((mpmath.ldexp(t, -ROOT_BITS), away))
        return sorted(found)

    def _condition(self, line: dict[tuple[int, int], int]) -> tuple[Polynomial, Polynomial]:
        u, v, d, _ = self._blade
        if self.kind == "pairs":
            return tuple(sum(line[i, j] * b[i][j] for i, j in PAIRS) for b in (u, v))
        even: Any = 0
        odd: Any = 0
        for m in range(5):
            yu: Any = 0
            yv: Any = 0
            rest = [k for k in range(5) if k != m]
            for i, j in combinations(rest, 2):
                k, n = (x for x in rest if x not in (i, j))
                weight = parity((m, i, j, k, n)) * METRIC[k] * METRIC[n] * line[i, j]  # lower indices
                yu, yv = yu + weight * u[k][n], yv + weight * v[k][n]
            even = even + METRIC[m] * (np.convolve(yu, yu) + np.convolve(d, np.convolve(yv, yv)))
            odd = odd + 2 * METRIC[m] * np.convolve(yu, yv)
        return even, odd

    def _distance(self, t: int, origin: list[Any], direction: list[Any]) -> Any:
        """Distance along the ray to the object at t; None beside the segment of a pair.

        With infinity put in once comes the plane, or the direction of a pair; once more, the sphere or the middle.
        """
        u, v, d, _ = self._blade
        s = isqrt(value(d, t))
        b = [[mpmath.mpf(value(u[i][j], t) + s * value(v[i][j], t)) for j in range(5)] for i in range(5)]
        way = [sum(METRIC[k] * row[k] * INFINITY[k] for k in range(5)) for row in b]
        sphere = [sum(METRIC[k] * row[k] * way[k] for k in range(5)) for row in b]
        weight = sphere[4] - sphere[3]
        center = [x / weight for x in sphere[:3]]
        relative = subtract(center, origin)
        if self.kind == "circles":
            return dot(way[:3], relative) / dot(way[:3], direction)
        across = cross(direction, way[:3])
        along = dot(cross(relative, way[:3]), across) / dot(across, across)
        away = subtract(scale(direction, along), relative)
        half = (sphere[3] + sphere[4]) / weight - dot(center, center)
        return along if dot(away, away) <= half else None


def _product(x: Any, y: Any) -> list[list[Polynomial]]:
    return [[sum(np.convolve(x[i][k], y[k][j]) for k in range(5)) for j in range(5)] for i in range(5)]


def _line(origin: list[Any], direction: list[Any]) -> dict[tuple[int, int], Any]:
    """The complement of o ^ d ^ n_inf."""
    a, b, c = _point(origin), [*direction, 0, 0], INFINITY
    found = {}
    for pair in PAIRS:
        i, j, k = (m for m in range(5) if m not in pair)
        det = (
            a[i] * (b[j] * c[k] - b[k] * c[j]) - a[j] * (b[i] * c[k] - b[k] * c[i]) + a[k] * (b[i] * c[j] - b[j] * c[i])
        )
        found[pair] = parity((*pair, i, j, k)) * det
    return found


def isolate_roots(polynomial: Polynomial) -> list[tuple[int, int]]:
    """Intervals of [0, 1] with one root each, in units of 2^-ROOT_BITS: Descartes' rule on halves."""
    degree = len(polynomial) - 1
    scale = [comb(degree, k) for k in range(degree + 1)]
    common = int(np.lcm.reduce(np.array(scale, object)))
    intervals, pending = [], [([int(c) * (common // s) for c, s in zip(polynomial, scale, strict=True)], 0, 0)]
    while pending:
        c, index, depth = pending.pop()
        signs = [x > 0 for x in c if x]
        changes = sum(p != q for p, q in zip(signs, signs[1:], strict=False))
        if changes == 1:
            intervals.append((index << (ROOT_BITS - depth), (index + 1) << (ROOT_BITS - depth)))
        elif changes and depth < DEEPEST:
            left, right = [c[0] << degree], [c[-1] << degree]
            for step in range(1, degree + 1):
                c = [x + y for x, y in zip(c, c[1:], strict=False)]
                left.append(c[0] << (degree - step))
                right.append(c[-1] << (degree - step))
            pending += [(left, 2 * index, depth + 1), (right[::-1], 2 * index + 1, depth + 1)]
        elif changes:
            raise ArithmeticError("two roots closer than the reference can tell")
    return intervals


def refine_root(polynomial: Polynomial, low: int, high: int) -> int:
    """The root of an interval that has one, in units of 2^-ROOT_BITS: Newton's steps, halves where they leave it."""
    n = len(polynomial) - 1
    slope = [(k + 1) * polynomial[k + 1] - (n - k) * polynomial[k] for k in range(n)]
    rises = value(polynomial, high) > 0 or value(polynomial, low) < 0
    t = (low + high) // 2
    while high - low > SETTLED:
        here = value(polynomial, t)
        low, high = (low, t) if (here > 0) == rises else (t, high)
        steep = value(slope, t)
        step = (here << ROOT_BITS) // steep if steep else high - low
        inside = low < t - step < high
        t = t - step if inside else (low + high) // 2
        if inside and abs(step) < SETTLED:
            break
    return t


def value(polynomial: Polynomial, t: int) -> int:
    """Value of a homogeneous polynomial at (1 - t, t), rounded to an integer; t in units of 2^-ROOT_BITS."""
    s, power, total = (1 << ROOT_BITS) - t, 1 << ROOT_BITS, 0
    for c in polynomial:  # Horner in (1 - t), with powers of t beside it
        total = (total * s + power * c) >> ROOT_BITS
        power = (power * t) >> ROOT_BITS
    return int(total)
