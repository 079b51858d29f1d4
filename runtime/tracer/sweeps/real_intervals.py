"""Intervals where the objects of evolved surfaces are real, filled into their rows of parameters.

Errors name the surface, the interval, and the control whose reversal is a remedy.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.programs.tracer.surfaces.kind import SurfaceKind
from ...errors import SceneError
from .imaginary_gaps import EPSILON, ROUNDING, Gaps, imaginary_gaps
from .local_segments import CONTROLS, LENGTH, NOTHING, SPANS, START, WIDTH, Segments, local_segments

Array = NDArray[np.float64]
#: Largest number of real intervals of a row.
MOST_SPANS = (SPANS.stop - SPANS.start) // 2
#: Largest coefficient of a piece, also relative to those of its ends: twelfth powers of it do not overflow.
MOST_UNEVEN = 1e20
#: Largest number of intervals that a message lists.
MOST_LISTED = 3
#: Largest number of controls of a surface all of whose reversals are tried for the remedy; beyond it, the piece's own.
MAX_TRIED = 12
#: Remedy where the controls are not known.
DEFAULT_REMEDY = "Flip the orientation of the control that opposes its predecessor (align = true does)"
_MEMBER = re.compile(r"evolved_(?P<object>circle|point_pair)s(?P<free>_free)?_\d+")


def surface_label(index: int, surface: Any) -> str:
    """Label of a surface of a scene in messages: its index, and its name if it has one."""
    name = getattr(surface, "name", None)
    return f"surfaces[{index}]" + (f" ({name!r})" if name else "")


@dataclass(frozen=True, eq=False)
class RowContext:
    """Rows of parameters and the surfaces that they belong to, for messages."""

    kind: str
    rows: Array
    ids: NDArray[Any]
    surfaces: Sequence[Any] | None

    def name(self, row: int) -> str:
        """Label of the surface of a row."""
        number = int(self.ids[row])
        return surface_label(number, None if self.surfaces is None else self.surfaces[number])

    def segments(self, row: int) -> Segments | None:
        """Curve of the surface of a row."""
        return None if self.surfaces is None else getattr(self.surfaces[int(self.ids[row])], "segments", None)

    def piece(self, row: int) -> int:
        """Index of a row among those of its surface."""
        return row - int(np.argmax(self.ids == self.ids[row]))

    def alpha(self, row: int, low: float, high: float) -> tuple[float, float]:
        """Convert an interval of a piece to parameters of the curve."""
        start, length = self.rows[row, [START, LENGTH]].tolist()
        return start + length * float(low), start + length * float(high)


def with_real_intervals(
    kind: SurfaceKind, parameters: Array, ids: NDArray[Any], surfaces: Sequence[Any] | None = None
) -> Array:
    """Check rows of parameters, and fill in their spans: the intervals where the objects are real.

    Parameters
    ----------
    kind : SurfaceKind
        Member of a family of evolved surfaces.
    parameters : (n, p)
        The first span is the request: (0, 1) for objects that are real everywhere, (2, 2) if gaps are allowed.
    ids : (n,)
        Indices of the surfaces, for messages.
    surfaces : sequence, optional
        All surfaces. Their ``segments`` let messages name the control to flip; their ``name`` appears in messages.

    Raises
    ------
    SceneError
        If objects are imaginary that must be real; if a surface is real nowhere, or in more than four parts of a
        piece; for parameters that are not finite, and for pieces that stay one object.
    """
    object_, free = _family(kind)
    context = RowContext(object_, parameters, ids, surfaces)
    if len(parameters):
        _check_rows(context)
    gaps = imaginary_gaps(parameters[:, CONTROLS], object_, free)
    refused = np.zeros(len(parameters), bool)
    refused[gaps.row[gaps.imaginary]] = True
    refused &= parameters[:, SPANS.start] < 1
    if refused.any():
        raise _imaginary_error(int(np.argmax(refused)), gaps, context)
    result = parameters.copy()
    result[:, SPANS] = (0.0, 1.0, *NOTHING * (MOST_SPANS - 1))
    if len(gaps.row):
        _fill_spans(result, gaps, context)
    return result


def _family(kind: SurfaceKind) -> tuple[str, bool]:
    """Kind of the objects, and whether pieces may begin or end with sums that are not objects."""
    member = _MEMBER.fullmatch(kind.name)
    if member is None:
        raise ValueError(f"{kind.name} does not belong to a family of evolved surfaces")
    return member["object"], bool(member["free"])


def _fill_spans(rows: Array, gaps: Gaps, context: RowContext) -> None:
    """Write the intervals between gaps into rows of parameters.

    Raises
    ------
    SceneError
        For a surface without real intervals, and for a row with too many.
    """
    follows = np.concatenate([[False], gaps.row[1:] == gaps.row[:-1]])
    before = np.where(follows, np.concatenate([[0.0], gaps.high[:-1]]), 0.0)
    last = np.concatenate([~follows[1:], [True]])
    row = np.concatenate([gaps.row, gaps.row[last]])
    low, high = np.concatenate([before, gaps.high[last]]), np.concatenate([gaps.low, np.ones(int(last.sum()))])
    real = low < high
    row, low, high = row[real], low[real], high[real]
    order = np.lexsort((low, row))
    row, low, high = row[order], low[order], high[order]
    rank = np.arange(len(row)) - np.searchsorted(row, row)
    if (rank >= MOST_SPANS).any():
        name = context.name(int(row[np.argmax(rank)]))
        raise SceneError(
            f"{name} is real in more than {MOST_SPANS} parts of one piece of its curve.",
            remedy="Flip the orientation of controls, or split the curve in two",
        )
    rows[gaps.row, SPANS] = NOTHING * MOST_SPANS
    rows[row, SPANS.start + 2 * rank], rows[row, SPANS.start + 2 * rank + 1] = low, high
    some = np.zeros(len(rows), bool)
    some[row] = True
    some |= ~np.isin(np.arange(len(rows)), gaps.row)
    _, first, which = np.unique(context.ids, return_index=True, return_inverse=True)
    alive = np.bincount(which, some, len(first)) > 0
    if not alive.all():
        name = context.name(int(first[np.argmin(alive)]))
        raise SceneError(f"{name} is imaginary everywhere along its curve.", remedy="Flip the orientation of controls")


# -- messages ------------------------------------------------------------------------------------------


def _check_rows(context: RowContext) -> None:
    """Raise for rows that are not finite or too uneven, and for those that stay one object."""
    rows = context.rows
    controls = rows[:, CONTROLS].reshape(len(rows), -1, WIDTH)
    sizes = np.abs(controls).max(axis=2)
    ends, largest = sizes[:, [0, -1]].min(axis=1), sizes.max(axis=1)
    good = np.isfinite(rows).all(axis=1) & (largest <= MOST_UNEVEN) & (ends >= largest / MOST_UNEVEN)
    if not good.all():
        raise SceneError(
            f"{context.name(int(np.argmin(good)))} has parameters that are not finite, or of sizes too different for "
            "its polynomials.",
            remedy="Use radii, tangents and weights of more similar size",
        )
    first = controls[:, :1]
    factor = (controls * first).sum(axis=2, keepdims=True) / (first * first).sum(axis=2, keepdims=True)
    rest = np.abs(controls - factor * first).max(axis=2)
    same = (rest <= ROUNDING * EPSILON * sizes).all(axis=1)
    if same.any():
        row = int(np.argmax(same))
        low, high = context.alpha(row, 0.0, 1.0)
        raise SceneError(
            f"{context.name(row)} stays one object from alpha {low:.6g} to {high:.6g}: its controls there are equal, "
            "or opposite, to rounding; nothing is swept.",
            remedy="Give controls that differ",
        )


def _imaginary_error(row: int, gaps: Gaps, context: RowContext) -> SceneError:
    """Error for the surface of a row with imaginary objects, with a remedy."""
    its = gaps.imaginary & (context.ids[gaps.row] == context.ids[row])
    intervals = zip(gaps.row[its], gaps.low[its], gaps.high[its], strict=True)
    parts = _merge_intervals([context.alpha(int(i), low, high) for i, low, high in intervals])
    listed = " and ".join(f"from {low:.6g} to {high:.6g}" for low, high in parts[:MOST_LISTED])
    more = f" and in {len(parts) - MOST_LISTED} more intervals" if len(parts) > MOST_LISTED else ""
    objects = context.kind.replace("_", " ") + "s"
    segments = context.segments(row)
    remedy = DEFAULT_REMEDY if segments is None else _remedy(segments, context.piece(row), context.kind)
    return SceneError(
        f"{context.name(row)} has imaginary {objects} for alpha {listed}{more}.",
        remedy=f"{remedy}; or set gaps = true",
    )


def _merge_intervals(parts: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
    """Merge adjacent intervals of an ordered list."""
    merged = [parts[0]]
    for low, high in parts[1:]:
        if low <= merged[-1][1]:
            merged[-1] = merged[-1][0], high
        else:
            merged.append((low, high))
    return merged


def _remedy(segments: Segments, piece: int, kind: str) -> str:
    """Controls to flip, if the reversal of one, or of all from one on, makes the surface real everywhere."""
    count = len(segments.flipped)
    aligned = local_segments(segments.curve, kind, align=True).newly_flipped
    near = range(count) if count <= MAX_TRIED else [k % count for k in range(piece - 1, piece + 3)]
    tries = [aligned] if aligned.any() else []
    tries += [np.arange(count) == k for k in near] + [np.arange(count) >= k for k in near if k > 0]
    rows = [segments.with_flipped(which).parameters() for which in tries]
    gaps = imaginary_gaps(np.concatenate(rows)[:, CONTROLS], kind, segments.free)
    bad = np.unique(np.repeat(np.arange(len(rows)), [len(r) for r in rows])[gaps.row[gaps.imaginary]])
    cures = [which for k, which in enumerate(tries) if k not in bad]
    if not cures:
        return "No reversal of one control helps: bring controls nearer to each other, or add some between"
    which = min((np.nonzero(cure)[0] for cure in cures), key=len)
    names = ", ".join(f"controls[{k}]" for k in which)
    by = " (align = true does)" if aligned.any() and np.array_equal(aligned, cures[0]) else ""
    reversal = f"Swap a and b of {names}" if kind == "point_pair" else f"Flip the orientation of {names}"
    return f"{reversal}{by}; this gives a different, real surface"
