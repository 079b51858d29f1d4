"""Functions of users: how many arguments they take, and what goes wrong in them as one line."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any

from ..codegen.errors import BladesmithError, InputError


def check_arity(function: Callable[..., Any], counts: tuple[int, ...], what: str, needed: str) -> int:
    """With how many arguments a function can be called: the first of these counts that it takes.

    Raises
    ------
    InputError
        If it takes none of them.
    """
    try:
        signature = inspect.signature(function)
    except (TypeError, ValueError):  # of what is written in C nothing is known
        return counts[-1]
    places = (inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD)
    named = [p for p in signature.parameters.values() if p.kind in places and p.default is p.empty]
    if 1 in counts and len(named) == 1 and not any(p.kind is p.VAR_POSITIONAL for p in signature.parameters.values()):
        counts = (1,)  # others have values already: lambda t, a=a, b=b
    for count in counts:
        try:
            signature.bind(*[None] * count)
        except TypeError:
            continue
        return count
    raise InputError(f"{what} takes {signature}; {needed} is needed.")


def one_line(error: BaseException) -> str:
    """Error of a user's function, on one line."""
    if isinstance(error, BladesmithError):
        return error.what
    return f"{type(error).__name__}: {' '.join(str(error).split())}".rstrip(": ")


class GuardedCallback:
    """A user's function, whose failures before a run are reported like all bad input.

    Parameters
    ----------
    function : callable
        Of one argument.
    what : str
        What it is, for messages.
    check : callable, optional
        Raises an `InputError` of a value that is not valid.
    """

    def __init__(
        self, function: Callable[..., Any], what: str, check: Callable[[Any, str], None] | None = None
    ) -> None:
        self.__wrapped__ = function  # its signature is this one's
        self._what, self._check = what, check

    def __call__(self, *given: Any) -> Any:
        try:
            value = self.__wrapped__(*given)
        except Exception as error:  # a user's function may raise anything
            time = f" at time {given[0]:.6g}" if isinstance(given[0], float) else ""
            raise InputError(f"{self._what} failed{time}: {one_line(error).rstrip('.')}.") from error
        if self._check is not None:
            self._check(value, self._what)
        return value
