"""Algorithms of the package's generated programs: compiled at install, else at first use, in C or by numba."""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

from ..codegen.build.extension import generated_extension, load
from ..codegen.build.installed import bundled_folder, headers, installed_program
from ..codegen.build.toolchain import REMEDY_OF_PROGRAMS, compiler, missing_compiler, required_compiler
from ..codegen.execute.in_place import Entry, InPlace, read_entries
from ..codegen.execute.items import CLoop, CompiledLoop, Loop

if TYPE_CHECKING:
    from ..codegen.execute.cuda_items import CudaLoops

_log = logging.getLogger("bladesmith")


@cache
def stock_algorithm(program: str, name: str, part: str, what: str, numba_text: Callable[[str], str]) -> InPlace:
    """An algorithm of ``generated/<program>``, ready to run.

    Parameters
    ----------
    program : str
    name, part : str
        As the program's module names them.
    what : str
        What is compiled, for messages: "merging is compiled at its first use".
    numba_text : callable
        Gives the text of a part for numba.

    Raises
    ------
    CompilerMissingError
        If it is not installed, and there are neither a compiler nor numba.
    """
    entry = _entries(program)[f"{name}_{part}"]
    return InPlace(entry, _c_loop(program, part, entry) or _numba_loop(program, part, entry, what, numba_text))


@cache
def stock_algorithm_on_gpu(program: str, name: str, part: str, changed: tuple[str, ...]) -> InPlace:
    """An algorithm of ``generated/<program>`` for a GPU, a thread for each item.

    Parameters
    ----------
    program, name, part : str
        As for `stock_algorithm`.
    changed : tuple of str
        The arrays that it changes.

    Raises
    ------
    DeviceError
        If there is no GPU.
    MissingExtraError
        If its compiler, NVRTC, is not installed.
    """
    from ..codegen.execute.cuda_items import CudaLoop

    entry = _entries(program)[f"{name}_{part}"]
    count = len(entry.parameters)
    written = [k for k, (own, _, _) in enumerate(entry.parameters) if own in changed]
    returned = range(count, count + len(entry.results))
    return InPlace(entry, CudaLoop(_loops_on_gpu(program, part), f"bs_{entry.name}_f64", [*written, *returned]))


@cache
def _loops_on_gpu(program: str, part: str) -> CudaLoops:
    from ..codegen.execute.cuda_driver import first_gpu
    from ..codegen.execute.cuda_items import CudaLoops, compile_loops
    from ..codegen.targets.cuda.printer import stock_source

    texts = ("kernels.c", "kernels.h", "algorithm_functions.h", "algorithms.json")
    source = stock_source({name: _text(program, name) for name in texts}, part)
    most = max(len(e.parameters) + len(e.results) for e in _entries(program).values() if e.part == part)
    return CudaLoops(compile_loops(first_gpu(), source), most)


@cache
def _entries(program: str) -> dict[str, Entry]:
    return read_entries(_text(program, "algorithms.json"))


def _text(program: str, file: str) -> str:
    return (bundled_folder(program) / file).read_text(encoding="utf-8")


def _c_loop(program: str, part: str, entry: Entry) -> Loop | None:
    module = installed_program(program) or (_compiled_part(program, part) if compiler() else None)
    return None if module is None else CLoop(module, "f64", f"bs_{entry.name}")


@cache
def _compiled_part(program: str, part: str) -> Any:
    """One part of a program, from the cache or compiled now."""
    whole = generated_extension(bundled_folder(program), headers())
    own = "".join(line for line in whole.cdef.splitlines(keepends=True) if f"_{part}_f64(" in line)
    options = (*whole.options, "-DBS_SOME_PARTS", f"-DBS_PART_{part}")
    return load(replace(whole, name=f"{program}_{part}", cdef=own, options=options))


def _numba_loop(program: str, part: str, entry: Entry, what: str, numba_text: Callable[[str], str]) -> Loop:
    if find_spec("numba") is None:
        required_compiler(what, f"{REMEDY_OF_PROGRAMS}, or numba")
    return CompiledLoop(_numba_module(program, part, numba_text)[entry.name])


@cache
def _numba_module(program: str, part: str, numba_text: Callable[[str], str]) -> Any:
    from ..codegen.execute.numba_cache import CachedModule

    _log.warning("%s_%s runs by numba: %s.", program, part, missing_compiler().what)
    signatures = {name: entry.signature() for name, entry in _entries(program).items() if entry.part == part}
    return CachedModule(f"{program}_{part}", numba_text(part), signatures)
