"""Scene programs on a GPU: the loops of C, a thread for each ray or pixel; arrays are copied there and back."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping, Sequence
from functools import cache
from threading import Lock
from typing import Any

import numpy as np
from cffi import FFI
from numpy.typing import NDArray

from ...codegen.execute import cuda_driver, cuda_items
from ...codegen.execute.cuda_driver import CudaModule, DeviceMemory
from ...codegen.programs.tracer.records import PICTURE
from ...codegen.programs.tracer.scene import scene_program
from ...codegen.programs.tracer.scene_needs import SceneNeeds
from ...codegen.targets.c.instances import SCALAR
from ...codegen.targets.cuda.printer import scene_source
from .engines import Engine, Part, Rays, SceneLoops, StructuredScene

Array = NDArray[Any]


class CudaEngine(Engine):
    """A program that a GPU runs.

    Parameters
    ----------
    needs : SceneNeeds
    module : CudaModule
    host : Engine
        A program of this processor: constants of surfaces and trees are made once for a scene, and there.
    """

    is_c = True
    meets_several = False
    #: As many as a large GPU has threads, some times over.
    chunk = grain = 1 << 20

    def __init__(self, needs: SceneNeeds, module: CudaModule, host: Engine) -> None:
        super().__init__(needs)
        self.module, self.host = module, host
        self.ffi = FFI()
        self.ffi.cdef(self.program.files["kernels.cdef"])

    def scene(self, integers: Array, reals: Array) -> SceneLoops:
        return _CudaScene(self, integers, reals)

    def build_tree(self, boxes: Array, numbers: Array, nodes: Array, parts: Array) -> int:
        return self.host.build_tree(boxes, numbers, nodes, parts)

    def _prepare(self, kind: int, rows: Array, constants: Array) -> None:
        name = self.needs.kinds[kind]
        constants[:] = self.host.prepare(name, rows)


class _CudaScene(StructuredScene):
    def __init__(self, engine: CudaEngine, integers: Array, reals: Array) -> None:
        self.engine, self._lock = engine, Lock()
        super().__init__(engine.ffi, integers, reals)

    def hold(self, array: Array, is_result: bool) -> tuple[Any, DeviceMemory]:
        memory = DeviceMemory(self.engine.module.device, array.nbytes)
        if not is_result:
            memory.write(np.ascontiguousarray(array))
        return self.ffi.cast("void *", memory.pointer.value), memory

    def hits_loop(self, name: str, rays: Rays, results: Mapping[str, Array], roots: int) -> Part:
        given, hits, held = self.ray_structures(rays, results, roots)
        n = results["status"].size
        return self._loop(name, (given, hits), n, [*zip(results.values(), held[-len(results) :], strict=True)], held)

    def picture_loop(self, layout: Array, arrays: Mapping[str, Array]) -> Part:
        picture, held = self.picture_structure(layout, arrays)
        n = next(array.shape[0] * array.shape[1] for array in arrays.values())
        first = int(PICTURE.view(layout).first)
        return self._loop("render", (picture,), n, [*zip(arrays.values(), held[1:], strict=True)], held, first)

    def _loop(
        self, name: str, structures: tuple[Any, ...], n: int, results: Sequence[tuple[Array, DeviceMemory]], held: Any,
        first: int = 0,
    ) -> Part:  # fmt: skip
        """A launcher; what it computes of items, n from the first on, is copied back."""
        module = self.engine.module
        function = module.function(f"scene_{name}_launch_{SCALAR[self.single].tag}")
        passed = [
            (ctypes.c_char * self.ffi.sizeof(x[0])).from_buffer(self.ffi.buffer(x)) for x in (self._scene, *structures)
        ]
        rows = [(array.reshape(n, array.size // max(n, 1)), memory) for array, memory in results]

        def part(begin: int, end: int, _held: Any = held) -> None:
            with self._lock, module.device.current():
                module.launch(function, end - begin, passed, begin)
                for array, memory in rows:
                    memory.read(array[begin - first : end - first], (begin - first) * array.strides[0])

        return part


@cache
def cuda_engine(needs: SceneNeeds, host: Engine) -> CudaEngine:
    """The program for these needs, compiled for the first GPU.

    Parameters
    ----------
    needs : SceneNeeds
    host : Engine
        As for `CudaEngine`.

    Raises
    ------
    DeviceError
        If there is none.
    MissingExtraError
        If NVRTC is not installed.
    """
    source = scene_source(scene_program(needs).files)
    return CudaEngine(needs, cuda_items.compile_loops(cuda_driver.first_gpu(), source), host)
