"""Two models as the drivers of all backends read them: rows of numbers, what a model's middle is, and when two objects
may be one.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from numpy.typing import NDArray

Array = NDArray[Any]
#: Numbers of an element: position, direction, radius; coordinates of a position.
ELEMENT, POSITION = 7, 3


@dataclass(frozen=True)
class Side:
    """One model as the driver reads it.

    Attributes
    ----------
    rows : mapping of kind to array (n, k)
        Coefficients of unit objects.
    elements : mapping of kind to array (n, 7)
        Positions, directions and radii (formula `registration.element`).
    """

    rows: Mapping[str, Array]
    elements: Mapping[str, Array]


class MiddleRule(NamedTuple):
    """What a model's middle is nearest to.

    Attributes
    ----------
    rounds : int
        Of leaving out far objects, at most.
    place : int
        As far as the object that stands there, in the order of distances, is usual.
    far : float
        Objects more than so many times as far as that do not count.
    rounding : float
        Distances below this, relative to the largest coordinate, are rounding.
    loose : float
        Directions in which the objects say less than this, relative to the most, do not place the middle.
    """

    rounds: int
    place: int
    far: float
    rounding: float
    loose: float


@dataclass(frozen=True)
class Closeness:
    """When two objects may be one.

    Attributes
    ----------
    weights : (float, float, float)
        Of squared differences of positions, directions and radii.
    limit : float
        The sum of them up to which they may be one.
    least : float
        A motor is given up early if a smaller share of objects has a counterpart.
    align : bool
        x and -x are one object.
    """

    weights: tuple[float, float, float]
    limit: float
    least: float = 0.0
    align: bool = True
