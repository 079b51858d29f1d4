"""Springs whose ends meet: against exact motions on a line, where series would go through without a jump."""

from __future__ import annotations

import numpy as np
import pytest

from bladesmith import dynamics
from bladesmith.errors import SimulationError

pytestmark = pytest.mark.compiles
INERTIA = (0.1, 0.2, 0.25)


def two_bodies() -> dynamics.System:
    bodies = {name: dynamics.RigidBody(1.0, INERTIA, (x, 0, 0)) for name, x in (("a", 1.0), ("b", -1.0))}
    return dynamics.System(bodies, [])


def place_of_a(t: float) -> float:
    """Half of the gap: it swings about 1/4 with 200/s^2, and on the other side of 0 about -1/4."""
    rate = np.sqrt(200.0)
    size = 0.75
    to_zero = np.arccos(-0.25 / size) / rate
    if t <= to_zero:
        return float(0.25 + size * np.cos(rate * t))
    half = (2 * np.pi - 2 * (np.pi - np.arccos(-0.25 / size))) / rate  # from 0 to 0, on one side
    turns, rest = divmod(t - to_zero, half)
    side = -1.0 if turns % 2 == 0 else 1.0
    return float(side * (0.25 + size * np.cos(rate * (rest - half / 2))))


@pytest.mark.parametrize("coordinates", ["auto", "maximal"])
def test_two_bodies_pass_through_each_other(coordinates: str) -> None:
    spring = dynamics.Spring((0, 0, 0), (0, 0, 0), 100.0, 0.5, body="a", other="b")
    run = dynamics.Simulation(two_bodies(), [spring], coordinates=coordinates).run(1.0, step=0.1)
    assert run.ending == "ok"
    assert [x[0] for x in run["a"].position] == pytest.approx([place_of_a(t) for t in run.time], abs=1e-8)
    assert run.energy == pytest.approx(run.energy[0], rel=1e-9)


def test_a_damper_that_begins_at_its_anchor() -> None:
    body = dynamics.RigidBody(1.0, INERTIA, velocity=(0, 0, 1.0))
    run = dynamics.Simulation(body, [dynamics.Spring((0, 0, 0), (0, 0, 0), 100.0, 0.0, 5.0)]).run(1.0, times=[1.0])
    rate = np.sqrt(100 - 6.25)
    assert run.position[-1, 2] == pytest.approx(np.exp(-2.5) * np.sin(rate) / rate, rel=1e-9)


def test_a_spring_without_length_or_damping_keeps_its_series() -> None:
    body = dynamics.RigidBody(1.0, INERTIA, (0, 0, 1.0))
    run = dynamics.Simulation(body, [dynamics.Spring((0, 0, 0), (0, 0, 0), 100.0, 0.0)]).run(1.0, times=[1.0])
    assert run.integrator == "taylor" and run.position[-1, 2] == pytest.approx(np.cos(10.0), abs=1e-11)


def test_springs_that_turn_half_round_or_miss_keep_theirs() -> None:
    for sideways in (1e-6, 3.0):
        body = dynamics.RigidBody(1.0, INERTIA, (0, 0, 1.0), velocity=(sideways, 0, 0))
        spring = dynamics.Spring((0, 0, 0), (0, 0, 0), 100.0, 0.5)
        run, other = (
            dynamics.Simulation(body, [spring], integrator=integrator).run(1.0, times=[1.0])
            for integrator in ("auto", "adaptive")
        )
        assert run.integrator == "taylor" and run.position[-1] == pytest.approx(other.position[-1], abs=1e-6)


def test_taylor_says_what_it_cannot_do() -> None:
    spring = dynamics.Spring((0, 0, 0), (0, 0, 0), 100.0, 0.5)
    sim = dynamics.Simulation(dynamics.RigidBody(1.0, INERTIA, (0, 0, 2.0)), [spring], integrator="taylor")
    with pytest.warns(RuntimeWarning, match="ends of a spring meet"):
        run = sim.run(1.0, times=[1.0])
    assert run.ending == "spring ends meet" and not run.converged
    with pytest.raises(SimulationError, match=r"no series.*\n?.*adaptive"):
        sim.run(1.0, times=[1.0], strict=True)


def test_some_of_a_batch_meet() -> None:
    bodies = dynamics.RigidBody(np.full(3, 1.0), INERTIA, [(0, 0, 1.0), (0, 1.0, 1.0), (0, 0, 2.0)],
                                velocity=[(0, 0, 0), (2.0, 0, 0), (1.0, 0, 0)])  # fmt: skip
    spring = dynamics.Spring((0, 0, 0), (0, 0, 0), 100.0, 0.5)
    run = dynamics.Simulation(bodies, [spring]).run(1.0, times=[1.0])
    assert (run.ending == "ok").all() and np.ptp(run.energy, axis=1).max() < 1e-7


def test_paths_that_overflow_are_not_finite() -> None:
    sim = dynamics.Simulation(dynamics.RigidBody(1.0, INERTIA), [dynamics.Gravity((0, 0, -9.81))])
    with pytest.warns(RuntimeWarning, match="no longer finite"):
        run = sim.run(1e160, step=1e159)
    assert run.ending == "not finite"
