"""Types and expressions of Rust: integers wrap, and are cast where they are indices."""

from __future__ import annotations

from collections.abc import Sequence

from ....ir.loops.nodes import (
    Array,
    Binary,
    Constant,
    Count,
    Expression,
    Intrinsic,
    Select,
    Unary,
    Variable,
    parts,
)
from ....ir.loops.types import BOOL, INT, REAL, ArrayType, Scalar
from ....targets.loops import ATOM
from ...names import language_words
from ..literals import LiteralPrinter

#: Arithmetic of integers that may leave 64 bits.
_WRAPPING = {"+": "wrapping_add", "-": "wrapping_sub", "*": "wrapping_mul"}
_SHIFTS = {"<<": "wrapping_shl", ">>": "wrapping_shr"}
STORED = {32: "i32", 8: "u8"}
_HELPERS = {"//": "quotient", "%": "remainder", "min": "least", "max": "most"}


class RustExpressions(LiteralPrinter):
    """Expressions of one function. Elements are checked against the length of their array."""

    logical = {"and": "&&", "or": "||", "not": "!"}
    functions = frozenset(_HELPERS)
    indent = "    "
    _is_index = False

    # -- types ---------------------------------------------------------------------------------------------------------

    @property
    def not_a_number(self) -> str:  # type: ignore[override]
        return f"{self.precision}::NAN"

    @property
    def infinity(self) -> str:  # type: ignore[override]
        return f"{self.precision}::INFINITY"

    def type_of(self, scalar: Scalar) -> str:
        return {REAL: self.precision, INT: "i64", BOOL: "bool"}[scalar]

    def array_type(self, type: ArrayType) -> str:
        stored = STORED.get(type.bits) or self.type_of(type.scalar)
        return f"[{stored}]" if type.is_open else f"[{stored}; {type.size}]"

    # -- expressions ---------------------------------------------------------------------------------------------------

    def text(self, expression: Expression) -> str:
        return _bare(super().text(expression))

    def constant(self, value: Constant) -> str:
        if value.type == REAL:
            return self.real_constant(value)
        if value.type == BOOL:
            return "true" if value.value else "false"
        return str(int(value.value)) if value.value != -(1 << 63) else "i64::MIN"

    def variable(self, name: str) -> str:
        return f"{name}_" if name.endswith("_") or name in language_words("rust") else name

    def count(self, array: Array) -> str:
        rows = f"{self.variable(array.name)}.len()"
        return f"({rows} as i64)" if array.type.size == 1 else f"(({rows} / {array.type.size}) as i64)"

    def load(self, array: Array, index: Expression) -> str:
        element = self.element(array, index)
        return element if array.type.bits == 64 else f"({element} as i64)"

    def inner_element(self, array: Array, index: Expression) -> str:
        name = self.variable(array.name) if self._is_own(array) else array.name.upper()
        return f"{name}[{self._index(index)}]"

    def _is_own(self, array: Array) -> bool:
        """Not a table of the file."""
        return array.is_local or any(p.name == array.name for p in self.function.parameters)

    def _index(self, index: Expression) -> str:
        """A place in an array: sums and products there never wrap, but for those of places that are no good anyway."""
        if isinstance(index, Constant):
            return self.constant(index)
        if not all(isinstance(p, (Constant, Variable, Count, Binary)) for p in parts(index)) or any(
            p.operator not in _WRAPPING for p in parts(index) if isinstance(p, Binary)
        ):
            return f"{self.inside(index, ATOM)} as usize"
        before, self._is_index = self._is_index, True
        text = f"{self.inside(index, ATOM)} as usize"
        self._is_index = before
        return text

    def select(self, condition: str, yes: str, no: str) -> str:
        return f"if {_bare(condition)} {{ {_bare(yes)} }} else {{ {_bare(no)} }}"

    def _receiver(self, value: Expression) -> str:
        """An integer whose methods are called."""
        if isinstance(value, Constant):
            return f"{value.value}_i64" if int(value.value) >= 0 else f"({self.constant(value)}_i64)"
        if isinstance(value, Select):
            return f"({self.select(self.text(value.condition), self._receiver(value.yes), self._receiver(value.no))})"
        return self.inside(value, ATOM)

    def _print(self, expression: Expression) -> tuple[str, int]:
        match expression:
            case Binary(operator, left, right, type) if type == INT and operator in _WRAPPING and not self._is_index:
                return f"{self._receiver(left)}.{_WRAPPING[operator]}({self.text(right)})", ATOM
            case Binary(operator, left, right, type) if type == INT and operator in _SHIFTS:
                return f"{self._receiver(left)}.{_SHIFTS[operator]}({self._shift(right)})", ATOM
            case Unary("-", operand, type) if type == INT:
                return f"{self._receiver(operand)}.wrapping_neg()", ATOM
            case Intrinsic("iabs", (operand,), _):
                return f"{self._receiver(operand)}.wrapping_abs()", ATOM
            case Intrinsic("imin" | "imax" as name, (first, second), _):
                return f"{self._receiver(first)}.{name[1:]}({self.text(second)})", ATOM
            case Intrinsic("real" | "int" as name, (operand,), type):
                return f"({self._cast_operand(operand)} as {self.type_of(type)})", ATOM
            case _:
                return super()._print(expression)

    def _cast_operand(self, value: Expression) -> str:
        text = self.inside(value, ATOM)
        return f"{text}_{self.type_of(value.type)}" if isinstance(value, Constant) and text.isdigit() else text

    def _shift(self, count: Expression) -> str:
        return str(count.value) if isinstance(count, Constant) else f"{self.inside(count, ATOM)} as u32"

    def call(self, name: str, arguments: Sequence[str]) -> str:
        joined = ", ".join(arguments)
        match name:
            case "epsilon":
                return f"{self.precision}::EPSILON"
            case "largest":
                return f"{self.precision}::MAX"
            case "any":
                return f"({joined})"
            case "bits":
                return f"(f64::to_bits({joined}) as i64)"
            case "abs" if self.is_far:
                return f"f64::from_bits(f64::to_bits({joined}) & (u64::MAX >> 1))"
            case _:
                return f"{self._mathematics}{_HELPERS.get(name, name)}({joined})"

    @property
    def _mathematics(self) -> str:
        return "self::" if self.is_mathematics else "math::"


def _bare(text: str) -> str:
    """A text without brackets around all of it."""
    if not text.startswith("("):
        return text
    depth = 0
    for k, letter in enumerate(text):
        depth += {"(": 1, ")": -1}.get(letter, 0)
        if depth == 0:
            return _bare(text[1:-1]) if k == len(text) - 1 else text
    return text
