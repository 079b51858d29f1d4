"""Algorithms in C on W items at once: what differs between items is a vector, what they share a number.

Real numbers are vectors V, integers I, truth values masks M. Each lane has the bits of the item computed by itself.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

from ....errors import AlgorithmError
from ....ir.loops.nodes import (
    Array,
    Binary,
    Call,
    Constant,
    Expression,
    Function,
    Intrinsic,
    KernelSignature,
    Load,
    Select,
    Statement,
    Store,
    Unary,
    Variable,
    View,
)  # fmt: skip
from ....ir.loops.types import BOOL, INT, REAL, Scalar
from ...loops import ATOM
from ..loops import CLoopPrinter
from ..names import c_name
from .masks import masked_function
from .paths import is_wide_call, varies
from .varying import Lanes

#: Functions of vectors; what items share is computed by the same text, and its first lane taken.
_OF_VECTORS = frozenset(("sqrt", "abs", "sin", "cos", "exp", "log", "atan2"))
#: Functions of lanes.h for what differs between items.
_OF_LANES = {
    "min": "bs_least", "max": "bs_most", "imin": "bs_least_of", "imax": "bs_most_of", "iabs": "bs_magnitudes",
    "real": "bs_reals", "int": "bs_cut", "//": "bs_quotients", "%": "bs_remainders", "<<": "bs_shifted",
    ">>": "bs_shifted_back",
}  # fmt: skip
_TYPES = {REAL: "V", INT: "I", BOOL: "M"}
#: One value for all items.
_SPREAD = {REAL: "SPLAT", INT: "FN(bs_spread)", BOOL: "FN(bs_mask)"}
_COMPARISONS = {"<": "LT", "<=": "LE", ">": "GT", ">=": "GE", "==": "EQ", "!=": "NE"}


class LanePrinter(CLoopPrinter):
    """One function for W items, or for what they share."""

    def __init__(self, function: Function, lanes: Lanes, is_shared: bool = False) -> None:
        super().__init__(function)
        self.lanes, self.is_shared, self._count = lanes, is_shared, 0
        self.names: set[str] = set() if is_shared else lanes.names[function]
        self.results = [False] * len(function.results) if is_shared else lanes.results[function]
        self._names_shared = is_shared

    def function_name(self, function: Function) -> str:
        name = super().function_name(function)
        return f"{name}_shared" if self._names_shared and function.body else name

    def type_of(self, name: str, scalar: Scalar) -> str:
        return _TYPES[scalar] if name in self.names else super().type_of(name, scalar)

    def stored_type(self, array: Array) -> str:
        return self.type_of(array.name, array.type.scalar) if array.name in self.names else super().stored_type(array)

    def result_type(self, k: int) -> str:
        return _TYPES[self.function.results[k]] if self.results[k] else super().result_type(k)

    def value_for(self, name: str, value: Expression) -> str:
        return self._vector(value) if name in self.names else self.text(value)

    def returned(self, k: int, value: Expression) -> str:
        return self._vector(value) if self.results[k] else self.text(value)

    def load(self, array: Array, index: Expression) -> str:
        if varies(self.names, index):
            return f"FN({_access('take', array, self.names)})({c_name(array.name)}, {self.text(index)})"
        if array.name not in self.names:
            return super().load(array, index)
        found = f"{c_name(array.name)}[{self.text(index)}]"
        return found if varies(self.names, Load(array, index)) else f"BS_LANE({found}, 0)"

    def _statement(self, statement: Statement, declared: set[str], body: Sequence[Statement]) -> list[str]:
        match statement:
            case Store(array, index, value) if array.name in self.names:
                name = c_name(array.name)
                if varies(self.names, index):
                    function = _access("put", array, self.names)
                    return [f"FN({function})({name}, {self.text(index)}, {self._vector(value)});"]
                return [f"{name}[{self.text(index)}] = {self._vector(value)};"]
            case _:
                return super()._statement(statement, declared, body)

    # -- expressions ---------------------------------------------------------------------------------------------------

    def _vector(self, value: Expression) -> str:
        if varies(self.names, value):
            return self.text(value)
        if isinstance(value, Constant) and value.type == BOOL:
            return "BS_EACH" if value.value else "BS_NONE"
        return f"{_SPREAD[value.type]}({self.text(value)})"

    def _print(self, expression: Expression) -> tuple[str, int]:
        match expression:
            case Intrinsic("any", (mask,), _):
                return f"ANY({self._vector(mask)})", ATOM
            case Intrinsic(name, arguments, _) if name in _OF_VECTORS:
                of_vectors = self.call(name, [self._vector(a) for a in arguments])
                return of_vectors if varies(self.names, expression) else f"BS_LANE({of_vectors}, 0)", ATOM
            case _ if not varies(self.names, expression):
                return super()._print(expression)
            case Select(condition, yes, no, type):
                if not varies(self.names, condition):
                    return f"({self.select(self.inside(condition, 1), self._vector(yes), self._vector(no))})", ATOM
                function = "SELECT" if type == REAL else "FN(bs_choose)"
                return f"{function}({self.text(condition)}, {self._vector(yes)}, {self._vector(no)})", ATOM
            case Intrinsic(name, arguments, _) if name in _OF_LANES:
                return self._of_lanes(name, arguments), ATOM
            case Unary("not", operand, _):
                return f"NOT({self.text(operand)})", ATOM
            case Binary("//" | "%" | "<<" | ">>" as operator, left, right, _):
                return self._of_lanes(operator, (left, right)), ATOM
            case Binary("and" | "or" as operator, left, right, _):
                return f"{operator.upper()}({self._vector(left)}, {self._vector(right)})", ATOM
            case Binary(operator, left, right, _) if operator in _COMPARISONS:
                return f"{_COMPARISONS[operator]}({self._vector(left)}, {self._vector(right)})", ATOM
            case Binary(operator, left, right, type) if type != REAL:
                return f"({self._operand(left)} {operator} {self._operand(right)})", ATOM
            case _:
                return super()._print(expression)

    def _of_lanes(self, name: str, arguments: Sequence[Expression]) -> str:
        return f"FN({_OF_LANES[name]})({', '.join(self._vector(a) for a in arguments)})"

    def _operand(self, value: Expression) -> str:
        return self.inside(value, ATOM) if isinstance(value, Constant) and value.type == INT else self._vector(value)

    # -- calls ---------------------------------------------------------------------------------------------------------

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
        self._after.append(f"{c_name(result.name)} = {_SPREAD[result.type]}({own.name});")
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
        before.append(f"{_TYPES[each.type.scalar]} {name}[{size}];")
        if isinstance(callee, KernelSignature) and k < len(callee.outputs):
            self._after.append(f"FN(store_lane)({self.view(each)}, {name}, {size});")
        elif each.type.scalar == REAL:
            before.append(f"FN(load_broadcast)({name}, {self.view(each)}, {size});")
        else:
            before.append(f"for (int j = 0; j < {size}; j++) {name}[j] = FN(bs_spread)(({self.view(each)})[j]);")
        return name


def lanes_text(lanes: Lanes) -> str:
    """C text of all functions, callees first."""
    printed = []
    for function in lanes.functions:
        if not function.body:  # a function of C
            continue
        if function in lanes.shared:
            printed.append(LanePrinter(function, lanes, is_shared=True))
        if function in lanes.wide:
            printed.append(LanePrinter(masked_function(function, lanes), lanes))
    return "\n".join("\n".join([*printer.lines(), ""]) for printer in printed)


def _access(name: str, array: Array, names: Collection[str]) -> str:
    """Function of lanes.h for elements whose places differ between items."""
    if array.name in names:
        return f"bs_{name}" if array.type.scalar == REAL else f"bs_{name}_integers"
    if name == "take":
        return "bs_take_common" + ("" if array.type.scalar == REAL else f"{array.type.bits}")
    raise TypeError(array)  # what is written there differs
