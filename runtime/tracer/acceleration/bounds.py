"""Spheres and boxes that surely hold surfaces: of evolved ones, by their formulas run on pieces of the curve.

Bounds from sampled circles lose hits. Here every circle or pair of a short piece is enclosed, whatever rounding does;
pieces about which too little is known are cut again.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import parallel
from ..codegen.formulas import boxes, surfaces
from ..codegen.multivector import Multivector, from_values
from ..codegen.programs import cga3d
from ..codegen.programs.surface_kinds import SurfaceKind
from .enclosures import Enclosure, EnclosureRing, polynomial

Array = NDArray[Any]
#: Pieces of the curve at first. What a bound exceeds is of the order of one over its square.
PIECES = 16
#: A piece is cut again where it may reach farther than surely reached by this part of the surface's size.
LOOSE = 0.05
#: Times that a piece is cut in two, and pieces of one row that may be cut at once, before they count as unbounded.
CUTS, MOST_CUT = 16, 256
#: Rows that are enclosed at once: their pieces' arrays stay in the processor's cache.
ROWS_AT_ONCE = 2048
#: Relative growth of bounds for the rounding of hits, in float32 too.
SAFETY = 1e-3
#: What the driver takes for "unbounded".
FAR = float(np.finfo(np.float64).max)


def bounded(kind: SurfaceKind, constants: Array) -> tuple[Array, Array]:
    """Rows of constants with the bounds that only Python knows, and boxes along the axes of the world.

    Parameters
    ----------
    kind : SurfaceKind
    constants : (n, constants) array
        Of evolved surfaces, the part called "bound" is filled in, in place: centre and radius of a sphere, in the
        surface's own frame.

    Returns
    -------
    constants : (n, constants) array
    boxes : (n, 6) array
        Low and high corner; infinite for unbounded surfaces.
    """
    if any(name == "bound" for name, _ in kind.layout):
        return constants, _evolved(kind, constants)
    make = _BOXES.get(kind.name)
    if make is None:
        return constants, _unbounded(len(constants))
    return constants, make(constants)


def _unbounded(count: int) -> Array:
    return np.repeat([[-np.inf] * 3 + [np.inf] * 3], count, axis=0)


# -- plain kinds -------------------------------------------------------------------------------------------


def _around(center: Array, half: Array) -> Array:
    """Boxes by their centres and half lengths, one rounding wider."""
    with np.errstate(over="ignore"):
        return np.concatenate([np.nextafter(center - half, -np.inf), np.nextafter(center + half, np.inf)], axis=1)


def _sphere_boxes(rows: Array) -> Array:
    return _around(rows[:, :3], rows[:, 3:4])


def _disc_boxes(rows: Array) -> Array:
    """Along an axis, the radius times the normal's part across it: no difference of nearly equal numbers."""
    x, y, z = (rows[:, 3:6] ** 2).T
    across = np.sqrt(np.stack([y + z, x + z, x + y], axis=1))
    return _around(rows[:, :3], rows[:, 6:7] * across * (1 + SAFETY))


def _corner_boxes(rows: Array) -> Array:
    corners = [rows[:, i : i + 3] for i in (0, 3, 6)]
    low = np.minimum(np.minimum(corners[0], corners[1]), corners[2])
    return np.concatenate([low, np.maximum(np.maximum(corners[0], corners[1]), corners[2])], axis=1)


_BOXES: dict[str, Callable[[Array], Array]] = {
    "sphere": _sphere_boxes, "disc": _disc_boxes, "facet": _corner_boxes, "smooth_facet": _corner_boxes,
}  # fmt: skip


# -- evolved surfaces ------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class _Pieces:
    """Parts of curves: each one's row, and where it begins and ends."""

    rows: Array
    begin: Array
    end: Array

    def taken(self, where: Array) -> _Pieces:
        return _Pieces(self.rows[where], self.begin[where], self.end[where])

    def halves(self) -> _Pieces:
        middle = 0.5 * (self.begin + self.end)
        joined = [np.concatenate(pair) for pair in ((self.begin, middle), (middle, self.end))]
        return _Pieces(np.concatenate([self.rows, self.rows]), *joined)


