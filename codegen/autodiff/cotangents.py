"""Cotangents of batches: what was broadcast has the sum over the items that share it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..algebra.algebra import Kind
from ..errors import InputError, ShapeError
from ..execute.arrays import Array, Binding, broadcast_leads
from ..execute.reductions.sums import run_sums, sum_items


def run_summed(kernel: Binding, arrays: Sequence[Any], leads: Sequence[tuple[int, ...]]) -> list[Array]:
    """Results of a kernel, each summed to the leading shape that is wanted of it.

    Parameters
    ----------
    kernel : Binding
        Without statuses among its results.
    arrays : sequence of array
        As for a call.
    leads : sequence of tuple of int
        One for each result; together they have the shape of the items.

    Raises
    ------
    ShapeError
        If there are more items.
    """
    lead = broadcast_leads(leads, kernel.symbol)
    is_total = [own != lead and math.prod(own) == 1 for own in leads]
    found, items = run_sums(kernel, arrays, is_total)
    if items != lead:
        raise ShapeError(f"{kernel.symbol}: cotangents of items of shape {items} are more than there are values.")
    return [
        r if own == lead else r.reshape(*own, -1) if total else summed_to(r, own)
        for r, own, total in zip(found, leads, is_total, strict=True)
    ]


def cotangent_rows(array: Any, kind: Kind, lead: tuple[int, ...], what: str) -> Any:
    """A cotangent (..., size) of values (*lead, size); of values of one number also one (*lead), or a number.

    Parameters
    ----------
    array : array
    kind : Kind
        Of the values.
    lead : tuple of int
        The items' shape.
    what : str
        Whose it is, for messages.

    Raises
    ------
    InputError, ShapeError
        If it does not hold numbers, or broadcast to the values' shape.
    """
    if array.dtype.kind not in "biuf":
        raise InputError(f"{what} has type {array.dtype}; real numbers are needed.")
    shape = array.shape
    if kind.size == 1 and shape in ((), lead):
        return array[..., None]
    if shape[-1:] == (kind.size,) and _broadcasts(shape[:-1], lead):
        return array
    remedy = f"Give {(*lead, kind.size)}, the shape of the values"
    if kind.size == 1 and shape[-1:] != (1,) and lead:
        remedy += f", or {lead}: c[..., None] makes the one of the other"
    elif shape == lead:
        remedy += ", such as c[:, None] times a row of numbers"
    raise ShapeError(f"{what} has shape {shape}.", remedy=remedy)


def _broadcasts(own: tuple[int, ...], lead: tuple[int, ...]) -> bool:
    try:
        return np.broadcast_shapes(own, lead) == lead
    except ValueError:
        return False


def summed_to(value: Array, lead: tuple[int, ...]) -> Array:
    """An array (..., size) summed over the leading axes that a shape was broadcast along."""
    if not value.size:
        return np.zeros((*lead, value.shape[-1]), value.dtype)
    added = value.ndim - 1 - len(lead)
    axes = [i for i in range(value.ndim - 1) if i < added or (lead[i - added] == 1 and value.shape[i] != 1)]
    kept = [i for i in range(value.ndim) if i not in axes]
    rows = np.ascontiguousarray(value.transpose(*axes, *kept))
    rows = rows.reshape(math.prod(value.shape[i] for i in axes), -1)
    return sum_items(rows).reshape(*lead, value.shape[-1])
