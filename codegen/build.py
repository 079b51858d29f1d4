"""C text in, imported module out: cffi's wrapper, one run of the compiler, the cache.

The compiler is called directly, not through setuptools (slow, and absent from new Pythons). Kernels,
templates and arrays are not known here.
"""

from __future__ import annotations

import errno
import hashlib
import json
import logging
import os
import re
import sys
import sysconfig
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib.machinery import ExtensionFileLoader
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from threading import Lock
from types import ModuleType

import _cffi_backend

from . import cache
from .errors import CompileError, CompilerMissingError, SpecError
from .flags import C_FLAGS, HASH_MACRO, compiled_files, source_hash
from .toolchain import REMEDY, CompilerInfo, compiler, execute, required_compiler
from .version import __version__

__all__ = ["CompilerInfo", "ExtensionSource", "compiler", "generated_extension", "load", "source_hash"]

_STEM_NAME = 60  # characters of the name in file names, which systems limit to 255
_STEM_DIGITS = 24  # 96 bits of the key: no two sources will ever share them
_ERROR_LINES = 3
_log = logging.getLogger("bladesmith")


@dataclass(frozen=True)
class ExtensionSource:
    """Everything that a compiled module is made of.

    Parameters
    ----------
    name
        An identifier, the beginning of the module's name.
    cdef
        Declarations, as cffi reads them, of functions with external linkage.
    source
        The C text.
    headers
        File name -> text of what `source` includes.
    options
        Options of the compiler after `C_FLAGS`, such as `-march=native`.
    """

    name: str
    cdef: str
    source: str
    headers: Mapping[str, str] = field(default_factory=dict)
    options: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if not (self.name.isidentifier() and self.name.isascii()):
            raise SpecError(f"{self.name!r} cannot name an extension", remedy="Use letters, digits and _.")
        for header in self.headers:
            if not re.fullmatch(r"\w[\w.-]*", header):
                raise SpecError(f"{header!r} cannot name a header", where=f"extension {self.name}")

    def key(self) -> str:
        """Digest of everything that changes the compiled module.

        Raises
        ------
        CompilerMissingError
            If there is no compiler, whose version is a part of the key.
        """
        return _key(self, required_compiler())


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
    stem = f"bs_{extension.name[:_STEM_NAME]}_{_key(extension, chosen)[:_STEM_DIGITS]}"
    with _loading.lock(stem):
        module = _loading.modules.get(stem)
        if module is None:
            module = _loading.modules[stem] = _load(stem, extension, chosen)
    return module


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
    """Whether modules for this interpreter can be compiled; without, libraries are opened through libffi."""
    return (Path(_include()) / "Python.h").is_file()


def _key(extension: ExtensionSource, chosen: CompilerInfo) -> str:
    """A change of any of these may change the code; the layout of this list is part of the format."""
    parts = [
        extension.name, extension.cdef, extension.source, sorted(extension.headers.items()),
        extension.options, C_FLAGS, chosen.command, chosen.version,
        sys.implementation.cache_tag, sysconfig.get_config_var("SOABI"), sysconfig.get_platform(),
        has_python_headers(), _cffi_backend.__version__, __version__,
    ]  # fmt: skip
    return hashlib.sha256(json.dumps(parts).encode()).hexdigest()


def _load(stem: str, extension: ExtensionSource, chosen: CompilerInfo) -> ModuleType:
    def build(folder: Path) -> Mapping[str, object]:
        return _compile(stem, extension, chosen, folder)

    try:
        return _import(stem, extension, cache.fetch(stem, build))
    except (ImportError, OSError):  # removed after it was checked, or a library of a different system
        cache.discard(stem)
        return _import(stem, extension, cache.fetch(stem, build))


def _compile(
    stem: str, extension: ExtensionSource, chosen: CompilerInfo, folder: Path
) -> Mapping[str, object]:
    """Write the sources into `folder` and compile them there."""
    start = time.perf_counter()
    for name, text in extension.headers.items():
        (folder / name).write_text(text, encoding="utf-8")
    source = folder / f"{stem}.c"
    if has_python_headers():
        _emit_wrapper(stem, extension, source)
    else:
        source.write_text(extension.source, encoding="utf-8")
    command = [*chosen.command, *C_FLAGS, *extension.options, *_library_options(), f"-I{_include()}", "-I."]
    _run([*command, source.name, "-o", stem + cache.LIBRARY_SUFFIX, "-lm"], extension, folder, source)
    seconds = time.perf_counter() - start
    _log.info("compiled %s in %.2f s with %s", extension.name, seconds, chosen.summary)
    return {"name": extension.name, "seconds": round(seconds, 3), "compiler": chosen.summary}


def _library_options() -> list[str]:
    return ["-bundle", "-undefined", "dynamic_lookup"] if sys.platform == "darwin" else ["-shared", "-fPIC"]


def _emit_wrapper(stem: str, extension: ExtensionSource, source: Path) -> None:
    from cffi import FFI, CDefError, FFIError, VerificationError

    ffi = FFI()
    try:
        ffi.cdef(extension.cdef)
        ffi.set_source(stem, extension.source, compiler_verbose=0)  # cffi would print to stdout
        ffi.emit_c_code(str(source))
    except (CDefError, FFIError, VerificationError) as error:
        raise CompileError(str(error).splitlines()[0], where=f"declarations of {extension.name}") from None


def _run(command: list[str], extension: ExtensionSource, folder: Path, source: Path) -> None:
    try:
        done = execute(command, folder=folder)
    except OSError as error:  # it answered --version, and is gone
        raise CompilerMissingError(f"{command[0]} does not run: {error.strerror}", remedy=REMEDY) from None
    if done.returncode == 0:
        return
    output = done.stderr or done.stdout
    for number in (errno.ENOSPC, errno.EDQUOT):
        if os.strerror(number) in output:  # not the source's fault: another directory may do
            raise OSError(number, os.strerror(number), str(folder))
    raise CompileError(_first_errors(output), where=extension.name, source=source)


def _first_errors(output: str) -> str:
    lines = [line.strip() for line in output.splitlines() if line.strip()]
    # collect2 only says that the linker failed
    lines = [line for line in lines if not line.startswith("collect2:")] or lines
    errors = [line for line in lines if "error:" in line] or lines
    return " | ".join(errors[:_ERROR_LINES]) or "the compiler failed and said nothing"


def _import(stem: str, extension: ExtensionSource, library: Path) -> ModuleType:
    if not has_python_headers():
        return _open(stem, extension, library)
    spec = spec_from_file_location(stem, library, loader=ExtensionFileLoader(stem, str(library)))
    assert spec is not None and spec.loader is not None
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def _open(stem: str, extension: ExtensionSource, library: Path) -> ModuleType:
    """Without Python.h the library is plain C, called through libffi: slower per call, the same results."""
    from cffi import FFI

    module = ModuleType(stem)
    ffi = FFI()
    ffi.cdef(extension.cdef)
    vars(module).update(ffi=ffi, lib=ffi.dlopen(str(library)))
    return module
