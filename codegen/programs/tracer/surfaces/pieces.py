"""Pieces of curves of circles and of point pairs: the frame of a row, and points that are offered from it.

Everything is done in the piece's own frame, moved and scaled to about unit size; its constants are made there once.
"""

from __future__ import annotations

from ....ir.loops.algorithm import inlined
from ....ir.loops.language import InOut, Int, Ints, Out, Real, Reals, Rows, Vector, largest
from ....status import Status
from ..hits import AXES, accept_hit
from ..records import HIT, PIECE, RAY, SEARCH, SPANS, STATE
from .spans import VANISHES

#: Parameters of a surface are what a row begins with, without the sphere, then its controls.
PIECE_SIZE = PIECE.size
BOUND_AT, SPANS_AT = PIECE.offsets["bound"], PIECE.offsets["spans"]


@inlined
def begin_row(parameters: Reals, row: InOut[Reals]) -> None:
    """What a row begins with: unbounded, until somebody knows better."""
    for i in range(BOUND_AT):
        row[i] = parameters[i]
    for i in range(BOUND_AT, SPANS_AT - 1):
        row[i] = 0.0
    row[SPANS_AT - 1] = largest()
    for i in range(2 * SPANS):
        row[SPANS_AT + i] = parameters[BOUND_AT + i]


@inlined
def origin_in_frame(origin: Out[Vector[3]], piece: PIECE, ray: RAY) -> None:
    """The origin of a ray in the frame of a piece."""
    for i in AXES:
        origin[i] = (ray.origin[i] - piece.center[i]) * piece.inverse


@inlined
def point_on(position: Out[Vector[3]], origin: Vector[3], direction: Vector[3], t: Real) -> None:
    """A point of a ray."""
    for i in AXES:
        position[i] = origin[i] + t * direction[i]


@inlined
def status_of(count: Int) -> Int:
    """The status of a row, of what a finder of roots returned."""
    if count >= 0:
        return Status.OK
    return Status.SINGULAR if count == VANISHES else Status.INVALID


@inlined
def offer_at(
    t: Real, at: Real, position: Vector[3], piece: PIECE, search: InOut[SEARCH], hits: InOut[Rows[HIT]],
    state: InOut[STATE], integers: Ints,
) -> None:  # fmt: skip
    """Offer a point, of a parameter of the piece and of the ray in the frame."""
    place = accept_hit(t * piece.unit, piece.start + piece.length * at, search, hits, state, integers)
    if place >= 0:
        hit = hits[place]
        hit.at = at
        for i in AXES:
            hit.local[i] = position[i]
            hit.point[i] = piece.center[i] + piece.unit * position[i]
