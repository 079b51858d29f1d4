"""C text in, imported module out: cffi's wrapper, one run of the compiler, the cache.

The compiler is called directly, not through setuptools (slow, and absent from new Pythons). This module knows nothing
of kernels, templates or arrays. For separate compilation see `translation_units`.
"""

from __future__ import annotations

import ctypes
import hashlib
import json
import logging
import os
import sys
import sysconfig
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import lru_cache
from importlib.machinery import ExtensionFileLoader
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from threading import Lock, Timer
from types import ModuleType

import _cffi_backend

from ..errors import SpecError
from ..targets.c.instances import Instance
from ..targets.c.source import ExtensionSource, Unit
from ..version import __version__
from . import cache
from .flags import C_FLAGS, HASH_MACRO, compiled_files, source_hash, unit_file, unit_name, unit_options
from .toolchain import CompilerInfo, compiler, required_compiler, run_compiler
from .translation_units import Compilation, compile_units, emit_wrapper, stem_of

__all__ = [
    "CompilerInfo",
    "compiler",
    "generated_extension",
    "generated_unit",
    "load",
    "load_unit",
    "required_compiler",
]

_WRAPPER_OPTIONS = ("-O1",)  # a few conversions per call: more takes as long again, and gains nothing
#: Seconds of compiling after which a terminal is told of it, once in a process.
PATIENCE = 3.0
_log = logging.getLogger("bladesmith")
#: What a user who waits is told; commands, which say what they do, silence it.
_notices = logging.getLogger("bladesmith.compiling")


def extension_key(extension: ExtensionSource) -> str:
    """Digest of everything that changes the compiled module.

    Raises
    ------
    CompilerMissingError
        If there is no compiler, whose version is a part of the key.
    """
    return _key(extension, required_compiler())


def load(extension: ExtensionSource) -> ModuleType:
    """The compiled module, with `.ffi` and `.lib`: loaded before, from the cache, or compiled now.

    Raises
    ------
    CompilerMissingError
        If there is no compiler.
    CompileError
        If the compiler refuses the source.
    """
    chosen = required_compiler()
    stem = stem_of(extension.name, _key(extension, chosen))
    with _loading.lock(stem):
        module = _loading.modules.get(stem)
        if module is None:
            module = _loading.modules[stem] = _load(stem, extension, chosen)
    return module


def load_unit(unit: ExtensionSource) -> int:
    """Address of a unit of kernels, what its ``bs_this_unit()`` returns: nothing is declared, and no module is made.

    Raises
    ------
    CompilerMissingError, CompileError
        As `load`.
    """
    return int(load(unit).address)


def unit_stem(unit: ExtensionSource) -> str:
    """Name of a unit's entry in the cache. Raises CompilerMissingError if there is no compiler."""
    return stem_of(unit.name, _key(unit, required_compiler()))


def unit_in_cache(stem: str) -> int | None:
    """Address of a unit by the name of its entry; None where the cache does not hold it."""
    with _loading.lock(stem):
        module = _loading.modules.get(stem)
        if module is None:
            library = cache.find(stem)
            if library is None:
                return None
            try:
                module = _loading.modules[stem] = _open_unit(stem, library)
            except OSError:  # removed after it was checked
                return None
    return int(module.address)


def build_identity() -> tuple[object, ...]:
    """Everything that changes compiled code besides its text. Raises CompilerMissingError if there is no compiler."""
    return _identity(required_compiler())


def generated_extension(folder: Path, headers: Path) -> ExtensionSource:
    """The extension of a generated folder, for when it was not compiled at install or has changed since.

    Parameters
    ----------
    folder
        `generated/<name>`, with `kernels.c` and `kernels.cdef`.
    headers
        `templates/c`.
    """
    files = compiled_files(folder, headers)
    if not {"kernels.c", "kernels.cdef"} <= files.keys():
        raise SpecError(f"{folder} holds no kernels.c and kernels.cdef", remedy="Run: bladesmith generate")
    define = f'-D{HASH_MACRO}="{source_hash(files)}"'
    return ExtensionSource(folder.name, files.pop("kernels.cdef"), '#include "kernels.c"\n', files, (define,))


def generated_unit(folder: Path, headers: Path, module: str, instance: Instance) -> ExtensionSource:
    """One module's kernels for one instance, for `load_unit`: ``bs_add_unit`` of the folder's extension takes it.

    Parameters
    ----------
    folder, headers
        As for `generated_extension`.
    module
        Of formulas: the text is `kernels/<module>.c`.
    instance
        Precision and vector width.
    """
    files = compiled_files(folder, headers, [unit_file(module)])
    if unit_file(module) not in files:
        raise SpecError(f"{folder} holds no {unit_file(module)}", remedy="Run: bladesmith generate")
    options = unit_options(module, instance, source_hash(files))
    unit = f"const void *bs_this_unit(void) {{ return &bs_{unit_name(module, instance.tag)}; }}\n"
    name = f"{folder.name}_{unit_name(module, instance.tag)}"
    return ExtensionSource(name, "", files.pop(unit_file(module)) + unit, files, options)


class _Loading:
    """The modules of this process and a lock for each: no two threads load the same one."""

    def __init__(self) -> None:
        self.modules: dict[str, ModuleType] = {}
        self.forget_locks()

    def forget_locks(self) -> None:
        """After a fork: locks held by threads that do not exist in the child are never released."""
        self._guard = Lock()
        self._locks: dict[str, Lock] = {}

    def lock(self, stem: str) -> Lock:
        with self._guard:
            return self._locks.setdefault(stem, Lock())


