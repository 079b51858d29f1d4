"""Printing of a form's graph as straight-line code: what all targets share.

A target says how a constant, a function, a selection, a declaration and a call look; the rest is the same text
everywhere, in the same order of operations, so that all targets compute the same bits.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Sequence
from fractions import Fraction

from ..binding import Argument
from ..graph import Node, reachable
from ..simplify import Form
from ..trace import Input, Kernel

#: A single-use value longer than this gets a name: lines that a person can read.
MAX_INLINE = 72


def blade_label(algebra_name: str) -> str:
    """Blade names as they may stand in identifiers: the scalar's "1" becomes "s"."""
    return "s" if algebra_name == "1" else algebra_name


def coefficient_name(item: Input, index: int) -> str:
    """Local variable of one input coefficient, for example ``m_e12``."""
    if item.kind.form == "numbers":
        return f"{item.name}_{index}"
    return f"{item.name}_{blade_label(item.kind.algebra.blade_name(item.kind.blades[index]))}"


def comment_text(note: str) -> str:
    """A note on one line that cannot end a comment of any target, nor begin another."""
    return " ".join(note.split()).replace("/*", "/ *").replace("*/", "* /")


def interface(kernel: Kernel) -> tuple[list[Argument], list[Argument]]:
    """Inputs and outputs of a kernel as functions of arrays see them."""
    inputs = [Argument(i.name, 0 if i.kind.is_scalar_argument else i.kind.size) for i in kernel.inputs]
    codes = [o.role == "status" for o in kernel.outputs]
    outputs = [
        Argument(o.name, 0 if code else len(o.nodes), code) for o, code in zip(kernel.outputs, codes, strict=True)
    ]
    return inputs, outputs


class Printer(ABC):
    """Statements for one form in one language."""

    def __init__(self, form: Form) -> None:
        self.form = form
        self.kernel = form.kernel
        self.lines: list[str] = []
        self.nodes = self._order()
        self.uses = Counter(a.id for node in self.nodes for a in node.args)
        self.uses.update(node.id for node in form.roots)
        self.text: dict[int, str] = {}
        self.atomic: set[int] = set()
        self.calls: dict[tuple[Kernel, tuple[int, ...]], list[str]] = {}
        self.names = 0

    def _order(self) -> list[Node]:
        """Depth first from the outputs: values are made shortly before they are used."""
        order: dict[int, Node] = {}
        for root in self.form.roots:
            stack: list[tuple[Node, bool]] = [(root, False)]
            while stack:
                node, done = stack.pop()
                if node.id in order:
                    continue
                if done:
                    order[node.id] = node
                else:
                    stack.append((node, True))
                    stack.extend((a, False) for a in reversed(node.args))
        assert len(order) == len(reachable(self.form.roots))
        return list(order.values())

    # -- what a target says --------------------------------------------------------------------------------

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
            self._set(node, coefficient_name(self.kernel.inputs[i], j), atomic=True)
        elif node.op == "call":
            self._set(node, self._called(node), atomic=True)
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
        if self.uses[node.id] > 1 or len(text) > MAX_INLINE:
            self._name(node, text)
        else:
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

    def _called(self, node: Node) -> str:
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
