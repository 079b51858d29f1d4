"""Kernels: traced formulas with named inputs of known kinds, an expression graph, and outputs."""

from __future__ import annotations

import hashlib
import inspect
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Protocol

import numpy as np

from ..algebra.algebra import Algebra, Kind
from ..algebra.multivector import Multivector, from_values
from ..ir.argument import Argument
from ..ir.graph import Graph, Node, evaluate, reachable
from ..ir.loops.language import numbers_in_use
from ..ir.loops.nodes import KernelSignature
from ..rings.protocol import NumericRing, PrecisionRing, Ring
from .outputs import as_outputs

Formula = Callable[..., Any]


@dataclass(frozen=True)
class Input:
    """One argument of a kernel; of a row of numbers their names, and the named tuple that the formula takes."""

    name: str
    kind: Kind
    labels: tuple[str, ...] = ()
    row: Callable[..., Any] | None = None


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
    note: str
    again: Callable[[], Kernel] = field(repr=False)

    def release(self, *others: Node) -> None:
        """Free what only building needs: all but the nodes of the outputs and the given ones (see `Graph.release`)."""
        if not self.graph.released:
            _ = self.callees  # those in nodes that are not needed count, too
            self.graph.release([*self.roots, *others])

    def buildable(self) -> Kernel:
        """This kernel, or, where its graph has been released, the same traced once more: the same nodes."""
        return self.again() if self.graph.released else self

    @property
    def roots(self) -> tuple[Node, ...]:
        """All output nodes, in order."""
        return tuple(node for output in self.outputs for node in output.nodes)

    @cached_property
    def callees(self) -> tuple[Kernel, ...]:
        """Kernels that this one calls directly, in order of first use."""
        return tuple(dict.fromkeys(node.data[0] for node in self.graph.nodes if node.op == "call"))

    @cached_property
    def fingerprint(self) -> str:
        """Digest of what was traced: kinds and nodes. Kernels that share it have the same forms."""
        kinds = [(i.kind.form, i.kind.size, i.kind.blades, i.kind.constraints) for i in self.inputs]
        place: dict[int, int] = {}
        parts = [str(kinds)]
        for node in reachable(self.roots):
            place[node.id] = len(place)
            data = (node.data[0].fingerprint, *node.data[1:]) if node.op == "call" else node.data
            parts.append(f"{node.op} {[place[a.id] for a in node.args]} {data!r}")
        parts.append(str([place[root.id] for root in self.roots]))
        return hashlib.sha256("\n".join(parts).encode()).hexdigest()[:16]

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
        operands = [operand(i.kind, ring, values, i.row) for i, values in zip(self.inputs, arguments, strict=True)]
        results = as_outputs(self.formula(*operands))
        return [
            [v.scalar() for v in result.values] if output.kind.form == "numbers" else output.kind.values(result.value)
            for result, output in zip(results, self.outputs, strict=True)
        ]

    def signature(self, home: Any) -> KernelSignature:
        """The kernel as algorithms call it. ``home``: what declares it, whose ``variant`` is printed."""
        outputs = tuple((o.name, len(o.nodes)) for o in self.outputs)
        inputs = tuple((i.name, i.kind.size) for i in self.inputs)
        return KernelSignature(symbol_of(self.algebra, self.name), outputs, inputs, home)

    def on_numbers_in_use(self, arguments: Sequence[Any]) -> Any:
        """The formula itself on the numbers that algorithms use when they run as Python."""
        numbers = numbers_in_use()
        precise = PrecisionRing(numbers.dps) if hasattr(numbers, "dps") else None
        ring: Ring = precise or NumericRing(numbers)
        convert, back = (precise.context.mpf, numbers.mpf) if precise else (numbers, numbers)
        items = [[convert(v) for v in np.ravel(np.asarray(a, dtype=object))] for a in arguments]
        results = [[back(v) for v in r] for r in self.reference(ring, items)]
        arrays = [r[0] if len(r) == 1 else np.array(r, object if precise else numbers) for r in results]
        return arrays[0] if len(arrays) == 1 else tuple(arrays)


def value_layouts(outputs: Sequence[Output]) -> list[Kind]:
    """Layouts of the values among outputs: of what is no status."""
    return [output.kind.layout for output in outputs if output.role != "status"]


def operand(kind: Kind, ring: Ring, values: Sequence[Any], row: Callable[..., Any] | None = None) -> Any:
    """Argument of a formula: a multivector, or for rows of numbers a tuple of scalars, perhaps a named one."""
    if kind.form == "numbers":
        scalars = [Multivector(kind.algebra, ring, {0: v}) for v in values]
        return tuple(scalars) if row is None else row(*scalars)
    return from_values(kind.algebra, ring, kind.blades, values)


def argument_names(formula: Formula) -> list[str]:
    """Names of a formula's arguments; those with defaults are no inputs of its kernel."""
    return [p.name for p in inspect.signature(formula).parameters.values() if p.default is p.empty]


def symbol_of(algebra: Algebra, name: str) -> str:
    """Name in generated code of a kernel with this name."""
    return f"{algebra.name}_{name}"


def blade_label(algebra_name: str) -> str:
    """Blade names as they may stand in identifiers: the scalar's "1" becomes "s"."""
    return "s" if algebra_name == "1" else algebra_name


def coefficient_name(item: Input, index: int) -> str:
    """Local variable of one input coefficient, for example ``m_e12`` or ``robot_reach``."""
    if item.kind.form == "numbers":
        return f"{item.name}_{item.labels[index] if item.labels else index}"
    return f"{item.name}_{blade_label(item.kind.algebra.blade_name(item.kind.blades[index]))}"


#: What printers put behind the name of an argument or a result.
_PARTS = ("in", "out", "rows", "step", "columns", "row", "at", "result", "to")


def coefficient_names(inputs: Sequence[Input]) -> list[list[str]]:
    """Local variables of all coefficients of a kernel's inputs, each its own.

    `coefficient_name`, but for those that are that of another input's, such as ``x_e1`` and an argument ``x_e1`` of
    three numbers: these end in underscores.
    """
    taken = {f"{item.name}_{part}" for item in inputs for part in _PARTS}
    names = []
    for item in inputs:
        own = []
        for index in range(item.kind.size):
            name = coefficient_name(item, index)
            while name in taken:
                name += "_"
            taken.add(name)
            own.append(name)
        names.append(own)
    return names


class HasArguments(Protocol):
    """A kernel, or what is left of one that was compiled before."""

    @property
    def inputs(self) -> Sequence[Input]:
        """Its arguments."""

    @property
    def outputs(self) -> Sequence[Output]:
        """Its results."""


def interface(kernel: HasArguments) -> tuple[list[Argument], list[Argument]]:
    """Inputs and outputs of a kernel as functions of arrays see them."""
    inputs = [Argument(i.name, 0 if i.kind.is_scalar_argument else i.kind.size) for i in kernel.inputs]
    codes = [o.role == "status" for o in kernel.outputs]
    outputs = [
        Argument(o.name, 0 if code else o.kind.size, code) for o, code in zip(kernel.outputs, codes, strict=True)
    ]
    return inputs, outputs
