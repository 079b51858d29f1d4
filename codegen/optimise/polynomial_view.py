"""Between expression graphs and polynomials: roots, selections and calls become atoms, the rest expands.

`extract_polynomials` reads a kernel's outputs (and the arguments of its atoms) as polynomials, `rebuild` turns factored
expressions into nodes again. A rebuilt form is compared with the original at the graph's exact points.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from ..algebra.algebra import Kind
from ..algebra.members import residuals
from ..algebra.multivector import from_values
from ..ir.graph import Graph, Node, reachable
from ..rings.protocol import RationalRing, Terms
from ..trace.kernel import Kernel
from .factor.factor import Atom, Constant, Expr, Poly, Sum, multiply

#: A polynomial with more terms is not expanded: factoring it would cost more than it could save.
MAX_TERMS = 400


class TooManyTerms(Exception):
    """Expansion passed `MAX_TERMS`."""


def _times(a: Poly, b: Poly) -> Poly:
    if len(a) * len(b) > 4 * MAX_TERMS:
        raise TooManyTerms
    return _prune(multiply(a, b))


def _plus(terms: Sequence[tuple[Poly, Fraction]]) -> Poly:
    result: Poly = {}
    for poly, weight in terms:
        for m, c in poly.items():
            result[m] = result.get(m, Fraction(0)) + c * weight
    return _prune(result)


def _prune(poly: Poly) -> Poly:
    pruned = {m: c for m, c in poly.items() if c}
    if len(pruned) > MAX_TERMS:
        raise TooManyTerms
    return pruned


class PolynomialRing(RationalRing):
    """Polynomials in atoms, as dictionaries; for constraints, which have no roots."""

    def constant(self, value: Fraction) -> Poly:  # type: ignore[override]
        return {(): value} if value else {}

    def combine(self, terms: Terms) -> Poly:  # type: ignore[override]
        return _plus(list(terms))

    def multiply(self, a: Poly, b: Poly) -> Poly:  # type: ignore[override]
        return _times(a, b)

    def is_zero(self, a: Poly) -> bool:  # type: ignore[override]
        return not a


@dataclass(frozen=True)
class PolynomialView:
    """A kernel as polynomials.

    ``targets`` are the outputs and, before them, the arguments of the opaque atoms; ``polynomials`` are theirs.
    """

    atoms: tuple[Node, ...]
    targets: tuple[Node, ...]
    polynomials: tuple[Poly, ...]


def extract_polynomials(kernel: Kernel, keep_shared: bool) -> PolynomialView:
    """Polynomials of a kernel.

    With ``keep_shared`` the sums that are used more than once stay as atoms with polynomials of their own, as the
    formula was written; otherwise everything is expanded into inputs and opaque values.

    Raises
    ------
    TooManyTerms
        If a polynomial would be too large.
    """
    nodes = reachable(kernel.roots)
    uses: dict[int, int] = {}
    for node in nodes:
        for a in node.args:
            uses[a.id] = uses.get(a.id, 0) + 1
    atoms: list[Node] = []
    targets: list[Node] = []
    wanted: list[Poly] = []
    polynomials: dict[int, Poly] = {}

    def atom(node: Node) -> Poly:
        atoms.append(node)
        return {((len(atoms) - 1, 1),): Fraction(1)}

    for node in nodes:
        if node.op == "const":
            polynomials[node.id] = {(): node.data} if node.data else {}
        elif node.op == "var":
            polynomials[node.id] = atom(node)
        elif node.op in ("sum", "mul"):
            args = [polynomials[a.id] for a in node.args]
            expanded = _times(*args) if node.op == "mul" else _plus(list(zip(args, node.data, strict=True)))
            shared = uses.get(node.id, 0) > 1 and len(node.args) > 1
            if keep_shared and shared:
                targets.append(node)
                wanted.append(expanded)
                expanded = atom(node)
            polynomials[node.id] = expanded
        else:
            for a in node.args:
                if a.op in ("sum", "mul") and a not in targets:
                    targets.append(a)
                    wanted.append(polynomials[a.id])
            polynomials[node.id] = atom(node)
    for root in kernel.roots:
        targets.append(root)
        wanted.append(polynomials[root.id])
    return PolynomialView(tuple(atoms), tuple(targets), tuple(wanted))


def constraint_polynomials(kernel: Kernel, atoms: Sequence[Node]) -> list[tuple[Kind, list[Poly]]]:
    """Constraints of the inputs' kinds, as polynomials in the atoms; inputs without any are left out."""
    place = {node.data: i for i, node in enumerate(atoms) if node.op == "var"}
    ring = PolynomialRing()
    found = []
    for i, item in enumerate(kernel.inputs):
        if item.kind.is_layout:
            continue
        values: list[Poly] = []
        for j in range(item.kind.size):
            index = place.get((i, j))
            if index is None and any(n.op == "var" and n.data == (i, j) for n in kernel.graph.nodes):
                index = len(atoms) + sum(k.kind.size for k in kernel.inputs[:i]) + j  # in the constraints only
            values.append({} if index is None else {((index, 1),): Fraction(1)})
        member = from_values(item.kind.algebra, ring, item.kind.blades, values)
        polys = [p for mv in residuals(item.kind, member) for p in mv.terms.values() if p]
        if polys:
            found.append((item.kind, polys))
    return found


def rebuild(graph: Graph, parts: PolynomialView, expressions: Sequence[Expr], count: int) -> tuple[Node, ...]:
    """Nodes of factored expressions (one per target); returns the last ``count``: the outputs."""
    by_target: dict[int, Expr] = {}
    for t, e in zip(parts.targets, expressions, strict=True):
        by_target.setdefault(t.id, e)  # a shared sum that is also an output: its definition comes first
    made: dict[int, Node] = {}
    expression_nodes: dict[int, Node] = {}

    def atom_node(node: Node) -> Node:
        if node.id not in made:
            if node.op == "var":
                made[node.id] = node
            elif node.op in ("sum", "mul"):
                made[node.id] = build(by_target[node.id])
            else:
                made[node.id] = _again(graph, node, [argument(a) for a in node.args])
        return made[node.id]

    def argument(node: Node) -> Node:
        if node.op == "const":
            return node
        return build(by_target[node.id]) if node.id in by_target else atom_node(node)

    def build(e: Expr) -> Node:
        known = expression_nodes.get(id(e))
        if known is not None:
            return known
        if isinstance(e, Atom):
            node = atom_node(parts.atoms[e.index])
        elif isinstance(e, Constant):
            node = graph.constant(e.value)
        elif isinstance(e, Sum):
            node = graph.combine([(build(t), w) for t, w in e.terms])
        else:
            node = build(e.factors[0])
            for f in e.factors[1:]:
                node = graph.multiply(node, build(f))
        expression_nodes[id(e)] = node
        return node

    return tuple(build(e) for e in expressions[len(expressions) - count :])


def _again(graph: Graph, node: Node, args: Sequence[Node]) -> Node:
    """The same operation on other nodes of equal value."""
    if node.op == "select":
        return graph.select(*args)
    if node.op == "call":
        return graph.call(node.data[0], args, node.data[1:], graph.values[node.id], graph.comparisons[node.id])
    return graph.apply(node.op, *args)


def same_values(graph: Graph, first: Sequence[Node], second: Sequence[Node]) -> bool:
    """Return whether nodes agree at every living sample point."""
    pairs = zip(first, second, strict=True)
    one = Fraction(1)
    return all(
        graph.samples.is_zero(graph.samples.combine([(graph.values[a.id], one), (graph.values[b.id], -one)]))
        for a, b in pairs
    )
