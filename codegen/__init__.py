"""Code generation: mathematics in, source text out.

Importing this costs nothing; what a name needs is imported when the name is first used, so that users of the
compiled algebras never load SymPy or a compiler.
"""

from __future__ import annotations

import time
from importlib import import_module
from typing import Any

#: When this process began to load code: files that are younger are not what it runs.
LOADED = time.time()

#: Module -> the public names that live in it.
_NAMES = {
    "algebra": "Algebra",
    "declare": "kernel scalar numbers KernelFunction",
    "errors": "TraceError",
    "generator": "generate",
    "kinds": "Kind",
    "multivector": "Multivector select sqrt reciprocal absolute sin cos exp log atan2 "
    "stumpff0 stumpff1 stumpff2 stumpff3",
    "spec": "load_spec",
    "trace": "row named",
}
_HOMES = {name: module for module, names in _NAMES.items() for name in names.split()}
__all__ = sorted(_HOMES)


def __getattr__(name: str) -> Any:
    if name in _HOMES:
        value = getattr(import_module(f".{_HOMES[name]}", __name__), name)
        globals()[name] = value
        return value
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return __all__
