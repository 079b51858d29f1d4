"""The elementary functions of templates/c/elementary.h for numba and NumPy: the same operations, the same bits.

Plain Python on float64: each function takes NumPy arrays as it stands, and scalars once `compiled` has put it through
`numba.njit`. This module never imports numba. Methods: docs/elementary.md; constants: benchmarks/derive_elementary.py.
"""

from __future__ import annotations

from collections.abc import Callable
from types import FunctionType, SimpleNamespace
from typing import Any, TypeAlias

import numpy as np

Value: TypeAlias = Any  # a float64 array, or a scalar inside numba
Mask: TypeAlias = Any  # of bool
Word: TypeAlias = Any  # of int64 or uint64


def _exact(*texts: str) -> tuple[float, ...]:
    return tuple(float.fromhex(text) for text in texts)


# Polynomials, lowest coefficient first, and numbers in parts; named as in the C header.
_SIN = _exact(
    "0x1.5555555555548p-3", "-0x1.111111110f731p-7", "0x1.a01a019be94afp-13", "-0x1.71de355556c26p-19",
    "0x1.ae5e4bae22a78p-26", "-0x1.5d8b651a58f85p-33",
)
_COS = _exact(
    "0x1.555555555554bp-5", "-0x1.6c16c16c15016p-10", "0x1.a01a019c8f4dbp-16", "-0x1.27e4f7f1b6a14p-22",
    "0x1.1ee9dbecb79d9p-29", "-0x1.8fa695c162261p-37",
)
_C2 = _exact(
    "0x1p-1", "-0x1.5555555555555p-5", "0x1.6c16c16c16c17p-10", "-0x1.a01a01a01a09cp-16",
    "0x1.27e4fb778912p-22", "-0x1.1eed8efee4a4dp-29", "0x1.93974af3436b7p-37", "-0x1.ae7f50d06a796p-45",
    "0x1.680dc23b5952ep-53", "-0x1.f2443eb35bd67p-62",
)
_C3 = _exact(
    "0x1.5555555555555p-3", "-0x1.1111111111112p-7", "0x1.a01a01a01a0a3p-13", "-0x1.71de3a556a5bcp-19",
    "0x1.ae64567e6e50cp-26", "-0x1.612461ab4f88bp-33", "0x1.ae7f462b82937p-41", "-0x1.9510d792fddedp-49",
    "0x1.37675e4abc3cp-57",
)
_EXP = _exact(
    "0x1.000000000000ap-1", "0x1.55555555554fap-3", "0x1.55555555508a1p-5", "0x1.1111111127c87p-7",
    "0x1.6c16c1842204bp-10", "0x1.a01a012a0de64p-13", "0x1.a0199a22544f1p-16", "0x1.71df2618d1aeap-19",
    "0x1.28ad5e73bfa76p-22", "0x1.ad7e074c994c5p-26",
)
_LOG = _exact(
    "0x1.5555555555592p-1", "0x1.999999997ff2ep-2", "0x1.24924941df2bdp-2", "0x1.c71c5216af335p-3",
    "0x1.74663c597373p-3", "0x1.39a1f9771520bp-3", "0x1.2f0304c405abdp-3",
)
_ATAN = _exact(
    "0x1.5555555555518p-2", "-0x1.99999999914ddp-3", "0x1.249249216ffb5p-3", "-0x1.c71c709692423p-4",
    "0x1.745cf54f05e76p-4", "-0x1.3b11454a8ac64p-4", "0x1.10f3675c4f2e4p-4", "-0x1.dfed1097f67aep-5",
    "0x1.a3a77f5585f75p-5", "-0x1.571de4fe64645p-5", "0x1.c1fa230e68603p-6", "-0x1.4c27078eb4efbp-7",
)
_HALF_PI = _exact("0x1.921fb5444p+0", "0x1.68c234c4cp-39", "0x1.98a2e03707345p-77")
_LN2 = _exact("0x1.62e42fefap-1", "0x1.cf79abc9ep-40", "0x1.d9cc01f97b57ap-79")
_LN2_PAIR = _exact("0x1.62e42fefa38p-1", "0x1.ef35793c7673p-45")
_QUARTER_PI = _exact("0x1.921fb54442d18p-1", "0x1.1a62633145c07p-55")
_PER_HALF_PI = _exact("0x1.45f306dc9c883p-1")
_PER_LN2 = _exact("0x1.71547652b82fep+0")

