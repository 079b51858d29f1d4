"""Statuses of results: completed, combined, told in errors, and NaN where an item has no answer."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..codegen.errors import SingularError
from ..common.validation import all_finite, as_bool
from ..status import Status
from .multivector_data import M, MultivectorData, Statuses, statuses

#: Why an item has its status, for its index and status: the end of a message.
Explanation: TypeAlias = Callable[[tuple[int, ...], Status], str]


def raise_first(
    status: NDArray[np.uint8] | None,
    what: str,
    error: type[SingularError] = SingularError,
    explain: Explanation | None = None,
) -> None:
    """Raise for the first item without an answer.

    Raises
    ------
    SingularError
        Or the given subclass, naming the item and its status, and what ``explain`` says of them.
    """
    if status is None:
        return
    bad = (status != Status.OK) & (status != Status.NOT_UNIQUE)
    if not bad.any():
        return
    index = tuple(int(i) for i in np.argwhere(bad)[0]) if bad.ndim else ()
    code = Status(int(status[index]))
    item = "it" if not index else f"item {index[0] if len(index) == 1 else index}"
    reason = explain(index, code) if explain is not None and code != Status.INVALID else ""
    raise error(f"{what}: {item} is {code.name}{reason}.")


def unsigned_zeros(values: NDArray[Any]) -> NDArray[Any]:
    """A new result in which zeros have no sign, in place: a copy of a large batch costs as much as its kernel."""
    values += 0.0
    return values


def array_result(
    values: NDArray[Any],
    codes: NDArray[np.uint8] | None,
    what: str,
    status: Any,
    strict: Any,
    item_ndim: int = 0,
    explain: Explanation | None = None,
) -> NDArray[Any] | tuple[NDArray[Any], Statuses]:
    """Result of a function of plain arrays with the options ``status`` and ``strict``: values, or (values, statuses).

    Parameters
    ----------
    values : array (..., items)
        Items have ``item_ndim`` axes.
    codes : array (...) of uint8, optional
        Statuses that are known, such as those of the operands; what is not finite beside is `INVALID`.

    Raises
    ------
    SingularError
        With ``strict``: for the first item without an answer.
    """
    if status is False and strict is False:
        return values
    with_status, is_strict = as_bool(status, "status"), as_bool(strict, "strict")
    lead = values.shape[: values.ndim - item_ndim]
    finite = np.isfinite(values).all(tuple(range(-item_ndim, 0)))
    known = np.zeros(lead, np.uint8) if codes is None else np.broadcast_to(codes, lead)
    found = np.asarray(np.where(finite | (known != Status.OK), known, np.uint8(Status.INVALID)), np.uint8)
    if is_strict:
        raise_first(found, what, explain=explain)
    return (values, statuses(found, lead)) if with_status else values


def invalidate_nonfinite(x: M) -> M:
    """Items without an answer are NaN all over; what is not finite is `INVALID`, unless its status says more.

    Other packages' arrays, which have no statuses, stay as they are.
    """
    if x._type.backend is not None:
        return x
    if all_finite(x._data) and (x._status is None or not x._status.any()):
        return x
    bad = ~np.isfinite(x._data).all(-1)
    if x._status is not None:
        bad = bad | (x._status != Status.OK) & (x._status != Status.NOT_UNIQUE)
    return invalidate(x, bad)


def invalidate(x: M, bad: NDArray[np.bool_]) -> M:
    """NaN and INVALID in some items."""
    if not bad.any():
        return x
    known = np.zeros(x.shape, np.uint8) if x._status is None else x._status
    answered = (known == Status.OK) | (known == Status.NOT_UNIQUE)
    status = np.where(bad & answered, np.uint8(Status.INVALID), known)
    data = np.where(bad[..., None], x.dtype.type(np.nan), x._data)
    return _with_deviation(x._make(x._type, data, x.shape, np.asarray(status, np.uint8)), x)


def propagate_invalid(result: M, x: MultivectorData) -> M:
    """The result of a function of x: items of x that are not finite have no answer, and x's status or `INVALID`."""
    if all_finite(x._data):
        return result
    bad = ~np.isfinite(x._data).all(-1)
    statuses = (invalidate(x, bad)._status, result._status)
    given, known = (np.zeros(x.shape, np.uint8) if status is None else status for status in statuses)
    data = np.where(bad[..., None], result.dtype.type(np.nan), result._data)
    made = result._make(result._type, data, result.shape, np.asarray(np.where(bad, given, known), np.uint8))
    return _with_deviation(made, result)


def _with_deviation(made: M, x: M) -> M:
    if hasattr(x, "_deviation"):
        made._deviation = x._deviation
    return made


def merge_statuses(*statuses: NDArray[np.uint8] | None) -> NDArray[np.uint8] | None:
    """One status per item: the first that is not OK."""
    known = [s for s in statuses if s is not None]
    if not known:
        return None
    total = known[0]
    for other in known[1:]:
        total = np.where(total == Status.OK, other, total)
    return np.asarray(total, np.uint8)


__all__ = [
    "Explanation",
    "array_result",
    "invalidate",
    "invalidate_nonfinite",
    "merge_statuses",
    "propagate_invalid",
    "raise_first",
]
