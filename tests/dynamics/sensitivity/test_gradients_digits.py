"""Gradients of trajectories against central differences at 50 digits of Newton's and Euler's equations on vectors."""

from __future__ import annotations

from functools import cache
from typing import Any

import mpmath
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import bladesmith as bs
from bladesmith import dynamics
from bladesmith.codegen.errors import InputError

from ...oracles.gradients import (
    PARAMETERS,
    TURN,
    Vector,
    assert_close,
    central,
    cross,
    everything,
    extrapolated,
    last,
    numbers,
    turned,
    turned_back,
    turning,
)

ALGEBRAS = [bs.cga3d, bs.pga3d]
DURATION = 0.5

# -- a free body -------------------------------------------------------------------------------------------

FREE: dict[str, Any] = {
    "mass": 2.0, "inertia": (1.0, 2.0, 2.5), "velocity": (0.3, -0.2, 0.5), "angular_velocity": (0.4, 1.3, -0.6),
    "position": (1.0, 2.0, 3.0), "gravity": (0.3, 0.2, -9.81), "spring.stiffness": 30.0, "spring.length": 0.7,
    "spring.damping": 0.5, "spring.point": (0.2, 0.1, -0.4), "spring.anchor": (0.0, 1.0, 4.0),
}  # fmt: skip


def free_end(p: dict[str, Vector]) -> Vector:
    """Newton and Euler with a damped spring."""

    def rates(y: Vector) -> Vector:
        x, r, v, w = y[:3], y[3:12], y[12:15], y[15:]
        arm = turned(r, p["spring.point"])
        gap = [a - b - c for a, b, c in zip(p["spring.anchor"], x, arm, strict=True)]
        speed = [-a - b for a, b in zip(v, turned(r, cross(w, p["spring.point"])), strict=True)]
        way = mpmath.sqrt(sum(a * a for a in gap))
        closing = sum(a * b for a, b in zip(gap, speed, strict=True)) / way
        size = (p["spring.stiffness"][0] * (way - p["spring.length"][0]) + p["spring.damping"][0] * closing) / way
        force = [size * a for a in gap]
        moment = turned_back(r, cross(arm, force))
        spin = cross([a * b for a, b in zip(p["inertia"], w, strict=True)], w)
        dw = [(a + b) / c for a, b, c in zip(moment, spin, p["inertia"], strict=True)]
        dv = [g + f / p["mass"][0] for g, f in zip(p["gravity"], force, strict=True)]
        return [*v, *turning(r, w), *dv, *dw]

    y = extrapolated(rates, [*p["position"], *numbers(TURN), *p["velocity"], *p["angular_velocity"]], DURATION, 7)
    return [*y[:3], *y[12:]]


@pytest.mark.slow
@pytest.mark.compiles
def test_free_body_at_50_digits() -> None:
    pairs = [(a, "adaptive") for a in ALGEBRAS] + [(bs.pga3d, "taylor")]
    runs = [everything(a, FREE, integrator=name).run(DURATION, times=[DURATION], sensitivities=PARAMETERS)
            for a, name in pairs]  # fmt: skip
    rng = np.random.default_rng(5)
    for names in (["mass"], ["inertia"], ["velocity", "angular_velocity"], ["spring.stiffness"], list(FREE)):
        along = {name: rng.normal(size=np.shape(FREE[name])) for name in names}
        expected = central(free_end, FREE, along)
        for run in runs:
            assert_close(sum(last(run.sensitivities[n], d) for n, d in along.items()), expected)


#: What a split flow has no part for.
UNDAMPED = {**FREE, "spring.damping": 0.0}


@pytest.mark.slow
@pytest.mark.parametrize("name", ["rkmk4", "rk4", "cf4", "blanes-moan", "yoshida6", "adaptive", "taylor"])
def test_motion_of_every_integrator_at_50_digits(name: str) -> None:
    """The motion's own equations; steps of order two have errors of their own."""
    run = undamped(name).run(DURATION, step=5e-4, times=[DURATION], sensitivities=list(UNDAMPED))
    d, expected = undamped_difference()
    found = sum(last(run.sensitivities[n], x) for n, x in d.items())
    assert_close(found, expected, 1e-11 if name in ("rk4", "cf4", "rkmk4") else 1e-12)


@cache
def undamped_difference() -> tuple[dict[str, np.ndarray], np.ndarray]:
    rng = np.random.default_rng(6)
    along = {name: rng.normal(size=np.shape(UNDAMPED[name])) for name in UNDAMPED if name != "spring.damping"}
    return along, central(free_end, UNDAMPED, along)


