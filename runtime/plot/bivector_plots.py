"""What bivectors do: orbits of points, screw motions and their parts, fields of velocity (figures 3.7-3.9, 6.1, 6.2).

Positions come from compiled kernels in one batch: exponentials of multiples of the bivector, and sandwiches.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..arrays import truth
from ..errors import GradeError, InputError
from ..multivector import Multivector
from ..objects import screws
from ..status import Status
from . import checks, drawing, palette
from .shapes import Array, arrows

if TYPE_CHECKING:
    from .backend import Axes3D

#: Positions of an orbit in each turn.
SAMPLES = 128
#: Positions of one orbit, and points along a side of a field's grid, at most.
MOST, MOST_GRID = 1_000_000, 40
#: An orbit that never comes back (of a bivector with a positive square) is drawn up to this exponent each way:
#: exp(-2 REACH) of its way is left.
REACH = 3.0
#: The longest arrow of a field over the distance of its points, and the head over the longest arrow.
FILL, HEAD = 0.75, 0.25
#: Points of a field along each side, and arrows along each of its orbits.
GRID, ARROWS_ON_ORBIT = 5, 12


def orbit_paths(bivector: Multivector, points: Any = (0, 0, 0), turns: float = 1.0, samples: int = SAMPLES) -> Array:
    """Positions exp(t B) x exp(-t B) of points as t grows.

    Parameters
    ----------
    bivector : Multivector, shape ()
        Dual line, twist, dual circle, point pair, or any other sum of grade 2.
    points : Multivector (m,), or array (m, 3) or (3,)
    turns : float
        Of a rotation (B^2 < 0): whole turns, from t = 0. Of a translation (B^2 = 0): t runs over [0, turns]. Else the
        orbits run between two fixed points, and most of that is shown.
    samples : int
        Positions for each turn, or for all of an orbit that never comes back.

    Returns
    -------
    array (m, n, 3)
        NaN where a point passes infinity.

    Raises
    ------
    GradeError, InputError
    """
    t = _parameters(bivector, turns, samples)
    moved = (bivector * t).exp() >> _points(bivector, points)[:, None]
    return _positions(moved)


def orbit(
    bivector: Multivector,
    points: Any = (0, 0, 0),
    turns: float = 1.0,
    ax: Axes3D | None = None,
    color: Any = None,
    size: float = drawing.WIDTH,
    extent: Any = None,
) -> Axes3D:
    """Draw the orbits of points under exp(t B) (thesis, figure 3.7); see `orbit_paths`, and `draw` for the rest."""
    ways = orbit_paths(bivector, points, turns)
    return drawing.paths(ways, ax, palette.INK if color is None else color, size, extent)


def screw_parts(bivector: Multivector) -> tuple[Multivector, Multivector]:
    """A sum of dual lines as rotation and translation that commute (thesis 3.9.3, 3.9.4).

    Raises
    ------
    GradeError, InputError
        If it is no bivector of a motion; if it has no rotation, and therefore no axis.
    """
    rotation = _rotation(_decomposed(bivector))
    return rotation, bivector - rotation


def screw(
    bivector: Multivector,
    points: Any = (0, 0, 0),
    turns: float = 2.0,
    ax: Axes3D | None = None,
    parts: bool = True,
    size: float = drawing.WIDTH,
    extent: Any = None,
) -> Axes3D:
    """Draw the screw motion of a sum of dual lines, its axis, and what its parts do (thesis, figures 3.8 and 3.9).

    The motion is dark, the axis and the rotation about it are red, the translation is blue.

    Parameters
    ----------
    bivector : Multivector, shape ()
        Such as ``line1.dual() + line2.dual()``.
    points, turns
        As for `orbit_paths`.
    ax, size, extent
        As for `draw`.
    parts : bool
        Draw the orbits of the two commuting parts, too.

    Raises
    ------
    GradeError, InputError
    """
    found = _decomposed(bivector)
    ax = orbit(bivector, points, turns, ax, palette.INK, 1.5 * size, extent)
    if truth(parts, "parts"):
        rotation = _rotation(found)
        orbit(rotation, points, min(turns, 1.0), ax, palette.RED, size)
        orbit(bivector - rotation, points, float(np.pi * turns / found.magnitude), ax, palette.BLUE, size)
    return drawing.draw(found.axis, ax=ax, color=palette.RED, size=size)


def velocities(twist: Multivector, points: Any) -> Array:
    """Velocities (m, 3) of points that move with a twist: dX = X x Omega, so that dx = v + w x r (thesis 6.2).

    Raises
    ------
    GradeError, InputError
    """
    rate = _points(twist, points).commutator(_single(twist))
    if "ni" in rate.algebra.vectors:
        return np.stack([rate[f"e{i}"] for i in (1, 2, 3)], -1)
    return np.asarray(rate.as_kind("direction", check=False).parameters().v)


def twist_field(
    twist: Multivector,
    points: Any = None,
    reach: float = 1.0,
    count: int = GRID,
    ax: Axes3D | None = None,
    orbits: bool = False,
    color: Any = None,
    size: float = drawing.WIDTH,
    extent: Any = None,
) -> Axes3D:
    """Draw the velocities of points that move with a twist as arrows (thesis, figures 6.1 and 6.2).

    Parameters
    ----------
    twist : Multivector, shape ()
        Omega = w I3 + v n_inf: a direction translates, a dual line rotates.
    points : Multivector (m,), or array (m, 3), optional
        Where; a cubic grid by default.
    reach, count
        Half the side of the grid, and its points along each side.
    orbits : bool
        Draw the orbits of the points, with arrows along them. The motion is exp(-t Omega/2).
    color
        As for `draw`, one per arrow; by default green where it is slow to red where it is fast.
    ax, size, extent
        As for `draw`.

    Raises
    ------
    GradeError, InputError
    """
    if points is None:
        count, reach = checks.whole(count, "count", 1, MOST_GRID), checks.positive(reach, "reach")
        side = np.linspace(-reach, reach, count)
        points = np.stack(np.meshgrid(side, side, side, indexing="ij"), -1).reshape(-1, 3)
    start = _positions(_points(twist, points))
    if truth(orbits, "orbits"):
        ways = orbit_paths(-0.5 * twist, start)
        ax = drawing.paths(ways, ax, palette.GREY, 0.5 * size, extent)
        step = max(1, (ways.shape[1] - 1) // ARROWS_ON_ORBIT)
        start = ways[:, :-1:step].reshape(-1, 3)
        start = start[np.isfinite(start).all(-1)]
    velocity = velocities(twist, start)
    velocity /= float(np.fmax.reduce(np.abs(velocity), axis=None, initial=0.0)) or 1.0  # only their ratios show
    speed = np.linalg.norm(velocity, axis=-1)
    longest = float(np.fmax.reduce(speed, initial=0.0))
    shown = velocity * (FILL * _spacing(start[np.isfinite(start).all(-1)]) / longest) if longest > 0 else velocity
    if color is None:
        color = np.round(speed / longest, 6) if longest > 0 else palette.GREEN  # equal ones have one colour
    heads = HEAD * np.linalg.norm(shown, axis=-1)
    return drawing.paths(arrows(start - shown / 2, shown, heads), ax, color, size, extent)


# -- what bivectors and points may be --------------------------------------------------------------------------


def _single(bivector: Any) -> Multivector:
    if not isinstance(bivector, Multivector):
        raise InputError(f"a {type(bivector).__name__} is no bivector.")
    if bivector.grades != (2,):
        raise GradeError(
            f"a {bivector.kind.name} of grades {bivector.grades} is no bivector.", remedy="The dual of a line is one"
        )
    if bivector.size != 1 or not np.isfinite(bivector.values).all():
        raise InputError(f"one finite bivector is needed, not a batch of shape {bivector.shape} or NaN.")
    return bivector.reshape(())


def _decomposed(bivector: Multivector) -> Any:
    """Axis, pitch and magnitude."""
    found = screws.screw(_single(bivector))
    if found.status != Status.OK:
        raise InputError("this bivector has no rotation, and so no axis of a screw.")
    return found


def _rotation(found: Any) -> Multivector:
    """Magnitude times the dual of the axis."""
    return screws.screw_bivector(found.axis, 0.0, found.magnitude)


def _points(bivector: Any, points: Any) -> Multivector:
    """Points (m,) of the bivector's algebra."""
    algebra: Any = _single(bivector).algebra
    if isinstance(points, Multivector):
        if points.algebra is not algebra or points.kind.name != "point":
            raise InputError(f"the points are a {points.kind.name} of {points.algebra.name}; {algebra.name} is needed.")
        return points.reshape(-1)
    xyz = checks.numbers(points, "points")
    if xyz.ndim == 0 or xyz.shape[-1] != 3 or not xyz.size:
        raise InputError(f"points of shape {xyz.shape}: positions have a last axis of 3 numbers.")
    return algebra.point(xyz.reshape(-1, 3))  # type: ignore[no-any-return]


