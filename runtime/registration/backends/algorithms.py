"""The algorithms of a registration, by name, on the backends that run on this processor: compiled C, and numba."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from functools import cache
from importlib.util import find_spec
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.build.extension import load
from ...codegen.build.installed import bundled_folder, installed_program
from ...codegen.build.toolchain import REMEDY_OF_PROGRAMS, compiler, missing_compiler, required_compiler
from ...codegen.execute.in_place import Entry, InPlace, Kept, read_entries
from ...codegen.execute.items import STORED, CLoop, CompiledLoop, Loop
from ...codegen.programs import Program
from ...codegen.programs.registration.program import reform_numba, reform_texts
from ...codegen.programs.registration.registration import KINDS, set_name
from ...codegen.programs.stock import ENTRIES
from ...common import parallel

Array = NDArray[Any]
_log = logging.getLogger("bladesmith")


class Algorithms:
    """Algorithms for models of some kinds, one item after another, over threads.

    Parameters
    ----------
    kinds : str
        Name of the set of kinds.
    entries : mapping of str to Entry
    loop_of : callable
        Gives the compiled loop of an entry.
    hold : callable
        Holds an array as these loops do.
    """

    def __init__(
        self, kinds: str, entries: Mapping[str, Entry], loop_of: Callable[[Entry], Loop], hold: Callable[[Array], Any]
    ) -> None:
        self._kinds, self._entries, self._loop_of, self._hold = kinds, entries, loop_of, hold
        self._ready: dict[str, InPlace] = {}

    def keep(self, arrays: Mapping[str, Array]) -> Mapping[str, Any]:
        """Arrays for many calls: as arguments that all items share."""
        return {name: Kept(self._hold(array), len(array)) for name, array in arrays.items()}

    def run(
        self, name: str, n: int, each: Mapping[str, Array], shared: Mapping[str, Any], changed: tuple[str, ...] = (),
        threads: int | None = 1, grain: int = 1,
    ) -> list[Array]:  # fmt: skip
        """Run an algorithm on n items; arrays (n,) of what it returns.

        Parameters
        ----------
        name : str
        n : int
        each, shared : mapping of str to array or number
            Arguments, contiguous arrays of float64 or int64: those that items have of their own, along a first axis,
            and those that all share.
        changed : tuple of str
            Arguments that it changes.
        threads, grain : int
            Items that are worth another thread.
        """
        ready = self._ready.get(name)
        if ready is None:
            entry = self._entries[f"{name}_{self._kinds}"]
            ready = self._ready.setdefault(name, InPlace(entry, self._loop_of(entry)))
        if not n:
            return [np.empty(0, STORED[type]) for type in ready.entry.results]
        bound = ready.over(n, each, shared)
        if threads == 1:
            bound.run(0, n)
        else:
            parallel.run(bound.run, n, threads, grain=grain)
        return bound.returned


@cache
def c_algorithms(kinds: tuple[str, ...]) -> Algorithms:
    """Installed algorithms of all kinds, or those of these kinds from the cache, or compiled now; else by numba.

    Raises
    ------
    CompilerMissingError
        If they are not installed, and there are neither a compiler nor numba.
    """
    module = installed_program("reform")
    known: tuple[str, ...] = KINDS
    if module is None:
        if compiler() is None:
            if find_spec("numba") is None:
                required_compiler("registration is compiled at its first use", REMEDY_OF_PROGRAMS)
            _log.warning("registration runs by numba: %s.", missing_compiler().what)
            return numba_algorithms(kinds)
        known = kinds
        module = _load_program(kinds)

    def loop_of(entry: Entry) -> Loop:
        return CLoop(module, "f64", f"bs_{entry.name}")

    return Algorithms(set_name(known), entries_of(known), loop_of, module.ffi.from_buffer)


def _load_program(kinds: tuple[str, ...]) -> Any:
    return load(program_of(kinds).extension())


@cache
def program_of(kinds: tuple[str, ...]) -> Program:
    """The program of these kinds as text: that of all kinds as the package carries it."""
    name = set_name(kinds)
    if kinds != KINDS:
        return Program(f"reform_{name}", (), reform_texts(kinds))
    folder = bundled_folder("reform")
    suffixes = (".c", ".h", ".cdef", ".json")
    files = {path.name: path.read_text(encoding="utf-8") for path in folder.iterdir() if path.suffix in suffixes}
    return Program("reform", (), files)


@cache
def entries_of(kinds: tuple[str, ...]) -> Mapping[str, Entry]:
    """Names and sizes that callers of the algorithms of these kinds need."""
    return read_entries(program_of(kinds).files[ENTRIES])


@cache
def numba_algorithms(kinds: tuple[str, ...]) -> Algorithms:
    """Algorithms of these kinds, from the cache or compiled at first use.

    Raises
    ------
    MissingExtraError
        If numba is not installed.
    """
    from ...codegen.execute.numba_cache import CachedModule

    entries = entries_of(kinds)
    signatures = {f"bs_{name}": entry.signature() for name, entry in entries.items()}
    module = CachedModule(f"reform_{set_name(kinds)}", reform_numba(kinds), signatures)
    return Algorithms(set_name(kinds), entries, lambda entry: CompiledLoop(module[f"bs_{entry.name}"]), np.ravel)
