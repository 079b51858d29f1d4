"""Scene programs that run on this processor, compiled C and numba: the same loops over rays and pixels."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...codegen.execute.in_place import InPlace, read_entries
from ...codegen.execute.items import CompiledLoop
from ...codegen.programs import Program
from ...codegen.programs.tracer.scene import scene_program
from ...codegen.programs.tracer.scene_needs import SceneNeeds
from ...codegen.programs.tracer.surface_kinds import surface_kind

Array = NDArray[Any]
#: Rays per chunk, a few milliseconds at most; each chunk has one checksum, as in scene_common.h.
RAYS_PER_CHUNK = 4096
#: Runs items [begin, end).
Part = Callable[[int, int], None]
#: C types of a program's arrays other than numbers in the scene's precision.
_TYPES = {"surface": "int32_t *", "count": "int32_t *", "status": "uint8_t *", "checksum": "uint64_t *"}
#: Layers of pictures, for those that nobody asks for.
_NO_LAYERS = {
    **{name: np.zeros(1) for name in ("color", "normal", "depth", "alpha")}, "cost": np.zeros(1, np.int32),
}  # fmt: skip


class Rays(NamedTuple):
    """Origins and directions of rays, without gaps, and numbers from one to the next: 0 where all share one, or 3."""

    origins: Array
    origin_stride: int
    directions: Array
    direction_stride: int


class SceneLoops(ABC):
    """A scene's arrays, held by a program."""

    @abstractmethod
    def hits_loop(self, name: str, rays: Rays, results: Mapping[str, Array], roots: int) -> Part:
        """The loop "first", "all" or "wide" over rays, which fills the results."""

    @abstractmethod
    def picture_loop(self, layout: Array, arrays: Mapping[str, Array]) -> Part:
        """The loop over the pixels of a picture; `records.PICTURE` is the layout."""


class Engine(ABC):
    """A scene program.

    Parameters
    ----------
    needs : SceneNeeds
        The key that it was compiled for.
    """

    #: Whether it reads arrays as C does.
    is_c: bool
    #: Whether it has a loop over packets of rays.
    meets_several: bool
    #: Rays of one call.
    chunk = RAYS_PER_CHUNK
    #: Rays that are not shared out to threads.
    grain = 1

    def __init__(self, needs: SceneNeeds) -> None:
        self.needs = needs

    @cached_property
    def program(self) -> Program:
        """Source text in C and names of the kernels."""
        return scene_program(self.needs)

    @abstractmethod
    def scene(self, integers: Array, reals: Array) -> SceneLoops:
        """Hold a scene."""

    @abstractmethod
    def build_tree(self, boxes: Array, numbers: Array, nodes: Array, parts: Array) -> int:
        """Build the tree over boxes; see `codegen.programs.tracer.tree.tree_building.build_tree`."""

    def prepare(self, kind: str, parameters: Array) -> Array:
        """Compute rows of constants (n, constants) from rows of surfaces' parameters (n, parameters)."""
        layout = surface_kind(kind)
        rows = np.ascontiguousarray(parameters, np.float64).reshape(-1, layout.parameters)
        if not layout.is_apart:
            return rows.copy()
        constants = np.zeros((len(rows), layout.constants))
        if len(rows):
            self._prepare(self.needs.kinds.index(kind), rows, constants)
        return constants

    @abstractmethod
    def _prepare(self, kind: int, rows: Array, constants: Array) -> None:
        """Compute rows of constants of a kind, by its number."""


class CEngine(Engine):
    """A compiled C program.

    Parameters
    ----------
    needs : SceneNeeds
    module : module
        The extension, with ``ffi`` and ``lib``.
    """

    is_c = True

    def __init__(self, needs: SceneNeeds, module: Any) -> None:
        super().__init__(needs)
        self.module = module
        self.ffi = module.ffi
        self.lib = module.lib

    @cached_property
    def meets_several(self) -> bool:  # type: ignore[override]
        null = self.ffi.NULL
        return bool(self.needs.wide and self.lib.bs_scene_wide(null, 0, 0, 0, null, null))

    def scene(self, integers: Array, reals: Array) -> SceneLoops:
        return _CScene(self, integers, reals)

    def build_tree(self, boxes: Array, numbers: Array, nodes: Array, parts: Array) -> int:
        hold = self.ffi.from_buffer
        arrays = zip(("double[]", "ptrdiff_t[]", "double[]", "int32_t[]"), (boxes, numbers, nodes, parts), strict=True)
        return int(self.lib.bs_scene_build(len(boxes), *(hold(type, array) for type, array in arrays)))

    def _prepare(self, kind: int, rows: Array, constants: Array) -> None:
        hold = self.ffi.from_buffer
        self.lib.bs_scene_prepare(kind, len(rows), hold("double[]", rows), hold("double[]", constants))


