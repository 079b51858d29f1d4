"""From a formula in GA notation to a `Kernel`: named inputs of known kinds, an expression graph, outputs.

The kind of each output is proved at random exact points: `returns` is checked, otherwise the narrowest kind of
the algebra that holds is taken.
"""

from __future__ import annotations

import inspect
import traceback
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

from .algebra import Algebra, validated_identifier
from .errors import BladesmithError, TraceError
from .graph import LANES, Graph, MoreLanesNeeded, Node, evaluate
from .kinds import Kind, LaneSource, numbers
from .multivector import Multivector, from_values
from .rings import LaneRing, Ring

#: Seed of the random points: the same text for the same formula, always.
SEED = 20260101
Formula = Callable[..., Any]


@dataclass(frozen=True)
class Input:
    """One argument of a kernel."""

    name: str
    kind: Kind


@dataclass(frozen=True)
class Output:
    """One result: its name, its kind, and one node per blade of the kind.

    ``role`` is "value", or "status" for a code per item (`bladesmith.Status`) that is stored as a byte.
    """

    name: str
    kind: Kind
    nodes: tuple[Node, ...]
    role: str = "value"


@dataclass(frozen=True, eq=False)
class Kernel:
    """A traced formula."""

    name: str
    algebra: Algebra
    inputs: tuple[Input, ...]
    outputs: tuple[Output, ...]
    graph: Graph
    formula: Formula = field(repr=False)
    note: str = ""

    @property
    def roots(self) -> tuple[Node, ...]:
        """All output nodes, in order."""
        return tuple(node for output in self.outputs for node in output.nodes)

    @cached_property
    def called(self) -> tuple[Kernel, ...]:
        """Kernels that this one calls directly, in order of first use."""
        return tuple(dict.fromkeys(node.data[0] for node in self.graph.nodes if node.op == "call"))

    def evaluate_flat(self, values: Sequence[Any], ring: Ring) -> list[list[Any]]:
        """Outputs on a ring, from the flat list of all inputs' coefficients."""
        places = [(i, j) for i, item in enumerate(self.inputs) for j in range(item.kind.size)]
        flat = evaluate(self.roots, dict(zip(places, values, strict=True)), ring)
        result, start = [], 0
        for output in self.outputs:
            result.append(flat[start : start + len(output.nodes)])
            start += len(output.nodes)
        return result

    def reference(self, ring: Ring, arguments: Sequence[Sequence[Any]]) -> list[list[Any]]:
        """The formula itself on numbers: no graph, no form, no compiled code; restricted to the outputs' blades."""
        operands = [operand(item.kind, ring, values) for item, values in zip(self.inputs, arguments, strict=True)]
        results = as_outputs(self.formula(*operands))
        return [
            [v.scalar() for v in result.values] if output.kind.form == "numbers" else output.kind.values(result.value)
            for result, output in zip(results, self.outputs, strict=True)
        ]


def operand(kind: Kind, ring: Ring, values: Sequence[Any]) -> Any:
    """What a formula receives for one argument: a multivector, or a tuple of scalars for rows of numbers."""
    if kind.form == "numbers":
        return tuple(Multivector(kind.algebra, ring, {0: v}) for v in values)
    return from_values(kind.algebra, ring, kind.blades, values)


@dataclass(frozen=True)
class Result:
    """One value returned by a formula, with its role; a row of numbers has several scalars."""

    values: tuple[Multivector, ...]
    role: str = "value"
    name: str = ""
    is_row: bool = False

    @property
    def value(self) -> Multivector:
        """The only multivector."""
        return self.values[0]


def status(code: Multivector) -> Result:
    """Mark a scalar as the status code of the item."""
    return Result((code,), "status", "status")


def row(values: Sequence[Multivector], name: str = "") -> Result:
    """Return several scalars as one row of plain numbers."""
    return Result(tuple(values), name=name, is_row=True)


def named(name: str, value: Multivector) -> Result:
    """Give an output a name (the first is called "out" otherwise)."""
    return Result((value,), name=name)


def as_outputs(returned: Any) -> list[Result]:
    """What a formula returned, as a list: one multivector, or a tuple of multivectors and statuses."""
    items = returned if isinstance(returned, tuple) else (returned,)
    if not items:
        raise TraceError("a formula returns at least one multivector; this one returned an empty tuple.")
    results = [item if isinstance(item, Result) else Result((item,)) for item in items]
    for item in results:
        for value in item.values:
            if not isinstance(value, Multivector):
                raise TraceError(f"a formula returns multivectors, not {type(value).__name__}.")
    return results


