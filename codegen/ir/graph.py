"""The expression graph of one kernel: nodes in the order in which they were made, each with its exact value.

A graph is a ring: formulas are traced by running them on it. Equal nodes are shared. Every node carries its value at
random points of the constrained variety over F_p. A node that is zero at all of them is zero identically
(Schwartz-Zippel) and is replaced by the constant 0; this finds sparsity, grades and constraints without expanding.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from math import factorial
from typing import Any

from ..errors import TraceError
from ..rings.modular import Samples
from ..rings.protocol import FUNCTIONS, STUMPFF, Ring, SampleRing, Terms

#: Numbers of sample points that a trace may use; each step is tried where the one before does not suffice.
SAMPLES = (16, 1024, 2048, 4096, 16384)
#: Sample points without roots and comparisons.
FEW_SAMPLES = SAMPLES[0]
#: Sample points with roots or comparisons: about 38 % survive one projector.
MANY_SAMPLES = SAMPLES[1]
#: The largest number of sample points.
MOST_SAMPLES = SAMPLES[-1]
#: Stumpff functions of zero: 1/k!.
STUMPFF_AT_ZERO = {name: Fraction(1, factorial(k)) for k, name in enumerate(STUMPFF)}
#: A graph with fewer living sample points than this cannot tell zero from bad luck.
ENOUGH_SAMPLES = 8


class NeedMoreSamples(Exception):
    """A root, a comparison or too many of them were met: trace again with at least ``count`` samples."""

    def __init__(self, count: int) -> None:
        super().__init__(count)
        self.count = count


class Node:
    """One value: an operation, its arguments, and data (a variable's place, a constant, a sum's weights)."""

    __slots__ = ("id", "op", "args", "data")

    def __init__(self, id: int, op: str, args: tuple[Node, ...], data: Any) -> None:
        self.id = id
        self.op = op
        self.args = args
        self.data = data

    def __repr__(self) -> str:
        return f"<{self.op} {self.id}>"


class Graph:
    """Hash-consed nodes over a ring of samples."""

    is_symbolic = True

    def __init__(self, samples: int = FEW_SAMPLES) -> None:
        self.samples = SampleRing(samples)
        self.nodes: list[Node] = []
        self.values: list[Any] = []
        self.comparisons: list[frozenset[int]] = []
        self.frozen = False  # once traced: variants are built on it, and it is not traced again with more sample points
        self.released = False
        self._known: dict[Any, Node] = {}
        self.zero = self.constant(Fraction(0))
        self.one = self.constant(Fraction(1))

    def _node(
        self, op: str, args: tuple[Node, ...], data: Any, value: Any, comparisons: frozenset[int] = frozenset()
    ) -> Node:
        node = Node(len(self.nodes), op, args, data)
        self._known[op, tuple(a.id for a in args), data] = node
        self.nodes.append(node)
        self.values.append(value)
        self.comparisons.append(comparisons.union(*(self.comparisons[a.id] for a in args)))
        return node

    def vanishes(self, value: Samples, args: Sequence[Node]) -> bool:
        """Return whether a value made of ``args`` is zero, as far as the sample points can tell.

        Values behind comparisons are zero only if they are in every combination of outcomes: a claim that needs
        living sample points for each.

        Raises
        ------
        NeedMoreSamples
            If there are too few sample points for the comparisons, and more can be had. With the most, the value counts
            as not zero: a coefficient too many does no harm.
        """
        if not self.samples.is_zero(value):
            return False
        return self.can_prove(args)

    def can_prove(self, nodes: Iterable[Node]) -> bool:
        """Return whether the sample points cover every outcome of their comparisons; may ask for more sample points."""
        comparisons = len(frozenset[int]().union(*(self.comparisons[n.id] for n in nodes)))
        wanted, alive = ENOUGH_SAMPLES << comparisons, int(self.samples.alive.sum())
        if wanted <= alive:
            return True
        if self.samples.count < MOST_SAMPLES and not self.frozen and wanted <= MOST_SAMPLES:  # else none suffice
            raise NeedMoreSamples(self.samples.count * wanted // max(alive, 1))
        return False

    def check_samples(self, what: str) -> None:
        """Raise `NeedMoreSamples`, or `TraceError` where there are no more, if too few sample points live."""
        if int(self.samples.alive.sum()) < ENOUGH_SAMPLES:
            if self.samples.count < MOST_SAMPLES:
                raise NeedMoreSamples(self.samples.count + 1)
            raise TraceError(f"too few exact points survive the nested roots at {what}; split the formula in kernels.")

    def _lookup(self, op: str, args: tuple[Node, ...], data: Any) -> Node | None:
        return self._known.get((op, tuple(a.id for a in args), data))

    def variable(self, coefficient: tuple[int, int], value: Samples) -> Node:
        """Coefficient ``place = (input, index)`` with its exact values."""
        if self.samples.is_zero(value):
            return self.zero
        return self._lookup("var", (), coefficient) or self._node("var", (), coefficient, value)

    def mark(self) -> int:
        """The graph's size now, for `rollback`."""
        return len(self.nodes)

    def rollback(self, mark: int) -> None:
        """Forget the nodes made since: what is built next does not depend on what was tried before."""
        for node in self.nodes[mark:]:
            del self._known[node.op, tuple(a.id for a in node.args), node.data]
        del self.nodes[mark:], self.values[mark:], self.comparisons[mark:]

    def release(self, roots: Iterable[Node]) -> None:
        """Forget the exact values, and every node that the roots do not need: for a kernel whose form is chosen.

        A node's values take 16 KB and more, a hundred times what the node itself does. Nothing can be built on
        the graph from now on.
        """
        self.nodes = reachable(roots)
        self.values, self.comparisons, self._known = [], [], {}
        self.samples.release()
        self.released = True

    # -- the ring ------------------------------------------------------------------------------------------

    def constant(self, value: Fraction) -> Node:
        value = Fraction(value)
        return self._lookup("const", (), value) or self._node("const", (), value, self.samples.constant(value))

    def combine(self, terms: Terms) -> Node:
        """Weighted sum, as written: like terms are collected, constants folded, nested sums kept."""
        weights: dict[int, Fraction] = {}
        constant = Fraction(0)
        for node, weight in terms:
            if node.op == "const":
                constant += node.data * weight
                continue
            if node.op == "sum" and len(node.args) == 1:  # a scaled node: scale once
                node, weight = node.args[0], weight * node.data[0]
            weights[node.id] = weights.get(node.id, Fraction(0)) + weight
        args = [self.nodes[i] for i, w in weights.items() if w]
        scales = [w for w in weights.values() if w]
        if constant:
            args.append(self.one)
            scales.append(constant)
        if not args:
            return self.zero
        if len(args) == 1 and args[0] is self.one:
            return self.constant(constant)
        if len(args) == 1 and scales[0] == 1:
            return args[0]
        known = self._lookup("sum", tuple(args), tuple(scales))
        if known:
            return known
        value = self.samples.combine([(self.values[a.id], w) for a, w in zip(args, scales, strict=True)])
        if len(args) > 1 and self.vanishes(value, args):
            return self.zero
        return self._node("sum", tuple(args), tuple(scales), value)

    def multiply(self, a: Node, b: Node) -> Node:
        if a.op == "const" or b.op == "const":
            constant, other = (a, b) if a.op == "const" else (b, a)
            return self.combine([(other, constant.data)])
        scale = Fraction(1)
        if a.op == "sum" and len(a.args) == 1:  # (s x) y = s (x y): weights end up in sums
            scale, a = scale * a.data[0], a.args[0]
        if b.op == "sum" and len(b.args) == 1:
            scale, b = scale * b.data[0], b.args[0]
        if b.id < a.id:
            a, b = b, a
        node = self._lookup("mul", (a, b), None)
        if node is None:
            value = self.samples.multiply(self.values[a.id], self.values[b.id])
            node = self._node("mul", (a, b), None, value)
        return node if scale == 1 else self.combine([(node, scale)])

    def apply(self, name: str, *arguments: Node) -> Node:
        known = self._lookup(name, arguments, None)
        if known:
            return known
        if not arguments:
            return self._node(name, (), None, self.samples.apply(name))
        if name == "reciprocal" and self.samples.is_zero(self.values[arguments[0].id]):
            raise TraceError("a divisor is identically zero on the declared kinds; declare the input as a layout.")
        if name == "reciprocal" and arguments[0].op == "const":  # no other function: at sample points they are opaque
            return self.constant(1 / arguments[0].data)
        if name == "sqrt" and (arguments[0] is self.zero or arguments[0] is self.one):
            return arguments[0]
        if name in ("sqrt", "lt", "le") and self.samples.count < MANY_SAMPLES:
            raise NeedMoreSamples(MANY_SAMPLES)
        if name in STUMPFF_AT_ZERO and arguments[0] is self.zero:
            return self.constant(STUMPFF_AT_ZERO[name])
        values = [self.values[a.id] for a in arguments]
        value = self.samples.apply(name, *values)
        self.check_samples(name)
        if name in FUNCTIONS and self.vanishes(value, arguments):
            return self.zero
        own = frozenset([self.samples.comparison(name, *values)]) if name in ("lt", "le") else frozenset[int]()
        return self._node(name, arguments, None, value, own)

    def select(self, mask: Node, a: Node, b: Node) -> Node:
        if a is b:
            return a
        known = self._lookup("select", (mask, a, b), None)
        if known:
            return known
        value = self.samples.select(self.values[mask.id], self.values[a.id], self.values[b.id])
        node = self._node("select", (mask, a, b), None, value)
        if "nan" in (a.op, b.op):  # the exact value is the other branch's, whatever the comparison says
            self.comparisons[node.id] = self.comparisons[b.id if a.op == "nan" else a.id]
        return node

    def call(
        self, kernel: Any, arguments: Sequence[Node], output: tuple[int, int], value: Samples, comparisons: Any
    ) -> Node:
        """Coefficient ``output = (output, index)`` of another kernel, called with all of its inputs' coefficients.

        ``comparisons`` are the comparisons that the callee made.
        """
        args, data = tuple(arguments), (kernel, *output)
        known = self._lookup("call", args, data)
        if known:
            return known
        node = self._node("call", args, data, value, comparisons)
        if self.vanishes(value, (node,)):
            self.rollback(node.id)
            return self.zero
        return node

    def is_zero(self, a: Node) -> bool:
        return a is self.zero


