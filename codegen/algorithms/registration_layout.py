"""Arrays of a registration, as its algorithms and their callers know them.

The coefficients of a query and of a reference, and the elements (position, direction, radius) of the reference, are in
one array of real numbers. The elements of a kind are in the cells of a grid of their positions; what lies beyond the
grid is in its outermost cells. Kinds are numbered in every program, whichever of them it has.
"""

from __future__ import annotations

from typing import Any

from ..ir.loops.language import Int, IntVector, Real, Vector
from ..ir.loops.records import record

#: Coefficients of a motor and of a twist.
MOTOR = 8
TWIST = 6
#: Numbers of an element, and of its position.
ELEMENT = 7
POSITION = 3
#: Numbers of a match's rates: cost, its gradient and its Gauss-Newton matrix (upper half) by the twist.
RATES = 28
#: Numbers of the two ends of a segment, or of the two vectors of which the residuals of a match are linear forms.
VECTORS = 6
#: Residuals of a match at most, each of seven numbers: coefficients of the vectors, and what is taken off.
RESIDUALS = 6
RESIDUAL = VECTORS + 1
#: Numbers of a pair of objects that a motion leaves as they are.
INVARIANTS = 4
#: The match criterion: factors of squared differences of positions, of 1 - cos and of squared differences of radii; the
#: sum of them up to which two objects may be one; the fraction of objects with a counterpart below which a motor is
#: given up early; -1 where x and -x are one, else 1.
Settings: Any = record("Settings", weights=Vector[3], limit=Real, least=Real, other=Vector[1])
#: Of a kind: where cell 0, 0, 0 begins, cells per length, and 1 if it has a direction, else 0.
Grid: Any = record("Grid", corner=Vector[3], scale=Real, directed=Vector[1])
#: Of a kind: coefficients of a row; where rows of the query and of the reference and elements begin among the real
#: numbers, and, among the integers, the first object of each cell and the rows of the objects in the order of cells;
#: cells along each axis, and reference objects.
Head: Any = record(
    "Head", length=Int, query=Int, reference=Int, elements=Int, starts=Int, order=Int, sides=IntVector[3], objects=Int
)
#: A query object that is looked at.
Selected: Any = record("Selected", kind=Int, row=Int)
