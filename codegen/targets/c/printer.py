"""C: kernel bodies for scalars and vectors alike, and the sources of an extension around them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from ...ir.graph import Node
from ...optimise.variants import Variant
from ...rings.protocol import STUMPFF
from ...trace.kernel import Kernel, symbol_of
from ..printer import Printer, comment_text, decimal

FUNCTIONS = {
    "sqrt": "SQRT", "abs": "ABS", "sin": "SIN", "cos": "COS", "exp": "EXP", "log": "LOG", "atan2": "ATAN2",
    "lt": "LT", "le": "LE", "and": "AND", "or": "OR", "not": "NOT", "select": "SELECT",
    **{name: name.upper() for name in STUMPFF},
}  # fmt: skip
#: Functions of no argument.
CONSTANTS = {"nan": "SPLAT(BS_NOT_A_NUMBER)", "epsilon": "SPLAT(BS_EPSILON)"}
#: Functions whose text lives in elementary.h; it is included only when one is used.
ELEMENTARY = frozenset(("sin", "cos", "exp", "log", "atan2", *STUMPFF))


def symbol(kernel: Kernel) -> str:
    """Name of a kernel in generated code."""
    return symbol_of(kernel.algebra, kernel.name)


class CPrinter(Printer):
    """C99 on the short names of templates/c/lib/instance.h; CUDA prints the same text."""

    def constant(self, value: Fraction) -> str:
        return f"K({decimal(value)})"

    def splat(self, value: Fraction) -> str:
        return f"SPLAT({decimal(value)})"

    def declare(self, name: str, text: str, mask: bool = False) -> str:
        return f"const {'M' if mask else 'V'} {name} = {text};"

    def function(self, name: str, arguments: Sequence[str]) -> str:
        if name == "reciprocal":
            return f"K(1.0) / {arguments[0]}" if arguments[0].isidentifier() else f"K(1.0) / ({arguments[0]})"
        if name in CONSTANTS:
            return CONSTANTS[name]
        return arguments[0] if name == "rounded" else f"{FUNCTIONS[name]}({', '.join(arguments)})"

    def call(self, node: Node, arguments: Sequence[Sequence[str]], names: Sequence[str]) -> list[str]:
        kernel: Kernel = node.data[0]
        lines = [f"V {name}[{len(item.nodes)}];" for name, item in zip(names, kernel.outputs, strict=True)]
        prefix = names[0].split("_")[0]
        passed = []
        for item, values in zip(kernel.inputs, arguments, strict=True):
            lines.append(f"const V {prefix}_{item.name}_in[{len(values)}] = {{{', '.join(values)}}};")
            passed.append(f"{prefix}_{item.name}_in")
        lines.append(f"FN({symbol(kernel)})({', '.join([*names, *passed])});")
        return lines


#: A product and its rounding error (`exact_product` of formulas/products/double_double.py) where one instruction gives
#: the error: short of underflow and overflow the bits of Dekker's sums.
_PRODUCT = """#ifdef BS_PRODUCT_ERROR
const V product = {a} * {b};
{outputs[0]}[0] = product;
{outputs[1]}[0] = BS_PRODUCT_ERROR({a}, {b}, product);
#else"""


@dataclass(frozen=True)
class Parameter:
    """One array of a kernel function, as templates see it."""

    name: str
    size: int
    is_status: bool = False


@dataclass(frozen=True)
class Function:
    """One kernel function, as templates see it: validated names, printed statements, no mathematics."""

    symbol: str
    comment: str
    inputs: tuple[Parameter, ...]
    outputs: tuple[Parameter, ...]
    lines: tuple[str, ...]
    elementary: bool


def c_function(variant: Variant) -> Function:
    """Print one variant."""
    kernel = variant.kernel
    printer = CPrinter(variant)
    statements = printer.body()
    loads = [
        f"const V {printer.coefficients[i][j]} = {item.name}_in[{j}];"
        for i, item in enumerate(kernel.inputs)
        for j in range(item.kind.size)
        if any(node.op == "var" and node.data == (i, j) for node in printer.nodes)
    ]
    unused = [
        f"(void){item.name}_in;"
        for i, item in enumerate(kernel.inputs)
        if not any(node.op == "var" and node.data[0] == i for node in printer.nodes)
    ]
    stores, start = [], 0
    for output in kernel.outputs:
        for j, blade in enumerate(output.kind.blades):
            text = printer.value(variant.roots[start + j])
            label = "" if output.kind.form == "numbers" else f" /* {output.kind.algebra.blade_name(blade)} */"
            stores.append(f"{output.name}[{j}] = {text};{label}")
        start += len(output.nodes)
    lines = loads + unused + statements + stores
    if factors := getattr(kernel.formula, "exact_factors", None):
        a, b = (f"{kernel.inputs[k].name}_in[0]" for k in factors)
        lines = [*_PRODUCT.format(a=a, b=b, outputs=[o.name for o in kernel.outputs]).split("\n"), *lines, "#endif"]
    return Function(
        symbol(kernel),
        f"{symbol(kernel)}: {comment_text(kernel.note or kernel.name)} {variant.operations.text()}",
        tuple(Parameter(i.name, i.kind.size) for i in kernel.inputs),
        tuple(Parameter(o.name, len(o.nodes), o.role == "status") for o in kernel.outputs),
        tuple(lines),
        any(node.op in ELEMENTARY for node in printer.nodes),
    )
