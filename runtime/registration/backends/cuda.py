"""The registration driver on a GPU: what `engine` does on the processor, from the same text.

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

from ..codegen.errors import DeviceError
from ..codegen.programs.reform import KINDS, in_order, reform_program
from ..codegen.targets.cuda import DRIVER_OPTIONS, compile_kept, device_arch, reform_source
from ..codegen.targets.cuda_run import CudaModule, Device, DeviceArrays
from ..codegen.templating import template_text
from .engine import STRUCTURES
from .grids import grid_of
from .sides import ELEMENT, POSITION, Closeness, MiddleRule, Side
from .stages import MOTOR, TWIST, Stages, integers, reals

Array = NDArray[Any]
Arguments = Callable[[list[ctypes.c_uint64]], list[Any]]


@cache
def gpu() -> Device:
    """The first GPU.

    Raises
    ------
    DeviceError
        If there is none.
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
    return CudaModule(device, compile_kept(source, device_arch(device.capability), DRIVER_OPTIONS))


@cache
def structures() -> Any:
    """The driver's structures, as its header declares them."""
    from cffi import FFI

    ffi = FFI()
    ffi.cdef(template_text("c/reform_types.h"))
    return ffi


class Launchers:
    """A driver on the device: its launchers, and memory for what goes in and out."""

    def __init__(self, kinds: tuple[str, ...]) -> None:
        self._module = cuda_driver(kinds)
        self._functions: dict[str, ctypes.c_void_p] = {}
        self._passing = self.memory()
        self._lock = Lock()

    def memory(self) -> DeviceArrays:
        """For copies of arrays that stay."""
        return DeviceArrays(self._module.device)

    def run(self, stage: str, n: int, arguments: Arguments, given: Sequence[Array], found: Sequence[Array]) -> None:
        """Items 0 to n - 1 of a stage.

        Parameters
        ----------
        stage : str
        n : int
        arguments : callable
            Arguments of the launcher, from where the arrays begin on the device.
        given, found : sequences of array
            Both are copied to the device, and those that are found are copied back.
        """
        if not n:
            return
        with self._lock, self._module.device.current():
            if stage not in self._functions:
                self._functions[stage] = self._module.function(f"reform_{stage}")
            pointers = self._passing.write([*given, *found])
            self._module.launch(self._functions[stage], n, arguments(pointers))
            for pointer, array in zip(pointers[len(given) :], found, strict=True):
                self._passing.read(pointer, array)


class CudaDriver:
    """As `engine.Driver`."""

    def __init__(self, kinds: tuple[str, ...], threads: int | None = None) -> None:
        self._launchers = Launchers(in_order(kinds))

    def elements(self, kind: str, rows: Array) -> Array:
        """Positions, directions and radii (n, 7) of unit objects."""
        given, found, number = [reals(rows)], np.empty((len(rows), ELEMENT)), _number(kind)
        self._launchers.run("elements", len(rows), lambda places: [number, *places], given, [found])
        return found

    def seen(self, kind: str, rows: Array, origin: Array) -> Array:
        """Objects, (n, k) rows, as they are seen from an origin (3,)."""
        given, found, number = [reals(rows), reals(origin)], np.empty(rows.shape), _number(kind)
        self._launchers.run("seen", len(rows), lambda places: [number, *places], given, [found])
        return found

    def middle(self, kinds: Array, elements: Array, rule: MiddleRule) -> Array:
        """The point (3,) nearest to all objects together but for a few far ones, by their kinds and elements."""
        n, job = len(elements), structures().new("bs_middle *")
        job.count, job.rounds, job.place, job.far, job.rounding, job.loose = n, *rule
        given = {"kinds": integers(kinds), "elements": reals(elements)}
        found = {"point": np.empty(POSITION), "squares": np.empty(n), "ordered": np.empty(n)}
        arrays = {**given, **found, "near": np.empty(n, np.int32)}
        results = [arrays[name] for name in arrays if name not in given]
        self._launchers.run("middle", 1, lambda places: [_filled(job, arrays, places)], list(given.values()), results)
        return found["point"]

    def unseen(self, motors: Array, to: Array, back: Array) -> Array:
        """Motors (n, 8) from a frame about the position ``back`` to one about ``to`` as motors of the world."""
        found = np.empty((len(motors), MOTOR))
        self._launchers.run("unseen", len(motors), list, [reals(motors), reals(to), reals(back)], [found])
        return found

    def unseen_twists(self, twists: Array, origin: Array) -> Array:
        """Twists (n, 6) of a frame about an origin as twists of the world."""
        found = np.empty((len(twists), TWIST))
        self._launchers.run("unseen_twists", len(twists), list, [reals(twists), reals(origin)], [found])
        return found

    def invariants(self, kinds: tuple[str, str], rows: tuple[Array, Array], places: tuple[Array, Array]) -> Array:
        """Four numbers of pairs of objects (n, 4), by their places in rows; kinds in the order of `KINDS`."""
        given = [reals(rows[0]), integers(places[0]), reals(rows[1]), integers(places[1])]
        first, second = map(_number, kinds)
        found = np.empty((len(given[1]), 4))
        self._launchers.run("invariants", len(found), lambda p: [first, *p[:2], second, *p[2:]], given, [found])
        return found

    def step(self, motor: Array, twist: Array) -> Array:
        """The motor next to (1 + twist) motor."""
        found = np.empty(MOTOR)
        self._launchers.run("step", 1, list, [reals(motor), reals(twist)], [found])
        return found


