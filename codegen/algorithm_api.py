"""`@algorithm`: a loop in restricted Python becomes a function that is compiled when it is first called."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, overload

import numpy as np

from .errors import CompilerMissingError, InputError
from .execute.items import CLoop, ItemFunction, Loop, NumbaLoop
from .export.options import ExportOptions, describes_options
from .ir.loops import language
from .ir.loops.algorithm import Algorithm
from .ir.loops.nodes import Function
from .ir.loops.scope import Static
from .ir.loops.tangent import tangent as tangent_of
from .ir.loops.text import is_static
from .ir.loops.types import REAL, ArrayType, Parameter, Scalar, StaticType

#: Where an algorithm can run.
TARGETS = ("c", "numba", "cuda")


@overload
def algorithm(function: Callable[..., Any]) -> AlgorithmFunction: ...


@overload
def algorithm(
    *, tangent: Algorithm | None = None, still: bool = False
) -> Callable[[Callable[..., Any]], AlgorithmFunction]: ...


def algorithm(
    function: Callable[..., Any] | None = None, *, tangent: Algorithm | None = None, still: bool = False
) -> AlgorithmFunction | Callable[[Callable[..., Any]], AlgorithmFunction]:
    """Declare an algorithm: a decorator for a function in the language of :doc:`/algebra/algorithms`.

    The function's text is parsed, not run: loops, branches and calls of kernels and of other algorithms become C or
    numba. Called with arrays it runs compiled, item by item over leading axes that broadcast; inside another
    algorithm it is a call there.

    Parameters
    ----------
    function : callable
        With an annotation for each parameter: `Real`, `Int`, `Bool`, `Vector[n]`, `Matrix[m, n]`, `Rows[n]`,
        `IntVector[n]`, `IntRows[n]`, `Reals`, `Ints`, `Out[...]`, `InOut[...]`, `Static`.
    tangent : algorithm, optional
        Its derivative, where that is not the text's: it takes the same parameters, then a tangent ``d_x`` of each
        parameter x that matters, and returns the same, then tangents of the real numbers among it.
    still : bool
        Derivatives take what it gives for constant.

    Raises
    ------
    AlgorithmError
        If the text has something that the language has not: with file, line and what to write instead.

    Examples
    --------
    >>> from bladesmith.codegen import algorithm
    >>> from bladesmith.codegen.language import Real, Vector
    >>> @algorithm
    ... def largest(x: Vector) -> Real:
    ...     best = x[0]
    ...     for i in range(1, len(x)):
    ...         best = max(best, x[i])
    ...     return best
    """
    if function is None:
        return lambda given: AlgorithmFunction(_checked(given), tangent, still)
    return AlgorithmFunction(_checked(function))


def _checked(function: Any) -> Callable[..., Any]:
    if not callable(function) or not hasattr(function, "__code__"):
        raise InputError(f"@algorithm declares a Python function, not {function!r}.")
    declared: Callable[..., Any] = function
    return declared


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
        from .programs.algorithms import algorithm_cuda, algorithm_numba, algorithm_text
        from .targets.cuda.printer import self_contained

        if target not in TARGETS:
            raise InputError(f"there is no target {target!r}; choose one of {', '.join(TARGETS)}.")
        function = self.function_for(arguments or self.declared_arguments())
        if target == "cuda":
            return self_contained(algorithm_cuda(function))
        return algorithm_text(function) if target == "c" else algorithm_numba(function)

    @describes_options
    def export(
        self, language: str, folder: str | Path, *arguments: Any, name: str = "", dtype: str = "", split: bool = False
    ) -> list[Path]:
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

        {files}

        Raises
        ------
        InputError
            If sizes are missing.
            {refusals}
        """
        from .export.bound import ExportedAlgorithm
        from .export.export import export

        options = ExportOptions(language, name or self.__name__, dtype, split)
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


