"""The merging driver: for each kind of object its cost, its mean and its landmark, and the greedy loop around them."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cache

from ..algebra.multivector import Multivector
from ..formulas.objects import costs, merging
from ..rings.protocol import RationalRing
from . import KernelSpec, Program, cga3d, program, trace_spec

#: Kinds of object, in the order that the driver numbers them; all of one grade go as the last of that grade.
KINDS = ("point", "point_pair", "line", "circle", "plane", "sphere")


def _kernel_specs(kind: str) -> list[KernelSpec]:
    pair = (kind, kind)
    weighted = (*pair, "number", "number")
    return [
        KernelSpec(costs.pair_cost, pair, f"cost_{kind}"),
        KernelSpec(costs.aligned_cost, pair, f"aligned_cost_{kind}"),
        KernelSpec(merging.mean_of_two, weighted, f"mean_{kind}"),
        KernelSpec(merging.aligned_mean_of_two, weighted, f"aligned_mean_{kind}"),
        KernelSpec(merging.landmark, (kind,), f"landmark_{kind}"),
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
    return MergedKind(name, len(trace_spec(_kernel_specs(name)[-1]).outputs[0].nodes), squares)


@cache
def merge_program() -> Program:
    """The program that merges objects of any kind."""
    values = {
        "title": "Merging of similar objects",
        "kinds": [_merged_kind(name) for name in KINDS],
        "elementary": False,
    }
    specs = [d for kind in KINDS for d in _kernel_specs(kind)]
    return program("merge", specs, "merge.c.j2", "merge_types.h", values)
