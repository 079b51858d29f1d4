"""Arguments of all backends: models as arrays, the rule of a model's center, and the match criterion."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...codegen.algorithms.registration_layout import Settings

Array = NDArray[Any]


@dataclass(frozen=True)
class ModelData:
    """A model as arrays.

    Attributes
    ----------
    rows : mapping of kind to array (n, k)
        Coefficients of unit objects.
    elements : mapping of kind to array (n, 7)
        Positions, directions and radii (formula `registration.element`).
    """

    rows: Mapping[str, Array]
    elements: Mapping[str, Array]


class CenterRule(NamedTuple):
    """Rule of a model's robust center, by the names of the algorithm's parameters.

    Attributes
    ----------
    rounds : int
        Largest number of rounds of trimming outliers.
    rank : int
        Rank (in sorted distances) of the object whose distance defines the typical distance.
    outlier_factor : float
        Objects beyond this many typical distances are outliers.
    rounding : float
        Distances below this, relative to the largest coordinate, are rounding.
    rank_tolerance : float
        Directions with less information than this, relative to the most, do not determine the center.
    """

    rounds: int
    rank: int
    outlier_factor: float
    rounding: float
    rank_tolerance: float


@dataclass(frozen=True)
class MatchCriterion:
    """Criterion of a match of two objects.

    Attributes
    ----------
    weights : (float, float, float)
        Weights of squared differences of positions, directions and radii.
    limit : float
        Largest weighted sum of a match.
    early_exit_fraction : float
        A motor is given up early if a smaller fraction of objects has a counterpart.
    align : bool
        True if x and -x are the same object.
    """

    weights: tuple[float, float, float]
    limit: float
    early_exit_fraction: float = 0.0
    align: bool = True


@lru_cache(64)
def settings_of(criterion: MatchCriterion) -> Array:
    """A criterion as algorithms read it; angle^2 = 2 (1 - cos), nearly."""
    settings = Settings.zeros()
    position, direction, radius = criterion.weights
    settings.weights = (position, 2 * direction, radius)
    settings.limit, settings.least = criterion.limit, criterion.early_exit_fraction
    settings.other = -1.0 if criterion.align else 1.0
    found: Array = settings.view(np.ndarray)
    return found


def integers(array: Array) -> Array:
    """Array as algorithms read indices."""
    return np.ascontiguousarray(array, np.int64)


def reals(array: Array) -> Array:
    """Array as algorithms read numbers."""
    return np.ascontiguousarray(array, np.float64)
