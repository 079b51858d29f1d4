"""Rigorous bounding boxes and spheres of surfaces; those of evolved surfaces by affine arithmetic along the curve.

Bounds from sampled circles lose hits. Here every circle or point pair of a short piece is enclosed, rounding included;
pieces whose enclosure is too wide are bisected.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.algebra.multivector import Multivector, from_values
from ...codegen.formulas.curves import surfaces
from ...codegen.formulas.rays import boxes
from ...codegen.programs import cga3d
from ...codegen.programs.tracer.surfaces.kind import SurfaceKind
from ...common import parallel
from ...curves.bernstein import binomials
from .affine_arithmetic import AffineForm, AffineRing, polynomial

Array = NDArray[Any]
#: Initial number of pieces of the curve. The excess of a bound is of the order of one over its square.
PIECES = 16
#: Largest excess of an upper bound over the lower bound of the same extent, in sizes of the surface, before bisection.
MAX_EXCESS = 0.05
#: Largest number of successive bisections of a piece; a row that needs more counts as unbounded.
MAX_BISECTIONS = 16
#: Largest number of pieces of one row that are bisected at once; a row that needs more counts as unbounded.
MAX_PENDING = 256
#: Rows that are enclosed at once: the arrays of their pieces stay in the processor's cache.
ROWS_AT_ONCE = 2048
#: Relative growth of bounds for the rounding of hits, in float32 too.
SAFETY = 1e-3
#: Radius that stands for "unbounded" in the driver.
FAR = float(np.finfo(np.float64).max)


def compute_bounds(kind: SurfaceKind, constants: Array) -> tuple[Array, Array]:
    """Bound surfaces: axis-aligned boxes of rows of constants, and the bounding spheres of evolved surfaces.

    Parameters
    ----------
    kind : SurfaceKind
    constants : (n, constants) array
        For evolved surfaces the part called "bound" is filled in, in place: center and radius of a sphere, in the
        surface's local frame.

    Returns
    -------
    constants : (n, constants) array
    boxes : (n, 6) array
        Low and high corner; infinite for unbounded surfaces.
    """
    if any(name == "bound" for name, _ in kind.layout):
        return constants, _evolved_boxes(kind, constants)
    make = _BOXES.get(kind.name)
    if make is None:
        return constants, _unbounded_boxes(len(constants))
    return constants, make(constants)


def _unbounded_boxes(count: int) -> Array:
    return np.repeat([[-np.inf] * 3 + [np.inf] * 3], count, axis=0)


# -- primitives ---------------------------------------------------------------------------------------------


def _around(center: Array, half: Array) -> Array:
    """Boxes from centers and half lengths, widened by one unit in the last place."""
    with np.errstate(over="ignore"):
        return np.concatenate([np.nextafter(center - half, -np.inf), np.nextafter(center + half, np.inf)], axis=1)


def _sphere_boxes(rows: Array) -> Array:
    return _around(rows[:, :3], rows[:, 3:4])


def _disc_boxes(rows: Array) -> Array:
    """Half length along an axis: radius times the normal's component across it, without cancellation."""
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
    """Parts of curves: the row of each, and the interval of its parameter."""

    rows: Array
    begin: Array
    end: Array

    def take(self, where: Array) -> _Pieces:
        return _Pieces(self.rows[where], self.begin[where], self.end[where])

    def halves(self) -> _Pieces:
        middle = 0.5 * (self.begin + self.end)
        joined = [np.concatenate(pair) for pair in ((self.begin, middle), (middle, self.end))]
        return _Pieces(np.concatenate([self.rows, self.rows]), *joined)


#: Enclosures of the objects of pieces: a circle's center, squared radius and normal, or a pair's midpoint and half.
Shape = tuple[Multivector, ...]


