"""The elementary functions of templates/c/lib/elementary.h in plain Python: the same operations, the same bits.

Each function takes NumPy arrays and scalars, float64 or float32, as it stands, and scalars of either kind once
`compiled` has put it through numba, which is never imported here. NumPy warns of the branches not taken.
Methods: docs/elementary.md.
"""

from __future__ import annotations

from collections.abc import Callable
from types import FunctionType, SimpleNamespace
from typing import Any

import numpy as np

from . import rows
from .elementary_constants import DOUBLE, HALF_PI, HALF_PI_HALVES, SINGLE, TWO_OVER_PI
from .rows import select

_SHIFTER = 1.5 * 2.0**52
_SPLITTER = 2.0**27 + 1.0
_MANTISSA = 52  # bits stored of a float64's significand
_MANTISSA_MASK = 2**52 - 1
_BIAS = 1023  # of its exponent
_ONE = 0x3FF0000000000000  # bits of 1
_DIGITS = 2.0**52  # an integer or'ed into its low bits is added to it
_SMALLEST = 2.0**-1022  # normal number
_SMALL_SCALE = 54  # subnormal numbers are scaled by this power of two
_FAR_RANGE = 1e5, 1.7976931348623157e308  # what _reduce_far is made for, and a little beyond
_U0, _U1, _U31, _U32, _U61, _U62, _U63 = (np.uint64(n) for n in (0, 1, 31, 32, 61, 62, 63))
_LOW31, _LOW32, _HALF_TURN = np.uint64(2**31 - 1), np.uint64(2**32 - 1), np.uint64(2**61)


def _constants(x: Any) -> Any:
    """Those of the precision of x. Under numba the tests are decided when it compiles."""
    if isinstance(x, np.float32):
        return SINGLE
    if isinstance(x, float):
        return DOUBLE
    return SINGLE if np.asarray(x).dtype == np.float32 else DOUBLE


def _like(value: Any, x: Any) -> Any:
    """A float64 in the precision of x."""
    if isinstance(x, np.float32):
        return np.float32(value)
    if isinstance(x, float):
        return np.float64(value)
    return np.asarray(value).astype(np.asarray(x).dtype)[()]


def _bits(x: Any) -> Any:
    return np.float64(x).view(np.int64)


def _from_bits(i: Any) -> Any:
    return np.int64(i).view(np.float64)


def _polynomial(z: Any, terms: Any) -> Any:
    square = z * z
    last, other = terms[-1], terms[-2]
    for i in range(len(terms) - 3, -1, -1):
        last, other = other, last * square + terms[i]
    return other + last * z


def _power_of_two(n: Any) -> Any:
    """2^n in the precision of n, an integer."""
    return _like(_from_bits((_bits(np.float64(n) + _SHIFTER) << _MANTISSA) + _ONE), n)


def _quadrant(n: Any) -> Any:
    """An integer whose lowest bits are those of n."""
    return _bits(np.float64(n) + _SHIFTER)


def _change_sign(x: Any, word: Any) -> Any:
    return select((word & 2) == 2, -x, x)


def _reduce_by(x: Any, n: Any, step: Any, tail: Any, c: Any) -> Any:
    """(high, low) with high - low = x + tail - n step, to about twice the precision."""
    rest = x - n * step[0]
    product = n * step[1]
    high = rest - product
    lost = (rest - high) - product
    if c.half_pi[3] == 0.0:  # three parts are enough
        correction = (n * step[2] - lost) - tail
    else:
        rest = high
        product = n * step[2]
        high = rest - product
        lost = lost + ((rest - high) - product)
        correction = (n * step[3] - lost) - tail
    result = high - correction
    return result, correction - (high - result)


def _upper_product(a: Any, b: Any) -> Any:
    cross = (a >> _U32) * (b & _LOW32) + (((a & _LOW32) * (b & _LOW32)) >> _U32)
    rest = ((a & _LOW32) * (b >> _U32) + (cross & _LOW32)) >> _U32
    return (a >> _U32) * (b >> _U32) + (cross >> _U32) + rest


def _two_over_pi(size: Any) -> Any:
    """A float64's significand, and the 192 places of 2/pi that matter when it is multiplied, in three words."""
    word = _bits(size)
    place = (word >> _MANTISSA) - (_BIAS + _MANTISSA + 2 - 64)
    first, shift = place >> 6, np.uint64(place & 63)
    back = _U63 - shift
    w0, w1 = TWO_OVER_PI[first], TWO_OVER_PI[first + 1]
    w2, w3 = TWO_OVER_PI[first + 2], TWO_OVER_PI[first + 3]
    return (
        np.uint64((word & _MANTISSA_MASK) | (_MANTISSA_MASK + 1)),
        (w0 << shift) | ((w1 >> _U1) >> back),
        (w1 << shift) | ((w2 >> _U1) >> back),
        (w2 << shift) | ((w3 >> _U1) >> back),
    )