def trace(
    formula: Formula,
    kinds: Sequence[Kind],
    name: str | None = None,
    returns: Kind | None = None,
    algebra: Algebra | None = None,
    note: str = "",
    arguments: Sequence[str] | None = None,
    like: Kernel | None = None,
) -> Kernel:
    """Run ``formula`` on symbolic members of ``kinds`` and keep what it did.

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
    inputs = tuple(Input(validated_identifier(a, "an argument"), k) for a, k in zip(arguments, kinds, strict=True))
    algebra = algebra or next((k.algebra for k in kinds if not k.is_scalar_argument), kinds[0].algebra)
    note = note or (inspect.getdoc(formula) or "").split("\n")[0]
    for lanes in LANES:
        graph = Graph(lanes)
        try:
            results = as_outputs(_run(formula, _symbols(graph, inputs), name))
            outputs = _distinct(_outputs(graph, algebra, results, returns, name, like), inputs)
        except MoreLanesNeeded:
            continue
        graph.sealed = True
        return Kernel(name, algebra, inputs, outputs, graph, formula, note)
    raise AssertionError("a graph of the most lanes asked for more")


def _run(formula: Formula, symbols: Sequence[Any], name: str) -> Any:
    """The formula's result; what goes wrong in it is told with the line of the formula."""
    try:
        return formula(*symbols)
    except (BladesmithError, MoreLanesNeeded):
        raise
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
        frames = [f for f in traceback.extract_tb(error.__traceback__) if f.filename == formula.__code__.co_filename]
        place = f" in line {frames[-1].lineno}, `{frames[-1].line}`" if frames else ""
        raise TraceError(
            f"the formula {name} cannot be run on symbols{place}: {error}. Formulas combine multivectors with "
            "numbers, the operators of geometric algebra and the functions of bladesmith.codegen."
        ) from error


def argument_names(formula: Formula) -> list[str]:
    """Names of a formula's arguments; those with defaults are no inputs of its kernel."""
    return [p.name for p in inspect.signature(formula).parameters.values() if p.default is p.empty]


def _symbols(graph: Graph, inputs: Sequence[Input]) -> list[Any]:
    source = LaneSource(graph.lanes, SEED)
    symbols: list[Any] = []
    for i, item in enumerate(inputs):
        if item.kind.form == "numbers":
            values = [graph.variable((i, j), source.scalar()) for j in range(item.kind.size)]
            symbols.append(operand(item.kind, graph, values))
            continue
        member = item.kind.sample(source)
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
    like: Kernel | None,
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
            problem = kind.violated(_lane_values(graph, mv))
            if problem is None and not kind.is_layout and not graph.can_prove(mv.terms.values()):
                problem = "it has too many comparisons to be proved"
            if problem:
                raise TraceError(f"{name} does not return a {kind.name}: {problem}.")
        else:
            kind = infer_kind(graph, mv)
            wanted = _value_of(like, i)
            if wanted is not None and set(mv.terms) <= set(wanted.blades):
                kind = wanted
        nodes = tuple(mv.terms.get(b, graph.zero) for b in kind.blades)
        outputs.append(Output(result.name or ("out" if i == 0 else f"out{i}"), kind, nodes, result.role))
    return tuple(outputs)


def _value_of(like: Kernel | None, place: int) -> Kind | None:
    """Layout of an output of the kernel whose derivative this is (statuses have none)."""
    values = [o.kind.layout for o in like.outputs if o.role != "status"] if like else []
    return values[place] if place < len(values) and values[place].form == "multivector" else None


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


def _lane_values(graph: Graph, mv: Multivector) -> Multivector:
    """The multivector's exact values, over the graph's lanes."""
    ring: LaneRing = graph.lanes
    return from_values(mv.algebra, ring, mv.terms, [graph.values[node.id] for node in mv.terms.values()])


def infer_kind(graph: Graph, mv: Multivector) -> Kind:
    """The narrowest kind of the algebra that the value provably belongs to; else its own blades as a layout."""
    values = _lane_values(graph, mv)
    provable = graph.can_prove(mv.terms.values())
    fitting = [
        kind
        for kind in reversed(mv.algebra.kinds.values())  # of equal ones the plain kinds win: "bivector", not "twist"
        if set(mv.terms) <= set(kind.blades)
        and (kind.is_layout or provable)
        and (kind.size <= 2 * len(mv.terms))
        and kind.violated(values) is None
    ]
    own = tuple(mv.terms)
    if not own:
        own = (0,)
    best = min(fitting, key=lambda k: (k.size, -len(k.constraints)), default=None)
    if best is None or (best.is_layout and best.size > len(own)):
        joined = "_".join(mv.algebra.blade_name(b) for b in own) if len(own) <= 4 else f"blades{len(own)}"
        return Kind(mv.algebra, joined, own)
    return best
