"""Multivectors whose coefficients are SymPy expressions."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from fractions import Fraction
from operator import index
from typing import Any, Self

import sympy

from ...codegen.algebra.algebra import Algebra
from ...codegen.algebra.multivector import Multivector, absolute, sqrt
from ...codegen.errors import InputError, NotInvertibleError, TraceError, one_line
from ...codegen.formulas.products import inverses
from ...codegen.rings import expressions
from ...codegen.rings.expressions import ExpressionRing, Polynomial
from . import exponential, text

RING = ExpressionRing()
#: What SymPy has for expressions without a value.
NO_NUMBERS = (sympy.nan, sympy.oo, -sympy.oo, sympy.zoo, sympy.AccumBounds, sympy.Order)


class SymbolicMultivector(Multivector):
    """A multivector with SymPy expressions for coefficients; made by ``alg.multivector({"e1": a})`` or ``alg.symbols``.

    It has the operators of all multivectors, with numbers, SymPy expressions and numeric multivectors on either side.
    Products are expanded: coefficients are polynomials in symbols, functions and inverses.
    """

    __slots__ = ()

    # -- coefficients --------------------------------------------------------------------------------------

    def coefficient(self, name: str) -> Any:
        """The SymPy expression at a blade, in the sign of the name's order of vectors."""
        blade, sign = self.algebra.parse_blade(name)
        return expressions.to_sympy(self.terms[blade]) * sign if blade in self.terms else sympy.Integer(0)

    @property
    def expressions(self) -> dict[str, Any]:
        """SymPy expressions by blade, of the blades whose coefficients are not zero."""
        return {self.algebra.blade_name(b): expressions.to_sympy(p) for b, p in self.terms.items()}

    @property
    def free_symbols(self) -> set[Any]:
        """Symbols of all coefficients."""
        return set().union(*(e.free_symbols for e in self.expressions.values()))

    def applyfunc(self, function: Callable[[Any], Any]) -> Self:
        """The multivector whose coefficients are a function of these.

        Raises
        ------
        InputError
            If one is no number or expression, or not finite: where a pole is substituted, for instance.
        """
        return self.new({b: as_polynomial(function(expressions.to_sympy(p))) for b, p in self.terms.items()})

    def _by_sympy(self, name: str, function: Callable[[Any], Any]) -> Self:
        """`applyfunc` of a function that refuses arguments in its own way."""
        try:
            return self.applyfunc(function)
        except InputError:
            raise
        except (ValueError, TypeError) as error:
            raise InputError(f"{name}: {one_line(error)}") from None

    def subs(self, *arguments: Any, **options: Any) -> Self:
        """Substitution in all coefficients, as of SymPy's ``subs``."""
        return self._by_sympy("subs", lambda e: e.subs(*arguments, **options))

    def diff(self, *symbols: Any) -> Self:
        """Derivative by symbols, as of SymPy's ``diff``."""
        return self._by_sympy("diff", lambda e: e.diff(*symbols))

    def integrate(self, *symbols: Any) -> Self:
        """Integral of each coefficient, as of SymPy's ``integrate``."""
        return self._by_sympy("integrate", lambda e: sympy.integrate(e, *symbols))

    def simplify(self, **options: Any) -> Self:
        """Each coefficient simplified by SymPy."""
        return self.applyfunc(lambda e: sympy.simplify(e, **options))

    def expand(self, **options: Any) -> Self:
        """Each coefficient expanded by SymPy, functions included where the options say so (``trig=True``)."""
        return self.applyfunc(lambda e: e.expand(**options))

    def evalf(self, *arguments: Any, **options: Any) -> Self:
        """Numbers in place of exact constants, as of SymPy's ``evalf``."""
        return self.applyfunc(lambda e: e.evalf(*arguments, **options))

    def equals(self, other: Any) -> bool:
        """Whether all coefficients are equal, by SymPy's simplification."""
        return all(sympy.simplify(e) == 0 for e in (self - other).expressions.values())

    # -- functions -----------------------------------------------------------------------------------------

    def inverse(self) -> Self:
        """The y with x y = 1: ~x / (x ~x) where that is a number, else Shirokov's recursion.

        Raises
        ------
        NotInvertibleError
            If the denominator is zero.
        """
        square = self * ~self
        if not set(square.terms) - {0}:
            if not square.terms:
                raise NotInvertibleError("x ~x is zero: the multivector has no inverse.")
            return self.new((~self * self.new({0: _over(square.terms[0])})).terms)
        adjugate: Any = inverses.shirokov_adjugate(self)
        determinant = (self * adjugate).terms.get(0)
        if not determinant:
            raise NotInvertibleError("the multivector has no inverse: its determinant is zero.")
        return self.new((adjugate * self.new({0: _over(determinant)})).terms)

    def exp(self) -> Self:
        """Exponential of what has a number for its square, such as a simple bivector.

        cos, sin or cosh, sinh by the sign of the square, where that shows: of all its terms, or of its symbols.

        Raises
        ------
        GradeError
            If the square is not a number.
        """
        return self.new(exponential.exp(self).terms)

    def norm(self) -> Any:
        """The expression ``sqrt |<x ~x>_0|``."""
        return sympy.simplify(expressions.to_sympy(sqrt(absolute((self * ~self).grade(0))).scalar()))

    def normalized(self) -> Self:
        """The multivector over its norm."""
        square = (self * ~self).grade(0)
        if not square.terms:
            raise NotInvertibleError("<x ~x>_0 is zero: the multivector has no norm to divide by.")
        return self.new((self / sqrt(absolute(square))).terms)

    normalised = normalized

    def __pow__(self, exponent: Any) -> Multivector:
        try:
            whole = index(int(exponent) if isinstance(exponent, float) and exponent.is_integer() else exponent)
        except TypeError:
            what = f"the exponent is {one_line(exponent)}; powers of symbolic multivectors are whole numbers."
            raise TraceError(what) from None
        return super().__pow__(whole) if whole >= 0 else self.inverse() ** -whole

    def __truediv__(self, other: Any) -> Multivector:
        right = self._lift(other)
        return self * right.inverse()

    def __rtruediv__(self, other: Any) -> Multivector:
        return self._lift(other) * self.inverse()

    def lambdify(self, *symbols: Any, target: str = "c") -> Callable[..., Any]:
        """A compiled function of numbers, or arrays that broadcast, for the symbols; gives a numeric multivector.

        Parameters
        ----------
        *symbols : sympy.Symbol
            In the order of the arguments. Default: all, by name.
        target : str
            "c", "numba", "cuda" or "numpy".

        Raises
        ------
        InputError
            If a symbol of the coefficients is not among them, or a function has no compiled form.
        """
        from .lambdify import lambdify

        return lambdify(self, symbols, target)

    # -- what operands become ------------------------------------------------------------------------------

    def constant(self, value: Any) -> Self:
        """A number or an expression as a scalar.

        Raises
        ------
        InputError
            If it is neither.
        """
        return self.new({0: as_polynomial(value)})

    def _constant_object(self, other: Any) -> Self:
        """A numeric multivector: whole numbers become exact, others stay floats."""
        if other.shape:
            raise TraceError(f"a batch of shape {other.shape} beside symbols is not one multivector; take its items.")
        values = zip(other.kind.blades, other.values.tolist(), strict=True)
        return type(self)(other.algebra, self.ring, {b: as_polynomial(v) for b, v in values if v != 0})

    # -- text ----------------------------------------------------------------------------------------------

    def __repr__(self) -> str:
        return text.plain(self.algebra, self.terms)

    def _repr_latex_(self) -> str:
        return f"${text.latex(self.algebra, self.terms)}$"

    def __reduce__(self) -> tuple[Any, ...]:
        values = {b: expressions.to_sympy(p) for b, p in self.terms.items()}  # atoms are numbered in each process
        return from_expressions, (self.algebra, values)

    def __iter__(self) -> Iterator[Any]:
        raise TypeError("a symbolic multivector has no items; its coefficients are .expressions")


