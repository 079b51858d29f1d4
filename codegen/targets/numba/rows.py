"""Kernels for numba as functions of rows in flat arrays of float64: what loops in Python call."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from ...errors import TraceError
from ...ir.graph import Node
from ...optimise.variants import Variant
from ..c.printer import symbol
from ..printer import comment_text, decimal
from .printer import NumbaPrinter, wrap


class RowPrinter(NumbaPrinter):
    """Python on float64 alone: constants are written as they are, which numba reads far faster."""

    def constant(self, value: Fraction) -> str:
        return decimal(value)

    def function(self, name: str, arguments: Sequence[str]) -> str:
        if name in ("nan", "epsilon"):
            return {"nan": "NAN", "epsilon": "EPSILON"}[name]
        return super().function(name, arguments).replace("K(1.0)", "1.0")

    def call(self, node: Node, arguments: Sequence[Sequence[str]], names: Sequence[str]) -> list[str]:
        raise TraceError(f"{self.kernel.name} calls {node.data[0].name}: on rows, kernels call no others.")


@dataclass(frozen=True)
class RowFunction:
    """A kernel as the template sees it: a function of rows, results first, each an array and where in it to begin."""

    symbol: str
    comment: str
    parameters: str
    lines: tuple[str, ...]


def row_function(variant: Variant) -> RowFunction:
    """Print a variant as a function that reads and writes arrays."""
    kernel, printer = variant.kernel, RowPrinter(variant)
    body = printer.body()
    used = {node.data for node in printer.nodes if node.op == "var"}
    lines = [
        f"{printer.coefficients[i][j]} = {item.name}_row[U({item.name}_at + {j})]"
        for i, item in enumerate(kernel.inputs)
        for j in range(item.kind.size)
        if (i, j) in used
    ]
    lines += body
    start = 0
    for output in kernel.outputs:
        for j, node in enumerate(variant.roots[start : start + len(output.nodes)]):
            lines.append(f"{output.name}_result[U({output.name}_to + {j})] = {printer.value(node)}")
        start += len(output.nodes)
    parameters = [f"{o.name}_{part}" for o in kernel.outputs for part in ("result", "to")]
    parameters += [f"{i.name}_{part}" for i in kernel.inputs for part in ("row", "at")]
    comment = f"{comment_text(kernel.note or kernel.name)} {variant.operations.text()}"
    return RowFunction(symbol(kernel), comment, wrap(parameters, 1), tuple(lines))
