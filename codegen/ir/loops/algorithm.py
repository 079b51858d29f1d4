"""An algorithm: a Python function in the language, and what it is for each choice of sizes and static values."""

from __future__ import annotations

import ast
import hashlib
import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from threading import RLock
from typing import Any

import numpy as np

from ...errors import AlgorithmError, InputError
from . import language
from .nodes import Function
from .scope import Static
from .statements import StatementReader
from .text import AlgorithmText
from .types import REAL, ArrayType, Parameter, Scalar, StaticType

#: Calls inside calls, and instances of one algorithm: more than this is a recursion or a mistake.
_DEEPEST, _MOST_INSTANCES = 64, 4096
_DIGITS = 8
#: Letters of a static value in a name, and of a name.
_LONGEST, _LONGEST_NAME = 24, 96
#: Numbers in the local arrays of an algorithm and of those that it calls: C has them on the stack.
MOST_LOCAL = 1 << 17


class Algorithm:
    """A function in the language of algorithms; see docs/algebra/algorithms.md.

    Called inside another algorithm's text it is a call there. `reference` runs it as Python.

    Parameters
    ----------
    function : callable
        With annotated parameters.
    is_inline : bool
        C puts it where it is called: for what is called in the innermost loops.
    is_library : bool
        C has a function of this name in templates/c, with the same parameters: for what is about the machine.
    tangent : Algorithm, optional
        Its derivative, where that is not the text's: takes its parameters, then a tangent ``d_x`` of each parameter x
        on which it depends, and returns what it returns, then the tangents of that.
    is_still : bool
        Derivatives take what it gives for constant: estimates of rounding, and what only decides.

    Raises
    ------
    AlgorithmError
        If its text is not in the language: with file, line and what to write instead. Parameters that take any size are
        looked at when a call gives them one.
    """

    is_callable_in_algorithms = True

    def __init__(
        self, function: Callable[..., Any], is_inline: bool = False, is_library: bool = False,
        tangent: Algorithm | None = None, is_still: bool = False,
    ) -> None:  # fmt: skip
        self.function, self.is_inline, self.is_library = function, is_inline, is_library
        self.tangent, self.is_still = tangent, is_still
        self.text = AlgorithmText(function)
        self.name = self.text.name
        self.__name__ = self.name
        self.__doc__ = function.__doc__
        self._instances: dict[tuple[Any, ...], Function] = {}
        if all(_is_concrete(p) for p in self.text.parameters):
            self.instance()

    def __repr__(self) -> str:
        return f"<algorithm {self.name}>"

    def specialised(
        self, arguments: Sequence[ArrayType | Scalar | Static | StaticType],
        caller: tuple[AlgorithmText, ast.AST] | None = None,
    ) -> Function:  # fmt: skip
        """The IR for these types and static values, one for each parameter."""
        settled = [_settle_type(p, a) for p, a in zip(self.text.parameters, arguments, strict=True)]
        key = tuple((repr(a.value), a.value) if isinstance(a, Static) else a for a in settled)  # 1, 1.0, True differ
        with _lock:
            found = self._instances.get(key)
            if found is None:
                if any(a is self for a in _reading) or len(_reading) > _DEEPEST:
                    self._refuse_recursion(caller)
                if len(self._instances) >= _MOST_INSTANCES:
                    self.text.refuse(self.text.tree, "it is needed in too many sizes", "Give fewer static values.")
                _reading.append(self)
                try:
                    found = self._read(settled)
                finally:
                    _reading.pop()
                self._instances[key] = found
        return found

    def instance(self) -> Function:
        """The IR of an algorithm without static parameters and arrays of any size."""
        return self.specialised([p.type for p in self.text.parameters])

    def _refuse_recursion(self, caller: tuple[AlgorithmText, ast.AST] | None) -> None:
        text, node = caller or (self.text, self.text.tree)
        text.refuse(node, f"{self.name} calls itself", "Write a loop with a stack of its own.")

    def _read(self, arguments: Sequence[ArrayType | Scalar | Static | StaticType]) -> Function:
        parameters: list[Parameter] = []
        statics: dict[str, Any] = {}
        suffix: list[str] = []
        for declared, given in zip(self.text.parameters, arguments, strict=True):
            if isinstance(given, Static):
                statics[declared.name] = given.value
                suffix.append(_suffix(given.value))
            elif isinstance(given, (ArrayType, Scalar)):
                parameters.append(replace(declared, type=given))
                if isinstance(declared.type, ArrayType) and declared.type.is_generic and isinstance(given, ArrayType):
                    suffix.append("x".join("n" if n is None else str(n) for n in given.sizes))
        reader = StatementReader(self.text, parameters, statics)
        body = reader.read()
        name = "_".join([self.name, *filter(None, suffix)])
        if len(name) > _LONGEST_NAME:
            name = f"{name[:_LONGEST_NAME]}_{_digest(name)}"
        results = reader.results or ()
        function = Function(
            name, self.text.note, tuple(parameters), results, body, self.is_inline, self.is_library,
            self._rule(arguments), self.is_still, where=self.text.place(self.text.tree),
        )  # fmt: skip
        if function.local_size > MOST_LOCAL:
            self.text.refuse(
                self.text.tree,
                f"local arrays have {function.local_size} numbers, with those of its callees; {MOST_LOCAL} fit",
                "Take a large array as a parameter: InOut[...].",
            )
        return function

    def _rule(self, arguments: Sequence[ArrayType | Scalar | Static | StaticType]) -> Callable[[], Function] | None:
        """What gives the declared derivative for these types."""
        rule = self.tangent
        if rule is None:
            return None
        own = [p.name for p in self.text.parameters]
        declared = [p.name for p in rule.text.parameters]
        by_name = dict(zip(own, arguments, strict=True))
        if declared[: len(own)] != own or any(n.removeprefix("d_") not in by_name for n in declared[len(own) :]):
            raise AlgorithmError(
                f"{rule.name} is no derivative of {self.name}", where=", ".join(declared),
                remedy=f"It takes {', '.join(own)}, then tangents of some of them, such as d_{own[0]}.",
            )  # fmt: skip
        types = [*arguments, *(by_name[n.removeprefix("d_")] for n in declared[len(own) :])]
        return lambda: rule.specialised(types)

    def inputs(self) -> list[Parameter]:
        """Parameters that a call gives."""
        return [p for p in self.text.parameters if p.access != "out"]

    def check_count(self, arguments: Sequence[Any]) -> None:
        """Refuse a call with more or fewer arguments.

        Raises
        ------
        InputError
        """
        inputs = self.inputs()
        if len(arguments) != len(inputs):
            names = ", ".join(p.name for p in inputs) or "none"
            raise InputError(f"{self.name} takes {len(inputs)} arguments ({names}), not {len(arguments)}.")

    def reference(self, *arguments: Any, numbers: Any = None) -> Any:
        """Run the text as Python on one item.

        Parameters
        ----------
        *arguments
            As declared, those that are `Out` left out.
        numbers : NumPy type or context of mpmath, optional
            What real numbers are. Default: float64.

        Returns
        -------
        object or tuple
            What is `Out` or `InOut`, then what is returned.
        """
        self.check_count(arguments)
        with language.number_type(numbers or np.float64):
            given = iter(arguments)
            taken = [self._item(p, None if p.access == "out" else next(given)) for p in self.text.parameters]
            returned = self.function(*taken)
        changed = [a for a, p in zip(taken, self.text.parameters, strict=True) if p.access != "in"]
        results = [*changed, *(() if returned is None else returned if isinstance(returned, tuple) else (returned,))]
        return results[0] if len(results) == 1 else tuple(results)

    def _item(self, parameter: Parameter, value: Any) -> Any:
        """An argument in the numbers that are in use: arrays are copies."""
        if parameter.type == REAL:
            return language.number(value)
        if not isinstance(parameter.type, ArrayType):
            return value
        if parameter.access == "out":
            if parameter.type.is_generic or parameter.type.is_open:
                raise InputError(f"{self.name}: {parameter.name} is a result without a size.", remedy="Declare it.")
            return _with_fields(parameter.type, make_array(parameter.type))
        if parameter.type.scalar != REAL:
            return _with_fields(parameter.type, np.array(value, np.int64))
        array = language.zeros(*np.shape(value))
        array[...] = np.vectorize(language.number, otypes=[array.dtype])(np.asarray(value)) if array.size else 0
        return _with_fields(parameter.type, array)

    def __call__(self, *arguments: Any) -> Any:
        """Run the text as Python: what one algorithm does with another, run as Python."""
        return self.in_python(arguments)

    def in_python(self, arguments: Sequence[Any]) -> Any:
        """The text as Python on arrays that it may change; rows have the fields that the parameters declare."""
        return self.function(*(_with_fields(p.type, a) for p, a in zip(self.text.parameters, arguments, strict=True)))


