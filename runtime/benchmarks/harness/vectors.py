"""Vectors: random directions, and lists of exact numbers."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from .study import Array


def unit(vectors: Array) -> Array:
    """Vectors (..., k) over their lengths."""
    return np.asarray(vectors / np.linalg.norm(vectors, axis=-1, keepdims=True))


def directions(rng: np.random.Generator, count: int) -> Array:
    """Random unit vectors (count, 3)."""
    return unit(rng.normal(size=(count, 3)))


def vector_text(values: Iterable[float], digits: int = 6) -> str:
    """Components in parentheses."""
    return f"({', '.join(f'{x:.{digits}g}' for x in values)})"


# -- vectors of numbers of any kind: of `mpmath`, or fractions --------------------------------------------------


def dot(a: Iterable[Any], b: Iterable[Any]) -> Any:
    """Scalar product."""
    return sum(x * y for x, y in zip(a, b, strict=True))


def cross(a: Sequence[Any], b: Sequence[Any]) -> list[Any]:
    """Vector product."""
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def subtract(a: Iterable[Any], b: Iterable[Any]) -> list[Any]:
    """Difference."""
    return [x - y for x, y in zip(a, b, strict=True)]


def add(a: Iterable[Any], b: Iterable[Any]) -> list[Any]:
    """Sum."""
    return [x + y for x, y in zip(a, b, strict=True)]


def scale(a: Iterable[Any], factor: Any) -> list[Any]:
    """Multiple."""
    return [factor * x for x in a]
