"""Functions of Python that loops compiled by numba call by their address; as in C, they take the interpreter's lock."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from types import SimpleNamespace
from typing import Any

#: As C sees such a function: which one, of which item, a time, a state and room for values; not 0 if it failed.
C_TYPE = "int(ptrdiff_t which, ptrdiff_t item, double t, double *state, double *values)"


def user_values(
    handle: int, which: int, item: int, t: float, state: Any, state_at: int, values: Any, values_at: int
) -> int:
    """Values of the function at an address: its name for printed texts, which import what `compiled` makes.

    Raises
    ------
    NotImplementedError
        As Python: it takes an address.
    """
    raise NotImplementedError


def compiled(decorate: Callable[[Callable[..., Any]], Any]) -> SimpleNamespace:
    """The function, put through numba by `decorate`."""
    from .numba_jit import numba

    call = _call_address(numba())

    def user_values(handle, which, item, t, state, state_at, values, values_at):  # type: ignore[no-untyped-def]
        return call(handle, which, item, t, state.ctypes.data + 8 * state_at, values.ctypes.data + 8 * values_at)

    return SimpleNamespace(user_values=decorate(user_values))


def _call_address(numba: Any) -> Any:
    """A call of `C_TYPE` through an address that is known when it runs, so that machine code can be kept."""
    intrinsic = import_module("numba.extending").intrinsic
    ir, types = import_module("llvmlite.ir"), numba.types
    word, real, result = ir.IntType(64), ir.DoubleType(), ir.IntType(32)

    @intrinsic
    def call(typing, address, which, item, t, state, values):  # type: ignore[no-untyped-def]
        given = (types.int64, types.int64, types.int64, types.float64, types.int64, types.int64)

        def generate(context, builder, signature, arguments):  # type: ignore[no-untyped-def]
            function = ir.FunctionType(result, [word, word, real, word, word])
            pointer = builder.inttoptr(arguments[0], function.as_pointer())
            return builder.sext(builder.call(pointer, arguments[1:]), word)

        return types.int64(*given), generate

    return call
