"""The registration driver for numba: the loops of the C driver in Python, and its kernels on rows of flat arrays."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache

from ...build import source_digest, text_cache
from ...ir.graph import Node
from ...optimise.variants import Variant, as_written
from ...targets.c.printer import symbol
from ...targets.numba.printer import NumbaPrinter, wrap
from ...targets.printer import comment_text, decimal
from ...targets.templates import render
from ...trace.kernel import coefficient_name
from ..kernel_spec import trace_spec
from .registration import driver_spec, in_order

_TEMPLATE = "reform.py.j2"
#: What it includes.
_PARTS = tuple(f"reform_{part}.py.j2" for part in ("solve", "loops", "frames", "stages"))
#: What the text depends on, from the package's folder.
_SOURCES = (
    "programs/registration/registration_numba.py", "formulas/registration/registration.py", "specs/cga3d.toml",
    *(f"../templates/numba/{name}" for name in (_TEMPLATE, *_PARTS)),
)  # fmt: skip
#: Of float64.
EPSILON = 2.0**-52
_DIGITS = 24


class RowPrinter(NumbaPrinter):
    """Python on float64 alone: constants are written as they are, which numba reads far faster."""

    def constant(self, value: Fraction) -> str:
        return decimal(value)

    def function(self, name: str, arguments: Sequence[str]) -> str:
        if name in ("nan", "epsilon"):
            return {"nan": "NAN", "epsilon": "EPSILON"}[name]
        return super().function(name, arguments).replace("K(1.0)", "1.0")

    def call(self, node: Node, arguments: Sequence[Sequence[str]], names: Sequence[str]) -> list[str]:
        raise NotImplementedError("kernels of the registration driver call no others")


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
        f"{coefficient_name(item, j)} = {item.name}_row[{item.name}_at + {j}]"
        for i, item in enumerate(kernel.inputs)
        for j in range(item.kind.size)
        if (i, j) in used
    ]
    lines += body
    start = 0
    for output in kernel.outputs:
        for j, node in enumerate(variant.roots[start : start + len(output.nodes)]):
            lines.append(f"{output.name}_result[{output.name}_to + {j}] = {printer.value(node)}")
        start += len(output.nodes)
    parameters = [f"{o.name}_{part}" for o in kernel.outputs for part in ("result", "to")]
    parameters += [f"{i.name}_{part}" for i in kernel.inputs for part in ("row", "at")]
    comment = f"{comment_text(kernel.note or kernel.name)} {variant.operations.text()}"
    return RowFunction(symbol(kernel), comment, wrap(parameters, 1), tuple(lines))


@cache
def reform_numba(kinds: tuple[str, ...]) -> str:
    """The text of the driver of these kinds: made once for each state of the sources, and kept in the cache.

    Raises
    ------
    InputError
        If there is no such kind, or none at all.
    """
    wanted = in_order(kinds)
    digest, name = source_digest.digest(_SOURCES), f"{'_'.join(wanted)}.py"
    group = digest and f"reform_numba_{digest[:_DIGITS]}"
    found = text_cache.read(group, name) if group else None
    if found is None:
        found = _text(wanted)
        if group:
            text_cache.write(group, {name: found})
    elif group:
        text_cache.touch(group)
    return found


def _text(wanted: tuple[str, ...]) -> str:
    made = driver_spec(wanted)
    functions = [row_function(as_written(trace_spec(each))) for each in made.specs]
    return render(_TEMPLATE, **made.values, functions=functions, epsilon=repr(EPSILON))