def _evolved_boxes(kind: SurfaceKind, constants: Array) -> Array:
    """Fill in the bounding spheres of evolved surfaces; return their boxes in the world."""
    boxes_ = _unbounded_boxes(len(constants))
    bound = constants[:, kind.slice("bound")]

    def enclose(begin: int, end: int) -> None:
        part = slice(begin, end)
        with np.errstate(all="ignore"):
            low, high, radius = _enclose(kind, constants[part])
            sure = np.isfinite(radius) & np.isfinite(low).all(axis=1) & np.isfinite(high).all(axis=1)
            bound[part, :3] = np.where(sure[:, None], 0.5 * (low + high), 0.0)
            bound[part, 3] = np.where(sure, radius, FAR)
            center, unit = constants[part, kind.slice("center")], constants[part, kind.slice("unit")][:, :1]
            box = np.concatenate([center + unit * low, center + unit * high], axis=1)
            boxes_[part] = np.where(sure[:, None] & np.isfinite(box), box, boxes_[part])

    parallel.run(enclose, len(constants), chunk=ROWS_AT_ONCE)
    return boxes_


def _enclose(kind: SurfaceKind, constants: Array) -> tuple[Array, Array, Array]:
    """Corners of boxes around evolved surfaces, and radii about their centers; not finite where they are unbounded.

    A piece is bisected while its upper bound exceeds the largest lower bound of all pieces.
    """
    round_ = kind.name.startswith("evolved_circles")
    columns, count = np.ascontiguousarray(constants.T), len(constants)
    sides, reached = np.full((6, count), -np.inf), np.full((6, count), -np.inf)
    waiting = _first_pieces(constants[:, kind.slice("spans")].reshape(count, -1, 2))
    done: list[tuple[Array, Shape]] = []
    for depth in range(MAX_BISECTIONS + 1):
        shape = _shape(kind, columns, waiting, round_)
        least, most = _extents(shape, round_)
        rows = waiting.rows
        for side, surely in zip(reached, least, strict=True):
            np.maximum.at(side, rows, np.where(np.isfinite(surely), surely, -np.inf))
        size = np.max(reached[:3] + reached[3:], axis=0)
        good = np.all(most <= (reached + MAX_EXCESS * size)[:, rows], axis=0)
        given_up = np.bincount(rows[~good], minlength=count) > (MAX_PENDING if depth < MAX_BISECTIONS else 0)
        good |= given_up[rows]
        for side, reach in zip(sides, most, strict=True):
            np.maximum.at(side, rows[good], np.where(np.isnan(reach), np.inf, reach)[good])
        done.append((rows[good], _take_shape(shape, good)))
        if good.all():
            break
        waiting = waiting.take(~good).halves()
    return _with_safety(-sides[:3].T, sides[3:].T, done, round_)


def _first_pieces(spans: Array) -> _Pieces:
    """Initial pieces of the spans (rows, spans, 2) in which curves are real; unused spans begin behind their end."""
    rows, indices = np.nonzero(spans[..., 0] <= spans[..., 1])
    begin, end = spans[rows, indices].T
    ends = np.clip(begin[:, None] + np.linspace(0.0, 1.0, PIECES + 1) * (end - begin)[:, None], 0.0, 1.0)
    return _Pieces(np.repeat(rows, PIECES), ends[:, :-1].ravel(), ends[:, 1:].ravel())


