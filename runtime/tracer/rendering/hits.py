"""What rays meet first."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError

if TYPE_CHECKING:
    from .driver import BoundScene

Array = NDArray[Any]
#: Rays in fewer numbers are copied: it costs nothing, and what happens to the caller's arrays does not matter.
FEW_RAYS = 4096


@dataclass(frozen=True, eq=False)
class Hits:
    """The first points that rays meet.

    Points, normals and parameters of large batches on planes and spheres are worked out when they are first asked for,
    from the arrays of rays. If these have been changed by then in any bit, that is an error: ask before, or hand over
    copies.

    Attributes
    ----------
    hit : (...) array of bool
    t : (...) array
        Distance from the ray's origin; NaN where nothing is hit, like the others.
    point, normal : (..., 3) arrays
        The normal has length 1 and looks to where the ray comes from.
    surface : (...) array of int
        Position in the scene's list of surfaces, -1 for none.
    alpha : (...) array
        Parameter t of the surface's curve, where it has one.
    status : (...) array of `bladesmith.Status`
        `INVALID` for a ray that is not finite or has no direction, or whose point would be no number;
        `SINGULAR` for one that lies in an evolved surface or meets all of its circles, of which no single point can be
        told.
    """

    t: Array
    surface: Array
    status: Array
    _ask: Callable[[], dict[str, Array]] = field(repr=False)

    @cached_property
    def hit(self) -> Array:
        return np.asarray(self.surface >= 0)

    @cached_property
    def point(self) -> Array:
        return self._more["point"]

    @cached_property
    def normal(self) -> Array:
        return self._more["normal"]

    @cached_property
    def alpha(self) -> Array:
        return self._more["alpha"]

    @cached_property
    def _more(self) -> dict[str, Array]:
        """The whole answer."""
        found = self._ask()
        self.__dict__["_ask"] = lambda: found  # the rays are no longer needed
        return found

    def __getstate__(self) -> dict[str, Any]:
        """Everything worked out: the compiled scene and the rays stay behind."""
        return {"t": self.t, "surface": self.surface, "status": self.status, "_more": self._more}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state, _ask=lambda: state["_more"])


def first_hits(bound: BoundScene, origins: Array, directions: Array, threads: int | None) -> Hits:
    """First hits of rays, in the way that costs least."""
    if not bound.engine.meets_several:
        found = bound.first(origins, directions, threads)
        return Hits(found["t"], found["surface"], found["status"], lambda: found)
    if max(origins.size, directions.size) <= 3 * FEW_RAYS:
        origins, directions = origins.copy(), directions.copy()
    near = bound.nearest(origins, directions, threads)

    def ask() -> dict[str, Array]:
        again = bound.nearest(origins, directions, threads)
        if not np.array_equal(again["seal"], near["seal"]):
            raise InputError(
                "the arrays of rays were changed after intersect, and points and normals are worked out from them. Ask "
                "for .point before, or hand over copies."
            )
        return bound.first(origins, directions, threads)

    return Hits(near["t"], near["surface"], near["status"], ask)
