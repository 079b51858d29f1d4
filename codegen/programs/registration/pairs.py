"""Invariants of pairs of objects: what no motion changes."""

from __future__ import annotations

from ...algorithms.registration_layout import INVARIANTS
from ...ir.loops.algorithm import Algorithm as algorithm
from ...ir.loops.language import InOut, Int, Ints, Out, Reals, Static, Vector, empty
from .registration import PAIR_SETS


@algorithm
def invariants(
    kinds: Static,
    first_kind: Int,
    second_kind: Int,
    first_rows: Reals,
    second_rows: Reals,
    first: Int,
    second: Int,
    found: Out[Vector[INVARIANTS]],
) -> None:
    """Invariants of a pair of objects by their rows; kinds in order."""
    for pair in PAIR_SETS[kinds]:
        if first_kind == pair.first.number and second_kind == pair.second.number:
            x = pair.first.length * first
            y = pair.second.length * second
            found[:] = pair.invariants(first_rows[x : x + pair.first.length], second_rows[y : y + pair.second.length])
            return


@algorithm
def invariants_of_all(
    kinds: Static,
    first_kind: Int,
    second_kind: Int,
    first_rows: Reals,
    second_rows: Reals,
    row: Int,
    start: Int,
    begin: Int,
    second: Ints,
    found: InOut[Reals],
) -> None:
    """Invariants of an object with all others from a place on, each invariant in a row of its own.

    Pairs of all objects share these rows; those of this one begin at a place of them.
    """
    count = len(found) // INVARIANTS
    own = empty(INVARIANTS)
    for k in range(start, len(second)):
        invariants(kinds, first_kind, second_kind, first_rows, second_rows, row, second[k], own)
        for j in range(INVARIANTS):
            found[j * count + begin + k - start] = own[j]
