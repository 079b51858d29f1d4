"""Curves of circles and point pairs as polynomial pieces, each in a local frame where its size is about one.

Curves are linear in their controls and commute with translation and scaling: the parameters of controls are moved to
the frame before anything is multiplied, so that a curve 1e6 from the origin keeps the digits of its own size.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.multivector import Multivector
from ...curves import Bezier, Curve, Hermite, Interpolating, RationalBezier
from ...curves.bernstein import bernstein
from ...dispatch.coefficients import embed
from ...dispatch.formulas import evaluate
from ...errors import SceneError
from .control_parameters import ControlParameters, from_numbers, is_opposite, parameters_of, read_controls
from .segment_frames import alternating_flips, local_frames, opposite_neighbors, refuse_one_object

Array = NDArray[np.float64]
#: Columns of a row of parameters: origin of the local frame.
CENTER = slice(0, 3)
#: Columns of the frame's unit of length, and its reciprocal.
UNIT = slice(3, 5)
#: Column of the curve's parameter at the beginning of the piece.
START = 5
#: Column of the length of the piece in the curve's parameter.
LENGTH = 6
#: Columns of the intervals where the objects are real.
SPANS = slice(7, 15)
#: Columns of the Bernstein coefficients.
CONTROLS = slice(15, None)
#: First span of a surface that must be real everywhere.
ALL_REAL = (0.0, 1.0)
#: First span of a surface that may have gaps.
GAPS_ALLOWED = (2.0, 2.0)
#: An empty interval.
NOTHING = (1.0, 0.0)
#: A control counts for the frame of a piece if its weight in some coefficient is this fraction of the largest weight.
NEAR_FRACTION = 0.5
#: Weights of a control below this are less than rounding, whatever its size in the frame.
NEGLIGIBLE = 1e-40
#: Largest grade 4 part of the square of an object, in rounding units of its scalar part.
BLADE_ROUNDING = 1e4
#: Number of samples along a curve of sums that determine its size.
SAMPLES = 9
#: Largest number of objects of an interpolating curve: each piece depends on all of them, which takes quadratic memory.
MOST_INTERPOLATED = 2000
#: Largest ratio of a weight of a rational curve to those of its ends: beyond it rounding hides roots near the ends.
MAX_WEIGHT_RATIO = 1e6
#: Largest binary exponent of coefficients that are not rescaled.
ORDINARY_EXPONENT = 16
#: Number of coefficients of a circle or a point pair.
WIDTH = 10


@dataclass(frozen=True, eq=False)
class Segments:
    """Polynomial pieces of a curve in local frames; t = 0 is a piece's first object.

    Attributes
    ----------
    center : (pieces, 3)
        Origins of the frames.
    size : (pieces,)
        Units of length of the frames.
    controls : (pieces, n + 1, 10)
        Bernstein coefficients of degree n in these frames: C'(t) = sum binom(n, k) t^k (1 - t)^(n - k) C_k. Inner
        ones need not be objects; those of rational curves are weighted.
    starts, lengths : (pieces,)
        The parameter t of a piece in [0, 1] is the curve's parameter ``starts + lengths * t``.
    flipped : (controls,) of bool
        Controls whose orientation was reversed, by the curve itself or here.
    free : bool
        Some piece begins or ends with a sum that is not an object.
    source : Curve or sequence
        The curve, or the sequence of controls.
    newly_flipped : (controls,) of bool
        Controls whose orientation was reversed here.
    kind : {"circle", "point_pair"}
    """

    center: Array
    size: Array
    controls: Array
    starts: Array
    lengths: Array
    flipped: NDArray[np.bool_]
    free: bool
    source: Curve | Sequence[Any]
    newly_flipped: NDArray[np.bool_]
    kind: str

    @cached_property
    def curve(self) -> Curve:
        """The curve that the surface follows: `source`, with the orientation of `newly_flipped` controls reversed."""
        curve = self.source if isinstance(self.source, Curve) else Bezier(self.source)
        return curve.with_flipped_controls(self.newly_flipped) if self.newly_flipped.any() else curve

    def with_flipped(self, which: NDArray[np.bool_]) -> Segments:
        """The pieces of the curve with the orientation of further controls (controls,) reversed."""
        return local_segments(self.curve.with_flipped_controls(which), self.kind, align=False)

    def parameters(self, gaps: bool = False) -> Array:
        """Rows of parameters of an evolved surface (pieces, 15 + 10 (n + 1)), one for each piece."""
        count = len(self.controls)
        rows = np.empty((count, CONTROLS.start + self.controls[0].size))
        rows[:, CENTER], rows[:, UNIT.start], rows[:, UNIT.stop - 1] = self.center, self.size, 1 / self.size
        rows[:, START], rows[:, LENGTH] = self.starts, self.lengths
        rows[:, SPANS] = (*(GAPS_ALLOWED if gaps else ALL_REAL), *NOTHING, *NOTHING, *NOTHING)
        rows[:, CONTROLS] = self.controls.reshape(count, -1)
        return rows


def local_segments(curve: Any, kind: str, align: bool = False) -> Segments:
    """Split a curve of circles or point pairs into polynomial pieces.

    Parameters
    ----------
    curve : Curve, Multivector (n,), array (n, 10), or sequence
        Controls define a Bezier curve. They are objects, their coefficients, or parameters:
        (center, normal, radius) of a circle, (a, b) of a point pair, as tuples or mappings.
    kind : {"circle", "point_pair"}
    align : bool
        Reverse the orientation of controls that oppose their predecessor.

    Raises
    ------
    SceneError
        For a curve of other objects, and controls that are not valid.
    """
    if not isinstance(curve, Curve):
        return _from_sequence(curve, kind, align)
    from ...core.registry import stock_algebra

    actual = curve.kind
    if actual.algebra is not stock_algebra("cga3d") or not set(actual.blades) <= set(actual.algebra.kind(kind).blades):
        raise SceneError(f"curve is one of {_plural(actual.name)}; this surface follows {_plural(kind)}.")
    if not actual.constraints:
        return _from_sums(curve, kind)
    return _from_sequence(curve, kind, align) if isinstance(curve, Bezier) else _from_curve(curve, kind, align)


def _from_sequence(source: Any, kind: str, align: bool) -> Segments:
    """Split a Bezier curve: its controls are its coefficients."""
    curve = source if isinstance(source, Curve) else None
    controls = read_controls(source if curve is None else curve.original_controls, kind)
    if len(controls) < 2:
        raise SceneError(f"a curve needs at least 2 controls, not {len(controls)}.")
    refuse_one_object(controls)
    flipped = np.zeros((1, len(controls)), bool) if curve is None else curve.flipped[None]
    return _from_rows(controls, [source], flipped, np.array([align]))[0]


def bezier_segments(source: Sequence[Sequence[Any]], kind: str, align: NDArray[np.bool_]) -> list[Segments] | None:
    """Split Bezier curves of plain parameters, with equally many controls, together; None if one of them is not valid.

    Files have thousands of curves, and calls on a few numbers cost more than their arithmetic.
    """
    controls = from_numbers([control for curve in source for control in curve], kind)
    count = len(source[0])
    if controls is None or count < 2:
        return None
    rows = controls.rows.reshape(len(source), count, -1)
    if (rows == rows[:, :1]).all(axis=(1, 2)).any():
        return None
    return _from_rows(controls, source, np.zeros((len(source), count), bool), align)


def _from_rows(
    controls: ControlParameters, source: Sequence[Any], flipped: NDArray[np.bool_], align: NDArray[np.bool_]
) -> list[Segments]:
    """Split Bezier curves from their consecutive controls; ``flipped`` (curves, count) are flips by the curves."""
    curves, count = flipped.shape
    members = np.arange(curves * count).reshape(curves, count)
    center, size = local_frames(controls, np.ones((curves, count), bool), members)
    moved = controls.coefficients(np.repeat(center, count, axis=0), np.repeat(size, count))
    rows = moved.reshape(curves, count, WIDTH)
    rows[flipped] *= -1
    first, second = (rows[:, at].reshape(-1, WIDTH) for at in (slice(0, -1), slice(1, None)))
    against = is_opposite(controls.kind, first, second).reshape(curves, count - 1)
    flips = alternating_flips(against & align[:, None])
    rows[flips] *= -1
    start, length = np.zeros(1), np.ones(1)
    return [
        Segments(center[i : i + 1], size[i : i + 1], rows[i : i + 1], start, length, flipped[i] ^ flips[i], False,
                 source[i], flips[i], controls.kind)
        for i in range(curves)
    ]  # fmt: skip


def _from_curve(curve: Curve, kind: str, align: bool) -> Segments:
    """Split a curve of unit objects: blend the controls in the local frame of each piece."""
    if isinstance(curve, Interpolating) and len(curve) > MOST_INTERPOLATED:
        raise SceneError(
            f"the curve interpolates {len(curve)} objects; surfaces follow up to {MOST_INTERPOLATED}.",
            remedy="Split it, or use a Kochanek-Bartels curve",
        )
    if isinstance(curve, RationalBezier) and curve.weights[[0, -1]].min() * MAX_WEIGHT_RATIO < curve.weights.max():
        raise SceneError(
            f"the weights at the ends of the curve, {curve.weights[0]:g} and {curve.weights[-1]:g}, are too "
            f"small beside {curve.weights.max():g}.",
            remedy=f"Use end weights of at least the {1 / MAX_WEIGHT_RATIO:g}th part of the largest",
        )
    controls = read_controls(curve.original_controls, kind)
    refuse_one_object(controls)
    newly_flipped = np.zeros(len(controls), bool)
    if align:
        newly_flipped = alternating_flips(opposite_neighbors(controls) ^ curve.flipped[:-1] ^ curve.flipped[1:])
    flipped = curve.flipped ^ newly_flipped
    members, blending = _drop_unused(*curve.blending())
    sizes = np.abs(blending)
    objects = members < len(controls)  # the others are tangents
    near = (sizes >= NEAR_FRACTION * sizes.max(axis=2, keepdims=True)).any(axis=1) & objects
    center, size = local_frames(controls, near, np.where(objects, members, 0))
    rows = np.empty((*members.shape, WIDTH))
    piece, slot = np.nonzero(objects)
    which = members[piece, slot]
    signs = np.where(flipped, -1.0, 1.0)[which, None]
    rows[piece, slot] = controls.take(which).coefficients(center[piece], size[piece]) * signs
    if isinstance(curve, Hermite):
        rows[0, 2:] = _tangents(curve, center[0], size[0], kind) * np.where(flipped, -1.0, 1.0)[:, None]
    breaks = curve.breaks
    free = _has_free_ends(blending)
    coefficients = _normalize_exponents(blending @ rows)
    return Segments(center, size, coefficients, breaks[:-1], np.diff(breaks), flipped, free, curve, newly_flipped, kind)


def _from_sums(curve: Curve, kind: str) -> Segments:
    """Split a Bezier curve of arbitrary sums, as other curves convert to: multivectors in the curve's own frame."""
    rows = np.ascontiguousarray(curve._local.ordinates.reshape(-1, curve.kind.size))
    sums = curve._multivector(rows)
    objects = evaluate(sums.algebra, "blades.project_to_blade", curve._multivector(_sample_curve(rows))).value
    controls = parameters_of(objects, kind)
    if controls is None:
        raise SceneError(
            "curve has no real objects at any sample.", remedy="Flip the orientation of controls, or add some"
        )
    center, size = (part[0] for part in local_frames(controls, np.ones((1, len(controls)), bool)))
    local = _to_frame(sums, center, size)
    frame = curve._controls.frame
    origin = np.zeros(3) if frame is None else np.asarray(frame.origin, np.float64)
    none = np.zeros(len(curve), bool)
    free = not (_is_blade(local[0]) and _is_blade(local[-1]))
    coefficients = _normalize_exponents(embed(local, local.algebra.kind(kind))[None])
    start, length = np.zeros(1), np.ones(1)
    return Segments((origin + center)[None], size[None], coefficients, start, length, none, free, curve, none, kind)


