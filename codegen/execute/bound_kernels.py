"""Kernels of compiled libraries as functions of arrays, through cffi: single calls, ranges over threads, and plans."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from threading import Lock
from typing import Any, ClassVar

import numpy as np

from ..errors import CompileError, InputError
from ..ir.argument import Argument
from . import ranges
from .arrays import F32, F64, READY, Array, Binding

#: A plan's places for results and for arguments; the same numbers stand in templates/c/kernels/calls.cdef.
PLAN_OUTPUTS, PLAN_INPUTS = 8, 16

#: Adds the loop of a kernel, by its symbol, for one of some instances, the best of them first.
Supply = Callable[[str, Sequence[str]], None]


class LoopError(CompileError):
    """A library without a loop that this processor runs."""


class Library:
    """A compiled extension of kernels (see templates/c/kernels/kernels.cdef).

    Parameters
    ----------
    module : module
        With ``ffi`` and ``lib``.
    supply : callable, optional
        ``supply(symbol, instances)`` adds a unit with this kernel for one of these instances, where it can. Default:
        there are the kernels that were linked, all at once.
    """

    def __init__(self, module: Any, supply: Supply | None = None) -> None:
        self.module = module
        self.ffi = module.ffi
        self.lib = module.lib
        self._supply = supply
        if supply is None:
            self.lib.bs_initialize()
        names = [self._text(self.lib.bs_kernel_name(i)) for i in range(self.lib.bs_kernel_count())]
        self.index = {name: i for i, name in enumerate(names)}
        if supply is None:
            self._check_loops()

    def _check_loops(self) -> None:
        """Refuse a library whose loops this processor cannot run: a call would end the process."""
        precisions = {name[:3] == "f32" for name in self.instances}
        for name, kernel in self.index.items():
            if not all(self.lib.bs_has(kernel, single) for single in precisions):
                made, what = ", ".join(self.instances), "and says that it does not run one of each precision"
                raise LoopError(
                    f"{name} was compiled for {made}, {what}", remedy="Set CC to gcc or clang, or use target='numba'"
                )

    @property
    def made_of(self) -> str:
        """Digest of the sources."""
        return self._text(self.lib.bs_source_hash())

    def _text(self, pointer: Any) -> str:
        return str(self.ffi.string(pointer).decode())

    @property
    def instances(self) -> list[str]:
        """Instances of the text, for example ``["f64_base", "f32_base", "f64_v3", "f32_v3"]``."""
        return [self._text(self.lib.bs_instance_name(i)) for i in range(self.lib.bs_instance_count())]

    def provide(self, symbol: str, single: bool) -> bool:
        """Supply the loop of a kernel for a precision; return whether there is one: the processor's best instance."""
        kernel = self.index[symbol]
        if self._supply is not None and not self.lib.bs_has(kernel, single):
            runs = [name for i, name in enumerate(self.instances) if self.lib.bs_instance_runs(i)]
            self._supply(symbol, [name for name in reversed(runs) if name.startswith("f32" if single else "f64")])
        return bool(self.lib.bs_has(kernel, single))

    def use(self, instance: str, *symbols: str) -> bool:
        """Use one instance for its precision (for tests), with these kernels; False where it cannot be run."""
        place = self.instances.index(instance)
        if not self.lib.bs_instance_runs(place):
            return False
        for symbol in symbols:
            if self._supply is not None and not self.lib.bs_instance_has(place, self.index[symbol]):
                self._supply(symbol, [instance])
            if not self.lib.bs_instance_has(place, self.index[symbol]):
                return False
        return bool(self.lib.bs_use_instance(place))


class AddedKernel:
    """One kernel that was made at run time, among those of the extension that calls them; else as a `Library`.

    Parameters
    ----------
    module : module
        With ``ffi`` and ``lib``, see templates/c/kernels/calls.c.j2.
    symbol : str
    unit : int
        Address of a unit with this kernel alone.
    name : str
        Of that unit's entry in the cache.

    Raises
    ------
    LoopError
        If this processor cannot run it, or there are too many.
    """

    _numbers: ClassVar[dict[tuple[Any, int], int]] = {}
    _adding: ClassVar[Lock] = Lock()

    def __init__(self, module: Any, symbol: str, unit: int, name: str = "") -> None:
        self.module, self.symbol, self.unit = module, symbol, name
        self.ffi, self.lib = module.ffi, module.lib
        with self._adding:
            number = self._numbers.get((self.lib, unit))
            if number is None:
                number = self.lib.bs_add_kernel(self.ffi.cast("void *", unit))
                if number < 0:
                    why = "this processor does not run what was compiled" if number == -1 else "too many kernels"
                    raise LoopError(f"{symbol}: {why}", remedy="Set CC to gcc or clang, or use target='numba'")
                self._numbers[self.lib, unit] = number
        self.index = {symbol: number}

    def provide(self, symbol: str, single: bool) -> bool:
        """Return whether there is a loop for a precision."""
        return bool(self.lib.bs_has(self.index[symbol], single))


