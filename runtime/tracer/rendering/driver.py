"""A scene as the compiled driver reads it, and the driver's loops called on arrays.

The only module of the tracer that knows the layout of the driver's structures (templates/c/scene_types.h).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import parallel
from ..codegen.programs.surface_kinds import METHODS
from .engine import Engine
from .rows import SceneRows
from .tree import outward

Array = NDArray[Any]
#: Numbers that the driver reads per surface and per light, as in templates/c/scene_common.h.
MATERIAL_SIZE, LIGHT_SIZE = 17, 6
#: Points of a line on a surface that arrays have room for at first.
FEW_ROOTS = 2
#: Rays per chunk: a few milliseconds at most. As many share a seal, as in templates/c/scene_common.h.
RAYS_PER_CHUNK = 4096
#: Chunks at most that are one call where several rays are met at once, and calls for each thread.
CHUNKS_AT_ONCE, CALLS_PER_THREAD = 16, 4
#: What the driver's arrays hold, where that is not the scene's own precision.
_TYPES = {"surface": "int32_t *", "count": "int32_t *", "status": "uint8_t *", "seal": "uint64_t *"}


class BoundScene:
    """A driver's scene structure and the arrays that it points into."""

    def __init__(
        self,
        engine: Engine,
        rows: SceneRows,
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
        self._kept: list[Any] = []
        scene = self._scene = engine.ffi.new("bs_scene *")
        for kind, members in rows.items():
            entry = scene.surfaces[engine.numbers[kind]]
            entry.count = len(members.constants)
            if entry.count:
                entry.constants = self._pointer(members.constants)
                entry.ids = engine.ffi.cast("int32_t *", self._keep(members.ids))
                entry.boxes = self._keep(outward(members.boxes[..., None], self.dtype.type))
        scene.tree.reach = rows.reach
        if engine.needs.tree:
            self._plant(rows)
        for name, value in (("materials", materials), ("lights", lights), ("camera", camera), ("sky", sky)):
            if value is not None and value.size:
                setattr(scene, name, self._pointer(value))
        scene.light_count = 0 if lights is None else len(lights)
        scene.depth, scene.grid = depth, grid
        scene.method, scene.samples = METHODS[method], samples

    def _plant(self, rows: SceneRows) -> None:
        """Hand over the tree of rows, whose items number the kinds as the rows do."""
        ffi, tree, given = self.engine.ffi, self._scene.tree, rows.tree(self.engine)
        items = given.items.copy()
        items[:, 0] = np.array([self.engine.numbers[kind] for kind in rows], np.int32)[given.items[:, 0]]
        tree.nodes = ffi.cast("bs_node *", self._keep(given.nodes))
        tree.items = ffi.cast("int32_t *", self._keep(items))
        tree.node_count, tree.item_count, tree.loose = len(given.parts), len(items), given.loose
        tree.whole, tree.center, tree.unit = given.whole.tolist(), given.center.tolist(), given.unit

    def _keep(self, array: Array) -> Any:
        buffer = self.engine.ffi.from_buffer(np.ascontiguousarray(array))
        self._kept.append(buffer)
        return buffer

    def _pointer(self, array: Array) -> Any:
        with np.errstate(over="ignore"):
            return self._keep(np.asarray(array, self.dtype))

    def _rays(self, origins: Array, directions: Array) -> tuple[list[Any], tuple[int, ...]]:
        """The driver's structure of rays, followed by the buffers that it points into."""
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
        kept = {name: ffi.from_buffer(array) for name, array in results.items()}
        for name, buffer in kept.items():
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
        """Of first hits only t, surface and status, for programs that meet several rays at once: the same bits.

        And "seal" (chunks,): a digest of the bits of each chunk of rays, by which changed ones are told.
        """
        threads = parallel.thread_count(threads)
        rays, lead = self._rays(origins, directions)
        n = math.prod(lead)
        seal = np.zeros(-(-n // RAYS_PER_CHUNK), np.uint64)
        results = {"t": np.empty(lead, self.dtype), **self._codes(lead), "seal": seal}
        if n <= RAYS_PER_CHUNK:
            threads = 1  # one seal
        shared = -(-len(seal) // (CALLS_PER_THREAD * threads))
        self._run(self.engine.lib.bs_scene_wide, rays, n, results, 1, threads, min(max(shared, 1), CHUNKS_AT_ONCE))
        return results

    @staticmethod
    def _codes(lead: tuple[int, ...]) -> dict[str, Array]:
        return {"surface": np.empty(lead, np.int32), "status": np.empty(lead, np.uint8)}

    def all(self, origins: Array, directions: Array, threads: int | None = None) -> dict[str, Array]:
        """All points of lines on the scene's only surface: t, point, normal, alpha, row, count, status.

        Arrays have room for the most that there are. More than two are rare, and memory that is never read
        costs more than the geometry: lines that have more are asked again.
        """
        found = self._all(origins, directions, FEW_ROOTS, threads)
        most = int(np.max(found["count"], initial=0))
        if most <= FEW_ROOTS:
            return found
        lead = found["count"].shape
        crowded = found["count"] > FEW_ROOTS
        starts, ways = (np.broadcast_to(x, (*lead, 3))[crowded] for x in (origins, directions))
        again = self._all(starts, ways, most, threads)
        for name, few in found.items():
            if name in ("count", "status"):
                few[crowded] = again[name]
                continue
            many = np.empty((*lead, most, *few.shape[len(lead) + 1 :]), few.dtype)
            many.fill(-1 if name == "row" else np.nan)
            rows = many.reshape(math.prod(lead), most, -1)
            rows[:, :FEW_ROOTS] = few.reshape(math.prod(lead), FEW_ROOTS, -1)
            many[crowded] = again[name]
            found[name] = many
        return found

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
        """The loop over pixels of a picture: a function of (begin, end), in reading order.

        Parameters
        ----------
        width, height : int
            Of the whole picture.
        arrays : mapping
            What is asked for, by the names of the driver's structure.
        first : int
            The pixel that the arrays begin with.
        """
        ffi, scene, single, function = self.engine.ffi, self._scene, self.single, self.engine.lib.bs_scene_render
        kept = {name: ffi.from_buffer(array) for name, array in arrays.items()}
        picture = ffi.new("bs_picture *", {"width": width, "height": height, "first": first})
        for name, buffer in kept.items():
            setattr(picture, name, ffi.cast("int32_t *" if name == "cost" else "void *", buffer))

        def paint(begin: int, end: int, _kept: Any = kept) -> None:
            function(scene, single, begin, end, picture)

        return paint
