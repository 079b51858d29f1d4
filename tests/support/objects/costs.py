"""Random objects of each kind, for costs of pairs."""

from __future__ import annotations

from typing import Any

import numpy as np

import bladesmith as bs
from bladesmith import cga3d as cga

KINDS = ("point_pair", "line", "circle", "plane", "sphere")
INVALID, NOT_UNIQUE = bs.Status.INVALID, bs.Status.NOT_UNIQUE


def objects(kind: str, n: int, seed: int = 0) -> Any:
    """Random objects near the origin, from geometric parameters."""
    r = np.random.default_rng(seed)
    a, b = r.normal(size=(2, n, 3))
    size = r.uniform(0.5, 2, n)
    made = {
        "point": lambda: cga.point(a),
        "point_pair": lambda: cga.point_pair(a, b),
        "line": lambda: cga.line(a, b),
        "circle": lambda: cga.circle(a, b, size),
        "plane": lambda: cga.plane(b, size),
        "sphere": lambda: cga.sphere(a, size),
    }
    return made[kind]()


def flipped(x: Any) -> Any:
    """-X, of the same kind."""
    return (-1 * x).normalized(x.kind)
