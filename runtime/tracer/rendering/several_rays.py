"""First hits of many rays, and pixels, several at once: loops of programs of their own, compiled once they pay."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.build.extension import compiler, load
from ...codegen.execute.items import CLoop
from ...codegen.programs.tracer.records import DEFERRED, PICTURE
from ...codegen.programs.tracer.scene_needs import SceneNeeds
from ...common import parallel
from .engines import RAYS_PER_CHUNK, Part, Rays

Array = NDArray[Any]
#: Rays of one call that are worth it, and of all calls so far from which on the program is compiled: a second or two,
#: once, as long as these rays took.
MANY_RAYS, PAYS = 1 << 15, 1 << 21
#: The same of samples of pictures, whose program takes five.
MANY_SAMPLES, PICTURES_PAY = 1 << 16, 1 << 22

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
    loop : CLoop
        Of the program "rays".
    """

    def __init__(self, loop: CLoop) -> None:
        self._loop = loop

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


def several_rays_of(needs: SceneNeeds, n: int) -> SeveralRays | None:
    """The loop for these needs and n rays more; None where there is none, no compiler, or it does not pay yet."""
    has_curves = bool(needs.methods)  # the scene's own program meets several rays on planes and spheres
    loop = _loop_of("rays", needs, n, PAYS) if has_curves else None
    return None if loop is None else SeveralRays(loop)


def several_pixels_of(
    needs: SceneNeeds, samples: int, integers: Array, reals: Array, picture: Array, color: Array
) -> Part | None:
    """The loop over pixels for these needs and so many samples more; None as by `several_rays_of`.

    Pixels that are left to the search of single rays have a color that is no number.
    """
    loop = _loop_of("pixels", needs, samples, PICTURES_PAY)
    if loop is None:
        return None
    shared = [loop.hold(a) for a in (integers, integers, reals, picture)]
    strides, counts = loop.integers((1, 0, 0, 0, 0, 3)), loop.integers((0, 0, len(integers), len(reals), 0, 0))
    rows, first = color.reshape(-1, 3), int(PICTURE.view(picture).first)

    def part(begin: int, end: int) -> None:
        arrays = [np.arange(begin, end, dtype=np.int64), rows[begin - first : end - first]]
        pixels, colors = (loop.hold(a) for a in arrays)
        loop.bind([pixels, *shared, colors], strides, counts)(0, end - begin)

    return part


_seen: dict[tuple[str, SceneNeeds], int] = {}


def _loop_of(name: str, needs: SceneNeeds, n: int, pays: int) -> CLoop | None:
    """The loop of a program, if n rays more are worth it."""
    from ...codegen.programs.tracer.several_rays import meets_several

    key = SceneNeeds(needs.kinds, needs.methods, reflection=needs.reflection, checker=needs.checker, tree=needs.tree)
    _seen[name, key] = _seen.get((name, key), 0) + n
    if compiler() is None or not meets_several(key):
        return None
    return _loaded(name, key) if _seen[name, key] >= pays or _was_made(name, key) else None


@cache
def _was_made(name: str, needs: SceneNeeds) -> bool:
    """Whether an earlier process has compiled the program."""
    from ...codegen.programs.tracer.several_rays import PROGRAMS

    return PROGRAMS[name].is_made(needs)


@cache
def _loaded(name: str, needs: SceneNeeds) -> CLoop:
    from ...codegen.programs.tracer.several_rays import INSTANCE, PROGRAMS

    return CLoop(load(PROGRAMS[name].extension(needs)), INSTANCE.tag)
