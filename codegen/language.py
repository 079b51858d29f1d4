"""Names for the text of algorithms: types for annotations, arrays and functions; see docs/algorithms.md."""

from __future__ import annotations

from .ir.loops.language import (
    INFINITY,
    NAN,
    Bool,
    InOut,
    Int,
    IntRows,
    Ints,
    IntVector,
    Matrix,
    Out,
    Real,
    Reals,
    Rows,
    Static,
    Vector,
    atan2,
    cos,
    empty,
    epsilon,
    exp,
    int_zeros,
    log,
    sin,
    sqrt,
    zeros,
)  # fmt: skip
from .ir.loops.records import Record, RecordArray, record

__all__ = [
    "INFINITY", "NAN", "Bool", "InOut", "Int", "IntRows", "IntVector", "Ints", "Matrix", "Out", "Real", "Reals",
    "Record", "RecordArray", "Rows", "Static", "Vector", "atan2", "cos", "empty", "epsilon", "exp", "int_zeros", "log",
    "record", "sin", "sqrt", "zeros",
]  # fmt: skip
