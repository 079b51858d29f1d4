"""Printing of a variant's graph as straight-line code: the part that all targets share.

A target says how a constant, a function, a selection, a declaration and a call look; the rest is the same text
everywhere, in the same order of operations, so that all targets compute the same bits.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Sequence
from fractions import Fraction

from ..ir.graph import Node, in_order_of_use
from ..optimise.variants import Variant
from ..trace.kernel import Kernel, coefficient_names

#: A single-use value longer than this gets a name: lines that a person can read. Numbers of rows count as if they were
#: numbered, so that what they are called changes no compiled code.
MAX_INLINE = 72


def comment_text(note: str) -> str:
    """A note on one line that cannot end a comment of any target, nor begin another, with what can be seen alone."""
    seen = "".join(c if c.isprintable() or c.isspace() else "?" for c in note)
    return " ".join(seen.split()).replace("/*", "/ *").replace("*/", "* /")


class Printer(ABC):
    """Statements for one variant in one language."""

    def __init__(self, variant: Variant) -> None:
        self.variant = variant
        self.kernel = variant.kernel
        self.coefficients = coefficient_names(self.kernel.inputs)
        self.lines: list[str] = []
        self.nodes = in_order_of_use(variant.roots)
        self.uses = Counter(a.id for node in self.nodes for a in node.args)
        self.uses.update(node.id for node in variant.roots)
        self.text: dict[int, str] = {}
        self.atomic: set[int] = set()
        self.excess: dict[int, int] = {}  # characters of names of numbers, beyond those of their index
        self.calls: dict[tuple[Kernel, tuple[int, ...]], list[str]] = {}
        self.names = 0

    # -- the part of a target --------------------------------------------------------------------------------

    @abstractmethod
    def constant(self, value: Fraction) -> str:
        """A constant inside arithmetic."""

    def splat(self, value: Fraction) -> str:
        """A constant that stands alone where a value is needed."""
        return self.constant(value)

    @abstractmethod
    def declare(self, name: str, text: str, mask: bool = False) -> str:
        """Statement that gives a value a name."""

    @abstractmethod
    def function(self, name: str, arguments: Sequence[str]) -> str:
        """Unary or binary function, comparison, or selection."""

    @abstractmethod
    def call(self, node: Node, arguments: Sequence[Sequence[str]], names: Sequence[str]) -> list[str]:
        """Statements that call another kernel; its outputs are then ``names[output][index]``."""

    # -- statements ----------------------------------------------------------------------------------------

    def body(self) -> list[str]:
        """Statements that compute every named value; afterwards `value` prints the outputs."""
        for node in self.nodes:
            self._visit(node)
        return self.lines

    def value(self, node: Node) -> str:
        """Expression of a root."""
        return self.splat(node.data) if node.op == "const" else self.text[node.id]

    def _visit(self, node: Node) -> None:
        if node.op == "const":
            return
        if node.op == "var":
            i, j = node.data
            item = self.kernel.inputs[i]
            self.excess[node.id] = len(item.labels[j]) - len(str(j)) if item.labels else 0
            self._set(node, self.coefficients[i][j], atomic=True)
        elif node.op == "call":
            self._set(node, self._call_element(node), atomic=True)
        elif node.op == "sum":
            self._arithmetic(node, self._sum(node))
        elif node.op == "mul":
            a, b = node.args
            self._arithmetic(node, f"{self._factor(a, left=True)} * {self._factor(b)}")
        else:
            mask = node.op in ("lt", "le", "and", "or", "not")
            self._name(node, self.function(node.op, [self._argument(a) for a in node.args]), mask)

    def _argument(self, node: Node) -> str:
        return self.splat(node.data) if node.op == "const" else self.text[node.id]

    def _set(self, node: Node, text: str, atomic: bool) -> None:
        self.text[node.id] = text
        if atomic:
            self.atomic.add(node.id)

    def _name(self, node: Node, text: str, mask: bool = False) -> None:
        name = f"t{self.names}"
        self.names += 1
        self.lines.append(self.declare(name, text, mask))
        self._set(node, name, atomic=True)

    def _arithmetic(self, node: Node, text: str) -> None:
        excess = sum(self.excess.get(a.id, 0) for a in node.args)
        if self.uses[node.id] > 1 or len(text) - excess > MAX_INLINE:
            self._name(node, text)
        else:
            self.excess[node.id] = excess
            self._set(node, text, atomic=False)

    def _factor(self, node: Node, left: bool = False) -> str:
        text = self.text[node.id]
        if node.id in self.atomic or (left and node.op == "mul"):
            return text
        return f"({text})"

    def _sum(self, node: Node) -> str:
        terms = list(zip(node.args, node.data, strict=True))
        first = next((i for i, (_, w) in enumerate(terms) if w > 0), 0)
        terms.insert(0, terms.pop(first))
        text = ""
        for arg, weight in terms:
            magnitude = abs(weight)
            if arg.op == "const":
                part = self.constant(arg.data * magnitude)
            else:
                inner = self.text[arg.id]
                bare = arg.id in self.atomic or arg.op == "mul"
                part = inner if bare and magnitude == 1 else f"({inner})" if not bare else inner
                if magnitude != 1:
                    part = f"{self.constant(magnitude)} * " + (inner if arg.id in self.atomic else f"({inner})")
            sign = "-" if weight < 0 else "+"
            text = f"{text} {sign} {part}" if text else (f"-{part}" if weight < 0 else part)
        return text

    def _call_element(self, node: Node) -> str:
        kernel, output, index = node.data
        key = (kernel, tuple(a.id for a in node.args))
        if key not in self.calls:
            number = len(self.calls)
            names = [f"c{number}_{item.name}" for item in kernel.outputs]
            flat = [self._argument(a) for a in node.args]
            grouped, start = [], 0
            for item in kernel.inputs:
                grouped.append(flat[start : start + item.kind.size])
                start += item.kind.size
            self.lines.extend(self.call(node, grouped, names))
            self.calls[key] = names
        return f"{self.calls[key][output]}[{index}]"


def decimal(value: Fraction) -> str:
    """The shortest decimal that reads back as the nearest double."""
    return repr(value.numerator / value.denominator)