def _drop_unused(members: NDArray[np.intp], blending: Array) -> tuple[NDArray[np.intp], Array]:
    """Drop controls without weight in a piece; equally many remain for each piece."""
    used = (np.abs(blending) > NEGLIGIBLE).any(axis=1)
    most = int(used.sum(axis=1).max())
    if most == used.shape[1]:
        return members, blending
    first = np.argsort(~used, axis=1, kind="stable")[:, :most]
    return np.take_along_axis(members, first, 1), np.take_along_axis(blending, first[:, None, :], 2)


def _has_free_ends(blending: Array) -> bool:
    """Test whether some piece does not begin and end with a single weighted control."""
    return bool((np.count_nonzero(blending[:, [0, -1]], axis=2) != 1).any())


def _is_blade(x: Multivector) -> bool:
    square = x * ~x
    quad = np.abs(square.grade(4).values).max(initial=0.0)
    return bool(quad <= BLADE_ROUNDING * np.finfo(np.float64).eps * np.abs(square.grade(0).values).max(initial=0.0))


def _to_frame(x: Multivector, center: Array, size: Any) -> Multivector:
    """Express multivectors in a frame."""
    algebra = x.algebra
    moved: Multivector = algebra.dilator(1 / size) >> (~algebra.translator(center) >> x.astype(np.float64))
    return moved