#: Enclosed shapes of the objects of pieces: a circle's centre, squared radius and normal, or a pair's middle and half.
Shape = tuple[Multivector, ...]


def _evolved(kind: SurfaceKind, constants: Array) -> Array:
    """Fill in the spheres around evolved surfaces; their boxes in the world."""
    found = _unbounded(len(constants))
    bound = constants[:, kind.slice("bound")]

    def enclose(begin: int, end: int) -> None:
        part = slice(begin, end)
        with np.errstate(all="ignore"):
            low, high, radius = _enclosed(kind, constants[part])
            sure = np.isfinite(radius) & np.isfinite(low).all(axis=1) & np.isfinite(high).all(axis=1)
            bound[part, :3] = np.where(sure[:, None], 0.5 * (low + high), 0.0)
            bound[part, 3] = np.where(sure, radius, FAR)
            center, unit = constants[part, kind.slice("center")], constants[part, kind.slice("unit")][:, :1]
            box = np.concatenate([center + unit * low, center + unit * high], axis=1)
            found[part] = np.where(sure[:, None] & np.isfinite(box), box, found[part])

    parallel.run(enclose, len(constants), chunk=ROWS_AT_ONCE)
    return found


def _enclosed(kind: SurfaceKind, constants: Array) -> tuple[Array, Array, Array]:
    """Corners of boxes around evolved surfaces, and radii about their middles; not finite where they are unbounded.

    A piece that reaches farther than is surely reached by some piece is cut again.
    """
    round_ = kind.name.startswith("evolved_circles")
    columns, count = np.ascontiguousarray(constants.T), len(constants)
    sides, reached = np.full((6, count), -np.inf), np.full((6, count), -np.inf)
    waiting = _first_pieces(constants[:, kind.slice("spans")].reshape(count, -1, 2))
    done: list[tuple[Array, Shape]] = []
    for cut in range(CUTS + 1):
        shape = _shape(kind, columns, waiting, round_)
        least, most = _extents(shape, round_)
        rows = waiting.rows
        for side, surely in zip(reached, least, strict=True):
            np.maximum.at(side, rows, np.where(np.isfinite(surely), surely, -np.inf))
        size = np.max(reached[:3] + reached[3:], axis=0)
        good = np.all(most <= (reached + LOOSE * size)[:, rows], axis=0)
        given_up = np.bincount(rows[~good], minlength=count) > (MOST_CUT if cut < CUTS else 0)
        good |= given_up[rows]
        for side, reach in zip(sides, most, strict=True):
            np.maximum.at(side, rows[good], np.where(np.isnan(reach), np.inf, reach)[good])
        done.append((rows[good], _taken(shape, good)))
        if good.all():
            break
        waiting = waiting.taken(~good).halves()
    return _grown(-sides[:3].T, sides[3:].T, done, round_)


def _first_pieces(spans: Array) -> _Pieces:
    """Pieces of the spans (rows, spans, 2) in which curves are real; unused spans begin behind their end."""
    rows, places = np.nonzero(spans[..., 0] <= spans[..., 1])
    begin, end = spans[rows, places].T
    ends = np.clip(begin[:, None] + np.linspace(0.0, 1.0, PIECES + 1) * (end - begin)[:, None], 0.0, 1.0)
    return _Pieces(np.repeat(rows, PIECES), ends[:, :-1].ravel(), ends[:, 1:].ravel())


