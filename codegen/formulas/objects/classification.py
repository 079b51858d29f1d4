"""Numbers that decide the kind of a CGA object: squares and flatness, each beside the scale of its rounding errors.

Numbers only; the names ("circle", "imaginary sphere", "not a blade") are the runtime's. The scale of each sum is what
rounding can leave of it when every coefficient is as uncertain as the largest of its weight (see `sizes`), so distance
from the origin and scale do not matter until the digits are gone.
"""

from __future__ import annotations

from fractions import Fraction

from ...algebra.members import TOLERANCE_ULPS
from ...algebra.multivector import Multivector, select
from ...trace.outputs import Result, row
from ..products.outcome import epsilon, size
from ..products.products import absolute_product
from ..products.sizes import Sizes, product_sizes, sizes
from .conformal import infinity

#: The product of the sizes of weights -1 and +1 is noise of the square of the middle one for flats, and at least a
#: tenth of it for rounds, wherever they are.
FLAT_FRACTION = Fraction(1, 16)


def invariants(x: Multivector) -> Result:
    """Eight numbers of a multivector of one grade.

    0, 1: <x x>_0 and the sum of its absolute terms. Beyond noise it is positive for real point pairs, lines and
    circles and for imaginary spheres, negative for real planes and spheres and for imaginary rounds; zero for
    points, tangents and directions.
    2, 3: size of the rest of x x (of grade 4), and of the errors that its factors may have, over the rounding unit;
    beyond noise, x is not a blade.
    4: size of that rest where it has the weight of the scalar: both have the same errors.
    5: whether x is flat, 1 or 0: x ^ n_inf is noise of x.
    6, 7: size of x . n_inf, and of x.
    """
    ni = infinity(x)
    square = x * x
    own = sizes(x)
    whole = size(x)
    noise = TOLERANCE_ULPS * epsilon(x) * whole
    curved = size(x ^ ni)
    flat = (curved <= noise) & (curved * own[2] <= FLAT_FRACTION * own[1] * own[1])
    written = own[0], own[1], _highest(own, noise)
    rest = sizes(square.grade(4))
    return row(
        [
            square.grade(0),
            absolute_product(x, x).grade(0),
            x.sum(rest),
            x.sum(product_sizes(written, written)),
            rest[1],
            select(flat, x.constant(1), x.constant(0)),
            size(x | ni),
            whole,
        ],
        "invariants",
    )


def _highest(own: Sizes, noise: Multivector) -> Multivector:
    """Size of the coefficients of weight +1 as written: they are differences of squares of lengths.

    They may cancel (for x^2 = r^2, for one) or vanish (for flats through the origin), and their errors do not: they are
    those of the square of the distance, or for flats of a unit of length.
    """
    low, level, high = own
    if not low.terms:
        return high + level
    return high + select(low > noise, level * level / low, level)
