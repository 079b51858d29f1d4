"""Proofs about kinds: a random member obeys the constraints, and is as general as they allow.

If random members are not generic, nonzero coefficients are wrongly removed by the trace; if the constraints do not
generate the full ideal, valid reductions are missed. Both are checked exactly, by ranks of Jacobians over F_p: the
member varies in as many directions as the constraints admit.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..errors import KindError
from ..rings.dual import DualRing
from ..rings.modular import P, Samples
from ..rings.protocol import SampleRing
from .algebra import Kind
from .members import SampleSource, residuals, sample, violation
from .multivector import Multivector

SEED = 1
#: No member draws more random numbers than this.
MOST_DRAWS = 64


def check_kind(kind: Kind) -> None:
    """Prove that random members satisfy the kind's constraints and are generic among those that do.

    Raises
    ------
    KindError
        If one breaks a constraint, or varies in fewer directions than the constraints admit.
    """
    problem = violation(kind, sample(kind, SampleSource(SampleRing(16), SEED)))
    if problem:
        raise KindError(f"kind {kind.name!r} of {kind.algebra.name}: its random member breaks it: {problem}.")
    if kind.is_layout:
        return
    drawn, admissible = member_rank(kind), kind.size - constraint_rank(kind)
    if drawn != admissible:
        raise KindError(
            f"kind {kind.name!r} of {kind.algebra.name}: its random member varies in {drawn} directions, its "
            f"constraints admit {admissible}; make the member more general, or state the constraints that it obeys."
        )


class _Directions:
    """The same random numbers in every sample point; the n-th drawn one varies at point n."""

    def __init__(self) -> None:
        self.ring: Any = DualRing(SampleRing(MOST_DRAWS))
        self.random = np.random.default_rng(SEED)
        self.drawn = 0

    def scalar(self) -> Any:
        value = np.full(MOST_DRAWS, self.random.integers(1, P), np.uint64)
        tangent = np.zeros(MOST_DRAWS, np.uint64)
        tangent[self.drawn] = 1
        self.drawn += 1
        return Samples(value), Samples(tangent)


def member_rank(kind: Kind) -> int:
    """Number of independent directions in which the random member varies."""
    source = _Directions()
    member = sample(kind, source)
    return _rank([_row(member.terms.get(b)) for b in kind.blades])


def constraint_rank(kind: Kind) -> int:
    """Number of independent constraints at a random member."""
    base = SampleRing(kind.size)
    member = sample(kind, SampleSource(SampleRing(1), SEED))
    ring = DualRing(base)
    terms = {}
    for j, blade in enumerate(kind.blades):
        value = int(member.terms[blade].re[0]) if blade in member.terms else 0
        tangent = np.zeros(kind.size, np.uint64)
        tangent[j] = 1
        terms[blade] = (Samples(np.full(kind.size, value, np.uint64)), Samples(tangent))
    x = Multivector(kind.algebra, ring, terms)
    return _rank([_row(c) for residual in residuals(kind, x) for c in residual.terms.values()])


def _row(coefficient: Any) -> list[int]:
    """Derivatives of a coefficient in all sample points."""
    if coefficient is None or coefficient[1] is None:
        return []
    return [int(v) for v in coefficient[1].re]


def _rank(rows: list[list[int]]) -> int:
    """Rank over F_p by elimination."""
    live = [row for row in rows if any(row)]
    rank = 0
    while live:
        pivot = live.pop()
        column = next((k for k, v in enumerate(pivot) if v), None)
        if column is None:
            continue
        rank += 1
        inverse = pow(pivot[column], -1, P)
        for row in live:
            if row[column]:
                scale = row[column] * inverse % P
                row[:] = [(v - scale * w) % P for v, w in zip(row, pivot, strict=True)]
    return rank
