"""Reduction of one very large angle, in float64 and integers of 64 bits; see functions.py."""

from __future__ import annotations

from typing import Any, TypeAlias

from .constants import HALF_PI, HALF_PI_HALVES
from .machine import bits, real, select

#: Types of the language, which the reader puts in their places.
Real: TypeAlias = Any
Words: TypeAlias = Any

_SPLITTER = 2.0**27 + 1.0
_LARGEST = 1.7976931348623157e308
_LOW_27, _LOW_31, _LOW_32 = 2**27 - 1, 2**31 - 1, 2**32 - 1


def times_half_pi(f: Real, f_rest: Real) -> tuple[Real, Real]:
    """(high, low): high - low = (f + f_rest) pi/2, in float64."""
    cut = f * _SPLITTER
    f_1 = cut - (cut - f)
    f_2 = f - f_1
    product = f * HALF_PI[0]
    half_1, half_2 = HALF_PI_HALVES[0], HALF_PI_HALVES[1]
    error = ((f_1 * half_1 - product) + f_1 * half_2 + f_2 * half_1) + f_2 * half_2
    error = error + (f * HALF_PI[1] + f_rest * HALF_PI[0])
    high = product + error
    return high, (high - product) - error


def reduce_far(x: Real, places: Words) -> tuple[Real, Real, Real]:
    """(high, low, quadrant) of one large number, in float64: exact, times those 192 places of 2/pi that matter.

    x = m 2^e with an integer m. m in two parts times six words of 32 places, modulo 4, cut off 126 places after the
    point; then times pi/2 in two parts (Payne and Hanek).
    """
    size = abs(x)
    finite = size <= _LARGEST
    word = bits(select(finite & (size >= 1.0), size, 1e5))
    m = (word & (2**52 - 1)) | 2**52
    upper, lower = m >> 27, m & _LOW_27
    place = (word >> 52) - (1023 + 52 + 2 - 64)  # of the first digit that matters; the words of zeros count
    first, shift = place >> 5, place & 31
    back = 32 - shift
    t0 = ((places[first] << shift) | (places[first + 1] >> back)) & _LOW_32
    t1 = ((places[first + 1] << shift) | (places[first + 2] >> back)) & _LOW_32
    t2 = ((places[first + 2] << shift) | (places[first + 3] >> back)) & _LOW_32
    t3 = ((places[first + 3] << shift) | (places[first + 4] >> back)) & _LOW_32
    t4 = ((places[first + 4] << shift) | (places[first + 5] >> back)) & _LOW_32
    t5 = ((places[first + 5] << shift) | (places[first + 6] >> back)) & _LOW_32
    d5 = lower * t5 + ((upper * t5 & 31) << 27)
    d4 = lower * t4 + ((upper * t4 & 31) << 27) + (upper * t5 >> 5) + (d5 >> 32)
    d3 = lower * t3 + ((upper * t3 & 31) << 27) + (upper * t4 >> 5) + (d4 >> 32)
    d2 = lower * t2 + ((upper * t2 & 31) << 27) + (upper * t3 >> 5) + (d3 >> 32)
    d1 = lower * t1 + ((upper * t1 & 31) << 27) + (upper * t2 >> 5) + (d2 >> 32)
    d0 = lower * t0 + ((upper * t0 & 31) << 27) + (upper * t1 >> 5) + (d1 >> 32)
    d0, d1, d2, d3 = d0 & _LOW_32, d1 & _LOW_32, d2 & _LOW_32, d3 & _LOW_32
    quadrant = (d0 + 2**29) >> 30
    d0 = d0 - (quadrant << 30)  # now signed: the fraction lies in [-1/2, 1/2)
    n3 = -d3
    n2 = (n3 >> 32) - d2
    n1 = (n2 >> 32) - d1
    negative = d0 < 0
    d0 = select(negative, (n1 >> 32) - d0, d0)
    d1 = select(negative, n1 & _LOW_32, d1)
    d2 = select(negative, n2 & _LOW_32, d2)
    d3 = select(negative, n3 & _LOW_32, d3)
    a = real((d0 << 1) | (d1 >> 31)) * 2.0**-31
    b = real(d1 & _LOW_31) * 2.0**-62
    rest = real(d2) * 2.0**-94 + real(d3) * 2.0**-126
    total = a + b
    rest = ((a - total) + b) + rest
    f = total + rest
    high, low = times_half_pi(f, (total - f) + rest)
    flip = negative ^ (x < 0.0)
    turns = real(quadrant)
    return (
        select(finite, select(flip, -high, high), x - x),
        select(finite, select(flip, -low, low), x - x),
        select(x < 0.0, -turns, turns),
    )
