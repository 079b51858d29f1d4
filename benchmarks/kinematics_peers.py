"""The Delta robot by those whom people would use instead, each as its users write the thesis's formulas (7.7.2, 7.7.5):
numba, NumPy and clifford. What bench_kinematics.py measures; Pinocchio's arm is that of the study `chains`.

A robot is (base - effector radius, upper arm, forearm); the elbow turned outwards solves a cos t + b sin t = c, and the
platform is where three spheres about the elbows meet. Jacobians are from F dy = d dtheta, rows of F the forearms.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from importlib.util import find_spec
from typing import Any

import numpy as np

Solve = Callable[[Any], Any]
#: Directions s_i of the arms.
OUTWARDS = np.array([[1, 0, 0], [-0.5, np.sqrt(0.75), 0], [-0.5, -np.sqrt(0.75), 0]])
WORKS = ("inverse", "forward", "inverse_jacobian", "forward_jacobian")


def missing(package: str) -> bool:
    """Whether a peer is not installed."""
    return find_spec(package) is None


# -- numba -------------------------------------------------------------------------------------------------


@cache
def numba_loops() -> dict[str, Any]:
    """Loops over poses, by what they solve."""
    from math import atan2, cos, sin, sqrt

    from numba import njit

    half, high = 0.5, float(np.sqrt(0.75))

    @njit(inline="always")
    def angle(x, y, z, sx, sy, r, e, p):  # type: ignore[no-untyped-def]
        ux, uy = x - r * sx, y - r * sy
        a, b = ux * sx + uy * sy, z
        c = (e * e + ux * ux + uy * uy + z * z - p * p) / (2 * e)
        h = sqrt(a * a + b * b - c * c)
        return c * a + h * b, c * b - h * a

    @njit(inline="always")
    def place(t0, t1, t2, r, e, p):  # type: ignore[no-untyped-def]
        o0, o1, o2 = r + e * cos(t0), r + e * cos(t1), r + e * cos(t2)
        ax, ay, az = o0, 0.0, e * sin(t0)
        bx, by, bz = -half * o1, high * o1, e * sin(t1)
        cx, cy, cz = -half * o2, -high * o2, e * sin(t2)
        ux, uy, uz, vx, vy, vz = bx - ax, by - ay, bz - az, cx - ax, cy - ay, cz - az
        nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        n, uu, vv = nx * nx + ny * ny + nz * nz, ux * ux + uy * uy + uz * uz, vx * vx + vy * vy + vz * vz
        wx, wy, wz = uu * vx - vv * ux, uu * vy - vv * uy, uu * vz - vv * uz
        k = 0.5 / n
        mx, my, mz = k * (wy * nz - wz * ny), k * (wz * nx - wx * nz), k * (wx * ny - wy * nx)
        h = sqrt((p * p - mx * mx - my * my - mz * mz) / n)
        return ax + mx + h * nx, ay + my + h * ny, az + mz + h * nz

    @njit
    def inverse(given, r, e, p, found):  # type: ignore[no-untyped-def]
        for i in range(len(given)):
            x, y, z = given[i, 0], given[i, 1], given[i, 2]
            c, s = angle(x, y, z, 1.0, 0.0, r, e, p)
            found[i, 0] = atan2(s, c)
            c, s = angle(x, y, z, -half, high, r, e, p)
            found[i, 1] = atan2(s, c)
            c, s = angle(x, y, z, -half, -high, r, e, p)
            found[i, 2] = atan2(s, c)

    @njit
    def forward(given, r, e, p, found):  # type: ignore[no-untyped-def]
        for i in range(len(given)):
            found[i, 0], found[i, 1], found[i, 2] = place(given[i, 0], given[i, 1], given[i, 2], r, e, p)

    @njit(inline="always")
    def row(x, y, z, c, s, sx, sy, r, e):  # type: ignore[no-untyped-def]
        o = r + e * c
        fx, fy, fz = x - o * sx, y - o * sy, z - e * s
        return fx, fy, fz, e * (fz * c - s * (fx * sx + fy * sy))

    @njit
    def inverse_jacobian(given, r, e, p, found):  # type: ignore[no-untyped-def]
        for i in range(len(given)):
            x, y, z = given[i, 0], given[i, 1], given[i, 2]
            for k in range(3):
                sx, sy = (1.0, 0.0) if k == 0 else (-half, high if k == 1 else -high)
                c, s = angle(x, y, z, sx, sy, r, e, p)
                size = sqrt(c * c + s * s)
                fx, fy, fz, d = row(x, y, z, c / size, s / size, sx, sy, r, e)
                found[i, k, 0], found[i, k, 1], found[i, k, 2] = fx / d, fy / d, fz / d

    @njit
    def forward_jacobian(given, r, e, p, found):  # type: ignore[no-untyped-def]
        for i in range(len(given)):
            t0, t1, t2 = given[i, 0], given[i, 1], given[i, 2]
            x, y, z = place(t0, t1, t2, r, e, p)
            fx, fy, fz, d0 = row(x, y, z, cos(t0), sin(t0), 1.0, 0.0, r, e)
            gx, gy, gz, d1 = row(x, y, z, cos(t1), sin(t1), -half, high, r, e)
            hx, hy, hz, d2 = row(x, y, z, cos(t2), sin(t2), -half, -high, r, e)
            ax, ay, az = gy * hz - gz * hy, gz * hx - gx * hz, gx * hy - gy * hx
            bx, by, bz = hy * fz - hz * fy, hz * fx - hx * fz, hx * fy - hy * fx
            cx, cy, cz = fy * gz - fz * gy, fz * gx - fx * gz, fx * gy - fy * gx
            v = 1 / (fx * ax + fy * ay + fz * az)
            d0, d1, d2 = d0 * v, d1 * v, d2 * v
            found[i, 0, 0], found[i, 0, 1], found[i, 0, 2] = ax * d0, bx * d1, cx * d2
            found[i, 1, 0], found[i, 1, 1], found[i, 1, 2] = ay * d0, by * d1, cy * d2
            found[i, 2, 0], found[i, 2, 1], found[i, 2, 2] = az * d0, bz * d1, cz * d2

    loops = (inverse, forward, inverse_jacobian, forward_jacobian)
    return dict(zip(WORKS, loops, strict=True))


def by_numba(lengths: tuple[float, ...], work: str) -> Solve:
    """One of `WORKS` for poses (n, 3)."""
    base, effector, upper, fore = lengths
    loop = numba_loops()[work]

    def run(given: Any) -> Any:
        found = np.empty((len(given), 3, 3) if "jacobian" in work else (len(given), 3))
        loop(given, base - effector, upper, fore, found)
        return found

    return run


# -- NumPy -------------------------------------------------------------------------------------------------


def numpy_inverse(lengths: tuple[float, ...], y: Any) -> Any:
    """Angles (n, 3)."""
    base, effector, upper, fore = lengths
    u = y[:, None] - (base - effector) * OUTWARDS
    a, b = (u * OUTWARDS).sum(-1), u[:, :, 2]
    c = (upper**2 + (u * u).sum(-1) - fore**2) / (2 * upper)
    h = np.sqrt(a * a + b * b - c * c)
    return np.arctan2(c * b - h * a, c * a + h * b)


def numpy_elbows(lengths: tuple[float, ...], theta: Any) -> Any:
    """Pseudo-elbows a_i (n, 3, 3)."""
    base, effector, upper, _ = lengths
    found = (base - effector + upper * np.cos(theta))[..., None] * OUTWARDS
    found[..., 2] = upper * np.sin(theta)
    return found


def numpy_forward(lengths: tuple[float, ...], theta: Any) -> Any:
    """Positions (n, 3)."""
    a = numpy_elbows(lengths, theta)
    u, v = a[:, 1] - a[:, 0], a[:, 2] - a[:, 0]
    normal = np.cross(u, v)
    size = (normal * normal).sum(-1, keepdims=True)
    way = (u * u).sum(-1, keepdims=True) * v - (v * v).sum(-1, keepdims=True) * u
    middle = np.cross(way, normal) / (2 * size)
    return a[:, 0] + middle + normal * np.sqrt((lengths[3] ** 2 - (middle * middle).sum(-1, keepdims=True)) / size)


def numpy_matrices(lengths: tuple[float, ...], theta: Any, y: Any) -> tuple[Any, Any]:
    """F (n, 3, 3) and d (n, 3)."""
    rows = y[:, None] - numpy_elbows(lengths, theta)
    path = -np.sin(theta)[..., None] * OUTWARDS
    path[..., 2] = np.cos(theta)
    return rows, lengths[2] * (rows * path).sum(-1)


def by_numpy(lengths: tuple[float, ...], work: str) -> Solve:
    """One of `WORKS` for poses (n, 3)."""

    def inverse_jacobian(y: Any) -> Any:
        rows, speeds = numpy_matrices(lengths, numpy_inverse(lengths, y), y)
        return rows / speeds[..., None]

    def forward_jacobian(theta: Any) -> Any:
        rows, speeds = numpy_matrices(lengths, theta, numpy_forward(lengths, theta))
        return np.linalg.solve(rows, speeds[..., None] * np.eye(3))

    return {
        "inverse": lambda y: numpy_inverse(lengths, y), "forward": lambda theta: numpy_forward(lengths, theta),
        "inverse_jacobian": inverse_jacobian, "forward_jacobian": forward_jacobian,
    }[work]  # fmt: skip


# -- clifford ----------------------------------------------------------------------------------------------


def by_clifford(lengths: tuple[float, ...], work: str) -> Solve:
    """Point pairs and projectors as printed, with the reverse of the pair for the outer elbow and the far position;
    Jacobians by central differences. One pose (3,) in a call."""
    from clifford import g3c

    layout, blades, stuff = g3c.layout, g3c.blades, g3c.stuff
    up, down, infinity, five = stuff["up"], stuff["down"], stuff["einf"], layout.pseudoScalar
    e1, e2, e3 = (blades[f"e{i}"] for i in (1, 2, 3))
    space = e1 ^ e2 ^ e3
    base, effector, upper, fore = lengths
    outwards = [float(s[0]) * e1 + float(s[1]) * e2 for s in OUTWARDS]

    def scalar(x: Any) -> float:
        return float(x.value[0])

    def extracted(pair: Any) -> Any:
        projector = 0.5 * (1 - pair / abs(scalar(pair * pair)) ** 0.5)
        return down(-(~projector) * (pair | infinity))

    def inverse(y: Any) -> Any:
        place, found = float(y[0]) * e1 + float(y[1]) * e2 + float(y[2]) * e3, []
        for s in outwards:
            sphere = up(place + effector * s) - 0.5 * fore**2 * infinity
            circle = (up(base * s) - 0.5 * upper**2 * infinity) ^ (space * (s ^ e3))
            z = extracted((circle ^ sphere) * five) - base * s
            found.append(np.arctan2(scalar(z | e3), scalar(z | s)))
        return np.array(found)

    def forward(theta: Any) -> Any:
        meet: Any = 1
        for t, s in zip(theta, outwards, strict=True):
            elbow = (base - effector + upper * np.cos(t)) * s + upper * np.sin(t) * e3
            meet = meet ^ (up(elbow) - 0.5 * fore**2 * infinity)
        y = extracted(five * meet)
        return np.array([scalar(y | e) for e in (e1, e2, e3)])

    def differences(solve: Solve) -> Solve:
        steps = 1e-5 * np.eye(3)
        return lambda x: np.stack([(solve(x + h) - solve(x - h)) / 2e-5 for h in steps], -1)

    return {
        "inverse": inverse, "forward": forward, "inverse_jacobian": differences(inverse),
        "forward_jacobian": differences(forward),
    }[work]  # fmt: skip


#: Peer, its package, how it is made, and how many poses one call takes (None: all).
PEERS: dict[str, tuple[str, Callable[[tuple[float, ...], str], Solve], int | None]] = {
    "numba": ("numba", by_numba, None),
    "NumPy": ("numpy", by_numpy, None),
    "clifford, pose by pose": ("clifford", by_clifford, 1),
}
