"""The elementary functions: one text for C, CUDA, numba and NumPy, with the same operations and so the same bits.

The text is in the language of algorithms, without branches, but for one: selections compute both sides. As it stands it
runs on NumPy arrays and scalars, float64 or float32; `compiled` puts it through numba, which is never imported here,
and through the reader of algorithms, from which `targets.c.elementary` prints templates/c/lib/elementary.h. NumPy
warns of the branches not taken. Methods: docs/algebra/elementary.md.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import FunctionType, SimpleNamespace
from typing import Any, TypeAlias

from . import far_angles, machine
from .constants import TWO_OVER_PI
from .far_angles import reduce_far
from .machine import (
    any_of,
    change_sign,
    constants,
    copy_sign,
    exponent,
    is_odd,
    like,
    power_of_two,
    real,
    select,
    significand,
    square_root,
)  # fmt: skip

#: Types of the language, which the reader puts in their places.
Real: TypeAlias = Any
Static: TypeAlias = Any


def polynomial(z: Real, terms: Static) -> Real:
    """A polynomial: even and odd terms by themselves are two short chains of operations instead of a long one."""
    square = z * z
    last, other = terms[-1], terms[-2]
    for term in terms[-3::-1]:
        before = last
        last = other
        other = before * square + term
    return other + last * z


def reduce_by(
    x: Real, n: Real, step0: Real, step1: Real, step2: Real, step3: Real, tail: Real, c: Static
) -> tuple[Real, Real]:
    """(high, low): high - low = x + tail - n step to about twice the precision, for a small tail and step in parts.

    The first product and difference are exact by the choice of the parts; what later ones lose is kept. Zero keeps
    its sign.
    """
    rest = x - n * step0
    product = n * step1
    high = rest - product
    lost = (rest - high) - product
    if c.half_pi[3] == 0.0:  # three parts are enough
        correction = (n * step2 - lost) - tail
    else:
        rest = high
        product = n * step2
        high = rest - product
        lost = lost + ((rest - high) - product)
        correction = (n * step3 - lost) - tail
    result = high - correction
    return result, correction - (high - result)


# -- sin, cos: the reduced argument is high - low, |high| <= pi/4 and a little; quadrants are shifted integers --------


def far_or_near(x: Any, far: Any, high: Any, low: Any, quadrant: Any) -> Any:
    """(high, low, quadrant), reduced anew where far. What is computed at once differs: C has a text of its own."""
    if not any_of(far):
        return high, low, quadrant
    most, rest, turns = reduce_far(real(x), TWO_OVER_PI)
    new = like(most, x)
    return (
        select(far, new, high),
        select(far, like((real(new) - most) + rest, x), low),
        select(far, like(turns, x) + constants(x).shifter, quadrant),
    )


def sincos(x: Real) -> tuple[Real, Real]:
    """(sine, cosine) of x, at most 1 ulp off."""
    c = constants(x)
    quadrant = x * c.per_half_pi + c.shifter
    h0, h1, h2, h3 = c.half_pi
    r, low = reduce_by(x, quadrant - c.shifter, h0, h1, h2, h3, c.zero, c)
    r, low, quadrant = far_or_near(x, abs(x) > c.near, r, low, quadrant)
    z = r * r
    half = c.half * z
    most = c.one - half
    sine = r - ((r * z) * polynomial(z, c.sine) + low * most)
    cosine = most + (((c.one - most) - half) + ((z * z) * polynomial(z, c.cosine) + r * low))
    odd = is_odd(quadrant)
    return (
        change_sign(select(odd, cosine, sine), quadrant),
        change_sign(select(odd, sine, cosine), quadrant + c.one),
    )


def sin(x: Real) -> Real:
    """Sine."""
    sine, _ = sincos(x)
    return sine


def cos(x: Real) -> Real:
    """Cosine."""
    _, cosine = sincos(x)
    return cosine


# -- exp, log, sinh, cosh -----------------------------------------------------------------------------------------


def exp(x: Real) -> Real:
    """Exponential function, at most 1 ulp off: 2^n exp r, the power in two factors, for subnormal results."""
    c = constants(x)
    x = select(x > c.exp_range[1], c.exp_range[1], x)
    x = select(x < c.exp_range[0], c.exp_range[0], x)
    n = (x * c.per_ln2 + c.shifter) - c.shifter
    head = x - n * c.ln2_pair[0]
    product = n * c.ln2_pair[1]
    r = head - product
    low = (head - r) - product
    value = c.one + (r + ((r * r) * polynomial(r, c.exponential) + low))
    first = n * c.half + c.shifter
    return value * power_of_two(first) * power_of_two((n - (first - c.shifter)) + c.shifter)


def log(x: Real) -> Real:
    """Natural logarithm, at most 1 ulp off: -inf at zero, NaN below.

    log x = k ln2 + log(1 + f), 1 + f in [sqrt(1/2), sqrt(2)). With s = f/(2 + f), log(1 + f) is 2 artanh s, written
    f - (f^2/2 - s (f^2/2 + z R(z))), so that the largest term is exact.
    """
    c = constants(x)
    k = exponent(x)
    f = significand(x) - c.one
    s = f / (f + c.two)
    z = s * s
    half = c.half * f * f
    bent = s * (half + z * polynomial(z, c.logarithm))
    value = k * c.ln2_pair[0] - ((half - (bent + k * c.ln2_pair[1])) - f)
    value = select(x <= c.largest, value, x)  # infinity, NaN
    value = select(x == c.zero, -c.infinity, value)
    return select(x < c.zero, c.nan, value)


def from_powers(n: Real, r: Real, a: Real, b: Real, c: Static) -> tuple[Real, Real]:
    """(cosh, sinh) of n ln2 + r not near zero, where cosh r = 1 + a and sinh r = r + b.

    Half the sum and half the difference of 2^n exp r and 2^-n exp(-r), over 16 on the way, so that they overflow only
    where they must.
    """
    kept = select(n > c.forget, c.forget, n)
    grown = (c.one + (r + (a + b))) * power_of_two((n - c.four) + c.shifter)
    shrunk = (c.one - (r - (a - b))) * power_of_two((-c.four - kept) + c.shifter)
    return c.eight * (grown + shrunk), c.eight * (grown - shrunk)


def sinhcosh(x: Real) -> tuple[Real, Real]:
    """(hyperbolic sine, hyperbolic cosine), at most 2 ulp off."""
    c = constants(x)
    size = abs(x)
    size = select(size > c.sinh_largest, c.sinh_largest, size)
    near = size < c.one
    n = select(near, c.zero, (size * c.per_ln2 + c.shifter) - c.shifter)
    l0, l1, l2, l3 = c.ln2
    r, low = reduce_by(size, n, l0, l1, l2, l3, c.zero, c)
    z = r * r
    a = z * (c.half + z * polynomial(-z, c.stumpff4)) - r * low
    b = r * (z * (c.sixth + z * polynomial(-z, c.stumpff5))) - low * (c.one + a)
    far_cosh, far_sinh = from_powers(n, r, a, b, c)
    return copy_sign(select(near, r + b, far_sinh), x), select(near, c.one + a, far_cosh)


def sinh(x: Real) -> Real:
    """Hyperbolic sine."""
    sine, _ = sinhcosh(x)
    return sine


def cosh(x: Real) -> Real:
    """Hyperbolic cosine."""
    _, cosine = sinhcosh(x)
    return cosine


# -- atan2 --------------------------------------------------------------------------------------------------------


def atan2(y: Real, x: Real) -> Real:
    """Angle of the point (x, y) in [-pi, pi], at most 2 ulp off.

    A count of eighths of a turn plus or minus arctan q, |q| <= 1/2, where q is small/big or, where small > big/2,
    (small - big)/(small + big). One sum brings all parts together.
    """
    c = constants(x)
    width, height = abs(x), abs(y)
    swap, left = height > width, copy_sign(c.one, x) < c.zero
    big, small = select(swap, height, width), select(swap, width, height)
    scale = select(big > c.largest * c.quarter, c.quarter, c.one)  # their sum may overflow
    diagonal = (small > c.half * big) | (small > c.largest)  # the second: both infinite
    big, small = big * scale, small * scale
    above, below = select(diagonal, small - big, small), select(diagonal, small + big, big)
    q = select((below > c.zero) & (below <= c.largest), above / below, c.zero)  # 0/0: the eighths say it all
    backward = swap ^ left
    eighths = select(diagonal, c.one, c.zero)
    eighths = select(backward, -eighths, eighths) + select(swap, c.two, select(left, c.four, c.zero))
    z = q * q
    bend = (q * z) * polynomial(z, c.arctangent)
    q, bend = select(backward, -q, q), select(backward, -bend, bend)
    angle = eighths * c.quarter_pi[0] + (q + (eighths * c.quarter_pi[1] - bend))
    return select((x != x) | (y != y), x + y, copy_sign(angle, y))


# -- Stumpff functions ----------------------------------------------------------------------------------------------


def root_in_two(size: Real, c: Static) -> tuple[Real, Real]:
    """(root, rest): the square root of size is root (1 + rest), to about twice the precision."""
    root = square_root(size)
    cut = root * c.splitter
    first = cut - (cut - root)
    second = root - first
    square = root * root
    error = ((first * first - square) + c.two * first * second) + second * second
    return root, ((size - square) - error) / (c.two * size)


def stumpff_six(w: Real) -> tuple[Real, Real, Real, Real, Real, Real]:
    """(c0, .., c5) of w, the last two not as good as they should be.

    With t = sqrt|w|: c0, c1 are cos t, sin t/t for w > 0 and cosh t, sinh t/t for w < 0. Both cases reduce t to r, by
    pi/2 or by ln2, and need c0(z) = 1 - z c2(z) and r c1(z) = r - r z c3(z) at z = r^2 or -r^2: one pair of
    polynomials, for c4 in c2 = 1/2 - z c4 and for c5 in c3 = 1/6 - z c5. Near zero they are taken at w itself.
    Elsewhere c3 = (1 - c1)/w and c2 = (1 - c0)/w or, since this cancels near full turns, s^2/(w (1 + c0)) with
    s = sin t where c0 > 0. The root is taken to twice the precision.
    """
    c = constants(w)
    lowest = -c.sinh_largest * c.sinh_largest
    w = select(w < lowest, lowest, w)
    hyperbolic, near = w < c.zero, (w > c.below) & (w < c.above)
    root, relative_tail = root_in_two(abs(w), c)
    far = root > c.near  # never where hyperbolic
    tail = select(far, c.zero, root * relative_tail)
    step0, step1 = select(hyperbolic, c.ln2[0], c.half_pi[0]), select(hyperbolic, c.ln2[1], c.half_pi[1])
    step2, step3 = select(hyperbolic, c.ln2[2], c.half_pi[2]), select(hyperbolic, c.ln2[3], c.half_pi[3])
    quadrant = root * select(hyperbolic, c.per_ln2, c.per_half_pi) + c.shifter
    n = quadrant - c.shifter
    r, low = reduce_by(root, n, step0, step1, step2, step3, tail, c)
    r, low, quadrant = far_or_near(root, far, r, low, quadrant)

    signed_r = select(hyperbolic, -r, r)
    z = select(near, w, signed_r * r)
    bend = select(near, c.zero, signed_r * low)
    near4, near5 = polynomial(z, c.stumpff4), polynomial(z, c.stumpff5)
    near2, near3 = c.half - z * near4, c.sixth - z * near5
    z3 = z * near3
    less = z * near2 - bend
    cosine = c.one - less  # cos r or cosh r
    bent = r * z3 + low * cosine
    sine = r - bent  # sin r or sinh r
    odd = is_odd(quadrant)
    cosh_root, sinh_root = from_powers(n, r, -less, -bent, c)
    far0 = select(hyperbolic, cosh_root, change_sign(select(odd, sine, cosine), quadrant + c.one))
    far_sine = select(hyperbolic, sinh_root, change_sign(select(odd, cosine, sine), quadrant))
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


def stumpff(w: Real) -> tuple[Real, Real, Real, Real]:
    """(c0, c1, c2, c3) of w, c_k(w) = sum over n of (-w)^n / (2n + k)!, at most 4 ulp off."""
    c0, c1, c2, c3, _, _ = stumpff_six(w)
    return c0, c1, c2, c3


def stumpff0(w: Real) -> Real:
    """c0: cos sqrt(w), cosh sqrt(-w)."""
    c0, _, _, _, _, _ = stumpff_six(w)
    return c0


def stumpff1(w: Real) -> Real:
    """c1: sin sqrt(w) / sqrt(w), sinh sqrt(-w) / sqrt(-w)."""
    _, c1, _, _, _, _ = stumpff_six(w)
    return c1


def stumpff2(w: Real) -> Real:
    """c2: (1 - c0(w)) / w."""
    _, _, c2, _, _, _ = stumpff_six(w)
    return c2


def stumpff3(w: Real) -> Real:
    """c3: (1 - c1(w)) / w."""
    _, _, _, c3, _, _ = stumpff_six(w)
    return c3


def stumpff4(w: Real) -> Real:
    """c4: (1/2 - c2(w)) / w, at most 8 ulp off: from a quarter of the argument, no term has the other sign."""
    c = constants(w)
    _, c1, _, c3, _, _ = stumpff_six(c.quarter * w)
    return c.half * c.quarter * (c3 * (c.one + c1))


def stumpff5(w: Real) -> Real:
    """c5: (1/6 - c3(w)) / w, at most 8 ulp off."""
    c = constants(w)
    _, _, c2, c3, c4, c5 = stumpff_six(c.quarter * w)
    return c.quarter * c.quarter * ((c4 + c5) + c2 * c3)


def stumpff6(w: Real) -> Real:
    """c6: (1/24 - c4(w)) / w, at most 8 ulp off; c5 of the quarter by a polynomial that reaches farther."""
    c = constants(w)
    q = c.quarter * w
    _, c1, _, c3, _, c5 = stumpff_six(q)
    c5 = select(abs(q) < -c.below, c.per_120 - q * polynomial(q, c.stumpff7), c5)
    return c.half * c.quarter * c.quarter * (c.sixth * c3 + c5 * (c.one + c1))


def stumpff7(w: Real) -> Real:
    """c7: (1/120 - c5(w)) / w, at most 8 ulp off."""
    c = constants(w)
    q, lowest = c.quarter * w, -c.sinh_largest * c.sinh_largest
    _, _, c2, _, c4, c5 = stumpff_six(q)
    near, c6, c7 = abs(q) < -c.below, polynomial(q, c.stumpff6), polynomial(q, c.stumpff7)
    far = ((c.quarter * c.sixth - c4) + (c.per_120 - c5)) / select(q < lowest, lowest, q)
    c4, c5 = select(near, c.quarter * c.sixth - q * c6, c4), select(near, c.per_120 - q * c7, c5)
    return c.quarter * c.quarter * c.quarter * (select(near, c6 + c7, far) + (c.sixth * c4 + c5 * c2))


def compiled(
    decorate: Callable[[Callable[..., Any]], Any], replaced: Mapping[str, Any] | None = None
) -> SimpleNamespace:
    """The functions, each put through `decorate`.

    Parameters
    ----------
    decorate
        For scalars, `numba.njit(error_model="numpy")`, with more options or none. The error model matters: both
        branches of a selection run, and one of them may divide by zero.
    replaced : mapping of str to object, optional
        Names that mean something else. Default: those of `machine`, decorated.

    Returns
    -------
    SimpleNamespace
        They call each other's decorated forms.
    """
    texts = {**vars(far_angles), **globals()}
    space = {**texts, **(machine.compiled(decorate) if replaced is None else replaced)}
    for name, value in texts.items():
        is_text = isinstance(value, FunctionType) and value.__module__ in (__name__, far_angles.__name__)
        if is_text and value is not compiled and name not in (replaced or ()):
            space[name] = decorate(FunctionType(value.__code__, space, name))
    return SimpleNamespace(**space)
