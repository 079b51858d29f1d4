"""Curves of circles and point pairs as polynomial pieces, each in a frame of its own at about unit size.

Curves are linear in their controls and follow translation and scaling: controls are moved while they are parameters,
before anything is multiplied, so that a curve 1e6 from the origin keeps the digits of its own size.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..calls import call
from ..curves import Bezier, Curve, Hermite, Interpolating, RationalBezier
from ..curves.basis import bernstein
from ..errors import SceneError
from ..multivector import Multivector
from ..rows import embedded
from .controls import Controls, from_numbers, opposed, parameters_of, read_controls
from .frames import frames, opposed_neighbours, refuse_one_object, turned_over

Array = NDArray[np.float64]
#: Where the parts of a row of parameters stand: the frame, what is added to the piece's own parameter, intervals where
#: the objects are real, Bernstein controls.
CENTER, UNIT, START, LENGTH = slice(0, 3), slice(3, 5), 5, 6
SPANS, CONTROLS = slice(7, 15), slice(15, None)
#: Spans as surfaces hand them over: real all along, or real where the check finds it.
ALL_REAL, GAPS_ALLOWED = (0.0, 1.0), (2.0, 2.0)
#: An interval that holds nothing.
NOTHING = (1.0, 0.0)
#: A control counts for the frame of a piece if some coefficient takes this share of it, of the largest share.
NEAR_SHARE = 0.5
#: Shares of a far control below this are less than rounding, whatever its size in the frame.
NO_SHARE = 1e-40
#: The ends of sums are objects if the grade 4 of their squares is less than this many rounding units of the scalar.
BLADE_ROUNDING = 1e4
#: Places along a curve of sums where its size is taken.
PLACES = 9
#: Every piece of an interpolating curve takes from all objects: a square of numbers.
MOST_INTERPOLATED = 2000
#: How much heavier than its ends a rational curve may be; beyond it roots near the light ends drown in rounding.
MOST_UNLIKE = 1e6
#: Powers of two that are no extreme sizes of coefficients.
ORDINARY = 16
#: Coefficients of a circle or a point pair.
WIDTH = 10


@dataclass(frozen=True, eq=False)
class Segments:
    """Polynomial pieces of a curve in frames of their own; t = 0 is a piece's first object.

    Attributes
    ----------
    center : (pieces, 3)
        Origins of the frames.
    size : (pieces,)
        Units of length of the frames.
    controls : (pieces, n + 1, 10)
        Bernstein coefficients of degree n in those frames: C'(t) = sum binom(n, k) t^k (1 - t)^(n - k) C_k. Inner
        ones need not be objects; those of rational curves are weighted.
    starts, lengths : (pieces,)
        A piece's t in [0, 1] is the curve's parameter ``starts + lengths * t``.
    flipped : (controls,) of bool
        Which controls of the curve as it was given are turned over, by the curve itself or here.
    free : bool
        Some piece begins or ends with a sum that is no object.
    given : Any
        The curve, or the sequence of controls.
    turned : (controls,) of bool
        Which controls are turned over here.
    kind : {"circle", "point_pair"}
    """

    center: Array
    size: Array
    controls: Array
    starts: Array
    lengths: Array
    flipped: NDArray[np.bool_]
    free: bool
    given: Any
    turned: NDArray[np.bool_]
    kind: str

    @cached_property
    def curve(self) -> Curve:
        """The curve that the surface follows: the given one, with controls turned over where `turned` says so."""
        curve = self.given if isinstance(self.given, Curve) else Bezier(self.given)
        return curve.turned(self.turned) if self.turned.any() else curve

    def with_turned(self, which: NDArray[np.bool_]) -> Segments:
        """The pieces of the curve with further controls turned over, (controls,) of bool."""
        return local_segments(self.curve.turned(which), self.kind, align=False)

    def parameters(self, gaps: bool = False) -> Array:
        """Rows of parameters of an evolved surface (pieces, 15 + 10 (n + 1)), one for each piece."""
        count = len(self.controls)
        rows = np.empty((count, CONTROLS.start + self.controls[0].size))
        rows[:, CENTER], rows[:, UNIT.start], rows[:, UNIT.stop - 1] = self.center, self.size, 1 / self.size
        rows[:, START], rows[:, LENGTH] = self.starts, self.lengths
        rows[:, SPANS] = (*(GAPS_ALLOWED if gaps else ALL_REAL), *NOTHING, *NOTHING, *NOTHING)
        rows[:, CONTROLS] = self.controls.reshape(count, -1)
        return rows


def local_segments(curve: Any, kind: str, align: bool = True) -> Segments:
    """The polynomial pieces of a curve of circles or point pairs.

    Parameters
    ----------
    curve : Curve, Multivector (n,), array (n, 10), or sequence
        Of plain controls a Bezier curve is made. Controls are objects, their coefficients, or parameters:
        (center, normal, radius) of a circle, (a, b) of a point pair, as tuples or mappings.
    kind : {"circle", "point_pair"}
    align : bool
        Turn controls over where they oppose the one before them.

    Raises
    ------
    SceneError
        For a curve of other objects, and controls that are none.
    """
    if not isinstance(curve, Curve):
        return _of_sequence(curve, kind, align)
    from ..loading import stock_algebra

    own = curve.kind
    if own.algebra is not stock_algebra("cga3d") or not set(own.blades) <= set(own.algebra.kind(kind).blades):
        raise SceneError(f"curve is one of {_plural(own.name)}; this surface follows {_plural(kind)}.")
    if not own.constraints:
        return _of_sums(curve, kind)
    return _of_sequence(curve, kind, align) if isinstance(curve, Bezier) else _of_curve(curve, kind, align)


def _of_sequence(given: Any, kind: str, align: bool) -> Segments:
    """A Bezier curve: its controls are its coefficients."""
    curve = given if isinstance(given, Curve) else None
    controls = read_controls(given if curve is None else curve.given, kind)
    if len(controls) < 2:
        raise SceneError(f"a curve needs at least 2 controls, not {len(controls)}.")
    refuse_one_object(controls)
    flipped = np.zeros((1, len(controls)), bool) if curve is None else curve.flipped[None]
    return _of_rows(controls, [given], flipped, np.array([align]))[0]


def bezier_segments(given: Sequence[Sequence[Any]], kind: str, align: NDArray[np.bool_]) -> list[Segments] | None:
    """Bezier curves of plain parameters, of as many controls each, at once; None if one of them is not as it should be.

    Files have thousands of curves, and calls on a few numbers cost more than the numbers.
    """
    controls = from_numbers([control for curve in given for control in curve], kind)
    count = len(given[0])
    if controls is None or count < 2:
        return None
    rows = controls.rows.reshape(len(given), count, -1)
    if (rows == rows[:, :1]).all(axis=(1, 2)).any():
        return None
    return _of_rows(controls, given, np.zeros((len(given), count), bool), align)


def _of_rows(
    controls: Controls, given: Sequence[Any], flipped: NDArray[np.bool_], align: NDArray[np.bool_]
) -> list[Segments]:
    """Bezier curves of as many controls each, which follow on each other; ``flipped`` (curves, count) by the curves."""
    curves, count = flipped.shape
    members = np.arange(curves * count).reshape(curves, count)
    center, size = frames(controls, np.ones((curves, count), bool), members)
    seen = controls.coefficients(np.repeat(center, count, axis=0), np.repeat(size, count))
    rows = seen.reshape(curves, count, WIDTH)
    rows[flipped] *= -1
    first, second = (rows[:, at].reshape(-1, WIDTH) for at in (slice(0, -1), slice(1, None)))
    against = opposed(controls.kind, first, second).reshape(curves, count - 1)
    turned = turned_over(against & align[:, None])
    rows[turned] *= -1
    start, length = np.zeros(1), np.ones(1)
    return [
        Segments(center[i : i + 1], size[i : i + 1], rows[i : i + 1], start, length, flipped[i] ^ turned[i], False,
                 given[i], turned[i], controls.kind)
        for i in range(curves)
    ]  # fmt: skip


def _of_curve(curve: Curve, kind: str, align: bool) -> Segments:
    """A curve of unit objects: what its pieces take of the controls, and these in the frame of each piece."""
    if isinstance(curve, Interpolating) and len(curve) > MOST_INTERPOLATED:
        raise SceneError(
            f"the curve interpolates {len(curve)} objects; surfaces follow up to {MOST_INTERPOLATED}.",
            remedy="Cut it, or use a Kochanek-Bartels curve",
        )
    if isinstance(curve, RationalBezier) and curve.weights[[0, -1]].min() * MOST_UNLIKE < curve.weights.max():
        raise SceneError(
            f"the weights at the ends of the curve, {curve.weights[0]:g} and {curve.weights[-1]:g}, are too "
            f"small beside {curve.weights.max():g}.",
            remedy=f"Use end weights of at least the {1 / MOST_UNLIKE:g}th part of the largest",
        )
    controls = read_controls(curve.given, kind)
    refuse_one_object(controls)
    turned = np.zeros(len(controls), bool)
    if align:
        turned = turned_over(opposed_neighbours(controls) ^ curve.flipped[:-1] ^ curve.flipped[1:])
    flipped = curve.flipped ^ turned
    members, shares = _needed(*curve.blending())
    sizes = np.abs(shares)
    objects = members < len(controls)  # the others are tangents
    near = (sizes >= NEAR_SHARE * sizes.max(axis=2, keepdims=True)).any(axis=1) & objects
    center, size = frames(controls, near, np.where(objects, members, 0))
    rows = np.empty((*members.shape, WIDTH))
    piece, place = np.nonzero(objects)
    which = members[piece, place]
    signs = np.where(flipped, -1.0, 1.0)[which, None]
    rows[piece, place] = controls.taken(which).coefficients(center[piece], size[piece]) * signs
    if isinstance(curve, Hermite):
        rows[0, 2:] = _tangents(curve, center[0], size[0], kind) * np.where(flipped, -1.0, 1.0)[:, None]
    breaks = curve.breaks
    free = _has_free_ends(shares)
    found = _levelled(shares @ rows)
    return Segments(center, size, found, breaks[:-1], np.diff(breaks), flipped, free, curve, turned, kind)


def _of_sums(curve: Curve, kind: str) -> Segments:
    """A Bezier curve of any sums, as other curves convert to: moved as multivectors from the frame that it has."""
    rows = np.ascontiguousarray(curve._local.ordinates.reshape(-1, curve.kind.size))
    sums = curve._multivector(rows)
    objects = call(sums.algebra, "blades.project_to_blade", curve._multivector(_along(rows))).value
    controls = parameters_of(objects, kind)
    if controls is None:
        raise SceneError(
            "curve has no real objects at the places that were tried.", remedy="Turn controls over, or add some"
        )
    center, size = (part[0] for part in frames(controls, np.ones((1, len(controls)), bool)))
    local = _seen(sums, center, size)
    frame = curve._controls.frame
    origin = np.zeros(3) if frame is None else np.asarray(frame.origin, np.float64)
    none = np.zeros(len(curve), bool)
    free = not (_is_blade(local[0]) and _is_blade(local[-1]))
    coefficients = _levelled(embedded(local, local.algebra.kind(kind))[None])
    start, length = np.zeros(1), np.ones(1)
    return Segments((origin + center)[None], size[None], coefficients, start, length, none, free, curve, none, kind)


def _needed(members: NDArray[np.intp], shares: Array) -> tuple[NDArray[np.intp], Array]:
    """Without the controls that no coefficient of a piece takes anything from, of as many for each piece."""
    used = (np.abs(shares) > NO_SHARE).any(axis=1)
    most = int(used.sum(axis=1).max())
    if most == used.shape[1]:
        return members, shares
    first = np.argsort(~used, axis=1, kind="stable")[:, :most]
    return np.take_along_axis(members, first, 1), np.take_along_axis(shares, first[:, None, :], 2)


def _has_free_ends(shares: Array) -> bool:
    """Whether some piece does not begin and end with one control, of any weight."""
    return bool((np.count_nonzero(shares[:, [0, -1]], axis=2) != 1).any())


def _is_blade(x: Multivector) -> bool:
    square = x * ~x
    quad = np.abs(square.grade(4).values).max(initial=0.0)
    return bool(quad <= BLADE_ROUNDING * np.finfo(np.float64).eps * np.abs(square.grade(0).values).max(initial=0.0))


def _seen(x: Multivector, center: Array, size: Any) -> Multivector:
    """Any multivectors, seen from a frame."""
    algebra = x.algebra
    moved: Multivector = algebra.dilator(1 / size) >> (~algebra.translator(center) >> x.astype(np.float64))
    return moved


def _tangents(curve: Hermite, center: Array, size: Any, kind: str) -> Array:
    """Coefficients (2, 10) of the tangents as given: differences of objects keep their digits far away."""
    rows = []
    for tangent in curve.given_tangents:
        if isinstance(tangent, Multivector):
            rows.append(embedded(_seen(tangent, center, size), tangent.algebra.kind(kind)).reshape(WIDTH))
        else:
            ends = read_controls([tangent["from"], tangent["to"]], kind).coefficients(center, size)
            rows.append(float(tangent.get("scale", 1.0)) * (ends[1] - ends[0]))
    return np.array(rows)


def _levelled(controls: Array) -> Array:
    """Pieces of extreme weights times a power of two: the objects are the same, and powers of them are numbers."""
    exponent = np.frexp(np.abs(controls).max(axis=(1, 2)))[1]
    extreme = np.abs(exponent) > ORDINARY
    return np.ldexp(controls, np.where(extreme, -exponent, 0)[:, None, None]) if extreme.any() else controls


def _along(rows: Array) -> Array:
    """Sums at some places of one piece with these Bernstein coefficients."""
    return np.ascontiguousarray(bernstein(len(rows) - 1, np.linspace(0.0, 1.0, PLACES)) @ rows)


def _plural(kind: str) -> str:
    return kind.replace("_", " ") + "s"
