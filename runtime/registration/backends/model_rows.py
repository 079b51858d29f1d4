"""Arguments of the drivers of all backends: models as arrays, the rule of a model's center, and the match criterion."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from numpy.typing import NDArray

Array = NDArray[Any]
#: Size of an element: position, direction, radius.
ELEMENT = 7
#: Size of a position.
POSITION = 3


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
    """Rule of a model's robust center.

    Attributes
    ----------
    max_rounds : int
        Largest number of rounds of trimming outliers.
    rank : int
        Rank (in sorted distances) of the object whose distance defines the typical distance.
    outlier_factor : float
        Objects beyond this many typical distances are outliers.
    rounding : float
        Distances below this, relative to the largest coordinate, are rounding.
    min_information : float
        Directions with less information than this, relative to the most, do not determine the center.
    """

    max_rounds: int
    rank: int
    outlier_factor: float
    rounding: float
    min_information: float


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
