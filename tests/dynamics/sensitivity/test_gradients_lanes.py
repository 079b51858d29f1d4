"""Gradients of several directions at once have the bits of those that are computed one after the other."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import dynamics
from bladesmith.codegen.build.cpu_features import has_wide_vectors
from bladesmith.codegen.build.toolchain import compiler
from bladesmith.dynamics.integration import program

from .test_gradients_methods import CASES, double_pendulum, loaded, symmetric_top

pytestmark = [
    pytest.mark.slow, pytest.mark.compiles,
    pytest.mark.skipif(compiler() is None or not has_wide_vectors(), reason="no wide vectors, or no compiler"),
]  # fmt: skip


def carried(integrator: str) -> Any:
    """A body on a moving pin, pushed by a function of time."""

    def path(t: float) -> Any:
        a, b = bs.pga3d.point((0, 0, 1.0)), bs.pga3d.point((0.1, 0.2, 1.3))
        return a + t**3 * (b - a), 3 * t**2 * (b - a), 6 * t * (b - a)

    body = dynamics.RigidBody(1.3, (0.4, 0.5, 0.6), (0, 0, 1.0), angular_velocity=(0.3, 0.2, 4.0), algebra=bs.pga3d)
    push = dynamics.WorldWrench(lambda t: dynamics.wrench((0.1, 0.3 * t, 0), (0.1, 0, 0), algebra=bs.pga3d))
    pin = dynamics.PinPath(bs.pga3d.point((0, 0, 0)), path)
    return dynamics.Simulation(body, [push], [pin], integrator=integrator)


@pytest.mark.parametrize("integrator", ["adaptive", "rkmk4"])
@pytest.mark.parametrize(
    ("make", "names"),
    [
        (loaded, CASES[loaded]), (symmetric_top, ["mass", "angular_velocity"]),
        (double_pendulum, CASES[double_pendulum]), (carried, ["mass", "inertia", "angular_velocity[0]"]),
    ],
    ids=["loaded", "top", "double pendulum", "functions"],
)  # fmt: skip
def test_bits(make: Any, names: list[str], integrator: str, monkeypatch: pytest.MonkeyPatch) -> None:
    times, found = np.array([0.0, 0.03, 0.08]), []
    for is_wide in (True, False):
        monkeypatch.setattr(program, "has_wide_vectors", lambda is_wide=is_wide: is_wide)
        program.program_for.cache_clear()
        run = make(integrator).run(times[-1], times=times, step=0.02, sensitivities=names)
        run = (run if hasattr(run, "_run") else next(iter(run.bodies.values())))._run
        assert run.driver.program.needs.lanes == (4 if is_wide else 1)
        found.append((run.motors, run.twists, run.tangents))
    program.program_for.cache_clear()
    for x, y in zip(*found, strict=True):
        assert np.isfinite(x).all() and x.tobytes() == y.tobytes()
    assert np.abs(found[0][2]).max() > 0
