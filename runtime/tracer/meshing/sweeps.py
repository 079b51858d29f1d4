"""Objects along the curve of an evolved surface, in the local frames of its pieces: where meshes put their rows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...calls import call
from ...codegen.programs.surface_kinds import surface_kind
from ...curves.basis import bernstein
from ...errors import SceneError
from ...loading import stock_algebra
from ...multivector import Multivector
from ...status import Status
from ...typed import F64
from ..segments import SPANS
from ..spans import checked

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
#: Where objects end in a gap they shrink to nothing; rows begin at this share of the interval inside.
GAP_MARGIN = 1e-9
_ANSWERS = (int(Status.OK), int(Status.NOT_UNIQUE))


@dataclass(frozen=True, eq=False)
class Sweep:
    """Unit objects along a curve, one for each row of a mesh.

    Attributes
    ----------
    objects, rates : Multivector (rows,)
        Objects in the frame of their piece, and their derivatives.
    alpha : (rows,) array
        The curve's parameter.
    center, size : (rows, 3) and (rows,) arrays
        Origins and units of the frames.
    run : (rows,) array of int
        Rows of one number are connected.
    joined : (runs,) array of bool
        Whether a run begins where the one before ends.
    """

    objects: Multivector
    rates: Multivector
    alpha: Array
    center: Array
    size: Array
    run: Integers
    joined: NDArray[np.bool_]

    def refuse(self, bad: NDArray[np.bool_], what: str, remedy: str) -> None:
        """Raise for the first rows that are bad, naming the interval of the parameter around them."""
        if not bad.any():
            return
        first = int(bad.argmax())
        last = first + int((~bad[first:]).argmax() if not bad[first:].all() else len(bad) - first) - 1
        low, high = self.alpha[max(first - 1, 0)], self.alpha[min(last + 1, len(bad) - 1)]
        raise SceneError(f"the surface has {what} between alpha = {low:.6g} and {high:.6g}", remedy=remedy)


def sweep(surface: Any, kind: str, bands: int) -> Sweep:
    """Rows along the curve of an evolved surface, ``bands`` intervals at least; pieces have as many each.

    Raises
    ------
    SceneError
        If there are no real objects on the way, and the surface allows no gaps.
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
    found = call(algebra, "blades.project_sum", sums, multivector(sizes))
    rate = call(algebra, "blades.project_rate", sums, multivector(rates.reshape(rows.shape))).value
    objects = Multivector._make(algebra.type_of(algebra.kind(kind), F64), found.value._data, sums.shape)
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
    if found.status is not None:
        objects_ = kind.replace("_", " ") + "s"
        bad = ~np.isin(found.status, _ANSWERS)  # where they are real: spans say so
        what = f"{objects_} of which rounding leaves nothing, small or light as they are beside others of their piece,"
        swept.refuse(bad, what, "Make them more alike, or let a piece of the curve end before them")
    return swept


def _runs(surface: Any) -> tuple[Integers, Array, Array, NDArray[np.bool_]]:
    """Pieces, the intervals of their parameter where there are objects, and which begin where the one before ends."""
    count = len(surface.segments.controls)
    kind = surface_kind(surface.program_kind)
    rows = checked(kind, surface.parameters, np.zeros(count, np.int32), [surface])
    spans = rows[:, SPANS].reshape(count, -1, 2)
    piece, which = np.nonzero(spans[..., 0] < spans[..., 1])
    low, high = spans[piece, which].T
    joined = np.concatenate([[False], (low[1:] == 0) & (high[:-1] == 1) & (np.diff(piece) == 1)])
    margin = GAP_MARGIN * (high - low)
    return piece, np.where(low > 0, low + margin, low), np.where(high < 1, high - margin, high), joined


__all__ = ["Sweep", "sweep"]
