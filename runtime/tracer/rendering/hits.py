"""First hits of rays; points and normals of large batches are computed when they are first read."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError

if TYPE_CHECKING:
    from .driver import BoundScene

Array = NDArray[Any]
#: Batches up to this size are copied: it costs nothing, and the caller may then change the arrays.
FEW_RAYS = 4096


@dataclass(frozen=True, eq=False)
class Hits:
    """First hits of rays.

    Points, normals and parameters of large batches on planes and spheres are computed when they are first read, from
    the arrays of rays. If any bit of these has changed by then, an error is raised: read them before, or pass copies.

    Attributes
    ----------
    hit : (...) array of bool
    t : (...) array
        Distance from the ray's origin; NaN where nothing is hit, like the others.
    point, normal : (..., 3) arrays
        The normal has length 1 and faces the ray's origin.
    surface : (...) array of int
        Position in the scene's list of surfaces, -1 for none.
    alpha : (...) array
        Parameter t of the surface's curve, where it has one.
    status : (...) array of `bladesmith.Status`
        `INVALID` for a ray that is not finite or has no direction, or whose point would not be a number;
        `SINGULAR` for one that lies in an evolved surface or meets all of its circles, so that no single point is the
        hit.
    """

    t: Array
    surface: Array
    status: Array
    _evaluate: Callable[[], dict[str, Array]] = field(repr=False)

    @cached_property
    def hit(self) -> Array:
        return np.asarray(self.surface >= 0)

    @cached_property
    def point(self) -> Array:
        return self._deferred_arrays["point"]

    @cached_property
    def normal(self) -> Array:
        return self._deferred_arrays["normal"]

    @cached_property
    def alpha(self) -> Array:
        return self._deferred_arrays["alpha"]

    @cached_property
    def _deferred_arrays(self) -> dict[str, Array]:
        """All arrays, computed at the first read."""
        arrays = self._evaluate()
        self.__dict__["_evaluate"] = lambda: arrays  # the rays are no longer needed
        return arrays

    def __getstate__(self) -> dict[str, Any]:
        """Return all arrays, without the compiled scene and the rays."""
        return {"t": self.t, "surface": self.surface, "status": self.status, "_more": self._deferred_arrays}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state, _evaluate=lambda: state["_more"])


def first_hits(bound: BoundScene, origins: Array, directions: Array, threads: int | None) -> Hits:
    """Compute first hits of rays by the cheaper of the two loops."""
    if not bound.engine.meets_several:
        arrays = bound.first(origins, directions, threads)
        return Hits(arrays["t"], arrays["surface"], arrays["status"], lambda: arrays)
    if max(origins.size, directions.size) <= 3 * FEW_RAYS:
        origins, directions = origins.copy(), directions.copy()
    near = bound.nearest(origins, directions, threads)

    def evaluate() -> dict[str, Array]:
        again = bound.nearest(origins, directions, threads)
        if not np.array_equal(again["checksum"], near["checksum"]):
            raise InputError(
                "the arrays of rays were changed after intersect, and points and normals are worked out from them. Ask "
                "for .point before, or hand over copies."
            )
        return bound.first(origins, directions, threads)

    return Hits(near["t"], near["surface"], near["status"], evaluate)
