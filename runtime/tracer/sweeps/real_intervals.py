"""Rows of parameters of evolved surfaces checked, and filled in with the intervals where their objects are real.

What is refused is told by surface and interval, with the control whose turning over cures it.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.programs.surface_kinds import SurfaceKind
from ..errors import SceneError
from .gaps import EPSILON, ROUNDING, Gaps, imaginary_gaps
from .segments import CONTROLS, LENGTH, NOTHING, SPANS, START, WIDTH, Segments, local_segments

Array = NDArray[np.float64]
#: Real intervals that a row holds.
MOST_SPANS = (SPANS.stop - SPANS.start) // 2
#: The largest coefficient of a piece, and what it is over those of its ends: twelfth powers of that are numbers.
MOST_UNEVEN = 1e20
#: Intervals that a message lists.
SHOWN = 3
#: Controls of a surface up to which every turn is tried for the message; of more those of the piece are.
TRIED = 12
#: What helps where the controls are not known.
TURN_OVER = "Turn over the control that opposes the one before it (align = true does)"
_MEMBER = re.compile(r"evolved_(?P<object>circle|point_pair)s(?P<free>_free)?_\d+")


@dataclass(frozen=True, eq=False)
class Asked:
    """Rows and whose they are, for messages."""

    kind: str
    rows: Array
    ids: NDArray[Any]
    surfaces: Sequence[Any] | None

    def name(self, row: int) -> str:
        """What messages call the surface of a row: by its number, and by its name if it has one."""
        number = int(self.ids[row])
        name = None if self.surfaces is None else getattr(self.surfaces[number], "name", None)
        return f"surfaces[{number}]" + (f" ({name!r})" if name else "")

    def segments(self, row: int) -> Segments | None:
        """The curve of the surface of a row."""
        return None if self.surfaces is None else getattr(self.surfaces[int(self.ids[row])], "segments", None)

    def piece(self, row: int) -> int:
        """Number of a row among those of its surface."""
        return row - int(np.argmax(self.ids == self.ids[row]))

    def alpha(self, row: int, low: float, high: float) -> tuple[float, float]:
        """An interval of a piece as parameters of the curve."""
        start, length = self.rows[row, [START, LENGTH]].tolist()
        return start + length * float(low), start + length * float(high)


def checked(kind: SurfaceKind, parameters: Array, ids: NDArray[Any], surfaces: Sequence[Any] | None = None) -> Array:
    """Rows of parameters with their spans filled in: where the objects are real.

    Parameters
    ----------
    kind : SurfaceKind
        Of a family of evolved surfaces.
    parameters : (n, p)
        The first span says what is asked: (0, 1) that the objects are real all along, (2, 2) that they need not.
    ids : (n,)
        Numbers of the surfaces, for messages.
    surfaces : sequence, optional
        All surfaces, by number. With their ``segments`` messages say which control to turn over; with their ``name``
        they use it.

    Raises
    ------
    SceneError
        Where objects are imaginary that must be real; where a surface is real nowhere, or in more than four
        parts of a piece; for parameters that are not finite, and for pieces that are one object all along.
    """
    object_, free = _family(kind)
    asked = Asked(object_, parameters, ids, surfaces)
    if len(parameters):
        _refuse_bad(asked)
    gaps = imaginary_gaps(parameters[:, CONTROLS], object_, free)
    refused = np.zeros(len(parameters), bool)
    refused[gaps.row[gaps.imaginary]] = True
    refused &= parameters[:, SPANS.start] < 1
    if refused.any():
        raise _imaginary(int(np.argmax(refused)), gaps, asked)
    result = parameters.copy()
    result[:, SPANS] = (0.0, 1.0, *NOTHING * (MOST_SPANS - 1))
    if len(gaps.row):
        _fill(result, gaps, asked)
    return result


def _family(kind: SurfaceKind) -> tuple[str, bool]:
    """Kind of the objects, and whether pieces may end with none."""
    member = _MEMBER.fullmatch(kind.name)
    if member is None:
        raise ValueError(f"{kind.name} is no family of evolved surfaces")
    return member["object"], bool(member["free"])


def _fill(rows: Array, gaps: Gaps, asked: Asked) -> None:
    """The intervals between gaps, written into rows of parameters.

    Raises
    ------
    SceneError
        For a surface without any, and for a row with more than it holds.
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
        name = asked.name(int(row[np.argmax(rank)]))
        raise SceneError(
            f"{name} is real in more than {MOST_SPANS} parts of one piece of its curve.",
            remedy="Turn controls over, or cut the curve in two",
        )
    rows[gaps.row, SPANS] = NOTHING * MOST_SPANS
    rows[row, SPANS.start + 2 * rank], rows[row, SPANS.start + 2 * rank + 1] = low, high
    some = np.zeros(len(rows), bool)
    some[row] = True
    some |= ~np.isin(np.arange(len(rows)), gaps.row)
    _, first, which = np.unique(asked.ids, return_index=True, return_inverse=True)
    alive = np.bincount(which, some, len(first)) > 0
    if not alive.all():
        name = asked.name(int(first[np.argmin(alive)]))
        raise SceneError(f"{name} is imaginary all along its curve.", remedy="Turn controls over")


