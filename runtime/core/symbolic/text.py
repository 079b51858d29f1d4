"""Text of symbolic multivectors: sums in brackets beside their blades."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import sympy

from ...codegen.rings import expressions
from ...codegen.rings.expressions import Polynomial
from .. import formatting


def plain(algebra: Any, terms: Mapping[int, Polynomial]) -> str:
    """``a e1 + (b + c) e12 - 2 ni``."""
    return _sum(terms, str, "({})", lambda blade: formatting.blade_text(algebra, blade))


def latex(algebra: Any, terms: Mapping[int, Polynomial]) -> str:
    """The same in LaTeX."""
    return _sum(terms, sympy.latex, r"\left({}\right)", lambda blade: formatting.latex_blade(algebra, blade))


def _sum(
    terms: Mapping[int, Polynomial], write: Callable[[Any], str], brackets: str, name: Callable[[int], str]
) -> str:
    written: list[tuple[bool, str]] = []
    for blade, polynomial in terms.items():
        expression = expressions.to_sympy(polynomial)
        negative = not expression.is_Add and expression.could_extract_minus_sign()
        size = -expression if negative else expression
        factor = brackets.format(write(size)) if size.is_Add and (blade or written) else write(size)
        if blade:
            factor = name(blade) if size == 1 else f"{factor} {name(blade)}"
        written.append((negative, factor))
    return formatting.join_terms(written)
