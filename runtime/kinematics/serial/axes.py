"""Axes of chains: twists of joints from positions and directions, and what the driver keeps of them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..arrays import rows
from ..calls import Numbers as Operand
from ..calls import call, finite, raise_first
from ..codegen.errors import AlgebraMismatchError, GradeError, InputError, ShapeError
from ..dynamics.given import finite as finite_numbers
from ..dynamics.given import kept
from ..dynamics.screws import as_screw, geometry
from ..euclidean import plain
from ..multivector import Multivector
from .chains_engine import Numbers

if TYPE_CHECKING:
    from ..algebras import Algebra

Array = NDArray[Any]


# -- making ------------------------------------------------------------------------------------------------


def revolute_axis(
    position: ArrayLike, direction: ArrayLike, algebra: Algebra | None = None, *, strict: bool = False
) -> Multivector:
    """The twist a I3 + (p x a) n of a turn by one radian, counter-clockwise about a line.

    Parameters
    ----------
    position, direction : array (..., 3)
        A point of the line, and a vector along it of any length.
    algebra : Algebra, optional
        `bladesmith.cga3d` (default) or `pga3d`.

    Returns
    -------
    Multivector of twists (...)
        Dually in CGA, and in PGA by itself, the unit line. INVALID: no direction.
    """
    return _axis("axis_through", algebra, strict, position=position, direction=direction)


def prismatic_axis(direction: ArrayLike, algebra: Algebra | None = None, *, strict: bool = False) -> Multivector:
    """The twist a n of a slide by one unit of length along a direction (..., 3) of any length. INVALID: zero."""
    return _axis("slide_along", algebra, strict, direction=direction)


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
    given = [Operand(value, home.kind("euclidean"), name) for name, value in vectors.items()]
    with np.errstate(all="ignore"):
        found = finite(call(home, f"chains.{formula}", *given, *more).value)
    made = found._make(home.type_of(home.kind("twist"), found.dtype), _on_twist(found), found.shape, found._status)
    if strict:
        raise_first(made._status, formula)
    return made


def _on_twist(x: Multivector) -> Array:
    """Coefficients on all blades of a twist; an item that is NaN is NaN all over."""
    from ..rows import embedded

    data = embedded(x, x.algebra.kind("twist"))
    bad = ~np.isfinite(data).all(-1, keepdims=True)
    return np.where(bad, np.nan, data)


# -- reading -----------------------------------------------------------------------------------------------


def joined(axes: Any) -> Multivector:
    """Twists (n,) of a batch or a list, lines of CGA among them.

    Raises
    ------
    InputError, GradeError, ShapeError, AlgebraMismatchError
    """
    if isinstance(axes, Multivector):
        found = _twists(axes, "the axes")
        if len(found.shape) != 1:
            raise ShapeError(f"the axes have shape {found.shape}; (n,) is needed.")
    elif isinstance(axes, (list, tuple)):
        parts = [_twists(x, f"axis {i}") for i, x in enumerate(axes)]
        if not parts:
            raise InputError("a chain has at least one joint.")
        for i, x in enumerate(parts):
            if x.algebra is not parts[0].algebra:
                raise AlgebraMismatchError(f"axis {i} belongs to {x.algebra.name}, axis 0 to {parts[0].algebra.name}.")
            if x.shape:
                raise ShapeError(f"axis {i} has shape {x.shape}; a list holds one axis for each joint.")
        data = np.stack([np.asarray(x._data, np.float64) for x in parts])
        found = parts[0].algebra.wrap(parts[0].kind, data)
    else:
        raise InputError(
            f"the axes are a {type(axes).__name__}; twists (n,) are needed.",
            remedy="Make them with kinematics.revolute_axis and prismatic_axis",
        )
    if not len(found):
        raise InputError("a chain has at least one joint.")
    return found.astype(np.float64)


def _twists(x: Any, what: str) -> Multivector:
    if isinstance(x, Multivector) and x.grades == (3,) and "line" in x.algebra.kinds and not x.algebra.is_degenerate:
        if not set(x.kind.blades) <= set(x.algebra.kind("line").blades):
            raise GradeError(f"{what}: a {x.kind.name} is no line.", remedy="Give its axis as a line or a twist")
        x = call(x.algebra, "screws.twist_of", x).value
    return as_screw(x, what)


def parts_of(axes: Multivector, tool: Multivector, frames: Multivector, names: Sequence[str]) -> tuple[Numbers, Array]:
    """The chain in numbers, and the lengths of the ways from joint to joint to tool.

    Places on the joints' axes are those nearest to the tool.

    Raises
    ------
    InputError
        If an axis is zero or not finite.
    """
    algebra = axes.algebra
    vector, rotor = algebra.kind("euclidean"), algebra.kind("rotor")
    turn, at = call(algebra, "motions.motor_parts", tool).values
    end = plain(at)
    with np.errstate(all="ignore"):
        found = call(algebra, "chains.joint", axes, Operand(end, vector, "the tool"))
    bad = np.flatnonzero(np.asarray(found.status))
    if len(bad):
        what = "zero" if np.isfinite(axes.values[bad[0]]).all() else "not finite"
        raise InputError(f"the axis of {names[bad[0]]} (joint {bad[0]}) is {what}.")
    direction, place, turns, advance = (plain(v) if isinstance(v, Multivector) else v for v in found.values)
    count = len(axes)
    offsets = np.diff(place, axis=0, prepend=place[:1])
    joints = np.concatenate([offsets, direction, turns.reshape(count, 1), advance.reshape(count, 1)], -1)
    frame_turn, frame_at = call(algebra, "motions.motor_parts", frames).values
    links = np.concatenate([plain(frame_at) - place, frame_turn.as_kind(rotor, check=False).values], -1)
    own = np.append(end - place[-1], turn.as_kind(rotor, check=False).values)
    finite_numbers(joints, "the joints")
    steps = np.linalg.norm(np.vstack([offsets[1:], own[None, :3]]), axis=-1)
    return Numbers(joints, links, own, place[0]), steps


def names_of(given: Any, count: int) -> tuple[str, ...]:
    """Names of joints, checked, or what they are called by number."""
    if given is None:
        return tuple(f"joint_{i + 1}" for i in range(count))
    if isinstance(given, str) or not isinstance(given, Sequence) or not all(isinstance(x, str) and x for x in given):
        raise InputError("names are a list of words, one for each joint.")
    if len(given) != count:
        raise ShapeError(f"{len(given)} names for {count} joints.")
    double = next((x for i, x in enumerate(given) if x in given[:i]), None)
    if double is not None:
        raise InputError(f"two joints are called {double!r}.")
    return tuple(given)


def limits_of(given: Any, names: tuple[str, ...]) -> Array:
    """Limits (n, 2), checked; infinite where there are none."""
    if given is None:
        return kept(np.tile([-np.inf, np.inf], (len(names), 1)))
    found = np.array(rows(given, 2, "limits"), np.float64)
    if found.shape != (len(names), 2):
        raise ShapeError(f"limits have shape {found.shape}; {(len(names), 2)} is needed.")
    bad = np.flatnonzero(~(found[:, 0] <= found[:, 1]) | (found[:, 0] == np.inf) | (found[:, 1] == -np.inf))
    if len(bad):
        raise InputError(f"the limits of {names[bad[0]]} are {tuple(found[bad[0]].tolist())}: least, then greatest.")
    return kept(found)
