"""Plane of a full turn that commutes with the rest of a rotor: there the logarithm has a choice."""

from __future__ import annotations

from ...algebra.multivector import Mask, Multivector, select, sqrt
from ..objects.euclidean import attached_part, axes, space
from ..products.double_rotations import square_of
from ..products.outcome import NOISE, as_computed, epsilon, size


def commuting_axis(v: Multivector) -> tuple[Multivector, Mask | None]:
    """Unit bivector of a rotation about an axis along the translation in v, and where there is one (None: always)."""
    basis = axes(v)
    plane = basis[0] * basis[1]
    t = attached_part(v)
    if not t.terms:
        return plane, None
    square = (t * t).grade(0)
    if len(basis) != 3:
        return plane, square <= 0
    along = square > 0
    scale = select(along, 1 / sqrt(square), v.constant(0))
    return t * space(v) * scale + plane * select(along, v.constant(0), v.constant(1)), None


def commuting_plane(v2: Multivector) -> tuple[Multivector, Mask]:
    """A unit bivector of a rotation that commutes with a simple v2, and where there is one.

    In five dimensions orthogonal to v2 and to the basis vector (or no + ni) that leaves most of it; in four it is
    dual to v2; where v2 is nothing but rounding, it is spanned by the first two vectors of equal squares.
    """
    algebra = v2.algebra
    basis = [v2.basis("e" + label if label.isdigit() else label) for label in algebra.vectors]
    diagonal = [algebra.metric[i][i] for i in range(algebra.dimension)]
    chosen, best, plane = v2.new({}), v2.constant(0), v2.new({})
    if algebra.dimension == 5:
        null = [e for e, g in zip(basis, diagonal, strict=True) if not g]
        vectors = [e for e, g in zip(reversed(basis), reversed(diagonal), strict=True) if g]
        for x in [*vectors, v2.sum(null)] if null else vectors:
            score = -square_of((x ^ v2).dual())
            better = score > best
            chosen, best = select(better, x, chosen), select(better, score, best)
        plane = (chosen ^ v2).dual()
    elif algebra.dimension == 4:
        plane = v2.dual()
        best = -square_of(plane)
    pairs = [
        (x, y)
        for i, x in enumerate(basis)
        for j, y in enumerate(basis[i + 1 :], i + 1)
        if diagonal[i] and diagonal[i] == diagonal[j]
    ]
    nothing = size(v2) <= NOISE * NOISE * epsilon(v2)
    usable = (best > 0) & ~nothing
    if plane.terms:
        plane = as_computed(plane * select(usable, 1 / sqrt(best), v2.constant(0)))
        for _ in range(2):  # a turn that was no more than noise in v2 leaves noise/|v2| of v2 in it
            plane = as_computed(plane + ((plane ^ plane) * plane).grade(2) / 2)
            plane = plane * select(usable, 1 / sqrt(-square_of(plane)), v2.constant(0))
    if not pairs:
        return plane, usable
    x, y = pairs[0]
    return plane - (x * y) * select(nothing, v2.constant(1), v2.constant(0)), usable | nothing
