"""Geometric algebra for 3D geometry, compiled.

Importing this loads nothing but a few names: an algebra, a program or the code generator is loaded when it is
first used.
"""

from __future__ import annotations

from importlib import import_module
from os.path import isfile, join
from typing import TYPE_CHECKING, Any

from .codegen.version import __version__

if TYPE_CHECKING:
    from . import codegen, errors
    from .algebras import Algebra
    from .conformal import ConformalAlgebra, ConformalPlane
    from .interchange.clifford import from_clifford
    from .loading import algebra, load_algebra
    from .multivector import Multivector
    from .parallel import set_threads
    from .projective import ProjectiveAlgebra
    from .status import Status
    from .storage import load, save

    cga3d: ConformalAlgebra
    cga2d: ConformalPlane
    pga3d: ProjectiveAlgebra

_HOMES = {
    "Algebra": "algebras", "algebra": "loading", "load_algebra": "loading", "Multivector": "multivector",
    "Status": "status", "save": "storage", "load": "storage", "from_clifford": "interchange.clifford",
    "set_threads": "parallel",
}  # fmt: skip
_ROOMS = (
    "codegen", "curves", "dynamics", "errors", "interchange", "kinematics", "objects", "plot", "reform", "report",
    "tracer",
)  # fmt: skip
_ALGEBRAS = ("cga3d", "pga3d", "cga2d")

__all__ = [
    "Algebra",
    "Multivector",
    "Status",
    "__version__",
    "algebra",
    "cga2d",
    "cga3d",
    "codegen",
    "errors",
    "from_clifford",
    "load",
    "load_algebra",
    "pga3d",
    "save",
    "set_threads",
]


def __getattr__(name: str) -> Any:
    if name in _HOMES:
        value = getattr(import_module(f".{_HOMES[name]}", __name__), name)
    elif name in _ALGEBRAS:
        value = import_module(".loading", __name__).stock_algebra(name)
    elif name in _ROOMS:
        try:
            value = import_module(f".{name}", __name__)
        except ModuleNotFoundError as error:
            if error.name != f"{__name__}.{name}":
                raise
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}") from None
    else:
        value = _generated(name)
    globals()[name] = value
    return value


def _generated(name: str) -> Any:
    """An algebra that was generated into the package beside the stock ones.

    Asked for every name that is not there yet, submodules included: it must import nothing to say no.
    """
    homes = import_module(".generated", __name__).__path__ if name.isidentifier() and name[0] != "_" else ()
    if any(isfile(join(home, name, "manifest.json")) for home in homes):
        return import_module(".loading", __name__).stock_algebra(name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*__all__, *_ROOMS})
