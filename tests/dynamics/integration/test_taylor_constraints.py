"""Held motions by Taylor series: reactions are series, too."""

from __future__ import annotations

from functools import cache
from typing import Any

import mpmath
import numpy as np
import pytest

from bladesmith import cga3d as cga
from bladesmith.dispatch.formulas import evaluate
from bladesmith.dynamics import (
    Gravity,
    Incidence,
    Pin,
    RigidBody,
    Simulation,
    System,
    VirtualPower,
)

from ...oracles.elliptic_tops import HEAVY, HEAVY_TIME, MP, heavy_body, heavy_top, pendulum_angle


@pytest.mark.slow
def test_heavy_top_by_projection() -> None:
    """The same motion, held by reactions instead of by its subspace."""
    body, pin = heavy_body("cga3d")
    gravity = Gravity([0, 0, -HEAVY["gravity"]])
    held = Simulation(body, [gravity], [pin], integrator="taylor", stabilization="projection")
    for rtol in (1e-6, 1e-9, 1e-12):
        found = held.run(HEAVY_TIME, times=[0.5, HEAVY_TIME], rtol=rtol)
        assert np.abs(found.angular_velocity[-1] - heavy_top()[:3]).max() <= 100 * rtol
        assert found.violation.max() <= 1e-14
    other = Simulation(body, [gravity], [pin], integrator="taylor").run(HEAVY_TIME, times=[0.5, HEAVY_TIME], rtol=1e-12)
    np.testing.assert_allclose(found.position, other.position, rtol=0, atol=1e-11)
    np.testing.assert_allclose(found.reaction.values, other.reaction.values, rtol=0, atol=1e-10)


def test_point_on_a_sphere_swings_as_a_pendulum_does() -> None:
    """A row of a matrix on a point's coefficients; by elliptic functions."""
    length, gravity, times = 0.8, 9.81, np.linspace(0, 2, 9)
    body = RigidBody(1.5, [0.1, 0.2, 0.3], position=[length, 0, 0], angular_velocity=[0, 0, 2])
    sphere = Incidence(cga.point([0, 0, 0]), cga.sphere([0, 0, 0], length))
    found = Simulation(body, [Gravity([0, 0, -gravity])], [sphere], integrator="taylor").run(2, times=times, rtol=1e-11)
    angle = pendulum_angle(MP.sqrt(MP.mpf(gravity) / MP.mpf(length)), times)
    expected = length * np.array([np.sin(angle), 0 * angle, -np.cos(angle)]).T
    np.testing.assert_allclose(found.position, expected, rtol=0, atol=1e-9)
    np.testing.assert_allclose(found.angular_velocity, np.tile([0, 0, 2.0], (9, 1)), rtol=0, atol=1e-9)
    assert found.violation.max() < 1e-12


@cache
def double_pendulum(time: float) -> list[float]:
    """Angles of a planar double pendulum from the horizontal, by Lagrange's equations."""
    mp = mpmath.mp.clone()
    mp.dps = 18  # 30 would take seconds
    first, second, joint, weights = (
        mp.mpf("1.7"),
        mp.mpf("0.45"),
        mp.mpf("0.5"),
        (2 * mp.mpf("9.81"), mp.mpf("9.81") / 2),
    )

    def rates(t: Any, y: list[Any]) -> list[Any]:
        a, b, da, db = y
        c, s = joint * mp.cos(a - b), joint * mp.sin(a - b)
        one, two = -s * db * db - weights[0] * mp.sin(a), s * da * da - weights[1] * mp.sin(b)
        size = first * second - c * c
        return [da, db, (second * one - c * two) / size, (first * two - c * one) / size]

    return [float(x) for x in mp.odefun(rates, 0, [mp.pi / 2, mp.pi / 2, 0, 0])(time)[:2]]


@pytest.mark.compiles
def test_joint_between_bodies() -> None:
    """Masses 2 and 1, moments 0.2 about their centres at half of a length of 1; redundant rows in each hinge."""
    bodies = {
        "upper": RigidBody(2.0, [0.1, 0.2, 0.25], position=[0.5, 0, 0]),
        "lower": RigidBody(1.0, [0.1, 0.2, 0.25], position=[1.5, 0, 0]),
    }
    near, far = cga.line([-0.5, 0, 0], [0, 1, 0]), cga.line([0.5, 0, 0], [0, 1, 0])
    hinges = [Pin(near, body="upper"), Pin(far, near, body="upper", other="lower")]
    held = Simulation(System(bodies), [Gravity([0, 0, -9.81])], hinges, integrator="taylor")
    for rtol in (1e-7, 1e-12):
        found = held.run(0.4, times=[0.3, 0.4], rtol=rtol)
        a, b = double_pendulum(0.4)
        upper, lower = (found.bodies[name].position[-1] for name in ("upper", "lower"))
        assert np.abs(upper - 0.5 * np.array([np.sin(a), 0, -np.cos(a)])).max() <= 100 * rtol
        assert np.abs(lower - 2 * upper - 0.5 * np.array([np.sin(b), 0, -np.cos(b)])).max() <= 100 * rtol
        assert found.violation.max() <= 1e-13


@pytest.mark.compiles
def test_constraint_on_velocities() -> None:
    """A wrench without power on the motion, through the centre of mass at first: by the adaptive integrator."""
    body = RigidBody(1.5, [0.2, 0.3, 0.4], angular_velocity=[1, 2, -1], velocity=[0, 1, 0])
    wrench = evaluate(cga, "mechanics.screw_of", cga.spatial([1, 0, 0], "f"), cga.spatial([0, 0, 0], "m")).value
    found, other = (
        Simulation(body, [Gravity([1, 2, -9.81])], [VirtualPower(wrench)], integrator=name).run(
            0.5, times=[0.2, 0.5], rtol=1e-12
        )
        for name in ("taylor", "adaptive")
    )
    np.testing.assert_allclose(found.position, other.position, rtol=0, atol=1e-11)
    np.testing.assert_allclose(found.angular_velocity, other.angular_velocity, rtol=0, atol=1e-10)
    np.testing.assert_allclose(found.reaction.values, other.reaction.values, rtol=0, atol=1e-9)
    assert found.steps < other.steps
