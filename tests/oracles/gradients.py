"""Gradients by differences for tests: of Newton's and Euler's equations on vectors at 50 digits, and of states."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import mpmath
import numpy as np
from scipy.spatial.transform import Rotation

from bladesmith import dynamics

from .sequences import cross

DIGITS = 50
#: Step of the differences; their error is its square.
STEP = "1e-15"
BAR = 1e-8
TURN = Rotation.from_rotvec([0.5, 1.0, 0.3]).as_matrix()
Vector = list[Any]

# -- an independent integration at 50 digits ---------------------------------------------------------------


def turned(r: Vector, a: Vector) -> Vector:
    """R a, of a matrix row by row."""
    return [r[3 * i] * a[0] + r[3 * i + 1] * a[1] + r[3 * i + 2] * a[2] for i in range(3)]


def turned_back(r: Vector, a: Vector) -> Vector:
    return [r[i] * a[0] + r[i + 3] * a[1] + r[i + 6] * a[2] for i in range(3)]


def turning(r: Vector, w: Vector) -> Vector:
    """dR = R [w]x."""
    return [x for i in range(3) for x in cross(r[3 * i : 3 * i + 3], w)]


def extrapolated(rates: Callable[[Vector], Vector], y: Vector, duration: Any, steps: int, columns: int = 13) -> Vector:
    """Gragg's midpoint rule with extrapolation; the last two columns agree."""
    h = mpmath.mpf(duration) / steps
    for _ in range(steps):
        rows: list[list[Vector]] = []
        for j in range(columns):
            n = 2 * (j + 1)
            s = h / n
            before, now = y, [a + s * b for a, b in zip(y, rates(y), strict=True)]
            for _ in range(n - 1):
                before, now = now, [a + 2 * s * b for a, b in zip(before, rates(now), strict=True)]
            row = [[(a + b + s * c) / 2 for a, b, c in zip(before, now, rates(now), strict=True)]]
            for k in range(j):
                ratio = mpmath.mpf(j + 1) ** 2 / (j - k) ** 2 - 1
                row.append([a + (a - b) / ratio for a, b in zip(row[k], rows[-1][k], strict=True)])
            rows.append(row)
        y = rows[-1][-1]
        assert max(abs(a - b) for a, b in zip(y, rows[-1][-2], strict=True)) < mpmath.mpf("1e-24")
    return y


def numbers(values: Any) -> Vector:
    return [mpmath.mpf(float(v)) for v in np.ravel(values)]


def central(outcome: Callable[[dict[str, Vector]], Vector], given: dict[str, Any], along: dict[str, Any]) -> np.ndarray:
    """Derivative of an outcome where the given values move along a direction."""
    with mpmath.workdps(DIGITS):
        h, found = mpmath.mpf(STEP), []
        for sign in (1, -1):
            moved = {k: numbers(v) for k, v in given.items()}
            for k, d in along.items():
                moved[k] = [a + sign * h * b for a, b in zip(moved[k], numbers(d), strict=True)]
            found.append(outcome(moved))
        return np.array([float((a - b) / (2 * h)) for a, b in zip(*found, strict=True)])


def last(sensitivity: Any, direction: Any) -> np.ndarray:
    """Position, velocity and spin at the end along a direction of the parameter."""
    d = np.ravel(direction)
    parts = [sensitivity.position, sensitivity.velocity, sensitivity.angular_velocity]
    return np.concatenate([np.einsum("k,ki->i", d, x[-1]) for x in parts])


def assert_close(found: np.ndarray, expected: np.ndarray, bar: float = BAR) -> None:
    for f, e in zip(np.split(found, 3), np.split(expected, 3), strict=True):
        assert np.abs(f - e).max() <= bar * np.abs(e).max()


# -- the simulations' own differences ----------------------------------------------------------------------

#: Weights of central differences of order 8.
WEIGHTS = (4 / 5, -1 / 5, 4 / 105, -1 / 280)


def difference(state: Callable[[float], Sequence[np.ndarray]], h: float) -> list[np.ndarray]:
    """Derivative at 0 of each of the arrays of a state."""
    total: list[Any] = []
    for k, weight in enumerate(WEIGHTS, 1):
        ahead, behind = state(k * h), state(-k * h)
        parts = [weight / h * (a - b) for a, b in zip(ahead, behind, strict=True)]
        total = parts if not total else [a + b for a, b in zip(total, parts, strict=True)]
    return total


#: One of each load, all of which do nothing: one program serves all bodies that are held alike.
NOTHING: dict[str, Any] = {
    "orientation": np.zeros(3), "gravity": np.zeros(3), "damper.angular": 0.0, "damper.linear": 0.0,
    "spring.stiffness": 0.0, "spring.length": 0.0, "spring.damping": 0.0, "spring.point": np.zeros(3),
    "spring.anchor": np.array([0.0, 1.0, 4.0]), "body_wrench": np.zeros(6), "world_wrench": np.zeros(6),
}  # fmt: skip
#: Names of all parameters of such a body: 42 numbers.
PARAMETERS = ("mass", "inertia", "position", "velocity", "angular_velocity", *NOTHING)


def everything(algebra: Any, given: dict[str, Any], constraints: Sequence[Any] = (), **options: Any) -> Any:
    """A body under all loads; the orientation is a turn of `TURN`, along the body's axes."""
    p = {**NOTHING, **given}
    turn = TURN @ Rotation.from_rotvec(p["orientation"]).as_matrix()
    body = dynamics.RigidBody(
        p["mass"], p["inertia"], p["position"], turn, p["velocity"], p["angular_velocity"], algebra
    )
    wrenches = [algebra.wrap(algebra.kind("twist"), p[f"{x}_wrench"]) for x in ("body", "world")]
    loads = [
        dynamics.Gravity(p["gravity"]), dynamics.BodyWrench(wrenches[0]), dynamics.WorldWrench(wrenches[1]),
        dynamics.Damper(p["damper.angular"], p["damper.linear"]),
        dynamics.Spring(*(p[f"spring.{n}"] for n in ("point", "anchor", "stiffness", "length", "damping"))),
    ]  # fmt: skip
    return dynamics.Simulation(body, loads, constraints, **options)


def states(run: Any) -> list[np.ndarray]:
    return [run.position, run.velocity, run.angular_velocity, run.energy]
