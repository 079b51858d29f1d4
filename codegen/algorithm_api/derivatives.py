"""Derivatives of algorithms: forward along directions, and reverse, from cotangents."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..autodiff.cotangents import summed_to
from ..errors import InputError, ShapeError
from ..execute.arrays import Array, broadcast_leads
from ..ir.adjoint.pullback import Pullback, pullback
from ..ir.loops.nodes import Function
from ..ir.loops.tangent import tangent as tangent_of
from ..ir.loops.types import ArrayType, Parameter
from .compiled import CompiledAlgorithm
from .sized import SizedAlgorithm, is_real


class DerivedAlgorithm(CompiledAlgorithm):
    """What is derived from an algorithm with respect to some of its parameters.

    Parameters
    ----------
    algorithm : AlgorithmFunction
    wrt : tuple of str
    """

    #: What the name has between the algorithm's and the parameters'.
    mark: str

    def __init__(self, algorithm: SizedAlgorithm, wrt: tuple[str, ...]) -> None:
        super().__init__()
        self.algorithm = algorithm
        self.wrt = wrt
        self.__name__ = f"{algorithm.name}_{self.mark}_{'_'.join(wrt)}"
        self.__module__ = algorithm.__module__

    def declared_arguments(self) -> Sequence[Any]:
        return self.algorithm.declared_arguments()


class AlgorithmDerivative(DerivedAlgorithm):
    """The derivative of an algorithm along directions of some of its parameters; see `AlgorithmFunction.derivative`.

    Parameters
    ----------
    algorithm : AlgorithmFunction
    wrt : tuple of str
    """

    mark = "d"

    def __call__(self, *arguments: Any) -> Any:
        """Results and their tangents.

        Parameters
        ----------
        *arguments
            Those of the algorithm, then directions.
        """
        return self.call("c", arguments)

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


class AlgorithmPullback(DerivedAlgorithm):
    """The reverse derivative of an algorithm with respect to some of its parameters; see `AlgorithmFunction.pullback`.

    Parameters
    ----------
    algorithm : AlgorithmFunction
    wrt : tuple of str
    """

    mark = "vjp"

    def __call__(self, *arguments: Any) -> Any:
        """Cotangents of the parameters, of each item.

        Parameters
        ----------
        *arguments
            Those of the algorithm, then a cotangent of each array of real numbers that it changes or writes, and of
            each real number that it returns.
        """
        return self.call("c", arguments)

    def function_for(self, arguments: Sequence[Any]) -> Function:
        return self.made(arguments).function

    def made(self, arguments: Sequence[Any]) -> Pullback:
        """What runs for arguments of the algorithm, and cotangents where an array of any size is written."""
        inputs = self.algorithm.inputs()
        own, rest = arguments[: len(inputs)], arguments[len(inputs) :]
        given = dict(zip([p.name for p in self._changed()], rest, strict=False))
        base = self.algorithm.function_for(own, given)
        by_name = {**given, **{p.name: a for p, a in zip(inputs, own, strict=True)}}
        rows = {p.name: _rows(p, by_name.get(p.name)) for p in base.parameters
                if isinstance(p.type, ArrayType) and p.type.is_open}  # fmt: skip
        return pullback(base, self.wrt, rows)

    def _changed(self) -> list[Parameter]:
        return [p for p in self.algorithm.text.parameters if p.access != "in" and is_real(p)]

    def prepare(self, arguments: Sequence[Any]) -> tuple[Function, list[Any]]:
        """Arguments and cotangents."""
        count, made = len(self.algorithm.inputs()), self.made(arguments)
        wanted = len(made.cotangents)
        if len(arguments) != count + wanted:
            names = ", ".join(p.name for p in made.cotangents) or "none"
            raise InputError(
                f"{self.__name__} takes {count} arguments of {self.algorithm.name} and {wanted} cotangents ({names}), "
                f"not {len(arguments)} in all."
            )
        return made.function, [*self.algorithm.items(arguments[:count]), *arguments[count:]]

    def summed(self, inputs: Sequence[Any], cotangents: Sequence[Any]) -> tuple[Array, ...]:
        """Cotangents of the parameters, of their shapes: what items share has the sum over them."""
        made, found = self.made((*inputs, *cotangents)), self(*inputs, *cotangents)
        given = {p.name: a for p, a in zip(self.algorithm.inputs(), inputs, strict=True)}
        axes = {p.name: len(p.type.sizes) if isinstance(p.type, ArrayType) else 0 for p in made.function.parameters}
        leads = {n: _lead(a, axes[n]) for n, a in given.items() if n in axes}
        lead = broadcast_leads(list(leads.values()), self.__name__)
        results = dict(zip((*made.arrays, *made.numbers), found if isinstance(found, tuple) else (found,), strict=True))
        sums = []
        for name in self.wrt:
            value, own = np.asarray(results[name]), leads[name]
            items = value.shape[: value.ndim - axes[name]]
            if items != lead:
                raise ShapeError(
                    f"{self.__name__}: cotangents of items of shape {items} are more than there are values, {lead}."
                )
            rows = value.reshape(*lead, math.prod(value.shape[value.ndim - axes[name] :]))
            sums.append((rows if own == lead else summed_to(rows, own)).reshape(np.shape(given[name])))
        return tuple(sums)


def _rows(parameter: Parameter, value: Any) -> int:
    """The number of rows of an argument, which is checked where it is taken."""
    assert isinstance(parameter.type, ArrayType)
    shape: tuple[int, ...] = np.shape(value)
    axes = len(parameter.type.sizes)
    return shape[len(shape) - axes] if len(shape) >= axes else 0


def _lead(value: Any, axes: int) -> tuple[int, ...]:
    shape: tuple[int, ...] = np.shape(value)
    return shape[: len(shape) - axes]


def _zeros_like(value: Any) -> Any:
    """Zeros of the same shape and precision."""
    single = getattr(value, "dtype", None) == np.float32
    return np.zeros(np.shape(value), np.float32 if single else np.float64)