# -- messages ------------------------------------------------------------------------------------------


def _refuse_bad(asked: Asked) -> None:
    """Raise for rows that are not finite or too uneven, and for those along which there is one object only."""
    rows = asked.rows
    controls = rows[:, CONTROLS].reshape(len(rows), -1, WIDTH)
    sizes = np.abs(controls).max(axis=2)
    ends, largest = sizes[:, [0, -1]].min(axis=1), sizes.max(axis=1)
    good = np.isfinite(rows).all(axis=1) & (largest <= MOST_UNEVEN) & (ends >= largest / MOST_UNEVEN)
    if not good.all():
        raise SceneError(
            f"{asked.name(int(np.argmin(good)))} has parameters that are not finite, or of sizes too unlike for its "
            "polynomials.",
            remedy="Use radii, tangents and weights that are more alike",
        )
    first = controls[:, :1]
    share = (controls * first).sum(axis=2, keepdims=True) / (first * first).sum(axis=2, keepdims=True)
    rest = np.abs(controls - share * first).max(axis=2)
    same = (rest <= ROUNDING * EPSILON * sizes).all(axis=1)
    if same.any():
        row = int(np.argmax(same))
        low, high = asked.alpha(row, 0.0, 1.0)
        raise SceneError(
            f"{asked.name(row)} stays one object from alpha {low:.6g} to {high:.6g}: its controls there are equal, or "
            "opposite, to rounding; nothing is swept.",
            remedy="Give controls that differ",
        )


def _imaginary(row: int, gaps: Gaps, asked: Asked) -> SceneError:
    """What is wrong with the surface of a row, and what would cure it."""
    its = gaps.imaginary & (asked.ids[gaps.row] == asked.ids[row])
    intervals = zip(gaps.row[its], gaps.low[its], gaps.high[its], strict=True)
    parts = _joined([asked.alpha(int(i), low, high) for i, low, high in intervals])
    shown = " and ".join(f"from {low:.6g} to {high:.6g}" for low, high in parts[:SHOWN])
    more = f" and in {len(parts) - SHOWN} more intervals" if len(parts) > SHOWN else ""
    objects = asked.kind.replace("_", " ") + "s"
    segments = asked.segments(row)
    cure = TURN_OVER if segments is None else _cure(segments, asked.piece(row), asked.kind)
    return SceneError(
        f"{asked.name(row)} has imaginary {objects} for alpha {shown}{more}.",
        remedy=f"{cure}; or allow gaps (gaps = true)",
    )


def _joined(parts: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
    """Intervals in order, those that follow on each other as one."""
    joined = [parts[0]]
    for low, high in parts[1:]:
        if low <= joined[-1][1]:
            joined[-1] = joined[-1][0], high
        else:
            joined.append((low, high))
    return joined


def _cure(segments: Segments, piece: int, kind: str) -> str:
    """Which controls to turn over, if turning one, or all from one on, makes the surface real all along."""
    count = len(segments.flipped)
    aligned = local_segments(segments.curve, kind, align=True).turned
    near = range(count) if count <= TRIED else [k % count for k in range(piece - 1, piece + 3)]
    tries = [aligned] if aligned.any() else []
    tries += [np.arange(count) == k for k in near] + [np.arange(count) >= k for k in near if k > 0]
    rows = [segments.with_turned(which).parameters() for which in tries]
    gaps = imaginary_gaps(np.concatenate(rows)[:, CONTROLS], kind, segments.free)
    bad = np.unique(np.repeat(np.arange(len(rows)), [len(r) for r in rows])[gaps.row[gaps.imaginary]])
    cures = [which for k, which in enumerate(tries) if k not in bad]
    if not cures:
        return "No turning of one control cures it: bring controls nearer to each other, or add some between"
    which = min((np.nonzero(cure)[0] for cure in cures), key=len)
    places = ", ".join(f"controls[{k}]" for k in which)
    by = " (align = true does)" if aligned.any() and np.array_equal(aligned, cures[0]) else ""
    over = f"Swap a and b of {places}" if kind == "point_pair" else f"Turn over {places}"
    return f"{over}{by}, which cures it but makes another surface"
