"""Reverse derivatives: from a kernel the formula that takes its inputs, and a cotangent of each value, to cotangents.

What is reversed is the graph of the formula on layouts, as for forward derivatives, and without calls. Cotangents are
coefficients that are paired with coefficients: a cotangent of a multivector is no multivector of the metric's dual.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from ..algebra.algebra import Kind
from ..algebra.multivector import from_values
from ..ir.graph import Node
from ..ir.reverse import pull_back
from ..rings.dual import DualRing
from .derivatives import lift, value
from .kernel import Formula, Kernel, argument_names
from .outputs import Result, as_outputs
from .rows import annotation


def inlined(formula: Formula) -> Formula:
    """The same formula without calls of kernels: on dual numbers that do not vary."""

    def without_calls(*arguments: Any) -> Any:
        first = arguments[0][0] if isinstance(arguments[0], tuple) else arguments[0]
        ring = DualRing(first.ring)
        results = as_outputs(formula(*(lift(x, ring) for x in arguments)))
        return tuple(Result(tuple(value(v, first.ring) for v in r.values), r.role, r.name, r.is_row) for r in results)

    without_calls.__doc__ = formula.__doc__
    without_calls.__annotations__ = {name: annotation(formula, name) for name in argument_names(formula)}
    return without_calls


def roots_like(kernel: Kernel, roots: Sequence[Node], layouts: Sequence[Kind]) -> list[list[Node | None]]:
    """The roots of a kernel by its values, on the blades of other layouts; None where a kernel has no such blade."""
    found: list[list[Node | None]] = []
    flat, wanted = iter(roots), iter(layouts)
    for output in kernel.outputs:
        nodes = [next(flat) for _ in output.nodes]
        if output.role != "status":
            by_blade = dict(zip(output.kind.blades, nodes, strict=True))
            is_row, layout = output.kind.form == "numbers", next(wanted)
            found.append(list(nodes) if is_row else [by_blade.get(b) for b in layout.blades])
    return found


def pullback_formula(
    roots: Callable[[], Sequence[Sequence[Node | None]]],
    kinds: Sequence[Kind],
    outputs: Sequence[Kind],
    wrt: Sequence[int],
) -> Formula:
    """The formula of a reverse derivative.

    Parameters
    ----------
    roots : callable
        Nodes of the coefficients of each value (None: zero), of a graph whose variables are the inputs' coefficients.
    kinds, outputs : sequences of Kind
        Of the inputs, and of the values.
    wrt : sequence of int
        Inputs whose cotangents are returned.

    Returns
    -------
    callable
        Takes the inputs, then the cotangents of the values; returns cotangents of the inputs ``wrt``.
    """

    def pullback(*arguments: Any) -> Any:
        given = [_coefficients(k, x) for k, x in zip((*kinds, *outputs), arguments, strict=True)]
        first = arguments[0][0] if isinstance(arguments[0], tuple) else arguments[0]
        ring = first.ring
        variables = {(i, j): v for i, row in enumerate(given[: len(kinds)]) for j, v in enumerate(row)}
        pairs = [
            (node, cotangent)
            for nodes, row in zip(roots(), given[len(kinds) :], strict=True)
            for node, cotangent in zip(nodes, row, strict=True)
            if node is not None
        ]
        found = pull_back([n for n, _ in pairs], variables, [c for _, c in pairs], wrt, ring)
        zero = first.constant(0).scalar()
        results = []
        for i in wrt:
            row = [found.get((i, j), zero) for j in range(kinds[i].size)]
            if kinds[i].form == "numbers":
                results.append(Result(tuple(from_values(first.algebra, ring, (0,), [v]) for v in row), is_row=True))
            else:
                results.append(Result((from_values(first.algebra, ring, kinds[i].blades, row),)))
        return tuple(results)

    return pullback


def _coefficients(kind: Kind, x: Any) -> list[Any]:
    return [v.scalar() for v in x] if kind.form == "numbers" else kind.values(x)