def _shape(kind: SurfaceKind, columns: Array, pieces: _Pieces, round_: bool) -> Shape:
    """The objects of pieces, enclosed, from columns of constants."""
    algebra, ring = cga3d(), EnclosureRing()
    blades = algebra.kind("circle" if round_ else "point_pair").blades

    def part(name: str, size: int) -> Enclosure:
        scaled = columns[kind.slice(name)][:, pieces.rows].reshape(-1, size, len(pieces.rows))
        return polynomial(scaled / _binomials(len(scaled) - 1)[:, None, None], pieces.begin, pieces.end)

    def objects(name: str) -> Multivector:
        parts = zip(*part(name, len(blades)), strict=True)
        return from_values(algebra, ring, blades, [Enclosure(*x) for x in parts])

    def scalar(value: Enclosure) -> Multivector:
        return Multivector(algebra, ring, {0: Enclosure(*(x[0] for x in value))})

    norm, kappa = part("norm", 1), part("kappa", 1)
    degrees = [kind.slice(name).stop - kind.slice(name).start - 1 for name in ("norm", "kappa")]
    ended = degrees[1] < 2 * degrees[0]
    hump = np.array([[[0.0]], [[0.5]], [[0.0]]]) if ended else np.array([[[1.0]]])  # a b where the ends are objects
    w = scalar(polynomial(np.broadcast_to(hump, (*hump.shape[:2], len(pieces.rows))), pieces.begin, pieces.end))
    m, _ = surfaces.branch(scalar(norm), scalar(kappa), w)
    # over m: a weight that changes along the piece would widen the enclosures of all that follows
    made = objects("controls") - (w / m) * objects("products")
    return boxes.circle_shape(made) if round_ else boxes.pair_shape(made)


def _binomials(n: int) -> Array:
    row = np.ones(1)
    for _ in range(n):
        row = np.convolve(row, [1.0, 1.0])
    return row


def _vector(x: Multivector) -> list[Enclosure]:
    return [Enclosure(*x[name].scalar()) for name in ("e1", "e2", "e3")]


def _extents(shape: Shape, round_: bool) -> tuple[Array, Array]:
    """How far pieces reach along -x, -y, -z, x, y, z (6, pieces): surely so far, and never farther."""
    ring, center = EnclosureRing(), _vector(shape[0])
    halves = [x.scalar() for x in boxes.circle_extents(shape[1], shape[2])] if round_ else _vector(shape[1])
    least, most = [], []
    for outwards in (-1, 1):
        for c, half in zip(center, halves, strict=True):
            ends = [ring.combine([(c, Fraction(outwards)), (half, Fraction(sign))]) for sign in (1, -1)]
            least.append(np.maximum(*(x.middle - x.error for x in ends)))
            most.append(np.maximum(*(x.high for x in ends)))
    return np.stack(np.broadcast_arrays(*least)), np.stack(np.broadcast_arrays(*most))


def _taken(shape: Shape, where: Array) -> Shape:
    """The same of some of the pieces."""
    every = where.all()

    def some(x: Enclosure) -> Enclosure:
        return x if every else Enclosure(*(np.broadcast_to(y, where.shape)[where] for y in x))

    return tuple(Multivector(x.algebra, x.ring, {b: some(c) for b, c in x.terms.items()}) for x in shape)


def _grown(low: Array, high: Array, done: list[tuple[Array, Shape]], round_: bool) -> tuple[Array, Array, Array]:
    """Boxes with room for the rounding of hits, and the farthest that anything is from their middles."""
    middle = 0.5 * (low + high)
    square = np.zeros(len(low))
    for rows, shape in done:
        np.maximum.at(square, rows, _reach(shape, middle[rows], round_))
    radius = np.sqrt(square) * (1 + SAFETY)
    half = 0.5 * (high - low) + SAFETY * radius[:, None]
    return middle - half, middle + half, np.where(np.isnan(square), np.inf, radius)


def _reach(shape: Shape, middle: Array, round_: bool) -> Array:
    """Squares of the farthest distances of pieces from points (pieces, 3)."""
    ring = EnclosureRing()
    like = shape[0]
    points = [Enclosure(x, 0.0, 0.0) for x in middle.T]
    blades = [like.algebra.parse_blade(name)[0] for name in ("e1", "e2", "e3")]
    center = like - from_values(like.algebra, ring, blades, points)
    if round_:
        return np.asarray(boxes.circle_reach(center, shape[1], shape[2]).scalar().high)
    ends = [center + shape[1], center - shape[1]]
    squares = [x.scalar_product(x).scalar().high for x in ends]
    return np.asarray(np.maximum(*squares))


__all__ = ["bounded"]
