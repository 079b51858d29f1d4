"""Gradients of trajectories against the simulations' own differences; their shapes, and what is refused."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import dynamics, kinematics
from bladesmith.codegen.errors import InputError
from bladesmith.codegen.formulas.mechanics import mechanics
from bladesmith.codegen.programs import KernelSpec

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


def double_pendulum(algebra: Any, mass: float, stiffness: float, **options: Any) -> Any:
    bodies = {
        "upper": dynamics.RigidBody(mass, (0.15, 0.2, 0.3), (0, 0.5, 0), algebra=algebra),
        "lower": dynamics.RigidBody(2.0, (0.3, 0.2, 0.25), (0, 1.4, 0.2), algebra=algebra),
    }
    joints = [
        kinematics.Spherical("base", "upper", algebra.point((0, 0, 0))),
        kinematics.Spherical("upper", "lower", algebra.point((0, 1, 0))),
    ]
    spring = dynamics.Spring((0.1, 0, 0.2), (0, 0.1, 0.1), stiffness, 0.3, 0.4, body="upper", other="lower")
    loads = [dynamics.Gravity((0, 0, -9.81)), spring]
    return dynamics.Simulation(dynamics.System(bodies, joints), loads, **options)


@pytest.mark.compiles
@pytest.mark.parametrize("integrator", ["auto", pytest.param("taylor", marks=pytest.mark.slow)])
def test_systems(integrator: str) -> None:
    run = double_pendulum(bs.pga3d, 1.0, 5.0, integrator=integrator).run(
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
    rng = np.random.default_rng(3)
    bracket = KernelSpec(mechanics.bracket, ("twist", "twist"))
    for _ in range(5):
        a, b, da, db = rng.normal(size=(4, 6))
        value, tangent = bracket.along(("a", "b"))(a, b, da, db)
        np.testing.assert_allclose(value, bracket(a, b))
        np.testing.assert_allclose(tangent, bracket(da, b) + bracket(a, db))


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


@pytest.mark.compiles
@pytest.mark.parametrize("integrator", ["adaptive", "rk4", "strang", pytest.param("taylor", marks=pytest.mark.slow)])
def test_events(integrator: str) -> None:
    """A throw ends on the ground: its time, where it is and its velocity there change with the throw."""
    g, z, v = 9.81, 2.0, 3.0
    body = dynamics.RigidBody(1.5, INERTIA, (0, 0, z), velocity=(1, 0, v), angular_velocity=(0.4, 1.3, -0.6))
    ground = dynamics.Event(lambda t, motor, twist: float(motor.algebra.matrix(motor)[2, 3]), -1, "ground")
    run = dynamics.Simulation(body, [dynamics.Gravity((0, 0, -g))], integrator=integrator).run(
        3.0, step=0.01, times=np.linspace(0, 3, 7), events=[ground], sensitivities=["velocity", "position", "gravity"]
    )
    root = np.sqrt(v * v + 2 * g * z)
    time = (v + root) / g
    assert run.message == "ground" and abs(run.time[-1] - time) < 1e-12
    # of g T^2/2 = v T + z: by v, z and the field, which is -g
    changes = {"velocity": time / root, "position": 1 / root, "gravity": time**2 / 2 / root}
    for name, change in changes.items():
        s = run.sensitivities[name]
        assert np.abs(s.time[:-1]).max() == 0.0
        np.testing.assert_allclose(s.time[-1], [0, 0, change], atol=1e-12)
        place = {"velocity": [time, 0, change], "position": [1, 0, change], "gravity": [time**2 / 2, 0, change]}[name]
        np.testing.assert_allclose(np.diag(s.position[-1])[:2], [place[0], place[0]], rtol=1e-12)
        np.testing.assert_allclose(s.position[-1, 2], [change, 0, 0], atol=1e-12)
        falling = {"velocity": 1.0, "position": 0.0, "gravity": time}[name] - g * change
        np.testing.assert_allclose(s.velocity[-1, 2, 2], falling, rtol=1e-12)


@pytest.mark.compiles
def test_events_that_depend_on_all() -> None:
    """Of time, pose and twist, against differences of order 8 of runs that end there."""

    def value(t: float, motor: Any, twist: Any) -> float:
        matrix = motor.algebra.matrix(motor)
        return float(matrix[0, 1] + 0.3 * matrix[2, 3] * twist.values[0] + 0.2 * np.sin(3 * t) - 0.25)

    def run(spin: float, **options: Any) -> Any:
        body = dynamics.RigidBody(2.0, INERTIA, (0, 0, 1), velocity=(0, 0.3, 0), angular_velocity=(0.4, spin, -0.6))
        spring = dynamics.Spring((0.2, 0.1, 0), (0, 0, 2), 30.0, 0.5)
        return dynamics.Simulation(body, [spring], integrator="adaptive").run(
            2.0, times=np.linspace(0, 2, 21), events=[dynamics.Event(value)], **options
        )

    found = run(1.3, sensitivities="angular_velocity[1]")
    assert found.message == "event" and 0.1 < found.time[-1] < 1.9
    s = found.sensitivities["angular_velocity[1]"]

    def end(e: float) -> list[np.ndarray]:
        moved = run(1.3 + e)
        return [moved.time[-1:], *(x[-1] for x in states(moved)[:3])]

    expected = difference(end, 1e-2)
    found_ends = (s.time[-1], s.position[-1, 0], s.velocity[-1, 0], s.angular_velocity[-1, 0])
    for x, y in zip(found_ends, expected, strict=True):
        assert np.abs(x - y).max() <= 1e-10 * max(1.0, np.abs(y).max())


@pytest.mark.compiles
def test_executors_and_projected_starts() -> None:
    """Pieces of a batch have the same bits; a start that is off is brought to the pin, with its tangents."""
    body = dynamics.RigidBody([1.0, 2.0, 3.0], INERTIA, velocity=(1, 2, 3), angular_velocity=(0.4, 1.3, -0.6))
    simulation, names = dynamics.Simulation(body), FIVE
    whole = simulation.run(0.5, times=[0.5], sensitivities=names).sensitivities
    with ThreadPoolExecutor(2) as executor:
        parts = simulation.run(0.5, times=[0.5], sensitivities=names, executor=executor).sensitivities
    for name in names:
        assert np.array_equal(whole[name].motor.values, parts[name].motor.values)

    for stabilization in ("projection", "auto"):

        def run(x: float, kind: str = stabilization, **options: Any) -> Any:
            hung = dynamics.RigidBody(1.0, (0.2, 0.3, 0.1), (x, 0, -1.1), angular_velocity=(0.3, 0.5, 0.1))
            pin = dynamics.Pin(bs.cga3d.point((0, 0, 1.0)), bs.cga3d.point((0, 0, 0)))
            return dynamics.Simulation(hung, [dynamics.Gravity((0, 0, -9.81))], [pin], stabilization=kind).run(
                0.3, times=[0.1, 0.3], project=True, **options
            )

        s = run(0.3, sensitivities="position[0]").sensitivities["position[0]"]
        expected = difference(lambda e: states(run(0.3 + e))[:3], 5e-3)  # noqa: B023
        for x, y in zip((s.position, s.velocity, s.angular_velocity), expected, strict=True):
            assert np.abs(x[:, 0] - y).max() <= 1e-10 * np.abs(y).max()


def test_refused() -> None:
    body = dynamics.RigidBody(1.0, (1, 1, 1))
    run = dynamics.Simulation(body).run(1.0, times=[1.0], sensitivities=FIVE)
    with pytest.raises(InputError, match="did you mean 'mass'"):
        run.sensitivities["mas"]
