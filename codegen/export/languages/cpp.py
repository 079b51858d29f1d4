"""C++17: one header of templates over the type of numbers, in a namespace."""

from __future__ import annotations

from collections.abc import Mapping

from ...ir.loops.nodes import Allocate, Array, Assign, Call, Function, Return, Store, Variable
from ...ir.loops.types import BOOL, INT, REAL
from ...targets.templates import render
from ..elementary import ELEMENTARY, far_functions
from ..names import camel_case
from ..unit import Entry, Slot, Unit, deep_callees, intrinsics_of, own_intrinsics
from .c_family import ExportPrinter, file_values, mathematics_texts
from .notation import Notation

#: What there is for float and double only.
_OF_PRECISIONS = ELEMENTARY | {"epsilon", "largest"}
_TEMPLATE = "template <class T>"
_REFUSAL = 'static_assert(detail::Precision<T>::is_known, "float and double have these functions, no other type");'


class CppPrinter(ExportPrinter):
    """Functions of C++: templates, but for elementary functions."""

    language = "cpp"
    types = {INT: "std::int64_t", BOOL: "bool"}
    stored = {32: "std::int32_t", 8: "std::uint8_t"}
    unsigned = "std::uint64_t"
    mathematics = ""
    has_booleans = is_functional = True
    initial = "{}"
    own_words = frozenset(("sqrt", "abs", "NAN", "INFINITY"))

    @property
    def real(self) -> str:
        return super().real if self.is_mathematics else "T"

    @property
    def storage(self) -> str:  # type: ignore[override]
        return "constexpr" if _is_constant(self.function) else "inline"

    @property
    def kernel_storage(self) -> str:  # type: ignore[override]
        return f"[[nodiscard]] {self.storage}"

    # -- numbers -------------------------------------------------------------------------------------------------------

    def literal(self, number: float) -> str:
        return super().literal(number) if self.is_mathematics else f"T({number!r})"

    @property
    def not_a_number(self) -> str:
        return f"{self.real}(NAN)"

    @property
    def infinity(self) -> str:
        return f"{self.real}(INFINITY)"

    def machine_number(self, name: str) -> str:
        return f"detail::Precision<{self.real}>::{name}"

    def square_root_or_size(self, name: str) -> str:
        return f"std::{name}" if self.is_mathematics else name

    # -- names ---------------------------------------------------------------------------------------------------------

    def symbol(self, name: str) -> str:
        return name

    def variable(self, name: str) -> str:
        table = next((t for t in self.unit.tables if t.name == name), None)
        if table is None:
            return super().variable(name)
        return f"detail::{name}<T>" if table.type.scalar == REAL else f"detail::{name}"

    def table_form(self, kind: str, name: str, size: int) -> tuple[str, str]:
        return f"{f'{_TEMPLATE} ' if kind == 'T' else ''}inline constexpr {kind} {name}[{size}] = {{", "};"

    def helper(self, name: str) -> str:
        return f"detail::{name}"

    def called(self, function: Function) -> str:
        name = self.function_name(function)
        if function in self.unit.mathematics or any(function.name == f.name for f in far_functions()):
            return f"detail::{name}"
        return (
            f"{name}<T>"
            if any(e.function is function and not e.is_kernel for e in self.unit.entries)
            else f"detail::{name}<T>"
        )

    def struct_type(self, name: str) -> str:
        return f"{camel_case(name)}<T>"

    # -- functions -----------------------------------------------------------------------------------------------------

    def head(self, storage: str = "", end: str = ")") -> list[str]:
        lines = super().head(storage, end)
        return lines if self.is_mathematics else [_TEMPLATE, *lines]

    def kernel_head(self, entry: Entry, end: str = ")") -> list[str]:
        return [_TEMPLATE, *super().kernel_head(entry, end)]

    def _body(self) -> list[str]:
        lines = super()._body()
        if self.is_mathematics:
            return lines
        own = own_intrinsics(self.function)
        first = [_REFUSAL] if intrinsics_of(self.function) & _OF_PRECISIONS else []
        return [*first, *(f"using std::{name};" for name in ("sqrt", "abs") if name in own), *lines]

    def slot_parameter(self, slot: Slot) -> str:
        if slot.struct is None:
            return super().slot_parameter(slot)
        return f"const {self.slot_type(slot)} &{self.variable(slot.array)}"

    def result_parameter(self, k: int) -> str:
        return f"{self.result_type(k)} &result{k}_"

    def result_place(self, k: int) -> str:
        return f"result{k}_"

    def result_argument(self, variable: Variable) -> str:
        return self.variable(variable.name)

    def allocation(self, array: Array, is_zero: bool) -> list[str]:
        (line,) = super().allocation(array, False)
        return [f"{line[:-1]}{{}};" if is_zero or self.is_cleared(array) or _is_constant(self.function) else line]


def _is_constant(function: Function) -> bool:
    """Whether a function can be a constant expression: all numbers are known where they are declared."""
    straight = all(
        isinstance(s, (Assign, Store, Allocate, Return)) or (isinstance(s, Call) and len(s.results) < 2)
        for f in (function, *deep_callees(function)) for s in f.walk()
    )  # fmt: skip
    return straight and len(function.results) < 2 and not intrinsics_of(function)


def cpp_files(unit: Unit) -> Mapping[str, str]:
    """The header.

    Returns
    -------
    mapping of str to str
        File name to text.
    """
    precisions = []
    for precision, bits, real in (("f64", 64, "double"), ("f32", 32, "float")):
        own = unit.in_precision(precision)
        precisions.append((_notation(bits, real), mathematics_texts(own, CppPrinter)))
    values = {
        **file_values(unit, CppPrinter),
        "precisions": precisions,
        "t": _notation(64, "T"),
        "camel_case": camel_case,
    }
    used = unit.intrinsics
    values["has_detail"] = bool(used - {"sqrt", "abs"} or unit.tables or unit.functions)
    values["needs_precision"] = any(intrinsics_of(e.function) & _OF_PRECISIONS for e in unit.entries)
    return {f"{unit.name}.hpp": render("cpp.hpp.j2", **values)}


def _notation(bits: int, real: str) -> Notation:
    return Notation(
        bits, real, f"std::int{bits}_t", f"std::uint{bits}_t", "bool", "std::int64_t", "std::uint64_t",
        f"{_TEMPLATE} constexpr " if real == "T" else "inline ", "constexpr ", suffix="" if bits == 64 else "f",
        constant="const ", table="static constexpr", result="&", place="", argument="", is_functional=True,
    )  # fmt: skip
