"""Names and expressions of JavaScript: integers are numbers, or of type BigInt in functions that work on bits."""

from __future__ import annotations

from collections.abc import Sequence

from ....ir.loops.nodes import (
    Array,
    Binary,
    Constant,
    Expression,
    Function,
    Intrinsic,
    Unary,
    expressions,
    integer,
    parts,
)
from ....ir.loops.types import BOOL, INT, REAL
from ....targets.loops import ATOM
from ...names import language_words, lower_camel_case
from ...unit import Entry, Unit
from ..literals import LiteralPrinter

#: What the text of functions uses by these names.
_GLOBALS = frozenset(["Math", "Number", "BigInt", "Float64Array", "Infinity", "NaN"])
#: Operations on bits; integers beyond this have more than a number of JavaScript has.
_BITS, _EXACT = frozenset(("&", "|", "^", "<<", ">>")), 1 << 53
#: A product by a positive integer up to this is exact wherever the other factor is an index.
_SMALL = 4096
_FUNCTIONS = {
    "sqrt": "Math.sqrt", "abs": "Math.abs", "imin": "Math.min", "imax": "Math.max", "iabs": "Math.abs",
    "//": "math_quotient", "%": "math_remainder", "int": "math_integer",
}  # fmt: skip
_WIDE_FUNCTIONS = {
    **_FUNCTIONS, "imin": "math_min", "imax": "math_max", "iabs": "math_wide_abs", "//": "math_wide_quotient",
    "%": "math_wide_remainder", "int": "math_wide_integer",
}  # fmt: skip


class JsExpressions(LiteralPrinter):
    """Expressions of one function: its variables are in camel case, functions of the file have an underscore."""

    logical = {"and": "&&", "or": "||", "not": "!", "==": "===", "!=": "!=="}
    functions = frozenset(("//", "%"))
    not_a_number, infinity = "NaN", "Infinity"

    def __init__(self, function: Function, unit: Unit, entry: Entry | None = None) -> None:
        self._names: dict[str, str] = {}
        self._taken = set(language_words("js") | _GLOBALS)
        for name in [s.array for s in entry.inputs] if entry else [p.name for p in function.parameters]:
            self.variable(name)
        super().__init__(function, unit, entry)
        asked = [p for s in function.walk() for e in expressions(s) for p in parts(e)]
        self.is_wide = any(_needs_bits(p) for p in asked)

    # -- names ---------------------------------------------------------------------------------------------------------

    def variable(self, name: str) -> str:
        return self._spelled(name, name)

    def _spelled(self, key: str, name: str) -> str:
        """A name of its own for each key, as near as may be to a name of the algorithm."""
        if key not in self._names:
            stem = lower_camel_case(name.strip("_")) or "unused"
            found, number = stem, 2
            while found in self._taken:
                found, number = f"{stem}{number}", number + 1
            self._taken.add(found)
            self._names[key] = found
        return self._names[key]

    def _begin(self, name: str) -> str:
        """Where an array that the function takes begins."""
        return self._spelled(f"{name}.at", f"{name}_at")

    def _own_name(self, function: Function) -> str:
        if self.is_far or function in self.unit.mathematics:
            return f"math_{function.name}"
        return f"{self.unit.name_of(function)}_at"

    def _local(self, array: Array) -> str:
        """The file's name of a local array."""
        name = self.entry.name if self.entry else self._own_name(self.function)
        return f"{name}_{lower_camel_case(array.name.strip('_'))}_"

    def spelled(self, name: str) -> str:
        return lower_camel_case(name)

    # -- numbers -------------------------------------------------------------------------------------------------------

    def constant(self, value: Constant) -> str:
        if value.type == REAL:
            return self.real_constant(value)
        if value.type == BOOL:
            return "true" if value.value else "false"
        return f"{int(value.value)}{'n' if self.is_wide else ''}"

    def count(self, array: Array) -> str:
        name = self._spelled(f"{array.name}.count", f"{array.name}_count")
        return f"BigInt({name})" if self.is_wide else name

    def load(self, array: Array, index: Expression) -> str:
        element = self.element(array, index)
        return f"BigInt({element})" if self.is_wide and array.type.scalar == INT else element

    def inner_element(self, array: Array, index: Expression) -> str:
        name, place = self._place(array, index)
        return f"{name}[{place}]"

    def _place(self, array: Array, index: Expression) -> tuple[str, str]:
        """The array, and where in it an element is."""
        number = self._index(index)
        if array.is_local:
            return self._local(array), number
        if all(p.name != array.name for p in self.function.parameters):
            return array.name, number
        begin = self._begin(array.name)
        return self.variable(array.name), begin if number == "0" else f"{begin} + {number}"

    def _index(self, index: Expression) -> str:
        if not self.is_wide:
            text = self.inside(index, 6)
            return text if not text.startswith("-") else f"({text})"
        return str(index.value) if isinstance(index, Constant) else f"Number({self.text(index)})"

    def _number(self, value: Expression) -> str:
        """An expression as others take it: integers are numbers."""
        if not self.is_wide or value.type != INT:
            return self.text(value)
        return str(value.value) if isinstance(value, Constant) else f"math_exact({self.text(value)})"

    # -- expressions ---------------------------------------------------------------------------------------------------

    def select(self, condition: str, yes: str, no: str) -> str:
        return f"{condition} ? {yes} : {no}"

    def _print(self, expression: Expression) -> tuple[str, int]:
        match expression:
            case Binary("&" | "|" as operator, left, right, type) if type == BOOL:
                return super()._print(Binary("and" if operator == "&" else "or", left, right, type))
            case Binary(operator, left, right, type) if type == INT:
                return self._of_integers(operator, left, right, expression)
            case Unary("-", operand, type) if type == INT:  # zero has no sign
                return self._print(Binary("-", integer(0), operand, INT))
            case Intrinsic("real", (operand,), _):
                return (f"Number({self.text(operand)})", ATOM) if self.is_wide else self._print(operand)
            case _:
                return super()._print(expression)

    def _of_integers(self, operator: str, left: Expression, right: Expression, expression: Binary) -> tuple[str, int]:
        if not self.is_wide:
            if operator == "*" and not any(_is_small(e) for e in (left, right)):
                return f"math_product({self.text(left)}, {self.text(right)})", ATOM
            return super()._print(expression)
        if operator in ("<<", ">>"):
            count = self.text(right) if isinstance(right, Constant) else f"({self.inside(right, ATOM)} & 63n)"
            shifted = f"{self.inside(left, ATOM)} {operator} {count}"
            return (f"({shifted})" if operator == ">>" else f"BigInt.asIntN(64, {shifted})"), ATOM
        text, tightness = super()._print(expression)
        return (f"BigInt.asIntN(64, {text})", ATOM) if operator in "+-*" else (text, tightness)

    def call(self, name: str, arguments: Sequence[str]) -> str:
        joined = ", ".join(arguments)
        match name:
            case "epsilon":
                return "Number.EPSILON"
            case "largest":
                return "Number.MAX_VALUE"
            case "any":
                return f"({joined})"
            case _:
                functions = _WIDE_FUNCTIONS if self.is_wide else _FUNCTIONS
                return f"{functions.get(name, f'math_{name}')}({joined})"


def _needs_bits(part: Expression) -> bool:
    match part:
        case Binary(operator, _, _, type):
            return type == INT and operator in _BITS
        case Constant(value, type):
            return type == INT and abs(value) >= _EXACT
        case _:
            return isinstance(part, Intrinsic) and part.name == "bits"


def _is_small(factor: Expression) -> bool:
    return isinstance(factor, Constant) and 0 < factor.value <= _SMALL
