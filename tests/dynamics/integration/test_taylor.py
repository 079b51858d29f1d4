"""Motions by Taylor series, free and loaded: against elliptic functions, 30 digits and closed forms."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest

from bladesmith import cga3d as cga
from bladesmith import pga3d as pga
from bladesmith.codegen.errors import InputError
from bladesmith.dispatch.formulas import evaluate
from bladesmith.dynamics import (
    BodyWrench,
    Damper,
    Gravity,
    Pin,
    PinPath,
    RigidBody,
    Simulation,
    Spring,
    WorldWrench,
)
from bladesmith.dynamics.integration.integrators import order_of

from ...oracles.elliptic_tops import (
    HEAVY,
    HEAVY_TIME,
    MOMENTS,
    MP,
    SPIN,
    free_top,
    heavy_body,
    heavy_top,
    pendulum_angle,
)

ALGEBRAS = ["cga3d", "pga3d"]
BY_NAME = {"cga3d": cga, "pga3d": pga}
TOLERANCES = [1e-6, 1e-9, 1e-12, 1e-14]

NO_GRAVITY = Gravity([0, 0, 0])  # one program serves all free bodies


def free_body(algebra: str) -> RigidBody:
    return RigidBody(
        2.0, MOMENTS, position=[3, 1, -2], velocity=[1, 0.5, 0], angular_velocity=SPIN, algebra=BY_NAME[algebra]
    )


@pytest.mark.parametrize("rtol", TOLERANCES)
@pytest.mark.parametrize("algebra", ALGEBRAS)
def test_free_top(algebra: str, rtol: float) -> None:
    """At the ends of steps, and as exactly between them; gravity bends the flight alone."""
    times = np.linspace(0, 20, 41)
    found = Simulation(free_body(algebra), [Gravity([0, 0, -9.81])], integrator="taylor").run(
        20, times=times, rtol=rtol
    )
    expected = np.array([[float(x) for x in free_top().spin(MP.mpf(float(t)))] for t in times])
    error = np.abs(found.angular_velocity - expected).max()
    assert error <= 300 * rtol + 1e-13
    assert rtol < 1e-10 or error > 1e-14  # the tolerance is what decides
    assert found.steps < 100
    way = np.array([3, 1, -2]) + times[:, None] * [1, 0.5, 0] - 9.81 / 2 * times[:, None] ** 2 * [0, 0, 1]
    np.testing.assert_allclose(found.position, way, rtol=1e-14, atol=1e-12)
    np.testing.assert_allclose(found.velocity, np.gradient(way, times, axis=0, edge_order=2), rtol=0, atol=1e-9)


@pytest.mark.slow
def test_orientation_of_the_free_top() -> None:
    times = [0.0, 2.3, 5.0]
    expected = np.array([free_top().orientation(t) for t in times])
    for algebra in ALGEBRAS:
        found = Simulation(free_body(algebra), [NO_GRAVITY], integrator="taylor").run(5, times=times, rtol=1e-13)
        np.testing.assert_allclose(found.orientation, expected, rtol=0, atol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("rtol", TOLERANCES)
@pytest.mark.parametrize("algebra", ALGEBRAS)
def test_heavy_top(algebra: str, rtol: float) -> None:
    body, pin = heavy_body(algebra)
    gravity = Gravity([0, 0, -HEAVY["gravity"]])
    found = Simulation(body, [gravity], [pin], integrator="taylor").run(HEAVY_TIME, times=[HEAVY_TIME], rtol=rtol)
    spin, (a, b, c, d) = heavy_top()[:3], heavy_top()[3:]
    turn = np.array([
        [a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c)],
        [2 * (b * c + a * d), a * a - b * b + c * c - d * d, 2 * (c * d - a * b)],
        [2 * (b * d - a * c), 2 * (c * d + a * b), a * a - b * b - c * c + d * d],
    ])  # fmt: skip
    assert np.abs(found.angular_velocity[-1] - spin).max() <= 100 * rtol + 2e-14
    assert np.abs(found.orientation[-1] - turn).max() <= 100 * rtol + 2e-14
    np.testing.assert_allclose(found.position[-1], turn @ HEAVY["center"], rtol=0, atol=100 * rtol + 2e-14)


def test_pendulum_from_rest_at_the_horizontal() -> None:
    """Of the angle's coefficients three in four vanish."""
    mass, length, gravity = 1.5, 0.8, 9.81
    body = RigidBody(mass, [0.1, 0.2, 0.3], position=[length, 0, 0])
    hinge = Pin(cga.line([-length, 0, 0], [0, 1, 0]))
    times = np.linspace(0, 3, 13)
    rate = MP.sqrt(MP.mpf(mass) * MP.mpf(length) * MP.mpf(gravity) / (MP.mpf(0.2) + MP.mpf(mass) * MP.mpf(length) ** 2))
    angle = pendulum_angle(rate, times)
    expected = length * np.array([np.sin(angle), 0 * angle, -np.cos(angle)]).T
    for rtol in (1e-7, 1e-10, 1e-13):
        found = Simulation(body, [Gravity([0, 0, -gravity])], [hinge], integrator="taylor").run(
            3, times=times, rtol=rtol
        )
        assert np.abs(found.position - expected).max() <= 100 * rtol
        assert found.steps < 200


# -- loads ----------------------------------------------------------------------------------------------------


def all_loads(algebra: str, **given: Any) -> list[Any]:
    """One of each load, two springs: those that are not given do nothing. One program serves them all."""
    used = BY_NAME[algebra]
    zero = np.zeros(3)
    wrench = evaluate(
        used, "mechanics.screw_of", *(used.spatial(x, "w") for x in given.get("wrench", (zero, zero)))
    ).value
    return [
        Gravity(given.get("gravity", zero)), Damper(*given.get("drag", (0, 0))),
        BodyWrench(wrench), WorldWrench(wrench),
        *(Spring(*x) for x in given.get("springs", [(zero, zero, 0.0)] * 2)),
    ]  # fmt: skip


