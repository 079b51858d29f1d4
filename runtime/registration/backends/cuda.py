"""The algorithms of a registration on a GPU, from the C text that `c` compiles.

A scene's arrays are copied to the device once and stay there.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import DeviceError
from ...codegen.execute.cuda_driver import CudaModule, Device
from ...codegen.execute.cuda_items import CudaLoops, compile_loops
from ...codegen.execute.in_place import Kept, arrange
from ...codegen.execute.items import STORED
from ...codegen.programs.registration.registration import set_name
from ...codegen.targets.cuda.printer import stock_source
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
    return compile_loops(gpu(), stock_source(program_of(kinds).files))


class CudaAlgorithms:
    """Algorithms for models of some kinds, a thread for each item; see `algorithms.Algorithms`."""

    def __init__(self, kinds: tuple[str, ...]) -> None:
        self._kinds, self._entries = set_name(kinds), entries_of(kinds)
        most = max(len(entry.parameters) + len(entry.results) for entry in self._entries.values())
        self._loops = CudaLoops(cuda_module(kinds), most)

    def keep(self, arrays: Mapping[str, Array]) -> Mapping[str, Any]:
        """Copies on the device, for many calls: as arguments that all items share."""
        copies = self._loops.keep(list(arrays.values()))
        return {name: Kept(copy, len(arrays[name])) for name, copy in zip(arrays, copies, strict=True)}

    def run(
        self, name: str, n: int, each: Mapping[str, Array], shared: Mapping[str, Any], changed: tuple[str, ...] = (),
        threads: int | None = 1, grain: int = 1,
    ) -> list[Array]:  # fmt: skip
        """Run an algorithm; what is not there is copied to the device, and back what it changes and returns."""
        entry = self._entries[f"{name}_{self._kinds}"]
        returned = [np.empty(n, STORED[type]) for type in entry.results]
        if not n:
            return returned
        count = len(entry.parameters)
        arrays: list[Any] = [None] * count
        strides, counts = [0] * count, [0] * count
        places = [(k, *parameter) for k, parameter in enumerate(entry.parameters)]
        arrange(places, n, each, shared, lambda array: array, _number, arrays, strides, counts)
        read = [k for k, parameter in enumerate(entry.parameters) if parameter[0] in changed]
        read += range(len(arrays), len(arrays) + len(returned))
        strides += [1] * len(returned)
        self._loops.run(f"bs_{entry.name}_f64", n, [*arrays, *returned], strides, counts, read)
        return returned


def _number(value: Any, type: str) -> Array:
    return np.array((value,), STORED[type])