_NEAR = 102943.0  # 65536 half pi, less a little: up to here products reduce
_SHIFTER = 1.5 * 2.0**52  # added and taken off again, rounds to an integer
_SPLITTER = 2.0**27 + 1.0  # cuts a significand into halves
_LARGEST = float(np.finfo(np.float64).max)
_SMALLEST = float(np.finfo(np.float64).tiny)
_MANTISSA = 52  # bits stored of a significand
_BIAS = 1023  # of an exponent
_SMALL_SCALE = 54  # subnormal numbers are scaled by this power of two
_ONE = 0x3FF0000000000000  # bits of 1
_ROOT_HALF = 0x3FE6A09E667F3BCD  # bits of sqrt(1/2)
_SIGN_BIT = -(2**63)
_EXP_LARGEST, _EXP_SMALLEST = 710.0, -746.0  # beyond: infinity, zero
_SINH_LARGEST = 711.0  # beyond: infinity
_FORGET = 64.0  # exp(-x) is nothing beside exp(x) from 2^64 on
_STUMPFF_BELOW, _STUMPFF_ABOVE = -4.0, 1.5  # between: polynomials in w itself
_HALF_PI_FIRST, _HALF_PI_REST = _exact("0x1.921fb54442d18p+0", "0x1.1a62633145c07p-54")
_HALF_PI_HALVES = _exact("0x1.921fb5p+0", "0x1.110b46p-26")  # of the first part

# Places of 2/pi after the point, 64 in each word, after a word of zeros.
_TWO_OVER_PI = np.array(
    [
        0x0000000000000000, 0xA2F9836E4E441529, 0xFC2757D1F534DDC0, 0xDB6295993C439041,
        0xFE5163ABDEBBC561, 0xB7246E3A424DD2E0, 0x06492EEA09D1921C, 0xFE1DEB1CB129A73E,
        0xE88235F52EBB4484, 0xE99C7026B45F7E41, 0x3991D639835339F4, 0x9C845F8BBDF9283B,
        0x1FF897FFDE05980F, 0xEF2F118B5A0A6D1F, 0x6D367ECF27CB09B7, 0x4F463F669E5FEA2D,
        0x7527BAC7EBE5F17B, 0x3D0739F78A5292EA, 0x6BFB5FB11F8D5D08, 0x56033046FC7B6BAB,
    ],
    dtype=np.uint64,
)
_LOW32, _U1, _U32, _U31, _U61, _U62, _U63 = (np.uint64(n) for n in (2**32 - 1, 1, 32, 31, 61, 62, 63))
_LOW31, _HALF_TURN, _ZERO = np.uint64(2**31 - 1), np.uint64(2**61), np.uint64(0)


def _select(mask: Mask, a: Value, b: Value) -> Value:
    return np.where(mask, a, b)


def _any(mask: Mask) -> Any:
    return np.any(mask)


def _select_scalar(mask: Mask, a: Value, b: Value) -> Value:
    return a if mask else b


def _any_scalar(mask: Mask) -> Any:
    return mask


def _bits(x: Value) -> Word:
    return np.float64(x).view(np.int64)


def _from_bits(i: Word) -> Value:
    return np.int64(i).view(np.float64)


def _horner(z: Value, terms: tuple[float, ...]) -> Value:
    square = z * z
    last, other = terms[-1], terms[-2]
    for i in range(len(terms) - 3, -1, -1):
        last, other = other, last * square + terms[i]
    return other + last * z


def _power_of_two(shifted: Value) -> Value:
    return _from_bits((_bits(shifted) << _MANTISSA) + _ONE)


def _change_sign(x: Value, word: Word) -> Value:
    return _from_bits(_bits(x) ^ ((word & 2) << 62))


def _with_sign_of(x: Value, y: Value) -> Value:
    return _from_bits(_bits(x) | (_bits(y) & _SIGN_BIT))


def _reduce_by(x: Value, n: Value, step: tuple[Value, Value, Value], tail: Value) -> tuple[Value, Value]:
    """(high, low) with high - low = x + tail - n step, to about twice the precision."""
    rest = x - n * step[0]
    product = n * step[1]
    high = rest - product
    lost = (rest - high) - product
    correction = (n * step[2] - lost) - tail
    result = high - correction
    return result, correction - (high - result)


def _upper_product(a: Word, b: Word) -> Word:
    cross = (a >> _U32) * (b & _LOW32) + (((a & _LOW32) * (b & _LOW32)) >> _U32)
    return (a >> _U32) * (b >> _U32) + (cross >> _U32) + (((a & _LOW32) * (b >> _U32) + (cross & _LOW32)) >> _U32)


