"""Algorithms of the package's generated programs: compiled at install, else at first use, in C or by numba."""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from importlib.util import find_spec
from typing import Any

from ..codegen.build.extension import generated_extension, load
from ..codegen.build.toolchain import REMEDY_OF_PROGRAMS, compiler, missing_compiler, required_compiler
from ..codegen.execute.in_place import Entry, InPlace, read_entries
from ..codegen.execute.items import CLoop, CompiledLoop, Loop
from .installed import bundled_folder, headers, installed_program

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
