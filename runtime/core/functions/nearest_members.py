"""The member of a kind that is nearest to given coefficients, and how far that is: Newton's steps on the constraints.

Objects from elsewhere carry the rounding of what made them. Coefficients are compared in a unit of length in which the
object is about one away from the origin, so that those of n0, n_inf and the others weigh alike.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.algebra.algebra import Kind
from ...dispatch.coefficients import embed
from ...dispatch.multivector_data import MultivectorData
from ..kind_constraints import quadratic_constraints

Array = NDArray[np.float64]
#: Steps square the distance: three suffice from 1e-2.
STEPS = 6
#: Constraints depend on each other: directions in which they change less than this are noise of the others.
DEPENDENT = 1e-3
#: Steps below this, relative, change nothing any more.
ROUNDED = 4 * float(np.finfo(np.float64).eps)
#: So many items go through a step together.
CHUNK = 4096


def nearest_member(start: MultivectorData, kind: Kind) -> Array:
    """Rows of the kind near ``start`` (n,), which is scaled to it; they hold its constraints where that converges."""
    rows = embed(start, kind).astype(np.float64)
    units = unit_weights(rows, kind.algebra, kind.blades)
    for begin in range(0, len(rows), CHUNK):
        part = slice(begin, begin + CHUNK)
        rows[part] = _project_to_constraints(rows[part], units[part], kind)
    return rows


def distance(x: MultivectorData, y: MultivectorData) -> Array:
    """Distance of items (n,) from the members that were computed for them, up to scale.

    The largest change of a coefficient relative to the largest coefficient, both in the unit of length of the result.
    """
    algebra = x.algebra
    every = algebra.layout_of({*x._type.blades, *y._type.blades})
    a, b = (embed(v, every).astype(np.float64) for v in (x, y))
    weights = unit_weights(b, algebra, every.blades)
    a, b = a * weights, b * weights
    with np.errstate(all="ignore"):
        scale = (a * b).sum(-1, keepdims=True) / (a * a).sum(-1, keepdims=True)
        return np.asarray(np.abs(scale * a - b).max(-1) / np.abs(b).max(-1))


def spread(x: MultivectorData, kind: Kind) -> Array:
    """Distance of items (n,) of a kind that a change of every coefficient by the largest one makes."""
    rows = np.abs(embed(x, kind)).astype(np.float64)
    weights = unit_weights(rows, kind.algebra, kind.blades)
    with np.errstate(all="ignore"):
        return np.asarray(rows.max(-1) * weights.max(-1) / (rows * weights).max(-1))


def unit_weights(rows: Array, algebra: Any, blades: Sequence[int]) -> Array:
    """Factors of the coefficients that change the unit of length to the items' distance from the origin, or to one."""
    from ...codegen.formulas.objects.subspaces import length_powers  # brings the tracer of formulas: when it is needed

    powers = np.array(length_powers(algebra, tuple(int(b) for b in blades)))
    low, level, high = (np.abs(rows[:, powers == p]).max(-1, initial=0.0) for p in (-1, 0, 1))
    with np.errstate(all="ignore"):
        length = np.where(low > 0, np.sqrt(high / low), np.where(level > 0, high / level, 1.0))
    length = np.clip(np.where(np.isfinite(length), length, 1.0), 1.0, None)
    return np.asarray(length[:, None] ** -powers.astype(float))


def _project_to_constraints(x: Array, weights: Array, kind: Kind) -> Array:
    form = quadratic_constraints(kind)
    table = form.quadratic
    column = np.repeat(np.arange(len(form.constant)), np.diff(table.starts))
    for _ in range(STEPS):
        slopes = np.broadcast_to(form.linear.T, (len(x), *form.linear.T.shape)).copy()
        flat = slopes.reshape(len(x), -1)
        for own, other in ((table.left, table.right), (table.right, table.left)):
            np.add.at(flat.T, column * kind.size + own, (x[:, other] * table.weights).T)
        slopes /= weights[:, None, :]
        length = np.linalg.norm(slopes, axis=-1)
        usable = np.isfinite(slopes).all((-1, -2))
        slopes[~usable] = 0
        scale = np.where(length > 0, length, 1.0)
        step = (np.linalg.pinv(slopes / scale[..., None], rcond=DEPENDENT) @ (form.at(x) / scale)[..., None])[..., 0]
        large = np.abs(step).max(-1) > ROUNDED * np.abs(x * weights).max(-1)
        x = x - step / weights
        if not (large & usable).any():
            break
    return x