def _times_half_pi(f: Any, f_rest: Any) -> Any:
    """(high, low) with high - low = (f + f_rest) pi/2."""
    cut = f * _SPLITTER
    f_1 = cut - (cut - f)
    f_2 = f - f_1
    product = f * HALF_PI[0]
    half_1, half_2 = HALF_PI_HALVES
    error = ((f_1 * half_1 - product) + f_1 * half_2 + f_2 * half_1) + f_2 * half_2
    error = error + (f * HALF_PI[1] + f_rest * HALF_PI[0])
    high = product + error
    return high, (high - product) - error


def _reduce_far(x: Any) -> Any:
    """(high, low, quadrant) of an angle by as many places of 2/pi as it takes, for large |x|."""
    wide = np.float64(x)
    size = np.abs(wide)
    finite = size <= _FAR_RANGE[1]
    m, word0, word1, word2 = _two_over_pi(select(finite & (size >= 1.0), size, _FAR_RANGE[0]))
    carried = _upper_product(m, word2)
    fraction = m * word1 + carried
    top = m * word0 + _upper_product(m, word1) + select(fraction < carried, _U1, _U0)
    quadrant = (top + _HALF_TURN) >> _U62
    top = top - (quadrant << _U62)
    negative = (top >> _U63) == _U1
    opposite = ~fraction + _U1
    top = select(negative, ~top + select(opposite == _U0, _U1, _U0), top)
    fraction = select(negative, opposite, fraction)
    a = np.float64(np.int64(top >> _U31)) * 2.0**-31
    b = np.float64(np.int64(top & _LOW31)) * 2.0**-62
    c = np.float64(np.int64(fraction >> _U32)) * 2.0**-94
    c = c + np.float64(np.int64(fraction & _LOW32)) * 2.0**-126
    total = a + b
    rest = ((a - total) + b) + c
    f = total + rest
    most, low = _times_half_pi(f, (total - f) + rest)
    flip = negative ^ (wide < 0.0)
    most = select(finite, select(flip, -most, most), wide - wide)
    low = select(finite, select(flip, -low, low), wide - wide)
    high = _like(most, x)
    turns = np.int64(quadrant)
    return high, _like((np.float64(high) - most) + low, x), select(wide < 0.0, -turns, turns)


def _far_or_near(x: Any, far: Any, high: Any, low: Any, quadrant: Any) -> Any:
    """(high, low, quadrant), reduced anew where far."""
    if not np.any(far):
        return high, low, quadrant
    other_high, other_low, other_quadrant = _reduce_far(x)
    return select(far, other_high, high), select(far, other_low, low), select(far, other_quadrant, quadrant)


def sincos(x: Any) -> Any:
    """(sine, cosine) of x, at most 1 ulp off."""
    c = _constants(x)
    n = (x * c.per_half_pi + c.shifter) - c.shifter
    r, low = _reduce_by(x, n, c.half_pi, c.zero, c)
    r, low, quadrant = _far_or_near(x, np.abs(x) > c.near, r, low, _quadrant(n))
    z = r * r
    half = c.half * z
    most = c.one - half
    sine = r - ((r * z) * _polynomial(z, c.sine) + low * most)
    cosine = most + (((c.one - most) - half) + ((z * z) * _polynomial(z, c.cosine) + r * low))
    odd = (quadrant & 1) == 1
    return (
        _change_sign(select(odd, cosine, sine), quadrant),
        _change_sign(select(odd, sine, cosine), quadrant + 1),
    )


def sin(x: Any) -> Any:
    """Sine."""
    return sincos(x)[0]


def cos(x: Any) -> Any:
    """Cosine."""
    return sincos(x)[1]


def exp(x: Any) -> Any:
    """Exponential function, at most 1 ulp off."""
    c = _constants(x)
    x = select(x > c.exp_range[1], c.exp_range[1], x)
    x = select(x < c.exp_range[0], c.exp_range[0], x)
    n = (x * c.per_ln2 + c.shifter) - c.shifter
    head = x - n * c.ln2_pair[0]
    product = n * c.ln2_pair[1]
    r = head - product
    low = (head - r) - product
    value = c.one + (r + ((r * r) * _polynomial(r, c.exponential) + low))
    first = (n * c.half + c.shifter) - c.shifter
    return value * _power_of_two(first) * _power_of_two(n - first)


