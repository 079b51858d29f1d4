"""Backends of a registration: compiled C, numba, or CUDA, with the same algorithms and bit for bit the same results."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ...codegen.errors import InputError
from ...common.validation import short_repr
from .algorithms import c_algorithms, numba_algorithms


def _cuda(kinds: tuple[str, ...]) -> Any:
    from .cuda import CudaAlgorithms

    return CudaAlgorithms(kinds)


#: Algorithms of some kinds, in order, by the backend's name; see `algorithms.Algorithms`.
BACKENDS: dict[str, Callable[[tuple[str, ...]], Any]] = {
    "c": lambda kinds: c_algorithms(kinds),
    "numba": lambda kinds: numba_algorithms(kinds),
    "cuda": _cuda,
}


def check_backend(name: str) -> str:
    """The name of a backend.

    Raises
    ------
    InputError
        If there is no such backend.
    """
    if not isinstance(name, str) or name not in BACKENDS:
        raise InputError(f"backend is {short_repr(name)}; there are: {', '.join(BACKENDS)}.")
    return name


def algorithms_of(backend: str, kinds: tuple[str, ...]) -> Any:
    """The algorithms of these kinds, in order, on a backend.

    Raises
    ------
    InputError
        If there is no such backend.
    """
    return BACKENDS[check_backend(backend)](kinds)
