"""Translation units of an extension: compiled separately and in parallel, and reused by other extensions.

Programs define the units; `extension` links them.
"""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import time
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from ..errors import CompileError
from ..targets.c.source import Unit
from . import cache
from .toolchain import run_compiler

STEM_NAME = 60  # characters of the name in file names, which systems limit to 255
STEM_DIGITS = 24  # 96 bits of the key: no two sources will ever share them
_ATTEMPTS = 2  # an object that another process removes between finding and copying it is made again


@dataclass(frozen=True)
class Compilation:
    """How units are compiled.

    Parameters
    ----------
    command
        The compiler and the options of all units.
    module
        Name of the module that wrappers are for.
    identity
        Everything else that changes what is compiled: versions, platform.
    """

    command: tuple[str, ...]
    module: str
    identity: tuple[object, ...]

    def stem(self, unit: Unit) -> str:
        """Name of the unit's entry in the cache."""
        parts = [unit.parts(), self.command, self.module, self.identity]
        digest = hashlib.sha256(json.dumps(parts).encode()).hexdigest()
        return stem_of(unit.name, digest)


def stem_of(name: str, digest: str) -> str:
    """Name of an entry in the cache."""
    return f"bs_{name[:STEM_NAME]}_{digest[:STEM_DIGITS]}"


def compile_units(units: Sequence[Unit], how: Compilation, folder: Path) -> list[str]:
    """Objects of all units, as names of files in a folder; those that take longest should come first.

    Raises
    ------
    CompilerMissingError, CompileError, OSError
        As by `run_compiler`.
    """
    processors = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    with ThreadPoolExecutor(min(processors, len(units))) as pool:
        return list(pool.map(lambda unit: _object(unit, how, folder), units))


def _object(unit: Unit, how: Compilation, folder: Path) -> str:
    if not unit.kept:
        compile_unit(unit, unit.name, how, folder)
        return unit.name + cache.OBJECT_SUFFIX
    stem = how.stem(unit)

    def build(home: Path) -> Mapping[str, object]:
        start = time.perf_counter()
        compile_unit(unit, stem, how, home)
        return {"name": unit.name, "seconds": round(time.perf_counter() - start, 3)}

    for attempt in range(_ATTEMPTS):
        path = cache.fetch(stem, build, cache.OBJECT_SUFFIX)
        try:
            shutil.copyfile(path, folder / path.name)
        except FileNotFoundError:
            if attempt + 1 == _ATTEMPTS:
                raise
    return path.name


def compile_unit(unit: Unit, stem: str, how: Compilation, folder: Path) -> None:
    """Write a unit's texts into a folder and compile them there."""
    for name, text in unit.headers.items():
        (folder / name).write_text(text, encoding="utf-8")
    source = folder / f"{stem}.c"
    if unit.declarations:
        emit_wrapper(how.module, unit.declarations, unit.source, source, unit.name)
    else:
        source.write_text(unit.source, encoding="utf-8")
    command = [*how.command, *unit.options, "-fPIC", "-I.", "-c", source.name, "-o", stem + cache.OBJECT_SUFFIX]
    run_compiler(command, folder, unit.name, source)


def emit_wrapper(module: str, declarations: str, preamble: str, path: Path, where: str) -> None:
    """Write the C text of a module: a preamble, and cffi's functions around what is declared."""
    from cffi import FFI, CDefError, FFIError, VerificationError

    ffi = FFI()
    try:
        ffi.cdef(declarations)
        ffi.set_source(module, preamble, compiler_verbose=0)  # cffi would print to stdout
        ffi.emit_c_code(str(path))
    except (CDefError, FFIError, VerificationError) as error:
        raise CompileError(str(error).splitlines()[0], where=f"declarations of {where}") from None
