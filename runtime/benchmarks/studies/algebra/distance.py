"""Growth of errors with the distance from the origin: motions of points, in three representations.

A rigid motion near a position at distance R (a rotation about an axis there) moves points near that position. A point
stores x^2/2, so errors of plain conformal coordinates grow as R^2; re-centering on a local origin brings R back.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import mpmath
import numpy as np

from ...harness.algebras import cga3d
from ...harness.study import PRECISIONS, Array, Case, Errors, Method, Study, errors_by_item, on_copies
from ...harness.vectors import cross, directions, dot, subtract

DIGITS = 50
#: Each motion is computed this many times in one call, so that the time is the loops' and not the calls'.
COPIES = 100


@dataclass(frozen=True)
class Motions:
    """Rotations by ``angle`` about ``axis`` through ``position``, and the points that they move."""

    position: Array
    axis: Array
    angle: Array
    point: Array


def motions(rng: np.random.Generator, count: int, distance: float) -> Motions:
    """Motions at a distance from the origin; points lie within unit distance of the position."""
    position = distance_vectors(rng, count, distance)
    axis = directions(rng, count)
    return Motions(position, axis, rng.uniform(-3, 3, count), position + rng.uniform(-1, 1, (count, 3)))


def distance_vectors(rng: np.random.Generator, count: int, distance: float) -> Array:
    """Random vectors (count, 3) of one length."""
    away = rng.normal(size=(count, 3))
    return np.asarray(distance * away / np.linalg.norm(away, axis=1, keepdims=True))


def truth(m: Motions) -> list[list[Any]]:
    """Rodrigues' formula with 50 digits, on the inputs as they are."""
    rows = []
    with mpmath.workdps(DIGITS):
        for *vectors, angle in zip(m.position, m.axis, m.point, m.angle, strict=True):
            c, n, p = ([mpmath.mpf(float(v)) for v in vector] for vector in vectors)
            length = mpmath.sqrt(dot(n, n))
            n, x = [v / length for v in n], subtract(p, c)
            cosine, sine = mpmath.cos(mpmath.mpf(float(angle))), mpmath.sin(mpmath.mpf(float(angle)))
            along, across = dot(n, x), cross(n, x)
            rows.append([c[i] + x[i] * cosine + across[i] * sine + n[i] * along * (1 - cosine) for i in range(3)])
    return rows


def error(answer: Array, exact: list[list[Any]], _: Motions) -> Errors:
    """Distance between the computed and the true point, in units of the body (1)."""

    def distance(row: Array, true: list[Any]) -> float:
        away = subtract(map(mpmath.mpf, map(float, row)), true)
        return float(mpmath.sqrt(dot(away, away)))

    with mpmath.workdps(DIGITS):
        return errors_by_item(distance, answer, exact)


def null_basis(m: Motions, precision: str) -> Array:
    """R >> X on the stored null basis, about the world's origin."""
    motor = cga3d.rotor(m.axis.astype(precision), m.angle.astype(precision), point=m.position.astype(precision))
    moved = motor >> cga3d.point(m.point.astype(precision))
    return np.asarray(moved.parameters().xyz, float)


def local_origin(m: Motions, precision: str) -> Array:
    """R >> X about a local origin: subtract the position, move, add it again."""
    moved = null_basis(replace(m, position=np.zeros_like(m.position), point=m.point - m.position), precision)
    return m.position + moved


def orthonormal_basis(m: Motions, precision: str) -> Array:
    """The same product on e1 e2 e3 e+ e-, as dense libraries store it: the exact motor and point, converted."""
    motor = cga3d.rotor(m.axis, m.angle, point=m.position)
    point = cga3d.point(m.point)
    r, x = (v.to_basis("orthonormal").astype(precision) for v in (motor, point))
    y = r >> x
    weight = y["e5"] - y["e4"]  # X . n_inf = -1 is divided out
    with np.errstate(all="ignore"):  # far away in single precision nothing is left of it: the answer is lost
        return np.stack([np.asarray(y[name] / weight, float) for name in ("e1", "e2", "e3")], -1)


def describe(m: Motions, i: int) -> str:
    """One motion, in full."""
    axis, position, point = (x[i].tolist() for x in (m.axis, m.position, m.point))
    return f"angle {m.angle[i]:.17g} about {axis} through {position}, point {point}"


STUDY = Study(
    name="distance",
    title="A motor on a point, against the distance from the origin",
    methods=tuple(
        Method(name, on_copies(run, COPIES), "precision", PRECISIONS)
        for name, run in (
            ("null basis", null_basis),
            ("orthonormal basis", orthonormal_basis),
            ("local origin", local_origin),
        )
    ),
    cases=(
        Case("distance 1", partial(motions, distance=1.0)),
        Case("distance 1e3", partial(motions, distance=1e3), "stiff"),
        Case("distance 1e6", partial(motions, distance=1e6), "extreme"),
    ),
    reference=truth,
    error=error,
    describe=describe,
    unit="in body sizes",
    count=300,
    copies=COPIES,
    source="null basis: docs/development/decisions/formulas.md; motions: thesis 1.2.6",
    notes="Each time includes making the motor and the point and reading the result. The local origin subtracts and "
    "adds the position in double precision.",
)
