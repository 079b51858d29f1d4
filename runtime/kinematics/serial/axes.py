"""Axes of serial chains: twists of joints from positions and directions, and the parameters of the driver."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...codegen.errors import AlgebraMismatchError, GradeError, InputError, ShapeError
from ...common.validation import as_bool, check_shape, finite_array, invalid, real_array
from ...core.geometry.euclidean import plain
from ...core.multivector import Multivector
from ...dispatch.coefficients import embed
from ...dispatch.formulas import ArrayOperand as Operand
from ...dispatch.formulas import evaluate
from ...dispatch.item_statuses import invalidate_nonfinite, raise_first
from ...mechanics.arguments import frozen_copy
from ...mechanics.screws import as_screw, geometry
from .driver import ChainParameters

if TYPE_CHECKING:
    from ...core.multivector import Algebra

Array = NDArray[Any]
#: An advance by a radian is a rounding error up to this fraction of the axis's distance from the origin; so is what is
#: between axes that meet.
ROUNDING = 32 * np.finfo(float).eps


# -- making ------------------------------------------------------------------------------------------------


def revolute_axis(
    position: ArrayLike, direction: ArrayLike, algebra: Algebra | None = None, *, strict: bool = False
) -> Multivector:
    """The twist a I3 + (p x a) n of a rotation by one radian, counter-clockwise about a line.

    Parameters
    ----------
    position, direction : array (..., 3)
        A point of the line, and a vector along it of any length.
    algebra : Algebra, optional
        `bladesmith.cga3d` (default) or `pga3d`.

    Returns
    -------
    Multivector of twists (...)
        In CGA the dual of the unit line, in PGA the unit line itself. INVALID: the direction is zero.
    """
    return _axis("axis_through", algebra, strict, position=position, direction=direction)


def prismatic_axis(direction: ArrayLike, algebra: Algebra | None = None, *, strict: bool = False) -> Multivector:
    """The twist a n of a translation by one unit of length along a direction (..., 3) of any length. INVALID: zero."""
    return _axis("translation_along", algebra, strict, direction=direction)


def screw_axis(
    position: ArrayLike, direction: ArrayLike, pitch: ArrayLike, algebra: Algebra | None = None, *, strict: bool = False
) -> Multivector:
    """The twist of a screw: as `revolute_axis`, with an advance along the line of ``pitch`` (...) for each radian."""
    home = geometry(algebra)
    return _axis(
        "screw_through", home, strict, Operand(pitch, 0, "pitch"), position=position, direction=direction
    )  # fmt: skip


def _axis(formula: str, algebra: Algebra | None, strict: bool, *more: Operand, **vectors: ArrayLike) -> Multivector:
    home = geometry(algebra)
    operands = [Operand(value, home.kind("euclidean"), name) for name, value in vectors.items()]
    with np.errstate(all="ignore"):
        raw = invalidate_nonfinite(evaluate(home, f"chains.{formula}", *operands, *more).value)
    twists = raw._make(home.type_of(home.kind("twist"), raw.dtype), _on_twist(raw), raw.shape, raw._status)
    if as_bool(strict, "strict"):
        raise_first(twists._status, formula)
    return twists  # type: ignore[no-any-return]


def _on_twist(x: Multivector) -> Array:
    """Coefficients on all blades of a twist; an item that is NaN is NaN all over."""
    data = embed(x, x.algebra.kind("twist"))
    bad = ~np.isfinite(data).all(-1, keepdims=True)
    return np.where(bad, np.nan, data)


# -- reading -----------------------------------------------------------------------------------------------


def join_axes(axes: Any) -> Multivector:
    """Twists (n,) of a batch or a list, lines of CGA among them.

    Raises
    ------
    InputError, GradeError, ShapeError, AlgebraMismatchError
    """
    if isinstance(axes, Multivector):
        twists = _twists(axes, "the axes")
        check_shape(twists, "the axes", ("n",))
    elif isinstance(axes, (list, tuple)):
        parts = [_twists(x, f"axis {i}") for i, x in enumerate(axes)]
        if not parts:
            raise InputError("a chain has at least one joint.")
        for i, x in enumerate(parts):
            if x.algebra is not parts[0].algebra:
                raise AlgebraMismatchError(f"axis {i} belongs to {x.algebra.name}, axis 0 to {parts[0].algebra.name}.")
            check_shape(x, f"axis {i}", ())
        data = np.stack([np.asarray(x._data, np.float64) for x in parts])
        twists = parts[0].algebra.wrap(parts[0].kind, data)
    else:
        remedy = "Make them with kinematics.revolute_axis and prismatic_axis"
        raise invalid(axes, "axes", "a batch (n,) or a list of twists", remedy=remedy)
    if not len(twists):
        raise InputError("a chain has at least one joint.")
    return twists.astype(np.float64)


def _twists(x: Any, what: str) -> Multivector:
    if isinstance(x, Multivector) and x.grades == (3,) and "line" in x.algebra.kinds and not x.algebra.is_degenerate:
        if not set(x.kind.blades) <= set(x.algebra.kind("line").blades):
            raise GradeError(f"{what}: a {x.kind.name} is not a line.", remedy="Give its axis as a line or a twist")
        x = evaluate(x.algebra, "screws.twist_of", x).value
    return as_screw(x, what)


def chain_parameters(
    axes: Multivector, tool: Multivector, frames: Multivector, names: Sequence[str]
) -> tuple[ChainParameters, Array]:
    """Parameters of a chain, and the distances from joint to joint to tool.

    A joint's position is the point of its axis nearest to the tool.

    Raises
    ------
    InputError
        If an axis is zero or not finite.
    """
    algebra = axes.algebra
    vector, rotor = algebra.kind("euclidean"), algebra.kind("rotor")
    rotation, translation = evaluate(algebra, "motions.motor_parts", tool).values
    end = plain(translation)
    with np.errstate(all="ignore"):
        result = evaluate(algebra, "chains.joint", axes, Operand(end, vector, "the tool"))
    bad = np.flatnonzero(np.asarray(result.status))
    if len(bad):
        what = "zero" if np.isfinite(axes.values[bad[0]]).all() else "not finite"
        raise InputError(f"the axis of {names[bad[0]]} (joint {bad[0]}) is {what}.")
    direction, position, rotations, advance = (plain(v) if isinstance(v, Multivector) else v for v in result.values)
    count = len(axes)
    hand_offset = end - position[-1]
    rounding = ROUNDING * max(np.abs(position).max(), np.abs(end).max())
    offsets, hand_offset = (
        np.where(np.linalg.norm(x, axis=-1, keepdims=True) <= rounding, 0.0, x)
        for x in (np.diff(position, axis=0, prepend=position[:1]), hand_offset)
    )
    joints = np.concatenate([offsets, direction, rotations.reshape(count, 1), advance.reshape(count, 1)], -1)
    frame_rotation, frame_position = evaluate(algebra, "motions.motor_parts", frames).values
    links = np.concatenate([plain(frame_position) - position, frame_rotation.as_kind(rotor, check=False).values], -1)
    hand = np.append(hand_offset, rotation.as_kind(rotor, check=False).values)
    finite_array(joints, "the joints")
    steps = np.linalg.norm(np.vstack([offsets[1:], hand[None, :3]]), axis=-1)
    return ChainParameters(joints, links, hand, position[0]), steps


def joint_names(names: Any, count: int) -> tuple[str, ...]:
    """Names of joints, checked; numbered ones by default."""
    if names is None:
        return tuple(f"joint_{i + 1}" for i in range(count))
    if isinstance(names, str) or not isinstance(names, Sequence) or not all(isinstance(x, str) and x for x in names):
        raise InputError("names are a list of words, one for each joint.")
    if len(names) != count:
        raise ShapeError(f"{len(names)} names for {count} joints.")
    double = next((x for i, x in enumerate(names) if x in names[:i]), None)
    if double is not None:
        raise InputError(f"two joints are called {double!r}.")
    return tuple(names)


def joint_limits(limits: Any, names: tuple[str, ...]) -> Array:
    """Limits (n, 2) of joints, checked; infinite by default."""
    if limits is None:
        return frozen_copy(np.tile([-np.inf, np.inf], (len(names), 1)))
    values = np.array(real_array(limits, "limits", (len(names), 2)), np.float64)
    bad = np.flatnonzero(~(values[:, 0] <= values[:, 1]) | (values[:, 0] == np.inf) | (values[:, 1] == -np.inf))
    if len(bad):
        raise InputError(f"the limits of {names[bad[0]]} are {tuple(values[bad[0]].tolist())}: least, then greatest.")
    return frozen_copy(values)


def translation_ranges(parameters: ChainParameters, limits: Array) -> Array:
    """Largest translation of each joint from zero (n,); infinite without limits.

    The advance of a joint that rotates is computed from the moment of its axis; its rounding error counts as zero.
    """
    joints = parameters.joints
    positions = parameters.base + np.cumsum(joints[:, :3], axis=0)
    rounding = ROUNDING * np.linalg.norm(positions, axis=-1) * joints[:, 6]
    advance, farthest = np.abs(joints[:, 7]), np.abs(limits).max(-1)
    return np.asarray(advance * np.where(advance > rounding, farthest, 0))
