"""Names of the numbers in rows, from the annotations of formulas: what generated code calls them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from ..algebra.algebra import Algebra, Kind


@dataclass(frozen=True)
class BladesOf:
    """Annotates a row that holds coefficients of multivectors of a kind, one multivector after the other.

    Examples
    --------
    >>> Covector = Annotated[tuple[Multivector, ...], BladesOf("twist")]
    """

    kind: str


def annotation(formula: Callable[..., Any], argument: str) -> Any:
    """Return what annotates an argument; a name is looked up in the formula's module. None if there is nothing."""
    hint = getattr(formula, "__annotations__", {}).get(argument)
    return getattr(formula, "__globals__", {}).get(hint) if isinstance(hint, str) else hint


def row_type(formula: Callable[..., Any], argument: str, kind: Kind) -> Callable[..., Any] | None:
    """Return the named tuple that annotates an argument, if it has as many fields as the row has numbers."""
    hint = annotation(formula, argument)
    return hint if kind.form == "numbers" and len(getattr(hint, "_fields", ())) == kind.size else None


def row_labels(formula: Callable[..., Any], argument: str, kind: Kind, algebra: Algebra) -> tuple[str, ...]:
    """Return the names of a row's numbers: fields of a named tuple, or blades. Empty where numbers have no names."""
    named = row_type(formula, argument, kind)
    if named is not None:
        return tuple(getattr(named, "_fields"))  # noqa: B009 (a callable without declared fields)
    for each in getattr(annotation(formula, argument), "__metadata__", ()):
        if kind.form == "numbers" and isinstance(each, BladesOf) and each.kind in algebra.kinds:
            names = [algebra.blade_name(b) for b in algebra.kinds[each.kind].blades]
            count, rest = divmod(kind.size, len(names))
            if rest == 0:
                return tuple(names if count == 1 else [f"{i}_{name}" for i in range(count) for name in names])
    return ()