@pytest.mark.compiles
def test_loads_by_closed_forms() -> None:
    times = np.linspace(0, 2, 9)
    off, velocity, t = np.array([0.5, 2, 3]), np.array([0.5, 0, -1]), times[:, None]
    body = RigidBody(2.0, [1, 1, 1], position=[1, 2, 3], velocity=velocity)
    loads = all_loads("cga3d", springs=[([0, 0, 0], [0.5, 0, 0], 12.0), ([0, 0, 0], [0.5, 0, 0], 6.0)])
    found = Simulation(body, loads, integrator="taylor").run(2, times=times, rtol=1e-12)
    expected = [0.5, 0, 0] + off * np.cos(3 * t) + velocity * np.sin(3 * t) / 3
    np.testing.assert_allclose(found.position, expected, rtol=0, atol=1e-11)
    body = RigidBody(2.0, [1, 2, 3], velocity=velocity, angular_velocity=[0, 0, 4])
    found = Simulation(body, all_loads("cga3d", drag=(1.5, 3.0)), integrator="taylor").run(2, times=times, rtol=1e-12)
    np.testing.assert_allclose(found.velocity, velocity * np.exp(-1.5 * t), rtol=0, atol=1e-11)
    np.testing.assert_allclose(found.angular_velocity, [0, 0, 4] * np.exp(-0.5 * t), rtol=0, atol=1e-11)


@cache
def loaded(algebra: str, integrator: str) -> Any:
    """A batch, off its axes, with everything at once."""
    body = RigidBody(
        np.array([2.0, 3.0, 4.0]), [[2, 0.1, 0], [0.1, 2.5, 0.2], [0, 0.2, 3]], position=[1, 2, 3],
        velocity=[0.5, 0, -1], angular_velocity=[1, -2, 3], algebra=BY_NAME[algebra],
    )  # fmt: skip
    springs = [([0.1, 0.2, 0.3], [2, 2, 4], 30.0, 0.5, 0.4), ([-0.1, 0.2, 0.3], [0, 2, 4], 20.0)]
    wrench = ([1, 2, -1], [0.3, 0, 0.5])
    loads = all_loads(algebra, gravity=[0, 0, -9.81], wrench=wrench, drag=(0.1, 0.2), springs=springs)
    return Simulation(body, loads, integrator=integrator).run(1, times=np.linspace(0, 1, 8), rtol=1e-12)


@pytest.mark.compiles
@pytest.mark.parametrize("algebra", ALGEBRAS)
def test_all_loads_as_the_adaptive_integrator_has_them(algebra: str) -> None:
    found, other = loaded(algebra, "taylor"), loaded("cga3d", "adaptive")
    np.testing.assert_allclose(found.position, other.position, rtol=0, atol=1e-10)
    np.testing.assert_allclose(found.orientation, other.orientation, rtol=0, atol=1e-10)
    np.testing.assert_allclose(found.angular_velocity, other.angular_velocity, rtol=0, atol=1e-10)
    assert (found.steps < other.steps).all()


# -- what it does at the edge ---------------------------------------------------------------------------------


def test_extreme_scales_of_time() -> None:
    """The units of the coefficients follow the motion, up to 1e9 turns a second and down to one in a thousand years."""
    for rate in (1e9, 1e-10):
        body = RigidBody(2.0, MOMENTS, angular_velocity=rate * np.array(SPIN))
        times = np.linspace(0, 20, 5) / rate
        found = Simulation(body, [NO_GRAVITY], integrator="taylor").run(20 / rate, times=times, rtol=1e-12)
        expected = np.array([[float(x) for x in free_top().spin(MP.mpf(float(t * rate)))] for t in times])
        np.testing.assert_allclose(found.angular_velocity / rate, expected, rtol=0, atol=1e-9)
    still = Simulation(RigidBody(2.0, MOMENTS), [NO_GRAVITY], integrator="taylor").run(5, times=[5.0])
    assert still.steps == 1
    np.testing.assert_array_equal(still.position[-1], [0, 0, 0])


def test_a_long_run_after_a_short_scale() -> None:
    """A body that hardly moves at first: the first units would be far too long for the spring."""
    body = RigidBody(1.0, [1, 1, 1], position=[1e-9, 0, 0])
    loads = all_loads("cga3d", springs=[([0, 0, 0], [0, 0, 0], 1e4), ([0, 0, 0], [0, 0, 0], 0.0)])
    found = Simulation(body, loads, integrator="taylor").run(1, times=[1.0], rtol=1e-12)
    np.testing.assert_allclose(found.position[-1], [1e-9 * np.cos(100), 0, 0], rtol=0, atol=1e-12)


def test_orders_and_what_has_no_series() -> None:
    assert [order_of(x) for x in (1e-3, 1e-9, 1e-12, 1e-16)] == [5, 12, 15, 20]
    body = RigidBody(2.0, MOMENTS, angular_velocity=SPIN)
    pushed = Simulation(body, [BodyWrench(lambda t: cga.line([0, 0, 0], [1, 0, 0]))], integrator="taylor")
    with pytest.raises(InputError, match="functions of users have none. Use integrator='adaptive'"):
        pushed.run(1)
    held = Simulation(body, [], [PinPath(cga.point([0, 0, 0]), lambda t: cga.point([t, 0, 0]))], integrator="taylor")
    with pytest.raises(InputError, match="Use integrator='adaptive'"):
        held.run(1)
