"""What the text of the elementary functions takes for granted: selections, and the bits of numbers.

For NumPy arrays and scalars as it stands, for scalars under numba once `compiled` has put it through it, and in C
under the same names (templates/c/lib/elementary.h.j2, instance.h). An integer n is handed on as a number: as n plus the
constant `shifter` of the precision, in whose lowest bits it stands.
"""

from __future__ import annotations

from collections.abc import Callable
from types import FunctionType
from typing import Any

import numpy as np

from ...templates.numba import rows
from ...templates.numba.rows import select
from .constants import DOUBLE, SINGLE

__all__ = ["compiled", "select"]

_MANTISSA = 52  # bits stored of a significand
_MANTISSA_MASK = 2**52 - 1
_BIAS = 1023  # of an exponent
_ONE = 0x3FF0000000000000  # bits of 1
_ROOT_HALF, _ROOT_HALF_32 = 0x3FE6A09E667F3BCD, 0x3FE6A09E60000000  # of sqrt(1/2) in each precision, as float64
_DIGITS = 2.0**52  # an integer or'ed into its low bits is added to it
_SMALLEST = 2.0**-1022  # normal number
_SMALL_SCALE = 54  # subnormal numbers are scaled by this power of two


def constants(x: Any) -> Any:
    """Those of the precision of x. Under numba the tests are decided when it compiles."""
    if isinstance(x, np.float32):
        return SINGLE
    if isinstance(x, float):
        return DOUBLE
    return SINGLE if np.asarray(x).dtype == np.float32 else DOUBLE


def like(value: Any, x: Any) -> Any:
    """A float64 in the precision of x."""
    if isinstance(x, np.float32):
        return np.float32(value)
    if isinstance(x, float):
        return np.float64(value)
    return np.asarray(value).astype(np.asarray(x).dtype)[()]


def bits(x: Any) -> Any:
    """Those of a float64, as an integer."""
    return np.float64(x).view(np.int64)


def _from_bits(i: Any) -> Any:
    return np.int64(i).view(np.float64)


def _word(shifted: Any) -> Any:
    """An integer whose lowest bits are those of a shifted one."""
    return bits(np.float64(shifted - constants(shifted).shifter) + DOUBLE.shifter)


def power_of_two(shifted: Any) -> Any:
    """2^n for a shifted integer n."""
    return like(_from_bits((_word(shifted) << _MANTISSA) + _ONE), shifted)


def is_odd(shifted: Any) -> Any:
    """Whether a shifted integer is odd."""
    return (_word(shifted) & 1) == 1


def change_sign(x: Any, shifted: Any) -> Any:
    """x, or -x where a shifted integer is 2 or 3 modulo 4."""
    return select((_word(shifted) & 2) == 2, -x, x)


def copy_sign(x: Any, y: Any) -> Any:
    """x >= 0 with the sign of y, which zeros have too."""
    return np.copysign(x, y)


def _significand_word(x: Any) -> Any:
    wide = np.float64(x)
    return bits(select(wide < _SMALLEST, wide * 2.0**_SMALL_SCALE, wide)) + (_ONE - _root_half(x))


def _root_half(x: Any) -> Any:
    if isinstance(x, np.float32):
        return _ROOT_HALF_32
    if isinstance(x, float):
        return _ROOT_HALF
    return _ROOT_HALF_32 if np.asarray(x).dtype == np.float32 else _ROOT_HALF


def exponent(x: Any) -> Any:
    """The integer k, as a number, for which x 2^-k lies between sqrt(1/2) and sqrt(2); of positive numbers."""
    number = _from_bits((_significand_word(x) >> _MANTISSA) | bits(_DIGITS))
    return like(number - select(np.float64(x) < _SMALLEST, _DIGITS + (_BIAS + _SMALL_SCALE), _DIGITS + _BIAS), x)


def significand(x: Any) -> Any:
    """x 2^-k for that k."""
    return like(_from_bits((_significand_word(x) & _MANTISSA_MASK) + _root_half(x)), x)


def any_of(mask: Any) -> Any:
    """Whether a condition holds for some of the numbers that are computed at once."""
    return np.any(mask)


def square_root(x: Any) -> Any:
    """Of numbers that are not negative."""
    return np.sqrt(x)


def real(i: Any) -> Any:
    """An integer as a float64."""
    return np.float64(i)


def compiled(decorate: Callable[[Callable[..., Any]], Any]) -> dict[str, Any]:
    """The functions for scalars, each put through `decorate`: see `functions.compiled`."""
    space = {**globals(), "select": rows.compiled(decorate).select}
    own = [n for n, f in globals().items() if isinstance(f, FunctionType) and f.__module__ == __name__]
    for name in own:
        if name != "compiled":
            space[name] = decorate(FunctionType(globals()[name].__code__, space, name))
    return {name: space[name] for name in (*own, "select")}
