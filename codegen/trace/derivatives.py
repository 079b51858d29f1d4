"""Forward derivatives: a formula run on dual numbers over any ring is its own derivative.

Over a graph it becomes a kernel, over mpmath numbers the reference. The differentiated input is traced on its
layout: on a kind with constraints known, reductions would hide directions in which the formula varies.
"""

from __future__ import annotations

import inspect
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from ..algebra.algebra import Kind
from ..algebra.multivector import Multivector
from ..errors import TraceError
from ..rings.dual import DualRing
from ..rings.protocol import Ring
from .kernel import Formula, argument_names
from .outputs import Result, as_outputs, row
from .rows import annotation


def derivative_formula(formula: Formula, names: Sequence[str], wrt: str, is_scalar: bool) -> Formula:
    """The formula of the derivative: the same arguments, and for a multivector the direction ``d_<wrt>`` last."""
    place = list(names).index(wrt)

    def derivative(*arguments: Any) -> Any:
        operands = list(arguments)
        direction: Any = None if is_scalar else operands.pop()
        base = operands[place].ring
        ring = DualRing(base)
        lifted = [lift(x, ring) for x in operands]
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

    return derivative


def jacobian_formula(
    formula: Formula, names: Sequence[str], wrt: str, kind: Kind, outputs: Sequence[Sequence[int] | None]
) -> Formula:
    """The formula of all partial derivatives.

    Parameters
    ----------
    formula : callable
    names : sequence of str
        Its arguments.
    wrt : str
        One of them.
    kind : Kind
        Of that one.
    outputs : sequence
        Blades of each result that is no status; None for a row of numbers.

    Returns
    -------
    callable
        Takes the same arguments, and returns for each result a row of numbers: its coefficients' derivatives, those of
        one coefficient beside each other.
    """
    place = list(names).index(wrt)

    def jacobian(*arguments: Any) -> Any:
        own = arguments[place]
        like = own[0] if isinstance(own, tuple) else own
        base, ring = like.ring, DualRing(like.ring)
        columns = []
        for k in range(kind.size):
            lifted = [lift(x, ring) for x in arguments]
            lifted[place] = _along(own, kind, k, ring)
            found = [r for r in as_outputs(formula(*lifted)) if r.role != "status"]
            columns.append([_tangents(r, blades, base) for r, blades in zip(found, outputs, strict=True)])
        return tuple(
            row([column[o][i] for i in range(len(first)) for column in columns], f"jacobian{o or ''}")
            for o, first in enumerate(columns[0])
        )

    return jacobian


def _along(x: Any, kind: Kind, place: int, ring: DualRing) -> Any:
    """An argument that varies along one of its coefficients."""
    if isinstance(x, tuple):
        lifted = [lift(v, ring) if k != place else _along(v, kind, -1, ring) for k, v in enumerate(x)]
        return x._make(lifted) if hasattr(x, "_make") else tuple(lifted)
    base, blade = x.ring, 0 if place < 0 else kind.blades[place]
    zero, one = base.constant(Fraction(0)), base.constant(Fraction(1))
    blades = x.algebra.order([*x.terms, blade])
    return Multivector(x.algebra, ring, {b: (x.terms.get(b, zero), one if b == blade else None) for b in blades})


def _tangents(result: Result, blades: Sequence[int] | None, base: Ring) -> list[Multivector]:
    """Tangents of a result's coefficients, as scalars."""
    found = [_tangent(v, base, whole=True) for v in result.values]
    if blades is None:
        return found
    zero = base.constant(Fraction(0))
    return [Multivector(found[0].algebra, base, {0: found[0].terms.get(b, zero)}) for b in blades]


