"""Names for the text of algorithms: types for annotations, arrays and functions; see docs/algebra/algorithms.md."""

from __future__ import annotations

from .ir.loops.language import (
    INFINITY,
    NAN,
    Bool,
    Bytes,
    InOut,
    Int,
    IntRows,
    Ints,
    Ints32,
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
    int_empty,
    int_zeros,
    largest,
    log,
    sin,
    sqrt,
    unrolled,
    zeros,
)  # fmt: skip
from .ir.loops.records import Record, RecordArray, record

__all__ = [
    "INFINITY", "NAN", "Bool", "Bytes", "InOut", "Int", "IntRows", "IntVector", "Ints", "Ints32", "Matrix", "Out",
    "Real", "Reals", "Record", "RecordArray", "Rows", "Static", "Vector", "atan2", "cos", "empty", "epsilon", "exp",
    "int_empty", "int_zeros", "largest", "log", "record", "sin", "sqrt",
    "unrolled", "zeros",
]  # fmt: skip
