"""Gradients of trajectories against the simulations' own differences; their shapes, and what is refused."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import dynamics, kinematics
from bladesmith.codegen.errors import InputError
from bladesmith.dispatch.formulas import evaluate

from ...oracles.gradients import (
    PARAMETERS,
    TURN,
    difference,
    everything,
    states,
)

POINT, SPIN = np.array([0.2, 0.1, 1.0]), np.array([0.4, 1.3, -0.6])
START: dict[str, Any] = {
    "mass": 2.0, "inertia": np.array([1.0, 2.0, 2.5]), "position": np.array([1.0, 2.0, 3.0]),
    "orientation": np.zeros(3), "velocity": TURN @ np.cross(SPIN, -POINT), "angular_velocity": SPIN,
    "gravity": np.array([0.3, 0.2, -9.81]), "damper.angular": 0.1, "damper.linear": 0.2, "spring.stiffness": 20.0,
    "spring.length": 0.5, "spring.damping": 0.3, "spring.point": np.array([0.2, 0.1, -0.4]),
    "spring.anchor": np.array([0.0, 1.0, 4.0]), "body_wrench": np.array([0.1, 0.2, 0.3, 0.4, 0.5, 0.6]),
    "world_wrench": np.array([0.3, 0.1, 0.2, 0.6, 0.4, 0.5]),
}  # fmt: skip
TIMES = np.array([0.0, 0.4, 0.8])
PLACE = TURN @ POINT + START["position"]


def path(algebra: Any) -> Callable[[float], Any]:
    """A point that moves off, smoothly enough not to change the start."""
    first, second, third = (algebra.point(PLACE + x) for x in ([0, 0, 0], [0.1, 0.2, -0.1], [-0.1, -0.2, 0.1]))
    if algebra is bs.pga3d:
        slope = (second - third) / 2
        return lambda t: (first + t**3 * slope, 3 * t**2 * slope, 6 * t * slope)
    slope, bend = (second - third) / 2, (second + third - 2 * first) / 2
    return lambda t: (
        first + t**3 * slope + t**6 * bend, 3 * t**2 * slope + 6 * t**5 * bend, 6 * t * slope + 30 * t**4 * bend,
    )  # fmt: skip


CONSTRAINTS: dict[str, Callable[[], tuple[Any, list[Any]]]] = {
    "free": lambda: (bs.pga3d, []),
    "pin where it is": lambda: (bs.cga3d, [dynamics.Pin(bs.cga3d.point(POINT))]),
    "pin": lambda: (bs.pga3d, [dynamics.Pin(bs.pga3d.point(POINT), bs.pga3d.point(PLACE))]),
    "path": lambda: (bs.cga3d, [dynamics.PinPath(bs.cga3d.point(POINT), path(bs.cga3d))]),
    "plane, twice": lambda: (
        bs.pga3d, [dynamics.Incidence(bs.pga3d.point(POINT), bs.pga3d.plane((0, 0, 1), PLACE[2]))] * 2
    ),
}  # fmt: skip


@pytest.mark.compiles
@pytest.mark.parametrize("case", CONSTRAINTS)
def test_all_parameters_together(case: str) -> None:
    """The gradient along a direction of all parameters at once."""
    algebra, constraints = CONSTRAINTS[case]()
    start = START
    rng = np.random.default_rng(7)
    along = {name: rng.normal(size=np.shape(value)) * (0.1 + np.abs(value).max()) for name, value in start.items()}
    run = everything(algebra, start, constraints).run(TIMES[-1], times=TIMES, sensitivities=PARAMETERS)

    def moved(e: float) -> list[np.ndarray]:
        p = {name: value + e * along[name] for name, value in start.items()}
        return states(everything(algebra, p, constraints).run(TIMES[-1], times=TIMES, project=bool(constraints)))

    total: list[Any] = [0.0] * 4
    for name, d in along.items():
        s, d = run.sensitivities[name], np.ravel(d)
        for i, x in enumerate((s.position, s.velocity, s.angular_velocity)):
            total[i] = total[i] + np.einsum("k,tki->ti", d, x)
        total[3] = total[3] + s.energy @ d
    for found, expected in zip(total, difference(moved, 2e-3), strict=True):
        assert np.abs(found - expected).max() <= 1e-8 * np.abs(expected).max()


def double_pendulum(algebra: Any, mass: float, stiffness: float) -> Any:
    bodies = {
        "upper": dynamics.RigidBody(mass, (0.15, 0.2, 0.3), (0, 0.5, 0), algebra=algebra),
        "lower": dynamics.RigidBody(2.0, (0.3, 0.2, 0.25), (0, 1.4, 0.2), algebra=algebra),
    }
    joints = [
        kinematics.Spherical("base", "upper", algebra.point((0, 0, 0))),
        kinematics.Spherical("upper", "lower", algebra.point((0, 1, 0))),
    ]
    spring = dynamics.Spring((0.1, 0, 0.2), (0, 0.1, 0.1), stiffness, 0.3, 0.4, body="upper", other="lower")
    return dynamics.Simulation(dynamics.System(bodies, joints), [dynamics.Gravity((0, 0, -9.81)), spring])


@pytest.mark.compiles
def test_systems() -> None:
    run = double_pendulum(bs.pga3d, 1.0, 5.0).run(
        TIMES[-1], times=TIMES, sensitivities=["upper.mass", "spring[0].stiffness"]
    )

    def moved(e: float) -> list[np.ndarray]:
        return states(double_pendulum(bs.pga3d, 1 + e, 5 + 2 * e).run(TIMES[-1], times=TIMES).bodies["lower"])

    mass, stiffness = (run.bodies["lower"].sensitivities[n] for n in ("upper.mass", "spring[0].stiffness"))
    for name, expected in zip(
        ("position", "velocity", "angular_velocity", "energy"), difference(moved, 5e-3), strict=True
    ):
        found = (getattr(mass, name) + 2 * getattr(stiffness, name))[:, 0]
        assert np.abs(found - expected).max() <= 1e-8 * np.abs(expected).max()


# -- shapes, kinds of loads, errors ------------------------------------------------------------------------


INERTIA = (1.0, 2.0, 2.5)
#: Five numbers: one program serves all bodies under nothing.
FIVE = ["mass", "inertia", "orientation[1]"]


@pytest.mark.compiles
def test_batches() -> None:
    """Each simulation has its own; shapes as documented."""
    body = dynamics.RigidBody([1.0, 2.0, 3.0], INERTIA, velocity=(1, 2, 3), angular_velocity=(0.4, 1.3, -0.6))
    names = FIVE
    runs = dynamics.Simulation(body).run(1.0, times=[0.5, 1.0], sensitivities=names)
    s = runs.sensitivities["inertia"]
    assert s.position.shape == s.orientation.shape == s.velocity.shape == (3, 3, 3, 3)
    assert s.motor.shape == (3, 3, 3) and s.energy.shape == (3, 3, 3)
    assert runs.sensitivities["orientation[1]"].motor.shape == (3, 3, 1)
    for i, mass in enumerate(body.mass):
        one = dynamics.RigidBody(mass, INERTIA, velocity=(1, 2, 3), angular_velocity=(0.4, 1.3, -0.6))
        alone = dynamics.Simulation(one).run(1.0, times=[0.5, 1.0], sensitivities=names)
        for name in names:
            for part in ("position", "velocity", "angular_velocity", "energy"):
                x, y = (getattr(r.sensitivities[name], part) for r in (runs, alone))
                np.testing.assert_allclose(x[i], y, rtol=1e-10, atol=1e-12)


@pytest.mark.compiles
def test_functions_of_time() -> None:
    """Loads that change with time pass; those that depend on the state do not."""

    def simulation(mass: float, *loads: Any) -> Any:
        body = dynamics.RigidBody(mass, INERTIA, (1, 2, 3), velocity=(0.3, 0, 0.1), angular_velocity=(0.4, 0.3, -0.6))
        return dynamics.Simulation(body, loads)

    push = dynamics.WorldWrench(lambda t: np.cos(2 * t) * dynamics.wrench((1, -2, 0.3), (0, 0.1, 3)))
    own = dynamics.BodyWrench(lambda t: np.sin(3 * t) * dynamics.wrench((1, 2, 3), (0, 0.1, 0)))
    run = simulation(2.0, push, own).run(0.2, times=TIMES / 4, sensitivities=["mass"])
    expected = difference(lambda e: states(simulation(2 + e, push, own).run(0.2, times=TIMES / 4))[:3], 2e-2)
    s = run.sensitivities["mass"]
    for found, other in zip((s.position, s.velocity, s.angular_velocity), expected, strict=True):
        assert np.abs(found[:, 0] - other).max() <= 1e-8 * np.abs(other).max()
    drag = dynamics.BodyWrench(lambda t, motor, twist: -0.1 * dynamics.wrench((1, 0, 0), 0))
    with pytest.raises(InputError, match="functions of the state"):
        simulation(2.0, drag).run(0.1, sensitivities=["mass"])


def test_tangents_of_motors() -> None:
    """The twist delta moves the pose: dR = -R delta/2."""
    body = lambda w: dynamics.RigidBody(1.0, (1, 2, 3), angular_velocity=(w, 1.0, 0.3), velocity=(1, 2, 3))  # noqa: E731
    run = dynamics.Simulation(body(0.2)).run(1.0, times=[1.0], sensitivities=[*FIVE[:2], "angular_velocity[0]"])
    rate = -(run.motor[-1] * run.sensitivities["angular_velocity[0]"].motor[-1, 0]).values / 2
    (expected,) = difference(
        lambda e: [dynamics.Simulation(body(0.2 + e)).run(1.0, times=[1.0], rtol=1e-13).motor[-1].values], 5e-3
    )
    assert np.abs(rate[: len(expected)] - expected).max() < 1e-8


def test_bilinear_tangents() -> None:
    """Of a product the tangent is what its two factors add."""
    algebra, rng = bs.cga3d, np.random.default_rng(3)
    a, b, da, db = (algebra.wrap(algebra.kind("twist"), rng.normal(size=(5, 6))) for _ in range(4))
    value, tangent = evaluate(algebra, "motion_tangents.bracket", a, b, da, db).values
    bracket = lambda x, y: evaluate(algebra, "mechanics.bracket", x, y).value  # noqa: E731
    np.testing.assert_allclose(value.values, bracket(a, b).values)
    np.testing.assert_allclose(tangent.values, (bracket(da, b) + bracket(a, db)).values)


@pytest.mark.parametrize(
    ("names", "told"),
    [
        (["masss"], "did you mean 'mass'"), (["inertia[3]"], "3 components"), (["spring[1].length"], "did you mean"),
        (["damper.linear"], "There are: mass"), ([3], "a text is needed"), (["gravity"], "not a parameter"),
    ],
)  # fmt: skip
def test_unknown_parameters(names: list[Any], told: str) -> None:
    body = dynamics.RigidBody(1.0, (1, 1, 1))
    with pytest.raises(InputError, match=told.replace("[", r"\[")):
        dynamics.Simulation(body, [dynamics.Spring(0, (0, 0, 1), 3.0)]).run(1.0, sensitivities=names)


def test_refused() -> None:
    body = dynamics.RigidBody(1.0, (1, 1, 1))
    with pytest.raises(InputError, match="does not compute sensitivities.*adaptive"):
        dynamics.Simulation(body, integrator="rk4").run(1.0, sensitivities=["mass"])
    with pytest.raises(InputError, match="project"):
        dynamics.Simulation(body).run(1.0, sensitivities=["mass"], project=True)
    run = dynamics.Simulation(body).run(1.0, times=[1.0], sensitivities=FIVE)
    with pytest.raises(InputError, match="did you mean 'mass'"):
        run.sensitivities["mas"]
