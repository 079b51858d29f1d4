"""Code generation: mathematics in, source text out.

Importing this costs nothing; what a name needs is imported when the name is first used, so that users of the
compiled algebras never load SymPy or a compiler.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

_HOMES = {
    "kernel": "declare", "scalar": "declare", "numbers": "declare", "KernelFunction": "declare",
    "generate": "generator", "load_spec": "spec", "row": "trace", "named": "trace", "Kind": "kinds", "Algebra": "algebra", "Multivector": "multivector",
    "select": "multivector", "sqrt": "multivector", "reciprocal": "multivector", "absolute": "multivector",
    "sin": "multivector", "cos": "multivector", "exp": "multivector", "log": "multivector",
    "atan2": "multivector", "stumpff0": "multivector", "stumpff1": "multivector", "stumpff2": "multivector",
    "stumpff3": "multivector", "TraceError": "errors",
}  # fmt: skip
__all__ = sorted(_HOMES)


def __getattr__(name: str) -> Any:
    if name in _HOMES:
        value = getattr(import_module(f".{_HOMES[name]}", __name__), name)
        globals()[name] = value
        return value
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return __all__
