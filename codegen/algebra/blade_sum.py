"""Sums of blades over any ring: construction, grades and linear structure.

Coefficients that the ring knows to be zero are dropped, so grades and blades follow from the mathematics.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from fractions import Fraction
from typing import Any, Self

from ..errors import AlgebraMismatchError, GradeError, TraceError
from ..rings.protocol import Ring
from .algebra import Algebra
from .blades import grade, reverse_sign

Number = int | float | Fraction


class BladeSum:
    """Sum of blades of ``algebra`` with coefficients in ``ring``."""

    __slots__ = ("algebra", "ring", "terms")
    __array_ufunc__ = None

    def __init__(self, algebra: Algebra, ring: Ring, terms: Mapping[int, Any]) -> None:
        self.algebra = algebra
        self.ring = ring
        self.terms = {b: terms[b] for b in algebra.order(terms) if not ring.is_zero(terms[b])}

    # -- construction --------------------------------------------------------------------------------------

    def new(self, terms: Mapping[int, Any]) -> Self:
        """Sum of blades of the same algebra and ring."""
        return type(self)(self.algebra, self.ring, terms)

    def constant(self, value: Number) -> Self:
        """Scalar constant."""
        return self.new({0: self.ring.constant(Fraction(value))})

    def basis(self, name: str) -> Self:
        """Basis blade of the same algebra, by name."""
        blade, sign = self.algebra.parse_blade(name)
        return self.new({blade: self.ring.constant(Fraction(sign))})

    def pseudoscalar(self) -> Self:
        """The algebra's pseudoscalar I, with its sign."""
        sign = Fraction(self.algebra.pseudoscalar_sign)
        return self.new({self.algebra.full_blade: self.ring.constant(sign)})

    def _lift(self, other: Any) -> Self:
        if hasattr(other, "as_kind"):
            other = self._constant_object(other)
        if isinstance(other, type(self)):
            if other.algebra is not self.algebra:
                names = f"{self.algebra.name} and {other.algebra.name}"
                raise AlgebraMismatchError(f"the operands belong to different algebras, {names}; convert one first.")
            return other
        return self.constant(other)

    def _constant_object(self, other: Any) -> Self:
        """A runtime multivector inside a formula, such as ``cga.ni``: a constant of the formula."""
        if other.shape:
            raise TraceError(f"a batch of shape {other.shape} inside a formula is not a constant; make it an argument.")
        values = zip(other.kind.blades, other.values, strict=True)
        terms = {b: self.ring.constant(Fraction(float(v))) for b, v in values if v != 0}
        return type(self)(other.algebra, self.ring, terms)

    # -- linear structure ----------------------------------------------------------------------------------

    def linear_combination(self, own: Number, other: Self | Number, weight: Number) -> Self:
        """``own * self + weight * other`` in one sum per blade."""
        lifted = self._lift(other)
        total: dict[int, Any] = {}
        for blade in self.algebra.order([*self.terms, *lifted.terms]):
            parts = [
                (mv.terms[blade], Fraction(scale)) for mv, scale in ((self, own), (lifted, weight)) if blade in mv.terms
            ]
            total[blade] = self.ring.combine(parts)
        return self.new(total)

    def sum(self, values: Iterable[Self]) -> Self:
        """Sum of several multivectors, one n-ary sum per blade."""
        gathered: dict[int, list[tuple[Any, Fraction]]] = {}
        for mv in values:
            for blade, c in self._lift(mv).terms.items():
                gathered.setdefault(blade, []).append((c, Fraction(1)))
        return self.new({b: self.ring.combine(parts) for b, parts in gathered.items()})

    def __add__(self, other: Self | Number) -> Self:
        return self.linear_combination(1, other, 1)

    def __sub__(self, other: Self | Number) -> Self:
        return self.linear_combination(1, other, -1)

    def __rsub__(self, other: Number) -> Self:
        return self.linear_combination(-1, other, 1)

    __radd__ = __add__

    def scale_blades(self, scale: Callable[[int], int | Fraction]) -> Self:
        """Each blade's coefficient times a rational that depends on the blade."""
        factors = {b: Fraction(scale(b)) for b in self.terms}
        return self.new({b: self.ring.combine([(c, factors[b])]) for b, c in self.terms.items() if factors[b]})

    def __neg__(self) -> Self:
        return self.scale_blades(lambda _: -1)

    def __invert__(self) -> Self:
        return self.scale_blades(reverse_sign)

    reverse = __invert__

    def involute(self) -> Self:
        """Grade involution: odd grades change sign."""
        return self.scale_blades(lambda b: -1 if grade(b) & 1 else 1)

    def conjugate(self) -> Self:
        """Clifford conjugation: reversion and involution."""
        return (~self).involute()

    def grade(self, *grades: int) -> Self:
        """Projection to grades."""
        return self.new({b: c for b, c in self.terms.items() if grade(b) in grades})

    @property
    def grades(self) -> tuple[int, ...]:
        """Grades present, ascending."""
        return tuple(sorted({grade(b) for b in self.terms}))

    def __getitem__(self, name: str) -> Self:
        """Coefficient of a blade as a scalar multivector."""
        blade, sign = self.algebra.parse_blade(name)
        return self.new({0: self.ring.combine([(self.terms[blade], Fraction(sign))])} if blade in self.terms else {})

    def coefficients(self) -> list[Self]:
        """All coefficients, in storage order, as scalars."""
        return [self.new({0: c}) for c in self.terms.values()]

    def scalar(self) -> Any:
        """The scalar coefficient of a scalar multivector.

        On numbers, other parts are rounding errors and are ignored; on a graph they are an error of the formula.
        """
        others = [b for b in self.terms if b]
        if others and getattr(self.ring, "is_symbolic", False):
            names = ", ".join(self.algebra.blade_name(b) for b in others[:4])
            raise GradeError(f"a scalar is needed here, but the value also has {names}; take .grade(0) if it is meant.")
        return self.terms.get(0, self.ring.constant(Fraction(0)))

    def __repr__(self) -> str:
        parts = " + ".join(f"{c!r} {self.algebra.blade_name(b)}" for b, c in self.terms.items())
        return f"<{self.algebra.name}: {parts or '0'}>"
