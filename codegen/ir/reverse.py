"""Reverse derivatives of an expression graph: cotangents of its results become cotangents of its variables.

The adjoint method on any ring, so that the derivative is a formula as others are: over a graph a kernel, over mpmath
numbers its reference, over dual numbers its own derivative. A branch of a selection that is not taken may be infinite;
its adjoint is zero, and 0 times infinity no number. What such a value multiplies is therefore selected again.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from fractions import Fraction
from typing import Any

from ..rings.partials import partials
from ..rings.protocol import PREDICATES, Ring
from .graph import Node, all_values, reachable

Place = tuple[int, int]
#: When an adjoint counts: one of these sets of outcomes of comparisons (by the comparison's node) has come true.
_Guard = frozenset[frozenset[tuple[int, bool]]]
_ALWAYS: _Guard = frozenset([frozenset()])
#: Operations whose values are finite for all finite arguments; a function may have a pole, or overflow.
_TAME = ("var", "const", "sum", "mul", "select", "abs", "sin", "cos", "rounded", "epsilon", *PREDICATES)


def pull_back(
    roots: Sequence[Node],
    variables: Mapping[Place, Any],
    cotangents: Sequence[Any],
    wrt: Collection[int],
    ring: Ring,
) -> dict[Place, Any]:
    """Cotangents of variables.

    Parameters
    ----------
    roots : sequence of Node
        Of a graph without calls.
    variables : mapping
        Values of all variables, on the ring.
    cotangents : sequence
        One for each root, on the ring.
    wrt : collection of int
        Inputs whose coefficients vary.
    ring : Ring

    Returns
    -------
    dict
        By variable; those that no root depends on are left out.
    """
    return _Reverse(roots, variables, wrt, ring).run(cotangents)


class _Reverse:
    """One pass: the nodes' values, then adjoints from the roots down."""

    def __init__(self, roots: Sequence[Node], variables: Mapping[Place, Any], wrt: Collection[int], ring: Ring) -> None:
        self.ring, self.roots = ring, roots
        self.nodes = reachable(roots)
        self.values = all_values(self.nodes, variables, ring)
        self.zero = ring.constant(Fraction(0))
        self.active: set[int] = set()
        self.wild: set[int] = set()
        for node in self.nodes:
            if node.data[0] in wrt if node.op == "var" else any(a.id in self.active for a in node.args):
                self.active.add(node.id)
            if node.op not in _TAME or any(a.id in self.wild for a in node.args):
                self.wild.add(node.id)
        self.terms: dict[int, list[tuple[Any, Fraction]]] = {}
        self.guards: dict[int, _Guard] = {}
        self.masks: dict[_Guard, Any] = {}

    def run(self, cotangents: Sequence[Any]) -> dict[Place, Any]:
        for root, cotangent in zip(self.roots, cotangents, strict=True):
            self.add(root, cotangent, _ALWAYS)
        found: dict[Place, Any] = {}
        for node in reversed(self.nodes):
            if node.id in self.terms:
                adjoint, guard = self.ring.combine(self.terms.pop(node.id)), self.guards[node.id]
                if node.op == "var":
                    found[node.data] = adjoint
                else:
                    self.spread(node, adjoint, guard)
        return found

    def add(self, node: Node, adjoint: Any, guard: _Guard, weight: Fraction = Fraction(1)) -> None:
        """Add to a node's adjoint."""
        if node.id in self.active:
            self.terms.setdefault(node.id, []).append((adjoint, weight))
            self.guards[node.id] = _either(self.guards[node.id], guard) if node.id in self.guards else guard

    def spread(self, node: Node, adjoint: Any, guard: _Guard) -> None:
        """Give a node's adjoint on to its arguments."""
        args, ring = node.args, self.ring
        if node.op == "sum":
            for a, weight in zip(args, node.data, strict=True):
                self.add(a, adjoint, guard, weight)
        elif node.op == "mul":
            for a, other in (args, args[::-1]):
                if a.id in self.active:
                    self.scale(a, adjoint, self.values[other.id], guard, other.id in self.wild)
        elif node.op == "select":
            self.split(node, adjoint, guard)
        else:
            factors: Sequence[Callable[[], Any]] = partials(
                ring, node.op, self.values[node.id], [self.values[a.id] for a in args]
            )
            is_wild = node.id in self.wild
            for a, factor in zip(args, factors, strict=True):
                if a.id in self.active:
                    self.scale(a, adjoint, factor(), guard, is_wild)

    def scale(self, node: Node, adjoint: Any, factor: Any, guard: _Guard, is_wild: bool) -> None:
        """Add a product to a node's adjoint: zero where it does not count, whatever the factor is there."""
        product = self.ring.multiply(adjoint, factor)
        self.add(node, self.counted(product, guard) if is_wild else product, guard)

    def split(self, node: Node, adjoint: Any, guard: _Guard) -> None:
        """The adjoint of a selection is that of the branch taken; where that has no value there is no derivative."""
        chosen, *branches = node.args
        mask, outcome = self.values[chosen.id], _outcome(chosen)
        for i, (branch, other) in enumerate(zip(branches, branches[::-1], strict=True)):
            if branch.id not in self.active:
                continue
            taken = _both(guard, outcome if i == 0 else (outcome[0], not outcome[1]))
            if taken == guard:
                self.add(branch, adjoint, guard)
            elif taken:
                nothing = self.values[other.id] if other.op == "nan" else self.zero
                given = self.ring.select(mask, *((adjoint, nothing) if i == 0 else (nothing, adjoint)))
                if other.op == "nan":  # it counts in both branches: in the other one it is no number
                    taken, given = guard, self.counted(given, guard)
                self.add(branch, given, taken)

    def counted(self, adjoint: Any, guard: _Guard) -> Any:
        """The adjoint where it counts, else zero, whatever it is there."""
        return adjoint if guard == _ALWAYS else self.ring.select(self.mask(guard), adjoint, self.zero)

    def mask(self, guard: _Guard) -> Any:
        """The guard on the ring."""
        if guard not in self.masks:
            cases = [[self.outcome(*each) for each in sorted(case)] for case in sorted(guard, key=sorted)]
            self.masks[guard] = self.joined("or", [self.joined("and", case) for case in cases])
        return self.masks[guard]

    def outcome(self, comparison: int, is_true: bool) -> Any:
        mask = self.values[comparison]
        return mask if is_true else self.ring.apply("not", mask)

    def joined(self, operation: str, masks: Sequence[Any]) -> Any:
        first, *others = masks
        for other in others:
            first = self.ring.apply(operation, first, other)
        return first


def _outcome(mask: Node) -> tuple[int, bool]:
    """The comparison that a mask is of, and its outcome where the mask is true."""
    is_true = True
    while mask.op == "not":
        mask, is_true = mask.args[0], not is_true
    return mask.id, is_true


def _both(guard: _Guard, outcome: tuple[int, bool]) -> _Guard:
    """The guard and an outcome, without the cases that are impossible."""
    comparison, is_true = outcome
    return frozenset(case | {outcome} for case in guard if (comparison, not is_true) not in case)


def _either(first: _Guard, second: _Guard) -> _Guard:
    """One guard or the other: cases that differ in one outcome alone are one without it."""
    cases = set(first | second)
    while True:
        merged = next(
            (
                (case, other, case - {(c, t)})
                for case in cases
                for c, t in case
                if (other := (case - {(c, t)}) | {(c, not t)}) in cases
            ),
            None,
        )
        if merged is None:
            return frozenset(c for c in cases if not any(other < c for other in cases))
        case, other, rest = merged
        cases -= {case, other}
        cases.add(rest)
