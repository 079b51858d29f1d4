"""Events next to stored states, and behind which a function fails."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import dynamics

pytestmark = pytest.mark.compiles
GRAVITY = dynamics.Gravity((0, 0, -9.81))


def height(t: float, motor: Any, twist: Any) -> float:
    return float(bs.cga3d.matrix(motor)[2, 3])


GROUND = dynamics.Event(height, name="ground", direction=-1)


@pytest.mark.parametrize("integrator", ["auto", "adaptive"])
def test_events_at_stored_times(integrator: str) -> None:
    """By rounding they are just behind them, where no step leads to."""
    for k in range(2, 60):
        end = 0.05 * k
        ball = dynamics.RigidBody(1.0, (0.1, 0.1, 0.1), velocity=(0, 0, 9.81 * end / 2), angular_velocity=(0, 0, 1.0))
        run = dynamics.Simulation(ball, [GRAVITY], integrator=integrator).run(end + 0.5, step=0.05, events=GROUND)
        assert run.message == "ground" and run.time[-1] == pytest.approx(end, rel=1e-12)
        assert abs(run.position[-1, 2]) < 1e-11


def test_an_event_before_a_function_fails() -> None:
    def thrust(t: float) -> Any:
        if t > 1.0:
            raise ValueError("the table ends at 1 s")
        return dynamics.wrench((0, 0, 1.0), 0)

    ball = dynamics.RigidBody(1.0, (0.1, 0.1, 0.1), position=(0, 0, 1.0))
    sim = dynamics.Simulation(ball, [GRAVITY, dynamics.WorldWrench(thrust)])
    run = sim.run(2.0, step=0.01, events=GROUND, strict=True)
    assert run.message == "ground" and run.time[-1] == pytest.approx(np.sqrt(2 / 8.81), rel=1e-12)
    never = dynamics.Event(lambda t, motor, twist: 1.0, name="never")
    with pytest.warns(RuntimeWarning, match="the table ends"):
        assert sim.run(2.0, step=0.01, events=never).ending == "function failed"
