"""Factored expressions as plain data, and back: how chosen forms are checked in.

A record lists nodes in order of need: an integer is an atom, a string a constant, ["+", node, weight, ...] a sum and
["*", node, ...] a product of earlier nodes; "targets" are the nodes of the polynomials.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

from .factor import Atom, Constant, Expr, Product, Sum

#: {"variant": name, "nodes": [...], "targets": [...]}; the variant as written has no nodes.
Record = Mapping[str, Any]


def encode(expressions: Sequence[Expr]) -> dict[str, list[Any]]:
    """Nodes and targets of expressions; shared ones are written once."""
    places: dict[int, int] = {}
    nodes: list[Any] = []

    def place(e: Expr) -> int:
        if id(e) not in places:
            match e:
                case Atom(index):
                    node: Any = index
                case Constant(value):
                    node = str(value)
                case Sum(terms):
                    node = ["+", *(part for t, w in terms for part in (place(t), str(w)))]
                case Product(factors):
                    node = ["*", *(place(f) for f in factors)]
            nodes.append(node)
            places[id(e)] = len(nodes) - 1
        return places[id(e)]

    targets = [place(e) for e in expressions]
    return {"nodes": nodes, "targets": targets}


def decode(record: Record) -> list[Expr]:
    """Expressions of a record. Raises KeyError, IndexError, ValueError or TypeError where it is malformed."""
    made: list[Expr] = []

    def at(index: int) -> Expr:
        if not 0 <= index < len(made):
            raise IndexError(f"node {index} comes before it is made")
        return made[index]

    for node in record["nodes"]:
        if isinstance(node, int):
            made.append(Atom(node))
        elif isinstance(node, str):
            made.append(Constant(Fraction(node)))
        elif node[0] == "+":
            pairs = zip(node[1::2], node[2::2], strict=True)
            made.append(Sum(tuple((at(i), Fraction(w)) for i, w in pairs)))
        elif node[0] == "*":
            made.append(Product(tuple(at(i) for i in node[1:])))
        else:
            raise ValueError(f"unknown node {node!r}")
    return [at(i) for i in record["targets"]]
