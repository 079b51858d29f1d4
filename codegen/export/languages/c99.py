"""C99: one header, or a header and a source file, that include math.h and stdint.h only."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ...ir.loops.types import BOOL, INT
from ...targets.templates import render
from ..unit import Unit
from .c_family import ExportPrinter, file_values


class C99Printer(ExportPrinter):
    """Functions of C99."""

    types = {INT: "int64_t", BOOL: "int"}

    def call(self, name: str, arguments: Sequence[str]) -> str:
        joined = ", ".join(arguments)
        match name:
            case "epsilon":
                return "2.220446049250313e-16" if self.precision == "f64" else "1.1920928955078125e-07f"
            case "largest":
                return "1.7976931348623157e+308" if self.precision == "f64" else "3.4028234663852886e+38f"
            case "sqrt" | "abs":
                function = {"sqrt": "sqrt", "abs": "fabs"}[name]
                return f"{function}{'' if self.precision == 'f64' else 'f'}({joined})"
            case "real":
                return f"({self.real})({joined})"
            case "int":
                return f"(int64_t)({joined})"
            case "any":
                return f"({joined})"
            case "<<":
                return f"(int64_t)((uint64_t)({arguments[0]}) << ({arguments[1]}))"
            case "//" | "%" | "min" | "max" | "imin" | "imax" | "iabs":
                return f"{self.symbol({'//': 'quotient', '%': 'remainder'}.get(name, name))}({joined})"
            case _:
                return f"{self.symbol(self.mathematics + name)}({joined})"


def c99_files(unit: Unit) -> Mapping[str, str]:
    """The header.

    Returns
    -------
    mapping of str to str
        File name to text.
    """
    return {f"{unit.name}.h": render("c99.h.j2", **file_values(unit, C99Printer))}
