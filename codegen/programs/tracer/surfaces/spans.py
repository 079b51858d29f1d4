"""What finders of roots on surfaces along curves share: spans where a surface is real, and its ends."""

from __future__ import annotations

from ....algorithms.roots.problem import COUNT, FOUND, root_of_unit
from ....ir.loops.algorithm import Algorithm as algorithm
from ....ir.loops.algorithm import inlined
from ....ir.loops.language import Bool, InOut, Int, IntVector, Real, Reals, Vector
from ..records import SPANS

#: What finders return in place of a number of roots: the condition is zero everywhere; something is not finite; another
#: search is to find them.
VANISHES, INVALID, DEFERRED = -1, -2, -3
#: In square roots of the unit roundoff: how far a root may be off an end and still be that of the end.
BESIDE = 64.0


@inlined
def is_real(spans: Vector[2 * SPANS], t: Real) -> Bool:
    """Whether the surface is real at t."""
    for i in range(SPANS):  # noqa: SIM110
        if t >= spans[2 * i] and t <= spans[2 * i + 1]:
            return True
    return False


@inlined
def has_root_at(roots: Reals, count: Int, end: Real) -> Bool:
    """Whether one of the roots is that of an end."""
    for i in range(count):  # noqa: SIM110
        if abs(roots[i] - end) <= BESIDE * root_of_unit():
            return True
    return False


@algorithm
def add_end(roots: InOut[Reals], found: InOut[IntVector[FOUND]], end: Real) -> None:
    """Put an end of a piece among its roots; there is room.

    There f is zero to rounding, but the root may be just beyond it, at joints beyond the ends of both pieces.
    """
    count = found[COUNT]
    at = count
    if end == 0.0:
        for i in range(count, 0, -1):
            roots[i] = roots[i - 1]
        at = 0
    roots[at] = end
    found[COUNT] = count + 1
