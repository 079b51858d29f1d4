"""Joints of mechanisms as shared geometry (thesis chapter 7); each name is loaded when it is first used."""

from __future__ import annotations

from importlib import import_module
from typing import Any

#: Public name -> module of this package that defines it.
_HOMES = {
    "Joint": "joints",
    "Spherical": "joints",
    "Cylindrical": "joints",
    "Planar": "joints",
    "Revolute": "joints",
    "Prismatic": "joints",
    "Universal": "joints",
    "Bilinear": "joints",
}

__all__ = sorted(_HOMES)


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f".{_HOMES[name]}", __name__), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return __all__
