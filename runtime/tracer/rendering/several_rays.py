"""First hits of many rays, several at once: the loop of a program of its own, compiled at the first such call."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.build.extension import compiler, load
from ...codegen.execute.items import CLoop
from ...codegen.programs.tracer.scene_needs import SceneNeeds
from ...codegen.programs.tracer.several_rays import DEFERRED, INSTANCE, meets_several, several_rays
from ...common import parallel
from .engines import RAYS_PER_CHUNK, Rays

Array = NDArray[Any]
#: Rays of one call that are worth it, and of all calls so far from which on the program is compiled: a second or two,
#: once, as long as these rays took.
MANY_RAYS, PAYS = 1 << 15, 1 << 21


#: Neighbours that are looked at, and how much nearer to each other than to rays from anywhere they are in order.
SAMPLE, NEAR = 512, 0.125


def are_in_order(rays: Rays, n: int) -> bool:
    """Whether rays that follow each other are much alike, as those of pixels: others take paths of their own."""
    at = np.linspace(0, n - 2, SAMPLE).astype(np.int64)
    apart, spread = 0.0, 0.0
    with np.errstate(all="ignore"):
        for array, stride in ((rays.origins, rays.origin_stride), (rays.directions, rays.direction_stride)):
            if stride:
                rows = array.reshape(-1, 3)
                scale = np.abs(rows[at]).max() or 1.0
                apart += float(np.mean(np.abs(rows[at + 1] - rows[at]))) / scale
                spread += float(np.mean(np.abs(rows[at] - rows[at[::-1]]))) / scale
    return apart <= NEAR * spread  # not where a number is none


class SeveralRays:
    """The loop over rays of a kind of scene.

    Parameters
    ----------
    needs : SceneNeeds
        Of which `meets_several` holds.
    """

    def __init__(self, needs: SceneNeeds) -> None:
        self._loop = CLoop(load(several_rays(needs)), INSTANCE.tag)

    def run(
        self, integers: Array, reals: Array, rays: Rays, n: int, results: dict[str, Array], threads: int | None
    ) -> Array:
        """Fill the results of all rays but those that are returned, by number: for these, single rays are searched."""
        loop = self._loop
        fields = [results[name] for name in ("t", "alpha", "point", "normal", "surface", "status")]
        arrays = [loop.hold(a) for a in (integers, integers, reals, rays.origins, rays.directions, *fields)]
        strides = loop.integers((0, 0, 0, rays.origin_stride, rays.direction_stride, 1, 1, 3, 3, 1, 1))
        part = loop.bind(arrays, strides, loop.integers((0, len(integers), len(reals), *(0,) * 6, 1, 1)))
        parallel.run(part, n, threads, chunk=RAYS_PER_CHUNK)
        return np.flatnonzero(results["status"].reshape(-1) == DEFERRED)


_seen: dict[SceneNeeds, int] = {}


def several_rays_of(needs: SceneNeeds, n: int) -> SeveralRays | None:
    """The loop for these needs and n rays more; None where there is none, no compiler, or it does not pay yet."""
    _seen[needs] = _seen.get(needs, 0) + n
    if compiler() is None or not meets_several(needs):
        return None
    return _loaded(needs) if _seen[needs] >= PAYS else None


@cache
def _loaded(needs: SceneNeeds) -> SeveralRays:
    return SeveralRays(needs)
