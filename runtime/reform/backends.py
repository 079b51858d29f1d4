"""What computes a registration: compiled C, numba, or CUDA; all have the same stages."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from ..codegen.errors import InputError
from .engine import Driver, Scene


@dataclass(frozen=True)
class Backend:
    """Makers of what `engine.Driver` and `engine.Scene` are for C."""

    driver: Callable[..., Any]
    scene: Callable[..., Any]


BACKENDS = {"c": Backend(Driver, Scene)}


def backend_of(name: str) -> Backend:
    """The backend of this name.

    Raises
    ------
    InputError
        If there is none.
    """
    if name not in BACKENDS:
        raise InputError(f"backend is {name!r}; there are: {', '.join(BACKENDS)}.")
    return BACKENDS[name]