def inlined(function: Callable[..., Any]) -> Algorithm:
    """An algorithm that C puts where it is called."""
    return Algorithm(function, is_inline=True)


def in_library(function: Callable[..., Any]) -> Algorithm:
    """An algorithm for which C has a text of its own; tests hold both together."""
    return Algorithm(function, is_library=True)


def still(function: Callable[..., Any]) -> Algorithm:
    """An algorithm whose results derivatives take for constant."""
    return Algorithm(function, is_still=True)


def still_inlined(function: Callable[..., Any]) -> Algorithm:
    """The same, that C puts where it is called."""
    return Algorithm(function, is_inline=True, is_still=True)


def with_tangent(tangent: Algorithm | None) -> Callable[[Callable[..., Any]], Algorithm]:
    """A decorator: an algorithm with the one that is its derivative; see `Algorithm`."""
    return lambda function: Algorithm(function, tangent=tangent)


class Bound:
    """An algorithm whose first parameters, which are static, have values: algorithms call it with the others.

    Parameters
    ----------
    algorithm : Algorithm
    *values : object
    """

    is_callable_in_algorithms = True

    def __init__(self, algorithm: Algorithm, *values: Any) -> None:
        self.algorithm, self.values, self.name = algorithm, values, algorithm.name
        self.text, self.parameters = self, tuple(algorithm.text.parameters[len(values) :])

    def specialised(self, arguments: Sequence[Any], caller: Any = None) -> Function:
        """The IR for these types of the other parameters."""
        return self.algorithm.specialised([*map(Static, self.values), *arguments], caller)

    def instance(self) -> Function:
        """The IR where the others have types of their own."""
        return self.specialised([p.type for p in self.parameters])

    def __call__(self, *arguments: Any) -> Any:
        """Run the text as Python."""
        return self.algorithm(*self.values, *arguments)


