"""Pictures of bivectors: orbits of points, screw motions and their parts, velocity fields (figures 3.7-3.9, 6.1, 6.2).

Positions come from compiled kernels in one batch: exponentials of multiples of the bivector, and sandwiches.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..common.deprecation import renamed_keywords
from ..common.validation import as_bool, as_instance, as_int, positive_float, real_array
from ..core.multivector import Multivector
from ..errors import GradeError, InputError
from ..objects import screws
from ..status import Status
from . import drawing, palette
from .tessellation import Array, arrows

if TYPE_CHECKING:
    from .matplotlib_import import Axes3D

#: Default number of samples of an orbit for each full rotation.
SAMPLES = 128
#: Largest number of samples of an orbit.
MOST = 1_000_000
#: Largest number of points along a side of a field's grid.
MOST_GRID = 40
#: Largest exponent of an open orbit (of a bivector with a positive square), in both directions: a fraction
#: exp(-2 REACH) of its path is missing.
REACH = 3.0
#: Length of the longest arrow of a field, relative to the distance of its points.
FILL = 0.75
#: Length of an arrow's head, relative to the arrow.
HEAD = 0.25
#: Default number of points of a field along each side.
GRID = 5
#: Number of arrows along each orbit of a field.
ARROWS_ON_ORBIT = 12


def orbit_paths(bivector: Multivector, points: Any = (0, 0, 0), turns: float = 1.0, samples: int = SAMPLES) -> Array:
    """Sample the orbits exp(t B) x exp(-t B) of points.

    Parameters
    ----------
    bivector : Multivector, shape ()
        Dual line, twist, dual circle, point pair, or any other sum of grade 2.
    points : Multivector (m,), or array (m, 3) or (3,)
    turns : float
        Number of full rotations (B^2 < 0), from t = 0. For a translation (B^2 = 0) t runs over [0, turns]. Otherwise
        the orbits run between two fixed points, and most of them is shown.
    samples : int
        Number of samples for each full rotation, or for the whole of an open orbit.

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
    paths = orbit_paths(bivector, points, turns)
    return drawing.paths(paths, ax, palette.INK if color is None else color, size, extent)


