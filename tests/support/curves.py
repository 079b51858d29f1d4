"""What the tests of curves share: objects, and one entry per way to add them up."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from bladesmith import cga3d as cga
from bladesmith import curves
from bladesmith.codegen.rings.protocol import PrecisionRing

RANDOM = np.random.default_rng(5)
POSITIONS = RANDOM.normal(size=(6, 3))
KNOTS = np.array([-1.0, 0.0, 0.3, 2.0, 2.5, 4.0])
POINTS = cga.point(POSITIONS)
RING = PrecisionRing(50)
MP = RING.context
#: One entry per way to add up controls: a curve of the given objects.
FAMILIES: dict[str, Any] = {
    "bezier": curves.Bezier,
    "rational": lambda x: curves.RationalBezier(x, np.linspace(0.5, 3.0, len(x))),
    "hermite": lambda x: curves.Hermite(x[0], x[1] - x[0], x[-1], 2 * x[-1] - 2 * x[1]),
    "catmull-rom": curves.KochanekBartels,
    "kochanek-bartels": lambda x: curves.KochanekBartels(x, 0.3, -0.2, np.linspace(-0.4, 0.4, len(x)), closed=True),
    "linear": partial(curves.Interpolating, degree=1),
    "quadratic": lambda x: curves.Interpolating(x, KNOTS[: len(x)], 2),
    "cubic": lambda x: curves.Interpolating(x, KNOTS[: len(x)], 3),
    "natural": lambda x: curves.Interpolating(x, KNOTS[: len(x)], 3, ends="natural"),
}


def near_objects(kind: str, n: int, seed: int = 3, shift: Any = 0.0) -> Any:
    """Objects of one kind that differ moderately, so that sums of them stand for objects."""
    r = np.random.default_rng(seed)
    at = 0.2 * r.normal(size=(n, 3)) + shift
    up = [0, 0, 1] + 0.3 * r.normal(size=(n, 3))
    radius = r.uniform(0.8, 1.5, n)
    if kind == "mixed":  # every other circle is a line
        one, two = cga.line(at[::2], up[::2]), cga.circle(at[1::2] + [3, 0, 0], [0, 1, 0] + 0 * at[1::2], 3.0)
        return [x[i] for i in range(len(two)) for x in (one, two)]
    return {
        "point": lambda: cga.point(at),
        "point_pair": lambda: cga.point_pair(at - up, at + up),
        "line": lambda: cga.line(at, up),
        "circle": lambda: cga.circle(at, up, radius),
        "plane": lambda: cga.plane(up, (up * at).sum(-1)),
        "sphere": lambda: cga.sphere(at, radius),
    }[kind]()


def parameters(curve: Any, count: int = 7) -> np.ndarray:
    """Parameters inside, away from the joints."""
    start, end = curve.domain
    return start + (end - start) * (np.arange(count) + 0.43) / count
