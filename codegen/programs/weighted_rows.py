"""Weighted rows inside programs whose other text is a template: structure and functions in C."""

from __future__ import annotations

from ..algorithms.weighted_rows import COARSE, NO_MOTION, ROUNDINGS, weighted_rows
from ..ir.loops.records import Record
from ..targets.c.loops import c_functions
from ..targets.templates import render


def structure_text(numbers: Record, integers: Record, more: str = "") -> str:
    """C text of ``FN(system)``: rows of two records, which follow each other, and other members."""
    return render("row_structure.j2", numbers=numbers, integers=integers, more=more)


def weighted_rows_text(rows: int, size: int) -> str:
    """C text of ``FN(system)`` and its functions, for so many rows of a size."""
    found = weighted_rows(rows, size)
    used = (found.scale_rows, found.add_direction, found.least_change)
    functions = [each.specialised([p.type for p in each.text.parameters]) for each in used]
    more = "  ptrdiff_t rows;\n  const int32_t *stop;               /* not 0: give up; 0: never */\n"
    return render(
        "weighted_rows.j2", numbers=found.numbers, functions=c_functions(functions),
        structure=structure_text(found.numbers, found.integers, more),
        constants={"NO_MOTION": NO_MOTION, "COARSE": COARSE, "ROUNDINGS": ROUNDINGS},
    )  # fmt: skip
