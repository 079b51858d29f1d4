"""Calls between kernels: call nodes in the graph of the caller, under the same proofs as its own nodes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ..algebra.members import violation
from ..algebra.multivector import Multivector
from ..errors import TraceError
from ..ir.graph import Graph, NeedMoreSamples, Node
from .kernel import Kernel, operand


def call_in_graph(callee: Kernel, graph: Graph, arguments: Sequence[Any]) -> Any:
    """Nodes of a call inside a trace; the callee's kinds must hold for the arguments."""
    if callee.graph.samples.count > graph.samples.count:
        raise NeedMoreSamples(callee.graph.samples.count)
    flat: list[Node] = []
    like = next(a for a in arguments if isinstance(a, Multivector))
    for item, value in zip(callee.inputs, arguments, strict=True):
        if item.kind.form == "numbers":
            flat.extend(_lift(like, v).scalar() for v in value)
            continue
        mv = _lift(like, value)
        samples = Multivector(mv.algebra, graph.samples, {b: graph.values[n.id] for b, n in mv.terms.items()})
        problem = violation(item.kind, samples)
        if problem:
            raise TraceError(f"{callee.name}: argument {item.name} is not a {item.kind.name}: {problem}.")
        flat.extend(item.kind.values(mv))
    first = graph.samples.comparison_count
    values = callee.evaluate_flat([graph.values[n.id] for n in flat], graph.samples)
    graph.check_samples(f"the call of {callee.name}")
    own = frozenset(range(first, graph.samples.comparison_count))
    results: list[Any] = []
    for o, (output, samples_of_output) in enumerate(zip(callee.outputs, values, strict=True)):
        nodes = [graph.call(callee, flat, (o, j), sample, own) for j, sample in enumerate(samples_of_output)]
        results.append(operand(output.kind, graph, nodes))
    return results[0] if len(results) == 1 else tuple(results)


def _lift(like: Multivector, value: Any) -> Multivector:
    return value if isinstance(value, Multivector) else like.constant(value)