def _reduce_far(x: Value, far: Mask) -> tuple[Value, Value, Word]:
    """(high, low, quadrant) by as many places of 2/pi as it takes; of use where far."""
    size = np.abs(_select(far, x, _NEAR))
    size = _select(size <= _LARGEST, size, _NEAR)
    word = _bits(size)
    m = np.uint64((word & 0xFFFFFFFFFFFFF) | 0x10000000000000)
    place = (word >> _MANTISSA) - (_BIAS + _MANTISSA + 2 - 64)
    first, shift = place >> 6, np.uint64(place & 63)
    here, next1, next2, next3 = (
        _TWO_OVER_PI[first],
        _TWO_OVER_PI[first + 1],
        _TWO_OVER_PI[first + 2],
        _TWO_OVER_PI[first + 3],
    )
    back = _U63 - shift
    word0 = (here << shift) | ((next1 >> _U1) >> back)
    word1 = (next1 << shift) | ((next2 >> _U1) >> back)
    word2 = (next2 << shift) | ((next3 >> _U1) >> back)

    carried = _upper_product(m, word2)
    fraction = m * word1 + carried
    top = m * word0 + _upper_product(m, word1) + _select(fraction < carried, _U1, _ZERO)
    quadrant = (top + _HALF_TURN) >> _U62
    top = top - (quadrant << _U62)
    negative = (top >> _U63) == _U1
    opposite = ~fraction + _U1
    top = _select(negative, ~top + _select(opposite == _ZERO, _U1, _ZERO), top)
    fraction = _select(negative, opposite, fraction)
    a = np.float64(np.int64(top >> _U31)) * 2.0**-31
    b = np.float64(np.int64(top & _LOW31)) * 2.0**-62
    c = np.float64(np.int64(fraction >> _U32)) * 2.0**-94
    c = c + np.float64(np.int64(fraction & _LOW32)) * 2.0**-126
    total = a + b
    rest = ((a - total) + b) + c
    f = total + rest
    f_rest = (total - f) + rest

    cut = f * _SPLITTER
    f_1 = cut - (cut - f)
    f_2 = f - f_1
    product = f * _HALF_PI_FIRST
    half_1, half_2 = _HALF_PI_HALVES
    error = ((f_1 * half_1 - product) + f_1 * half_2 + f_2 * half_1) + f_2 * half_2
    error = error + (f * _HALF_PI_REST + f_rest * _HALF_PI_FIRST)
    high = product + error
    low = (high - product) - error
    flip = negative ^ (x < 0.0)
    wrong = ~(np.abs(x) <= _LARGEST)  # infinity, NaN
    turns = np.int64(quadrant)
    return (
        _select(wrong, x - x, _select(flip, -high, high)),
        _select(wrong, x - x, _select(flip, -low, low)),
        _select(x < 0.0, -turns, turns),
    )


def sincos(x: Value) -> tuple[Value, Value]:
    """(sine, cosine) of x, at most 1 ulp off."""
    x = np.float64(x)
    shifted = x * _PER_HALF_PI[0] + _SHIFTER
    quadrant = _bits(shifted)
    r, low = _reduce_by(x, shifted - _SHIFTER, _HALF_PI, 0.0)
    far = np.abs(x) > _NEAR
    if _any(far):
        far_r, far_low, far_quadrant = _reduce_far(x, far)
        r, low = _select(far, far_r, r), _select(far, far_low, low)
        quadrant = _select(far, far_quadrant, quadrant)
    z = r * r
    half = 0.5 * z
    most = 1.0 - half
    s = r - ((r * z) * _horner(z, _SIN) + low * most)
    c = most + (((1.0 - most) - half) + ((z * z) * _horner(z, _COS) + r * low))
    odd = (quadrant & 1) == 1
    return _change_sign(_select(odd, c, s), quadrant), _change_sign(_select(odd, s, c), quadrant + 1)


def sin(x: Value) -> Value:
    """Sine."""
    return sincos(x)[0]


def cos(x: Value) -> Value:
    """Cosine."""
    return sincos(x)[1]


