"""Models in frames of their own: near an origin, of about unit size, so that no digit is lost and tolerances mean one
thing. A motor between two frames is taken back to the world.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..algebras import Algebra
from ..codegen.formulas.subspaces import length_powers
from ..codegen.programs.reform import KINDS
from ..multivector import Multivector
from .engine import Driver
from .sides import Closeness, MiddleRule, Side

Array = NDArray[Any]
DOUBLE = np.dtype(np.float64)
#: Directions in which the objects say less than this, relative to the most, do not place a model's centre.
LOOSE = 1e-6
#: A size below this share of how far the objects are from the world's origin is rounding.
ROUNDING = 1e-12
#: A model is as large as this quantile of its objects' distances from the centre: a few far ones do not count.
SIZE_QUANTILE = 0.75
#: Objects more than so many times as far from the centre as that do not place it; rounds of leaving them out, at most.
FAR, ROUNDS = 3.0, 8


@dataclass(frozen=True)
class Local:
    """A model in its frame.

    Attributes
    ----------
    center : array (3,)
        The frame's origin, in the world.
    unit : float
        The frame's unit of length, a power of two: scaling by it is exact.
    objects : mapping of kind to Multivector (n,)
        In the frame.
    side : Side
        The same for the driver.
    """

    center: Array
    unit: float
    objects: Mapping[str, Multivector]
    side: Side

    @property
    def count(self) -> int:
        """Objects of all kinds."""
        return sum(x.shape[0] for x in self.objects.values())


def middle(driver: Driver, elements: Mapping[str, Array]) -> Array:
    """The point (3,) nearest to all objects together but for a few far ones, in the sense of least squares."""
    kinds = np.repeat([KINDS.index(kind) for kind in elements], [len(e) for e in elements.values()])
    rule = MiddleRule(ROUNDS, _place(len(kinds), SIZE_QUANTILE), FAR, ROUNDING, LOOSE)
    return driver.middle(kinds, _together(elements), rule)


def _together(arrays: Mapping[str, Array]) -> Array:
    first, *others = arrays.values()
    return np.concatenate([first, *others]) if others else first


def size_of(elements: Mapping[str, Array]) -> float:
    """How far objects are from the origin, or how large, whichever is more; zero for flats all through it."""
    every = _together(elements)
    radii, reach = every[:, 6], np.sqrt(np.einsum("ij,ij->i", every[:, :3], every[:, :3]))
    return max(_quantile(reach, SIZE_QUANTILE), _quantile(radii, 0.5) if radii.any() else 0.0)


def _quantile(values: Array, share: float) -> float:
    return float(np.sort(values)[_place(len(values), share)])


def _place(count: int, share: float) -> int:
    return round(share * (count - 1))


def local_pair(
    driver: Driver, query: Mapping[str, Multivector], reference: Mapping[str, Multivector]
) -> tuple[Local, Local]:
    """Both models in frames about their own centres, with one unit of length."""
    moved = []
    for objects in (query, reference):
        center = middle(driver, {kind: driver.elements(kind, x._data) for kind, x in objects.items()})
        rows = {kind: driver.seen(kind, x._data, center) for kind, x in objects.items()}
        moved.append((center, rows, {kind: driver.elements(kind, part) for kind, part in rows.items()}))
    size = max(size_of(elements) for _, _, elements in moved)
    far = max(float(np.abs(center).max()) for center, _, _ in moved)
    unit = 2.0 ** round(math.log2(size)) if size > ROUNDING * far else 1.0
    first, second = (
        _scaled(center, unit, objects, rows, elements)
        for objects, (center, rows, elements) in zip((query, reference), moved, strict=True)
    )
    return first, second


def _scaled(
    center: Array, unit: float, objects: Mapping[str, Multivector], rows: Mapping[str, Array],
    elements: Mapping[str, Array],
) -> Local:  # fmt: skip
    """A model in its frame, of rows and elements as they are seen from its centre."""
    scale = 1 / unit
    inside, sides = {}, {}
    for kind, x in objects.items():
        type_ = x.algebra.type_of(x.kind, DOUBLE)
        inside[kind] = scaled(x._make(type_, rows[kind], x.shape, x._status), scale)
        sides[kind] = elements[kind] * (scale, scale, scale, 1.0, 1.0, 1.0, scale)  # exact, as unit is
    return Local(center, unit, inside, Side({kind: x._data for kind, x in inside.items()}, sides))


def closeness_within(reach: float, least: float = 0.0, align: bool = True, length: float = 1.0) -> Closeness:
    """When a motor lays one object on another: within a reach, by (angle^2 length^2 + 3 distance^2)/4, as of rotors."""
    return Closeness((0.75, 0.25 * length * length, 0.75), reach * reach, least, align)


def scaled(x: Multivector, scale: float) -> Multivector:
    """Unit objects, motors or twists, scaled about the origin; exact for powers of two."""
    return x._make(x._type, x._data * scale ** _powers(x.algebra, x._type.blades, x.grades == (1,)), x.shape, x._status)


@cache
def _powers(algebra: Algebra, blades: tuple[int, ...], are_points: bool) -> Array:
    """With which power of the unit of length coefficients go; of points, whose weight stays 1, one more."""
    return np.array(length_powers(algebra, blades), np.float64) + are_points


def outward(driver: Driver, motors: Array, query: Local, reference: Local, algebra: Algebra) -> Multivector:
    """World motors (n,), with <R>_0 >= 0, of motors (n, 8) from the query's frame to the reference's."""
    inside = scaled(algebra.wrap(algebra.kind("motor"), motors), query.unit)
    found = driver.unseen(inside._data, reference.center, query.center)
    return algebra.wrap(algebra.kind("motor"), found)


def outward_twists(driver: Driver, twists: Array, model: Local, algebra: Algebra) -> Multivector:
    """Twists (n,) of the world, of twists (n, 6) of a model's frame."""
    inside = scaled(algebra.wrap(algebra.kind("twist"), twists), model.unit)
    return algebra.wrap(algebra.kind("twist"), driver.unseen_twists(inside._data, model.center))
