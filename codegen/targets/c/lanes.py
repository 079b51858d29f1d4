"""Algorithms in C on W items at once: what differs between items is a vector V, what they share a number S.

For algorithms whose items take one path: a branch, a count or an index that differs between items is refused.
Each lane has the bits of the item computed by itself.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

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
from .loops import CLoopPrinter, wrap_arguments
from .names import c_function_name, c_name, stored_type

#: Functions of vectors; what items share is computed by the same text, and its first lane taken.
_OF_VECTORS = frozenset(("sqrt", "abs", "sin", "cos", "exp", "log", "atan2"))
#: Tag of the instance of wide vectors, where another calls it.
LANES_TAG = "f64_v3"


def varies(names: Collection[str], expression: Expression) -> bool:
    """Whether a number differs between items, where numbers and arrays of these names do."""
    return any(
        (isinstance(p, Variable) and p.name in names) or (isinstance(p, Load) and p.array.name in names)
        for p in parts(expression)
    )


def argument_varies(names: Collection[str], argument: Expression | View) -> bool:
    """The same of an argument."""
    return argument.array.name in names if isinstance(argument, View) else varies(names, argument)


def is_wide_call(names: Collection[str], call: Call) -> bool:
    """Whether a call has anything that differs between items: others compute what all of them share."""
    return any(argument_varies(names, a) for a in call.arguments)


def shared_results(names: Collection[str], call: Call) -> range:
    """Results of a kernel that items share: all; those beside tangents, where only directions differ; or none."""
    kernel = call.callee
    assert isinstance(kernel, KernelSignature)
    count = len(kernel.outputs)
    differ = [argument_varies(names, a) for a in call.arguments[count:]]
    origin = getattr(kernel.kernel, "origin", None)
    if any(differ[: len(differ) - len(origin[1])] if origin else differ):
        return range(0)
    return range(count // 2 if any(differ) else count)


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
        self.functions = functions
        self.results = {f: [False] * len(f.results) for f in functions}
        self.names[root] = {p.name for p in root.parameters if p.name not in shared}
        while True:
            before = [len(n) for n in self.names.values()], [list(r) for r in self.results.values()]
            for function in functions:
                for statement in function.walk():
                    self._follow(function, statement)
            if before == ([len(n) for n in self.names.values()], [list(r) for r in self.results.values()]):
                break
        #: What is printed: functions of W items, and of what all of them share.
        self.wide: set[Function] = set()
        self.shared: set[Function] = set()
        self._collect(root, True)
        for function in self.wide:
            self._check(function)

    def _collect(self, function: Function, is_wide: bool) -> None:
        found = self.wide if is_wide else self.shared
        if function in found:
            return
        found.add(function)
        for statement in function.walk():
            if isinstance(statement, Call) and isinstance(statement.callee, Function):
                self._collect(statement.callee, is_wide and is_wide_call(self.names[function], statement))

    def text(self) -> str:
        """C text of all functions, callees first."""
        kinds = ((self.shared, True), (self.wide, False))
        printers = [LanePrinter(f, self, is_shared) for f in self.functions for found, is_shared in kinds
                    if f in found and not f.is_library]  # fmt: skip
        return "\n".join("\n".join([*printer.lines(), ""]) for printer in printers)

    def _follow(self, function: Function, statement: Statement) -> None:
        names = self.names[function]
        match statement:
            case Assign(target, value) if varies(names, value):
                names.add(target.name)
            case Store(array, _, value) if varies(names, value):
                names.add(array.name)
            case Return(values):
                for k, value in enumerate(values):
                    self.results[function][k] |= varies(names, value)
            case Call(KernelSignature(_, outputs), arguments, _):
                differ = arguments[len(shared_results(names, statement)) : len(outputs)]
                names.update(a.array.name for a in differ if isinstance(a, View))
            case Call(Function() as callee, arguments, results) if is_wide_call(names, statement):
                for p, a in zip(callee.parameters, arguments, strict=True):
                    if argument_varies(names, a):
                        self.names[callee].add(p.name)
                    elif isinstance(a, View) and p.access != "in" and p.name in self.names[callee]:
                        names.add(a.array.name)
                names.update(r.name for r, v in zip(results, self.results[callee], strict=True) if v)

    def _check(self, function: Function) -> None:
        names = self.names[function]
        found = [p for s in function.walk() for e in expressions(s) for p in parts(e)]
        numbers = [p.name for p in function.parameters if _scalar(p) != REAL and p.name in names]
        if (
            numbers
            or any(p.type != REAL and varies(names, p) for p in found)
            or any(isinstance(p, Intrinsic) and p.name in ("min", "max") and varies(names, p) for p in found)
            or any(t != REAL and v for t, v in zip(function.results, self.results[function], strict=True))
        ):
            raise AlgorithmError(
                f"{function.name} takes a path that differs between items", where=self.root.name,
                remedy="Compute its items one after the other, or say which of its parameters they share.",
            )  # fmt: skip

    def item(self) -> tuple[list[str], list[str]]:
        """Arrays of a loop over items, and statements that compute those from item i on; see algorithm.c.j2."""
        arrays, load, arguments, store = [], [], [], []
        if any(t != REAL for t in self.root.results):
            raise AlgorithmError(
                f"{self.root.name} returns an integer, of which several items have no vector",
                remedy="Put it into an array that all items share, or compute them one after the other.",
            )
        for k, p in enumerate(self.root.parameters):
            assert isinstance(p.type, (ArrayType, Scalar))
            given, is_array = f"({stored_type(p.type)} *)arrays[{k}]", isinstance(p.type, ArrayType)
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


def c_call_of_lanes(function: Function, lanes: Lanes, tag: str, direct: Collection[str]) -> str:
    """C text that an instance of single numbers has of a `CFunction`: a call of the root as vectors have it.

    Parameters
    ----------
    function : Function
        With the root's parameters; arrays that differ have the numbers of all lanes, those of one index side by side.
    lanes : Lanes
    tag : str
        Of the instance of vectors.
    direct : collection of str
        Arrays that begin where a vector may: others are copied.
    """
    root, vector = lanes.root, f"vector_{tag}"
    before, after, arguments = [], [], []
    for p in root.parameters:
        name, own = c_name(p.name), f"{p.name}_lanes_"
        assert isinstance(p.type, (ArrayType, Scalar))
        if p.name not in lanes.names[root]:
            arguments.append(name)
        elif p.name in direct:
            arguments.append(f"({'const ' if p.access == 'in' else ''}{vector} *){name}")
        else:
            before.append(f"{vector} {own}[{p.type.size if isinstance(p.type, ArrayType) else 1}];")
            before += [f"memcpy({own}, {name}, sizeof {own});"] if p.access != "out" else []
            after += [f"memcpy({name}, {own}, sizeof {own});"] if p.access != "in" else []
            arguments.append(own)
    call = wrap_arguments(f"const ptrdiff_t result_ = {c_function_name(root.name)}_{tag}(", arguments, ");")
    body = [*before, *call, *after, "return result_;"]
    return "\n".join([*CLoopPrinter(function).head("BS_INLINE"), "{", *(f"  {line}" for line in body), "}", ""])


class LanePrinter(CLoopPrinter):
    """One function for W items, or for what they share."""

    def __init__(self, function: Function, lanes: Lanes, is_shared: bool = False) -> None:
        super().__init__(function)
        self.lanes, self.is_shared, self._count = lanes, is_shared, 0
        self.names: set[str] = set() if is_shared else lanes.names[function]
        self._names_shared = is_shared

    def function_name(self, function: Function) -> str:
        name = super().function_name(function)
        return f"{name}_shared" if self._names_shared and not function.is_library else name

    def type_of(self, name: str, scalar: Scalar) -> str:
        return "V" if name in self.names else super().type_of(name, scalar)

    def result_type(self, k: int) -> str:
        is_number = self.function is self.lanes.root and self.function.results[k] == REAL
        is_wide = not self.is_shared and self.lanes.results[self.function][k]
        return "V" if is_number or is_wide else super().result_type(k)

    def value_for(self, name: str, value: Expression) -> str:
        return self._vector(value) if name in self.names else self.text(value)

    def returned(self, k: int, value: Expression) -> str:
        return self._vector(value) if self.result_type(k) == "V" else self.text(value)

    def _vector(self, value: Expression) -> str:
        text = self.text(value)
        return text if varies(self.names, value) else f"SPLAT({text})"

    def _print(self, expression: Expression) -> tuple[str, int]:
        match expression:
            case Intrinsic(name, arguments, _) if name in _OF_VECTORS:
                of_vectors = self.call(name, [self._vector(a) for a in arguments])
                return of_vectors if varies(self.names, expression) else f"BS_LANE({of_vectors}, 0)", 9
            case Select(condition, yes, no, _) if varies(self.names, expression):
                return self.select(self.inside(condition, 1), self._vector(yes), self._vector(no)), 0
            case _:
                return super()._print(expression)

    def _call_lines(self, call: Call, declared: set[str]) -> list[str]:
        self._after: list[str] = []
        is_function = isinstance(call.callee, Function)
        self._names_shared = is_function and not is_wide_call(self.names, call)
        own = [self._result(call, k) for k in range(len(call.results))]
        lines = super()._call_lines(replace(call, results=tuple(own)), declared)
        self._names_shared = self.is_shared
        return [*lines, *self._after]

    def _result(self, call: Call, k: int) -> Variable:
        """What a call gives, or a number of its own that all lanes of it are set to."""
        result, callee = call.results[k], call.callee
        assert isinstance(callee, Function)
        if result.name not in self.names or (self.lanes.results[callee][k] and not self._names_shared):
            return result
        own, self._count = Variable(f"shared{self._count}_", result.type), self._count + 1
        self._read.add(own.name)
        self._after.append(f"{c_name(result.name)} = SPLAT({own.name});")
        return own

    def argument(self, call: Call, k: int, before: list[str]) -> str:
        each, callee = call.arguments[k], call.callee
        is_shared = self._names_shared or (
            isinstance(callee, Function) and callee.parameters[k].name not in self.lanes.names[callee]
        )
        if is_shared:
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
        before.append(f"V {name}[{size}];")
        if isinstance(callee, KernelSignature) and k < len(callee.outputs):
            self._after.append(f"FN(store_lane)({self.view(each)}, {name}, {size});")
        else:
            before.append(f"FN(load_broadcast)({name}, {self.view(each)}, {size});")
        return name


def _scalar(parameter: Parameter) -> Scalar:
    type = parameter.type
    scalar = type.scalar if isinstance(type, ArrayType) else type
    assert isinstance(scalar, Scalar)
    return scalar
