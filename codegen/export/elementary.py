"""Which elementary functions an exported file holds: those that its functions call, and what these call."""

from __future__ import annotations

from collections.abc import Collection
from functools import cache

from ..elementary.constants import DOUBLE, SINGLE
from ..ir.loops.nodes import Function
from ..targets import elementary
from ..targets.loops import in_calling_order

#: Functions of numbers that are exported as text, so that all targets have the same bits.
ELEMENTARY = frozenset(elementary.NAMES) - {"stumpff"}


def elementary_functions(used: Collection[str], precision: str) -> list[Function]:
    """Functions of the loop IR, callees first.

    `elementary.FAR_OR_NEAR` among them has no body: each language has a text of its own, which calls what
    `far_functions` gives.
    """
    names = [name for name in elementary.NAMES if name in used]
    functions, _ = in_calling_order(elementary.elementary_functions(names, DOUBLE if precision == "f64" else SINGLE))
    return functions


@cache
def far_functions() -> tuple[Function, ...]:
    """The reduction of one very large angle, in float64, callees first."""
    functions, _ = in_calling_order([elementary.far_reduction()])
    return tuple(functions)
