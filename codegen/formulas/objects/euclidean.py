"""Elements that CGA and PGA share: Euclidean axes and one null vector n (n_inf or e0) that carries translations.

Motors, flat objects and their formulas are the same text in both algebras, written on these names.
"""

from __future__ import annotations

from ...algebra.blades import outer_sign
from ...algebra.multivector import Multivector, select, sqrt
from ...errors import GradeError
from ..products.outcome import as_computed, epsilon, size, where_or_nan

#: Labels of the null vector that makes translators, in CGA and in PGA.
_NULL_LABELS = ("ni", "0")


def _axis_labels(like: Multivector) -> list[str]:
    return [v for v in like.algebra.vectors if v.isdigit() and v != "0"]


def axes(like: Multivector) -> list[Multivector]:
    """The Euclidean basis vectors e1, e2, ..."""
    return [like.basis("e" + v) for v in _axis_labels(like)]


def _null_label(like: Multivector) -> str | None:
    return next((v for v in _NULL_LABELS if v in like.algebra.vectors), None)


def null_vector(like: Multivector) -> Multivector:
    """n: n_inf in CGA, e0 in PGA.

    Raises
    ------
    GradeError
        If the algebra has neither, and so no translations.
    """
    label = _null_label(like)
    if label is None:
        raise GradeError(f"{like.algebra.name} has no null vector `ni` or `e0`, and so no translations.")
    return like.basis("e0" if label == "0" else label)


def space(like: Multivector) -> Multivector:
    """Pseudoscalar of the Euclidean axes: I3 = e123, or e12 in the plane."""
    total = like.constant(1)
    for e in axes(like):
        total = total ^ e
    return total


def vector(coordinates: tuple[Multivector, ...]) -> Multivector:
    """The Euclidean vector with these coordinates."""
    like = coordinates[0]
    return like.sum(c * e for c, e in zip(coordinates, axes(like), strict=True))


def coordinates(x: Multivector) -> list[Multivector]:
    """Coordinates of a Euclidean vector."""
    return [x["e" + v] for v in _axis_labels(x)]


def _axes_mask(like: Multivector) -> int:
    vectors = like.algebra.vectors
    return sum(1 << vectors.index(v) for v in _axis_labels(like))


def euclidean_part(x: Multivector) -> Multivector:
    """The part of x made of the axes alone; in CGA (x ^ E0) E0."""
    mask = _axes_mask(x)
    return x.new({b: c for b, c in x.terms.items() if not b & ~mask})


def attached_part(x: Multivector) -> Multivector:
    """The Euclidean y in x = ... + y ^ n."""
    label = _null_label(x)
    if label is None:
        return x.new({})
    mask, null = _axes_mask(x), 1 << x.algebra.vectors.index(label)
    part = x.new({b: c for b, c in x.terms.items() if b & null and not b & ~(mask | null)})
    signed = part.scale_blades(lambda b: outer_sign(b ^ null, null))
    return x.new({b ^ null: c for b, c in signed.terms.items()})


def cross(a: Multivector, b: Multivector) -> Multivector:
    """Cross product of vectors in space: -(a ^ b) I3."""
    return -((a ^ b) * space(a))


def dot(x: Multivector, y: Multivector) -> Multivector:
    """Scalar product, also where an operand vanishes identically."""
    return x.scalar_product(y)


def length(v: Multivector) -> Multivector:
    """Length of a Euclidean vector."""
    return sqrt((v * v).grade(0))


def direction_of(v: Multivector) -> tuple[Multivector, Multivector]:
    """Unit vector along v and 1/|v|; both NaN for a zero or unusable v.

    Where squares might overflow or underflow, v is first brought to about unit size; as computed, for a simplifier
    would square before it divides.
    """
    written, small = size(v), epsilon(v) * epsilon(v)
    ordinary = (written > small) & (written * small < 1)
    unit = select(ordinary, v.constant(1), written)
    u = as_computed(v / unit)
    u_length = length(u)
    scale = 1 / where_or_nan(u_length > 0, u_length)
    return u * scale, scale / unit


def canonical_sign(x: Multivector) -> Multivector:
    """+1 or -1 that makes the first non-zero coefficient of x positive; +1 for zero."""
    sign = x.constant(1)
    for c in reversed(x.coefficients()):
        sign = select(c > 0, x.constant(1), select(c < 0, x.constant(-1), sign))
    return sign