def _positions(points: Multivector) -> Array:
    """Positions of what points became: NaN at infinity."""
    flat = points.reshape(-1)
    if flat.kind.name != "point":
        flat = flat.as_kind(flat.algebra.kind("point").layout, check=False).normalized("point")
    xyz: Array = np.asarray(flat.parameters().xyz, float)
    return xyz.reshape(*points.shape, 3)


def _parameters(bivector: Multivector, turns: float, samples: int) -> Array:
    turns, samples = checks.positive(turns, "turns"), checks.whole(samples, "samples", 2, MOST)
    square = float((_single(bivector) * bivector).grade(0)["1"].item())
    size = float(np.abs(bivector.values).max())
    noise = float(np.finfo(float).eps) * size * size
    if square > noise:
        return np.asarray(np.linspace(-REACH, REACH, samples + 1) / np.sqrt(square))
    if square >= -noise:
        return np.linspace(0.0, turns, samples + 1)
    count = np.ceil(samples * max(turns, 1.0)) + 1
    if count > MOST:
        raise InputError(f"{turns:g} turns of {samples} samples are more than {MOST} positions.")
    return np.asarray(np.linspace(0.0, turns, int(count)) * (np.pi / np.sqrt(-square)))


def _spacing(xyz: Array) -> float:
    """A typical distance between neighbours: the side of the cell that one point has of the box around all."""
    sides = np.ptp(xyz, axis=0)
    wide = sides[sides > 1e-9 * max(float(sides.max(initial=0.0)), 1e-300)]
    if len(wide) == 0:
        return 1.0
    per_side = max(len(xyz) ** (1 / len(wide)) - 1, 1.0)
    return float(np.prod(wide) ** (1 / len(wide)) / per_side)
