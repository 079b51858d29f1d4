"""The CUDA backend: the registration driver on a GPU, from the same source as that of `c`.

A scene's arrays are copied to the device once and stay there.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from threading import Lock
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import DeviceError
from ...codegen.execute.cuda_compiler import compile_cached, device_arch
from ...codegen.execute.cuda_driver import CudaModule, Device, DeviceArrays
from ...codegen.programs.registration.registration import KINDS, in_order, reform_program
from ...codegen.targets.cuda.printer import DRIVER_OPTIONS, reform_source
from ...codegen.targets.templates import template_text
from ..model.grid import grid_of
from .c import STRUCTURES
from .model_rows import POSITION, CenterRule, MatchCriterion, ModelData
from .stages import Functions, Stages, integers, reals, set_criterion

Array = NDArray[Any]
Arguments = Callable[[list[ctypes.c_uint64]], list[Any]]


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
def cuda_driver(kinds: tuple[str, ...]) -> CudaModule:
    """The driver for these kinds on the GPU, from the cache or compiled now.

    Raises
    ------
    MissingExtraError
        If NVRTC is not installed.
    DeviceError
        If there is no GPU.
    """
    device = gpu()
    source = reform_source(reform_program(in_order(kinds)).files)
    return CudaModule(device, compile_cached(source, device_arch(device.capability), DRIVER_OPTIONS))


@cache
def structures() -> Any:
    """The driver's structures, as its header declares them."""
    from cffi import FFI

    ffi = FFI()
    ffi.cdef(template_text("reform_types.h"))
    return ffi


class Launchers:
    """A driver on the device: its launchers, and memory for inputs and outputs."""

    def __init__(self, kinds: tuple[str, ...]) -> None:
        self._module = cuda_driver(kinds)
        self._functions: dict[str, ctypes.c_void_p] = {}
        self._passing = self.memory()
        self._lock = Lock()

    def memory(self) -> DeviceArrays:
        """Memory for copies of arrays that stay."""
        return DeviceArrays(self._module.device)

    def run(self, stage: str, n: int, arguments: Arguments, inputs: Sequence[Array], outputs: Sequence[Array]) -> None:
        """Run items 0 to n - 1 of a stage: ``arguments`` of the launcher are made from the addresses of the arrays.

        Inputs and outputs are copied to the device, and the outputs back.
        """
        if not n:
            return
        with self._lock, self._module.device.current():
            if stage not in self._functions:
                self._functions[stage] = self._module.function(f"reform_{stage}")
            pointers = self._passing.write([*inputs, *outputs])
            self._module.launch(self._functions[stage], n, arguments(pointers))
            for pointer, array in zip(pointers[len(inputs) :], outputs, strict=True):
                self._passing.read(pointer, array)


class CudaDriver(Functions):
    """See `c.Driver`."""

    def __init__(self, kinds: tuple[str, ...], threads: int | None = None) -> None:
        self._launchers = Launchers(in_order(kinds))

    def _call(self, name: str, kind: str | None, inputs: Sequence[Array], shape: tuple[int, ...]) -> Array:
        outputs, number = np.empty(shape), [] if kind is None else [_number(kind)]
        count = shape[0] if len(shape) > 1 else 1
        self._launchers.run(name, count, lambda pointers: [*number, *pointers], [*map(reals, inputs)], [outputs])
        return outputs

    def robust_center(self, kinds: Array, elements: Array, rule: CenterRule) -> Array:
        n, job = len(elements), structures().new("bs_center *")
        job.count, job.rounds, job.place, job.far, job.rounding, job.rank_tolerance = n, *rule
        inputs = {"kinds": integers(kinds), "elements": reals(elements)}
        outputs = {"point": np.empty(POSITION), "squares": np.empty(n), "ordered": np.empty(n)}
        arrays = {**inputs, **outputs, "near": np.empty(n, np.int32)}
        results = [arrays[name] for name in arrays if name not in inputs]
        self._launchers.run(
            "robust_center", 1, lambda indices: [_fill(job, arrays, indices)], list(inputs.values()), results
        )
        return outputs["point"]

    def invariants(self, kinds: tuple[str, str], rows: tuple[Array, Array], indices: tuple[Array, Array]) -> Array:
        inputs = [reals(rows[0]), integers(indices[0]), reals(rows[1]), integers(indices[1])]
        first, second = map(_number, kinds)
        outputs = np.empty((len(inputs[1]), 4))
        self._launchers.run("invariants", len(outputs), lambda p: [first, *p[:2], second, *p[2:]], inputs, [outputs])
        return outputs