class AlgorithmFunction(Algorithm, CompiledAlgorithm):
    """A declared algorithm; see `algorithm`."""

    def __init__(self, function: Callable[..., Any], tangent: Algorithm | None = None, is_still: bool = False) -> None:
        Algorithm.__init__(self, function, tangent=tangent, is_still=is_still)
        CompiledAlgorithm.__init__(self)

    def __call__(self, *arguments: Any) -> Any:
        """Run compiled on arrays; leading axes are items.

        Parameters
        ----------
        *arguments
            As declared, those that are `Out` left out.

        Returns
        -------
        ndarray or tuple of ndarrays
            What is `Out` or `InOut`, then what is returned.

        Raises
        ------
        InputError, ShapeError
            If an argument has another shape or type.
        """
        if language.runs_as_python():
            return self.in_python(arguments)
        return self.call("c", arguments)

    def derivative(self, *wrt: str) -> AlgorithmDerivative:
        """Forward derivative along directions of some parameters: branches are as taken.

        Parameters
        ----------
        *wrt : str
            Parameters of real numbers that the algorithm reads.

        Returns
        -------
        AlgorithmDerivative
            Takes the arguments of the algorithm, then a direction for each of ``wrt``, of the same shape; gives its
            results, the tangents of arrays behind the arrays and those of numbers behind the numbers.

        Raises
        ------
        InputError
            If there is no such parameter.

        Examples
        --------
        >>> from bladesmith.codegen import algorithm
        >>> from bladesmith.codegen.language import Real
        >>> @algorithm
        ... def cube(x: Real) -> Real:
        ...     return x * x * x
        >>> [float(v) for v in cube.derivative("x")(2.0, 1.0)]
        [8.0, 12.0]
        """
        reals = [p.name for p in self.inputs() if _is_real(p)]
        for name in wrt:
            if name not in reals:
                known = ", ".join(reals) or "none"
                raise InputError(f"{self.name} has no parameter of real numbers {name!r}; there are: {known}.")
        if not wrt:
            raise InputError(f"{self.name}: a derivative needs a parameter, such as derivative('x').")
        return AlgorithmDerivative(self, tuple(dict.fromkeys(wrt)))

    def declared_arguments(self) -> Sequence[Any]:
        found: list[Any] = []
        for p in self.inputs():
            if isinstance(p.type, StaticType) or (isinstance(p.type, ArrayType) and p.type.is_generic):
                raise InputError(f"{self.name}: the text depends on {p.name}; give the arguments of a call.")
            shape = [n or 1 for n in p.type.sizes] if isinstance(p.type, ArrayType) else []
            found.append(np.zeros(shape, np.float64 if _is_real(p) else np.int64))
        return found

    def prepare(self, arguments: Sequence[Any]) -> tuple[Function, list[Any]]:
        return self.function_for(arguments), self.items(arguments)

    def items(self, arguments: Sequence[Any]) -> list[Any]:
        """The arguments that are not static."""
        return [a for a, p in zip(arguments, self.inputs(), strict=True) if not isinstance(p.type, StaticType)]

    def function_for(self, arguments: Sequence[Any]) -> Function:
        inputs = self.inputs()
        self.check_count(arguments)
        by_name = {p.name: a for p, a in zip(inputs, arguments, strict=True)}
        types: list[ArrayType | Scalar | Static] = []
        for p in self.text.parameters:
            if isinstance(p.type, StaticType):
                value = by_name[p.name]
                if not is_static(value):
                    raise InputError(f"{self.name}: {p.name} is static: a number, a string or a tuple of such.")
                types.append(Static(value))
            elif isinstance(p.type, ArrayType) and (p.type.is_generic or (p.type.is_open and p.access == "out")):
                types.append(self._type_of_size(p, p.type, by_name.get(p.name)))
            else:
                types.append(p.type)
        return self.specialised(types)

    def _type_of_size(self, parameter: Parameter, type: ArrayType, value: Any) -> ArrayType:
        """The type of an array of any size, from the array that was given."""
        if parameter.access == "out":
            raise InputError(
                f"{self.name}: {parameter.name} is a result without a size.",
                remedy="Declare it, such as Out[Vector[3]], take it as InOut[...], or call it from an algorithm.",
            )
        try:
            axes, shape = type.axes, np.shape(value)
        except ValueError:
            raise InputError(f"{self.name}: {parameter.name} has rows of several lengths.") from None
        if len(shape) < axes or 0 in shape[len(shape) - axes :]:
            raise InputError(f"{self.name}: {parameter.name} has shape {shape}; it needs {axes} axes, not empty.")
        return ArrayType(type.scalar, shape[len(shape) - axes :])


