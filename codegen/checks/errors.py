"""Errors of a kernel's results against exact values, in units of roundoff and of what rounding may do."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from ..execute.arrays import Array
from ..ir.graph import evaluate
from ..rings.error_bound import BoundRing
from ..rings.protocol import FUNCTIONS, NumericRing, Terms
from ..status import Status
from ..trace.kernel import Kernel
from .exact_items import exact_items

#: Errors are held to this many units of roundoff times the bound; variants are admitted up to a ratio of 4.
CONSTANT = 8.0
#: Digits of references, of formulas that are not rational, and their rounding where the exact answer is zero.
DIGITS, ORACLE = 50, 1e-45


@dataclass(frozen=True)
class Comparison:
    """Errors of the results for some items.

    Attributes
    ----------
    units : float
        The largest error, in units of roundoff of the result's largest coefficient.
    fraction : float
        The largest error over what is allowed: more than 1 is a fault.
    fault : str
        What is wrong with the first item and coefficient that is off by more, and its operands; empty if none is.
    """

    units: float
    fraction: float
    fault: str


def exact_rows(kernel: Kernel, arrays: Sequence[Array], digits: int = DIGITS) -> list[list[list[Any]]]:
    """The formula itself, item by item: rationals where that is possible, else numbers of so many digits.

    Returns
    -------
    list
        For each item and output its coefficients.
    """
    rational = not any(node.op in FUNCTIONS for node in kernel.graph.nodes)
    columns = [np.reshape(a, (len(a), -1)).T.astype(float).tolist() for a in arrays]
    epsilon = Fraction(float(np.finfo(arrays[0].dtype).eps))
    return exact_items(kernel, columns, rational, digits, epsilon)


def compare(
    kernel: Kernel, arrays: Sequence[Array], results: Any, exact: Sequence[Any], reduced: bool = False
) -> Comparison:
    """Compare results with exact values.

    Parameters
    ----------
    kernel : Kernel
    arrays : sequence of arrays
        Operands (items, size), or (items,) of plain numbers.
    results : array or tuple of arrays
    exact : sequence
        See `exact_rows`.
    reduced : bool
        True for variants that use constraints: members are rounded, so off their constraints by a unit of the whole
        object, not of a coefficient.
    """
    items, dtype = len(arrays[0]), arrays[0].dtype
    unit = float(np.finfo(dtype).eps) / 2
    places = _places(kernel, arrays)
    bounded = evaluate(kernel.roots, {place: (v, 0.0) for place, v in places.items()}, BoundRing())
    outputs = results if isinstance(results, tuple) else (results,)
    worst_units = worst_fraction = 0.0
    fault, start = "", 0
    for o, (output, values) in enumerate(zip(kernel.outputs, outputs, strict=True)):
        size = len(output.nodes)
        part = bounded[start : start + size]
        start += size
        table = np.asarray(values).reshape(items, size)
        own = [np.broadcast_to(np.maximum(b, np.abs(v)), (items,)) for v, b in part]
        if reduced:
            own = [np.max(own, axis=0)] * size
        magnitude = np.max([np.abs(np.broadcast_to(v, (items,))) for v, _ in part], axis=0)
        # bounds are of first order: of the square of a rounding error they see nothing
        limits = [limit * unit * CONSTANT + ORACLE * magnitude + (CONSTANT * unit) ** 2 for limit in own]
        for i in range(items):
            for j in range(size):
                true, got = exact[i][o][j], float(table[i, j])
                error, allowed = 0.0, float(limits[j][i] + np.finfo(dtype).smallest_subnormal)
                if output.role == "status":
                    is_wrong = int(got) != int(true) and not _overflows(kernel, outputs, i, places)
                elif not np.isfinite(got) or not np.isfinite(limits[j][i]):
                    lost = not _fits(true, dtype) or not _fits(limits[j][i], dtype)
                    is_wrong = not lost and not _overflows(kernel, outputs, i, places)
                else:
                    error = abs(float(Fraction(got) - true)) if isinstance(true, Fraction) else abs(float(got - true))
                    is_wrong = not error <= allowed
                    worst_fraction = max(worst_fraction, error / allowed)
                    if magnitude[i] > 0:
                        worst_units = max(worst_units, error / (unit * float(magnitude[i])))
                if is_wrong and not fault:
                    where = f"item {i}, {_coefficient(kernel, o, j)}"
                    off = f"is off by {error:.3g} where {allowed:.3g} is allowed" if error else f"is not {true}"
                    fault = f"{where}: {got!r} {off}; {_operands(kernel, arrays, i)}"
    return Comparison(worst_units, worst_fraction, fault)


def _places(kernel: Kernel, arrays: Sequence[Array]) -> dict[tuple[int, int], Array]:
    """Columns of coefficients, by argument and coefficient."""
    return {
        (n, j): (a if item.kind.is_scalar_argument else a[..., j]).astype(float)
        for n, (item, a) in enumerate(zip(kernel.inputs, arrays, strict=True))
        for j in range(item.kind.size)
    }


class _RangeRing(NumericRing):
    """Numbers, and whether any that was computed is beyond a range."""

    def __init__(self, largest: float) -> None:
        super().__init__()
        self.largest = largest
        self.beyond: Any = np.False_

    def _noted(self, value: Any) -> Any:
        self.beyond = self.beyond | (np.abs(value) > self.largest)
        return value

    def combine(self, terms: Terms) -> Any:
        return self._noted(super().combine(terms))

    def multiply(self, a: Any, b: Any) -> Any:
        return self._noted(super().multiply(a, b))


def _overflows(kernel: Kernel, outputs: Sequence[Array], item: int, places: dict[tuple[int, int], Array]) -> bool:
    """Whether an item may have no value, because there are numbers beyond the range on the way to it.

    A kernel with a status must say so: NaN, and INVALID.
    """
    by_role = [(o.role, v[item]) for o, v in zip(kernel.outputs, outputs, strict=True)]
    codes, values = ([v for r, v in by_role if (r == "status") == told] for told in (True, False))
    if codes and not (int(codes[0]) == Status.INVALID and all(np.isnan(v).all() for v in values)):
        return False
    ranges = _RangeRing(float(np.finfo(outputs[0].dtype).max))
    evaluate(kernel.roots, {place: column[item] for place, column in places.items()}, ranges)
    return bool(ranges.beyond)


def _fits(value: Any, dtype: Any) -> bool:
    """Whether a number of this precision can hold it."""
    return abs(float(value)) <= float(np.finfo(dtype).max)


def _coefficient(kernel: Kernel, output: int, index: int) -> str:
    found = kernel.outputs[output]
    if found.role == "status":
        return "the status"
    if found.kind.form != "multivector":
        return f"number {index} of {found.name}"
    return f"coefficient {found.kind.algebra.blade_name(found.kind.blades[index])} of {found.name}"


def _operands(kernel: Kernel, arrays: Sequence[Array], item: int) -> str:
    """Operands of an item, so that the call can be repeated: float32 as it is."""
    return ", ".join(f"{i.name} = {np.asarray(a[item]).tolist()}" for i, a in zip(kernel.inputs, arrays, strict=True))
