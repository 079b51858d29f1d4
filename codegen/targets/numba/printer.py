"""numba: kernels as a readable Python module.

The text is plain Python. Run as it is, on numbers or on whole columns, it gives the same bits as compiled by
numba, and as C: the order of operations is the printer's, and nothing is contracted or reassociated.
"""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from ...ir.graph import Node
from ...optimise.variants import Variant
from ...trace.kernel import Output
from ..c.extension import in_dependency_order
from ..c.printer import ELEMENTARY, Parameter, symbol
from ..printer import Printer, comment_text, decimal
from ..templates import render

#: How functions and predicates look; the elementary ones are called by their names.
FUNCTIONS = {
    "sqrt": "np.sqrt({})", "abs": "np.abs({})", "select": "select({}, {}, {})",
    "lt": "{} < {}", "le": "{} <= {}", "and": "{} & {}", "or": "{} | {}", "not": "np.logical_not({})",
    "nan": "K(np.nan)", "epsilon": "K(np.finfo(K).eps)", "rounded": "{}",
}  # fmt: skip
#: Width of the lists of names in generated text.
LINE = 100


class NumbaPrinter(Printer):
    """Python on numbers or columns. K is the type of constants: a bare 0.5 would make float64 of float32."""

    def constant(self, value: Fraction) -> str:
        return f"K({decimal(value)})"

    def declare(self, name: str, text: str, mask: bool = False) -> str:
        return f"{name} = {text}"

    def function(self, name: str, arguments: Sequence[str]) -> str:
        if name == "reciprocal":
            return f"K(1.0) / {arguments[0]}" if arguments[0].isidentifier() else f"K(1.0) / ({arguments[0]})"
        if name in ELEMENTARY:
            return f"{name}({', '.join(arguments)})"
        return FUNCTIONS[name].format(*arguments)

    def call(self, node: Node, arguments: Sequence[Sequence[str]], names: Sequence[str]) -> list[str]:
        flat = ", ".join(value for values in arguments for value in values)
        return [f"{', '.join(names)} = {symbol(node.data[0])}({flat})"]


@dataclass(frozen=True)
class Function:
    """One kernel and its loop, as the template sees them: printed text, no mathematics."""

    symbol: str
    comment: str
    parameters: str
    lines: tuple[str, ...]
    results: str
    inputs: tuple[Parameter, ...]
    outputs: tuple[Parameter, ...]
    rows: str
    targets: str
    arguments: str
    operations: frozenset[str]


def numba_source(variants: Sequence[Variant], title: str = "") -> str:
    """Text of a module with these kernels and those that they call, and a batch function for each of these.

    Parameters
    ----------
    variants : sequence of Variant
    title : str, optional
        First words of the module's docstring; default: the algebra's name.
    """
    functions = [numba_function(v) for v in in_dependency_order(variants)]
    used: frozenset[str] = frozenset().union(*(f.operations for f in functions))
    return render(
        "kernels.py.j2",
        title=title or (variants[0].kernel.algebra.name if variants else "kernels"),
        functions=functions,
        batched=[symbol(v.kernel) for v in variants],
        count=len(variants),
        elementary=sorted(used & ELEMENTARY),
        select="select" in used,
    )


def numba_function(variant: Variant) -> Function:
    """Print one variant."""
    kernel = variant.kernel
    printer = NumbaPrinter(variant)
    lines = printer.body()
    inputs = tuple(Parameter(i.name, i.kind.size) for i in kernel.inputs)
    outputs = tuple(Parameter(o.name, len(o.nodes), o.role == "status") for o in kernel.outputs)
    names = [name for own in printer.coefficients for name in own]
    columns = [f"{p.name}_columns[{j}, i]" for p in inputs for j in range(p.size)]
    arrays = [f"{o.name}_rows" for o in outputs]
    arrays += [f"{p.name}_{part}" for p in inputs for part in ("rows", "step")]
    targets = [_tuple([f"{o.name}_columns[{j}, i]" for j in range(o.size)]) for o in outputs]
    return Function(
        symbol(kernel),
        f"{comment_text(kernel.note or kernel.name)} {variant.operations.text()}",
        wrap(names, 1),
        tuple(lines),
        _results(printer, variant),
        inputs,
        outputs,
        wrap(["begin", "end", *arrays], 1),
        ", ".join(targets),
        wrap(columns, 4),
        frozenset(node.op for node in printer.nodes),
    )


def _results(printer: NumbaPrinter, variant: Variant) -> str:
    """The returned tuple: coefficients of the only output, or a tuple of such tuples."""
    parts, start = [], 0
    several = len(variant.kernel.outputs) > 1
    for output in variant.kernel.outputs:
        nodes = variant.roots[start : start + len(output.nodes)]
        start += len(output.nodes)
        entries = [f"{printer.value(node)},{_label(output, j)}" for j, node in enumerate(nodes)]
        parts.append("(\n" + textwrap.indent("\n".join(entries), "    ") + "\n)")
    text = parts[0] if not several else "(\n" + textwrap.indent(",\n".join(parts), "    ") + ",\n)"
    return textwrap.indent(text, "    ").lstrip()


def _label(output: Output, index: int) -> str:
    if output.kind.form == "numbers":
        return ""
    return f"  # {output.kind.algebra.blade_name(output.kind.blades[index])}"


def _tuple(items: Sequence[str]) -> str:
    return f"({items[0]},)" if len(items) == 1 else f"({wrap(items, 4)})"


def wrap(items: Sequence[str], level: int) -> str:
    """A list of arguments between brackets, on lines of its own where it is long."""
    text = ", ".join(items)
    if len(text) + 4 * level < LINE * 3 // 4:
        return text
    outer, inner = "    " * (level - 1), "    " * level
    body = textwrap.fill(text + ",", LINE, initial_indent=inner, subsequent_indent=inner)
    return f"\n{body}\n{outer}"
