"""What poses are asked for, batch by batch: how far driven joints go, and items that are no numbers left out."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..calls import call
from ..codegen.errors import InputError, ShapeError
from ..dynamics.given import of_algebra, shown
from ..dynamics.pins import is_turn
from ..multivector import Multivector
from .local import SLIDE

if TYPE_CHECKING:
    from .mechanism import Mechanism
    from .solving import Poses

Array = NDArray[Any]


def common_shape(*shapes: Mapping[str, tuple[int, ...]]) -> tuple[int, ...]:
    """The shape of a batch that these make together, each by what has it."""
    named = {name: shape for some in shapes for name, shape in some.items()}
    try:
        return np.broadcast_shapes((), *named.values())
    except ValueError:
        told = ", ".join(f"{name} {shape}" for name, shape in named.items() if shape)
        raise ShapeError(f"these batches do not go together: {told}.") from None


def filled(values: Array, bad: Array, path: bool) -> Array:
    """Values (..., k) without those of bad items: of a path, what comes before, or the first good one."""
    if not bad.any():
        return values
    if not path:
        return np.where(bad[..., None], 0.0, values)
    steps = np.arange(bad.shape[-1])
    before = np.maximum.accumulate(np.where(bad, -1, steps), -1)
    index = np.where(before < 0, np.argmin(bad, -1)[..., None], before)
    found = np.take_along_axis(values, index[..., None], -2)
    return np.where(np.isfinite(found), found, 0.0)


def motors_of(mechanism: Mechanism, x: Any, what: str) -> Array:
    """Coefficients (..., 8) of motors, NaN where an item is not finite."""
    algebra = mechanism.algebra
    kind = algebra.kind("motor")
    if not isinstance(x, Multivector):
        raise InputError(f"{what} is {shown(x)}; a motor of {algebra.name} is needed.")
    bad = ~np.isfinite(x.values).all(-1)
    clean = algebra.scalar(1.0) if bad.all() else x
    if bad.any() and not bad.all():
        clean = x.algebra.wrap(x.kind.layout, np.where(bad[..., None], x.values[~bad][0], x.values))
    values = np.array(np.broadcast_to(of_algebra(clean, algebra, what).as_kind("motor").values, (*x.shape, kind.size)))
    values[bad] = np.nan
    return values


def way_to(mechanism: Mechanism, joint: int, begin: Poses | None, values: Array, path: bool) -> Array:
    """How far a joint's coordinates (..., f) go, in the mechanism's units, from the item before along a path: one
    turn and one slide add up, of other joints motions are followed along a screw."""
    relation = mechanism.loops.relations[joint]
    own = values / relation.speeds
    count = own.shape[-1]
    first = np.zeros(count) if begin is None else begin.coordinates(mechanism.joints[joint]) / relation.speeds
    first = np.where(np.isfinite(first), first, 0.0)
    if count > 2:
        return _screws(mechanism, relation.free, own, first, path) if path or begin is not None else own
    ways = own - first
    if begin is not None:  # the short way round
        turns = np.abs(relation.free[is_turn(mechanism.algebra)]).max(0) > SLIDE
        whole = np.where(turns, np.round(ways / (2 * np.pi)), 0.0)
        ways = ways - 2 * np.pi * (whole[..., :1, :] if path and whole.ndim > 1 else whole)
    if path:
        ways[..., 1:, :] = np.diff(ways, axis=-2)
    return np.asarray(ways)


def _screws(mechanism: Mechanism, free: Array, own: Array, first: Array, path: bool) -> Array:
    """Coordinates (..., f) of the twists that take a joint from one place to the next."""
    algebra = mechanism.algebra
    kinds = algebra.kind("motor"), algebra.kind("twist")
    rest = np.zeros(8)
    rest[kinds[0].blades.index(0)] = 1

    def motors(coordinates: Array) -> Multivector:
        twists = np.ascontiguousarray(coordinates @ free.T)
        ones = np.broadcast_to(rest, (*twists.shape[:-1], 8)).copy()
        moved: Multivector = call(
            algebra, "joints.stepped", algebra.wrap(kinds[1], twists), algebra.wrap(kinds[0], ones)
        ).value
        return moved

    before = np.broadcast_to(first, own.shape).copy()
    if path:
        before[..., 1:, :] = own[..., :-1, :]
    twists = call(algebra, "joints.way", motors(before), motors(own)).value
    return np.asarray(twists.values @ np.linalg.pinv(free).T)