class BoundKernel(Binding):
    """One kernel of a compiled library.

    Parameters
    ----------
    library : Library or AddedKernel
    symbol : str
        Name in the library.
    inputs, outputs : sequences of Argument
    otherwise : callable, optional
        Makes the kernel that serves a precision for which the library can have none.
    """

    def __init__(
        self,
        library: Library | AddedKernel,
        symbol: str,
        inputs: Sequence[Argument],
        outputs: Sequence[Argument],
        otherwise: Callable[[], Binding] | None = None,
    ) -> None:
        super().__init__(symbol, inputs, outputs)
        self.library = library
        self._otherwise = otherwise
        self._other: Binding | None = None
        self.index = library.index[symbol]
        self._from_buffer = library.ffi.from_buffer
        self._run1 = library.lib.bs_run1
        self._run2 = library.lib.bs_run2
        self._shapes = [(item.size,) for item in self.inputs]
        self._result_shape = (self.outputs[0].size,)
        self._ready = [bool(library.lib.bs_has(self.index, single)) for single in (False, True)]
        self._has_pair = self._single_output and len(self.inputs) == 2 and all(i.size for i in self.inputs)
        self.is_pair = self._has_pair and self._ready[False]

    def provide(self, single: bool) -> bool:
        """Return whether there is a compiled loop for a precision: compiled now, where it was not at install."""
        if not self._ready[single]:
            self._ready[single] = self._other is None and self.library.provide(self.symbol, single)
            self.is_pair = self._has_pair and self._ready[False]
        return self._ready[single]

    def __call__(self, *arrays: Any) -> Any:
        if self.is_pair and len(arrays) == 2:
            result = self.pair(arrays[0], arrays[1])
            if result is not None:
                return result
        return super().__call__(*arrays)

    def pair(self, a: Any, b: Any) -> Array | None:
        """The result for one item, two contiguous float64 rows: the short way. None where it is not that simple."""
        if type(a) is not np.ndarray or type(b) is not np.ndarray or a.dtype is not F64 or b.dtype is not F64:
            return None
        if [a.shape, b.shape] != self._shapes or a.flags.num & b.flags.num & READY != READY:
            return None
        out = np.empty(self._result_shape)
        buffer = self._from_buffer
        self._run2(self.index, 0, 1, buffer(out), buffer(a), 0, buffer(b), 0)
        return out

    def run(self, arrays: Sequence[Array], results: Sequence[Array], n: int) -> None:
        """Call the compiled loop on prepared arrays."""
        if n == 0:
            return
        single = bool(arrays) and arrays[0].dtype == F32
        if not self._ready[single] and not self.provide(single):
            self._without(single).run(arrays, results, n)
            return
        strides = self.strides(arrays)
        buffer = self._from_buffer
        is_short = self._single_output and ranges.splitter is None and n <= ranges.FIRST_CHEAP
        if is_short and len(arrays) == 2:
            self._run2(
                self.index, single, n, buffer(results[0]), buffer(arrays[0]), strides[0], buffer(arrays[1]), strides[1]
            )
            return
        if is_short and len(arrays) == 1:
            self._run1(self.index, single, n, buffer(results[0]), buffer(arrays[0]), strides[0])
            return
        ffi, run = self.library.ffi, self.library.lib.bs_run
        outs = ffi.new("void *[]", [buffer(r) for r in results])
        ins = ffi.new("void *[]", [buffer(a) for a in arrays])
        steps = ffi.new("ptrdiff_t[]", strides)

        def part(begin: int, end: int) -> None:
            run(self.index, single, begin, end, outs, ins, steps)

        ranges.parallel_for(part, n)

    def _without(self, single: bool) -> Binding:
        if self._other is None:
            if self._otherwise is None:
                raise InputError(f"{self.symbol} was compiled for float{64 if single else 32} alone.")
            self._other = self._otherwise()
        return self._other

    def plan(self, *arrays: Any) -> Plan:
        """A call with its arrays bound: ``plan()`` computes again into ``plan.results`` without any checks."""
        return Plan(self, *arrays)


class Plan:
    """Pointers kept, so that calling costs as little as C allows.

    ``arrays`` are what is read: refill them. They are the arguments themselves where these were contiguous arrays of
    the plan's precision and full shape, and copies where they had to be converted.
    """

    def __init__(self, kernel: BoundKernel, *arrays: Any) -> None:
        prepared, lead = kernel.prepare(arrays)
        dtype = prepared[0].dtype if prepared else F64
        self.arrays = prepared
        self.results = kernel.empty_results(lead, dtype)
        if len(self.results) > PLAN_OUTPUTS or len(prepared) > PLAN_INPUTS:
            raise InputError(f"{kernel.symbol}: a plan holds {PLAN_INPUTS} arguments and {PLAN_OUTPUTS} results.")
        if not kernel.provide(dtype == F32):
            raise InputError(f"{kernel.symbol} is not compiled for {dtype}, and a plan is a call of compiled code.")
        ffi = kernel.library.ffi
        plan = ffi.new("bs_plan *")
        plan.kernel, plan.single, plan.n = kernel.index, int(dtype == F32), math.prod(lead)
        self._kept = [ffi.from_buffer(a) for a in [*prepared, *self.results]]
        for i, stride in enumerate(kernel.strides(prepared)):
            plan.ins[i] = self._kept[i]
            plan.strides[i] = stride
        for i in range(len(self.results)):
            plan.outs[i] = self._kept[len(prepared) + i]
        self._plan = plan
        self._run = kernel.library.lib.bs_run_plan

    def __call__(self) -> None:
        self._run(self._plan)
