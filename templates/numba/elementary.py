"""The elementary functions of templates/c/elementary.h in plain Python: the same operations, the same bits.

Each function takes NumPy arrays and scalars, float64 or float32, as it stands, and scalars of either kind once
`compiled` has put it through numba, which is never imported here. NumPy warns of the branches not taken.
Methods: docs/elementary.md. Constants: benchmarks/derive_elementary.py.
"""

from __future__ import annotations

from collections.abc import Callable
from types import FunctionType, SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

from . import rows
from .rows import select


class Constants(NamedTuple):
    """What differs between the precisions. Polynomials have their lowest coefficient first, numbers are in parts."""

    sine: Any
    cosine: Any
    stumpff4: Any
    stumpff5: Any
    exponential: Any
    logarithm: Any
    arctangent: Any
    half_pi: Any
    ln2: Any
    ln2_pair: Any
    quarter_pi: Any
    per_half_pi: Any
    per_ln2: Any
    near: Any  # up to here products reduce an angle
    shifter: Any  # added and taken off again, rounds to an integer
    splitter: Any  # cuts a significand into halves
    largest: Any
    exp_range: Any  # beyond: zero, infinity
    sinh_largest: Any  # beyond: infinity
    forget: Any  # exp(-x) is nothing beside exp(x) from 2 to this power on
    below: Any  # the Stumpff functions are polynomials in w itself between this
    above: Any  # and this
    sixth: Any
    infinity: Any
    nan: Any
    zero: Any
    quarter: Any
    half: Any
    one: Any
    two: Any
    four: Any
    eight: Any
    root_half: int  # bits, as float64


def _float64(*values: str | float) -> tuple[Any, ...]:
    return tuple(float.fromhex(v) if isinstance(v, str) else float(v) for v in values)


def _float32(*values: str | float) -> tuple[Any, ...]:
    return tuple(np.float32(v) for v in _float64(*values))