class CudaScene(Stages):
    """As `engine.Scene`."""

    def __init__(
        self, query: Side, reference: Side, asked_kinds: Array, asked_rows: Array, threads: int | None = None
    ) -> None:
        self._launchers = Launchers(in_order(query.rows))
        self._state = structures().new("bs_reform *")
        self._models, self._asked = self._launchers.memory(), self._launchers.memory()
        self._copy(query, reference)
        self.ask(asked_kinds, asked_rows)

    def _copy(self, query: Side, reference: Side) -> None:
        """Everything about both models to the device, in one piece; and where it is."""
        arrays: list[Array] = []
        fields: list[tuple[Any, Any]] = []
        for name, side in (("query", query), ("reference", reference)):
            model = getattr(self._state, name)
            for kind, rows in side.rows.items():
                place = KINDS.index(kind)
                model.counts[place] = len(rows)
                arrays.append(reals(rows))
                fields.append((model.rows, place))
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

    def ask(self, kinds: Array, rows: Array) -> None:
        """Look at other query objects."""
        given = [integers(kinds), integers(rows)]
        places = self._asked.write(given)
        self._state.asked = self.asked = len(kinds)
        self._state.asked_kinds, self._state.asked_rows = map(_pointer, given, places)

    def closeness(self, given: Closeness) -> None:
        """From now on."""
        self._state.weights = given.weights
        self._state.limit, self._state.least, self._state.align = given.limit, given.least, int(given.align)

    def _run(
        self, stage: str, n: int, grain: int, numbers: Mapping[str, float], given: Mapping[str, Array],
        found: Mapping[str, Array],
    ) -> None:  # fmt: skip
        """The structure is filled with numbers and with where its arrays are on the device."""
        job, arrays = structures().new(f"{STRUCTURES[stage]} *"), {**given, **found}
        for name, number in numbers.items():
            setattr(job, name, number)

        def arguments(pointers: list[ctypes.c_uint64]) -> list[Any]:
            return [_by_value(self._state), _filled(job, arrays, pointers)]

        self._launchers.run(stage, n, arguments, list(given.values()), list(found.values()))


def _filled(job: Any, arrays: Mapping[str, Array], pointers: list[ctypes.c_uint64]) -> Any:
    """A structure as an argument, with where its arrays are on the device."""
    for (name, array), pointer in zip(arrays.items(), pointers, strict=True):
        setattr(job, name, _pointer(array, pointer))
    return _by_value(job)


def _pointer(array: Array, place: ctypes.c_uint64) -> Any:
    """A field of a structure that points to an array's copy on the device."""
    return structures().cast("int32_t *" if array.dtype == np.int32 else "double *", place.value)


def _by_value(structure: Any) -> Any:
    """A structure as an argument of a kernel."""
    buffer = structures().buffer(structure)
    return (ctypes.c_char * len(buffer)).from_buffer(buffer)


def _number(kind: str) -> ctypes.c_int:
    return ctypes.c_int(KINDS.index(kind))
