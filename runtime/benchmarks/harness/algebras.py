"""The algebra of the studies, loaded when it is first used."""

from __future__ import annotations

from ...core.geometry.conformal import ConformalAlgebra
from ...core.registry import stock_algebra

cga3d: ConformalAlgebra


def __getattr__(name: str) -> object:
    if name == "cga3d":
        return stock_algebra(name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