def screw_parts(bivector: Multivector) -> tuple[Multivector, Multivector]:
    """Decompose a sum of dual lines into a rotation and a translation that commute (thesis 3.9.3, 3.9.4).

    Raises
    ------
    GradeError, InputError
        If it is not the bivector of a motion, or has no rotation, and therefore no axis.
    """
    rotation = _rotation(_screw_of(bivector))
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
    """Draw the screw motion of a sum of dual lines, its axis, and the orbits of its parts (figures 3.8 and 3.9).

    The motion is dark, the axis and the rotation about it are red, the translation is blue.

    Parameters
    ----------
    bivector : Multivector, shape ()
        Sum of dual lines, as ``line1.dual() + line2.dual()``.
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
    parameters = _screw_of(bivector)
    ax = orbit(bivector, points, turns, ax, palette.INK, 1.5 * size, extent)
    if as_bool(parts, "parts"):
        rotation = _rotation(parameters)
        orbit(rotation, points, min(turns, 1.0), ax, palette.RED, size)
        orbit(bivector - rotation, points, float(np.pi * turns / parameters.magnitude), ax, palette.BLUE, size)
    return drawing.draw(parameters.axis, ax=ax, color=palette.RED, size=size)


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


@renamed_keywords(reach="half_side")
def twist_field(
    twist: Multivector,
    points: Any = None,
    half_side: float = 1.0,
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
        Positions of the arrows; a cubic grid by default.
    half_side, count
        Half the side of the grid, and its number of points along each side.
    orbits : bool
        Draw the orbits of the points, with arrows along them. The motion is exp(-t Omega/2).
    color
        As for `draw`, one per arrow; by default from green for slow to red for fast points.
    ax, size, extent
        As for `draw`.

    Raises
    ------
    GradeError, InputError
    """
    if points is None:
        count, half_side = as_int(count, "count", 1, MOST_GRID), positive_float(half_side, "half_side")
        side = np.linspace(-half_side, half_side, count)
        points = np.stack(np.meshgrid(side, side, side, indexing="ij"), -1).reshape(-1, 3)
    start = _positions(_points(twist, points))
    if as_bool(orbits, "orbits"):
        paths = orbit_paths(-0.5 * twist, start)
        ax = drawing.paths(paths, ax, palette.GREY, 0.5 * size, extent)
        step = max(1, (paths.shape[1] - 1) // ARROWS_ON_ORBIT)
        start = paths[:, :-1:step].reshape(-1, 3)
        start = start[np.isfinite(start).all(-1)]
    velocity = velocities(twist, start)
    velocity /= float(np.fmax.reduce(np.abs(velocity), axis=None, initial=0.0)) or 1.0  # only their ratios show
    speed = np.linalg.norm(velocity, axis=-1)
    longest = float(np.fmax.reduce(speed, initial=0.0))
    shown = velocity * (FILL * _spacing(start[np.isfinite(start).all(-1)]) / longest) if longest > 0 else velocity
    if color is None:
        color = np.round(speed / longest, 6) if longest > 0 else palette.GREEN  # equal speeds have one color
    heads = HEAD * np.linalg.norm(shown, axis=-1)
    return drawing.paths(arrows(start - shown / 2, shown, heads), ax, color, size, extent)


# -- checks of bivectors and points --------------------------------------------------------------------------


def _single(bivector: Any) -> Multivector:
    x = as_instance(bivector, "the bivector", Multivector, "a bivector")
    if x.grades != (2,):
        raise GradeError(
            f"a bivector is needed, not {x.kind.name} of grades {x.grades}.", remedy="Give the dual of a line"
        )
    if x.size != 1 or not np.isfinite(x.values).all():
        raise InputError(f"one finite bivector is needed, not a batch of shape {x.shape} or NaN.")
    return x.reshape(())


def _screw_of(bivector: Multivector) -> Any:
    """Axis, pitch and magnitude of a screw."""
    parameters = screws.screw(_single(bivector))
    if parameters.status != Status.OK:
        raise InputError("this bivector has no rotation, and therefore no screw axis.")
    return parameters


def _rotation(parameters: Any) -> Multivector:
    """Rotation of a screw: its magnitude times the dual of the axis."""
    return screws.screw_bivector(parameters.axis, 0.0, parameters.magnitude)


def _points(bivector: Any, points: Any) -> Multivector:
    """Points (m,) of the bivector's algebra."""
    algebra: Any = _single(bivector).algebra
    if isinstance(points, Multivector):
        if points.algebra is not algebra or points.kind.name != "point":
            raise InputError(f"the points are a {points.kind.name} of {points.algebra.name}; {algebra.name} is needed.")
        return points.reshape(-1)
    xyz = np.asarray(real_array(points, "points", (..., 3), InputError), float)
    if not xyz.size:
        raise InputError("points is empty; at least one position is needed.")
    return algebra.point(xyz.reshape(-1, 3))  # type: ignore[no-any-return]


def _positions(points: Multivector) -> Array:
    """Positions of transformed points: NaN at infinity."""
    flat = points.reshape(-1)
    if flat.kind.name != "point":
        flat = flat.as_kind(flat.algebra.kind("point").layout, check=False).normalized("point")
    xyz: Array = np.asarray(flat.parameters().xyz, float)
    return xyz.reshape(*points.shape, 3)


def _parameters(bivector: Multivector, turns: float, samples: int) -> Array:
    turns, samples = positive_float(turns, "turns"), as_int(samples, "samples", 2, MOST)
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
    """Typical distance of adjacent points: side of a point's part of the box around all."""
    sides = np.ptp(xyz, axis=0)
    wide = sides[sides > 1e-9 * max(float(sides.max(initial=0.0)), 1e-300)]
    if len(wide) == 0:
        return 1.0
    per_side = max(len(xyz) ** (1 / len(wide)) - 1, 1.0)
    return float(np.prod(wide) ** (1 / len(wide)) / per_side)
