"""Normalization of models: frames of their own, near an origin and of about unit size, so that no digit is lost and
tolerances are relative to the size. Motors between two frames are converted to the world.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.formulas.objects.subspaces import length_powers
from ...codegen.programs.registration.registration import KINDS
from ...core.multivector import Algebra, Multivector
from ..backends.driver import Driver
from ..backends.model_rows import CenterRule, MatchCriterion, ModelData

Array = NDArray[Any]
DOUBLE = np.dtype(np.float64)
#: Directions with less information about the center than this, relative to the most, do not determine it.
MIN_INFORMATION = 1e-6
#: Sizes below this fraction of the distance from the world's origin are rounding.
ROUNDING = 1e-12
#: The size of a model is this quantile of its objects' distances from the center: a few far ones are ignored.
SIZE_QUANTILE = 0.75
#: Objects at more than this many sizes from the center are outliers.
OUTLIER_FACTOR = 3.0
#: Largest number of rounds of trimming outliers.
MAX_ROUNDS = 8


@dataclass(frozen=True)
class NormalizedModel:
    """A model in a frame of its own.

    Attributes
    ----------
    center : array (3,)
        Origin of the frame, in the world.
    unit : float
        Unit of length of the frame, a power of two: scaling by it is exact.
    objects : mapping of kind to Multivector (n,)
        Objects in the frame.
    data : ModelData
        Their coefficients and elements for the driver.
    """

    center: Array
    unit: float
    objects: Mapping[str, Multivector]
    data: ModelData

    @property
    def count(self) -> int:
        """Number of objects of all kinds."""
        return sum(x.shape[0] for x in self.objects.values())


def robust_center(driver: Driver, elements: Mapping[str, Array]) -> Array:
    """Center (3,) of least squared distances from all objects except outliers."""
    kinds = np.repeat([KINDS.index(kind) for kind in elements], [len(e) for e in elements.values()])
    rule = CenterRule(MAX_ROUNDS, _rank(len(kinds), SIZE_QUANTILE), OUTLIER_FACTOR, ROUNDING, MIN_INFORMATION)
    return driver.robust_center(kinds, _concatenate(elements), rule)


def _concatenate(arrays: Mapping[str, Array]) -> Array:
    first, *others = arrays.values()
    return np.concatenate([first, *others]) if others else first


def model_size(elements: Mapping[str, Array]) -> float:
    """Size of a model: a quantile of distances from the origin or of radii; zero for flats through the origin."""
    every = _concatenate(elements)
    radii, reach = every[:, 6], np.sqrt(np.einsum("ij,ij->i", every[:, :3], every[:, :3]))
    return max(_quantile(reach, SIZE_QUANTILE), _quantile(radii, 0.5) if radii.any() else 0.0)


def _quantile(values: Array, fraction: float) -> float:
    return float(np.sort(values)[_rank(len(values), fraction)])


def _rank(count: int, fraction: float) -> int:
    return round(fraction * (count - 1))


def normalize_pair(
    driver: Driver, query: Mapping[str, Multivector], reference: Mapping[str, Multivector]
) -> tuple[NormalizedModel, NormalizedModel]:
    """Both models in frames at their own centers, with one unit of length."""
    centered = []
    for objects in (query, reference):
        center = robust_center(driver, {kind: driver.elements(kind, x._data) for kind, x in objects.items()})
        rows = {kind: driver.to_frame(kind, x._data, center) for kind, x in objects.items()}
        centered.append((center, rows, {kind: driver.elements(kind, part) for kind, part in rows.items()}))
    size = max(model_size(elements) for _, _, elements in centered)
    distance = max(float(np.abs(center).max()) for center, _, _ in centered)
    unit = 2.0 ** round(math.log2(size)) if size > ROUNDING * distance else 1.0
    first, second = (
        _normalized_model(center, unit, objects, rows, elements)
        for objects, (center, rows, elements) in zip((query, reference), centered, strict=True)
    )
    return first, second


def _normalized_model(
    center: Array, unit: float, objects: Mapping[str, Multivector], rows: Mapping[str, Array],
    elements: Mapping[str, Array],
) -> NormalizedModel:  # fmt: skip
    """Model in its frame, from coefficients and elements relative to its center."""
    scale = 1 / unit
    inside, sides = {}, {}
    for kind, x in objects.items():
        type_ = x.algebra.type_of(x.kind, DOUBLE)
        inside[kind] = scale_coefficients(x._make(type_, rows[kind], x.shape, x._status), scale)
        sides[kind] = elements[kind] * (scale, scale, scale, 1.0, 1.0, 1.0, scale)  # exact, as unit is
    return NormalizedModel(center, unit, inside, ModelData({kind: x._data for kind, x in inside.items()}, sides))


def criterion_within(
    max_distance: float, min_fraction: float = 0.0, align: bool = True, length: float = 1.0
) -> MatchCriterion:
    """Criterion of a match: (angle^2 length^2 + 3 distance^2)/4, as of rotors, at most ``max_distance`` squared."""
    return MatchCriterion((0.75, 0.25 * length * length, 0.75), max_distance * max_distance, min_fraction, align)


def scale_coefficients(x: Multivector, scale: float) -> Multivector:
    """Unit objects, motors or twists, scaled about the origin; exact for powers of two."""
    return x._make(x._type, x._data * scale ** _powers(x.algebra, x._type.blades, x.grades == (1,)), x.shape, x._status)


@cache
def _powers(algebra: Algebra, blades: tuple[int, ...], are_points: bool) -> Array:
    """Powers of the unit of length of coefficients; one more for points, whose weight stays 1."""
    return np.array(length_powers(algebra, blades), np.float64) + are_points


def motors_to_world(
    driver: Driver, motors: Array, query: NormalizedModel, reference: NormalizedModel, algebra: Algebra
) -> Multivector:
    """Motors (n,) of the world, with <R>_0 >= 0, from motors (n, 8) between the frames of two models."""
    inside = scale_coefficients(algebra.wrap(algebra.kind("motor"), motors), query.unit)
    motors_ = driver.motors_to_world(inside._data, reference.center, query.center)
    return algebra.wrap(algebra.kind("motor"), motors_)


def twists_to_world(driver: Driver, twists: Array, model: NormalizedModel, algebra: Algebra) -> Multivector:
    """Twists (n,) of the world, from twists (n, 6) in a model's frame."""
    inside = scale_coefficients(algebra.wrap(algebra.kind("twist"), twists), model.unit)
    return algebra.wrap(algebra.kind("twist"), driver.twists_to_world(inside._data, model.center))
