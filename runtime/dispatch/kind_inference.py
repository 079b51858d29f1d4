"""Kinds of results, proved at random exact members of their operands' kinds (no rules, no rounding).

A proof costs some milliseconds and is made once for each combination of kinds.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from ..codegen.algebra.algebra import Kind
from ..codegen.trace import result_kinds
from .types import TypedAlgebra

#: Every member of the first kind is provably a member of the second.
is_subkind = result_kinds.belongs
#: A random exact member of a kind.
member = result_kinds.member
#: Kinds of products with more terms are not inferred: the layout of the product is taken.
MAX_TERMS = 4096


def result_kind(algebra: TypedAlgebra, formula: Callable[..., Any], kinds: Sequence[Kind]) -> Kind:
    """The narrowest kind of the algebra that a formula's value provably belongs to, else the layout of its blades.

    The formula may use sums and products only.
    """
    kind, blades = result_kinds.result_blades(algebra, formula, kinds)
    return kind or algebra.layout_of(blades)
