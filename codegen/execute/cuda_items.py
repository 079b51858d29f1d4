"""Loops over items on a GPU: a thread for each item, arrays copied there and back."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from threading import Lock
from typing import Any

import numpy as np

from ..ir.loops.nodes import Function
from ..targets.cuda.printer import DRIVER_OPTIONS
from .arrays import Array
from .cuda_driver import CudaModule, Device, DeviceArrays, DeviceMemory
from .items import Loop, Run
from .nvrtc import compile_cached, device_arch


def compile_loops(device: Device, source: Mapping[str, str]) -> CudaModule:
    """Files of `targets.cuda.printer.loops_source` on a GPU, from the cache or compiled now.

    Raises
    ------
    MissingExtraError
        If NVRTC is not installed.
    """
    return CudaModule(device, compile_cached(source, device_arch(device.capability), DRIVER_OPTIONS))


@dataclass(frozen=True)
class OnDevice:
    """An array on the device, which is there as long as this object."""

    pointer: ctypes.c_uint64
    memory: DeviceArrays | DeviceMemory


class CudaLoops:
    """The loops of a compiled text.

    Parameters
    ----------
    module : CudaModule
    most : int
        Arrays that the text has room for.
    """

    def __init__(self, module: CudaModule, most: int) -> None:
        self.module = module
        addresses, numbers = ctypes.c_uint64 * most, ctypes.c_ssize_t * most
        fields = [("arrays", addresses), ("strides", numbers), ("counts", numbers)]
        self._passed = type("Passed", (ctypes.Structure,), {"_fields_": fields})
        self._functions: dict[str, ctypes.c_void_p] = {}
        self._memory = DeviceArrays(module.device)
        self._lock = Lock()

    def keep(self, arrays: Sequence[Array]) -> list[OnDevice]:
        """Copies on the device, for many calls."""
        memory = DeviceArrays(self.module.device)
        return [OnDevice(pointer, memory) for pointer in memory.write(arrays)]

    def run(
        self, name: str, n: int, arrays: Sequence[Array | OnDevice], strides: Sequence[int], counts: Sequence[int],
        changed: Collection[int],
    ) -> None:  # fmt: skip
        """Run a loop over n items; arrays that are not there are copied to the device, and back those that it changes.

        Parameters
        ----------
        name : str
            Of the C function.
        n : int
        arrays : sequence of array or OnDevice
            Contiguous.
        strides, counts : sequence of int
        changed : collection of int
            Which arrays.
        """
        with self._lock, self.module.device.current():
            copied = iter(self._memory.write([a for a in arrays if not isinstance(a, OnDevice)]))
            pointers = [a.pointer if isinstance(a, OnDevice) else next(copied) for a in arrays]
            passed: Any = self._passed()
            passed.arrays[: len(pointers)] = [pointer.value for pointer in pointers]
            passed.strides[: len(strides)] = strides
            passed.counts[: len(counts)] = counts
            self.module.launch(self._function(f"launch_{name}"), n, [passed])
            for k in changed:
                array = arrays[k]
                if not isinstance(array, OnDevice):
                    self._memory.read(pointers[k], array)

    def _function(self, name: str) -> ctypes.c_void_p:
        if name not in self._functions:
            self._functions[name] = self.module.function(name)
        return self._functions[name]


class CudaLoop(Loop):
    """The loop of an algorithm.

    Parameters
    ----------
    loops : CudaLoops
    name : str
        Of the C function.
    changed : collection of int
        Arrays that it changes, and those for what it returns.
    """

    runs_whole = True

    def __init__(self, loops: CudaLoops, name: str, changed: Collection[int]) -> None:
        self._loops, self._name, self._changed = loops, name, changed
        self.hold: Callable[[Array], Any] = np.asarray

    def bind(self, arrays: Sequence[Any], strides: Any, counts: Any) -> Run:
        def run(begin: int, end: int) -> None:
            assert begin == 0
            self._loops.run(self._name, end, arrays, strides, counts, self._changed)

        return run

    def integers(self, values: Sequence[int]) -> Any:
        return list(values)

    def work(self, size: int, dtype: Any) -> OnDevice:
        memory = DeviceMemory(self._loops.module.device, size * np.dtype(dtype).itemsize)
        return OnDevice(memory.pointer, memory)


def algorithm_loop(device: Device, source: Mapping[str, str], function: Function, tag: str) -> CudaLoop:
    """The loop of an algorithm from the files of `programs.algorithms.algorithm_cuda`, by its precision's tag."""
    inputs, results = len(function.parameters), len(function.results)
    written = [k for k, p in enumerate(function.parameters) if p.access != "in"]
    loops = CudaLoops(compile_loops(device, source), inputs + results)
    return CudaLoop(loops, f"bs_loop_{tag}", [*written, *range(inputs, inputs + results)])