# fmt: off
_DOUBLE = Constants(
    sine=_float64(
        "0x1.5555555555548p-3", "-0x1.111111110f731p-7", "0x1.a01a019be94afp-13", "-0x1.71de355556c26p-19",
        "0x1.ae5e4bae22a78p-26", "-0x1.5d8b651a58f85p-33",
    ),
    cosine=_float64(
        "0x1.555555555554bp-5", "-0x1.6c16c16c15016p-10", "0x1.a01a019c8f4dbp-16", "-0x1.27e4f7f1b6a14p-22",
        "0x1.1ee9dbecb79d9p-29", "-0x1.8fa695c162261p-37",
    ),
    stumpff4=_float64(
        "0x1.5555555555555p-5", "-0x1.6c16c16c16c18p-10", "0x1.a01a01a01a04bp-16", "-0x1.27e4fb778872bp-22",
        "0x1.1eed8effa9694p-29", "-0x1.93974ab77a0b2p-37", "0x1.ae7f26bb98d3ap-45", "-0x1.682cefdbfb008p-53",
        "0x1.e3f86fc34c998p-62", "-0x1.21050be12755cp-70",
    ),
    stumpff5=_float64(
        "0x1.1111111111111p-7", "-0x1.a01a01a01a01ap-13", "0x1.71de3a556c748p-19", "-0x1.ae64567f5343ep-26",
        "0x1.6124613a94caep-33", "-0x1.ae7f3e9296891p-41", "0x1.952c66d90fe04p-49", "-0x1.2f4d4ce6e8219p-57",
        "0x1.70e12dc1f01c4p-66", "-0x1.9015bffb9429fp-75",
    ),
    exponential=_float64(
        "0x1.000000000000ap-1", "0x1.55555555554fap-3", "0x1.55555555508a1p-5", "0x1.1111111127c87p-7",
        "0x1.6c16c1842204bp-10", "0x1.a01a012a0de64p-13", "0x1.a0199a22544f1p-16", "0x1.71df2618d1aeap-19",
        "0x1.28ad5e73bfa76p-22", "0x1.ad7e074c994c5p-26",
    ),
    logarithm=_float64(
        "0x1.5555555555592p-1", "0x1.999999997ff2ep-2", "0x1.24924941df2bdp-2", "0x1.c71c5216af335p-3",
        "0x1.74663c597373p-3", "0x1.39a1f9771520bp-3", "0x1.2f0304c405abdp-3",
    ),
    arctangent=_float64(
        "0x1.5555555555518p-2", "-0x1.99999999914ddp-3", "0x1.249249216ffb5p-3", "-0x1.c71c709692423p-4",
        "0x1.745cf54f05e76p-4", "-0x1.3b11454a8ac64p-4", "0x1.10f3675c4f2e4p-4", "-0x1.dfed1097f67aep-5",
        "0x1.a3a77f5585f75p-5", "-0x1.571de4fe64645p-5", "0x1.c1fa230e68603p-6", "-0x1.4c27078eb4efbp-7",
    ),
    half_pi=_float64("0x1.921fb5444p+0", "0x1.68c234c4cp-39", "0x1.98a2e03707345p-77", "0x0p+0"),
    ln2=_float64("0x1.62e42fefap-1", "0x1.cf79abc9ep-40", "0x1.d9cc01f97b57ap-79", "0x0p+0"),
    ln2_pair=_float64("0x1.62e42fefa38p-1", "0x1.ef35793c7673p-45"),
    quarter_pi=_float64("0x1.921fb54442d18p-1", "0x1.1a62633145c07p-55"),
    per_half_pi=_float64("0x1.45f306dc9c883p-1")[0],
    per_ln2=_float64("0x1.71547652b82fep+0")[0],
    near=_float64(102943.0)[0],
    shifter=_float64("0x1.8p+52")[0],
    splitter=_float64("0x1.0000002p+27")[0],
    largest=_float64("0x1.fffffffffffffp+1023")[0],
    exp_range=_float64(-746.0, 710.0),
    sinh_largest=_float64(711.0)[0],
    forget=_float64(64.0)[0],
    below=_float64(-9.0)[0],
    above=_float64(1.5)[0],
    sixth=_float64(1.0 / 6.0)[0],
    infinity=_float64(np.inf)[0],
    nan=_float64(np.nan)[0],
    zero=_float64(0.0)[0],
    quarter=_float64(0.25)[0],
    half=_float64(0.5)[0],
    one=_float64(1.0)[0],
    two=_float64(2.0)[0],
    four=_float64(4.0)[0],
    eight=_float64(8.0)[0],
    root_half=0x3FE6A09E667F3BCD,
)
_SINGLE = Constants(
    sine=_float32("0x1.555546p-3", "-0x1.110778p-7", "0x1.995402p-13"),
    cosine=_float32("0x1.55554ap-5", "-0x1.6c0c28p-10", "0x1.99e806p-16"),
    stumpff4=_float32(
        "0x1.555556p-5", "-0x1.6c16cp-10", "0x1.a019eep-16", "-0x1.27efp-22",
        "0x1.1d6d58p-29", "-0x1.bf5486p-37",
    ),
    stumpff5=_float32(
        "0x1.11111p-7", "-0x1.a01a14p-13", "0x1.71e8bp-19", "-0x1.ac2de8p-26",
        "0x1.87d376p-33",
    ),
    exponential=_float32(
        "0x1.fffffcp-2", "0x1.555492p-3", "0x1.5558fp-5", "0x1.1239a8p-7",
        "0x1.6a24eep-10",
    ),
    logarithm=_float32("0x1.55557ap-1", "0x1.995edap-2", "0x1.31dfep-2"),
    arctangent=_float32(
        "0x1.555514p-2", "-0x1.997ba4p-3", "0x1.22513cp-3", "-0x1.a044aap-4",
        "0x1.a4cf6ep-5",
    ),
    half_pi=_float32("0x1.921p+0", "0x1.f6ap-13", "0x1.11p-26", "0x1.68c234p-39"),
    ln2=_float32("0x1.62ep-1", "0x1.0bfp-15", "0x1.7d1p-28", "0x1.9ef358p-41"),
    ln2_pair=_float32("0x1.62e4p-1", "0x1.7f7d1cp-20"),
    quarter_pi=_float32("0x1.921fbp-1", "0x1.5110b4p-23"),
    per_half_pi=_float32("0x1.45f306p-1")[0],
    per_ln2=_float32("0x1.715476p+0")[0],
    near=_float32(3216.0)[0],
    shifter=_float32("0x1.8p+23")[0],
    splitter=_float32("0x1.002p+12")[0],
    largest=_float32("0x1.fffffep+127")[0],
    exp_range=_float32(-105.0, 89.0),
    sinh_largest=_float32(90.0)[0],
    forget=_float32(32.0)[0],
    below=_float32(-9.0)[0],
    above=_float32(1.5)[0],
    sixth=_float32(1.0 / 6.0)[0],
    infinity=_float32(np.inf)[0],
    nan=_float32(np.nan)[0],
    zero=_float32(0.0)[0],
    quarter=_float32(0.25)[0],
    half=_float32(0.5)[0],
    one=_float32(1.0)[0],
    two=_float32(2.0)[0],
    four=_float32(4.0)[0],
    eight=_float32(8.0)[0],
    root_half=0x3FE6A09E60000000,
)
# fmt: on

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
_HALF_PI = _float64("0x1.921fb54442d18p+0", "0x1.1a62633145c07p-54")
_HALF_PI_HALVES = _float64("0x1.921fb5p+0", "0x1.110b46p-26")  # of the first part

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
_U0, _U1, _U31, _U32, _U61, _U62, _U63 = (np.uint64(n) for n in (0, 1, 31, 32, 61, 62, 63))
_LOW31, _LOW32, _HALF_TURN = np.uint64(2**31 - 1), np.uint64(2**32 - 1), np.uint64(2**61)


def _constants(x: Any) -> Any:
    """Those of the precision of x. Under numba the tests are decided when it compiles."""
    if isinstance(x, np.float32):
        return _SINGLE
    if isinstance(x, float):
        return _DOUBLE
    return _SINGLE if np.asarray(x).dtype == np.float32 else _DOUBLE


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
    w0, w1 = _TWO_OVER_PI[first], _TWO_OVER_PI[first + 1]
    w2, w3 = _TWO_OVER_PI[first + 2], _TWO_OVER_PI[first + 3]
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
    product = f * _HALF_PI[0]
    half_1, half_2 = _HALF_PI_HALVES
    error = ((f_1 * half_1 - product) + f_1 * half_2 + f_2 * half_1) + f_2 * half_2
    error = error + (f * _HALF_PI[1] + f_rest * _HALF_PI[0])
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
    far1 = far1 - far1 * relative_tail
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
