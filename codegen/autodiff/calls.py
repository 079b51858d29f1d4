"""Calls of kernels as other packages make them: tables of rows (n, size), or one row (size,) that all items share.

A result is a table where an operand is, or the sum over the items. Arrays are of any package: they have a shape, and
are reshaped.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..algebra.algebra import Kind
from ..algebra.mismatch import algebra_mismatch
from ..errors import InputError, KindError, ShapeError
from ..execute.reductions.sums import run_sums


@dataclass(frozen=True)
class Call:
    """What is called, and how.

    Attributes
    ----------
    kernel : KernelFunction
    is_summed : tuple of bool
        For each output whether it is summed over the items.
    source : tuple, optional
        Of the tangents of a kernel: that kernel, and the arguments along whose directions they are.
    """

    kernel: Any
    is_summed: tuple[bool, ...]
    source: tuple[Any, tuple[str, ...]] | None = None


def call_of(kernel: Any, lead: tuple[int, ...]) -> Call:
    """The call of a declared kernel for items of a shape."""
    return Call(kernel, (kernel.reduce is not None and math.prod(lead) != 1,) * len(kernel.outputs))


def items(operands: Sequence[Any]) -> int | None:
    """Number of items; None of a single one."""
    return next((o.shape[0] for o in operands if len(o.shape) == 2), None)


def shapes(call: Call, operands: Sequence[Any]) -> list[tuple[tuple[int, ...], Any]]:
    """Shapes and types of results; of a status there is one number for each item."""
    n = items(operands)
    found = []
    for output, summed in zip(call.kernel.outputs, call.is_summed, strict=True):
        lead = () if n is None or summed else (n,)
        is_status = output.role == "status"
        found.append((lead if is_status else (*lead, output.kind.size), np.uint8 if is_status else operands[0].dtype))
    return found


def run(call: Call, kernel: Any, *operands: Any) -> list[Any]:
    """Results of a bound kernel, from operands that NumPy takes."""
    columns = [np.asarray(o) for o in operands]
    sized = [c if i.size else c[..., 0] for c, i in zip(columns, kernel.inputs, strict=True)]
    many = items(columns) is not None
    found, _ = run_sums(kernel, sized, [summed and many for summed in call.is_summed])
    pairs = zip(found, shapes(call, columns), strict=True)
    return [np.asarray(f).reshape(shape).astype(dtype, copy=False) for f, (shape, dtype) in pairs]


def coefficients(kernel: str, value: Any, kind: Kind, argument: str) -> Any:
    """Coefficients of a multivector on the blades of a kind; any other value as it is.

    Raises
    ------
    AlgebraMismatchError, KindError
        If it is of another algebra, or not of the kind.
    """
    if not hasattr(value, "as_kind"):
        return value
    if value.algebra is not kind.algebra:
        what = f"{kernel}: {argument} belongs to {value.algebra.name}, not to {kind.algebra.name}."
        raise algebra_mismatch(what, value, kind.algebra)
    try:
        return value.as_kind(kind).values
    except KindError as error:
        raise KindError(f"{kernel}: argument {argument}: {error}") from None


def check_count(kernel: Any, arguments: Sequence[Any], by_name: Iterable[str] = ()) -> tuple[str, ...]:
    """Names of the arguments that are not given by position.

    Raises
    ------
    InputError
        If there are more or fewer, or those by name are others.
    """
    rest: tuple[str, ...] = kernel.arguments[len(arguments) :]
    if len(arguments) > len(kernel.kinds) or set(by_name) != set(rest):
        raise InputError(f"{kernel.name} takes {len(kernel.kinds)} arguments ({', '.join(kernel.arguments)}).")
    return rest


def positional(kernel: Any, arguments: Sequence[Any], by_name: Mapping[str, Any]) -> list[Any]:
    """The arguments in the declared order, multivectors as their coefficients.

    Raises
    ------
    InputError, AlgebraMismatchError, KindError
        If there are more or fewer; if a multivector is not of its argument's kind.
    """
    rest = check_count(kernel, arguments, by_name)
    whole = zip((*arguments, *(by_name[name] for name in rest)), kernel.kinds, kernel.arguments, strict=True)
    return [coefficients(kernel.name, value, kind, name) for value, kind, name in whole]


def rows_of(kernel: Any, arrays: Sequence[Any]) -> list[Any]:
    """Arrays with an axis of coefficients, also those of plain numbers.

    Raises
    ------
    ShapeError
        If that axis has another length.
    """
    found = []
    for array, kind, name in zip(arrays, kernel.kinds, kernel.arguments, strict=True):
        rows = array[..., None] if kind.is_scalar_argument else array
        if rows.ndim == 0 or rows.shape[-1] != kind.size:
            what = f"{kernel.name}: {name} has shape {tuple(array.shape)}; its last axis must have {kind.size} entries."
            raise ShapeError(what, remedy=constructor(kind))
        found.append(rows)
    return found


def constructor(kind: Kind) -> str | None:
    """What makes members of a kind, for messages; None where the algebra has no function for it."""
    home = kind.algebra
    for name in (kind.name, f"{kind.name}_from_matrix"):
        if kind.form == "multivector" and callable(made := getattr(home, name, None)):
            arguments = ", ".join(p for p in inspect.signature(made).parameters if p != "strict")
            return f"{home.name}.{name}({arguments}) makes a {kind.name}"
    return None


def tables(arrays: Sequence[Any], lead: tuple[int, ...], broadcast_to: Callable[..., Any]) -> list[Any]:
    """Tables of rows, or rows that all items share, of arrays (..., size) for items of a shape."""
    is_single = math.prod(lead) == 1
    return [
        a.reshape(-1)
        if is_single or math.prod(a.shape[:-1]) == 1
        else broadcast_to(a, (*lead, a.shape[-1])).reshape(math.prod(lead), a.shape[-1])
        for a in arrays
    ]


def shaped(kernel: Any, results: Sequence[Any], lead: tuple[int, ...]) -> Any:
    """Results as users get them: one array, or a tuple with those of statuses."""
    whole = () if kernel.reduce is not None else lead
    found = [
        r.reshape(whole if o.role == "status" else (*whole, o.kind.size))
        for r, o in zip(results, kernel.outputs, strict=True)
    ]
    return found[0] if len(found) == 1 else tuple(found)
