"""Backends of a registration: compiled C, numba, or CUDA, with the same stages and bit for bit the same results."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from ...codegen.errors import InputError
from ...common.validation import short_repr
from .c import Driver, Scene


@dataclass(frozen=True)
class Backend:
    """Constructors with the interfaces of `c.Driver` and `c.Scene`."""

    driver: Callable[..., Any]
    scene: Callable[..., Any]


def _c() -> Backend:
    return Backend(Driver, Scene)


def _numba() -> Backend:
    from .numba import NumbaDriver, NumbaScene

    return Backend(NumbaDriver, NumbaScene)


def _cuda() -> Backend:
    from .cuda import CudaDriver, CudaScene

    return Backend(CudaDriver, CudaScene)


#: Backends by name; their modules are imported at first use.
BACKENDS: dict[str, Callable[[], Backend]] = {"c": _c, "numba": _numba, "cuda": _cuda}


def backend_of(name: str) -> Backend:
    """The backend of this name.

    Raises
    ------
    InputError
        If there is no such backend.
    """
    if not isinstance(name, str) or name not in BACKENDS:
        raise InputError(f"backend is {short_repr(name)}; there are: {', '.join(BACKENDS)}.")
    return BACKENDS[name]()
