"""Many bodies: workspaces, which are refused where they do not fit, and interrupts of long steps."""

from __future__ import annotations

import _thread
import threading
import time

import numpy as np
import pytest

from bladesmith import cga3d as cga
from bladesmith import dynamics, kinematics
from bladesmith.codegen.algorithms.dynamics import records
from bladesmith.codegen.build import text_cache
from bladesmith.codegen.programs.dynamics.dynamics import dynamics_program
from bladesmith.common import memory
from bladesmith.dynamics.integration import driver, program
from bladesmith.errors import InputError, Interrupted

from ...support.effort import FULL

GRAVITY = dynamics.Gravity((0.3, 1.0, -9.81))
#: Bodies of a chain that overflowed the stack: 52 and more did.
MANY = 300 if FULL else 56


def chain(n):
    """Hinged bodies that hang below each other, axes in turn along x and y."""
    bodies, joints = {}, []
    for i in range(n):
        bodies[f"b{i}"] = dynamics.RigidBody(1.0, (0.1, 0.11, 0.02), (0, 0, -(i + 0.5)))
        axis = (1, 0, 0) if i % 2 else (0, 1, 0)
        joints.append(kinematics.Revolute(f"b{i - 1}" if i else "base", f"b{i}", cga.circle((0, 0, -i), axis, 0.3)))
    return dynamics.System(bodies, joints)


def ladder(n):
    """Four-bars on top of each other."""
    names = ["base", *(f"{side}{i}" for i in range(n) for side in ("left", "right", "bar"))]
    found = kinematics.Mechanism(names, "base")
    for i in range(n):
        below = f"bar{i - 1}" if i else "base"
        for x, side in enumerate(("left", "right")):
            foot, head = (cga.circle((x, y, 0), (0, 0, 1), 0.2) for y in (i, i + 1))
            found.add(kinematics.Revolute(below, f"{side}{i}", foot), f"{side}_foot{i}")
            found.add(kinematics.Revolute(f"{side}{i}", f"bar{i}", head), f"{side}_head{i}")
    return found


def test_many_hinged_bodies() -> None:
    """The chain begins to swing: it holds together, and keeps its energy."""
    simulation = dynamics.Simulation(chain(MANY), [GRAVITY], integrator="rk4")
    found = simulation.run(1e-3, times=[1e-3])
    assert found.message == "" and found._run.violations.max() < 5e-14 * MANY
    assert abs(found.energy[1] - found.energy[0]) < 1e-9
    moved = found.bodies[f"b{MANY - 1}"].position[1] - found.bodies[f"b{MANY - 1}"].position[0]
    assert moved[1] > 1e-8  # gravity pulls along y


@pytest.mark.slow
def test_taylor_series_of_many_bodies() -> None:
    """More than fit a stack; beside steps of order 4."""
    ends = []
    for integrator in ("taylor", "rk4"):
        found = dynamics.Simulation(chain(16), [GRAVITY], integrator=integrator).run(2e-3, step=2e-4, times=[2e-3])
        ends.append(found._run.motors)
    assert np.abs(ends[0] - ends[1]).max() < 1e-12


INTEGRATORS = ("rk4", "rkmk4", "cf4", "midpoint", "adaptive", "taylor")


@pytest.mark.parametrize(
    "integrator", [name if name == "adaptive" else pytest.param(name, marks=pytest.mark.slow) for name in INTEGRATORS]
)
def test_the_same_bits_from_workspaces(integrator, monkeypatch) -> None:
    """Arrays of bodies that are in the work, as those of many bodies are, instead of on the stack."""
    simulation = dynamics.Simulation(chain(2), [GRAVITY], integrator=integrator)

    def ends():
        run = simulation.run(4e-3, step=2e-3, times=[3e-3, 4e-3])._run
        return [run.motors, run.twists, run.reactions, run.violations]

    def forget():
        simulation._cache.clear()
        for each in (program.program_for, dynamics_program, records.work_records):
            each.cache_clear()

    expected = ends()
    forget()
    monkeypatch.setattr(records, "LARGE", 0)
    monkeypatch.setattr(text_cache, "made_once", lambda stem, sources, name, make: make())
    found = ends()
    forget()
    assert all(np.array_equal(a, b) for a, b in zip(expected, found, strict=True))


@pytest.mark.slow
def test_sensitivities_from_workspaces() -> None:
    """Of a system whose tangents do not fit the stack: beside differences."""

    def end(weight):
        gravity = dynamics.Gravity((0.3, 1.0, weight))
        return dynamics.Simulation(chain(4), [gravity], integrator="rkmk4")

    found = end(-9.81).run(0.05, step=5e-3, times=[0.05], sensitivities=["gravity"])
    own = found.bodies["b3"].sensitivities["gravity"].position[-1, 2]
    high, low = (end(-9.81 + d).run(0.05, step=5e-3, times=[0.05]).bodies["b3"].position[-1] for d in (1e-4, -1e-4))
    assert np.allclose(own, (high - low) / 2e-4, rtol=1e-6, atol=1e-12)


def test_what_does_not_fit_is_refused_before_it_is_taken(monkeypatch) -> None:
    simulation = dynamics.Simulation(chain(9), [GRAVITY], integrator="rk4")
    monkeypatch.setattr(memory, "total", lambda: 100_000)
    monkeypatch.setattr(driver.Driver, "workspace", lambda self: pytest.fail("it was taken"))
    with pytest.raises(InputError, match=r"a simulation of 9 bodies with 90 equations takes \d{6,} bytes of memory"):
        simulation.run(1e-3, times=[1e-3])


def test_large_mechanisms(monkeypatch) -> None:
    """Loops that overflowed the stack; a push of the foot moves every four-bar as it moves one."""
    count = 200 if FULL else 30
    found = ladder(count).solve_pose({f"left_foot{i}": 0.01 for i in range(count)})
    assert found.status == 0 and found.residual < 1e-12
    monkeypatch.setattr(memory, "total", lambda: 10_000)
    with pytest.raises(InputError, match=rf"a mechanism of {3 * count} bodies takes \d+ bytes of memory"):
        ladder(count).solve_pose({f"left_foot{i}": 0.01 for i in range(count)})


def test_an_interrupt_comes_through_a_long_step(monkeypatch) -> None:
    monkeypatch.setattr(driver, "MANY", 1)  # as if these were so many
    simulation = dynamics.Simulation(chain(20), [GRAVITY], integrator="rk4")
    simulation.run(1e-3, times=[1e-3])
    begun = time.monotonic()
    stopper = threading.Timer(0.5, _thread.interrupt_main)
    stopper.start()
    with pytest.raises(Interrupted) as caught:
        simulation.run(100.0, times=[100.0])
    assert caught.value.partial.message == "interrupted" and time.monotonic() - begun < 30
