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
from .common import rich_display

_ALGEBRAS = ("cga3d", "pga3d", "cga2d", "vga2d", "vga3d", "pga2d", "sta", "qcga", "dcga")
#: Modules that examples of the docs imported, by their old names.
_OLD_MODULES = {
    f"{__name__}.{old}": f"{__name__}.{new}"
    for old, new in (
        ("codegen.formulas.blades", "codegen.formulas.objects.blades"),
        ("codegen.pairs", "codegen.execute.pairs"),
        ("kinematics.document", "kinematics.io.reader"),
        ("kinematics.pictures", "kinematics.plotting.picture"),
        ("report", "benchmarks"),
    )
}
#: What draws the small pictures that notebooks show; multivectors and curves have one in common.
_PREVIEWS = {
    "Mechanism": ("kinematics.plotting.picture", "picture"),
    "Model": ("registration.plotting.picture", "draw_model"),
    "Record": ("dynamics.plotting.scene", "picture"),
    "Trajectory": ("dynamics.plotting.scene", "picture"),
}
_find, _names = lazy_names(__name__, __file__, _ALGEBRAS)


def __getattr__(name: str) -> Any:
    if _is_algebra(name):
        value = _algebra(name)
        globals()[name] = value
        return value
    if f"{__name__}.{name}" in _OLD_MODULES:
        return import_module(f"{__name__}.{name}")
    return _find(name)


def _algebra(name: str) -> Any:
    from .core.registry import stock_algebra

    return stock_algebra(name)


def _is_algebra(name: str) -> bool:
    """Test whether this names a stock algebra, or one that was generated into the package.

    Called for every name that is not there yet, submodules included: it must import nothing to say no.
    """
    if name in _ALGEBRAS:
        return True
    if not name.isidentifier() or name.startswith("_"):
        return False
    generated = import_module(".generated", __name__)  # `from . import` would come back here
    return any(isfile(join(folder, name, "manifest.json")) for folder in generated.__path__)


class _Finder:
    """Import of algebras as modules, and of modules by old names.

    ``import bladesmith.cga3d`` gives what ``from bladesmith import cga3d`` gives.
    """

    def find_spec(self, name: str, path: Any = None, target: Any = None) -> ModuleSpec | None:
        """The import of an algebra or of an old name; None for every other module."""
        package, _, algebra = name.rpartition(".")
        is_ours = name in _OLD_MODULES or (package == __name__ and _is_algebra(algebra))
        return ModuleSpec(name, self) if is_ours else None  # type: ignore[arg-type]

    def create_module(self, spec: ModuleSpec) -> None:
        """Let the import system create a module, which the algebra or the module that was meant replaces."""

    def exec_module(self, module: ModuleType) -> None:
        """Put what was meant in the module's place."""
        name = module.__name__
        sys.modules[name] = _renamed_module(name) if name in _OLD_MODULES else _algebra(name.rpartition(".")[2])


def _renamed_module(old: str) -> Any:
    from .common.deprecation import warn_renamed

    warn_renamed(old, _OLD_MODULES[old])
    return import_module(_OLD_MODULES[old])


def _preview(thing: Any) -> Any:
    module, draw = _PREVIEWS.get(type(thing).__name__, ("plot.previews", "preview"))
    return getattr(import_module(f".{module}", __name__), draw)(thing)


rich_display.painter = _preview
sys.meta_path.append(_Finder())  # after all others: it is called for names that are no module


def __dir__() -> list[str]:
    return sorted(_names())
