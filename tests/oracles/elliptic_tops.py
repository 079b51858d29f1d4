"""Tops and pendulums by elliptic functions and at 30 digits, for tests of Taylor series."""

from __future__ import annotations

from functools import cache
from typing import Any

import mpmath
import numpy as np

from bladesmith import cga3d as cga
from bladesmith import pga3d as pga
from bladesmith.dynamics import (
    Pin,
    RigidBody,
)

BY_NAME = {"cga3d": cga, "pga3d": pga}
MP = mpmath.mp.clone()
MP.dps = 30
SPIN, MOMENTS = (0.1, 2.0, 0.1), (1.0, 2.0, 3.0)


class FreeTop:
    """The free top by Jacobi's elliptic functions (Landau and Lifshitz, Mechanics, 37), for L^2 > 2 E I2."""

    def __init__(self) -> None:
        mp = MP
        self.moments = i1, i2, i3 = [mp.mpf(x) for x in MOMENTS]
        spin = [mp.mpf(x) for x in SPIN]
        energy = sum(i * w * w for i, w in zip(self.moments, spin, strict=True))
        square = sum((i * w) ** 2 for i, w in zip(self.moments, spin, strict=True))
        assert square > energy * i2
        above, below = energy * i3 - square, square - energy * i1
        self.amplitudes = (
            mp.sqrt(above / (i1 * (i3 - i1))),
            mp.sqrt(above / (i2 * (i3 - i2))),
            mp.sqrt(below / (i3 * (i3 - i1))),
        )
        self.rate = mp.sqrt((i3 - i2) * below / (i1 * i2 * i3))
        self.parameter = (i2 - i1) * above / ((i3 - i2) * below)
        self.begin = mp.ellipf(mp.asin(spin[1] / self.amplitudes[1]), self.parameter)
        self.length = mp.sqrt(square)

    @cache  # noqa: B019
    def spin(self, t: Any) -> list[Any]:
        """Along the body's axes."""
        u = self.begin + self.rate * t
        return [
            a * MP.ellipfun(f, u, m=self.parameter) for a, f in zip(self.amplitudes, ("cn", "sn", "dn"), strict=True)
        ]

    def turn(self, t: Any, precession: Any) -> Any:
        """Body to a frame whose third axis is along the angular momentum, by Euler's angles."""
        a, b, c = (i * w / self.length for i, w in zip(self.moments, self.spin(t), strict=True))
        tilt, roll = MP.acos(c), MP.atan2(a, b)

        def about_third(x: Any) -> Any:
            return MP.matrix([[MP.cos(x), -MP.sin(x), 0], [MP.sin(x), MP.cos(x), 0], [0, 0, 1]])

        lean = MP.matrix([[1, 0, 0], [0, MP.cos(tilt), -MP.sin(tilt)], [0, MP.sin(tilt), MP.cos(tilt)]])
        return about_third(precession) * lean * about_third(roll)

    def orientation(self, t: float) -> Any:
        """Body to world, the world's axes being the body's at the start: the precession is an integral."""

        def rate(time: Any) -> Any:
            w = self.spin(time)
            parts = [i * x * x for i, x in zip(self.moments, w, strict=True)]
            return self.length * (parts[0] + parts[1]) / (self.moments[0] * parts[0] + self.moments[1] * parts[1])

        precession = MP.quad(rate, MP.linspace(0, t, max(2, int(t) + 1)))
        turn = self.turn(MP.mpf(0), MP.mpf(0)).T * self.turn(MP.mpf(t), precession)
        return np.array(turn.tolist(), float)


@cache
def free_top() -> FreeTop:
    return FreeTop()


HEAVY = {"mass": 1.0, "moments": (1.5, 2.0, 1.8), "center": (0.1, 0.1, 0.4), "gravity": 9.81, "spin": (1.0, 2.0, 0.5)}
HEAVY_TIME = 1.0


@cache
def heavy_top() -> Any:
    """Spin and quaternion (w, x, y, z) of the heavy top at its end, to 30 digits; moments are about the pin."""
    i1, i2, i3 = (MP.mpf(x) for x in HEAVY["moments"])
    c1, c2, c3 = (MP.mpf(x) for x in HEAVY["center"])
    weight = MP.mpf(HEAVY["mass"]) * MP.mpf(HEAVY["gravity"])

    def rates(t: Any, y: list[Any]) -> list[Any]:
        w1, w2, w3, a, b, c, d = y
        f1, f2, f3 = (-weight * x for x in (2 * (b * d - a * c), 2 * (c * d + a * b), a * a - b * b - c * c + d * d))
        return [
            (c2 * f3 - c3 * f2 + (i2 - i3) * w2 * w3) / i1,
            (c3 * f1 - c1 * f3 + (i3 - i1) * w3 * w1) / i2,
            (c1 * f2 - c2 * f1 + (i1 - i2) * w1 * w2) / i3,
            (-b * w1 - c * w2 - d * w3) / 2, (a * w1 + c * w3 - d * w2) / 2,
            (a * w2 + d * w1 - b * w3) / 2, (a * w3 + b * w2 - c * w1) / 2,
        ]  # fmt: skip

    start = [*(MP.mpf(x) for x in HEAVY["spin"]), MP.mpf(1), MP.mpf(0), MP.mpf(0), MP.mpf(0)]
    return np.array([float(x) for x in MP.odefun(rates, 0, start)(HEAVY_TIME)])


def heavy_body(algebra: str) -> tuple[RigidBody, Pin]:
    """The pin is the world's origin; moments about it become those about the centre."""
    c, mass, spin = np.array(HEAVY["center"]), HEAVY["mass"], np.array(HEAVY["spin"])
    inertia = np.diag(HEAVY["moments"]) - mass * (c @ c * np.eye(3) - np.outer(c, c))
    used = BY_NAME[algebra]
    body = RigidBody(mass, inertia, position=c, velocity=np.cross(spin, c), angular_velocity=spin, algebra=used)
    return body, Pin(used.point(-c))


def pendulum_angle(rate: Any, times: Any) -> Any:
    """Of a pendulum that is let go at the horizontal: sin(angle/2) = k sn(K - t rate), k^2 = 1/2."""
    quarter, half = MP.ellipk(0.5), MP.sqrt(0.5)
    sines = [half * MP.ellipfun("sn", quarter - rate * MP.mpf(float(t)), m=0.5) for t in times]
    return np.array([float(2 * MP.asin(x)) for x in sines])
