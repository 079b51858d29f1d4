"""The algorithms of a registration on a GPU, from the C text that `c` compiles.

A scene's arrays are copied to the device once and stay there.
"""

from __future__ import annotations

import ctypes
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from threading import Lock
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import DeviceError
from ...codegen.execute.cuda_compiler import compile_cached, device_arch
from ...codegen.execute.cuda_driver import CudaModule, Device, DeviceArrays
from ...codegen.execute.in_place import DTYPES, Kept, arrange
from ...codegen.programs.registration.registration import set_name
from ...codegen.targets.cuda.printer import DRIVER_OPTIONS, algorithms_source
from .algorithms import entries_of, program_of

Array = NDArray[Any]


@cache
def gpu() -> Device:
    """The first GPU.

    Raises
    ------
    DeviceError
        If there is no GPU.
    """
    try:
        return Device()
    except DeviceError as error:
        remedy = 'Use backend="c" or backend="numba": they give the same answer.'
        raise DeviceError(f'backend="cuda" needs a GPU and its driver: {error}', remedy=remedy) from None


@dataclass(frozen=True)
class OnDevice:
    """A copy of an array on the device, which is there as long as this object."""

    pointer: ctypes.c_uint64
    memory: DeviceArrays


@cache
def cuda_module(kinds: tuple[str, ...]) -> CudaModule:
    """The algorithms of these kinds on the GPU, from the cache or compiled now.

    Raises
    ------
    MissingExtraError
        If NVRTC is not installed.
    DeviceError
        If there is no GPU.
    """
    device = gpu()
    source = algorithms_source(program_of(kinds).files)
    return CudaModule(device, compile_cached(source, device_arch(device.capability), DRIVER_OPTIONS))


class CudaAlgorithms:
    """Algorithms for models of some kinds, a thread for each item; see `algorithms.Algorithms`."""

    def __init__(self, kinds: tuple[str, ...]) -> None:
        self._module = cuda_module(kinds)
        self._kinds, self._entries = set_name(kinds), entries_of(kinds)
        most = max(len(entry.parameters) + len(entry.results) for entry in self._entries.values())
        addresses, numbers = ctypes.c_uint64 * most, ctypes.c_ssize_t * most
        fields = [("arrays", addresses), ("strides", numbers), ("counts", numbers)]
        self._passed = type("Passed", (ctypes.Structure,), {"_fields_": fields})
        self._functions: dict[str, ctypes.c_void_p] = {}
        self._memory = DeviceArrays(self._module.device)
        self._lock = Lock()

    def keep(self, arrays: Mapping[str, Array]) -> Mapping[str, Any]:
        """Copies on the device, for many calls: as arguments that all items share."""
        memory = DeviceArrays(self._module.device)
        pointers = memory.write(list(arrays.values()))
        return {
            name: Kept(OnDevice(pointer, memory), len(array))
            for (name, array), pointer in zip(arrays.items(), pointers, strict=True)
        }

    def run(
        self, name: str, n: int, each: Mapping[str, Array], shared: Mapping[str, Any], changed: tuple[str, ...] = (),
        threads: int | None = 1, grain: int = 1,
    ) -> list[Array]:  # fmt: skip
        """Run an algorithm; what is not there is copied to the device, and back what it changes and returns."""
        entry = self._entries[f"{name}_{self._kinds}"]
        returned = [np.empty(n, DTYPES[type]) for type in entry.results]
        if not n:
            return returned
        arrays, strides, counts = arrange(entry, n, each, shared, lambda array: array, _number)
        names = [parameter[0] for parameter in entry.parameters]
        arrays, names = [*arrays, *returned], [*names, *("" for _ in returned)]
        with self._lock, self._module.device.current():
            copied = iter(self._memory.write([a for a in arrays if not isinstance(a, OnDevice)]))
            pointers = [a.pointer if isinstance(a, OnDevice) else next(copied) for a in arrays]
            passed = self._passed()
            passed.arrays[: len(pointers)] = [pointer.value for pointer in pointers]
            passed.strides[: len(pointers)] = [*strides, *(1 for _ in returned)]
            passed.counts[: len(counts)] = counts
            self._module.launch(self._function(entry.name), n, [passed])
            for array, pointer, own in zip(arrays, pointers, names, strict=True):
                if not own or own in changed:
                    self._memory.read(pointer, array)
        return returned

    def _function(self, name: str) -> ctypes.c_void_p:
        if name not in self._functions:
            self._functions[name] = self._module.function(f"launch_{name}")
        return self._functions[name]


def _number(value: Any, type: str) -> Array:
    return np.array((value,), DTYPES[type])
