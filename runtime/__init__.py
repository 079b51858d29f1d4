"""Geometric algebra for 3D geometry, compiled.

Importing this loads nothing but a few names: an algebra, a program or the code generator is loaded when it is
first used.
"""

from __future__ import annotations

import sys
from importlib import import_module
from importlib.machinery import ModuleSpec
from os.path import isfile, join
from types import ModuleType
from typing import Any

from .codegen.lazy_names import lazy_names
from .codegen.version import __version__ as __version__

_ALGEBRAS = ("cga3d", "pga3d", "cga2d")
_find, _names, __all__ = lazy_names(__name__, __file__)
__all__ = [*__all__, *_ALGEBRAS]


def __getattr__(name: str) -> Any:
    if _is_algebra(name):
        value = _algebra(name)
        globals()[name] = value
        return value
    return _find(name)


def _algebra(name: str) -> Any:
    from .core.registry import stock_algebra

    return stock_algebra(name)


def _is_algebra(name: str) -> bool:
    """Whether this names a stock algebra, or one that was generated into the package.

    Called for every name that is not there yet, submodules included: it must import nothing to say no.
    """
    if name in _ALGEBRAS:
        return True
    if not name.isidentifier() or name.startswith("_"):
        return False
    generated = import_module(".generated", __name__)  # `from . import` would come back here
    return any(isfile(join(folder, name, "manifest.json")) for folder in generated.__path__)


class _AlgebraFinder:
    """Import of algebras as modules: ``import bladesmith.cga3d`` gives what ``from bladesmith import cga3d`` gives."""

    def find_spec(self, name: str, path: Any = None, target: Any = None) -> ModuleSpec | None:
        """The import of an algebra; None for every other module."""
        package, _, algebra = name.rpartition(".")
        return ModuleSpec(name, self) if package == __name__ and _is_algebra(algebra) else None  # type: ignore[arg-type]

    def create_module(self, spec: ModuleSpec) -> None:
        """Let the import system create a module, which the algebra replaces."""

    def exec_module(self, module: ModuleType) -> None:
        """Put the algebra in the module's place."""
        sys.modules[module.__name__] = _algebra(module.__name__.rpartition(".")[2])


sys.meta_path.append(_AlgebraFinder())  # after all others: it is called for names that are no module


def __dir__() -> list[str]:
    return sorted(__all__)