class CudaScene(Stages):
    """See `c.Scene`."""

    def __init__(
        self, query: ModelData, reference: ModelData, kinds: Array, rows: Array, threads: int | None = None
    ) -> None:
        self._launchers = Launchers(in_order(query.rows))
        self._state = structures().new("bs_reform *")
        self._models, self._selected = self._launchers.memory(), self._launchers.memory()
        self._copy(query, reference)
        self.select_objects(kinds, rows)

    def _copy(self, query: ModelData, reference: ModelData) -> None:
        """Copy the arrays of both models to the device, in one piece, and set their addresses."""
        arrays: list[Array] = []
        fields: list[tuple[Any, Any]] = []
        for name, side in (("query", query), ("reference", reference)):
            model = getattr(self._state, name)
            for kind, rows in side.rows.items():
                index = KINDS.index(kind)
                model.counts[index] = len(rows)
                arrays.append(reals(rows))
                fields.append((model.rows, index))
        for kind, elements in reference.elements.items():
            grid, to = grid_of(elements), self._state.grids[KINDS.index(kind)]
            to.corner, to.scale, to.sides = list(grid.corner), grid.scale, grid.sides
            arrays += [integers(grid.starts), integers(grid.order), reals(grid.elements)]
            fields += [(to, "starts"), (to, "order"), (to, "elements")]
        for (owner, field), array, pointer in zip(fields, arrays, self._models.write(arrays), strict=True):
            if isinstance(field, int):
                owner[field] = _pointer(array, pointer)
            else:
                setattr(owner, field, _pointer(array, pointer))

    def select_objects(self, kinds: Array, rows: Array) -> None:
        """Select query objects for subsequent calls."""
        inputs = [integers(kinds), integers(rows)]
        indices = self._selected.write(inputs)
        self._state.asked = self.n_selected = len(kinds)
        self._state.asked_kinds, self._state.asked_rows = map(_pointer, inputs, indices)

    def set_criterion(self, criterion: MatchCriterion) -> None:
        """Set the match criterion for subsequent calls."""
        set_criterion(self._state, criterion)

    def _run(
        self, stage: str, n: int, grain: int, numbers: Mapping[str, float], inputs: Mapping[str, Array],
        outputs: Mapping[str, Array],
    ) -> None:  # fmt: skip
        """See `Stages`; the structure gets the numbers, and the addresses of its arrays on the device."""
        job, arrays = structures().new(f"{STRUCTURES[stage]} *"), {**inputs, **outputs}
        for name, number in numbers.items():
            setattr(job, name, number)

        def arguments(pointers: list[ctypes.c_uint64]) -> list[Any]:
            return [_by_value(self._state), _fill(job, arrays, pointers)]

        self._launchers.run(stage, n, arguments, list(inputs.values()), list(outputs.values()))


def _fill(job: Any, arrays: Mapping[str, Array], pointers: list[ctypes.c_uint64]) -> Any:
    """Structure as an argument, with the addresses of its arrays on the device."""
    for (name, array), pointer in zip(arrays.items(), pointers, strict=True):
        setattr(job, name, _pointer(array, pointer))
    return _by_value(job)


def _pointer(array: Array, index: ctypes.c_uint64) -> Any:
    """Pointer to an array's copy on the device, for a field of a structure."""
    return structures().cast("int32_t *" if array.dtype == np.int32 else "double *", index.value)


def _by_value(structure: Any) -> Any:
    """A structure as an argument of a kernel."""
    buffer = structures().buffer(structure)
    return (ctypes.c_char * len(buffer)).from_buffer(buffer)


def _number(kind: str) -> ctypes.c_int:
    return ctypes.c_int(KINDS.index(kind))
