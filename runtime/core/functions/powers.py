"""Powers of multivectors: products for whole numbers, exp and log for all others."""

from __future__ import annotations

from fractions import Fraction
from operator import index
from typing import Any

import numpy as np

from ...codegen.errors import InputError, one_line
from ...common.validation import as_int, real_array
from ..operators import P
from .exponentials import exp, log
from .inverses import inverse

#: Largest whole exponent: powers of more are numbers beyond all.
MAX_POWER = 4096


def power(x: P, exponent: Any, strict: bool = False) -> P:
    """x to the power ``exponent``: a whole number, or numbers that broadcast over the items, by exp and log.

    Raises
    ------
    InputError
        If the exponent is not a real number or an array of them, or a whole one beyond `MAX_POWER`.
    """
    whole = whole_exponent(exponent)
    if whole is None:
        rows = real_array(float(exponent) if isinstance(exponent, Fraction) else exponent, "the exponent")
        return exp(log(x, strict) * rows, strict)
    base = x if whole >= 0 else inverse(x, strict=strict)
    if whole == 0:
        return x._make(x.algebra.type_of(x.algebra.scalar_layout, x.dtype), np.ones((*x._lead, 1), x.dtype), x._lead)
    result = repeated_product(base, abs(whole))
    return result if whole > 0 else x._make(result._type, result._data, result._lead, base._status)


def repeated_product(base: P, count: int) -> P:
    """The product of ``count`` factors, at least one."""
    result, square = None, base
    while True:
        if count & 1:
            result = square if result is None else result * square
        count >>= 1
        if not count:
            break
        square = square * square
    assert result is not None
    return result


def power_of_number(base: Any, exponent: P) -> P:
    """Positive numbers to the power of a multivector: exp(log(base) exponent).

    Raises
    ------
    InputError
        If a base is not a positive number.
    """
    rows = real_array(base, "the base of a power")
    if not (rows > 0).all():
        raise InputError(f"the base of a power is {one_line(base)}; positive numbers have powers of multivectors.")
    return exp(exponent * np.log(rows))  # type: ignore[no-any-return]


def whole_exponent(exponent: Any) -> int | None:
    """A whole number as such, also a float that is one; None of all others.

    Raises
    ------
    InputError
        If its size is beyond `MAX_POWER`.
    """
    whole: int | None
    if isinstance(exponent, bool | np.bool_):
        return None
    if isinstance(exponent, Fraction):
        whole = exponent.numerator if exponent.denominator == 1 else None
    elif isinstance(exponent, float | np.floating) and exponent.is_integer():
        whole = int(exponent)
    else:
        try:
            whole = index(exponent)
        except TypeError:
            return None
    if whole is not None:
        as_int(abs(whole), "the exponent's size", 0, MAX_POWER)
    return whole
