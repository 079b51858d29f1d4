"""Products and their rounding errors, by Dekker's sums and by the instruction of wide vectors, against exact ones."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from bladesmith import cga3d as cga
from bladesmith import codegen
from bladesmith.codegen import algorithm
from bladesmith.codegen.build import extension
from bladesmith.codegen.formulas.products.double_double import two_product, two_square
from bladesmith.codegen.language import Out, Real, Vector

from ...support.targets.lanes import TAGS, by_lanes

pytestmark = [
    pytest.mark.compiles, pytest.mark.skipif(extension.compiler() is None, reason="no C compiler"),
]  # fmt: skip
product = codegen.kernel(codegen.scalar, codegen.scalar, algebra=cga)(two_product)
square = codegen.kernel(codegen.scalar, algebra=cga)(two_square)


@algorithm
def products(a: Real, b: Real, found: Out[Vector[4]]) -> None:
    """A product and a square, each with its error."""
    found[0], found[1] = product(a, b)
    found[2], found[3] = square(a)


@pytest.mark.parametrize("tag", TAGS)
def test_errors_are_exact(tag: str) -> None:
    rng = np.random.default_rng(6)
    a, b = rng.normal(size=(2, 203)) * 10.0 ** rng.integers(-100, 100, (2, 203))
    a[:5], b[:5] = (0.0, -1.0, 3.0, 1.0 + 2.0**-52, 1 / 3), (-1.0, 0.0, 7.0, 1.0 - 2.0**-53, 3.0)
    (found,) = by_lanes(products, (a, b), len(a), tag)
    for x, y, (xy, rest, xx, left) in zip(
        *(v.tolist() for v in (a, b)), np.reshape(found, (-1, 4)).tolist(), strict=True
    ):
        assert (xy, xx) == (x * y, x * x)
        assert Fraction(rest) == Fraction(x) * Fraction(y) - Fraction(xy)
        assert Fraction(left) == Fraction(x) ** 2 - Fraction(xx)
    assert np.count_nonzero(found) > 700 and not np.signbit(np.reshape(found, (-1, 4))[:3, [1, 3]]).any()