def undamped(name: str) -> Any:
    """A body on a spring."""
    p = {n: np.array(v) for n, v in UNDAMPED.items()}
    body = dynamics.RigidBody(
        2.0, p["inertia"], p["position"], TURN, p["velocity"], p["angular_velocity"], algebra=bs.pga3d
    )
    spring = dynamics.Spring(*(p[f"spring.{n}"] for n in ("point", "anchor", "stiffness", "length", "damping")))
    return dynamics.Simulation(body, [dynamics.Gravity(p["gravity"]), spring], integrator=name)


# -- drag --------------------------------------------------------------------------------------------------

THROWN: dict[str, Any] = {
    "mass": 2.0, "inertia": (1.0, 2.0, 2.5), "velocity": (3.0, -2.0, 5.0), "angular_velocity": (0.4, 1.3, -0.6),
    "gravity": (0.3, 0.2, -9.81), "quadratic_drag.angular": 0.7, "quadratic_drag.linear": 0.4,
}  # fmt: skip


def thrown_end(p: dict[str, Vector]) -> Vector:
    """Newton and Euler with forces and moments by the squares of the velocities."""

    def rates(y: Vector) -> Vector:
        r, v, w = y[3:12], y[12:15], y[15:]
        speed, pace = (mpmath.sqrt(sum(a * a for a in x)) for x in (v, w))
        slow = p["quadratic_drag.linear"][0] * speed / p["mass"][0]
        dv = [g - slow * a for g, a in zip(p["gravity"], v, strict=True)]
        spin = cross([a * b for a, b in zip(p["inertia"], w, strict=True)], w)
        brake = [p["quadratic_drag.angular"][0] * pace * a for a in w]
        dw = [(a - b) / c for a, b, c in zip(spin, brake, p["inertia"], strict=True)]
        return [*v, *turning(r, w), *dv, *dw]

    y = extrapolated(rates, [*numbers((0, 0, 0)), *numbers(TURN), *p["velocity"], *p["angular_velocity"]], DURATION, 24)
    return [*y[:3], *y[12:]]


@pytest.mark.slow
@pytest.mark.compiles
def test_quadratic_drag_at_50_digits() -> None:
    body = dynamics.RigidBody(
        2.0, THROWN["inertia"], (0, 0, 0), TURN, THROWN["velocity"], THROWN["angular_velocity"], algebra=bs.pga3d
    )
    loads = [dynamics.Gravity(THROWN["gravity"]), dynamics.QuadraticDrag(0.7, 0.4)]
    run = dynamics.Simulation(body, loads).run(DURATION, times=[DURATION], sensitivities=list(THROWN))
    assert run.integrator == "adaptive"  # where the body rests the motion has no series
    rng = np.random.default_rng(9)
    for names in (["quadratic_drag.angular", "quadratic_drag.linear"], ["mass", "inertia"], list(THROWN)):
        along = {name: rng.normal(size=np.shape(THROWN[name])) for name in names}
        found = sum(last(run.sensitivities[n], d) for n, d in along.items())
        assert_close(found, central(thrown_end, THROWN, along), 1e-11)
    with pytest.raises(InputError, match="quadratic_drag has none where the body rests"):
        dynamics.Simulation(body, loads, integrator="taylor").run(0.1)


# -- a heavy top, and a pendulum ---------------------------------------------------------------------------

ARM = np.array([0.1, -0.2, 0.9])
TOP: dict[str, Any] = {
    "mass": 1.5, "inertia": (0.4, 0.5, 0.3), "angular_velocity": (0.5, -0.3, 12.0), "gravity": (0.0, 0.0, -9.81),
}  # fmt: skip


def top_end(p: dict[str, Vector]) -> Vector:
    """A body that turns about the origin, its centre at ARM."""
    arm, m = numbers(ARM), p["mass"][0]
    square = sum(a * a for a in arm)
    tensor = mpmath.matrix(3)
    for i in range(3):
        for j in range(3):
            tensor[i, j] = m * ((square if i == j else 0) - arm[i] * arm[j]) + (p["inertia"][i] if i == j else 0)
    inverse = tensor**-1

    def times(a: Any, x: Vector) -> Vector:
        return [sum(a[i, j] * x[j] for j in range(3)) for i in range(3)]

    def rates(y: Vector) -> Vector:
        r, w = y[:9], y[9:]
        pull = cross(arm, [m * g for g in turned_back(r, p["gravity"])])
        return [*turning(r, w), *times(inverse, [a + b for a, b in zip(pull, cross(times(tensor, w), w), strict=True)])]

    y = extrapolated(rates, [*numbers(TURN), *p["angular_velocity"]], DURATION, 8)
    r, w = y[:9], y[9:]
    return [*turned(r, arm), *turned(r, cross(w, arm)), *w]


