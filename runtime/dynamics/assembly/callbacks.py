"""Registry of the users' functions that the driver calls: loads and paths that change with time or state."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import InputError
from ...common.callbacks import check_arity, one_line

Array = NDArray[Any]
#: Coefficients of a motor.
MOTOR = 8


def arity(function: Callable[..., Any], what: str) -> int:
    """Number of arguments of a function: 1 (time), or 3 (time, motor, twist).

    Raises
    ------
    InputError
        If it takes another number.
    """
    return check_arity(function, (3, 1), what, "a function of time, or of time, motor and twist")


class CallbackRegistry:
    """Functions of a simulation, which the driver calls by number; errors are stored until the driver returns."""

    def __init__(self) -> None:
        self.functions: list[Callable[[int, float, Array], Array]] = []
        self.names: list[str] = []
        self.sizes: list[int] = []
        self.error: BaseException | None = None

    def add(self, function: Callable[[int, float, Array], Array], name: str, size: int) -> int:
        """Add a function of simulation, time and state (motor, then twist) with ``size`` values; return its number."""
        self.sizes.append(size)
        self.functions.append(function)
        self.names.append(name)
        return len(self.functions) - 1

    def call(self, which: int, item: int, t: float, state: Array) -> Array | None:
        """Value of a function, or None if it failed."""
        if self.error is not None and not isinstance(self.error, Exception):
            return None  # an interrupt ends all of a batch
        try:
            value = self.functions[which](item, t, state)
            if np.size(value) != self.sizes[which]:  # the driver has room for no more, and reads no less
                raise InputError(
                    f"it returned {np.size(value)} numbers where {self.sizes[which]} are needed: return one object, "
                    "with its two derivatives at every call or at none"
                )
            if not np.isfinite(value).all():
                raise InputError(f"it returned {value[~np.isfinite(value)][0]}")
            return value
        except Exception as error:  # a user's function may raise anything
            cause = (error.__cause__ if isinstance(error, InputError) else None) or error
            failure = InputError(
                f"{self.names[which]} failed at time {t:.6g}: {one_line(cause).rstrip('.')}.",
                where=None if item == 0 else f"simulation {item}",
                remedy=f"The body was at motor {_format(state[:MOTOR])} with twist {_format(state[MOTOR:])}",
            )
            failure.__cause__ = error
            self.error = self.error or failure
        except BaseException as error:  # an interrupt inside the function
            self.keep(error)
        return None

    def keep(self, error: BaseException) -> None:
        """Store the error that ends the run: the first one, unless an interrupt comes."""
        if self.error is None or not isinstance(error, Exception):
            self.error = error


def _format(values: Array) -> str:
    return "[" + ", ".join(f"{v:.6g}" for v in values) + "]"
