"""What exported files say of a kernel: its note, formula, operations, and what is known of its rounding."""

from __future__ import annotations

import ast
import inspect
import re
import textwrap
from collections.abc import Callable
from typing import Any

import numpy as np

from ..ir.graph import in_order_of_use
from ..optimise.accuracy import finite_bounds
from ..optimise.variants import Variant
from ..targets.printer import comment_text
from ..trace.kernel import Formula

#: Larger first-order bounds say nothing: they do not see sums with twice the digits.
LARGEST_BOUND = 1e6


def kernel_notes(variant: Variant) -> tuple[str, ...]:
    """What is said of a kernel: its note, formula, operations, error bound, and the order of its coefficients."""
    kernel = variant.kernel
    notes = [comment_text(kernel.note or kernel.name)]
    if formula := formula_text(kernel.formula):
        notes.append(f"Formula: {formula}.")
    notes.append(f"Operations: {variant.operations.text()} Rounding: {_rounding(variant)}.")
    return tuple(notes)


def _rounding(variant: Variant) -> str:
    """What is known of the rounding errors."""
    if not variant.operations.total:
        return "none"
    bounds = finite_bounds(variant.kernel, variant.roots)
    if not bounds.size:
        return "no bound, since arguments at random have no value"
    bound = float(np.median(bounds))
    if not bound:
        decides = any(node.op == "select" for node in in_order_of_use(variant.roots))
        return "only where numbers are compared, or by underflow" if decides else "only by underflow"
    if bound > LARGEST_BOUND:
        return "compensated: sums with twice the digits"
    return f"at most about {bound:.2g} roundoffs of the largest coefficient"


def formula_text(formula: Formula | Callable[..., Any]) -> str:
    """What a formula of one line returns, as it is written; else its name in the package's text, or nothing."""
    try:
        tree = ast.parse(textwrap.dedent(inspect.getsource(inspect.unwrap(formula))))
    except (OSError, TypeError, SyntaxError):
        return ""
    found = tree.body[0]
    body = [s for s in getattr(found, "body", []) if not _is_text(s)]
    if len(body) == 1 and isinstance(body[0], ast.Return) and body[0].value is not None:
        text = comment_text(ast.unparse(body[0].value))
        if not re.search(r"\b_[a-z]", text):  # what it calls is not for users
            return text
    return f"{formula.__module__}.{formula.__name__}"


def _is_text(statement: ast.stmt) -> bool:
    return isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Constant)
