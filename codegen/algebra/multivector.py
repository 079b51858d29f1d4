"""One multivector over any ring, with the operators of geometric algebra.

Formulas are written on this class. On a graph it traces a kernel; on numbers it is the kernel's reference.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from fractions import Fraction
from typing import Any

from ..errors import BladeError, GradeError, TraceError
from ..rings.protocol import Ring
from .algebra import Algebra
from .blade_sum import BladeSum, Number
from .blades import grade, outer_sign
from .product_terms import Filter, TermTable, keep_inner, keep_left, keep_outer, keep_right, keep_scalar, product_terms

#: Largest exponent in a formula: powers are products.
MAX_POWER = 16


class Mask:
    """Result of a comparison; only `select`, ``&``, ``|`` and ``~`` take it."""

    def __init__(self, ring: Ring, value: Any) -> None:
        self.ring = ring
        self.value = value

    def __bool__(self) -> bool:
        raise TraceError(
            "a comparison inside a formula has no truth value: a kernel computes both branches. Write "
            "codegen.select(mask, a, b) instead of if, and &, |, ~ instead of and, or, not, chains and max."
        )

    def __and__(self, other: Mask) -> Mask:
        return Mask(self.ring, self.ring.apply("and", self.value, other.value))

    def __or__(self, other: Mask) -> Mask:
        return Mask(self.ring, self.ring.apply("or", self.value, other.value))

    def __invert__(self) -> Mask:
        return Mask(self.ring, self.ring.apply("not", self.value))


class Multivector(BladeSum):
    """Multivector of ``algebra`` with coefficients in ``ring``: products, duality and comparisons of scalars."""

    __slots__ = ()

    # -- products ------------------------------------------------------------------------------------------

    def bilinear(
        self, other: Multivector | Number, terms: TermTable, multiply: Callable[[Any, Any], Any] | None = None
    ) -> Multivector:
        """Product with the given terms for each pair of blades; ``multiply`` multiplies coefficients."""
        right, multiply = self._lift(other), multiply or self.ring.multiply
        gathered: dict[int, list[tuple[Any, Fraction]]] = {}
        for a, x in self.terms.items():
            for b, y in right.terms.items():
                kept = list(terms(a, b))
                if kept:
                    xy = multiply(x, y)
                    for c, w in kept:
                        gathered.setdefault(c, []).append((xy, w))
        return self.new({c: self.ring.combine(parts) for c, parts in gathered.items()})

    def product(self, other: Multivector | Number, keep: Filter | None = None) -> Multivector:
        """Geometric product, or the part of it that ``keep`` selects by the grades of operands and term."""
        return self.bilinear(other, product_terms(self.algebra, keep))

    def __mul__(self, other: Multivector | Number) -> Multivector:
        return self.product(other)

    def __rmul__(self, other: Any) -> Multivector:
        return self._lift(other).product(self)

    def __xor__(self, other: Multivector | Number) -> Multivector:
        return self.product(other, keep_outer)

    def __or__(self, other: Multivector | Number) -> Multivector:
        return self.product(other, keep_inner)

    def __rxor__(self, other: Any) -> Multivector:
        return self._lift(other) ^ self

    def __ror__(self, other: Any) -> Multivector:
        return self._lift(other) | self

    def __rand__(self, other: Any) -> Multivector:
        return self._lift(other) & self

    def __rrshift__(self, other: Any) -> Multivector:
        return self._lift(other) >> self

    def __pow__(self, exponent: int) -> Multivector:
        if isinstance(exponent, bool) or not isinstance(exponent, int) or not 0 <= exponent <= MAX_POWER:
            raise TraceError(f"x ** {exponent!r}: powers in formulas are whole numbers from 0 to {MAX_POWER}.")
        power = self.constant(1)
        for _ in range(exponent):
            power = power * self
        return power

    outer, inner = __xor__, __or__

    def left_contraction(self, other: Multivector | Number) -> Multivector:
        """Left contraction: the part of grade (right - left)."""
        return self.product(other, keep_left)

    def right_contraction(self, other: Multivector | Number) -> Multivector:
        """Right contraction: the part of grade (left - right)."""
        return self.product(other, keep_right)

    def scalar_product(self, other: Multivector | Number) -> Multivector:
        """<A B>_0; unlike the inner product it is not zero with scalars."""
        return self.product(other, keep_scalar)

    def commutator(self, other: Multivector | Number) -> Multivector:
        """(A B - B A)/2."""
        return self._symmetric(other, -1)

    def anticommutator(self, other: Multivector | Number) -> Multivector:
        """(A B + B A)/2."""
        return self._symmetric(other, 1)

    def _symmetric(self, other: Multivector | Number, sign: int) -> Multivector:
        def terms(a: int, b: int) -> list[tuple[int, Fraction]]:
            total = dict(self.algebra.product(a, b))
            for c, w in self.algebra.product(b, a):
                total[c] = total.get(c, Fraction(0)) + sign * w
            return [(c, w / 2) for c, w in total.items() if w]

        return self.bilinear(other, terms)

    def __rshift__(self, other: Multivector) -> Multivector:
        """Sandwich R x ~R."""
        return self * other * ~self

    sandwich = __rshift__

    def __truediv__(self, other: Multivector | Number) -> Multivector:
        if not isinstance(other, Multivector):
            return self * (1 / Fraction(other))
        return self * reciprocal(other)

    def __rtruediv__(self, other: Number) -> Multivector:
        return reciprocal(self) * other

    # -- duality -------------------------------------------------------------------------------------------

    def dual(self) -> Multivector:
        """X I where I is invertible, else the map J with X ^ J(X) = I on basis blades (thesis 1.4.5)."""
        return self.complement() if self.algebra.is_degenerate else self * self.pseudoscalar()

    def undual(self) -> Multivector:
        """Inverse of `dual`."""
        if self.algebra.is_degenerate:
            n = self.algebra.dimension
            return self.complement().scale_blades(lambda b: -1 if grade(b) * (n - grade(b)) & 1 else 1)
        square = (self.pseudoscalar() * self.pseudoscalar()).terms[0]
        return self * self.pseudoscalar() * self.new({0: self.ring.apply("reciprocal", square)})

    def complement(self) -> Multivector:
        """The map J: each basis blade goes to the signed blade that completes it to I (any metric)."""
        full, sign = self.algebra.full_blade, self.algebra.pseudoscalar_sign
        return self.new(
            {
                full ^ b: self.ring.combine([(c, Fraction(sign * outer_sign(b, full ^ b)))])
                for b, c in self.terms.items()
            }
        )

    def meet(self, other: Multivector) -> Multivector:
        """Intersection: ``^`` where objects are built from planes (degenerate metrics), else the regressive product."""
        return self ^ other if self.algebra.is_degenerate else self & other

    def join(self, other: Multivector) -> Multivector:
        """Span of disjoint objects: the other one of the two products."""
        return self & other if self.algebra.is_degenerate else self ^ other

    def __and__(self, other: Multivector) -> Multivector:
        """Regressive product: X v Y = (X* ^ Y*) I, or J^-1(J X ^ J Y) where the metric is degenerate."""
        right = self._lift(other)
        outer = self.dual() ^ right.dual()
        return outer.undual() if self.algebra.is_degenerate else outer * self.pseudoscalar()

    # -- comparisons of scalars ----------------------------------------------------------------------------

    def __lt__(self, other: Multivector | Number) -> Mask:
        return Mask(self.ring, self.ring.apply("lt", self.scalar(), self._lift(other).scalar()))

    def __le__(self, other: Multivector | Number) -> Mask:
        return Mask(self.ring, self.ring.apply("le", self.scalar(), self._lift(other).scalar()))

    def __gt__(self, other: Multivector | Number) -> Mask:
        return self._lift(other) < self

    def __ge__(self, other: Multivector | Number) -> Mask:
        return self._lift(other) <= self


def _function(name: str) -> Callable[..., Multivector]:
    def apply(first: Multivector, *others: Multivector) -> Multivector:
        if not isinstance(first, Multivector):
            what = f"codegen.{name} is a function of values in formulas; this is a {type(first).__name__}."
            raise TraceError(what, remedy="Elsewhere numbers have NumPy's functions, and multivectors methods")
        try:
            values = [first.scalar(), *(first._lift(x).scalar() for x in others)]
        except GradeError as error:
            better = f"Of multivectors it is codegen.ga.{name}" if name in ("exp", "log", "sqrt") else None
            raise GradeError(f"{name} is that of scalars: {error.what}", remedy=better) from None
        return first.new({0: first.ring.apply(name, *values)})

    apply.__name__ = name
    apply.__doc__ = f"{name} of scalars."
    return apply


sqrt = _function("sqrt")
reciprocal = _function("reciprocal")
absolute = _function("abs")
sin = _function("sin")
cos = _function("cos")
exp = _function("exp")
log = _function("log")
atan2 = _function("atan2")
stumpff0 = _function("stumpff0")
stumpff1 = _function("stumpff1")
stumpff2 = _function("stumpff2")
stumpff3 = _function("stumpff3")


def select(mask: Mask, a: Multivector | Number, b: Multivector | Number) -> Multivector:
    """a where the mask holds, else b, coefficient by coefficient (a blend each: select scalars where you can)."""
    first = a if isinstance(a, Multivector) else b
    if not isinstance(first, Multivector):
        raise BladeError("select needs a multivector in one of its branches; write x.constant(value) for a number.")
    left, right = first._lift(a), first._lift(b)
    zero = first.ring.constant(Fraction(0))
    blades = first.algebra.order([*left.terms, *right.terms])
    return first.new(
        {k: first.ring.select(mask.value, left.terms.get(k, zero), right.terms.get(k, zero)) for k in blades}
    )


def from_values(algebra: Algebra, ring: Ring, blades: Iterable[int], values: Iterable[Any]) -> Multivector:
    """Multivector from blades and coefficients."""
    return Multivector(algebra, ring, dict(zip(blades, values, strict=True)))
