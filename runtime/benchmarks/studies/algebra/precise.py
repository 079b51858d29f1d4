"""Multivectors with 50 digits, references of the studies of objects. Plain series and products, no kernels."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import cache
from typing import Any

import numpy as np

from ....codegen.algebra.multivector import from_values
from ....codegen.formulas.objects import conformal
from ....codegen.rings.protocol import PrecisionRing
from ...harness.algebras import cga3d
from ...harness.study import Array

DIGITS = 50
#: exp(b) = exp(b/2^HALVINGS)^(2^HALVINGS): with the terms below, far beyond 50 digits for |b| up to some hundred.
HALVINGS, SERIES_TERMS = 10, 24


@cache
def ring() -> Any:
    """The ring of numbers with 50 digits and a reserve for the squarings."""
    return PrecisionRing(DIGITS + 15)


def multivector(kind: Any, row: Iterable[Any]) -> Any:
    """The multivector of a kind with these coefficients (floats are taken exactly)."""
    mp = ring().context
    values = [v if isinstance(v, mp.mpf) else mp.mpf(float(v)) for v in row]
    return from_values(kind.algebra, ring(), kind.blades, values)


def multivectors(kind: Any, rows: Array) -> list[Any]:
    """One for each row."""
    return [multivector(kind, row) for row in rows]


def construct(maker: str, *parameters: Any) -> Any:
    """The object of `conformal`'s maker of this name, from 50-digit vectors and numbers (rows of 3 and of 1)."""
    kinds = {3: cga3d.kind("euclidean"), 1: cga3d.kind("scalar")}
    rows = [list(np.atleast_1d(p)) for p in parameters]
    x = getattr(conformal, maker)(*(multivector(kinds[len(row)], row) for row in rows))[0]
    return x.new({b: x.terms[b] for b in cga3d.kind(maker).blades if b in x.terms})  # the rest is rounding noise


def exponential(b: Any) -> Any:
    """exp(b) by its series on a small multiple of b, and squaring."""
    small = b / 2**HALVINGS
    total = small / SERIES_TERMS + 1
    for k in range(SERIES_TERMS - 1, 0, -1):
        total = (small * total) / k + 1
    for _ in range(HALVINGS):
        total = total * total
    return total


def size(x: Any) -> float:
    """Largest coefficient."""
    return max((float(abs(c)) for c in x.terms.values()), default=0.0)


def difference(x: Any, y: Any) -> float:
    """Largest coefficient of x - y, over the largest of y and 1; infinite where x is not finite."""
    error = size(x - y)
    return error / max(size(y), 1.0) if np.isfinite(error) else float("inf")


def to_floats(kind: Any, items: Sequence[Any]) -> Array:
    """Coefficients (n, k) in double precision."""
    return np.array([[float(v) for v in kind.values(x)] for x in items])