class AlgorithmDerivative(CompiledAlgorithm):
    """The derivative of an algorithm along directions of some of its parameters; see `AlgorithmFunction.derivative`.

    Parameters
    ----------
    algorithm : AlgorithmFunction
    wrt : tuple of str
    """

    def __init__(self, algorithm: AlgorithmFunction, wrt: tuple[str, ...]) -> None:
        super().__init__()
        self.algorithm = algorithm
        self.wrt = wrt
        self.__name__ = f"{algorithm.name}_d_{'_'.join(wrt)}"

    def __call__(self, *arguments: Any) -> Any:
        """Results and their tangents.

        Parameters
        ----------
        *arguments
            Those of the algorithm, then directions.
        """
        return self.call("c", arguments)

    def declared_arguments(self) -> Sequence[Any]:
        return self.algorithm.declared_arguments()

    def function_for(self, arguments: Sequence[Any]) -> Function:
        return tangent_of(self.algorithm.function_for(arguments), self.wrt).function

    def prepare(self, arguments: Sequence[Any]) -> tuple[Function, list[Any]]:
        """Arguments, directions, and zeros for the tangents of arrays that it changes along no direction."""
        algorithm, count = self.algorithm, len(self.algorithm.inputs())
        if len(arguments) != count + len(self.wrt):
            raise InputError(
                f"{self.__name__} takes {count} arguments of {algorithm.name} and {len(self.wrt)} directions, "
                f"not {len(arguments)} in all."
            )
        own = arguments[:count]
        directions = dict(zip(self.wrt, arguments[count:], strict=True))
        by_name = {p.name: a for p, a in zip(algorithm.inputs(), own, strict=True)}
        base = algorithm.function_for(own)
        derived = tangent_of(base, self.wrt)
        tangents = [
            directions[p.name] if p.name in directions else _zeros_like(by_name[p.name])
            for p in base.parameters if p.name in derived.varies and p.access != "out"
        ]  # fmt: skip
        return derived.function, [*algorithm.items(own), *tangents]


def _is_real(parameter: Parameter) -> bool:
    return (parameter.type.scalar if isinstance(parameter.type, ArrayType) else parameter.type) == REAL


def _zeros_like(value: Any) -> Any:
    """Zeros of the same shape and precision."""
    single = getattr(value, "dtype", None) == np.float32
    return np.zeros(np.shape(value), np.float32 if single else np.float64)


def _is_single(function: Function, items: Sequence[Any]) -> bool:
    """Whether all arrays of real numbers are of single precision."""
    declared = [p for p in function.parameters if p.access != "out"]
    reals = [
        getattr(a, "dtype", None) for a, p in zip(items, declared, strict=True)
        if isinstance(p.type, ArrayType) and p.type.scalar == REAL
    ]  # fmt: skip
    return bool(reals) and all(r == np.float32 for r in reals)


def _loop(function: Function, target: str, precision: str) -> Loop:
    from .programs.algorithms import algorithm_cuda, algorithm_extension, algorithm_numba

    if target == "cuda":
        from .execute.cuda_driver import first_gpu
        from .execute.cuda_items import algorithm_loop

        return algorithm_loop(first_gpu(), algorithm_cuda(function), function, precision)
    if target == "c":
        from .build.extension import load

        try:
            return CLoop(load(algorithm_extension(function)), precision)
        except CompilerMissingError:
            if precision == "f32":
                raise
    return NumbaLoop(function.name, algorithm_numba(function), function)
