"""Binding of a scene to the compiled driver, and calls of the driver's loops on arrays.

The only module of the tracer that depends on the layout of the driver's structures (scene_types.h and scene_common.h in
templates/c/programs/tracer).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.programs.tracer.surface_kinds import METHODS
from ...common import parallel
from ..acceleration.bvh import round_outward
from .program import Engine
from .surface_tables import SurfaceTables

Array = NDArray[Any]
#: Initial capacity of arrays of a line's points on a surface.
FEW_ROOTS = 2
#: Rays per chunk, a few milliseconds at most; each chunk has one checksum, as in scene_common.h.
RAYS_PER_CHUNK = 4096
#: Largest number of chunks in one call of the loop over packets of rays.
CHUNKS_AT_ONCE = 16
#: Calls of that loop for each thread, for balance.
CALLS_PER_THREAD = 4
#: C types of the driver's arrays other than numbers in the scene's precision.
_TYPES = {"surface": "int32_t *", "count": "int32_t *", "status": "uint8_t *", "checksum": "uint64_t *"}


class BoundScene:
    """A driver's scene structure and the arrays that it points into."""

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
        self.engine, self.dtype = engine, np.dtype(dtype)
        self.single = int(self.dtype == np.float32)
        self._buffers: list[Any] = []
        scene = self._scene = engine.ffi.new("bs_scene *")
        for kind, members in rows.items():
            entry = scene.surfaces[engine.numbers[kind]]
            entry.count = len(members.constants)
            if entry.count:
                entry.constants = self._pointer(members.constants)
                entry.ids = engine.ffi.cast("int32_t *", self._keep(members.ids))
                entry.boxes = self._keep(round_outward(members.boxes[..., None], self.dtype.type))
        scene.tree.reach = rows.largest_coordinate
        if engine.needs.tree:
            self._bind_tree(rows)
        for name, value in (("materials", materials), ("lights", lights), ("camera", camera), ("sky", sky)):
            if value is not None and value.size:
                setattr(scene, name, self._pointer(value))
        scene.light_count = 0 if lights is None else len(lights)
        scene.depth, scene.grid = depth, grid
        scene.method, scene.samples = METHODS[method], samples

    def _bind_tree(self, rows: SurfaceTables) -> None:
        """Bind the tree of the rows; its items number the kinds in the order of the tables."""
        ffi, tree, built = self.engine.ffi, self._scene.tree, rows.tree(self.engine)
        items = built.items.copy()
        items[:, 0] = np.array([self.engine.numbers[kind] for kind in rows], np.int32)[built.items[:, 0]]
        tree.nodes = ffi.cast("bs_node *", self._keep(built.nodes))
        tree.items = ffi.cast("int32_t *", self._keep(items))
        tree.node_count, tree.item_count, tree.unbounded = len(built.parts), len(items), built.unbounded
        tree.whole, tree.center, tree.unit = built.whole.tolist(), built.center.tolist(), built.unit

    def _keep(self, array: Array) -> Any:
        buffer = self.engine.ffi.from_buffer(np.ascontiguousarray(array))
        self._buffers.append(buffer)
        return buffer

    def _pointer(self, array: Array) -> Any:
        with np.errstate(over="ignore"):
            return self._keep(np.asarray(array, self.dtype))

    def _rays(self, origins: Array, directions: Array) -> tuple[list[Any], tuple[int, ...]]:
        """Structure of rays, followed by the buffers that it points into; and the shape of the batch."""
        lead = np.broadcast_shapes(origins.shape[:-1], directions.shape[:-1])
        rays = [self.engine.ffi.new("bs_rays *")]
        for name, array in (("origin", origins), ("direction", directions)):
            single = array.size == 3
            whole = array if single or array.shape == (*lead, 3) else np.broadcast_to(array, (*lead, 3))
            rays.append(self.engine.ffi.from_buffer(np.ascontiguousarray(whole, self.dtype)))
            setattr(rays[0], f"{name}s", rays[-1])
            setattr(rays[0], f"{name}_stride", 0 if single else 3)
        return rays, lead

    def _run(
        self,
        function: Callable[..., None],
        rays: list[Any],
        n: int,
        results: Mapping[str, Array],
        roots: int,
        threads: int | None,
        chunks: int = 1,
    ) -> None:
        ffi = self.engine.ffi
        hits = ffi.new("bs_hits *")
        buffers = {name: ffi.from_buffer(array) for name, array in results.items()}
        for name, buffer in buffers.items():
            setattr(hits, name, ffi.cast(_TYPES.get(name, "void *"), buffer))
        hits.roots = roots
        scene, single = self._scene, self.single

        def part(begin: int, end: int) -> None:
            function(scene, single, begin, end, rays[0], hits)

        parallel.run(part, n, threads, chunk=chunks * RAYS_PER_CHUNK if n > RAYS_PER_CHUNK else None)

    def first(self, origins: Array, directions: Array, threads: int | None = None) -> dict[str, Array]:
        """First hits of rays: t, point, normal, alpha, surface, status."""
        rays, lead = self._rays(origins, directions)
        results = {**self._floats(lead), **self._codes(lead)}
        self._run(self.engine.lib.bs_scene_first, rays, math.prod(lead), results, 1, threads)
        return results

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
        self._run(self.engine.lib.bs_scene_wide, rays, n, results, 1, threads, min(max(shared, 1), CHUNKS_AT_ONCE))
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
        self._run(self.engine.lib.bs_scene_all, rays, math.prod(lead), results, roots, threads)
        return {"row" if name == "surface" else name: array for name, array in results.items()}

    def _floats(self, lead: tuple[int, ...]) -> dict[str, Array]:
        shapes = {"t": lead, "alpha": lead, "point": (*lead, 3), "normal": (*lead, 3)}
        return {name: np.empty(shape, self.dtype) for name, shape in shapes.items()}

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
        ffi, scene, single, function = self.engine.ffi, self._scene, self.single, self.engine.lib.bs_scene_render
        buffers = {name: ffi.from_buffer(array) for name, array in arrays.items()}
        picture = ffi.new("bs_picture *", {"width": width, "height": height, "first": first})
        for name, buffer in buffers.items():
            setattr(picture, name, ffi.cast("int32_t *" if name == "cost" else "void *", buffer))

        def paint(begin: int, end: int, _buffers: Any = buffers) -> None:
            function(scene, single, begin, end, picture)

        return paint
