"""The derivative of an algorithm, for the text of another one."""

from __future__ import annotations

import ast
from collections.abc import Sequence
from typing import Any

from ..errors import AlgorithmError
from .loops.algorithm import Algorithm
from .loops.nodes import Function
from .loops.tangent import tangent
from .loops.text import AlgorithmText
from .loops.types import Parameter


class DerivativeCall:
    """What the text of an algorithm calls: results of another one, then their tangents.

    Takes the other's parameters, then, in their order, a tangent of each that varies or is made of what varies.

    Parameters
    ----------
    algorithm : Algorithm
        Of arrays of known sizes.
    wrt : tuple of str
        Parameters that vary.
    """

    is_callable_in_algorithms = True

    def __init__(self, algorithm: Algorithm, wrt: Sequence[str]) -> None:
        self.function = tangent(algorithm.instance(), wrt).function
        self.name = self.function.name
        self.parameters: Sequence[Parameter] = self.function.parameters
        self.text = self

    def specialised(self, arguments: Sequence[Any], caller: tuple[AlgorithmText, ast.AST] | None = None) -> Function:
        """The IR."""
        return self.function

    def instance(self) -> Function:
        """The same."""
        return self.function

    def __call__(self, *arguments: Any) -> Any:
        """Refuse: it has no text.

        Raises
        ------
        AlgorithmError
        """
        raise AlgorithmError(f"{self.name} is made by the compiler and has no text to run as Python")


def derivative_of(algorithm: Algorithm, *wrt: str) -> DerivativeCall:
    """The derivative with respect to some parameters, to be called in the text of an algorithm."""
    return DerivativeCall(algorithm, wrt)