class StructuredScene(SceneLoops):
    """A scene whose arrays are handed over in the structures of scene_types.h.

    Parameters
    ----------
    ffi : FFI
        Knows them.
    integers, reals : array
    """

    def __init__(self, ffi: Any, integers: Array, reals: Array) -> None:
        self.ffi, self.single = ffi, int(reals.dtype == np.float32)
        self._scene = ffi.new("bs_scene *")
        self._held = self._fill(self._scene, {"integers": integers, "reals": reals}, {"integers": "ptrdiff_t *"})

    @abstractmethod
    def hold(self, array: Array, is_result: bool) -> tuple[Any, Any]:
        """Where the program finds an array, as cffi's pointer or buffer, and what must live as long as it does so.

        Of a result only the room matters.
        """

    def ray_structures(self, rays: Rays, results: Mapping[str, Array], roots: int) -> tuple[Any, Any, list[Any]]:
        """Structures of rays and of hits, and what must live as long as they are used."""
        given, hits = self.ffi.new("bs_rays *"), self.ffi.new("bs_hits *")
        given.origin_stride, given.direction_stride = rays.origin_stride, rays.direction_stride
        hits.roots = roots
        held = self._fill(given, {"origins": rays.origins, "directions": rays.directions})
        return given, hits, held + self._fill(hits, results, _TYPES, is_result=True)

    def picture_structure(self, layout: Array, arrays: Mapping[str, Array]) -> tuple[Any, list[Any]]:
        """The structure of a picture, and what must live as long as it is used."""
        picture = self.ffi.new("bs_picture *")
        held = self._fill(picture, {"layout": layout}, {"layout": "ptrdiff_t *"})
        return picture, held + self._fill(picture, arrays, {"cost": "int32_t *"}, is_result=True)

    def _fill(
        self, structure: Any, arrays: Mapping[str, Array], types: Mapping[str, str] | None = None,
        is_result: bool = False,
    ) -> list[Any]:  # fmt: skip
        found = []
        for name, array in arrays.items():
            pointer, held = self.hold(array, is_result)
            setattr(structure, name, self.ffi.cast((types or {}).get(name, "void *"), pointer))
            found.append(held)
        return found


class _CScene(StructuredScene):
    def __init__(self, engine: CEngine, integers: Array, reals: Array) -> None:
        self.engine = engine
        super().__init__(engine.ffi, integers, reals)

    def hold(self, array: Array, is_result: bool) -> tuple[Any, Any]:
        buffer = self.ffi.from_buffer(array)
        return buffer, buffer

    def hits_loop(self, name: str, rays: Rays, results: Mapping[str, Array], roots: int) -> Part:
        given, hits, held = self.ray_structures(rays, results, roots)
        function, scene, single = getattr(self.engine.lib, f"bs_scene_{name}"), self._scene, self.single

        def part(begin: int, end: int, _held: Any = held) -> None:
            function(scene, single, begin, end, given, hits)

        return part

    def picture_loop(self, layout: Array, arrays: Mapping[str, Array]) -> Part:
        picture, held = self.picture_structure(layout, arrays)
        function, scene, single = self.engine.lib.bs_scene_render, self._scene, self.single

        def paint(begin: int, end: int, _held: Any = held) -> None:
            function(scene, single, begin, end, picture)

        return paint


class NumbaEngine(Engine):
    """A program that numba has compiled, in double precision.

    Parameters
    ----------
    needs : SceneNeeds
    text, entries : str
        See `codegen.programs.tracer.algorithms.numba_program`.
    """

    is_c = False
    meets_several = False

    def __init__(self, needs: SceneNeeds, text: str, entries: str) -> None:
        from ...codegen.execute.numba_cache import CachedModule

        super().__init__(needs)
        self._entries = read_entries(entries)
        signatures = {name: entry.signature() for name, entry in self._entries.items()}
        self._module = CachedModule("scene", text, signatures)
        self._loops: dict[str, InPlace] = {}

    def loop(self, name: str) -> InPlace:
        """One of the algorithms, compiled at its first use."""
        key = f"{name}_items"
        if key not in self._loops:
            self._loops[key] = InPlace(self._entries[key], CompiledLoop(self._module[key]))
        return self._loops[key]

    def scene(self, integers: Array, reals: Array) -> SceneLoops:
        return _NumbaScene(self, {"scene": integers, "integers": integers, "reals": reals})

    def build_tree(self, boxes: Array, numbers: Array, nodes: Array, parts: Array) -> int:
        arguments = {"boxes": boxes, "numbers": numbers, "nodes": nodes, "parts": parts}
        return int(self.loop("build_tree")(arguments))

    def _prepare(self, kind: int, rows: Array, constants: Array) -> None:
        arguments = {"kind": kind, "rows": len(rows), "parameters": rows.ravel(), "constants": constants.ravel()}
        self.loop("prepare_rows")(arguments)


class _NumbaScene(SceneLoops):
    def __init__(self, engine: NumbaEngine, arrays: Mapping[str, Array]) -> None:
        self.engine, self._arrays = engine, arrays

    def hits_loop(self, name: str, rays: Rays, results: Mapping[str, Array], roots: int) -> Part:
        loop = self.engine.loop(f"{name}_hits")
        flat = {field: array.reshape(-1) for field, array in results.items()}  # of one ray they have no axis
        arguments = {**self._arrays, **rays._asdict(), **flat, "roots": roots}
        if name == "all":
            arguments["rows"] = arguments.pop("surface")
        return lambda begin, end: loop({**arguments, "begin": begin, "end": end})

    def picture_loop(self, layout: Array, arrays: Mapping[str, Array]) -> Part:
        loop = self.engine.loop("render")
        arguments = {**self._arrays, "picture": layout, **_NO_LAYERS, **arrays}
        return lambda begin, end: loop({**arguments, "begin": begin, "end": end})
