"""Unit objects along the curve of an evolved surface, in the local frames of its pieces: the rows of a mesh."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.programs.tracer.surface_kinds import surface_kind
from ...common.dtypes import F64
from ...core.multivector import Multivector
from ...core.registry import stock_algebra
from ...curves.bernstein import bernstein
from ...dispatch.formulas import evaluate
from ...errors import SceneError
from ...status import Status
from ..sweeps.local_segments import SPANS
from ..sweeps.real_intervals import with_real_intervals

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
#: Distance of the first row from a gap, where objects shrink to nothing, as a fraction of the interval.
GAP_MARGIN = 1e-9
#: Statuses of projected sums that are valid.
_VALID = (int(Status.OK), int(Status.NOT_UNIQUE))


@dataclass(frozen=True, eq=False)
class Sweep:
    """Unit objects along a curve, one for each row of a mesh.

    Attributes
    ----------
    objects, rates : Multivector (rows,)
        Objects in the frame of their piece, and their derivatives.
    alpha : (rows,) array
        Parameter of the curve.
    center, size : (rows, 3) and (rows,) arrays
        Origins and units of the frames.
    run : (rows,) array of int
        Rows with the same number are connected.
    joined : (runs,) array of bool
        A run begins where the previous one ends.
    """

    objects: Multivector
    rates: Multivector
    alpha: Array
    center: Array
    size: Array
    run: Integers
    joined: NDArray[np.bool_]

    def refuse(self, bad: NDArray[np.bool_], what: str, remedy: str) -> None:
        """Raise for the first invalid rows, with the interval of the parameter around them."""
        if not bad.any():
            return
        first = int(bad.argmax())
        last = first + int((~bad[first:]).argmax() if not bad[first:].all() else len(bad) - first) - 1
        low, high = self.alpha[max(first - 1, 0)], self.alpha[min(last + 1, len(bad) - 1)]
        raise SceneError(f"the surface has {what} between alpha = {low:.6g} and {high:.6g}", remedy=remedy)


def sweep(surface: Any, kind: str, bands: int) -> Sweep:
    """Sample the curve of an evolved surface at rows with at least ``bands`` intervals, equally many in each piece.

    Raises
    ------
    SceneError
        If objects are imaginary, and the surface does not allow gaps.
    """
    segments = surface.segments
    piece, low, high, joined = _runs(surface)
    count = -(-bands // len(piece))
    t = low[:, None] + (high - low)[:, None] * np.linspace(0.0, 1.0, count + 1)
    controls = segments.controls[piece]
    degree = controls.shape[1] - 1
    basis = bernstein(degree, t)
    rows, sizes = (np.einsum("rkj,rjc->rkc", basis, c).reshape(-1, c.shape[-1]) for c in (controls, np.abs(controls)))
    rates = np.einsum("rkj,rjc->rkc", bernstein(degree - 1, t), degree * np.diff(controls, axis=1))
    algebra = stock_algebra("cga3d")
    layout = algebra.type_of(algebra.kind(kind).layout, F64)

    def multivector(data: Array) -> Multivector:
        return Multivector._make(layout, np.ascontiguousarray(data), data.shape[:1])

    sums = multivector(rows)
    unit = evaluate(algebra, "blades.project_sum", sums, multivector(sizes))
    rate = evaluate(algebra, "blades.project_rate", sums, multivector(rates.reshape(rows.shape))).value
    objects = Multivector._make(algebra.type_of(algebra.kind(kind), F64), unit.value._data, sums.shape)
    each = np.repeat(piece, count + 1)
    swept = Sweep(
        objects,
        rate,
        (segments.starts[piece, None] + segments.lengths[piece, None] * t).reshape(-1),
        segments.center[each],
        segments.size[each],
        np.repeat(np.arange(len(piece)), count + 1),
        joined,
    )
    if unit.status is not None:
        plural = kind.replace("_", " ") + "s"
        bad = ~np.isin(unit.status, _VALID)  # where they are real: spans say so
        what = f"{plural} that are lost to rounding, because they are small or light beside others of their piece,"
        swept.refuse(bad, what, "Use objects of more similar size, or end a piece of the curve before them")
    return swept


def _runs(surface: Any) -> tuple[Integers, Array, Array, NDArray[np.bool_]]:
    """Pieces, the intervals of their parameter with real objects, and which begin where their predecessor ends."""
    count = len(surface.segments.controls)
    kind = surface_kind(surface.program_kind)
    rows = with_real_intervals(kind, surface.parameters, np.zeros(count, np.int32), [surface])
    spans = rows[:, SPANS].reshape(count, -1, 2)
    piece, which = np.nonzero(spans[..., 0] < spans[..., 1])
    low, high = spans[piece, which].T
    joined = np.concatenate([[False], (low[1:] == 0) & (high[:-1] == 1) & (np.diff(piece) == 1)])
    margin = GAP_MARGIN * (high - low)
    return piece, np.where(low > 0, low + margin, low), np.where(high < 1, high - margin, high), joined
