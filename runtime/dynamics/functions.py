"""Functions of users: what the driver calls for loads and paths that change with time or state."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.errors import BladesmithError, InputError

Array = NDArray[Any]
#: Coefficients of a motor.
MOTOR = 8
#: Weights of central differences of order eight: of the first derivative at 1..4 steps, of the second at 0..4.
FIRST = (4 / 5, -1 / 5, 4 / 105, -1 / 280)
SECOND = (-205 / 72, 8 / 5, -1 / 5, 8 / 315, -1 / 560)
#: Steps that are tried, in seconds.
STEPS = tuple(10.0**k for k in np.arange(-6, 0.1, 0.5))


def arity(function: Callable[..., Any], what: str) -> int:
    """1 for functions of time, 3 for those of time, motor and twist.

    Raises
    ------
    InputError
        If it takes neither.
    """
    return takes(function, (3, 1), what, "a function of time, or of time, motor and twist")


def takes(function: Callable[..., Any], counts: tuple[int, ...], what: str, needed: str) -> int:
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


def reason(error: BaseException) -> str:
    """What a user's function raised, on one line."""
    if isinstance(error, BladesmithError):
        return error.what
    return f"{type(error).__name__}: {' '.join(str(error).split())}".rstrip(": ")


class Asked:
    """A user's function, whose failures before a run are told like all bad input.

    Parameters
    ----------
    function : callable
        Of one argument.
    what : str
        What it is, for messages.
    check : callable, optional
        Raises an `InputError` of a value that is no answer.
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
            raise InputError(f"{self._what} failed{time}: {reason(error).rstrip('.')}.") from error
        if self._check is not None:
            self._check(value, self._what)
        return value


class Differences:
    """A function of time with its first two derivatives by differences, at a step that is found once."""

    def __init__(self, function: Callable[[float], Array], times: tuple[float, float]) -> None:
        self._function = function
        self._step = self._best(times)

    def __call__(self, t: float) -> tuple[Array, Array, Array]:
        return self._at(t, self._step)

    def _at(self, t: float, h: float) -> tuple[Array, Array, Array]:
        middle = self._function(t)
        ahead = [self._function(t + k * h) for k in range(1, 5)]
        behind = [self._function(t - k * h) for k in range(1, 5)]
        pairs = list(zip(ahead, behind, strict=True))
        first = sum((w * (a - b) for w, (a, b) in zip(FIRST, pairs, strict=True)), 0 * middle) / h
        second = sum((w * (a + b - 2 * middle) for w, (a, b) in zip(SECOND[1:], pairs, strict=True)), 0 * middle) / h**2
        return middle, first, second

    def _best(self, times: tuple[float, float]) -> float:
        """The step at which estimates differ least from those at half of it."""
        begin, end = times
        samples = [begin + share * (end - begin) for share in (0.13, 0.51, 0.87)]
        errors = []
        for h in STEPS:
            pairs = [(self._at(t, h)[2], self._at(t, h / 2)[2]) for t in samples]
            errors.append(max(float(np.abs(a - b).max()) for a, b in pairs))
        return float(STEPS[int(np.argmin(errors))])


class Called:
    """All functions of a simulation: the driver asks for them by number, and what goes wrong is kept for later."""

    def __init__(self) -> None:
        self.functions: list[Callable[[int, float, Array], Array]] = []
        self.names: list[str] = []
        self.sizes: list[int] = []
        self.error: BaseException | None = None

    def add(self, function: Callable[[int, float, Array], Array], name: str, size: int) -> int:
        """The number of a function of simulation, time and state (motor, then twist), that gives so many numbers."""
        self.sizes.append(size)
        self.functions.append(function)
        self.names.append(name)
        return len(self.functions) - 1

    def call(self, which: int, item: int, t: float, state: Array) -> Array | None:
        """The value, or None where the function failed."""
        if self.error is not None and not isinstance(self.error, Exception):
            return None  # an interrupt ends all of a batch
        try:
            value = self.functions[which](item, t, state)
            if np.size(value) != self.sizes[which]:  # the driver has room for no more, and reads no less
                raise InputError(
                    f"it gave {np.size(value)} numbers where {self.sizes[which]} are needed: one object, always with "
                    "its two derivatives or always without"
                )
            if not np.isfinite(value).all():
                raise InputError(f"it returned {value[~np.isfinite(value)][0]}")
            return value
        except Exception as error:  # a user's function may raise anything
            cause = (error.__cause__ if isinstance(error, InputError) else None) or error
            told = InputError(
                f"{self.names[which]} failed at time {t:.6g}: {reason(cause).rstrip('.')}.",
                where=None if item == 0 else f"simulation {item}",
                remedy=f"The body was at motor {_rounded(state[:MOTOR])} with twist {_rounded(state[MOTOR:])}",
            )
            told.__cause__ = error
            self.error = self.error or told
        except BaseException as error:  # an interrupt inside the function
            self.error = error
        return None


def _rounded(values: Array) -> str:
    return "[" + ", ".join(f"{v:.6g}" for v in values) + "]"