def exp(x: Value) -> Value:
    """Exponential function."""
    x = np.float64(x)
    x = _select(x > _EXP_LARGEST, _EXP_LARGEST, x)
    x = _select(x < _EXP_SMALLEST, _EXP_SMALLEST, x)
    n = (x * _PER_LN2[0] + _SHIFTER) - _SHIFTER
    head = x - n * _LN2_PAIR[0]
    product = n * _LN2_PAIR[1]
    r = head - product
    low = (head - r) - product
    value = 1.0 + (r + ((r * r) * _horner(r, _EXP) + low))
    shifted = n * 0.5 + _SHIFTER
    other = (n - (shifted - _SHIFTER)) + _SHIFTER
    return value * _power_of_two(shifted) * _power_of_two(other)


def log(x: Value) -> Value:
    """Natural logarithm: -inf at zero, NaN below."""
    x = np.float64(x)
    tiny = x < _SMALLEST
    word = _bits(_select(tiny, x * 2.0**_SMALL_SCALE, x)) + (_ONE - _ROOT_HALF)
    digits = 2.0**_MANTISSA
    number = _from_bits((word >> _MANTISSA) | _bits(digits))
    k = number - _select(tiny, digits + (_BIAS + _SMALL_SCALE), digits + _BIAS)
    f = _from_bits((word & 0xFFFFFFFFFFFFF) + _ROOT_HALF) - 1.0
    s = f / (f + 2.0)
    z = s * s
    half = 0.5 * f * f
    bent = s * (half + z * _horner(z, _LOG))
    value = k * _LN2_PAIR[0] - ((half - (bent + k * _LN2_PAIR[1])) - f)
    value = _select(x <= _LARGEST, value, x)
    value = _select(x == 0.0, -np.inf, value)
    return _select(x < 0.0, np.nan, value)


def _from_powers(n: Value, r: Value, c: Value, s: Value) -> tuple[Value, Value]:
    """(cosh, sinh) of n ln2 + r, where cosh r = 1 + c and sinh r = r + s."""
    kept = _select(n > _FORGET, _FORGET, n)
    grown = (1.0 + (r + (c + s))) * _power_of_two((n - 4.0) + _SHIFTER)
    shrunk = (1.0 - (r - (c - s))) * _power_of_two((-4.0 - kept) + _SHIFTER)
    return 8.0 * (grown + shrunk), 8.0 * (grown - shrunk)


def sinhcosh(x: Value) -> tuple[Value, Value]:
    """Hyperbolic sine and cosine."""
    x = np.float64(x)
    size = np.abs(x)
    size = _select(size > _SINH_LARGEST, _SINH_LARGEST, size)
    near = size < 1.0
    n = _select(near, 0.0, (size * _PER_LN2[0] + _SHIFTER) - _SHIFTER)
    r, low = _reduce_by(size, n, _LN2, 0.0)
    z = r * r
    c = z * _horner(-z, _C2) - r * low
    s = r * (z * _horner(-z, _C3)) - low * (1.0 + c)
    far_cosh, far_sinh = _from_powers(n, r, c, s)
    return _with_sign_of(_select(near, r + s, far_sinh), x), _select(near, 1.0 + c, far_cosh)


def sinh(x: Value) -> Value:
    """Hyperbolic sine."""
    return sinhcosh(x)[0]


def cosh(x: Value) -> Value:
    """Hyperbolic cosine."""
    return sinhcosh(x)[1]


def atan2(y: Value, x: Value) -> Value:
    """Angle of the point (x, y), in [-pi, pi]."""
    y, x = np.float64(y), np.float64(x)
    width, height = np.abs(x), np.abs(y)
    swap, left = height > width, _bits(x) < 0
    big, small = _select(swap, height, width), _select(swap, width, height)
    scale = _select(big > 0.25 * _LARGEST, 0.25, 1.0)
    diagonal = (small > 0.5 * big) | (small > _LARGEST)
    big, small = big * scale, small * scale
    above, below = _select(diagonal, small - big, small), _select(diagonal, small + big, big)
    plain = (below > 0.0) & (below <= _LARGEST)
    q = _select(plain, above / below, 0.0)
    backward = swap ^ left
    eighths = _select(diagonal, 1.0, 0.0)
    eighths = _select(backward, -eighths, eighths) + _select(swap, 2.0, _select(left, 4.0, 0.0))
    z = q * q
    bend = (q * z) * _horner(z, _ATAN)
    q, bend = _select(backward, -q, q), _select(backward, -bend, bend)
    angle = eighths * _QUARTER_PI[0] + (q + (eighths * _QUARTER_PI[1] - bend))
    return _select((x != x) | (y != y), x + y, _with_sign_of(angle, y))


