"""`@algorithm`: a loop in restricted Python becomes a function that is compiled when it is first called."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, overload

from ..errors import InputError
from ..execute.arrays import Array
from ..ir.loops import language
from ..ir.loops.algorithm import Algorithm
from ..ir.loops.nodes import Function
from .compiled import CompiledAlgorithm
from .derivatives import AlgorithmDerivative, AlgorithmPullback
from .sized import SizedAlgorithm, is_real


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


class AlgorithmFunction(SizedAlgorithm, CompiledAlgorithm):
    """A declared algorithm; see `algorithm`."""

    def __init__(self, function: Callable[..., Any], tangent: Algorithm | None = None, is_still: bool = False) -> None:
        SizedAlgorithm.__init__(self, function, tangent=tangent, is_still=is_still)
        CompiledAlgorithm.__init__(self)
        self.__module__ = function.__module__
        self._pullbacks: dict[tuple[str, ...], AlgorithmPullback] = {}

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
        if not wrt:
            raise InputError(f"{self.name}: a derivative needs a parameter, such as derivative('x').")
        return AlgorithmDerivative(self, self._varying(wrt))

    def pullback(self, *wrt: str) -> AlgorithmPullback:
        """Reverse derivative: from cotangents of the results to those of some parameters; branches are as taken.

        Parameters
        ----------
        *wrt : str
            Parameters of real numbers that the algorithm reads; default: all.

        Returns
        -------
        AlgorithmPullback
            Takes the arguments of the algorithm, then a cotangent ``<name>_bar`` of each array of real numbers that it
            changes or writes and ``result_bar`` of each real number that it returns; gives the cotangents of each item:
            arrays, then numbers. It is made for the number of rows of each array.

        Raises
        ------
        InputError
            If there is no such parameter.
        AlgorithmError
            When it is called or printed, if the memory that it needs is not bounded: with the loop's file and line.
        """
        varying = self._varying(wrt or [p.name for p in self.inputs() if is_real(p)])
        if not varying:
            raise InputError(f"{self.name} has no parameter of real numbers.")
        return self._pullbacks.setdefault(varying, AlgorithmPullback(self, varying))

    def vjp(self, *arguments: Any, wrt: str | Sequence[str] = ()) -> Callable[..., tuple[Array, ...]]:
        """Reverse derivative at some arguments.

        Parameters
        ----------
        *arguments
            As for a call.
        wrt : str or sequence of str
            Parameters of real numbers; default: all.

        Returns
        -------
        callable
            Takes a cotangent of each real result, of its shape or one that broadcasts to it, arrays that are `Out` or
            `InOut` before numbers that are returned. Gives a tuple with one of each parameter, of its shape: what was
            broadcast has the sum over the items that share it. Arguments are read when it is called.

        Raises
        ------
        InputError
            If there is no such parameter, or an argument too many or too few.

        Examples
        --------
        >>> from bladesmith.codegen import algorithm
        >>> from bladesmith.codegen.language import Real, Vector
        >>> @algorithm
        ... def square(x: Vector[3]) -> Real:
        ...     total = 0.0
        ...     for i in range(3):
        ...         total += x[i] * x[i]
        ...     return total
        >>> square.vjp([1.0, 2.0, 3.0])(1.0)[0].tolist()
        [2.0, 4.0, 6.0]
        """
        self.check_count(arguments)
        pullback = self.pullback(*((wrt,) if isinstance(wrt, str) else wrt))
        return lambda *cotangents: pullback.summed(arguments, cotangents)

    def _varying(self, wrt: Sequence[str]) -> tuple[str, ...]:
        """Parameters that may vary, each once.

        Raises
        ------
        InputError
        """
        reals = [p.name for p in self.inputs() if is_real(p)]
        for name in wrt:
            if name not in reals:
                known = ", ".join(reals) or "none"
                raise InputError(f"{self.name} has no parameter of real numbers {name!r}; there are: {known}.")
        return tuple(dict.fromkeys(wrt))

    def prepare(self, arguments: Sequence[Any]) -> tuple[Function, list[Any]]:
        return self.function_for(arguments), self.items(arguments)
