"""Tables of the products of basis blades, to look at and as arrays."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

import numpy as np
from numpy.typing import NDArray

from ..codegen.errors import SignatureError
from ..common.validation import as_choice
from ..dispatch.product_tables import OPERATIONS, product_table
from ..dispatch.types import TypedAlgebra
from . import formatting

#: Dimensions of the largest table: 256 x 256 products.
LARGEST = 8


class CayleyTable:
    """Products of all basis blades of an algebra, made by `Algebra.cayley`. Prints as a table, in notebooks too.

    Attributes
    ----------
    algebra : Algebra
    operation : str
        Name of the product.
    """

    def __init__(self, algebra: TypedAlgebra, operation: str = "geometric") -> None:
        as_choice(operation, "operation", OPERATIONS)
        if algebra.dimension > LARGEST:
            raise SignatureError(
                f"{algebra.name} has {algebra.dimension} dimensions; tables of products go to {LARGEST}.",
                remedy="Multiply the blades that are meant: alg.e1 * alg.e12",
            )
        self.algebra = algebra
        self.operation = operation

    def to_array(self) -> NDArray[np.float64]:
        """Structure constants c[i, j, k]: the product of blades i and j has the coefficient c on blade k."""
        blades = tuple(int(blade) for blade in self.algebra.blades)
        table = product_table(self.algebra, self.operation, blades, blades, blades)
        dense = np.zeros((len(blades),) * 3)
        result = np.repeat(np.arange(len(blades)), np.diff(table.starts))
        np.add.at(dense, (table.left, table.right, result), table.weights)
        return dense

    def _cells(self) -> list[list[str]]:
        names = [formatting.blade_text(self.algebra, blade) for blade in self.algebra.blades]
        rows = [["", *names]]
        for name, row in zip(names, self.to_array(), strict=True):
            rows.append([name, *(_cell(entry, names) for entry in row)])
        return rows

    def __str__(self) -> str:
        rows = self._cells()
        widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
        lines = ["  ".join(cell.rjust(width) for cell, width in zip(row, widths, strict=True)) for row in rows]
        return "\n".join(lines)

    __repr__ = __str__

    def _repr_html_(self) -> str:
        head, *rows = self._cells()
        cells = [f"<th>{escape(row[0])}</th>" + "".join(f"<td>{escape(c)}</td>" for c in row[1:]) for row in rows]
        first = "".join(f"<th>{escape(c)}</th>" for c in head)
        return f"<table><tr>{first}</tr>" + "".join(f"<tr>{row}</tr>" for row in cells) + "</table>"


def _cell(entry: NDArray[np.float64], names: Sequence[str]) -> str:
    """One product: -e12, 2 + e1, 0."""
    terms = []
    for k in np.flatnonzero(entry).tolist():
        size = f"{abs(entry[k]):g}"
        term = size if names[k] == "1" else names[k] if size == "1" else f"{size} {names[k]}"
        terms.append((bool(entry[k] < 0), term))
    return formatting.join_terms(terms)
