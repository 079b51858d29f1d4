"""Blades as subspaces, without a metric: the vectors that span a blade, as a table that is linear in its coefficients.

Ranks are determined on numbers, by the runtime. A blade spans the same vectors whatever they square to,
so null blades and degenerate metrics are no special cases.
"""

from __future__ import annotations

from fractions import Fraction

from ...algebra.algebra import Algebra
from ...algebra.blades import outer_sign
from ..products.frames import Entry

#: Null vectors that carry lengths: their coefficients scale with the power of a length that stands here.
_LENGTHS = {"no": -1, "ni": 1, "0": 1}


def contractions(algebra: Algebra, grade: int) -> list[Entry]:
    """The matrix whose rows are the vectors A _| B, for all basis blades A of one grade less than B's.

    _| contracts as if the basis were orthonormal: the coefficient of e_i is that of A ^ e_i in B. For a blade all
    non-zero singular values are equal and the rows span it; the number of them is more than the grade for any other
    B, for it is the dimension of the smallest subspace that holds B.
    """
    column = {b: i for i, b in enumerate(algebra.blades_of_grade(grade))}
    entries = []
    for row, a in enumerate(algebra.blades_of_grade(grade - 1)):
        for i in range(algebra.dimension):
            if sign := outer_sign(a, 1 << i):
                entries.append(Entry(row, i, column[a | 1 << i], Fraction(sign)))
    return entries


def length_powers(algebra: Algebra, blades: tuple[int, ...]) -> tuple[int, ...]:
    """With which power of the unit of length a blade's coefficient goes: n_inf (e0) counts 1, n0 counts -1."""
    powers = [_LENGTHS.get(label, 0) for label in algebra.vectors]
    return tuple(sum(p for i, p in enumerate(powers) if blade >> i & 1) for blade in blades)
