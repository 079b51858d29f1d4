"""From a formula in GA notation to a `Kernel`: named inputs of known kinds, an expression graph, outputs.

The kind of each output is proved at random exact points: `returns` is checked, otherwise the narrowest kind of
the algebra that holds is taken.
"""

from __future__ import annotations

import inspect
import traceback
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Any

from ..algebra.algebra import Algebra, Kind, numbers
from ..algebra.blades import validated_identifier
from ..algebra.members import SampleSource, sample, violation
from ..algebra.multivector import Multivector, from_values
from ..errors import BladesmithError, TraceError
from ..ir.graph import SAMPLES, Graph, NeedMoreSamples
from ..rings.protocol import SampleRing
from .kernel import Formula, Input, Kernel, Output, argument_names, operand
from .outputs import Result, as_outputs
from .rows import row_labels, row_type

#: Seed of the random points: the same text for the same formula, always.
SEED = 20260101


def trace(
    formula: Formula,
    kinds: Sequence[Kind],
    name: str | None = None,
    returns: Kind | None = None,
    algebra: Algebra | None = None,
    note: str = "",
    arguments: Sequence[str] | None = None,
    layouts: Sequence[Kind] = (),
) -> Kernel:
    """Run ``formula`` on symbolic members of ``kinds`` and keep what it did.

    Results have the blades of ``layouts``, where they suffice.

    Raises
    ------
    TraceError
        If the formula divides by an identical zero, returns something else than multivectors, takes another
        number of arguments, or if ``returns`` does not hold.
    """
    name = validated_identifier(name or formula.__name__, "a kernel's name")
    arguments = arguments or argument_names(formula)
    if len(kinds) != len(arguments):
        raise TraceError(f"{name} takes {len(arguments)} arguments, but {len(kinds)} kinds were declared.")
    algebra = algebra or next((k.algebra for k in kinds if not k.is_scalar_argument), kinds[0].algebra)
    inputs = tuple(
        Input(validated_identifier(a, "an argument"), k, row_labels(formula, a, k, algebra), row_type(formula, a, k))
        for a, k in zip(arguments, kinds, strict=True)
    )
    note = note or (inspect.getdoc(formula) or "").split("\n")[0]
    samples = SAMPLES[0]
    while True:
        graph = Graph(samples)
        try:
            results = as_outputs(_run(formula, _symbols(graph, inputs), name))
            outputs = _distinct(_outputs(graph, algebra, results, returns, name, layouts), inputs)
        except NeedMoreSamples as needed:
            samples = next((n for n in SAMPLES if n >= needed.count), SAMPLES[-1])
            continue
        graph.frozen = True
        again = partial(trace, formula, kinds, name, returns, algebra, note, arguments, layouts)
        return Kernel(name, algebra, inputs, outputs, graph, formula, note, again)


def _run(formula: Formula, symbols: Sequence[Any], name: str) -> Any:
    """The formula's result; what goes wrong in it is told with the line of the formula."""
    try:
        return formula(*symbols)
    except (BladesmithError, NeedMoreSamples):
        raise
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
        frames = [f for f in traceback.extract_tb(error.__traceback__) if f.filename == formula.__code__.co_filename]
        place = f" in line {frames[-1].lineno}, `{frames[-1].line}`" if frames else ""
        raise TraceError(
            f"the formula {name} cannot be run on symbols{place}: {error}. Formulas combine multivectors with "
            "numbers, the operators of geometric algebra and the functions of bladesmith.codegen."
        ) from error


def _symbols(graph: Graph, inputs: Sequence[Input]) -> list[Any]:
    source = SampleSource(graph.samples, SEED)
    symbols: list[Any] = []
    for i, item in enumerate(inputs):
        if item.kind.form == "numbers":
            values = [graph.variable((i, j), source.scalar()) for j in range(item.kind.size)]
            symbols.append(operand(item.kind, graph, values, item.row))
            continue
        member = sample(item.kind, source)
        terms = {
            blade: graph.variable((i, j), member.terms[blade])
            for j, blade in enumerate(item.kind.blades)
            if blade in member.terms
        }
        symbols.append(Multivector(item.kind.algebra, graph, terms))
    return symbols


def _outputs(
    graph: Graph,
    algebra: Algebra,
    results: Sequence[Result],
    returns: Kind | None,
    name: str,
    layouts: Sequence[Kind],
) -> tuple[Output, ...]:
    outputs = []
    for i, result in enumerate(results):
        mv = result.value
        if result.is_row:
            kind = numbers(algebra, len(result.values))
            nodes = tuple(v.scalar() for v in result.values)
            outputs.append(Output(result.name or ("out" if i == 0 else f"out{i}"), kind, nodes))
            continue
        if returns is not None and i == 0:
            kind = returns
            problem = violation(kind, _sample_values(graph, mv))
            if problem is None and not kind.is_layout and not graph.can_prove(mv.terms.values()):
                problem = "it has too many comparisons to be proved"
            if problem:
                raise TraceError(f"{name} does not return a {kind.name}: {problem}.")
        else:
            fits = i < len(layouts) and layouts[i].form == "multivector" and set(mv.terms) <= set(layouts[i].blades)
            kind = layouts[i] if fits else infer_kind(graph, mv)
        nodes = tuple(mv.terms.get(b, graph.zero) for b in kind.blades)
        outputs.append(Output(result.name or ("out" if i == 0 else f"out{i}"), kind, nodes, result.role))
    return tuple(outputs)


def _distinct(outputs: Sequence[Output], inputs: Sequence[Input]) -> tuple[Output, ...]:
    """Outputs with names that no argument and no other output has: they share one scope in generated code."""
    taken = {item.name for item in inputs}
    renamed = []
    for output in outputs:
        name = output.name
        while name in taken:
            name += "_"
        taken.add(name)
        renamed.append(replace(output, name=name))
    return tuple(renamed)


def _sample_values(graph: Graph, mv: Multivector) -> Multivector:
    """The multivector's exact values, at the graph's sample points."""
    ring: SampleRing = graph.samples
    return from_values(mv.algebra, ring, mv.terms, [graph.values[node.id] for node in mv.terms.values()])


def infer_kind(graph: Graph, mv: Multivector) -> Kind:
    """The narrowest kind of the algebra that the value provably belongs to; else its own blades as a layout."""
    values = _sample_values(graph, mv)
    provable = graph.can_prove(mv.terms.values())
    fitting = [
        kind
        for kind in reversed(mv.algebra.kinds.values())  # of equal ones the plain kinds win: "bivector", not "twist"
        if set(mv.terms) <= set(kind.blades)
        and (kind.is_layout or provable)
        and (kind.size <= 2 * len(mv.terms))
        and violation(kind, values) is None
    ]
    own = tuple(mv.terms)
    if not own:
        own = (0,)
    best = min(fitting, key=lambda k: (k.size, -len(k.constraints)), default=None)
    if best is None or (best.is_layout and best.size > len(own)):
        joined = "_".join(mv.algebra.blade_name(b) for b in own) if len(own) <= 4 else f"blades{len(own)}"
        return Kind(mv.algebra, joined, own)
    return best
