"""One algebra of the same plain data in a process, so that multivectors meet; algebras in pickles are such data."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, TypeVar
from weakref import WeakValueDictionary

from ..codegen.algebra.loader import data_from_algebra
from ..codegen.errors import InputError
from ..dispatch.types import TypedAlgebra

A = TypeVar("A", bound=TypedAlgebra)
#: Algebras made from data, by class and data: unpickling gives back the one that was pickled in this process.
_INTERNED: WeakValueDictionary[Any, Any] = WeakValueDictionary()


def intern(cls: type[A], data: Mapping[str, Any]) -> A:
    """The one algebra of a class, in this process, of plain data."""
    return from_hashable(cls, _hashable(data))


def keep(algebra: A) -> tuple[Callable[..., A], tuple[type[A], Any]]:
    """What pickle stores of an algebra that no function makes; read in this process it is the same one."""
    key = type(algebra), _hashable(data_from_algebra(algebra))
    _INTERNED.setdefault(key, algebra)
    return from_hashable, key


def from_hashable(cls: type[A], data: Any) -> A:
    """The algebra of data as nested tuples; called by pickle.

    Raises
    ------
    InputError
        If the data is not an algebra's.
    """
    algebra: A | None = _INTERNED.get((cls, data))
    if algebra is None:
        plain = _plain_data(data)
        if not isinstance(plain, dict):
            raise InputError("the pickled data is not an algebra.")
        maker: Any = cls
        algebra = _INTERNED[cls, data] = maker.from_data(plain)
    assert algebra is not None
    return algebra


def _hashable(data: Any) -> Any:
    """Plain data as nested tuples, so that the same data gives the same algebra in one process."""
    if isinstance(data, Mapping):
        return ("map", *((key, _hashable(value)) for key, value in data.items()))
    return ("list", *map(_hashable, data)) if isinstance(data, list | tuple) else data


def _plain_data(data: Any) -> Any:
    if not isinstance(data, tuple):
        return data
    if data[0] == "map":
        return {key: _plain_data(value) for key, value in data[1:]}
    return [_plain_data(value) for value in data[1:]]