def tangent_formula(
    formula: Formula, module: str, constant: Sequence[str] = (), names: Sequence[str] | None = None
) -> Formula:
    """A formula along a direction of all its arguments at once.

    Parameters
    ----------
    formula : callable
    module : str
        The module of formulas that the new one belongs to.
    constant : sequence of str
        Arguments that do not vary.
    names : sequence of str, optional
        Of the arguments; default: as the formula calls them.

    Returns
    -------
    callable
        Takes the arguments, then a direction ``d_<name>`` (of the same blades) for each that varies, and returns all
        values, then their tangents on the same blades. Statuses are left out.
    """
    names = list(names or argument_names(formula))
    if unknown := set(constant) - set(names):
        raise TraceError(f"{formula.__name__} has no argument {min(unknown)!r} that could be constant.")
    varying = [name for name in names if name not in constant]

    def tangent(*arguments: Any) -> Any:
        operands, directions = arguments[: len(names)], dict(zip(varying, arguments[len(names) :], strict=True))
        first = operands[0][0] if isinstance(operands[0], tuple) else operands[0]
        base = first.ring
        ring = DualRing(base)
        lifted = [lift(x, ring, directions.get(name)) for name, x in zip(names, operands, strict=True)]
        results = [r for r in as_outputs(formula(*lifted)) if r.role != "status"]
        called = [r.name or ("out" if i == 0 else f"out{i}") for i, r in enumerate(results)]
        values = [
            Result(tuple(value(v, base) for v in r.values), r.role, name, r.is_row)
            for r, name in zip(results, called, strict=True)
        ]
        tangents = [
            Result(tuple(_tangent(v, base, whole=True) for v in r.values), r.role, f"d_{name}", r.is_row)
            for r, name in zip(results, called, strict=True)
        ]
        return (*values, *tangents)

    parameters = [*names, *directions_of(varying, names)]
    tangent.__name__ = tangent.__qualname__ = f"{formula.__name__}_tangent"
    tangent.__module__ = module
    tangent.__doc__ = f"`{formula.__name__}` and its tangent."
    tangent.__annotations__ = {
        p: annotation(formula, name) for p, name in zip(parameters, [*names, *varying], strict=True)
    }
    tangent.__signature__ = inspect.Signature(  # type: ignore[attr-defined]
        [inspect.Parameter(name, inspect.Parameter.POSITIONAL_OR_KEYWORD) for name in parameters]
    )
    return tangent


def restricted(result: Result, layout: Kind) -> Result:
    """A result on the blades of a layout alone."""
    if result.is_row:
        return result
    x = result.value
    terms = {b: c for b, c in x.terms.items() if b in layout.blades}
    return Result((Multivector(x.algebra, x.ring, terms),), result.role, result.name)


def lift(x: Any, ring: DualRing, direction: Any = None) -> Any:
    """A constant, or with a direction on the same blades a value that varies."""
    if isinstance(x, tuple):
        lifted = [lift(v, ring, d) for v, d in zip(x, direction or [None] * len(x), strict=True)]
        return x._make(lifted) if hasattr(x, "_make") else tuple(lifted)
    tangents = {} if direction is None else direction.terms
    return Multivector(x.algebra, ring, {b: (c, tangents.get(b)) for b, c in x.terms.items()})


def value(x: Multivector, base: Ring) -> Multivector:
    """What is left of dual coefficients without their tangents."""
    return Multivector(x.algebra, base, {b: c[0] for b, c in x.terms.items()})


def _tangent(x: Multivector, base: Ring, whole: bool = False) -> Multivector:
    """The tangents of the coefficients; whole: with the zeros of those that do not vary."""
    zero = base.constant(Fraction(0))
    terms = {b: zero if c[1] is None else c[1] for b, c in x.terms.items() if whole or c[1] is not None}
    return Multivector(x.algebra, base, terms)


def derivative_kinds(
    names: Sequence[str], kinds: Sequence[Kind], wrt: str, rows: bool = False
) -> tuple[list[str], list[Kind]]:
    """Argument names and kinds of the derivative. ``rows``: it may be with respect to a row of numbers.

    Raises
    ------
    TraceError
        If there is no such argument, or it is a row of numbers.
    """
    if wrt not in names:
        raise TraceError(f"the kernel has no argument {wrt!r}; it has: {', '.join(names)}.")
    kind = kinds[list(names).index(wrt)]
    if kind.form == "numbers" and not rows:
        raise TraceError(f"{wrt} is a row of numbers; derivatives are of one number or of a multivector.")
    if kind.is_scalar_argument:
        return list(names), list(kinds)
    free = [k.layout if n == wrt else k for n, k in zip(names, kinds, strict=True)]
    return [*names, *directions_of([wrt], names)], [*free, kind.layout]


def directions_of(varying: Sequence[str], names: Sequence[str]) -> list[str]:
    """Names of the directions of some arguments: ``d_<name>``, unless an argument has that name."""
    taken = list(names)
    for name in varying:
        taken.append(unused(f"d_{name}", taken))
    return taken[len(names) :]


def unused(name: str, taken: Sequence[str]) -> str:
    """The name, or a longer one: a second derivative, or an argument, may have it."""
    while name in taken:
        name += "_"
    return name
