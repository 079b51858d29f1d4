"""What decides the kind of a CGA object: squares and flatness, each beside the scale of its rounding errors.

Numbers only; the names ("circle", "imaginary sphere", "not a blade") are the runtime's. Every test is relative
to what rounding can do to that very sum, so distance from the origin and weight do not matter until the digits
are gone.
"""

from __future__ import annotations

from ..multivector import Multivector
from ..trace import Result, row
from .conformal import infinity
from .outcome import size
from .products import absolute_product


def invariants(x: Multivector) -> Result:
    """Eight numbers of a multivector of one grade.

    0, 1: <x x>_0 and the sum of its absolute terms. Beyond noise it is positive for real point pairs, lines and
    circles and for imaginary spheres, negative for real planes and spheres and for imaginary rounds; zero for
    points, tangents and directions.
    2, 3: size of the rest of x x (of grade 4), and of its absolute terms; beyond noise, x is not a blade.
    4, 5: size of x ^ n_inf and of x . n_inf. The first is noise of x for flats; both are for directions.
    6: size of x itself. 7: the weight -(x* . n_inf) of grade 4, positive for an outward sphere, else 0.
    """
    ni = infinity(x)
    square = x * x
    scale = absolute_product(x, x)
    return row(
        [
            square.grade(0),
            scale.grade(0),
            size(square.grade(4)),
            size(scale.grade(4)),
            size(x ^ ni),
            size(x | ni),
            size(x),
            -(x.dual() | ni).grade(0) if x.grades == (4,) else x.constant(0),
        ],
        "invariants",
    )
