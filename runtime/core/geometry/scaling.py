"""Lengths in coefficients: a unit in which objects are small numbers, and objects in other units."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..multivector import Multivector

if TYPE_CHECKING:
    from ..multivector import Algebra

Array = NDArray[Any]
#: Share of an object's largest coefficient that is none: of a plane, say, what a sphere would have.
ROUNDING = 1e-13


def length_powers(algebra: Algebra, blades: Sequence[int]) -> Array:
    """With what power of a length coefficients on blades grow: n_inf goes with a length, n0 with one less."""
    powers = {"ni": 1, "0": 1, "no": -1}
    bits = [powers.get(v, 0) for v in algebra.vectors]
    return np.array([sum(p for i, p in enumerate(bits) if b >> i & 1) for b in blades])


def lengths_of(x: Multivector) -> Array:
    """A length (...) that makes each object small numbers, its largest distance or radius; 0 for none."""
    sizes, powers = np.abs(x.values), length_powers(x.algebra, x.kind.blades)
    groups = np.stack([sizes[..., powers == p].max(-1) for p in range(powers.min(), powers.max() + 1)])
    groups = np.where(groups > ROUNDING * sizes.max(-1), groups, 0)
    first = (groups > 0).argmax(0)
    base = np.take_along_axis(groups, first[None], 0)[0]
    steps = np.arange(len(groups)).reshape(-1, *[1] * base.ndim) - first
    ratios = np.divide(groups, base, out=np.zeros_like(groups), where=base > 0)
    found: Array = np.where(steps > 0, ratios ** (1 / np.maximum(steps, 1)), 0).max(0)
    return found


def length_of(objects: Sequence[Multivector]) -> Array:
    """A length (...) for all of these, item by item, a power of two; 1 for none."""
    largest = np.max([lengths_of(x) for x in objects], 0) if objects else np.zeros(())
    return np.asarray(2.0 ** np.round(np.log2(np.where(largest > 0, largest, 1.0))))


def in_units(x: Multivector, unit: Any) -> Multivector:
    """Objects in a world whose lengths are measured by these units; but for a factor."""
    powers = length_powers(x.algebra, x.kind.blades)
    scales = np.asarray(unit, float)[..., None] ** (powers.min() - powers.astype(float))
    return x.algebra.wrap(x.kind.layout, np.ascontiguousarray(x.values * scales))
