"""The merging driver: for each kind of object its cost, its mean and its landmark, and the greedy loop around them."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cache

from ..formulas import costs, merging
from ..multivector import Multivector
from ..rings import RationalRing
from . import Declared, Program, cga3d, program, traced

#: Kinds of object, in the order that the driver numbers them; all of one grade go as the last of that grade.
KINDS = ("point", "point_pair", "line", "circle", "plane", "sphere")
_HEADERS = ("platform.h", "instance.h", "instance_end.h", "merge_types.h", "merge_tree.h", "merge_loops.h")


def _declared(kind: str) -> list[Declared]:
    pair = (kind, kind)
    weighted = (*pair, "number", "number")
    return [
        Declared(costs.pair_cost, pair, f"cost_{kind}"),
        Declared(costs.aligned_cost, pair, f"aligned_cost_{kind}"),
        Declared(merging.mean_of_two, weighted, f"mean_{kind}"),
        Declared(merging.aligned_mean_of_two, weighted, f"aligned_mean_{kind}"),
        Declared(merging.landmark, (kind,), f"landmark_{kind}"),
    ]


@dataclass(frozen=True)
class MergedKind:
    """A kind of object, as the driver's template sees it: the length of its landmark, and what squares count."""

    name: str
    marks: int
    squares: tuple[str, ...]

    @property
    def size(self) -> int:
        """Coefficients of a row."""
        return len(self.squares)


def _merged_kind(name: str) -> MergedKind:
    """The null basis has orthogonal blades, too, whose squares count otherwise: what `costs.magnitude` says of each."""
    algebra, ring = cga3d(), RationalRing()
    basis = [Multivector(algebra, ring, {blade: Fraction(1)}) for blade in algebra.kind(name).blades]
    squares = tuple(str(float(costs.magnitude(b).terms[0])) for b in basis)
    return MergedKind(name, len(traced(_declared(name)[-1]).outputs[0].nodes), squares)


@cache
def merge_program() -> Program:
    """The program that merges objects of any kind."""
    values = {
        "title": "Merging of similar objects",
        "kinds": [_merged_kind(name) for name in KINDS],
        "elementary": False,
    }
    declared = [d for kind in KINDS for d in _declared(kind)]
    return program("merge", declared, "c/merge.c.j2", "c/merge_types.h", _HEADERS, values)
