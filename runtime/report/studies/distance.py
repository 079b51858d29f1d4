"""How error grows with the distance from the origin: motions of points, on three ways to store them.

A rigid motion near a place at distance R (a rotation about an axis there) moves points near that place. A point
stores x^2/2, so errors of plain conformal coordinates grow as R^2; re-centring on a local origin brings R back.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError
from ..study import Case, Errors, Method, Study

Array = NDArray[np.float64]
DIGITS = 50
#: Each motion is computed this many times in one call, so that the time is the loops' and not the calls'.
COPIES = 100


@dataclass(frozen=True)
class Motions:
    """Rotations by ``angle`` about ``axis`` through ``place``, and the points that they move."""

    place: Array
    axis: Array
    angle: Array
    point: Array


def motions(distance: float) -> Any:
    """Maker of motions at a distance from the origin; points lie within unit distance of the place."""

    def make(rng: np.random.Generator, count: int) -> Motions:
        away = rng.normal(size=(count, 3))
        place = distance * away / np.linalg.norm(away, axis=1, keepdims=True)
        axis = rng.normal(size=(count, 3))
        axis /= np.linalg.norm(axis, axis=1, keepdims=True)
        return Motions(place, axis, rng.uniform(-3, 3, count), place + rng.uniform(-1, 1, (count, 3)))

    return make


def truth(m: Motions) -> list[list[Any]]:
    """Rodrigues' formula with 50 digits, on the inputs as they are."""
    import mpmath

    rows = []
    with mpmath.workdps(DIGITS):
        for place, axis, angle, point in zip(m.place, m.axis, m.angle, m.point, strict=True):
            c = [mpmath.mpf(float(v)) for v in place]
            length = mpmath.sqrt(sum(mpmath.mpf(float(v)) ** 2 for v in axis))
            n = [mpmath.mpf(float(v)) / length for v in axis]
            x = [mpmath.mpf(float(v)) - w for v, w in zip(point, c, strict=True)]
            cosine, sine = mpmath.cos(mpmath.mpf(float(angle))), mpmath.sin(mpmath.mpf(float(angle)))
            dot = sum(a * b for a, b in zip(n, x, strict=True))
            cross = [n[1] * x[2] - n[2] * x[1], n[2] * x[0] - n[0] * x[2], n[0] * x[1] - n[1] * x[0]]
            rows.append([c[i] + x[i] * cosine + cross[i] * sine + n[i] * dot * (1 - cosine) for i in range(3)])
    return rows


def error(answer: Array, exact: list[list[Any]], _: Motions) -> Errors:
    """Distance between the computed and the true point, in units of the body (1)."""
    import mpmath

    with mpmath.workdps(DIGITS):
        return np.array(
            [
                float(mpmath.sqrt(sum((mpmath.mpf(float(a)) - t) ** 2 for a, t in zip(row, true, strict=True))))
                if np.all(np.isfinite(row))
                else np.inf
                for row, true in zip(answer, exact, strict=True)
            ]
        )


def repeated(method: Callable[[Motions, str], Array]) -> Callable[[Motions, str], Array]:
    """The method on COPIES copies of the motions; the answers of the first."""

    def run(m: Motions, precision: str) -> Array:
        place, axis, point = (np.tile(a, (COPIES, 1)) for a in (m.place, m.axis, m.point))
        return method(Motions(place, axis, np.tile(m.angle, COPIES), point), precision)[: len(m.place)]

    return run


def null_basis(m: Motions, precision: str) -> Array:
    """R >> X on the stored null basis, about the world's origin."""
    return _moved(m.place, m.axis, m.angle, m.point, precision)


def local_origin(m: Motions, precision: str) -> Array:
    """The same about a local origin: subtract the place, move, add it again."""
    moved = _moved(np.zeros_like(m.place), m.axis, m.angle, m.point - m.place, precision)
    return m.place + moved


def _moved(place: Array, axis: Array, angle: Array, point: Array, precision: str) -> Array:
    from ... import cga3d

    dtype = precision_dtype(precision)
    motor = cga3d.rotor(axis.astype(dtype), angle.astype(dtype), point=place.astype(dtype))
    moved = motor >> cga3d.point(point.astype(dtype))
    return np.asarray(moved.parameters().xyz, float)


def orthonormal_basis(m: Motions, precision: str) -> Array:
    """The same product on e1 e2 e3 e+ e-, as dense libraries store it: the exact motor and point, converted."""
    from ... import cga3d

    motor = cga3d.rotor(m.axis, m.angle, point=m.place)
    point = cga3d.point(m.point)
    r, x = (v.to_basis("orthonormal").astype(precision_dtype(precision)) for v in (motor, point))
    y = r >> x
    weight = y["e5"] - y["e4"]  # X . n_inf = -1 is divided out
    with np.errstate(all="ignore"):  # far away in single precision nothing is left of it: the answer is lost
        return np.stack([np.asarray(y[name] / weight, float) for name in ("e1", "e2", "e3")], -1)


def precision_dtype(precision: str) -> Any:
    """NumPy's type of a precision's name."""
    if precision not in ("float64", "float32"):
        raise InputError(f"precision {precision!r} is not float64 or float32.")
    return np.dtype(precision)


def describe(m: Motions, i: int) -> str:
    """One motion, in full."""
    return (
        f"angle {m.angle[i]:.17g} about {m.axis[i].tolist()} through {m.place[i].tolist()}, point {m.point[i].tolist()}"
    )


STUDY = Study(
    name="distance",
    title="A motor on a point, against the distance from the origin",
    methods=(
        Method("null basis", repeated(null_basis), "precision", ("float32", "float64")),
        Method("orthonormal basis", repeated(orthonormal_basis), "precision", ("float32", "float64")),
        Method("local origin", repeated(local_origin), "precision", ("float32", "float64")),
    ),
    cases=(
        Case("distance 1", motions(1.0), "ordinary", describe),
        Case("distance 1e3", motions(1e3), "stiff", describe),
        Case("distance 1e6", motions(1e6), "extreme", describe),
    ),
    reference=truth,
    error=error,
    unit="in body sizes",
    count=300,
    copies=COPIES,
    source="MATHS of the null basis: docs/decisions.md; motions: thesis 1.2.6",
    notes="Each time includes making the motor and the point and reading the result. The local origin subtracts and "
    "adds the place in double precision.",
)