def stumpff(w: Value) -> tuple[Value, Value, Value, Value]:
    """(c0, c1, c2, c3) of w, c_k(w) = sum over n of (-w)^n / (2n + k)!."""
    w = np.float64(w)
    lowest = -_SINH_LARGEST * _SINH_LARGEST
    w = _select(w < lowest, lowest, w)
    hyperbolic, near = w < 0.0, (w > _STUMPFF_BELOW) & (w < _STUMPFF_ABOVE)
    size = np.abs(w)
    root = np.sqrt(size)
    inverse = 1.0 / root
    far = root > _NEAR

    cut = root * _SPLITTER
    first = cut - (cut - root)
    second = root - first
    square = root * root
    error = ((first * first - square) + 2.0 * first * second) + second * second
    tail = _select(far, 0.0, ((size - square) - error) * (0.5 * inverse))

    step = (
        _select(hyperbolic, _LN2[0], _HALF_PI[0]),
        _select(hyperbolic, _LN2[1], _HALF_PI[1]),
        _select(hyperbolic, _LN2[2], _HALF_PI[2]),
    )
    shifted = root * _select(hyperbolic, _PER_LN2[0], _PER_HALF_PI[0]) + _SHIFTER
    n = shifted - _SHIFTER
    quadrant = _bits(shifted)
    r, low = _reduce_by(root, n, step, tail)
    if _any(far):
        far_r, far_low, far_quadrant = _reduce_far(root, far)
        r, low = _select(far, far_r, r), _select(far, far_low, low)
        quadrant = _select(far, far_quadrant, quadrant)

    signed_r = _select(hyperbolic, -r, r)
    z = _select(near, w, signed_r * r)
    bend = _select(near, 0.0, signed_r * low)
    near2, near3 = _horner(z, _C2), _horner(z, _C3)
    z3 = z * near3
    less = z * near2 - bend
    c = 1.0 - less
    bent = r * z3 + low * c
    s = r - bent
    odd = (quadrant & 1) == 1
    far0 = _change_sign(_select(odd, s, c), quadrant + 1)
    far1 = _change_sign(_select(odd, c, s), quadrant)
    cosh_root, sinh_root = _from_powers(n, r, -less, -bent)
    far0 = _select(hyperbolic, cosh_root, far0)
    far1 = _select(hyperbolic, sinh_root, far1) * inverse
    turned = ~hyperbolic & (far0 > 0.0)
    far2 = _select(turned, far1 * far1, 1.0 - far0) / _select(turned, 1.0 + far0, w)
    return (
        _select(near, c, far0),
        _select(near, 1.0 - z3, far1),
        _select(near, near2, far2),
        _select(near, near3, (1.0 - far1) / w),
    )


def stumpff0(w: Value) -> Value:
    """c0: cos sqrt(w), cosh sqrt(-w)."""
    return stumpff(w)[0]


def stumpff1(w: Value) -> Value:
    """c1: sin sqrt(w) / sqrt(w), sinh sqrt(-w) / sqrt(-w)."""
    return stumpff(w)[1]


def stumpff2(w: Value) -> Value:
    """c2: (1 - c0(w)) / w."""
    return stumpff(w)[2]


def stumpff3(w: Value) -> Value:
    """c3: (1 - c1(w)) / w."""
    return stumpff(w)[3]


_HELPERS = (
    "_bits _from_bits _horner _power_of_two _change_sign _with_sign_of _reduce_by _upper_product _reduce_far _from_powers"
).split()
NAMES = (
    "sincos sin cos exp log sinhcosh sinh cosh atan2 stumpff stumpff0 stumpff1 stumpff2 stumpff3"
).split()
"""The public functions; each one calls only those before it."""


def compiled(decorate: Callable[[Callable[..., Any]], Callable[..., Any]]) -> SimpleNamespace:
    """The functions for scalars, each put through `decorate`.

    Parameters
    ----------
    decorate
        `numba.njit(error_model="numpy")`, or the identity. The error model matters: both branches of a selection
        run, and one of them may divide by zero.

    Returns
    -------
    SimpleNamespace
        With one attribute per name in `NAMES`. They call each other's decorated forms.
    """
    space = dict(globals())
    space["_select"], space["_any"] = decorate(_select_scalar), decorate(_any_scalar)
    for name in [*_HELPERS, *NAMES]:
        plain = globals()[name]
        space[name] = decorate(FunctionType(plain.__code__, space, name, plain.__defaults__))
    return SimpleNamespace(**{name: space[name] for name in NAMES})