def _over(denominator: Polynomial) -> Polynomial:
    try:
        return expressions.reciprocal(denominator)
    except ZeroDivisionError:
        raise NotInvertibleError("the multivector has no inverse: its denominator is zero.") from None


def as_polynomial(value: Any) -> Polynomial:
    """A number or a SymPy expression as a coefficient; floats that are whole become exact.

    Raises
    ------
    InputError
        If it is neither, or not finite.
    """
    if isinstance(value, bool | str):
        raise InputError(f"a coefficient is {value!r}; numbers and SymPy expressions are coefficients.")
    if isinstance(value, float) and value.is_integer():
        value = int(value)
    if isinstance(value, int | float | Fraction):
        if value - value != 0:
            raise InputError(f"a coefficient is {value}; numbers are finite.")
        return expressions.from_sympy(value)
    try:
        expression = sympy.sympify(value, strict=True)
    except (sympy.SympifyError, TypeError, AttributeError):
        expression = None
    if not isinstance(expression, sympy.Expr) or expression.has(*NO_NUMBERS):
        raise InputError(f"a coefficient is {value!r}; numbers and SymPy expressions are coefficients.")
    if not expression.is_commutative:
        raise InputError(f"a coefficient is {one_line(value)}, which does not commute; coefficients do, as numbers.")
    return expressions.from_sympy(expression)


def from_expressions(algebra: Algebra, values: Mapping[int, Any]) -> SymbolicMultivector:
    """A multivector of expressions by blade."""
    return SymbolicMultivector(algebra, RING, {b: as_polynomial(v) for b, v in values.items()})
