"""One multivector over any ring, with the operators of geometric algebra.

Formulas are written on this class. On a graph it traces a kernel; on numbers it is the kernel's reference.
Coefficients that the ring knows to be zero are dropped, so grades and blades follow from the mathematics.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from fractions import Fraction
from typing import Any

from .algebra import Algebra, grade, outer_sign, reverse_sign
from .errors import AlgebraMismatchError, BladeError, GradeError, TraceError
from .rings import Ring

Number = int | float | Fraction
#: Largest exponent in a formula: powers are products.
MAX_POWER = 16
#: For grades (a, b) and the grade c of one term of the geometric product: does the product keep it?
Filter = Callable[[int, int, int], bool]


def keep_outer(a: int, b: int, c: int) -> bool:
    """Outer product: the grades add."""
    return c == a + b


def keep_inner(a: int, b: int, c: int) -> bool:
    """Inner product of the thesis (1.2.2): the grades' difference, zero with scalars."""
    return c == abs(a - b) and a > 0 and b > 0


def keep_left(a: int, b: int, c: int) -> bool:
    """Left contraction."""
    return c == b - a


def keep_scalar(a: int, b: int, c: int) -> bool:
    """Scalar product <A B>_0."""
    return c == 0


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


class Multivector:
    """Sum of blades of ``algebra`` with coefficients in ``ring``."""

    __slots__ = ("algebra", "ring", "terms")
    __array_ufunc__ = None

    def __init__(self, algebra: Algebra, ring: Ring, terms: Mapping[int, Any]) -> None:
        self.algebra = algebra
        self.ring = ring
        self.terms = {b: terms[b] for b in algebra.order(terms) if not ring.is_zero(terms[b])}

    # -- construction --------------------------------------------------------------------------------------

    def new(self, terms: Mapping[int, Any]) -> Multivector:
        """Multivector of the same algebra and ring."""
        return Multivector(self.algebra, self.ring, terms)

    def constant(self, value: Number) -> Multivector:
        """Scalar constant."""
        return self.new({0: self.ring.constant(Fraction(value))})

    def basis(self, name: str) -> Multivector:
        """Basis blade of the same algebra, by name."""
        blade, sign = self.algebra.parse_blade(name)
        return self.new({blade: self.ring.constant(Fraction(sign))})

    def pseudoscalar(self) -> Multivector:
        """The algebra's pseudoscalar I, with its sign."""
        sign = Fraction(self.algebra.pseudoscalar_sign)
        return self.new({self.algebra.pseudoscalar: self.ring.constant(sign)})

    def _lift(self, other: Any) -> Multivector:
        if hasattr(other, "as_kind"):
            other = self._constant_object(other)
        if isinstance(other, Multivector):
            if other.algebra is not self.algebra:
                names = f"{self.algebra.name} and {other.algebra.name}"
                raise AlgebraMismatchError(f"the operands belong to different algebras, {names}; convert one first.")
            return other
        return self.constant(other)

    def _constant_object(self, other: Any) -> Multivector:
        """A runtime multivector inside a formula, such as ``cga.ni``: a constant of the formula."""
        if other.shape:
            raise TraceError(f"a batch of shape {other.shape} inside a formula is no constant; make it an argument.")
        values = zip(other.kind.blades, other.values, strict=True)
        terms = {b: self.ring.constant(Fraction(float(v))) for b, v in values if v != 0}
        return Multivector(other.algebra, self.ring, terms)

    # -- linear structure ----------------------------------------------------------------------------------

    def weighted(self, own: Number, other: Multivector | Number, weight: Number) -> Multivector:
        """``own * self + weight * other`` in one sum per blade."""
        lifted = self._lift(other)
        total: dict[int, Any] = {}
        for blade in self.algebra.order([*self.terms, *lifted.terms]):
            parts = [
                (mv.terms[blade], Fraction(scale)) for mv, scale in ((self, own), (lifted, weight)) if blade in mv.terms
            ]
            total[blade] = self.ring.combine(parts)
        return self.new(total)

    def sum(self, values: Iterable[Multivector]) -> Multivector:
        """Sum of several multivectors, one n-ary sum per blade."""
        gathered: dict[int, list[tuple[Any, Fraction]]] = {}
        for mv in values:
            for blade, c in self._lift(mv).terms.items():
                gathered.setdefault(blade, []).append((c, Fraction(1)))
        return self.new({b: self.ring.combine(parts) for b, parts in gathered.items()})

    def __add__(self, other: Multivector | Number) -> Multivector:
        return self.weighted(1, other, 1)

    def __sub__(self, other: Multivector | Number) -> Multivector:
        return self.weighted(1, other, -1)

    def __rsub__(self, other: Number) -> Multivector:
        return self.weighted(-1, other, 1)

    __radd__ = __add__

    def scaled(self, scale: Callable[[int], int | Fraction]) -> Multivector:
        """Each blade's coefficient times a rational that depends on the blade."""
        factors = {b: Fraction(scale(b)) for b in self.terms}
        return self.new({b: self.ring.combine([(c, factors[b])]) for b, c in self.terms.items() if factors[b]})

    def __neg__(self) -> Multivector:
        return self.scaled(lambda _: -1)

    def __invert__(self) -> Multivector:
        return self.scaled(reverse_sign)

    reverse = __invert__

    def involute(self) -> Multivector:
        """Grade involution: odd grades change sign."""
        return self.scaled(lambda b: -1 if grade(b) & 1 else 1)

    def conjugate(self) -> Multivector:
        """Clifford conjugation: reversion and involution."""
        return (~self).involute()

    def grade(self, *grades: int) -> Multivector:
        """Projection to grades."""
        return self.new({b: c for b, c in self.terms.items() if grade(b) in grades})

    @property
    def grades(self) -> tuple[int, ...]:
        """Grades present, ascending."""
        return tuple(sorted({grade(b) for b in self.terms}))

    def __getitem__(self, name: str) -> Multivector:
        """Coefficient of a blade as a scalar multivector."""
        blade, sign = self.algebra.parse_blade(name)
        return self.new({0: self.ring.combine([(self.terms[blade], Fraction(sign))])} if blade in self.terms else {})

    def coefficients(self) -> list[Multivector]:
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

    # -- products ------------------------------------------------------------------------------------------

    def product(self, other: Multivector | Number, keep: Filter | None = None) -> Multivector:
        """Geometric product, or the part of it that ``keep`` selects by the grades of operands and term."""
        right = self._lift(other)
        gathered: dict[int, list[tuple[Any, Fraction]]] = {}
        for a, x in self.terms.items():
            for b, y in right.terms.items():
                if keep is keep_outer and a & b:
                    continue
                table = ((a | b, Fraction(outer_sign(a, b))),) if keep is keep_outer else self.algebra.product(a, b)
                kept = [(c, w) for c, w in table if keep is None or keep(grade(a), grade(b), grade(c))]
                if kept:
                    xy = self.ring.multiply(x, y)
                    for c, w in kept:
                        gathered.setdefault(c, []).append((xy, w))
        return self.new({c: self.ring.combine(parts) for c, parts in gathered.items()})

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
        right = self._lift(other)
        gathered: dict[int, list[tuple[Any, Fraction]]] = {}
        for a, x in self.terms.items():
            for b, y in right.terms.items():
                table = dict(self.algebra.product(a, b))
                for c, w in self.algebra.product(b, a):
                    table[c] = table.get(c, Fraction(0)) + sign * w
                if any(table.values()):
                    xy = self.ring.multiply(x, y)
                    for c, w in table.items():
                        if w:
                            gathered.setdefault(c, []).append((xy, w / 2))
        return self.new({c: self.ring.combine(parts) for c, parts in gathered.items()})

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
            return self.complement().scaled(lambda b: -1 if grade(b) * (n - grade(b)) & 1 else 1)
        square = (self.pseudoscalar() * self.pseudoscalar()).terms[0]
        return self * self.pseudoscalar() * self.new({0: self.ring.apply("reciprocal", square)})

    def complement(self) -> Multivector:
        """The map J: each basis blade goes to the signed blade that completes it to I (any metric)."""
        full, sign = self.algebra.pseudoscalar, self.algebra.pseudoscalar_sign
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

    def __repr__(self) -> str:
        parts = " + ".join(f"{c!r} {self.algebra.blade_name(b)}" for b, c in self.terms.items())
        return f"<{self.algebra.name}: {parts or '0'}>"


def _function(name: str) -> Callable[..., Multivector]:
    def apply(first: Multivector, *others: Multivector) -> Multivector:
        values = [first.scalar(), *(first._lift(x).scalar() for x in others)]
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
