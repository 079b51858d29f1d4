"""Kernels as functions of the loop IR: the variant that is printed for C, in the same order of operations.

Results come first among the parameters, then inputs, each an array of its coefficients.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from fractions import Fraction

from ..ir.graph import Node, in_order_of_use
from ..ir.loops.nodes import (
    Allocate,
    Array,
    Assign,
    Binary,
    Call,
    Constant,
    Expression,
    Function,
    Intrinsic,
    Load,
    Select,
    Statement,
    Store,
    Unary,
    Variable,
    View,
    integer,
    real,
)
from ..ir.loops.types import BOOL, REAL, ArrayType, Parameter
from ..optimise.variants import Variant
from ..trace.kernel import Kernel, coefficient_name, symbol_of

#: An expression of more terms gets a name: lines that a person can read.
MOST_TERMS = 6
_PREDICATES = {"lt": "<", "le": "<=", "and": "and", "or": "or"}


def kernel_function(variant: Variant, functions: dict[Kernel, Function] | None = None) -> Function:
    """A variant as a function.

    Parameters
    ----------
    variant : Variant
    functions : dict of Kernel to Function, optional
        Those that were made before; those of kernels that this one calls are added.
    """
    known = {} if functions is None else functions
    found = known.get(variant.kernel)
    if found is None:
        found = known[variant.kernel] = _Reader(variant, known).function()
    return found


class _Reader:
    """Statements of one variant."""

    def __init__(self, variant: Variant, known: dict[Kernel, Function]) -> None:
        self.variant, self.kernel, self.known = variant, variant.kernel, known
        self.nodes = in_order_of_use(variant.roots)
        self.uses = Counter(a.id for node in self.nodes for a in node.args)
        self.uses.update(node.id for node in variant.roots)
        self.expressions: dict[int, Expression] = {}
        self.terms: dict[int, int] = {}
        self.calls: dict[tuple[Kernel, tuple[int, ...]], list[Array]] = {}
        self.body: list[Statement] = []
        self.count = 0
        self.taken = {o.name for o in self.kernel.outputs}

    def function(self) -> Function:
        kernel = self.kernel
        outputs = [Parameter(o.name, ArrayType(REAL, (len(o.nodes),)), "out") for o in kernel.outputs]
        inputs = [Parameter(self._unused(i.name), ArrayType(REAL, (i.kind.size,))) for i in kernel.inputs]
        self.inputs = [Array(p.name, p.type) for p in inputs if isinstance(p.type, ArrayType)]
        for node in sorted((n for n in self.nodes if n.op == "var"), key=lambda n: n.data):
            self._load(node)
        for node in self.nodes:
            if node.op != "var":
                self._visit(node)
        roots = iter(self.variant.roots)
        for output, parameter in zip(kernel.outputs, outputs, strict=True):
            assert isinstance(parameter.type, ArrayType)
            array = Array(parameter.name, parameter.type)
            for k in range(len(output.nodes)):
                self.body.append(Store(array, integer(k), self.expressions[next(roots).id]))
        return Function(
            f"{symbol_of(kernel.algebra, kernel.name)}_array",
            kernel.note or kernel.name,
            (*outputs, *inputs),
            (),
            tuple(self.body),
        )

    def _unused(self, name: str) -> str:
        """The name, or one like it where an argument, a coefficient or a result has it."""
        while name in self.taken:
            name += "_"
        self.taken.add(name)
        return name

    def _load(self, node: Node) -> None:
        i, k = node.data
        self._assign(node, coefficient_name(self.kernel.inputs[i], k), Load(self.inputs[i], integer(k)))

    def _visit(self, node: Node) -> None:
        match node.op:
            case "const":
                self.expressions[node.id], self.terms[node.id] = _constant(node.data), 1
            case "call":
                self.expressions[node.id], self.terms[node.id] = self._call_element(node), 1
            case "sum":
                self._arithmetic(node, self._sum(node))
            case "mul":
                a, b = (self.expressions[x.id] for x in node.args)
                self._arithmetic(node, Binary("*", a, b, REAL))
            case "rounded":
                self._name(node, self.expressions[node.args[0].id])
            case _:
                self._name(node, _operation(node.op, [self.expressions[a.id] for a in node.args]))

    def _arithmetic(self, node: Node, value: Expression) -> None:
        terms = sum(self.terms[a.id] for a in node.args)
        if self.uses[node.id] > 1 or terms > MOST_TERMS:
            self._name(node, value)
        else:
            self.expressions[node.id], self.terms[node.id] = value, terms

    def _name(self, node: Node, value: Expression) -> None:
        self._assign(node, f"t{self.count}", value)
        self.count += 1

    def _assign(self, node: Node, name: str, value: Expression) -> None:
        variable = Variable(self._unused(name), value.type)
        self.body.append(Assign(variable, value))
        self.expressions[node.id], self.terms[node.id] = variable, 1

    def _sum(self, node: Node) -> Expression:
        """As `targets.printer` prints it: the first term that is added, then the others in their order."""
        terms = list(zip(node.args, node.data, strict=True))
        terms.insert(0, terms.pop(next((i for i, (_, w) in enumerate(terms) if w > 0), 0)))
        result: Expression | None = None
        for arg, weight in terms:
            size = abs(weight)
            if arg.op == "const":
                part: Expression = _constant(arg.data * size)
            else:
                own = self.expressions[arg.id]
                part = own if size == 1 else Binary("*", _constant(size), own, REAL)
            if result is None:
                result = Unary("-", part, REAL) if weight < 0 else part
            else:
                result = Binary("-" if weight < 0 else "+", result, part, REAL)
        assert result is not None
        return result

    def _call_element(self, node: Node) -> Expression:
        kernel, output, index = node.data
        key = (kernel, tuple(a.id for a in node.args))
        if key not in self.calls:
            self.calls[key] = self._call(kernel, node.args)
        return Load(self.calls[key][output], integer(index))

    def _call(self, kernel: Kernel, arguments: Sequence[Node]) -> list[Array]:
        callee = kernel_function(self.variant.callees[kernel], self.known)
        number, values = len(self.calls), iter(arguments)
        arrays = []
        for parameter in callee.parameters:
            assert isinstance(parameter.type, ArrayType)
            array = Array(self._unused(f"c{number}_{parameter.name}"), parameter.type, is_local=True)
            self.body.append(Allocate(array, is_zero=False))
            arrays.append(array)
            if parameter.access == "in":
                for k in range(parameter.type.size):
                    self.body.append(Store(array, integer(k), self.expressions[next(values).id]))
        self.body.append(Call(callee, tuple(View(a, integer(0), a.type) for a in arrays), ()))
        return arrays


def _constant(value: Fraction) -> Constant:
    return real(value.numerator / value.denominator)


def _operation(name: str, arguments: Sequence[Expression]) -> Expression:
    """A function, a comparison or a selection."""
    if name == "reciprocal":
        return Binary("/", real(1.0), arguments[0], REAL)
    if name == "nan":
        return real(math.nan)
    if name in _PREDICATES:
        return Binary(_PREDICATES[name], arguments[0], arguments[1], BOOL)
    if name == "not":
        return Unary("not", arguments[0], BOOL)
    if name == "select":
        condition, yes, no = arguments
        return Select(condition, yes, no, yes.type)
    return Intrinsic(name, tuple(arguments), REAL)
