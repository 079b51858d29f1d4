"""Algorithms for the sizes and static values of the arguments of a call."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..errors import InputError
from ..ir.loops.algorithm import Algorithm
from ..ir.loops.nodes import Function
from ..ir.loops.scope import Static
from ..ir.loops.text import is_static
from ..ir.loops.types import REAL, ArrayType, Parameter, Scalar, StaticType


class SizedAlgorithm(Algorithm):
    """An algorithm with the instances that calls need."""

    def declared_arguments(self) -> Sequence[Any]:
        """Zeros in place of arguments, where the sizes are declared."""
        found: list[Any] = []
        for p in self.inputs():
            if isinstance(p.type, StaticType) or (isinstance(p.type, ArrayType) and p.type.is_generic):
                raise InputError(f"{self.name}: the text depends on {p.name}; give the arguments of a call.")
            shape = [n or 1 for n in p.type.sizes] if isinstance(p.type, ArrayType) else []
            found.append(np.zeros(shape, np.float64 if is_real(p) else np.int64))
        return found

    def items(self, arguments: Sequence[Any]) -> list[Any]:
        """The arguments that are not static."""
        return [a for a, p in zip(arguments, self.inputs(), strict=True) if not isinstance(p.type, StaticType)]

    def function_for(self, arguments: Sequence[Any], results: Mapping[str, Any] | None = None) -> Function:
        """The IR for arguments. ``results``: arrays of the sizes of some that it writes."""
        inputs = self.inputs()
        self.check_count(arguments)
        by_name = {**(results or {}), **{p.name: a for p, a in zip(inputs, arguments, strict=True)}}
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
        if parameter.access == "out" and value is None:
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


def is_real(parameter: Parameter) -> bool:
    """Whether a parameter has real numbers."""
    return (parameter.type.scalar if isinstance(parameter.type, ArrayType) else parameter.type) == REAL
