"""Compiled programs of simulations, in C or by numba, and the functions of users that they call."""

from __future__ import annotations

import json
import logging
from collections.abc import Callable, Mapping
from functools import cache, cached_property
from importlib.util import find_spec
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...codegen.build.cpu_features import has_wide_vectors
from ...codegen.build.extension import load
from ...codegen.build.toolchain import missing_compiler, required_compiler
from ...codegen.errors import CompilerMissingError, InputError
from ...codegen.execute.in_place import InPlace, Kept, read_entries
from ...codegen.execute.items import CLoop, CompiledLoop, Loop, flat
from ...codegen.programs.dynamics.config import DynamicsConfig
from ...codegen.programs.dynamics.dynamics import PART, RECORDS, dynamics_program, numba_program
from ...codegen.programs.dynamics.wide import WideRun, is_wide, wide_run
from ...codegen.programs.stock import ENTRIES
from ...codegen.programs.tree_motion import tree_motion_numba, tree_motion_program
from ..assembly.callbacks import CallbackRegistry

Array = NDArray[Any]
_log = logging.getLogger("bladesmith")
#: What runs simulations.
TARGETS = ("c", "numba", "cuda")
#: Arguments that algorithms change, beside their work.
_CHANGED = frozenset(
    ("kept", "stages", "progress", "reached", "states", "tangents", "motors", "twists", "accelerations", "reactions",
     "matrix", "right", "errors", "rates")
)  # fmt: skip
#: The same of motions of trees.
_CHANGED_OF_TREES = frozenset(
    ("kept", "state", "references", "old_references", "x", "end", "fresh", "stages", "work", "acting", "progress",
     "reached", "motors", "twists", "reactions", "coordinates", "row_work", "matrix", "violations")
)  # fmt: skip


class Layout(NamedTuple):
    """Where the fields of a record begin, and how many numbers it has."""

    size: int
    offsets: Mapping[str, int]


