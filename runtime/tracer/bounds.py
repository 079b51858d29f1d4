"""A sphere that surely holds an evolved surface: its formulas run on intervals of the curve's parameter.

Bounds from sampled circles lose hits. Here every circle of a short piece of the curve is enclosed, whatever
rounding does.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.formulas import surfaces
from ..codegen.multivector import from_values
from ..codegen.programs import cga3d
from ..codegen.programs.surface_kinds import SurfaceKind
from ..codegen.rings import Terms

Array = NDArray[np.float64]
Interval = tuple[Array, Array]
#: Pieces of the curve. The excess of the bound is of the order of one over it.
PIECES = 1024
#: Relative growth for rounding, in float32 too.
SAFETY = 1e-3


class IntervalRing:
    """Pairs (low, high) of arrays; what cannot be bounded becomes infinite. Rounding is left to `SAFETY`."""

    def constant(self, value: Fraction) -> Interval:
        x = np.asarray(value.numerator / value.denominator)
        return x, x

    def combine(self, terms: Terms) -> Interval:
        low: Any = np.float64(0)
        high: Any = np.float64(0)
        for (a, b), weight in terms:
            w = weight.numerator / weight.denominator
            low, high = low + (w * a if w > 0 else w * b), high + (w * b if w > 0 else w * a)
        return low, high

    def multiply(self, a: Interval, b: Interval) -> Interval:
        with np.errstate(invalid="ignore"):
            products = [x * y for x in a for y in b]
            low = np.minimum(np.minimum(products[0], products[1]), np.minimum(products[2], products[3]))
            high = np.maximum(np.maximum(products[0], products[1]), np.maximum(products[2], products[3]))
        if a is b:
            low = np.maximum(low, 0)
        return low, high

    def apply(self, name: str, *arguments: Any) -> Any:
        low, high = arguments[0]
        if name == "sqrt":
            return np.sqrt(np.maximum(low, 0)), np.sqrt(np.maximum(high, 0))
        if name == "reciprocal":
            sure = (low > 0) | (high < 0)
            with np.errstate(divide="ignore"):
                return np.where(sure, 1 / high, -np.inf), np.where(sure, 1 / low, np.inf)
        if name in ("lt", "le"):
            other = arguments[1]
            return high < other[0], low > other[1]  # certainly, certainly not
        raise NotImplementedError(f"{name} of an interval")

    def select(self, mask: tuple[Any, Any], a: Interval, b: Interval) -> Interval:
        surely, never = mask
        low = np.where(surely, a[0], np.where(never, b[0], np.minimum(a[0], b[0])))
        high = np.where(surely, a[1], np.where(never, b[1], np.maximum(a[1], b[1])))
        return low, high

    def is_zero(self, a: Interval) -> bool:
        return False


def completed(kind: SurfaceKind, constants: Array) -> Array:
    """Rows of constants with the bounds that only Python knows: of evolved surfaces."""
    if not any(name == "bound" for name, _ in kind.layout):
        return constants
    bound, scalars, circles = (kind.slice(name) for name in ("bound", "scalars", "circles"))
    for row in constants:
        center, radius = evolved_bound(row[scalars], row[circles].reshape(4, 10))
        if np.isfinite(radius):
            row[bound] = [*center, radius]
    return constants


def evolved_bound(scalars: Array, circles: Array) -> tuple[Array, float]:
    """Centre and radius of a sphere around the surface; the radius is infinite if the surface is unbounded.

    Parameters
    ----------
    scalars : (2,) array
        m0 and kappa.
    circles : (4, 10) array
        C1, C2, M4 C1, M4 C2.
    """
    algebra, ring = cga3d(), IntervalRing()
    ends = np.linspace(0.0, 1.0, PIECES + 1)

    def scalar(low: Any, high: Any) -> Any:
        return from_values(algebra, ring, (0,), [(low, high)])

    blades = algebra.kind("circle").blades
    exact = [from_values(algebra, ring, blades, [(np.float64(v), np.float64(v)) for v in row]) for row in circles]
    surface = [scalar(v, v) for v in scalars]
    a, b = scalar(ends[:-1], ends[1:]), scalar(1 - ends[1:], 1 - ends[:-1])
    with np.errstate(invalid="ignore", over="ignore"):
        circle = surfaces.evolved_circle(surface, a, b, *exact)
        center = surfaces.circle_center(circle)
        _, square = surfaces.circle_square(circle).scalar()
        intervals = [center[name].scalar() for name in ("e1", "e2", "e3")]
        low = np.stack([np.broadcast_to(x, PIECES) for x, _ in intervals])
        high = np.stack([np.broadcast_to(x, PIECES) for _, x in intervals])
        radius = np.broadcast_to(np.sqrt(np.maximum(square, 0)), PIECES)
        middle = ((low - radius).min(axis=1) + (high + radius).max(axis=1)) / 2
        reach = np.maximum(np.abs(low - middle[:, None]), np.abs(high - middle[:, None]))
        bound = float(np.max(np.sqrt((reach**2).sum(axis=0)) + radius)) * (1 + SAFETY)
    if not np.isfinite(bound):
        return np.zeros(3), float("inf")
    return middle, bound


__all__ = ["IntervalRing", "completed", "evolved_bound"]
