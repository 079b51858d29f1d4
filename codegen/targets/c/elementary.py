"""The text of the elementary functions as a C header, for scalars, vectors and CUDA: instance.h says what V is.

All numbers are V and all conditions M. What reduces a very large angle is a function of one double, whatever V is.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ...elementary.constants import DOUBLE, SINGLE, TWO_OVER_PI
from ...ir.loops.nodes import Binary, Constant, Expression, Function, Intrinsic, Select, parts
from ...ir.loops.types import BOOL, INT, REAL, Scalar
from ..elementary import NAMES, elementary_functions, far_reduction
from ..loops import in_calling_order
from ..templates import render
from .loops import CLoopPrinter

#: Functions of elementary.machine in C.
_MACHINE = {
    "power_of_two": "FN(power_of_two)", "is_odd": "FN(is_odd)", "change_sign": "FN(change_sign)",
    "copy_sign": "FN(copy_sign)", "exponent": "FN(exponent)", "significand": "FN(significand)",
}  # fmt: skip


def elementary_header() -> str:
    """Text of elementary.h."""
    return render(
        "elementary.h.j2",
        far=_text([far_reduction()], _DoublePrinter),
        double=_text(elementary_functions(NAMES, DOUBLE), _VectorPrinter),
        single=_text(elementary_functions(NAMES, SINGLE), _VectorPrinter),
        places=[f"0x{word:08x}" for word in TWO_OVER_PI.tolist()],
        shifters=[float(c.shifter) for c in (DOUBLE, SINGLE)],
        names=[n for n in NAMES if n not in ("atan2", "stumpff")],
    )


def _text(roots: Sequence[Function], printer: type[CLoopPrinter]) -> str:
    functions, _ = in_calling_order(roots)
    return "\n".join("\n".join([*printer(f).lines(), ""]) for f in functions if f.body)


class _Printer(CLoopPrinter):
    """The names are those of the text: this is the library that others keep away from."""

    def function_name(self, function: Function) -> str:
        return function.name


class _DoublePrinter(_Printer):
    """One number at a time, in double."""

    def constant(self, value: Constant) -> str:
        return repr(float(value.value)) if value.type == REAL else super().constant(value)

    def type_of(self, name: str, scalar: Scalar) -> str:
        return {REAL: "double", INT: "int64_t", BOOL: "int"}[scalar]

    def result_type(self, k: int) -> str:
        return "double"

    def call(self, name: str, arguments: Sequence[str]) -> str:
        function = {"abs": "fabs", "bits": "FN(bits_of_double)", "real": "(double)"}.get(name)
        return f"{function}({arguments[0]})" if function else super().call(name, arguments)


class _VectorPrinter(_Printer):
    """All lanes at once."""

    def type_of(self, name: str, scalar: Scalar) -> str:
        return {REAL: "V", BOOL: "M"}[scalar]

    def result_type(self, k: int) -> str:
        return "V"

    def value_for(self, name: str, value: Expression) -> str:
        return self._vector(value)

    def returned(self, k: int, value: Expression) -> str:
        return self._vector(value)

    def argument(self, call: Any, k: int, before: list[str]) -> str:
        return self._vector(call.arguments[k])

    def _vector(self, value: Expression) -> str:
        is_constant = all(isinstance(p, Constant) or not hasattr(p, "name") for p in parts(value))
        return f"SPLAT({self.text(value)})" if is_constant and value.type == REAL else self.text(value)

    def _print(self, expression: Expression) -> tuple[str, int]:
        match expression:
            case Select(condition, yes, no, _):
                return f"SELECT({self.text(condition)}, {self._vector(yes)}, {self._vector(no)})", 9
            case Binary(("and" | "or" | "&" | "|") as operator, left, right, type) if type == BOOL:
                name = "AND" if operator in ("and", "&") else "OR"
                return f"{name}({self.text(left)}, {self.text(right)})", 9
            case Binary("!=", left, right, _) if left.type == BOOL:
                return f"({self.inside(left, 9)} ^ {self.inside(right, 9)})", 9
            case Intrinsic(name, arguments, _) if name in _MACHINE:
                return f"{_MACHINE[name]}({', '.join(self._vector(a) for a in arguments)})", 9
            case _:
                return super()._print(expression)