def _shape(kind: SurfaceKind, columns: Array, pieces: _Pieces, round_: bool) -> Shape:
    """Enclose the objects of pieces, from columns of constants."""
    algebra, ring = cga3d(), AffineRing()
    blades = algebra.kind("circle" if round_ else "point_pair").blades

    def part(name: str, size: int) -> AffineForm:
        scaled = columns[kind.slice(name)][:, pieces.rows].reshape(-1, size, len(pieces.rows))
        return polynomial(scaled / binomials(len(scaled) - 1)[:, None, None], pieces.begin, pieces.end)

    def objects(name: str) -> Multivector:
        parts = zip(*part(name, len(blades)), strict=True)
        return from_values(algebra, ring, blades, [AffineForm(*x) for x in parts])

    def scalar(value: AffineForm) -> Multivector:
        return Multivector(algebra, ring, {0: AffineForm(*(x[0] for x in value))})

    norm, kappa = part("norm", 1), part("kappa", 1)
    degrees = [kind.slice(name).stop - kind.slice(name).start - 1 for name in ("norm", "kappa")]
    has_object_ends = degrees[1] < 2 * degrees[0]
    hump = (
        np.array([[[0.0]], [[0.5]], [[0.0]]]) if has_object_ends else np.array([[[1.0]]])
    )  # a b where the ends are objects
    w = scalar(polynomial(np.broadcast_to(hump, (*hump.shape[:2], len(pieces.rows))), pieces.begin, pieces.end))
    m, _ = surfaces.branch(scalar(norm), scalar(kappa), w)
    # over m: a weight that changes along the piece would widen the enclosures of all that follows
    unit = objects("controls") - (w / m) * objects("products")
    return boxes.circle_shape(unit) if round_ else boxes.pair_shape(unit)


def _vector(x: Multivector) -> list[AffineForm]:
    return [AffineForm(*x[name].scalar()) for name in ("e1", "e2", "e3")]


def _extents(shape: Shape, round_: bool) -> tuple[Array, Array]:
    """Lower and upper bounds (6, pieces) of the extents of pieces along -x, -y, -z, x, y, z."""
    ring, center = AffineRing(), _vector(shape[0])
    halves = [x.scalar() for x in boxes.circle_extents(shape[1], shape[2])] if round_ else _vector(shape[1])
    least, most = [], []
    for outwards in (-1, 1):
        for c, half in zip(center, halves, strict=True):
            ends = [ring.combine([(c, Fraction(outwards)), (half, Fraction(sign))]) for sign in (1, -1)]
            least.append(np.maximum(*(x.center - x.radius for x in ends)))
            most.append(np.maximum(*(x.high for x in ends)))
    return np.stack(np.broadcast_arrays(*least)), np.stack(np.broadcast_arrays(*most))


def _take_shape(shape: Shape, where: Array) -> Shape:
    """Select some of the pieces."""
    every = where.all()

    def masked(x: AffineForm) -> AffineForm:
        return x if every else AffineForm(*(np.broadcast_to(y, where.shape)[where] for y in x))

    return tuple(Multivector(x.algebra, x.ring, {b: masked(c) for b, c in x.terms.items()}) for x in shape)


def _with_safety(low: Array, high: Array, done: list[tuple[Array, Shape]], round_: bool) -> tuple[Array, Array, Array]:
    """Boxes with a margin for the rounding of hits, and the largest distance of the surface from their centers."""
    middle = 0.5 * (low + high)
    square = np.zeros(len(low))
    for rows, shape in done:
        np.maximum.at(square, rows, _squared_range(shape, middle[rows], round_))
    radius = np.sqrt(square) * (1 + SAFETY)
    half = 0.5 * (high - low) + SAFETY * radius[:, None]
    return middle - half, middle + half, np.where(np.isnan(square), np.inf, radius)


def _squared_range(shape: Shape, middle: Array, round_: bool) -> Array:
    """Squares of the largest distances of pieces from points (pieces, 3)."""
    ring = AffineRing()
    like = shape[0]
    points = [AffineForm(x, 0.0, 0.0) for x in middle.T]
    blades = [like.algebra.parse_blade(name)[0] for name in ("e1", "e2", "e3")]
    center = like - from_values(like.algebra, ring, blades, points)
    if round_:
        return np.asarray(boxes.circle_extent(center, shape[1], shape[2]).scalar().high)
    ends = [center + shape[1], center - shape[1]]
    squares = [x.scalar_product(x).scalar().high for x in ends]
    return np.asarray(np.maximum(*squares))
