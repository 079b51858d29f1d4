"""What computes a registration: compiled C, numba, or CUDA; all have the same stages, and give the same bits."""

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


def _c() -> Backend:
    return Backend(Driver, Scene)


def _numba() -> Backend:
    from .backend_numba import NumbaDriver, NumbaScene

    return Backend(NumbaDriver, NumbaScene)


def _cuda() -> Backend:
    from .backend_cuda import CudaDriver, CudaScene

    return Backend(CudaDriver, CudaScene)


#: By name; what only one of them needs is loaded when that one is asked for.
BACKENDS: dict[str, Callable[[], Backend]] = {"c": _c, "numba": _numba, "cuda": _cuda}


def backend_of(name: str) -> Backend:
    """The backend of this name.

    Raises
    ------
    InputError
        If there is none.
    """
    if not isinstance(name, str) or name not in BACKENDS:
        raise InputError(f"backend is {name!r}; there are: {', '.join(BACKENDS)}.")
    return BACKENDS[name]()