_loading = _Loading()
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=lambda: _loading.forget_locks())


def _include() -> str:
    return sysconfig.get_path("include")


def has_python_headers() -> bool:
    """Return whether modules for this interpreter can be compiled; without, libraries are opened through libffi."""
    return (Path(_include()) / "Python.h").is_file()


def _key(extension: ExtensionSource, chosen: CompilerInfo) -> str:
    """A change of any of these may change the code; the layout of this list is part of the format."""
    parts = [extension.main().parts(), extension.cdef, [u.parts() for u in extension.units], _identity(chosen)]
    return hashlib.sha256(json.dumps(parts).encode()).hexdigest()


def _identity(chosen: CompilerInfo) -> tuple[object, ...]:
    """Everything that changes the code besides its text."""
    return (
        C_FLAGS, chosen.command, chosen.version,
        sys.implementation.cache_tag, sysconfig.get_config_var("SOABI"), sysconfig.get_platform(),
        has_python_headers(), _cffi_backend.__version__, __version__,
    )  # fmt: skip


def _load(stem: str, extension: ExtensionSource, chosen: CompilerInfo) -> ModuleType:
    def build(folder: Path) -> Mapping[str, object]:
        with _notice():
            return _compile(stem, extension, chosen, folder)

    try:
        return _import(stem, extension, cache.fetch(stem, build))
    except (ImportError, OSError):  # removed after it was checked, or a library of a different system
        cache.discard(stem)
        return _import(stem, extension, cache.fetch(stem, build))


@contextmanager
def _notice() -> Iterator[None]:
    """Tell a user at a terminal why a first use takes seconds, if the block does."""
    timer = Timer(PATIENCE, _tell_of_compiling)
    timer.daemon = True
    if sys.stderr is not None and sys.stderr.isatty():
        timer.start()
    try:
        yield
    finally:
        timer.cancel()


@lru_cache(maxsize=1)
def _tell_of_compiling() -> None:
    """Once in a process."""
    _notices.warning("bladesmith compiles what is used for the first time; it is kept for later runs.")


def _compile(stem: str, extension: ExtensionSource, chosen: CompilerInfo, folder: Path) -> Mapping[str, object]:
    """Write the sources into `folder` and compile them there."""
    start = time.perf_counter()
    command = (*chosen.command, *C_FLAGS)
    library = ["-o", stem + cache.LIBRARY_SUFFIX, "-lm"]
    if extension.units:
        how = Compilation((*command, f"-I{_include()}"), _module_name(stem, extension), _identity(chosen))
        objects = compile_units(_all_units(extension), how, folder)
        link = [*chosen.command, *_library_options(), *objects, *library]
        run_compiler(link, folder, extension.name, folder / f"{extension.name}.c")
        for name in objects:
            (folder / name).unlink()
    else:
        for name, text in extension.headers.items():
            (folder / name).write_text(text, encoding="utf-8")
        source = folder / f"{stem}.c"
        if extension.cdef and has_python_headers():
            emit_wrapper(stem, extension.cdef, extension.source, source, extension.name)
        else:
            source.write_text(extension.source, encoding="utf-8")
        include = [f"-I{_include()}"] if extension.cdef else []
        options = [*extension.options, *_library_options(), *include, "-I."]
        run_compiler([*command, *options, source.name, *library], folder, extension.name, source)
    seconds = time.perf_counter() - start
    _log.info("compiled %s in %.2f s with %s", extension.name, seconds, chosen.summary)
    return {"name": extension.name, "seconds": round(seconds, 3), "compiler": chosen.summary}


def _all_units(extension: ExtensionSource) -> list[Unit]:
    """The units of an extension, its source, and the wrapper that makes it a module: one for each declarations."""
    units = [*extension.units, extension.main()]
    if has_python_headers():
        preamble = f"#include <stddef.h>\n#include <stdint.h>\n{extension.cdef}\n"
        units.append(Unit(f"{extension.name}_module", preamble, {}, _WRAPPER_OPTIONS, extension.cdef))
    return units


def _module_name(stem: str, extension: ExtensionSource) -> str:
    """Modules whose wrappers are shared have the extension's name, others one of their own."""
    return f"bs_{extension.name}" if extension.units else stem


def _library_options() -> list[str]:
    return ["-bundle", "-undefined", "dynamic_lookup"] if sys.platform == "darwin" else ["-shared", "-fPIC"]


def _import(stem: str, extension: ExtensionSource, library: Path) -> ModuleType:
    if not extension.cdef:
        return _open_unit(stem, library)
    if not has_python_headers():
        return _open(stem, extension, library)
    name = _module_name(stem, extension)
    spec = spec_from_file_location(name, library, loader=ExtensionFileLoader(name, str(library)))
    assert spec is not None and spec.loader is not None
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def _open_unit(stem: str, library: Path) -> ModuleType:
    this_unit = ctypes.CDLL(str(library)).bs_this_unit  # what was opened is never closed
    this_unit.restype = ctypes.c_void_p
    module = ModuleType(stem)
    module.address = this_unit() or 0  # type: ignore[attr-defined]
    return module


def _open(stem: str, extension: ExtensionSource, library: Path) -> ModuleType:
    """Without Python.h the library is plain C, called through libffi: slower per call, the same results."""
    from cffi import FFI

    module = ModuleType(stem)
    ffi = FFI()
    ffi.cdef(extension.cdef)
    vars(module).update(ffi=ffi, lib=ffi.dlopen(str(library)))
    return module
