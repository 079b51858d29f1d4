"""Formulas of single items: one call of compiled code, found by one look-up, where all is as usual.

What is unusual in an item (a status, a number that is not finite), an array that has to be converted, single precision,
a kernel that is not compiled: all that is left to `formulas.evaluate`, which says so in full.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.execute.arrays import READY
from ..codegen.execute.bound_kernels import BoundKernel
from ..common.dtypes import F64
from .kernel_entries import Key, Result
from .multivector_data import from_buffer
from .types import Type, TypedAlgebra

#: Operands that the compiled call takes, and results.
MOST_OPERANDS, MOST_RESULTS = 4, 8
#: The status OK of a single item.
OK_ALONE = np.zeros((), np.uint8)
OK_ALONE.flags.writeable = False


def is_plain(array: Any, shape: tuple[int, ...]) -> bool:
    """Whether this is an array of a shape, in double precision, as compiled code takes it."""
    return (
        array.__class__ is np.ndarray
        and array.shape == shape
        and array.dtype is F64
        and array.flags.num & READY == READY
    )


class ItemPlan:
    """A kernel's results in the memory of a call.

    Parameters
    ----------
    kernel : BoundKernel
    operands : int
    outputs : sequence of Result
        Statuses among them.
    types : sequence of Type or None
        Of results that are multivectors.

    Attributes
    ----------
    status : array () of uint8, or None
        That of an item as usual, where the kernel has statuses.
    """

    __slots__ = ("status", "_run", "_item", "_results", "_places", "_numbers", "_rest")

    def __init__(
        self, kernel: BoundKernel, operands: int, outputs: Sequence[Result], types: Sequence[Type | None]
    ) -> None:
        ffi = kernel.library.ffi
        self._run = kernel.library.lib.bs_run_item
        self._rest = (ffi.NULL,) * (MOST_OPERANDS - operands)
        self._item = item = ffi.new("bs_item *")
        item.kernel, item.single, item.count = kernel.index, 0, len(outputs)
        self._results: list[tuple[slice, Type | None]] = []
        place = 0
        status = numbers = sum(o.size for o in outputs if not o.is_status)
        for i, (output, type) in enumerate(zip(outputs, types, strict=True)):
            item.places[i], item.sizes[i] = 8 * (status if output.is_status else place), output.size
            if output.is_status:
                item.sizes[i] = 0
                status += 1
            else:
                self._results.append((slice(place, place + output.size), type))
                place += output.size
        self._places = [p if p.stop > p.start + 1 else p.start for p, _ in self._results]
        self._numbers = status
        self.status = OK_ALONE if status > numbers else None

    def values(self, pointers: Sequence[Any]) -> list[Any] | None:
        """Results of an item, multivectors and rows of numbers; None where one is not as usual."""
        out = np.empty(self._numbers)
        if self._run(self._item, from_buffer(out), *pointers, *self._rest):
            return None
        return [out[place] if type is None else wrapped(type, out[place]) for place, type in self._results]

    def rows(self, pointers: Sequence[Any]) -> list[Any] | None:
        """Coefficients of all results, of one alone as a number; None where one is not as usual."""
        out = np.empty(self._numbers)
        if self._run(self._item, from_buffer(out), *pointers, *self._rest):
            return None
        return [out[place] for place in self._places]

    def value(self, pointers: Sequence[Any]) -> Any:
        """The first result, a multivector; None where one is not as usual."""
        out = np.empty(self._numbers)
        if self._run(self._item, from_buffer(out), *pointers, *self._rest):
            return None
        place, type = self._results[0]
        return wrapped(type, out if len(out) == place.stop else out[place])  # type: ignore[arg-type]


def wrapped(type: Type, data: NDArray[Any]) -> Any:
    """A single multivector on an array without gaps that nobody else writes to."""
    new = object.__new__(type.algebra.multivector_class)
    new._type = type
    new._data = data
    new._lead = ()
    new._pointer = new._status = None
    return new


class NoPlan:
    """What stands for a plan where there is none."""

    status = None

    def values(self, pointers: Sequence[Any]) -> None:
        """No results."""

    value = rows = values


NO_PLAN = NoPlan()


def make_plan(algebra: TypedAlgebra, run: Any, inputs: Sequence[Key], outputs: Sequence[Result]) -> ItemPlan | None:
    """The plan of a resolved kernel; None where it has none."""
    if not isinstance(run, BoundKernel) or len(inputs) > MOST_OPERANDS or len(outputs) > MOST_RESULTS:
        return None
    if not run.provide(single=False):
        return None
    types = [None if o.kind is None else algebra.type_of(o.kind, F64) for o in outputs]
    return ItemPlan(run, len(inputs), outputs, types)


__all__ = ["NO_PLAN", "OK_ALONE", "ItemPlan", "NoPlan", "is_plain", "make_plan"]