def reachable(roots: Iterable[Node]) -> list[Node]:
    """Nodes that the roots need, arguments first."""
    seen: dict[int, Node] = {}
    stack = list(roots)
    while stack:
        node = stack.pop()
        if node.id not in seen:
            seen[node.id] = node
            stack.extend(node.args)
    return [seen[i] for i in sorted(seen)]


def in_order_of_use(roots: Iterable[Node]) -> list[Node]:
    """Nodes that the roots need, depth first: values are made shortly before they are used."""
    order: dict[int, Node] = {}
    for root in roots:
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
    return list(order.values())


def evaluate(roots: Sequence[Node], variables: Mapping[tuple[int, int], Any], ring: Ring) -> list[Any]:
    """Values of nodes on another ring, given the values of the variables."""
    values = all_values(reachable(roots), variables, ring)
    return [values[r.id] for r in roots]


def all_values(nodes: Iterable[Node], variables: Mapping[tuple[int, int], Any], ring: Ring) -> dict[int, Any]:
    """Values by the nodes' numbers, of nodes in an order in which arguments come first."""
    values: dict[int, Any] = {}
    calls: dict[Any, list[list[Any]]] = {}
    for node in nodes:
        args = [values[a.id] for a in node.args]
        if node.op == "var":
            value = variables[node.data]
        elif node.op == "const":
            value = ring.constant(node.data)
        elif node.op == "sum":
            value = ring.combine(list(zip(args, node.data, strict=True)))
        elif node.op == "mul":
            value = ring.multiply(args[0], args[1])
        elif node.op == "select":
            value = ring.select(*args)
        elif node.op == "call":
            kernel, output, index = node.data
            key = (kernel, tuple(a.id for a in node.args))
            if key not in calls:
                calls[key] = kernel.evaluate_flat(args, ring)
            value = calls[key][output][index]
        else:
            value = ring.apply(node.op, *args)
        values[node.id] = value
    return values
