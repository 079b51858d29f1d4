"""`clifford` as a second opinion: the same multivectors on its orthonormal layouts.

The table of signs, stated once. Ours on the left, `clifford`'s on the right:

- vectors: no = (e- - e+)/2, ni = e+ + e-, with e+ = e4, e- = e5 of Cl(4,1); the PGA's e0 .. e3 by name.
- dual: X* = X I5 is minus its dual(), which is X I5^-1 (I5^2 = -1).
- meet in CGA: X v Y = (X* ^ Y*) I5 is its vee() times (-1)^((5-r)(5-s)) for grades r, s: its complements change the
  order of two odd factors.
- PGA: I = e1230 = -e0123. J is minus its right complement, J^-1 minus its left one, hence a join minus its vee().

Its products are taken from its multiplication tables: its compiled functions take seconds to warm up.
"""

from __future__ import annotations

from functools import cache
from importlib import import_module
from typing import Any

import numpy as np

from bladesmith.codegen.algebra.algebra import Algebra
from bladesmith.codegen.algebra.blades import outer_sign


class Imported:
    """A package of the extra `ci`, imported when a test uses it: collecting the tests does not need it."""

    def __init__(self, name: str) -> None:
        self._name = name

    def __getattr__(self, attribute: str) -> Any:
        return getattr(import_module(self._name), attribute)


clifford = Imported("clifford")

#: Our vectors on clifford's orthonormal ones, for labels that differ.
NULL_VECTORS = {"no": {"+": -0.5, "-": 0.5}, "ni": {"+": 1.0, "-": 1.0}}
DUAL_SIGN = -1
COMPLEMENT_SIGN = -1
JOIN_SIGN = -1


def meet_sign(dimension: int, r: int, s: int) -> int:
    """Our meet of grades r and s over clifford's vee, where the metric is not degenerate."""
    return -1 if (dimension - r) * (dimension - s) % 2 else 1


class Oracle:
    """A clifford layout, the change of basis to it, and its products on rows of coefficients."""

    def __init__(self, algebra: Algebra, layout: Any, vectors: np.ndarray) -> None:
        self.algebra = algebra
        self.layout = layout
        self.change = _outermorphism(algebra, layout, vectors)
        self.tables: dict[str, np.ndarray] = {}

    def to(self, rows: np.ndarray) -> np.ndarray:
        """Dense rows in our blade order -> rows in clifford's."""
        return rows @ self.change.T

    def back(self, rows: np.ndarray) -> np.ndarray:
        """The way back."""
        return rows @ np.linalg.inv(self.change).T

    def table(self, name: str) -> np.ndarray:
        """gmt, omt or imt: multiplication table of the geometric, outer or inner product, [left, result, right]."""
        if name not in self.tables:
            self.tables[name] = np.asarray(getattr(self.layout, name).todense(), float)
        return self.tables[name]

    def product(self, name: str, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """A product of our rows, computed by clifford's table."""
        left = np.einsum("ni,ijk->njk", self.to(x), self.table(name))
        return self.back(np.einsum("njk,nk->nj", left, self.to(y)))

    def multivector(self, row: np.ndarray) -> Any:
        """One of our rows as a clifford multivector."""
        return clifford.MultiVector(self.layout, self.to(row))


def _outermorphism(algebra: Algebra, layout: Any, vectors: np.ndarray) -> np.ndarray:
    """Matrix on all blades from that on vectors, by outer products of its columns."""
    places = {b: i for i, b in enumerate(algebra.blades)}
    theirs = {frozenset(t): i for i, t in enumerate(layout.bladeTupList)}
    ids = sorted(i for t in layout.bladeTupList if len(t) == 1 for i in t)
    matrix = np.zeros((len(theirs), len(places)))
    for blade, column in places.items():
        expanded = {0: 1.0}
        for v in range(algebra.dimension):
            if blade >> v & 1:
                grown: dict[int, float] = {}
                for part, c in expanded.items():
                    for w in np.flatnonzero(vectors[:, v]):
                        sign = outer_sign(part, 1 << int(w))
                        grown[part | 1 << int(w)] = grown.get(part | 1 << int(w), 0.0) + sign * c * vectors[w, v]
                expanded = grown
        for part, c in expanded.items():
            if c:
                key = frozenset(ids[w] for w in range(len(ids)) if part >> w & 1)
                matrix[theirs[key], column] = c
    return matrix


@cache
def oracle(algebra: Algebra) -> Oracle:
    """The layout for one of our algebras: Cl(4,1) for the CGA, otherwise vector by vector in storage order."""
    if "ni" in algebra.vectors:
        n = algebra.dimension
        layout, _ = clifford.Cl(n - 1, 1)
        vectors = np.zeros((n, n))
        for v, label in enumerate(algebra.vectors):
            if label in NULL_VECTORS:
                vectors[n - 2, v], vectors[n - 1, v] = NULL_VECTORS[label]["+"], NULL_VECTORS[label]["-"]
            else:
                vectors[int(label) - 1, v] = 1.0
        return Oracle(algebra, layout, vectors)
    squares = [int(algebra.metric[i][i]) for i in range(algebra.dimension)]
    layout = clifford.Layout(squares)
    return Oracle(algebra, layout, np.eye(algebra.dimension))