class SimulationProgram:
    """Loops over simulations.

    Parameters
    ----------
    needs : DynamicsConfig
    entries, records : str
        JSON texts of the program.
    loop_of : callable
        Gives the compiled loop of a name.
    hold : callable
        Holds an array as these loops do.
    hold_functions : callable
        Makes a registry callable from the loops: a number that these take, and what must live as long.

    Attributes
    ----------
    needs : DynamicsConfig
        What it is for, with the lanes that it has.
    work, integers, kept : Layout
        Of what each thread brings along, and of what is kept for each simulation.
    is_on_gpu : bool
        Whether each simulation is a thread, with work of its own.
    has_wide_run : bool
        Whether it may run several simulations at once: C does.
    """

    is_on_gpu = False
    has_wide_run = False

    def __init__(
        self, needs: DynamicsConfig, entries: str, records: str, loop_of: Callable[[str], Loop],
        hold: Callable[[Array], Any], hold_functions: Callable[[CallbackRegistry], tuple[int, Any]],
    ) -> None:  # fmt: skip
        self.needs = needs
        self._entries, self._loop_of, self._hold = read_entries(entries), loop_of, hold
        self.hold_functions = hold_functions
        self._ready: dict[str, InPlace] = {}
        layouts = {name: Layout(*each) for name, each in json.loads(records).items()}
        self.work, self.integers, self.kept = layouts["work"], layouts["integers"], layouts["kept"]
        self.workspace_bytes = 8 * (self.work.size + self.integers.size)

    def keep(self, arrays: Mapping[str, Array], n: int = 0) -> dict[str, Kept]:
        """Arrays as arguments of many calls: of n simulations each its own, along a first axis; or all share them."""
        if n:
            return {
                name: Kept(self._hold(x), x.shape[1] if x.ndim > 1 else 0, x.size // n) for name, x in arrays.items()
            }
        return {name: Kept(self._hold(x), len(x)) for name, x in arrays.items()}

    def __getitem__(self, name: str) -> InPlace:
        """An algorithm by name, ready to run."""
        ready = self._ready.get(name)
        if ready is None:
            key = f"{name}_{PART}"
            ready = self._ready.setdefault(name, InPlace(self._entries[key], self._loop_of(key)))
        return ready

    @cached_property
    def wide(self) -> WideRun | None:
        """Text of the run of simulations for several at once; None where there is none."""
        return wide_run(self.needs) if self.has_wide_run and is_wide(self.needs) else None

    @cached_property
    def wide_run(self) -> InPlace:
        """The same, compiled at its first use."""
        assert self.wide is not None
        return InPlace(self._entries[f"run_{PART}"], CLoop(load(self.wide.source), self.wide.tag))


@cache
def program_for(needs: DynamicsConfig, target: str) -> SimulationProgram:
    """The program of simulations with these needs; by numba where there is no compiler.

    Parameters
    ----------
    needs : DynamicsConfig
    target : str
        Of `TARGETS`.

    Raises
    ------
    CompilerMissingError
        If there is neither a compiler nor numba.
    MissingExtraError
        If numba is asked for and not installed.
    DeviceError
        If the target is "cuda" and there is no GPU.
    InputError
        If it is, and functions of users are called.
    """
    if target == "cuda":
        return _cuda_program(needs)
    if target == "c":
        try:
            # before the program is generated, which takes longer
            required_compiler("simulations are compiled when they first run")
            return _c_program(needs)
        except CompilerMissingError:
            if find_spec("numba") is None:
                raise
            _log.warning("simulations run by numba: %s.", missing_compiler().what)
    return _numba_program(needs)


def _c_program(needs: DynamicsConfig) -> SimulationProgram:
    needs = needs.with_lanes if has_wide_vectors() else needs
    program = dynamics_program(needs)
    module = load(program.extension())
    if needs.callbacks:
        _define_callback(module)

    def hold_functions(functions: CallbackRegistry) -> tuple[int, Any]:
        handle = module.ffi.new_handle(functions)
        return int(module.ffi.cast("intptr_t", handle)), handle

    found = SimulationProgram(
        needs, program.files[ENTRIES], program.files[RECORDS], lambda key: CLoop(module, "f64", f"bs_{key}"),
        module.ffi.from_buffer, hold_functions,
    )  # fmt: skip
    found.has_wide_run = True
    return found


def _numba_program(needs: DynamicsConfig) -> SimulationProgram:
    from cffi import FFI

    from ...codegen.execute.numba_cache import CachedModule
    from ...codegen.execute.numba_callbacks import C_TYPE

    name, text, entries, records = numba_program(needs)
    signatures = {key: entry.signature() for key, entry in read_entries(entries).items()}
    module, ffi = CachedModule(name, text, signatures), FFI()

    def hold_functions(functions: CallbackRegistry) -> tuple[int, Any]:
        def on_error(_: Any, error: BaseException, traceback: Any) -> None:
            functions.keep(error)

        @ffi.callback(C_TYPE, error=1, onerror=on_error)  # type: ignore[untyped-decorator, unused-ignore]
        def call_function(which: int, item: int, t: float, state: Any, out: Any) -> int:
            return call_user(ffi, functions, which, item, t, state, out)

        return int(ffi.cast("intptr_t", call_function)), call_function

    return SimulationProgram(needs, entries, records, lambda key: CompiledLoop(module[key]), flat, hold_functions)


def _cuda_program(needs: DynamicsConfig) -> SimulationProgram:
    if needs.callbacks:
        raise InputError("functions of time or state do not run on a GPU.", remedy='Use target="c" or "numba"')
    files = dynamics_program(needs).files
    found = SimulationProgram(
        needs, files[ENTRIES], files[RECORDS], _loops_on_gpu(files, _CHANGED), np.asarray,
        lambda functions: (0, functions),
    )  # fmt: skip
    found.is_on_gpu = True
    return found


def _loops_on_gpu(files: Mapping[str, str], changes: frozenset[str]) -> Callable[[str], Loop]:
    """The loops of a program by name, on the first GPU; ``changes`` are the arguments that they change."""
    from ...codegen.execute import cuda_driver, cuda_items
    from ...codegen.targets.cuda.printer import stock_source

    entries = read_entries(files[ENTRIES])
    most = max(len(entry.parameters) + len(entry.results) for entry in entries.values())
    loops = cuda_items.CudaLoops(cuda_items.compile_loops(cuda_driver.first_gpu(), stock_source(files)), most)

    def loop_of(key: str) -> Loop:
        parameters = entries[key].parameters
        changed = [k for k, (name, _, _) in enumerate(parameters) if name in changes]
        returned = range(len(parameters), len(parameters) + len(entries[key].results))
        return cuda_items.CudaLoop(loops, f"bs_{key}_f64", [*changed, *returned])

    return loop_of


@cache
def tree_loops(algebra: str, target: str, is_implicit: bool = False) -> tuple[dict[str, InPlace], bool]:
    """Algorithms of motions of trees by name, and whether they run on a GPU; by numba where there is no compiler.

    Those of implicit steps are a program of their own: explicit runs do not wait for its compilation.

    Raises
    ------
    CompilerMissingError, MissingExtraError, DeviceError
        As `program_for`.
    """
    from ...codegen.execute.numba_cache import CachedModule

    files = tree_motion_program(algebra, is_implicit).files if target == "cuda" else {}
    if target == "cuda":
        loop_of, text = _loops_on_gpu(files, _CHANGED_OF_TREES), files[ENTRIES]
    else:
        try:
            if target == "c":
                required_compiler("simulations are compiled when they first run")
        except CompilerMissingError:
            if find_spec("numba") is None:
                raise
            _log.warning("simulations run by numba: %s.", missing_compiler().what)
            target = "numba"
        if target == "c":
            program = tree_motion_program(algebra, is_implicit)
            text, module = program.files[ENTRIES], load(program.extension())
            loop_of = lambda key: CLoop(module, "f64", f"bs_{key}")  # noqa: E731
        else:
            texts = tree_motion_numba(algebra, is_implicit)
            text = texts.entries
            signatures = {key: entry.signature() for key, entry in read_entries(text).items()}
            compiled = CachedModule(texts.name, texts.text, signatures)
            loop_of = lambda key: CompiledLoop(compiled[key])  # noqa: E731
    found = {key.removesuffix(f"_{PART}"): InPlace(e, loop_of(key)) for key, e in read_entries(text).items()}
    return found, target == "cuda"


def _define_callback(module: Any) -> None:
    """Define the function through which compiled C calls functions of users."""

    def on_error(_: Any, error: BaseException, traceback: Any) -> None:
        # An interrupt may come before the first line of `call_function`, or between two of them.
        module.ffi.from_handle(traceback.tb_frame.f_locals["handle"]).keep(error)

    @module.ffi.def_extern(name="bs_dynamics_user", error=1, onerror=on_error)  # type: ignore[untyped-decorator, unused-ignore]
    def call_function(handle: Any, which: int, item: int, t: float, state: Any, out: Any) -> int:
        return call_user(module.ffi, module.ffi.from_handle(handle), which, item, t, state, out)


def call_user(ffi: Any, functions: CallbackRegistry, which: int, item: int, t: float, state: Any, out: Any) -> int:
    """Call a function of a user on memory of the loops: 0, or 1 if it failed."""
    values = np.frombuffer(ffi.buffer(state, 14 * 8), np.float64)
    value = functions.call(which, item, t, values)
    if value is None:
        return 1
    result = np.ascontiguousarray(value, np.float64).ravel()
    ffi.memmove(out, ffi.from_buffer(result), result.nbytes)
    return 0
