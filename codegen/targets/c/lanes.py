"""Algorithms in C on W items at once: what differs between items is a vector V, what they share a number S.

For algorithms whose items take one path: a branch, a count or an index that differs between items is refused.
Each lane has the bits of the item computed by itself.
"""

from __future__ import annotations

from collections.abc import Collection

from ...errors import AlgorithmError
from ...ir.loops.nodes import (
    Assign,
    Call,
    Expression,
    Function,
    Intrinsic,
    KernelSignature,
    Load,
    Return,
    Select,
    Statement,
    Store,
    Variable,
    View,
    expressions,
    parts,
)  # fmt: skip
from ...ir.loops.types import REAL, ArrayType, Parameter, Scalar
from ..loops import counted, in_calling_order
from .loops import CLoopPrinter, c_function_name

#: Functions of vectors: their results are vectors, whatever they are given.
_OF_VECTORS = frozenset(("sqrt", "abs", "sin", "cos", "exp", "log", "atan2"))


class Lanes:
    """What differs between the items of an algorithm, in it and in those that it calls.

    Parameters
    ----------
    root : Function
    shared : collection of str
        Its parameters that all items share.

    Attributes
    ----------
    names : mapping of Function to set of str
        Numbers and arrays that differ.
    results : mapping of Function to list of bool
        Whether what it returns differs.

    Raises
    ------
    AlgorithmError
        If items may take different paths.
    """

    def __init__(self, root: Function, shared: Collection[str]) -> None:
        functions, _ = in_calling_order([root])
        self.root = root
        self.names: dict[Function, set[str]] = {f: set() for f in functions}
        self.results = {f: [False] * len(f.results) for f in functions}
        self.names[root] = {p.name for p in root.parameters if p.name not in shared}
        while True:
            before = [len(n) for n in self.names.values()], [list(r) for r in self.results.values()]
            for function in functions:
                for statement in function.walk():
                    self._follow(function, statement)
            if before == ([len(n) for n in self.names.values()], [list(r) for r in self.results.values()]):
                break
        for function in functions:
            self._check(function)

    def varies(self, function: Function, expression: Expression) -> bool:
        """Whether a number differs between items."""
        names = self.names[function]
        return any(
            (isinstance(p, Variable) and p.name in names)
            or (isinstance(p, Load) and p.array.name in names)
            or (isinstance(p, Intrinsic) and p.name in _OF_VECTORS)
            for p in parts(expression)
        )

    def _follow(self, function: Function, statement: Statement) -> None:
        names = self.names[function]
        match statement:
            case Assign(target, value) if self.varies(function, value):
                names.add(target.name)
            case Store(array, _, value) if self.varies(function, value):
                names.add(array.name)
            case Return(values):
                for k, value in enumerate(values):
                    self.results[function][k] |= self.varies(function, value)
            case Call(KernelSignature(_, outputs), arguments, _):
                names.update(a.array.name for a in arguments[: len(outputs)] if isinstance(a, View))
            case Call(Function() as callee, arguments, results):
                for p, a in zip(callee.parameters, arguments, strict=True):
                    if a.array.name in names if isinstance(a, View) else self.varies(function, a):
                        self.names[callee].add(p.name)
                    elif isinstance(a, View) and p.access != "in" and p.name in self.names[callee]:
                        names.add(a.array.name)
                names.update(r.name for r, v in zip(results, self.results[callee], strict=True) if v)

    def _check(self, function: Function) -> None:
        found = [p for s in function.walk() for e in expressions(s) for p in parts(e)]
        numbers = [p.name for p in function.parameters if _scalar(p) != REAL and p.name in self.names[function]]
        if (
            numbers
            or any(p.type != REAL and self.varies(function, p) for p in found)
            or any(isinstance(p, Intrinsic) and p.name in ("min", "max") and self.varies(function, p) for p in found)
            or (function is self.root and any(t != REAL for t in function.results))
        ):
            raise AlgorithmError(
                f"{function.name} takes a path that differs between items", where=self.root.name,
                remedy="Compute its items one after the other, or say which of its parameters they share.",
            )  # fmt: skip

    def printer(self, function: Function) -> LanePrinter:
        """What prints one of the functions."""
        return LanePrinter(function, self)

    def item(self) -> tuple[list[str], list[str]]:
        """Arrays of a loop over items, and statements that compute those from item i on; see algorithm.c.j2."""
        arrays, load, arguments, store = [], [], [], []
        for k, p in enumerate(self.root.parameters):
            type = "ptrdiff_t" if _scalar(p) != REAL else "S"
            given, is_array = f"({type} *)arrays[{k}]", isinstance(p.type, ArrayType)
            size = str(p.type.size) if isinstance(p.type, ArrayType) else "1"
            size += f" * counts[{k}]" if isinstance(p.type, ArrayType) and p.type.is_open else ""
            if p.name in self.names[self.root]:
                own, row = f"{p.name}_lanes_", f"{given} + i * strides[{k}], strides[{k}], {size}, lanes"
                arrays.append(f"V {own}[{size}];")
                load += [f"FN(bs_gather)({own}, {row});"] if p.access != "out" else []
                store += [f"FN(bs_scatter)({own}, {row});"] if p.access != "in" else []
                arguments.append(own if is_array else f"{own}[0]")
            else:
                arguments.append(given if is_array else f"*({given})")
            if p.name in counted(self.root):
                arguments.append(f"counts[{k}]")
        first, count = len(self.root.parameters), len(self.root.results)
        for k in range(count):
            row = f"(S *)arrays[{first + k}] + i * strides[{first + k}], strides[{first + k}], 1, lanes"
            store.append(f"FN(bs_scatter)(&result{k}_, {row});")
        declared = [f"V result{k}_;" for k in range(count)]
        arguments += [f"&result{k}_" for k in range(count) if count > 1]
        call = f"{'result0_ = ' if count == 1 else ''}FN({c_function_name(self.root.name)})({', '.join(arguments)});"
        return arrays, [*load, *declared, call, *store]


