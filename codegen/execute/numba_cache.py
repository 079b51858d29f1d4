"""Printed numba modules whose machine code is kept in the cache: a second process loads it, and compiles nothing.

A text is executed as it was printed, never as the cache holds it; the file there is where numba keeps its code.
"""

from __future__ import annotations

import hashlib
import json
import linecache
import logging
import os
import shutil
import sys
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from importlib import import_module
from pathlib import Path
from threading import RLock
from types import FunctionType, ModuleType
from typing import Any

from ..build import cache
from .numba_inner import inner_compiler
from .numba_jit import numba, support

#: As of all printed kernels (see numba_run), but functions are inlined only where LLVM finds it worth while.
OPTIONS = {"error_model": "numpy", "fastmath": False, "nogil": True}
#: Of functions that only others of the text call: nothing is made for calls from elsewhere, and references are not
#: counted, since they make no array.
_INNER = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True, "_nrt": False}
_DIGITS = 24
_log = logging.getLogger("bladesmith")


class CachedModule:
    """A printed module, of which some functions are called from outside.

    Parameters
    ----------
    name : str
        What messages call it.
    source : str
        Its text.
    signatures : mapping of str to numba signature
        Of the functions that are called from outside. Each is compiled when it is first asked for.

    Raises
    ------
    MissingExtraError
        If numba is not installed.
    """

    def __init__(self, name: str, source: str, signatures: Mapping[str, Any]) -> None:
        self.name, self._signatures, self._lock = name, signatures, RLock()
        njit, digest = numba().njit, hashlib.sha256(source.encode()).hexdigest()[:_DIGITS]
        self._file, kept = _cache_file(f"numba_{name}_{digest}", source)
        module = ModuleType(f"bladesmith_{self._file.stem}")
        sys.modules[module.__name__] = module  # where kept machine code looks for what its functions name
        exec(compile(source, str(self._file), "exec"), vars(module))
        lines = source.splitlines(keepends=True)
        linecache.cache[str(self._file)] = (len(source), None, lines, str(self._file))
        for function, value in list(vars(module).items()):
            if isinstance(value, FunctionType):
                is_own = value.__globals__ is vars(module)
                caches = kept and function in signatures
                imported = None if is_own else getattr(support(value.__module__), function)
                inner = {} if function in signatures else {**_INNER, "pipeline_class": inner_compiler()}
                vars(module)[function] = imported or njit(**OPTIONS, **inner, cache=caches)(value)
        self._module = module
        self._ready: dict[str, Any] = {}

    def __getitem__(self, function: str) -> Any:
        """A compiled function, from the cache or compiled now."""
        ready = self._ready.get(function)
        if ready is None:
            with self._lock:
                ready = self._ready.get(function) or self._dispatcher(function)
                self._ready[function] = ready
        return ready

    def _dispatcher(self, function: str) -> Any:
        start = time.perf_counter()
        compiled, signature = getattr(self._module, function), self._signatures[function]
        with _wrapping_integers():
            try:
                compiled.compile(signature)
            except Exception as error:  # what is kept is damaged; or numba refuses the text, which it then does again
                _log.info("%s of %s is compiled anew: %s", function, self.name, error)
                shutil.rmtree(self._file.parent / "__pycache__", ignore_errors=True)
                compiled = numba().njit(**OPTIONS)(compiled.py_func)
                compiled.compile(signature)
        compiled.disable_compile()
        if not compiled.stats.cache_hits:
            _log.info("numba compiled %s of %s in %.2f s", function, self.name, time.perf_counter() - start)
        return compiled


@contextmanager
def _wrapping_integers() -> Iterator[None]:
    """A context in which sums and products of integers are compiled to wrap: numba takes them for less than 64 bits."""
    numbers: Any = import_module("numba.cpython.numbers")
    with import_module("numba.core.compiler_lock").global_compiler_lock:
        flags = numbers._int_arith_flags
        numbers._int_arith_flags = lambda _: []
        try:
            yield
        finally:
            numbers._int_arith_flags = flags


def _cache_file(stem: str, source: str) -> tuple[Path, bool]:
    """The file of a text in the cache, and whether it could be written; it is left alone where it is the same."""
    folder = cache.directory() / stem
    path = folder / f"{stem}.py"
    try:
        if not path.is_file() or path.read_text(encoding="utf-8") != source:
            folder.mkdir(parents=True, exist_ok=True)
            part = path.with_suffix(f".{os.getpid()}")
            part.write_text(source, encoding="utf-8")
            os.replace(part, path)
        record = folder / cache.RECORD
        if record.exists():
            with suppress(OSError):
                os.utime(record)
        else:
            record.write_text(json.dumps({"name": stem, "built": time.time()}), encoding="utf-8")
    except OSError:
        return path, False
    return path, True