class CFunction:
    """A function that C has, and no other target but those that are named, as algorithms call it.

    Parameters
    ----------
    name : str
        In C, without the tag of the instance.
    parameters : sequence of Parameter
    results : sequence of Scalar
        Types of the numbers that it returns.
    home : str
        The module that has it for numba, with ``compiled`` as modules that printed texts import have it; arrays are
        passed with the index where they begin.
    is_still : bool
        Derivatives take what it gives for constant; else it has none.
    """

    is_callable_in_algorithms = True

    def __init__(
        self, name: str, parameters: Sequence[Parameter], results: Sequence[Scalar] = (), home: str = "",
        is_still: bool = False,
    ) -> None:  # fmt: skip
        self.name, self.parameters = name, tuple(parameters)
        self.text = self
        self._function = Function(
            name, name, self.parameters, tuple(results), (), is_library=True, is_still=is_still, home=home
        )

    def specialised(self, arguments: Sequence[Any], caller: Any = None) -> Function:
        """The IR: a function without a text."""
        return self._function

    def instance(self) -> Function:
        """The same."""
        return self._function

    def __call__(self, *arguments: Any) -> Any:
        """Refuse: there is no text to run.

        Raises
        ------
        AlgorithmError
        """
        raise refusal_of_library(self.name)


def refusal_of_library(name: str) -> AlgorithmError:
    """The error where a target needs the text of a `CFunction`."""
    return AlgorithmError(f"{name} is a function of C alone", remedy="Run the program that calls it in C.")


def _with_fields(type: Any, array: Any) -> Any:
    if isinstance(type, ArrayType) and type.axes == 0 and type.is_open and type.size > 1 and np.ndim(array) == 1:
        array = array[: len(array) // type.size * type.size].reshape(-1, *type.sizes[1:])  # numbers given as rows
    elif isinstance(type, ArrayType) and type.shape == (None,) and np.ndim(array) > 1:
        array = array.reshape(-1)  # rows given as numbers
    return type.record.view(array) if isinstance(type, ArrayType) and type.record is not None else array


def make_array(type: ArrayType) -> Any:
    """An array of zeros, in the numbers that are in use."""
    sizes = [n or 0 for n in type.sizes]
    return language.zeros(*sizes) if type.scalar == REAL else language.int_zeros(*sizes)


#: Algorithms that are being read, the callers first; by one thread at a time.
_reading: list[Algorithm] = []
_lock = RLock()


def _settle_type(
    parameter: Parameter, given: ArrayType | Scalar | Static | StaticType
) -> ArrayType | Scalar | Static | StaticType:
    """What a parameter is in one instance: fields are those that it declares, whatever the caller's array has."""
    if not isinstance(given, ArrayType):
        return given
    assert isinstance(parameter.type, ArrayType)
    return replace(given, record=None) if parameter.type.is_generic else parameter.type


def _is_concrete(parameter: Parameter) -> bool:
    if isinstance(parameter.type, ArrayType):
        return not parameter.type.is_generic
    return isinstance(parameter.type, Scalar)


def _suffix(value: Any) -> str:
    """Of a name, for a static value: another for each, in letters that every target has; its label, if it has one."""
    if isinstance(label := getattr(value, "label", None), str):
        return label
    text = str(value)
    is_word = isinstance(value, str) and re.fullmatch("[a-z][a-z0-9_]*", text) and value not in ("true", "false")
    if len(text) <= _LONGEST and (is_word or type(value) is bool or (type(value) is int and value >= 0)):
        return text.lower()
    return _digest(repr(value))


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()[:_DIGITS]