def log(x: Any) -> Any:
    """Natural logarithm, at most 1 ulp off: -inf at zero, NaN below."""
    c = _constants(x)
    wide = np.float64(x)
    tiny = wide < _SMALLEST
    word = _bits(select(tiny, wide * 2.0**_SMALL_SCALE, wide)) + (_ONE - c.root_half)
    number = _from_bits((word >> _MANTISSA) | _bits(_DIGITS))
    k = _like(number - select(tiny, _DIGITS + (_BIAS + _SMALL_SCALE), _DIGITS + _BIAS), x)
    f = _like(_from_bits((word & _MANTISSA_MASK) + c.root_half) - 1.0, x)
    s = f / (f + c.two)
    z = s * s
    half = c.half * f * f
    bent = s * (half + z * _polynomial(z, c.logarithm))
    value = k * c.ln2_pair[0] - ((half - (bent + k * c.ln2_pair[1])) - f)
    value = select(x <= c.largest, value, x)
    value = select(x == c.zero, -c.infinity, value)
    return select(x < c.zero, c.nan, value)


def _from_powers(n: Any, r: Any, a: Any, b: Any, c: Any) -> Any:
    """(cosh, sinh) of n ln2 + r, where cosh r = 1 + a and sinh r = r + b."""
    kept = select(n > c.forget, c.forget, n)
    grown = (c.one + (r + (a + b))) * _power_of_two(n - c.four)
    shrunk = (c.one - (r - (a - b))) * _power_of_two(-c.four - kept)
    return c.eight * (grown + shrunk), c.eight * (grown - shrunk)


def sinhcosh(x: Any) -> Any:
    """(hyperbolic sine, hyperbolic cosine), at most 2 ulp off."""
    c = _constants(x)
    size = np.abs(x)
    size = select(size > c.sinh_largest, c.sinh_largest, size)
    near = size < c.one
    n = select(near, c.zero, (size * c.per_ln2 + c.shifter) - c.shifter)
    r, low = _reduce_by(size, n, c.ln2, c.zero, c)
    z = r * r
    a = z * (c.half + z * _polynomial(-z, c.stumpff4)) - r * low
    b = r * (z * (c.sixth + z * _polynomial(-z, c.stumpff5))) - low * (c.one + a)
    far_cosh, far_sinh = _from_powers(n, r, a, b, c)
    return np.copysign(select(near, r + b, far_sinh), x), select(near, c.one + a, far_cosh)


def sinh(x: Any) -> Any:
    """Hyperbolic sine."""
    return sinhcosh(x)[0]


def cosh(x: Any) -> Any:
    """Hyperbolic cosine."""
    return sinhcosh(x)[1]


def atan2(y: Any, x: Any) -> Any:
    """Angle of the point (x, y) in [-pi, pi], at most 2 ulp off."""
    c = _constants(x)
    width, height = np.abs(x), np.abs(y)
    swap, left = height > width, np.signbit(x)
    big, small = select(swap, height, width), select(swap, width, height)
    scale = select(big > c.largest * c.quarter, c.quarter, c.one)
    diagonal = (small > c.half * big) | (small > c.largest)
    big, small = big * scale, small * scale
    above, below = select(diagonal, small - big, small), select(diagonal, small + big, big)
    q = select((below > c.zero) & (below <= c.largest), above / below, c.zero)
    backward = swap ^ left
    eighths = select(diagonal, c.one, c.zero)
    eighths = select(backward, -eighths, eighths) + select(swap, c.two, select(left, c.four, c.zero))
    z = q * q
    bend = (q * z) * _polynomial(z, c.arctangent)
    q, bend = select(backward, -q, q), select(backward, -bend, bend)
    angle = eighths * c.quarter_pi[0] + (q + (eighths * c.quarter_pi[1] - bend))
    return select((x != x) | (y != y), x + y, np.copysign(angle, y))


def _root(size: Any, c: Any) -> Any:
    """(root, rest): the square root of size is root (1 + rest), to about twice the precision."""
    root = np.sqrt(size)
    cut = root * c.splitter
    first = cut - (cut - root)
    second = root - first
    square = root * root
    error = ((first * first - square) + c.two * first * second) + second * second
    return root, ((size - square) - error) / (c.two * size)