def _tangents(curve: Hermite, center: Array, size: Any, kind: str) -> Array:
    """Coefficients (2, 10) of the tangents as given: differences of objects keep their digits far from the origin."""
    rows = []
    for tangent in curve.original_tangents:
        if isinstance(tangent, Multivector):
            rows.append(embed(_to_frame(tangent, center, size), tangent.algebra.kind(kind)).reshape(WIDTH))
        else:
            ends = read_controls([tangent["from"], tangent["to"]], kind).coefficients(center, size)
            rows.append(float(tangent.get("scale", 1.0)) * (ends[1] - ends[0]))
    return np.array(rows)


def _normalize_exponents(controls: Array) -> Array:
    """Scale pieces of extreme weights by a power of two: the same objects, and their powers do not overflow."""
    exponent = np.frexp(np.abs(controls).max(axis=(1, 2)))[1]
    extreme = np.abs(exponent) > ORDINARY_EXPONENT
    return np.ldexp(controls, np.where(extreme, -exponent, 0)[:, None, None]) if extreme.any() else controls


def _sample_curve(rows: Array) -> Array:
    """Sample one piece with these Bernstein coefficients."""
    return np.ascontiguousarray(bernstein(len(rows) - 1, np.linspace(0.0, 1.0, SAMPLES)) @ rows)


def _plural(kind: str) -> str:
    return kind.replace("_", " ") + "s"
