"""C99: one header, or a header and a source file, that include math.h and stdint.h only."""

from __future__ import annotations

from collections.abc import Mapping

from ...ir.loops.nodes import Array
from ...ir.loops.types import BOOL, INT
from ...targets.templates import render
from ..unit import Unit
from .c_family import ExportPrinter, file_values
from .notation import Notation


class C99Printer(ExportPrinter):
    """Functions of C99."""

    language = "cpp"  # headers may be included there, too
    types = {INT: "int64_t", BOOL: "int"}

    def allocation(self, array: Array, is_zero: bool) -> list[str]:
        return super().allocation(array, is_zero or self.is_cleared(array))


class _DeclaredPrinter(C99Printer):
    """Functions of a source file: those for users are declared in a header."""

    kernel_storage = "extern"

    @property
    def storage(self) -> str:  # type: ignore[override]
        own = [e.function for e in self.unit.entries if not e.is_kernel]
        return "extern" if self.function in own else "static inline"


def c99_files(unit: Unit, split: bool = False) -> Mapping[str, str]:
    """The header.

    Parameters
    ----------
    unit : Unit
    split : bool
        The header declares, and a source file defines.

    Returns
    -------
    mapping of str to str
        File name to text.
    """
    bits = 64 if unit.precision == "f64" else 32
    real = "double" if bits == 64 else "float"
    notation = Notation(
        bits, real, f"int{bits}_t", f"uint{bits}_t", "int", "int64_t", "uint64_t", "static inline ", "static inline ",
        prefix=f"{unit.name}_{C99Printer.mathematics}", name=f"{unit.name}_", suffix="" if bits == 64 else "f",
    )  # fmt: skip
    values = {**file_values(unit, _DeclaredPrinter if split else C99Printer), "l": notation, "is_split": split}
    files = {f"{unit.name}.h": render("c99.h.j2", **values)}
    return {**files, f"{unit.name}.c": render("c99.c.j2", **values)} if split else files