class LanePrinter(CLoopPrinter):
    """One function for W items."""

    def __init__(self, function: Function, lanes: Lanes) -> None:
        super().__init__(function)
        self.lanes, self.names, self._count = lanes, lanes.names[function], 0

    def type_of(self, name: str, scalar: Scalar) -> str:
        return "V" if name in self.names else super().type_of(name, scalar)

    def result_type(self, k: int) -> str:
        is_vector = self.lanes.results[self.function][k] or self.function is self.lanes.root
        return "V" if is_vector else super().result_type(k)

    def value_for(self, name: str, value: Expression) -> str:
        return self._vector(value) if name in self.names else self.text(value)

    def returned(self, k: int, value: Expression) -> str:
        return self._vector(value) if self.result_type(k) == "V" else self.text(value)

    def _vector(self, value: Expression) -> str:
        text = self.text(value)
        return text if self.lanes.varies(self.function, value) else f"SPLAT({text})"

    def _print(self, expression: Expression) -> tuple[str, int]:
        match expression:
            case Intrinsic(name, arguments, _) if name in _OF_VECTORS:
                return self.call(name, [self._vector(a) for a in arguments]), 9
            case Select(condition, yes, no, _) if self.lanes.varies(self.function, expression):
                return self.select(self.inside(condition, 1), self._vector(yes), self._vector(no)), 0
            case _:
                return super()._print(expression)

    def argument(self, call: Call, k: int, before: list[str]) -> str:
        each, callee = call.arguments[k], call.callee
        if isinstance(callee, Function) and callee.parameters[k].name not in self.lanes.names[callee]:
            return super().argument(call, k, before)
        if not isinstance(each, View):
            return self._vector(each)
        if each.array.name in self.names:
            return super().argument(call, k, before)
        if each.type.is_open:
            raise AlgorithmError(
                f"{each.array.name} is shared by items, and differs elsewhere", where=self.function.name
            )
        name, size, self._count = f"shared{self._count}_", each.type.size, self._count + 1
        before += [f"V {name}[{size}];", f"FN(load_broadcast)({name}, {self.view(each)}, {size});"]
        return name


def _scalar(parameter: Parameter) -> Scalar:
    type = parameter.type
    scalar = type.scalar if isinstance(type, ArrayType) else type
    assert isinstance(scalar, Scalar)
    return scalar
