"""Random objects of each kind, for blends."""

from __future__ import annotations

from typing import Any

import numpy as np

from bladesmith import Multivector
from bladesmith import cga3d as cga

from ..formulas import stock

Array = Any
CGA = stock("cga3d")

KINDS = ("point_pair", "line", "circle", "plane", "sphere")
COUNT = 40
FAR = np.array([1e6, -6e5, 3e5])


def drawn(kind: str, count: int, seed: int, at: Any = 0.0) -> Multivector:
    """Random objects of a kind, from Euclidean numbers."""
    rng = np.random.default_rng(seed)
    c, n = rng.normal(size=(count, 3)) + at, rng.normal(size=(count, 3))
    n /= np.linalg.norm(n, axis=-1, keepdims=True)
    r = rng.uniform(0.4, 2, count)
    made: Multivector = {
        "point": lambda: cga.point(c),
        "point_pair": lambda: cga.point_pair(c - n * r[:, None], c + n * r[:, None]),
        "line": lambda: cga.line(c, n),
        "circle": lambda: cga.circle(c, n, r),
        "plane": lambda: cga.plane(n, (n * c).sum(-1)),
        "sphere": lambda: cga.sphere(c, r),
    }[kind]()
    return made
