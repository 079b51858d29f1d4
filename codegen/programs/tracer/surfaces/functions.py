"""Algorithms of kinds of surfaces along curves, as programs call them: constants of rows, points of rays, normals."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

from ....ir.loops.algorithm import Bound, CFunction, inlined
from ....ir.loops.language import InOut, Ints, Reals, Rows, Static
from ..plain_surfaces import plane_normal
from ..records import HIT, RAY, SEARCH, STATE
from ..surface_kinds import METHODS
from .kind import SurfaceKind
from .rows import CircleRows


class CurveAlgorithms(NamedTuple):
    """What programs call of a kind of surface along curves: algorithms, or functions of C."""

    prepare: Any
    normal: Any
    by_method: Mapping[str, Any]

    @property
    def all(self) -> list[Any]:
        """All of them."""
        return [self.prepare, self.normal, *self.by_method.values()]


class Ways(NamedTuple):
    """Algorithms that offer the points of a ray, by how they find roots."""

    label: str
    numbers_hits: tuple[tuple[int, Any], ...]


@inlined
def hits_by_method(
    ways: Static, row: Reals, ray: RAY, search: InOut[SEARCH], hits: InOut[Rows[HIT]], state: InOut[STATE],
    integers: Ints,
) -> None:  # fmt: skip
    """Offer the points of a ray on a piece, found as the scene says."""
    for number, offer_hits in ways.numbers_hits:
        if state.method == number:
            offer_hits(row, ray, search, hits, state, integers)


@inlined
def _prepare(parameters: Reals, row: InOut[Reals]) -> None:
    """What `prepare` of a kind takes."""


def curve_algorithms(kind: SurfaceKind, methods: Sequence[str], defers: bool = False) -> CurveAlgorithms:
    """The algorithms of a kind, for some ways to find roots; ``defers``: rays of rare cases are `Status.INVALID`."""
    from . import circle_points, circle_roots, pair_points, pair_roots

    assert kind.rows is not None
    texts, finder = (
        (circle_points, circle_roots.circle_finder(kind.rows, kind.roots, defers))
        if isinstance(kind.rows, CircleRows)
        else (pair_points, pair_roots.pair_finder(kind.rows, kind.roots, defers))
    )
    by_method = {method: Bound(texts.hits, finder, method) for method in methods}
    return CurveAlgorithms(Bound(texts.prepare, finder), Bound(texts.normal, finder), by_method)


def c_functions_of(kind: SurfaceKind, methods: Sequence[str]) -> CurveAlgorithms:
    """The same as functions of C, which stand elsewhere: nothing of the kind is read."""
    _, *hits = hits_by_method.text.parameters
    _, row = _prepare.text.parameters
    normal = [replace(row, access="in") if p.name == "row" else p for p in plane_normal.text.parameters]
    return CurveAlgorithms(
        CFunction(f"prepare_{kind.name}", _prepare.text.parameters),
        CFunction(f"normal_{kind.name}", normal),
        {method: CFunction(f"hits_{kind.name}_{method}", hits) for method in methods},
    )


def any_method(kind: SurfaceKind, own: CurveAlgorithms) -> Any:
    """What offers the points of a ray, by the method that a scene asks for."""
    if len(own.by_method) == 1:
        return next(iter(own.by_method.values()))
    return Bound(hits_by_method, Ways(kind.name, tuple((METHODS[m], each) for m, each in own.by_method.items())))
