"""Objects of curves as exact skew matrices, from their definition: outer products of points (python-flint).

The orthonormal basis e1 e2 e3 e+ e-; a trivector stands for the skew matrix of its complement, whose kernel it is.
Nothing here is bladesmith's.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from typing import Any

from flint import fmpq

from .families import Controls, Family, axes

METRIC = (1, 1, 1, 1, -1)
PAIRS = tuple(combinations(range(5), 2))
INFINITY = [fmpq(0)] * 3 + [fmpq(1)] * 2
Skew = dict[tuple[int, int], fmpq]


def parity(order: Sequence[int]) -> int:
    """Sign of a permutation of 0 .. n - 1."""
    return -1 if sum(a > b for i, a in enumerate(order) for b in order[i + 1 :]) % 2 else 1


def point(x: Sequence[fmpq]) -> list[fmpq]:
    """The null vector of a point."""
    square = sum((c * c for c in x), fmpq(0))
    return [*x, (square - 1) / 2, (square + 1) / 2]


def complement(vectors: Sequence[Sequence[fmpq]]) -> Skew:
    """Entries of the skew matrix of which the kernel is the span of three vectors."""
    found = {}
    for pair in PAIRS:
        i, j, k = (m for m in range(5) if m not in pair)
        a, b, c = vectors
        det = (
            a[i] * (b[j] * c[k] - b[k] * c[j]) - a[j] * (b[i] * c[k] - b[k] * c[i]) + a[k] * (b[i] * c[j] - b[j] * c[i])
        )
        found[pair] = parity((*pair, i, j, k)) * det
    return found


def rational(values: Any) -> list[fmpq]:
    """Floating-point numbers as they are."""
    return [fmpq(*float(v).as_integer_ratio()) for v in values]


def unit_objects(objects: Controls) -> list[Skew]:
    """Skew matrices of the unit control objects: pairs A ^ B, or complements of circles A ^ B ^ C."""
    found = []
    if objects.center is not None:
        assert objects.quaternion is not None and objects.radius is not None
        for center, q, radius in zip(objects.center, objects.quaternion, objects.radius, strict=True):
            length = sum(c * c for c in rational(q))
            u, v = ([x / length for x in rational(axis)] for axis in axes(q)[:2])
            (r,), c = rational([radius]), rational(center)
            corners = [point([p + r * w for p, w in zip(c, way, strict=True)]) for way in (u, v, [-x for x in u])]
            found.append({k: x / (2 * r**3) for k, x in complement(corners).items()})
    else:
        for a, b in zip(objects.a, objects.b, strict=True):  # type: ignore[arg-type]
            a, b = rational(a), rational(b)
            size = sum((x - y) ** 2 for x, y in zip(a, b, strict=True)) / 2
            a, b = point(a), point(b)
            found.append({(i, j): (a[i] * b[j] - a[j] * b[i]) / size for i, j in PAIRS})
    return found


def pieces(family: Family, objects: Controls) -> list[list[Skew]]:
    """Bezier controls of each polynomial piece of the curve."""
    x = unit_objects(objects)
    if family.curve == "bezier":
        return [x]
    last = len(x) - 1
    tension, bias, continuity = (rational(row) for row in objects.shape)

    def minus(a: int, b: int) -> Skew:
        return {k: x[a][k] - x[b][k] for k in PAIRS}

    def tangent(i: int, leaving: int) -> Skew:
        """V+ or V- at control i; where a neighbour is missing the other difference stands for it."""
        behind = minus(max(i, 1), max(i, 1) - 1)
        ahead = minus(min(i, last - 1) + 1, min(i, last - 1))
        c = leaving * continuity[i]
        p, q = (1 + bias[i]) * (1 + c), (1 - bias[i]) * (1 - c)
        return {k: (1 - tension[i]) / 2 * (p * behind[k] + q * ahead[k]) for k in PAIRS}

    found = []
    for i in range(last):
        out, in_ = tangent(i, 1), tangent(i + 1, -1)
        inner = [{k: x[i][k] + out[k] / 3 for k in PAIRS}, {k: x[i + 1][k] - in_[k] / 3 for k in PAIRS}]
        found.append([x[i], *inner, x[i + 1]])
    return found


def agree(first: Skew, second: Skew) -> bool:
    """Whether two objects of one kind are turned alike: <C1 C2>_0 > 0."""
    product = sum(METRIC[i] * METRIC[j] * first[i, j] * second[i, j] for i, j in PAIRS)
    # B^2 of a pair is positive, of the complement of a circle negative
    own = sum(METRIC[i] * METRIC[j] * first[i, j] * first[i, j] for i, j in PAIRS)
    return bool(product * own > 0)
