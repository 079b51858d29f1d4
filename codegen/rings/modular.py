"""Exact values at random points of F_p^2: the layer that decides what is zero.

p = 2^31 - 1, so that -1 is no square and F_p^2 = F_p[i]; products of two residues fit in 64 bits. Every value
holds its values at many random sample points. Nothing here knows geometric algebra.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from ..errors import TraceError

P = 2**31 - 1
_P = np.uint64(P)
_SHIFT = np.uint64(31)
Residues = NDArray[np.uint64]


def _mod(x: Residues) -> Residues:
    """Residue modulo the Mersenne prime 2^31 - 1, for x < 2^63: shift and add instead of a division.

    The result overwrites x: without new arrays it takes a third of the time.
    """
    high = x >> _SHIFT
    x &= _P
    x += high
    np.right_shift(x, _SHIFT, out=high)
    x &= _P
    x += high
    np.subtract(x, _P, out=high)  # below p it wraps around to a huge number
    np.minimum(x, high, out=x)
    return x


class Samples:
    """Values re + im i in F_p^2; ``im`` is None while every sample point is real, which saves half of the work.

    They are kept in 32 bits, and read as arrays of 64 bits of the reader's own.
    """

    __slots__ = ("_re", "_im")

    def __init__(self, re: Residues, im: Residues | None = None) -> None:
        self._re = re.astype(np.uint32)
        self._im = None if im is None else im.astype(np.uint32)

    @property
    def re(self) -> Residues:
        return self._re.astype(np.uint64)

    @property
    def im(self) -> Residues | None:
        return None if self._im is None else self._im.astype(np.uint64)

    @property
    def is_real(self) -> bool:
        """True where every sample point is real."""
        return self._im is None

    def imaginary(self) -> Residues:
        """Imaginary parts, zeros where the value is real."""
        return np.zeros(self._re.shape, np.uint64) if self._im is None else self._im.astype(np.uint64)

    def is_zero(self) -> NDArray[np.bool_]:
        """Sample points in which the value vanishes."""
        zero: NDArray[np.bool_] = self._re == 0
        return zero if self._im is None else zero & (self._im == 0)


def residue(value: Fraction) -> int:
    """A rational modulo p.

    Raises
    ------
    TraceError
        If it is 0 or infinite there without being so: a multiple of p above or below the line.
    """
    if value.denominator % P == 0 or (value and value.numerator % P == 0):
        raise TraceError(
            f"the constant {value} is a multiple of {P} = 2^31 - 1, the prime of the exact layer; scale it otherwise, "
            "or make it an argument."
        )
    return value.numerator % P * pow(value.denominator, -1, P) % P


def constant(value: Fraction, count: int) -> Samples:
    """The same rational in every sample point."""
    return Samples(np.full(count, residue(value), np.uint64))


def multiply(a: Samples, b: Samples) -> Samples:
    """Product in F_p^2."""
    a_re, a_im, b_re, b_im = a.re, a.im, b.re, b.im
    if a_im is None and b_im is None:
        return Samples(_mod(a_re * b_re))
    if a_im is None:
        return multiply(b, a)
    if b_im is None:
        return Samples(_mod(a_re * b_re), _mod(a_im * b_re))
    re = _mod(_mod(a_re * b_re) + _P - _mod(a_im * b_im))
    return Samples(re, _mod(_mod(a_re * b_im) + _mod(a_im * b_re)))


def combine(terms: Sequence[tuple[Samples, Fraction]]) -> Samples:
    """Sum of values with rational weights: below 2^32 of them, so that the sum is reduced once."""
    re = np.zeros_like(terms[0][0].re)
    im = None if all(value.is_real for value, _ in terms) else np.zeros_like(re)
    for value, weight in terms:
        _add_scaled(re, value.re, weight)
        if im is not None and not value.is_real:
            _add_scaled(im, value.imaginary(), weight)
    return Samples(_mod(re), None if im is None else _mod(im))


def _add_scaled(total: Residues, value: Residues, weight: Fraction) -> None:
    """Add a number below 2^32 that is congruent to the weighted value."""
    if weight == 1:
        total += value
    elif weight == -1:
        total += _P
        total -= value
    else:
        total += _mod(value * np.uint64(residue(weight)))


def _power(x: Residues, exponent: int) -> Residues:
    result = np.ones_like(x)
    while exponent:
        if exponent & 1:
            result = _mod(result * x)
        x = _mod(x * x)
        exponent >>= 1
    return result


def reciprocal(a: Samples) -> tuple[Samples, NDArray[np.bool_]]:
    """1/a, and the sample points in which it exists (zero elsewhere)."""
    alive, re, im = ~a.is_zero(), a.re, a.im
    if im is None:
        return Samples(_power(re, P - 2)), alive
    norm = _power(_mod(_mod(re * re) + _mod(im * im)), P - 2)
    return Samples(_mod(re * norm), _mod((_P - im) % _P * norm)), alive


def sqrt(a: Samples) -> tuple[Samples, NDArray[np.bool_]]:
    """A square root, and the sample points in which one exists in F_p^2.

    For real a it always does: of a or of -a, times i. Otherwise sqrt(x + iy) = u + i y/(2u) with
    u^2 = (x + n)/2 and n^2 = x^2 + y^2; the other sign of n is tried where the first has no root.
    """
    x, y = a.re, a.im
    root = _power(x, (P + 1) // 4)
    real = _mod(root * root) == x
    if y is None:
        zero = np.zeros_like(root)
        return Samples(np.where(real, root, zero), np.where(real, zero, root)), np.ones(x.shape, bool)
    half = np.uint64((P + 1) // 2)
    square = _mod(_mod(x * x) + _mod(y * y))
    norm = _power(square, (P + 1) // 4)
    alive = _mod(norm * norm) == square
    first = _mod(_mod(x + norm) * half)
    u = _power(first, (P + 1) // 4)
    fits = _mod(u * u) == first
    second = _mod(_mod(x + _P - norm) * half)
    v = _power(second, (P + 1) // 4)
    u = np.where(fits, u, v)
    alive &= fits | (_mod(v * v) == second)
    purely_real = y == 0
    inverse = _power(_mod(u * np.uint64(2)), P - 2)
    re, im = u, _mod(y * inverse)
    re = np.where(purely_real, np.where(real, root, 0), re)
    im = np.where(purely_real, np.where(real, 0, root), im)
    alive |= purely_real
    return Samples(re, im), alive


def select(mask: NDArray[np.bool_], a: Samples, b: Samples) -> Samples:
    """a where the mask holds, else b."""
    if a.is_real and b.is_real:
        return Samples(np.where(mask, a.re, b.re))
    return Samples(np.where(mask, a.re, b.re), np.where(mask, a.imaginary(), b.imaginary()))


def opaque(salt: int, arguments: Sequence[Samples]) -> Samples:
    """A value that depends on the arguments' values and on nothing else: a hash, for transcendental functions."""
    state = np.full(arguments[0].re.shape, salt * 0x9E3779B97F4A7C15 % 2**64, np.uint64)
    for value in arguments:
        for part in (value.re, value.imaginary()):
            state = state ^ part
            state = (state ^ (state >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
            state = (state ^ (state >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
            state = state ^ (state >> np.uint64(31))
    return Samples(state % _P)


def comparison_pattern(index: int, count: int) -> NDArray[np.bool_]:
    """Balanced pattern of sample points for the index-th comparison: bits of the number of the point, then a hash.

    The first log2(count) predicates meet in all combinations, so that a select vanishes only if both of its
    branches do.
    """
    samples = np.arange(count, dtype=np.uint64)
    bits = count.bit_length() - 1
    drawn = samples >> np.uint64(index) if index < bits else opaque(index + 1, [Samples(samples)]).re
    return np.asarray(drawn & np.uint64(1) == 1)
