"""Kinds: named sets of blades with constraints that hold for every member, and a way to draw exact members.

A kind is plain data (its expressions are text). Its layout is the same blades with nothing known. What it claims is
proved in `verify`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from typing import Any, Protocol

import numpy as np

from .algebra import Algebra
from .errors import KindError
from .expression import evaluate
from .modular import Lanes, P
from .multivector import Multivector, from_values, reciprocal
from .rings import LaneRing, NumericRing, RationalRing, Ring


class Source(Protocol):
    """Random scalars of one ring."""

    @property
    def ring(self) -> Ring: ...

    def scalar(self) -> Any: ...


@dataclass(frozen=True, eq=False)
class Kind:
    """Blades of an algebra, what is known of their coefficients, and a random member.

    Attributes
    ----------
    name : str
        Identifier, unique in the algebra; the layout of a kind carries the kind's name.
    blades : tuple of int
        Bit masks in storage order.
    constraints : tuple of str
        Expressions in ``x`` that vanish on every member. Empty for a layout.
    member : str
        Program for a random exact member; empty: every coefficient is free.
    form : str
        "multivector"; "number": a plain number per item, arrays without a component axis (`codegen.scalar`);
        "numbers": a row of plain numbers, which a formula sees as a tuple of scalars.
    """

    algebra: Algebra
    name: str
    blades: tuple[int, ...]
    constraints: tuple[str, ...] = ()
    member: str = ""
    form: str = "multivector"

    @property
    def size(self) -> int:
        """Number of coefficients."""
        return len(self.blades)

    @cached_property
    def layout(self) -> Kind:
        """The same blades with nothing known."""
        return self if not self.constraints else replace(self, constraints=(), member="")

    @property
    def is_scalar_argument(self) -> bool:
        """Whether arrays of this kind have no component axis."""
        return self.form == "number"

    @property
    def is_layout(self) -> bool:
        """Whether nothing is known of the coefficients."""
        return not self.constraints

    @cached_property
    def identity(self) -> tuple[str, tuple[int, ...], tuple[str, ...], str]:
        """What makes two kinds the same."""
        return self.algebra.name, self.blades, self.constraints, self.form

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Kind) and self.identity == other.identity

    def __hash__(self) -> int:
        return hash(self.identity)

    def sample(self, source: Source) -> Multivector:
        """A random member over the source's ring: exact where the ring is."""
        ring = source.ring
        if self.form == "numbers":
            raise KindError("rows of plain numbers are no multivector; draw scalars one by one.")
        if not self.member:
            return from_values(self.algebra, ring, self.blades, [source.scalar() for _ in self.blades])
        like = Multivector(self.algebra, ring, {})

        def scalar() -> Multivector:
            return like.new({0: source.scalar()})

        def vector(*basis: Multivector) -> Multivector:
            total = like
            for b in basis:
                total = total + scalar() * b
            return total

        def unit(*basis: Multivector) -> Multivector:
            """Rational point of the unit sphere: stereographic projection from -basis[0]."""
            parameters = [scalar() for _ in basis[1:]]
            square = like.constant(0)
            for t in parameters:
                square = square + t * t
            point = (1 - square) * basis[0]
            for t, b in zip(parameters, basis[1:], strict=True):
                point = point + 2 * t * b
            return point * reciprocal(1 + square)

        functions = {"scalar": scalar, "vector": vector, "unit": unit}
        member = evaluate(self.member, like, {}, f"member of {self.algebra.name}.{self.name}", functions)
        if isinstance(ring, NumericRing):  # what rounding left on other blades is no part of the member
            return like.new({b: member.terms[b] for b in self.blades if b in member.terms})
        return member

    def values(self, x: Multivector) -> list[Any]:
        """Coefficients of ``x`` on this kind's blades, in order, zeros included."""
        zero = x.ring.constant(Fraction(0))
        return [x.terms.get(b, zero) for b in self.blades]

    def residuals(self, x: Multivector) -> list[Multivector]:
        """Values of the constraints at ``x``; they vanish for members."""
        where = f"constraint of {self.algebra.name}.{self.name}"
        return [evaluate(text, x, {"x": x}, where) for text in self.constraints]

    def violated(self, x: Multivector) -> str | None:
        """The first constraint that does not vanish at ``x`` (over an exact ring), or None."""
        blades = set(self.blades)
        outside = [b for b in x.terms if b not in blades]
        if outside:
            return f"it has the blade {self.algebra.blade_name(outside[0])}"
        for text, value in zip(self.constraints, self.residuals(x), strict=True):
            if value.terms:
                return f"{text} does not hold"
        return None

    def __repr__(self) -> str:
        return f"<{'layout' if self.is_layout else 'kind'} {self.name} of {self.algebra.name}>"


class LaneSource:
    """Random residues in every lane of a lane ring."""

    def __init__(self, ring: LaneRing, seed: int) -> None:
        self.ring = ring
        self.random = np.random.default_rng(seed)

    def scalar(self) -> Lanes:
        return Lanes(self.random.integers(1, P, self.ring.count, dtype=np.uint64))


class RationalSource:
    """Small random fractions."""

    def __init__(self, seed: int) -> None:
        self.ring = RationalRing()
        self.random = np.random.default_rng(seed)

    def scalar(self) -> Fraction:
        return Fraction(int(self.random.integers(-40, 41)) or 1, int(self.random.integers(1, 20)))


class NumericSource:
    """Normal floating-point numbers, ``count`` at a time; members hold their constraints to rounding."""

    def __init__(self, count: int, seed: int, scale: float = 1.0, dtype: Any = np.float64) -> None:
        self.ring = NumericRing(dtype)
        self.count = count
        self.scale = scale
        self.random = np.random.default_rng(seed)

    def scalar(self) -> Any:
        return (self.random.normal(size=self.count) * self.scale).astype(self.ring.dtype)


def add_plain_kinds(algebra: Algebra) -> None:
    """Kinds that every algebra has: one per grade, the even and odd parts, and everything (layouts all)."""
    names = {0: "scalar", 1: "vector", 2: "bivector", 3: "trivector", 4: "quadvector"}
    n = algebra.dimension
    for g in range(n + 1):
        name = names.get(g, f"grade{g}")
        if g == n and n > 4:
            name = "pseudoscalar"
        algebra.kinds.setdefault(name, Kind(algebra, name, tuple(algebra.blades_of_grade(g))))
    if n > 10:  # 2^n coefficients are no layout that anybody means
        return
    even = tuple(b for b in algebra.blades if b.bit_count() % 2 == 0)
    odd = tuple(b for b in algebra.blades if b.bit_count() % 2 == 1)
    for name, blades in (("even", even), ("odd", odd), ("multivector", algebra.blades)):
        algebra.kinds.setdefault(name, Kind(algebra, name, blades))


def scalar_argument(algebra: Algebra) -> Kind:
    """Kind of a plain number per item: arrays of shape (...), without a component axis."""
    return Kind(algebra, "number", (0,), form="number")


def numbers(algebra: Algebra, count: int) -> Kind:
    """Kind of a row of ``count`` plain numbers."""
    return Kind(algebra, f"numbers{count}", (0,) * count, form="numbers")