@cache
def top_difference(name: str) -> tuple[np.ndarray, np.ndarray]:
    """A direction of a parameter, and the derivative along it."""
    d = np.random.default_rng(len(name)).normal(size=np.shape(TOP[name]))
    return d, central(top_end, TOP, {name: d})


def top_simulation(algebra: Any, **options: Any) -> Any:
    spin = np.array(TOP["angular_velocity"])
    pin = dynamics.Pin(algebra.point(-ARM), algebra.point((0, 0, 0)))
    given = {**TOP, "position": TURN @ ARM, "velocity": TURN @ np.cross(spin, ARM)}
    return everything(algebra, given, [pin], **options)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("algebra", "options"),
    [(bs.cga3d, {}), (bs.pga3d, {}), (bs.cga3d, {"stabilization": "projection"}), (bs.pga3d, {"integrator": "taylor"}),
     (bs.cga3d, {"integrator": "taylor", "stabilization": "projection"})],
)  # fmt: skip
def test_heavy_top_at_50_digits(algebra: Any, options: dict[str, str]) -> None:
    held = top_simulation(algebra, **options)
    run = held.run(DURATION, times=[DURATION], sensitivities=PARAMETERS)
    for name in TOP:
        d, expected = top_difference(name)
        found = last(run.sensitivities[name], d)
        if name == "angular_velocity":  # the centre moves with the spin
            found += last(run.sensitivities["velocity"], TURN @ np.cross(d, ARM))
        assert_close(found, expected)


HANG = {"mass": [1.5], "inertia": [0.4, 0.5, 0.3], "angle": [0.8]}
AXIS, LENGTH = np.array([0.6, 0.0, 0.8]), 1.25


def pendulum_end(p: dict[str, Vector]) -> Vector:
    """Position, velocity and spin: the angle's equation alone."""
    m, axis, arm = p["mass"][0], numbers(AXIS), mpmath.mpf(LENGTH)
    inertia = sum(i * a * a for i, a in zip(p["inertia"], axis, strict=True)) + m * arm**2
    rates = lambda y: [y[1], -m * mpmath.mpf(9.81) * arm / inertia * mpmath.sin(y[0])]  # noqa: E731
    angle, rate = extrapolated(rates, [p["angle"][0], mpmath.mpf(0)], DURATION, 4)
    c, s = arm * mpmath.cos(angle), arm * mpmath.sin(angle)
    return [s, mpmath.mpf(0), -c, rate * c, mpmath.mpf(0), rate * s, *(-rate * a for a in axis)]


@pytest.mark.compiles
@pytest.mark.parametrize("integrator", ["adaptive", pytest.param("taylor", marks=pytest.mark.slow)])
def test_pendulum_at_50_digits(integrator: str) -> None:
    """About an axis that is askew in the body; the first angle is place and orientation together."""
    level, down = np.array([0, 1.0, 0]), np.array([0, 0, -1.0])
    hang = np.array([0.8, 0, -0.6])  # across the axis in the body
    body_axes = np.stack([hang, np.cross(AXIS, hang), AXIS], 1)
    at_rest = np.stack([down, np.cross(level, down), level], 1) @ body_axes.T
    turn = Rotation.from_rotvec(-HANG["angle"][0] * level).as_matrix() @ at_rest
    place = turn @ (LENGTH * hang)
    body = dynamics.RigidBody(HANG["mass"][0], HANG["inertia"], place, turn, algebra=bs.pga3d)
    ends = [bs.pga3d.point(x - LENGTH * hang) for x in (0 * AXIS, AXIS)]
    pins = [dynamics.Pin(x) for x in ends]
    names = ["mass", "inertia", "position", "orientation"]
    run = dynamics.Simulation(body, [dynamics.Gravity((0, 0, -9.81))], pins, integrator=integrator).run(
        DURATION, times=[DURATION], sensitivities=names
    )
    found = run.sensitivities
    for name, d in (("mass", [1.0]), ("inertia", [0.3, -0.2, 0.7])):
        assert_close(last(found[name], d), central(pendulum_end, HANG, {name: d}))
    swung = last(found["orientation"], -AXIS) + last(found["position"], np.cross(-level, place))
    assert_close(swung, central(pendulum_end, HANG, {"angle": [1.0]}))
