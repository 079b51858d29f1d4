"""Symbolic multivectors as compiled functions of their symbols."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any

import sympy

from ...codegen.algebra import multivector as formulas
from ...codegen.algebra.algebra import scalar_argument
from ...codegen.algebra.multivector import Multivector
from ...codegen.api import KernelFunction
from ...codegen.errors import InputError, one_line
from ...codegen.rings import expressions

#: Functions of one scalar that kernels compute.
FUNCTIONS: dict[Any, Callable[[Multivector], Multivector]] = {
    sympy.sin: formulas.sin,
    sympy.cos: formulas.cos,
    sympy.tan: lambda x: formulas.sin(x) / formulas.cos(x),
    sympy.exp: formulas.exp,
    sympy.log: formulas.log,
    sympy.Abs: formulas.absolute,
    sympy.sinh: lambda x: x * formulas.stumpff1(-x * x),
    sympy.cosh: lambda x: formulas.stumpff0(-x * x),
    sympy.sinc: lambda x: formulas.stumpff1(x * x),
}
#: Whole powers to this are products, a few more for each doubling; others are exp(y log x), of positive x.
MAX_EXPONENT = 2**53
#: The sign of w in c_1(w) = sin(r)/r or sinh(r)/r, r^2 = w or -w: regular at zero, where the quotient is not.
QUOTIENTS = {sympy.sin: 1, sympy.sinh: -1}
#: Quotients of one power that are taken apart.
MAX_QUOTIENTS = 64


def lambdify(x: Any, symbols: Sequence[Any], target: str) -> Callable[..., Any]:
    """See `SymbolicMultivector.lambdify`."""
    own = x.free_symbols
    order = list(symbols) or sorted(own, key=lambda s: s.name)
    for symbol in order:
        if not isinstance(symbol, sympy.Symbol):
            raise InputError(f"{one_line(symbol)} is no symbol; lambdify takes the symbols of the arguments, in order.")
    missing = sorted(s.name for s in own - set(order))
    if missing:
        raise InputError(f"the coefficients have the symbols {', '.join(missing)}, which are no arguments.")
    if len(set(order)) != len(order):
        raise InputError("a symbol stands twice among the arguments.")
    if not order:
        raise InputError("the multivector has no symbols: it is a constant.", remedy="Use alg.multivector")
    algebra = x.algebra
    coefficients = {blade: expressions.to_sympy(polynomial) for blade, polynomial in x.terms.items()}

    def formula(*arguments: Multivector) -> Multivector:
        values = Values(arguments[0], dict(zip(order, arguments, strict=True)))
        return arguments[0].new({blade: values.of(e).scalar() for blade, e in coefficients.items()})

    names = [f"x{i}" for i in range(len(order))]
    formula.__doc__ = "A symbolic multivector."
    kinds = [scalar_argument(algebra)] * len(order)
    kernel = KernelFunction(formula, kinds, None, "symbolic", algebra, names, search=False)
    run = kernel.on(target)  # refuses unknown targets
    kind = kernel.traced.outputs[0].kind  # traces: what has no compiled form is refused here

    def function(*arguments: Any) -> Any:
        if len(arguments) != len(order):
            raise InputError(f"the function takes {len(order)} arguments: {', '.join(s.name for s in order)}.")
        return algebra.wrap(kind.layout, run(*arguments))

    function.__doc__ = f"Multivector of {algebra.name} from {', '.join(s.name for s in order)}."
    return function


class Values:
    """Expressions on the coefficients of a kernel's graph."""

    def __init__(self, like: Multivector, known: dict[Any, Multivector]) -> None:
        self.like = like
        self.known = known

    def of(self, e: Any) -> Multivector:
        """The scalar of an expression."""
        value = self.known.get(e)
        if value is None:
            value = self.known[e] = self._made(e)
        return value

    def _made(self, e: Any) -> Multivector:
        if e.is_Rational:
            exact = Fraction(int(e.p), int(e.q))
            if abs(exact) > sys.float_info.max:
                raise InputError(f"{one_line(e)} is beyond the range of numbers.")
            return self.like.constant(exact)
        if e.is_number and e.is_real:
            number = float(e)
            if math.isfinite(number):
                return self.like.constant(Fraction(number))
        if e.is_Add:
            return self.like.sum(self.of(term) for term in e.args)
        if e.is_Mul:
            return self._product(list(e.args))
        if e.is_Pow:
            exponent = e.exp if e.exp.is_Rational else sympy.Rational(float(e.exp)) if e.exp.is_Float else None
            if exponent is not None and exponent.q in (1, 2) and abs(exponent.p) <= MAX_EXPONENT:
                return self._power(e.base, int(exponent.p), int(exponent.q))
            return formulas.exp(self.of(e.exp) * formulas.log(self.of(e.base)))
        if e.func is sympy.atan2:
            return formulas.atan2(self.of(e.args[0]), self.of(e.args[1]))
        if e.func in FUNCTIONS:
            return FUNCTIONS[e.func](self.of(e.args[0]))
        raise InputError(
            f"{one_line(e)} has no compiled form; there are sums, products, powers, sin, cos, tan, exp, log, sqrt, "
            "Abs, sinh, cosh, sinc and atan2."
        )

    def _product(self, factors: list[Any]) -> Multivector:
        result = self.like.constant(1)
        for factor in list(factors):
            base, times = factor.as_base_exp()
            sign = QUOTIENTS.get(base.func)
            if not sign or not times.is_Integer:
                continue
            rest = sympy.Mul(*(f for f in factors if f is not factor))
            argument, taken = base.args[0], 0
            while taken < min(times, MAX_QUOTIENTS) and _takes_away(argument, rest):
                rest, taken = rest * argument, taken + 1
                result = result * formulas.stumpff1(sign * self.of(argument**2))
            if taken:
                factors = [*sympy.Mul.make_args(rest), base ** (times - taken)]
        for factor in factors:
            result = result * self.of(factor)
        return result

    def _power(self, base: Any, p: int, q: int) -> Multivector:
        root = self.of(base) if q == 1 else formulas.sqrt(self.of(base))
        result = self.like.constant(1)
        square, rest = root, abs(p)
        while rest:
            result = result * square if rest & 1 else result
            square, rest = square * square, rest >> 1
        return formulas.reciprocal(result) if p < 0 else result


def _takes_away(divisor: Any, product: Any) -> bool:
    """Test whether a product has negative powers that those of a divisor take away."""
    powers = product.as_powers_dict()
    own = [(b, e) for b, e in divisor.as_powers_dict().items() if not b.is_number]
    return any(b in powers and powers[b].is_negative and e.is_positive for b, e in own)
