"""Binding of a scene to its compiled program, and calls of the program's loops on arrays."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.execute.result_memory import STORE
from ...codegen.programs.tracer.records import LEFT_OVER, PICTURE
from ...codegen.programs.tracer.surface_kinds import METHODS
from ...common import parallel
from .engines import RAYS_PER_CHUNK, Engine, Rays
from .scene_arrays import scene_arrays
from .several_rays import MANY_RAYS, MANY_SAMPLES, are_in_order, several_pixels_of, several_rays_of
from .surface_tables import SurfaceTables

Array = NDArray[Any]
#: Initial capacity of arrays of a line's points on a surface.
FEW_ROOTS = 2
#: Largest number of chunks in one call of the loop over packets of rays.
CHUNKS_AT_ONCE = 16
#: Calls of that loop for each thread, for balance.
CALLS_PER_THREAD = 4


class BoundScene:
    """A scene's arrays, held by the program that reads them."""

    def __init__(
        self,
        engine: Engine,
        rows: SurfaceTables,
        dtype: Any,
        materials: Array | None = None,
        lights: Array | None = None,
        camera: Array | None = None,
        sky: Array | None = None,
        depth: int = 0,
        grid: int = 1,
        method: str = "isolate",
        samples: int = 64,
    ) -> None:
        self.engine, self.dtype, self.method, self._grid = engine, np.dtype(dtype), method, grid
        pictures = {"materials": materials, "lights": lights, "camera": camera, "sky": sky}
        lamps = 0 if lights is None else len(lights)
        settings = {"lights": lamps, "depth": depth, "grid": grid, "method": METHODS[method], "samples": samples}
        tree = rows.tree(engine) if engine.needs.tree else None
        arrays = scene_arrays(engine.needs.kinds, rows, tree, self.dtype, pictures, settings, engine.is_c)
        self._arrays = arrays
        self._scene = engine.scene(*arrays)

    def _rays(self, origins: Array, directions: Array) -> tuple[Rays, tuple[int, ...]]:
        """Arrays of rays with their strides, and the shape of the batch."""
        lead = np.broadcast_shapes(origins.shape[:-1], directions.shape[:-1])
        rays = {}
        for name, array in (("origin", origins), ("direction", directions)):
            single = array.size == 3
            whole = array if single or array.shape == (*lead, 3) else np.broadcast_to(array, (*lead, 3))
            rays[name] = np.ascontiguousarray(whole, self.dtype), 0 if single else 3
        return Rays(*rays["origin"], *rays["direction"]), lead

    def _run(
        self,
        loop: str,
        rays: Rays,
        n: int,
        results: Mapping[str, Array],
        roots: int,
        threads: int | None,
        chunks: int = 1,
        unit: int = 1,
    ) -> None:
        part = self._scene.hits_loop(loop, rays, results, roots)
        chunk = self.engine.chunk
        wanted = chunks * chunk if n > chunk else None
        parallel.run(part, n, threads, chunk=wanted, unit=unit, grain=self.engine.grain)

    def first(self, origins: Array, directions: Array, threads: int | None = None) -> dict[str, Array]:
        """First hits of rays: t, point, normal, alpha, surface, status."""
        rays, lead = self._rays(origins, directions)
        n = math.prod(lead)
        is_worth = n >= MANY_RAYS and self._may_meet_several and are_in_order(rays, n)
        several = several_rays_of(self.engine.needs, n) if is_worth else None
        if several is None:
            return self._first_of_each(rays, lead, threads)
        results = {**self._floats(lead), **self._codes(lead)}
        left = several.run(*self._arrays, rays, n, results, threads)
        if len(left):
            pairs = (rays.origins, rays.origin_stride), (rays.directions, rays.direction_stride)
            starts, towards = (a.reshape(-1, 3)[left] if stride else a for a, stride in pairs)
            some, shape = self._rays(starts, np.broadcast_to(towards, (len(left), 3)))
            for name, found in self._first_of_each(some, shape, threads).items():
                whole = results[name]
                whole.reshape(n, *whole.shape[len(lead) :])[left] = found
        return results

    def _first_of_each(self, rays: Rays, lead: tuple[int, ...], threads: int | None) -> dict[str, Array]:
        results = {**self._floats(lead), **self._codes(lead)}
        self._run("first", rays, math.prod(lead), results, 1, threads)
        return results

    @property
    def _may_meet_several(self) -> bool:
        return self.engine.is_c and self.engine.grain == 1 and self.dtype == np.float64 and self.method == "isolate"

    def nearest(self, origins: Array, directions: Array, threads: int | None = None) -> dict[str, Array]:
        """First hits of packets of rays, reduced to t, surface and status: the same bits as `first`.

        The result "checksum" (chunks,) is a digest of the bits of each chunk of rays, which detects changed rays.
        """
        threads = parallel.thread_count(threads)
        rays, lead = self._rays(origins, directions)
        n = math.prod(lead)
        checksum = np.zeros(-(-n // RAYS_PER_CHUNK), np.uint64)
        results = {"t": np.empty(lead, self.dtype), **self._codes(lead), "checksum": checksum}
        if n <= RAYS_PER_CHUNK:
            threads = 1  # one checksum
        shared = -(-len(checksum) // (CALLS_PER_THREAD * threads))
        self._run("wide", rays, n, results, 1, threads, min(max(shared, 1), CHUNKS_AT_ONCE), unit=RAYS_PER_CHUNK)
        return results

    @staticmethod
    def _codes(lead: tuple[int, ...]) -> dict[str, Array]:
        return {"surface": np.empty(lead, np.int32), "status": np.empty(lead, np.uint8)}

    def all(self, origins: Array, directions: Array, threads: int | None = None) -> dict[str, Array]:
        """All points of lines on the scene's only surface: t, point, normal, alpha, row, count, status.

        Arrays hold the largest number of points that occurs. More than two are rare, and memory that is never read
        costs more than the geometry: lines with more are intersected again.
        """
        results = self._all(origins, directions, FEW_ROOTS, threads)
        most = int(np.max(results["count"], initial=0))
        if most <= FEW_ROOTS:
            return results
        lead = results["count"].shape
        crowded = results["count"] > FEW_ROOTS
        starts, towards = (np.broadcast_to(x, (*lead, 3))[crowded] for x in (origins, directions))
        again = self._all(starts, towards, most, threads)
        for name, few in results.items():
            if name in ("count", "status"):
                few[crowded] = again[name]
                continue
            many = np.empty((*lead, most, *few.shape[len(lead) + 1 :]), few.dtype)
            many.fill(-1 if name == "row" else np.nan)
            rows = many.reshape(math.prod(lead), most, -1)
            rows[:, :FEW_ROOTS] = few.reshape(math.prod(lead), FEW_ROOTS, -1)
            many[crowded] = again[name]
            results[name] = many
        return results

    def _all(self, origins: Array, directions: Array, roots: int, threads: int | None) -> dict[str, Array]:
        rays, lead = self._rays(origins, directions)
        results = {
            **self._floats((*lead, roots)),
            "surface": np.empty((*lead, roots), np.int32),
            "count": np.empty(lead, np.int32),
            "status": np.empty(lead, np.uint8),
        }
        self._run("all", rays, math.prod(lead), results, roots, threads)
        return {"row" if name == "surface" else name: array for name, array in results.items()}

    def _floats(self, lead: tuple[int, ...]) -> dict[str, Array]:
        """Arrays for results, on one block of memory, so that large ones use that of earlier calls again."""
        rows = {"t": lead, "alpha": lead, "point": (*lead, 3), "normal": (*lead, 3)}
        ends = np.cumsum([math.prod(shape) for shape in rows.values()])
        memory = STORE.empty((int(ends[-1]),), self.dtype)
        parts = np.split(memory, ends[:-1])
        return {name: part.reshape(shape) for (name, shape), part in zip(rows.items(), parts, strict=True)}

    def painter(
        self, width: int, height: int, arrays: Mapping[str, Array], first: int = 0
    ) -> Callable[[int, int], None]:
        """Loop over the pixels of a picture: a function of (begin, end), in reading order.

        Parameters
        ----------
        width, height : int
            Size of the whole picture.
        arrays : mapping
            Requested layers, by the names of the driver's structure.
        first : int
            Index of the pixel that the arrays begin with.
        """
        layout = PICTURE.zeros()
        layout.width, layout.height, layout.first = width, height, first
        for name in arrays:
            setattr(layout, name, 1)
        picture, several = np.asarray(layout), None
        if "color" in arrays and self._may_meet_several and width * height * self._grid**2 >= MANY_SAMPLES:
            color, needs = arrays["color"], self.engine.needs
            several = several_pixels_of(needs, color.size // 3 * self._grid**2, *self._arrays, picture, color)
        if several is None:
            return self._scene.picture_loop(picture, arrays)
        layout.color = LEFT_OVER
        others = self._scene.picture_loop(picture, arrays)

        def paint(begin: int, end: int) -> None:
            several(begin, end)
            others(begin, end)

        return paint
