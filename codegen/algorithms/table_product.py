"""Bilinear products of sparse multivectors by a table of terms, whatever the algebra.

C computes several items at once and has a text of its own for that, templates/c/lib/general.h: sizes are known at run
time only, so that its vectors are in memory that it asks for.
"""

from __future__ import annotations

from ..ir.loops.algorithm import Algorithm as algorithm
from ..ir.loops.language import InOut, Ints, Reals


@algorithm
def multiply_by_table(
    starts: Ints, left: Ints, right: Ints, weights: Reals, a: Reals, b: Reals, product: InOut[Reals]
) -> None:
    """Each coefficient of the product: the sum of its terms, those from starts[k] to starts[k + 1], in their order."""
    for k in range(len(product)):
        total = 0.0
        for t in range(starts[k], starts[k + 1]):
            total += weights[t] * (a[left[t]] * b[right[t]])
        product[k] = total
