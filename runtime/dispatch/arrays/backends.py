"""The packages whose arrays multivectors may hold, found by the type of the values.

Neither is imported here: who has an array of a package has imported it.
"""

from __future__ import annotations

import sys
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from functools import cache
from importlib import import_module
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...common.dtypes import F32, F64


class Node(NamedTuple):
    """A class whose objects are trees of arrays: to its leaves and what else it is, and back."""

    type: type[Any]
    flatten: Callable[[Any], tuple[tuple[Any, ...], Any]]
    unflatten: Callable[[Any, Any, Any], Any]


class Backend(ABC):
    """What multivectors need of a package of arrays. Operators and indices are those of the arrays themselves."""

    #: In messages.
    name: ClassVar[str]
    #: Classes that a package with trees of arrays is told of.
    nodes: ClassVar[list[Node]] = []

    @abstractmethod
    def function(self, kernel: Any) -> Callable[..., Any]:
        """A declared kernel as a function of the package's arrays, with derivatives."""

    @abstractmethod
    def floating(self, value: Any, name: str) -> Any:
        """Anything of numbers as an array of float32 or float64 on the host."""

    @abstractmethod
    def constant(self, values: NDArray[Any], like: Any) -> Any:
        """A NumPy array as one of the package, in the type of another."""

    @abstractmethod
    def take(self, data: Any, columns: NDArray[np.int64]) -> Any:
        """Columns of the last axis; zeros for -1."""

    @abstractmethod
    def stack(self, columns: Sequence[Any]) -> Any:
        """Arrays that broadcast against each other, as columns."""

    @abstractmethod
    def norm(self, squares: Any) -> Any:
        """Square roots of absolute values."""

    @abstractmethod
    def cast(self, data: Any, dtype: np.dtype[Any]) -> Any:
        """The array in another precision."""

    @abstractmethod
    def numbers(self, data: Any) -> NDArray[Any] | None:
        """The numbers themselves; None while a function is traced, where there are none."""

    @abstractmethod
    def evaluate(self, algebra: Any, formula: str, operands: Sequence[Any]) -> Any:
        """`formulas.evaluate`, where an operand holds an array of the package."""

    @abstractmethod
    def product(self, formula: str, kind: Any, a: Any, b: Any) -> Callable[[Any, Any], Any]:
        """`plans.plan`, where an operand holds an array of the package."""

    def precision(self, data: Any) -> np.dtype[Any]:
        """float32, or float64."""
        return F32 if str(getattr(data, "dtype", "")).endswith("float32") else F64


#: Classes that no package derives its arrays from: the usual answer is given at once.
_COMMON = frozenset((float, int, list, tuple, np.ndarray))
#: By the package: the class of its arrays, and where its backend is.
_PACKAGES = {"jax": ("Array", "jax_backend", "JaxBackend"), "torch": ("Tensor", "torch_backend", "TorchBackend")}


def backend_of(value: Any) -> Backend | None:
    """The backend of an array of JAX or PyTorch; None for anything else."""
    if value.__class__ in _COMMON:
        return None
    for package, (array, _, _) in _PACKAGES.items():
        type_of_arrays = getattr(sys.modules.get(package), array, None)
        if type_of_arrays is not None and isinstance(value, type_of_arrays):
            return _backend(package)
    return None


@cache
def _backend(package: str) -> Backend:
    _, module, name = _PACKAGES[package]
    made: Backend = getattr(import_module(f".{module}", __package__), name)()
    return made
