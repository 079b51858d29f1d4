"""Interrupts at random moments of long calls of every chapter: they take effect within half a second.

`BLADESMITH_FUZZ=20 python -m pytest -s -n 0 -m "" tests/fuzz/test_interrupts.py` tries twenty of each, of large arrays.
"""

from __future__ import annotations

import math
import os
import signal
import threading
import time
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import curves, dynamics, kinematics, objects, poses, tracer
from bladesmith.errors import Interrupted

ROUNDS = int(os.environ.get("BLADESMITH_FUZZ", "2"))
IS_FULL = "BLADESMITH_FUZZ" in os.environ
#: Seconds from an interrupt to the end of a call; a machine that others use is given more.
BAR = 0.5 if IS_FULL else 3.0
#: Numbers of an argument or a result: 8 bytes each.
LARGE = 30_000_000 if IS_FULL else 2_000_000
#: Seconds of a call in which interrupts come; and after one, from which on it counts as lost.
LONGEST, LOST = 5.0, 0.05
CGA, PGA = bs.cga3d, bs.pga3d
Call = Callable[[], object]


def _points() -> np.ndarray:
    return np.random.default_rng(1).normal(size=(LARGE // 5, 3))


def _rotors() -> bs.Multivector:
    turns = np.random.default_rng(2).normal(size=(LARGE // 5, 3))
    return CGA.translator(turns) * CGA.rotor((0, 0, 1.0), turns[:, 0])


def _circles() -> bs.Multivector:
    x = np.random.default_rng(3).normal(size=(3, LARGE // 10, 3))
    return (CGA.point(x[0]) ^ CGA.point(x[1]) ^ CGA.point(x[2])).normalized()


def _points_of_arrays(folder: Path) -> Call:
    x = _points()
    return lambda: CGA.point(x)


def _sandwich(folder: Path) -> Call:
    rotors, points = _rotors(), CGA.point(_points())
    return lambda: rotors >> points


def _logarithm(folder: Path) -> Call:
    rotors = _rotors()
    return lambda: rotors.log()


def _exponential(folder: Path) -> Call:
    logs = _rotors().log()
    return lambda: logs.exp()


def _normalized(folder: Path) -> Call:
    circles = _circles()
    return lambda: circles.normalized()


def _parameters(folder: Path) -> Call:
    circles = _circles()
    return lambda: circles.parameters()


def _rotors_between(folder: Path) -> Call:
    circles = _circles()
    return lambda: objects.rotor_between(circles, circles[::-1])


def _products(folder: Path) -> Call:
    values = np.random.default_rng(4).normal(size=(LARGE // 20, 32))
    x = CGA.multivector(values)
    return lambda: x * x


def _sum(folder: Path) -> Call:
    x = CGA.multivector(np.ones((LARGE // 32, 32)))
    return lambda: x + 2.0 * x


def _inverse(folder: Path) -> Call:
    x = CGA.multivector(np.random.default_rng(5).normal(size=(LARGE // 100, 32)))
    return lambda: x.inverse()


def _interpolation(folder: Path) -> Call:
    circles = _circles()
    return lambda: objects.interpolate(circles, circles[::-1], alpha=0.3)


def _costs(folder: Path) -> Call:
    circles = _circles()[: math.isqrt(LARGE)]
    return lambda: objects.cost_matrix(circles, circles[::-1])


def _clusters(folder: Path) -> Call:
    circles = _circles()[: LARGE // 200]
    return lambda: objects.kmeans(circles, 50)


def _quaternions(folder: Path) -> Call:
    motors = PGA.translator(_points()) * PGA.rotor((0, 0, 1.0), 0.3)
    return lambda: poses.to_quaternion(motors)


def _matrices(folder: Path) -> Call:
    motors = PGA.translator(_points()) * PGA.rotor((0, 0, 1.0), 0.3)
    matrices = poses.to_matrix(motors)
    return lambda: poses.from_matrix(matrices)


def _curve(folder: Path) -> Call:
    tube = curves.KochanekBartels(_circles()[:4])
    t = np.linspace(0, 3, LARGE // 10)
    return lambda: tube(t)


def _surface() -> tracer.EvolvedCircles:
    ring = CGA.circle(center=[[0, 0, 0], [0, 1, 2]], normal=[[0, 0, 1], [0, 0.5, 1]], radius=[1.0, 0.6])
    return tracer.EvolvedCircles(curves.Bezier(ring))


def _hits(folder: Path) -> Call:
    surface = _surface()
    n = LARGE // 5
    origins = np.column_stack([np.random.default_rng(6).uniform(-2, 2, (n, 2)), np.full(n, -5.0)])
    return lambda: surface.intersect(origins, (0.0, 0.0, 1.0))


def _picture(folder: Path) -> Call:
    camera = tracer.Camera.look_at((0, 0, -6), (1, 0, 2), up=(0, 1, 0))
    scene, n = tracer.Scene(camera, [tracer.Light((3, 5, -5))], [_surface()]), math.isqrt(LARGE)
    return lambda: scene.render(n, n)


def _mesh(folder: Path) -> Call:
    surface, n = _surface(), math.isqrt(LARGE // 10)
    return lambda: surface.mesh(n, n)


def _save(folder: Path) -> Call:
    x = CGA.multivector(np.random.default_rng(7).normal(size=(LARGE // 100, 32)))
    return lambda: bs.save(folder / "x.npz", x)


def _load(folder: Path) -> Call:
    x = CGA.multivector(np.random.default_rng(7).normal(size=(LARGE // 100, 32)))
    bs.save(folder / "x.npz", x)
    return lambda: bs.load(folder / "x.npz")


def _load_points(folder: Path) -> Call:
    """Coefficients are checked to be those of points."""
    bs.save(folder / "x.npz", CGA.point(_points()))
    return lambda: bs.load(folder / "x.npz")


def _chain() -> kinematics.Chain:
    ways = [(0, 0, 1.0), (0, 1.0, 0), (1.0, 0, 0)]
    axes = [kinematics.revolute_axis((i, 0.1 * i, 0.2 * (i % 2)), ways[i % 3]) for i in range(6)]
    return kinematics.Chain(axes, tool=CGA.translator((6.5, 0, 0)))


def _forward(folder: Path) -> Call:
    chain, angles = _chain(), np.random.default_rng(8).uniform(-1, 1, (LARGE // 10, 6))
    return lambda: chain.forward(angles)


def _inverse_kinematics(folder: Path) -> Call:
    chain, angles = _chain(), np.random.default_rng(8).uniform(-1, 1, (LARGE // 50, 6))
    targets = chain.forward(angles)
    return lambda: chain.inverse(targets, start=angles + 0.1, threads=1)


def _delta(folder: Path) -> Call:
    robot = kinematics.DeltaRobot(base_radius=0.2, effector_radius=0.05, upper_arm=0.3, forearm=0.8)
    angles = np.random.default_rng(9).uniform(0.1, 0.6, (LARGE // 5, 3))
    return lambda: robot.forward(angles)


def _simulation(folder: Path) -> Call:
    body = dynamics.RigidBody(2.0, (1, 2, 2.5), angular_velocity=(0.01, 5, 0))
    return lambda: dynamics.Simulation(body).run(LARGE / 1000, step=0.01)


def _simulations(folder: Path) -> Call:
    body = dynamics.RigidBody(np.full(LARGE // 3000, 2.0), (1, 2, 2.5), angular_velocity=(0.01, 5, 0))
    return lambda: dynamics.Simulation(body).run(30.0, step=0.01)


CALLS = {
    name: make
    for name, make in dict(globals()).items()
    if name.startswith("_") and getattr(make, "__annotations__", {}).get("return") == "Call"
}


def _waited(call: Call, delay: float) -> float | None:
    """Seconds from an interrupt until a call is left; None where it had ended, infinite where it was lost."""
    sent: list[float] = []

    def send() -> None:
        sent.append(time.monotonic())
        os.kill(os.getpid(), signal.SIGINT)

    timer = threading.Timer(delay, send)
    try:
        timer.start()
        try:
            call()
            return math.inf if sent and time.monotonic() - sent[0] > LOST else None
        finally:
            timer.cancel()
            timer.join()
    except (KeyboardInterrupt, Interrupted):
        return time.monotonic() - sent[0]


@pytest.mark.service
@pytest.mark.parametrize("name", CALLS, ids=lambda name: name[1:])
def test_an_interrupt_ends_a_call(name: str, tmp_path: Path) -> None:
    call = CALLS[name](tmp_path)
    start = time.monotonic()
    call()
    whole = min(time.monotonic() - start, LONGEST)
    rng = np.random.default_rng(zlib.crc32(name.encode()))
    found = [_waited(call, rng.uniform(0.02, 0.9) * whole) for _ in range(ROUNDS)]
    times = [seconds for seconds in found if seconds is not None]
    print(f"{name[1:]}: {whole:.2f} s, {len(times)} of {ROUNDS} interrupted, after {max(times, default=0):.3f} s")
    assert max(times, default=0) < BAR
