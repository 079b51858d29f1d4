"""Members of kinds: random ones over any ring, exact where the ring is, and the values of constraints."""

from __future__ import annotations

from fractions import Fraction
from typing import Any, Protocol

import numpy as np

from ..errors import KindError
from ..rings.modular import P, Samples
from ..rings.protocol import NumericRing, RationalRing, Ring, SampleRing
from .algebra import Kind
from .multivector import Multivector, from_values, reciprocal
from .spec_language import evaluate

#: A constraint holds if its value is at most this many rounding units of the sum of its terms' absolute values:
#: room for the errors of a long chain of operations (1e-12 in double, 5e-4 in single precision).
TOLERANCE_ULPS = 4096
#: Sums of products of a few numbers of size 1 that are zero have less than this in single precision.
ROUNDING = 1e-5


class Source(Protocol):
    """Random scalars of one ring."""

    @property
    def ring(self) -> Ring: ...

    def scalar(self) -> Any: ...


class SampleSource:
    """Random residues at every sample point of a ring of samples."""

    def __init__(self, ring: SampleRing, seed: int) -> None:
        self.ring = ring
        self.random = np.random.default_rng(seed)

    def scalar(self) -> Samples:
        return Samples(self.random.integers(1, P, self.ring.count, dtype=np.uint64))


class RationalSource:
    """Small random fractions."""

    def __init__(self, seed: int) -> None:
        self.ring = RationalRing()
        self.random = np.random.default_rng(seed)

    def scalar(self) -> Fraction:
        return Fraction(int(self.random.integers(-40, 41)) or 1, int(self.random.integers(1, 20)))


class NumericSource:
    """Normal floating-point numbers, ``count`` at a time; members hold their constraints to rounding."""

    def __init__(
        self, count: int, seed: int | np.random.Generator | None, scale: float = 1.0, dtype: Any = np.float64
    ) -> None:
        self.ring = NumericRing(dtype)
        self.count = count
        self.scale = scale
        self.random = np.random.default_rng(seed)

    def scalar(self) -> Any:
        return (self.random.normal(size=self.count) * self.scale).astype(self.ring.dtype)


def sample(kind: Kind, source: Source) -> Multivector:
    """A random member of a kind over the source's ring: exact where the ring is."""
    ring = source.ring
    if kind.form == "numbers":
        raise KindError("a row of plain numbers is not a multivector; draw its scalars one by one.")
    if not kind.member:
        return from_values(kind.algebra, ring, kind.blades, [source.scalar() for _ in kind.blades])
    like = Multivector(kind.algebra, ring, {})

    def scalar() -> Multivector:
        return like.new({0: source.scalar()})

    def vector(*basis: Multivector) -> Multivector:
        total = like
        for b in basis:
            total = total + scalar() * b
        return total

    def unit(*basis: Multivector) -> Multivector:
        """Rational point of the quadric x^2 = basis[0]^2: stereographic projection from -basis[0]."""
        if not basis:
            raise KindError("unit() has no arguments.", remedy="Name the vectors that it is made of, unit(e1, e2)")
        first, others = basis[0], basis[1:]
        sign = _inner(first, first)
        if not any(_vanishes(c) for c in ((sign - 1).scalar(), (sign + 1).scalar())):
            raise KindError(
                "the first argument of unit(..) has a square other than 1 and -1.",
                remedy="Begin with one that has: the result has its square, as unit(e0, e1) of spacetime that of e0",
            )
        parameters = [scalar() for _ in others]
        square = like.constant(0)
        for i, (t, x) in enumerate(zip(parameters, others, strict=True)):
            if not _vanishes(_inner(first, x).scalar()):
                raise KindError(
                    "the first argument of unit(..) is not orthogonal to the others.",
                    remedy="Begin with one that is: unit(e1, no, ni), not unit(no + ni, no)",
                )
            square = square + t * t * _inner(x, x) * sign
            for u, y in zip(parameters[:i], others[:i], strict=True):
                if not _vanishes((inner := _inner(x, y)).scalar()):
                    square = square + 2 * t * u * inner * sign
        point = (1 - square) * first
        for t, x in zip(parameters, others, strict=True):
            point = point + 2 * t * x
        return point * reciprocal(1 + square)

    functions = {"scalar": scalar, "vector": vector, "unit": unit}
    member = evaluate(kind.member, like, {}, f"member of {kind.algebra.name}.{kind.name}", functions)
    if isinstance(ring, NumericRing):  # rounding errors on other blades are not part of the member
        return like.new({b: member.terms[b] for b in kind.blades if b in member.terms})
    return member


def _inner(x: Multivector, y: Multivector) -> Multivector:
    """(x y + y x)/2, which is a number for all arguments of unit(..)."""
    product = (x * y + y * x) / 2
    if not all(_vanishes(c) for blade, c in product.terms.items() if blade):
        raise KindError(
            "squares of sums of the arguments of unit(..) are no numbers.",
            remedy="Give it vectors, or blades of which any two anticommute, such as e12, e13 and e23",
        )
    return product.grade(0)


def _vanishes(coefficient: Any) -> bool:
    """Whether a coefficient of the arguments of unit(..) is zero; of floating-point numbers, but for rounding."""
    if isinstance(coefficient, tuple):  # a dual number
        return _vanishes(coefficient[0])
    if isinstance(coefficient, Samples):
        return bool(np.all(coefficient.is_zero()))
    return bool(coefficient == 0 if isinstance(coefficient, Fraction) else np.all(np.abs(coefficient) < ROUNDING))


def residuals(kind: Kind, x: Multivector) -> list[Multivector]:
    """Values of a kind's constraints at ``x``; they vanish for members."""
    where = f"constraint of {kind.algebra.name}.{kind.name}"
    return [evaluate(text, x, {"x": x}, where) for text in kind.constraints]


def violation(kind: Kind, x: Multivector) -> str | None:
    """The first constraint that does not vanish at ``x`` (over an exact ring), or None."""
    blades = set(kind.blades)
    outside = [b for b in x.terms if b not in blades]
    if outside:
        return f"it has the blade {kind.algebra.blade_name(outside[0])}"
    for text, value in zip(kind.constraints, residuals(kind, x), strict=True):
        if value.terms:
            return f"{text} does not hold"
    return None