def _stumpff_six(w: Any, c: Any) -> Any:
    """(c0, .., c5) of w, the last two not as good as they should be."""
    lowest = -c.sinh_largest * c.sinh_largest
    w = select(w < lowest, lowest, w)
    hyperbolic, near = w < c.zero, (w > c.below) & (w < c.above)
    root, relative_tail = _root(np.abs(w), c)
    far = root > c.near
    tail = select(far, c.zero, root * relative_tail)
    step = (
        select(hyperbolic, c.ln2[0], c.half_pi[0]),
        select(hyperbolic, c.ln2[1], c.half_pi[1]),
        select(hyperbolic, c.ln2[2], c.half_pi[2]),
        select(hyperbolic, c.ln2[3], c.half_pi[3]),
    )
    n = (root * select(hyperbolic, c.per_ln2, c.per_half_pi) + c.shifter) - c.shifter
    r, low = _reduce_by(root, n, step, tail, c)
    r, low, quadrant = _far_or_near(root, far, r, low, _quadrant(n))

    signed_r = select(hyperbolic, -r, r)
    z = select(near, w, signed_r * r)
    bend = select(near, c.zero, signed_r * low)
    near4, near5 = _polynomial(z, c.stumpff4), _polynomial(z, c.stumpff5)
    near2, near3 = c.half - z * near4, c.sixth - z * near5
    z3 = z * near3
    less = z * near2 - bend
    cosine = c.one - less
    bent = r * z3 + low * cosine
    sine = r - bent
    odd = (quadrant & 1) == 1
    cosh_root, sinh_root = _from_powers(n, r, -less, -bent, c)
    far0 = select(hyperbolic, cosh_root, _change_sign(select(odd, sine, cosine), quadrant + 1))
    far_sine = select(hyperbolic, sinh_root, _change_sign(select(odd, cosine, sine), quadrant))
    far1 = far_sine / root
    far1 = select(far1 <= c.largest, far1 - far1 * relative_tail, far1)
    turned = (w >= c.zero) & (far0 > c.zero)
    far2 = select(turned, far_sine * far_sine, c.one - far0) / select(turned, w * (c.one + far0), w)
    far3 = (c.one - far1) / w
    return (
        select(near, cosine, far0),
        select(near, c.one - z3, far1),
        select(near, near2, far2),
        select(near, near3, far3),
        select(near, near4, (c.half - far2) / w),
        select(near, near5, (c.sixth - far3) / w),
    )


def stumpff(w: Any) -> Any:
    """(c0, c1, c2, c3) of w, c_k(w) = sum over n of (-w)^n / (2n + k)!, at most 4 ulp off."""
    return _stumpff_six(w, _constants(w))[:4]


def stumpff0(w: Any) -> Any:
    """c0: cos sqrt(w), cosh sqrt(-w)."""
    return _stumpff_six(w, _constants(w))[0]


def stumpff1(w: Any) -> Any:
    """c1: sin sqrt(w) / sqrt(w), sinh sqrt(-w) / sqrt(-w)."""
    return _stumpff_six(w, _constants(w))[1]


def stumpff2(w: Any) -> Any:
    """c2: (1 - c0(w)) / w."""
    return _stumpff_six(w, _constants(w))[2]


def stumpff3(w: Any) -> Any:
    """c3: (1 - c1(w)) / w."""
    return _stumpff_six(w, _constants(w))[3]


def stumpff4(w: Any) -> Any:
    """c4: (1/2 - c2(w)) / w, at most 8 ulp off."""
    c = _constants(w)
    q = _stumpff_six(c.quarter * w, c)
    return c.half * c.quarter * (q[3] * (c.one + q[1]))


def stumpff5(w: Any) -> Any:
    """c5: (1/6 - c3(w)) / w, at most 8 ulp off."""
    c = _constants(w)
    q = _stumpff_six(c.quarter * w, c)
    return c.quarter * c.quarter * ((q[4] + q[5]) + q[2] * q[3])


def compiled(decorate: Callable[[Callable[..., Any]], Any]) -> SimpleNamespace:
    """The functions for scalars, each put through `decorate`.

    Parameters
    ----------
    decorate
        `numba.njit(error_model="numpy")`, with more options or none. The error model matters: both branches of a
        selection run, and one of them may divide by zero.

    Returns
    -------
    SimpleNamespace
        They call each other's decorated forms.
    """
    space = dict(globals())
    space["select"] = rows.compiled(decorate).select
    for name, value in globals().items():
        if isinstance(value, FunctionType) and value.__module__ == __name__ and value is not compiled:
            space[name] = decorate(FunctionType(value.__code__, space, name))
    return SimpleNamespace(**space)
