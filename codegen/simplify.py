"""Forms of a kernel: as written, factored, reduced modulo the kinds' constraints; the cheapest that is as accurate.

A form is a list of nodes that compute the kernel's outputs. Forms differ in rounding and cost, never in exact
value on the declared kinds. The choice depends on counts and bounds only, so every machine emits the same text.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from .graph import Node, reachable
from .trace import Kernel


@dataclass(frozen=True)
class Operations:
    """Operation counts of straight-line code."""

    multiplications: int
    additions: int
    others: int

    @property
    def total(self) -> int:
        """All of them, equally weighted: contraction is off, so multiplications and additions cost the same."""
        return self.multiplications + self.additions + self.others

    def text(self) -> str:
        """For headers and reports."""
        other = f", {self.others} other" if self.others else ""
        return f"{self.multiplications} mul, {self.additions} add{other}."


@dataclass(frozen=True, eq=False)
class Form:
    """One way to compute a kernel."""

    kernel: Kernel
    name: str
    roots: tuple[Node, ...]

    @cached_property
    def operations(self) -> Operations:
        """Counts of this form, the kernels that it calls included."""
        return count(self.roots)


def count(roots: tuple[Node, ...]) -> Operations:
    """Operations of the nodes that the roots need."""
    multiplications = additions = others = 0
    called: set[tuple[str, tuple[int, ...]]] = set()
    for node in reachable(roots):
        if node.op == "sum":
            additions += len(node.args) - 1
            multiplications += sum(
                abs(w) != 1 and a.op != "const" for a, w in zip(node.args, node.data, strict=True)
            )
        elif node.op == "mul":
            multiplications += 1
        elif node.op == "call":
            kernel = node.data[0]
            key = (kernel.name, tuple(a.id for a in node.args))
            if key not in called:
                called.add(key)
                inner = chosen_form(kernel).operations
                multiplications += inner.multiplications
                additions += inner.additions
                others += inner.others
        elif node.op not in ("var", "const"):
            others += 1
    return Operations(multiplications, additions, others)


def staged(kernel: Kernel) -> Form:
    """The kernel as its formula was written, dead code removed."""
    return Form(kernel, "staged", kernel.roots)


def chosen_form(kernel: Kernel) -> Form:
    """The form that is printed."""
    return staged(kernel)
