"""What runs compiled: algorithms and their derivatives, on arrays whose leading axes are items."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import CompilerMissingError, InputError
from ..execute.items import CLoop, ItemFunction, Loop, NumbaLoop
from ..export.options import ExportOptions, describes_options, source_of
from ..ir.loops.nodes import Function
from ..ir.loops.types import REAL, ArrayType

#: Where an algorithm can run.
TARGETS = ("c", "numba", "cuda")


class CompiledAlgorithm(ABC):
    """What runs compiled: an algorithm, or its derivative."""

    __name__: str

    def __init__(self) -> None:
        self._compiled: dict[tuple[Function, str, str], ItemFunction] = {}

    @abstractmethod
    def function_for(self, arguments: Sequence[Any]) -> Function:
        """What runs, for the sizes and static values of the algorithm's arguments."""

    @abstractmethod
    def prepare(self, arguments: Sequence[Any]) -> tuple[Function, list[Any]]:
        """What runs for the arguments of a call, and what it takes of them."""

    @abstractmethod
    def declared_arguments(self) -> Sequence[Any]:
        """Zeros in place of arguments, where the sizes are declared."""

    def on(self, target: str) -> Callable[..., Any]:
        """The function on one target: "c", "numba" or "cuda", which needs a GPU."""
        if target not in TARGETS:
            raise InputError(f"there is no target {target!r}; choose one of {', '.join(TARGETS)}.")
        return lambda *arguments: self.call(target, arguments)

    def source(self, target: str = "c", *arguments: Any) -> str:
        """Source text for "c", "numba" or "cuda".

        Parameters
        ----------
        target : str
        *arguments
            Those of the algorithm, where sizes or static values are not declared.

        Raises
        ------
        InputError
            If there is no such target, or sizes are missing.
        """
        from ..programs.algorithms import algorithm_cuda, algorithm_numba, algorithm_text
        from ..targets.cuda.printer import self_contained

        if target not in TARGETS:
            raise InputError(f"there is no target {target!r}; choose one of {', '.join(TARGETS)}.")
        function = self.function_for(arguments or self.declared_arguments())
        if target == "cuda":
            return self_contained(algorithm_cuda(function))
        return algorithm_text(function) if target == "c" else algorithm_numba(function)

    @describes_options
    def export(
        self, language: str, folder: str | Path, *arguments: Any, name: str = "", dtype: str = "", split: bool = False,
        overwrite: bool = False,
    ) -> list[Path]:  # fmt: skip
        """Write the function as a source file that needs nothing of this package; see :doc:`/algebra/export`.

        Parameters
        ----------
        {language}
        {folder}
        *arguments
            Those of the algorithm, where sizes or static values are not declared.
        {name}
            Default: the algorithm's.
        {dtype}
        {split}
        {overwrite}

        {files}

        Raises
        ------
        InputError
            If sizes are missing.
            {refusals}
        """
        from ..export.bound import ExportedAlgorithm
        from ..export.export import export

        options = ExportOptions(
            language, name or self.__name__, dtype, split, overwrite, source_of(self, self.__name__)
        )
        function = self.function_for(arguments or self.declared_arguments())
        return export([ExportedAlgorithm(self.__name__, function)], folder, options)

    def call(self, target: str, arguments: Sequence[Any]) -> Any:
        """Run compiled on arrays."""
        function, items = self.prepare(arguments)
        is_single = target != "numba" and _is_single(function, items)
        return self._item_function(function, target, "f32" if is_single else "f64")(*items)

    def _item_function(self, function: Function, target: str, precision: str) -> ItemFunction:
        key = (function, target, precision)
        found = self._compiled.get(key)
        if found is None:
            dtype = np.float32 if precision == "f32" else np.float64
            found = self._compiled[key] = ItemFunction(function, _loop(function, target, precision), dtype)
        return found


def _is_single(function: Function, items: Sequence[Any]) -> bool:
    """Whether all arrays of real numbers are of single precision."""
    declared = [p for p in function.parameters if p.access != "out"]
    reals = [
        getattr(a, "dtype", None) for a, p in zip(items, declared, strict=True)
        if isinstance(p.type, ArrayType) and p.type.scalar == REAL
    ]  # fmt: skip
    return bool(reals) and all(r == np.float32 for r in reals)


def _loop(function: Function, target: str, precision: str) -> Loop:
    from ..programs.algorithms import algorithm_cuda, algorithm_extension, algorithm_numba

    if target == "cuda":
        from ..execute.cuda_driver import first_gpu
        from ..execute.cuda_items import algorithm_loop

        return algorithm_loop(first_gpu(), algorithm_cuda(function), function, precision)
    if target == "c":
        from ..build.extension import load

        try:
            return CLoop(load(algorithm_extension(function)), precision)
        except CompilerMissingError:
            if precision == "f32":
                raise
    return NumbaLoop(function.name, algorithm_numba(function), function)
