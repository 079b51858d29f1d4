"""Gradients of implicit steps: against explicit ones where nothing is stiff, against exact solutions where it is."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import mpmath
import numpy as np
import pytest

import bladesmith as bs
from bladesmith import dynamics, kinematics

pytestmark = [pytest.mark.slow, pytest.mark.compiles]
START = {"x": 2.0, "v": -0.3, "m": 2.0, "k": 1e6, "c": 1e7, "rest": 0.5}
NAMES = {"x": "position", "v": "velocity", "m": "mass", "k": "spring.stiffness", "c": "spring.damping",
         "rest": "spring.length"}  # fmt: skip
TIMES = (1e-6, 0.01, 0.5, 2.0)


def on_a_line(integrator: str, x: float, v: float, m: float, k: float, c: float, rest: float) -> Any:
    """A body that a damped spring draws along a line."""
    body = dynamics.RigidBody(m, (1.0, 2.0, 2.5), (x, 0, 0), velocity=(v, 0, 0))
    spring = dynamics.Spring((0, 0, 0), (0, 0, 0), k, rest, c)
    return dynamics.Simulation(body, [spring], integrator=integrator)


def place(t: float, x: Any, v: Any, m: Any, k: Any, c: Any, rest: Any) -> Any:
    """Where that body is."""
    root = mpmath.sqrt(c * c - 4 * k * m)
    slow, fast = -2 * k / (c + root), -(c + root) / (2 * m)
    first = (v - fast * (x - rest)) / (slow - fast)
    return rest + first * mpmath.exp(slow * t) + (x - rest - first) * mpmath.exp(fast * t)


@pytest.mark.parametrize(("c", "k"), [(1e7, 1e6), (1e4, 1e4), (1e3, 10.0)])
def test_an_overdamped_spring_against_its_solution(c: float, k: float) -> None:
    start = {**START, "c": c, "k": k}
    names = list(NAMES.values())
    run = on_a_line("implicit", **start).run(2.0, times=TIMES, rtol=1e-9, sensitivities=names, strict=True)
    with mpmath.workdps(50):
        exact = {name: mpmath.mpf(value) for name, value in start.items()}
        for name, given in NAMES.items():
            found = run.sensitivities[given]
            for i, t in enumerate(TIMES):
                change, rate = (
                    mpmath.diff(function(t, exact, name), exact[name]) for function in (at_time, rate_at_time)
                )
                unit = 1.0 if name in "xv" else start[name]
                fast = max(1.0, c / start["m"]) if t < 1e-5 else 1.0
                assert abs(found.position[i + 1, 0, 0] - float(change)) * unit < 1e-8, (given, t)
                assert abs(found.velocity[i + 1, 0, 0] - float(rate)) * unit < 1e-8 * fast, (given, t)


def at_time(t: float, start: dict[str, Any], name: str) -> Callable[[Any], Any]:
    return lambda value: place(t, **{**start, name: value})


def rate_at_time(t: float, start: dict[str, Any], name: str) -> Callable[[Any], Any]:
    return lambda value: mpmath.diff(lambda time: place(time, **{**start, name: value}), t)


def two_bodies(integrator: str) -> Any:
    bodies = {
        "upper": dynamics.RigidBody(1.0, (0.15, 0.2, 0.3), (0, 0.5, 0), algebra=bs.pga3d),
        "lower": dynamics.RigidBody(2.0, (0.3, 0.2, 0.25), (0, 1.4, 0.2), algebra=bs.pga3d),
    }
    joints = [
        kinematics.Spherical("base", "upper", bs.pga3d.point((0, 0, 0))),
        kinematics.Spherical("upper", "lower", bs.pga3d.point((0, 1, 0))),
    ]
    spring = dynamics.Spring((0.1, 0, 0.2), (0, 0.1, 0.1), 5.0, 0.3, 0.4, body="upper", other="lower")
    system = dynamics.System(bodies, joints)
    return dynamics.Simulation(system, [dynamics.Gravity((0, 0, -9.81)), spring], integrator=integrator)


def test_two_bodies_with_joints_as_by_explicit_steps() -> None:
    names = ["upper.mass", "lower.inertia", "spring.stiffness", "spring.damping", "lower.angular_velocity"]
    found, known = (
        two_bodies(integrator).run(0.5, times=[0.2, 0.5], rtol=1e-10, sensitivities=names, strict=True)
        for integrator in ("implicit", "adaptive")
    )
    for name in names:
        ours, theirs = found.sensitivities[name], known.sensitivities[name]
        for body in ("upper", "lower"):
            for field in ("position", "velocity", "angular_velocity"):
                mine, known_ones = (np.asarray(getattr(each[body], field)) for each in (ours, theirs))
                assert np.allclose(mine, known_ones, atol=1e-8), (name, body, field)


def test_stiff_systems_choose_implicit_steps_for_sensitivities_too() -> None:
    sim = on_a_line("auto", **START)
    run = sim.run(2.0, sensitivities=["spring.damping"], strict=True)
    assert run.steps < 200
