"""Forward derivatives: a formula run on dual numbers over any ring is its own derivative.

Over a graph it becomes a kernel, over mpmath numbers the reference. The differentiated input is traced on its
layout: on a kind with constraints known, reductions would hide directions in which the formula varies.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any

from .errors import TraceError
from .kinds import Kind
from .multivector import Multivector
from .rings import Ring, Terms
from .trace import Formula, Result, as_outputs

#: A value and its tangent; the tangent None is zero.
Dual = tuple[Any, Any]
_HALF = Fraction(1, 2)


class DualRing:
    """Values with tangents over a base ring."""

    def __init__(self, base: Ring) -> None:
        self.base = base
        self.is_symbolic = getattr(base, "is_symbolic", False)

    def constant(self, value: Fraction) -> Dual:
        return self.base.constant(value), None

    def combine(self, terms: Terms) -> Dual:
        values = self.base.combine([(c[0], w) for c, w in terms])
        tangents = [(c[1], w) for c, w in terms if c[1] is not None]
        return values, self.base.combine(tangents) if tangents else None

    def multiply(self, a: Dual, b: Dual) -> Dual:
        parts = []
        if a[1] is not None:
            parts.append((self.base.multiply(a[1], b[0]), Fraction(1)))
        if b[1] is not None:
            parts.append((self.base.multiply(a[0], b[1]), Fraction(1)))
        return self.base.multiply(a[0], b[0]), self.base.combine(parts) if parts else None

    def apply(self, name: str, *arguments: Any) -> Any:
        base = self.base
        if name in ("and", "or", "not"):
            return base.apply(name, *arguments)
        if name in ("lt", "le"):
            return base.apply(name, arguments[0][0], arguments[1][0])
        value = base.apply(name, *(a[0] for a in arguments))
        if not arguments:  # where there is no value there is no derivative
            return value, value if name == "nan" else None
        parts = [
            (base.multiply(factor(), a[1]), Fraction(1))
            for factor, a in zip(self._factors(name, value, [a[0] for a in arguments]), arguments, strict=True)
            if a[1] is not None
        ]
        return value, base.combine(parts) if parts else None

    def _factors(self, name: str, value: Any, x: Sequence[Any]) -> Sequence[Callable[[], Any]]:
        """Partial derivatives of a function, as thunks: made only for arguments that vary."""
        base = self.base
        one = base.constant(Fraction(1))

        def scaled(a: Any, w: Fraction) -> Any:
            return base.combine([(a, w)])

        def stumpff(k: int, w: Any) -> Any:
            return base.apply(f"stumpff{k}", w)

        if name.startswith("stumpff"):  # c_k' = (k c_{k+2} - c_{k+1})/2
            k = int(name[-1])
            if k > 3:
                raise TraceError(f"the derivative of {name} needs Stumpff functions beyond the fifth.")
            higher: list[tuple[Any, Fraction]] = [(stumpff(k + 1, x[0]), -_HALF)]
            if k:
                higher.append((stumpff(k + 2, x[0]), _HALF * k))
            return [lambda: base.combine(higher)]
        rules: dict[str, list[Callable[[], Any]]] = {
            "sqrt": [lambda: scaled(base.apply("reciprocal", value), _HALF)],
            "reciprocal": [lambda: scaled(base.multiply(value, value), Fraction(-1))],
            "abs": [
                lambda: base.select(base.apply("lt", x[0], base.constant(Fraction(0))), scaled(one, Fraction(-1)), one)
            ],
            "sin": [lambda: base.apply("cos", x[0])],
            "cos": [lambda: scaled(base.apply("sin", x[0]), Fraction(-1))],
            "exp": [lambda: value],
            "rounded": [lambda: one],
            "log": [lambda: base.apply("reciprocal", x[0])],
            "atan2": [lambda: self._turn(x[1], x), lambda: scaled(self._turn(x[0], x), Fraction(-1))],
        }
        return rules[name]

    def _turn(self, numerator: Any, x: Sequence[Any]) -> Any:
        """numerator/(x0^2 + x1^2), the partial derivatives of atan2 but for the sign."""
        square = self.base.combine([(self.base.multiply(a, a), Fraction(1)) for a in x])
        return self.base.multiply(numerator, self.base.apply("reciprocal", square))

    def select(self, mask: Any, a: Dual, b: Dual) -> Dual:
        value = self.base.select(mask, a[0], b[0])
        if a[1] is None and b[1] is None:
            return value, None
        zero = self.base.constant(Fraction(0))
        return value, self.base.select(mask, zero if a[1] is None else a[1], zero if b[1] is None else b[1])

    def is_zero(self, a: Dual) -> bool:
        return self.base.is_zero(a[0]) and (a[1] is None or self.base.is_zero(a[1]))


def derivative_formula(formula: Formula, names: Sequence[str], wrt: str, is_scalar: bool) -> Formula:
    """The formula of the derivative: the same arguments, and for a multivector the direction ``d_<wrt>`` last."""
    place = list(names).index(wrt)

    def derived(*arguments: Any) -> Any:
        operands = list(arguments)
        direction: Any = None if is_scalar else operands.pop()
        base = operands[place].ring
        ring = DualRing(base)
        lifted = [_lift(x, ring) for x in operands]
        own = operands[place]
        if is_scalar:
            lifted[place] = own_dual = Multivector(own.algebra, ring, {})
            own_dual.terms[0] = (own.scalar(), base.constant(Fraction(1)))
        else:
            zero = base.constant(Fraction(0))
            blades = own.algebra.order([*own.terms, *direction.terms])
            terms = {b: (own.terms.get(b, zero), direction.terms.get(b)) for b in blades}
            lifted[place] = Multivector(own.algebra, ring, terms)
        return tuple(
            Result(tuple(_tangent(v, base) for v in r.values), r.role, r.name, r.is_row)
            for r in as_outputs(formula(*lifted))
            if r.role != "status"
        )

    return derived


def tangent_formula(formula: Formula, module: str, constant: Sequence[str] = ()) -> Formula:
    """A formula along a direction of all its arguments at once.

    Parameters
    ----------
    formula : callable
    module : str
        The module of formulas that the new one belongs to.
    constant : sequence of str
        Arguments that do not vary.

    Returns
    -------
    callable
        Takes the arguments, then a direction ``d_<name>`` (of the same blades) for each that varies, and returns all
        values, then their tangents on the same blades. Statuses are left out.
    """
    names = [p.name for p in inspect.signature(formula).parameters.values() if p.default is p.empty]
    varying = [name for name in names if name not in constant]

    def tangent(*arguments: Any) -> Any:
        operands, directions = arguments[: len(names)], dict(zip(varying, arguments[len(names) :], strict=True))
        first = operands[0][0] if isinstance(operands[0], tuple) else operands[0]
        base = first.ring
        ring = DualRing(base)
        lifted = [_lift(x, ring, directions.get(name)) for name, x in zip(names, operands, strict=True)]
        results = [r for r in as_outputs(formula(*lifted)) if r.role != "status"]
        called = [r.name or ("out" if i == 0 else f"out{i}") for i, r in enumerate(results)]
        values = [
            Result(tuple(_value(v, base) for v in r.values), r.role, name, r.is_row)
            for r, name in zip(results, called, strict=True)
        ]
        tangents = [
            Result(tuple(_tangent(v, base, whole=True) for v in r.values), r.role, f"d_{name}", r.is_row)
            for r, name in zip(results, called, strict=True)
        ]
        return (*values, *tangents)

    parameters = [*names, *(f"d_{name}" for name in varying)]
    tangent.__name__ = tangent.__qualname__ = f"{formula.__name__}_tangent"
    tangent.__module__ = module
    tangent.__doc__ = f"`{formula.__name__}` and its tangent."
    tangent.__signature__ = inspect.Signature(  # type: ignore[attr-defined]
        [inspect.Parameter(name, inspect.Parameter.POSITIONAL_OR_KEYWORD) for name in parameters]
    )
    return tangent


def _lift(x: Any, ring: DualRing, direction: Any = None) -> Any:
    """A constant, or with a direction on the same blades a value that varies."""
    if isinstance(x, tuple):
        return tuple(_lift(v, ring, d) for v, d in zip(x, direction or [None] * len(x), strict=True))
    tangents = {} if direction is None else direction.terms
    return Multivector(x.algebra, ring, {b: (c, tangents.get(b)) for b, c in x.terms.items()})


def _value(x: Multivector, base: Ring) -> Multivector:
    return Multivector(x.algebra, base, {b: c[0] for b, c in x.terms.items()})


def _tangent(x: Multivector, base: Ring, whole: bool = False) -> Multivector:
    """The tangents of the coefficients; whole: with the zeros of those that do not vary."""
    zero = base.constant(Fraction(0))
    terms = {b: zero if c[1] is None else c[1] for b, c in x.terms.items() if whole or c[1] is not None}
    return Multivector(x.algebra, base, terms)


def derivative_kinds(names: Sequence[str], kinds: Sequence[Kind], wrt: str) -> tuple[list[str], list[Kind]]:
    """Argument names and kinds of the derivative.

    Raises
    ------
    TraceError
        If there is no such argument, or it is a row of numbers.
    """
    if wrt not in names:
        raise TraceError(f"the kernel has no argument {wrt!r}; it has: {', '.join(names)}.")
    kind = kinds[list(names).index(wrt)]
    if kind.form == "numbers":
        raise TraceError(f"{wrt} is a row of numbers; derivatives are of one number or of a multivector.")
    if kind.is_scalar_argument:
        return list(names), list(kinds)
    free = [k.layout if n == wrt else k for n, k in zip(names, kinds, strict=True)]
    direction = f"d_{wrt}"
    while direction in names:  # a second derivative, or an argument that happens to have this name
        direction += "_"
    return [*names, direction], [*free, kind.layout]
