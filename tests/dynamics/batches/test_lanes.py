"""Batches of simulations of which several run at once: the bits of one after the other."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import dynamics, kinematics
from bladesmith.codegen.build import extension
from bladesmith.codegen.build.cpu_features import has_wide_vectors
from bladesmith.codegen.programs.dynamics import wide
from bladesmith.codegen.programs.dynamics.config import DynamicsConfig
from bladesmith.dynamics.integration import driver

from ...support.effort import FULL

pytestmark = pytest.mark.skipif(
    extension.compiler() is None or not has_wide_vectors(), reason="no compiler, or no wide vectors"
)
COUNT, TIMES = 77, [0.0, 0.21, 0.5]
GRAVITY = dynamics.Gravity((0.3, -0.2, -9.81))
LOADED = (
    GRAVITY, dynamics.Damper(0.1, 0.2), dynamics.Spring((0.2, 0.1, 0.0), (0.0, 0.0, 2.0), 30.0, 0.5, 0.3),
)  # fmt: skip
BETWEEN = (*LOADED, dynamics.Spring((0.2, 0.1, 0.0), (0.0, 0.3, 0.0), 20.0, 0.1, 0.2, "body0", "body1"))
CASES = [
    ("rk4", (), 1), ("rk4", (GRAVITY,), 1), ("rk4", BETWEEN, 2), ("rkmk4", LOADED, 1), ("cf4", LOADED, 1),
    ("midpoint", (GRAVITY,), 2), ("strang", (), 1), ("yoshida6", (GRAVITY,), 1), ("adaptive", LOADED, 1),
    ("adaptive", BETWEEN, 2), ("taylor", (), 1), ("taylor", LOADED, 1), ("taylor", BETWEEN, 2),
]  # fmt: skip
#: Pins that leave a body a group of motions: turns about a point, and about an axis.
POINTS = ((0.1, -0.2, 0.3), (0.4, 0.1, -0.2))
PINNED = [
    ("rk4", LOADED, 2), ("adaptive", LOADED, 1), ("taylor", (GRAVITY,), 1), ("taylor", LOADED, 2),
]  # fmt: skip
#: The same by multipliers, and two bodies on hinges.
CONSTRAINED = [
    ("rk4", LOADED, 1, "projection"), ("rk4", (GRAVITY,), 1, "baumgarte"), ("adaptive", LOADED, 1, "projection"),
    ("taylor", (GRAVITY,), 1, "projection"), ("rkmk4", BETWEEN, 2, "projection"),
]  # fmt: skip


def in_turn(cases: list[Any]) -> list[tuple[Any, Any]]:
    """Cases, each in one of the algebras; in both with all bars."""
    algebras = [bs.cga3d, bs.pga3d]
    return [(case, a) for k, case in enumerate(cases) for a in (algebras if FULL else algebras[k % 2 :][:1])]


def name_of(value: Any) -> str:
    """Of a case or an algebra."""
    return f"{value[0]}-{len(value[1])}-{value[2]}" if isinstance(value, tuple) else str(value.name)


def bodies(algebra: Any, count: int) -> dynamics.System | dynamics.RigidBody:
    """Some bodies of a batch, each with numbers of its own: slow and fast, light and heavy, some at rest."""
    rng = np.random.default_rng(5)

    def body() -> dynamics.RigidBody:
        moments = rng.uniform(1.0, 2.0, (COUNT, 3)) * 10.0 ** rng.integers(-3, 3, (COUNT, 1))
        spin = rng.normal(size=(COUNT, 3)) * 10.0 ** rng.integers(-2, 2, (COUNT, 1))
        spin[::9] = 0.0
        return dynamics.RigidBody(
            10.0 ** rng.uniform(-2.0, 2.0, COUNT), moments, velocity=rng.normal(size=(COUNT, 3)),
            angular_velocity=spin, algebra=algebra,
        )  # fmt: skip

    return body() if count == 1 else dynamics.System({f"body{k}": body() for k in range(count)}, [])


def arrays_of(trajectory: dynamics.Trajectory) -> list[np.ndarray]:
    """All that a run gave."""
    data = trajectory.to_data()
    return [np.asarray(data.steps), np.asarray(data.ending), *(a for row in data.rows.values() for a in row.values())]


def results_of(simulation: dynamics.Simulation, threads: int, project: bool) -> list[np.ndarray]:
    adapts = simulation.integrator in ("adaptive", "taylor")
    options: dict[str, Any] = {"rtol": 1e-9} if adapts else {"step": 0.013}
    return arrays_of(simulation.run(TIMES[-1], times=TIMES, threads=threads, project=project, **options))


def assert_the_bits_of_single_ones(simulation: Any, monkeypatch: Any, project: bool = False) -> None:
    several = [results_of(simulation, threads, project) for threads in (1, 2)]
    monkeypatch.setattr(driver, "WIDE_BATCH", 1 << 30)
    one_by_one = results_of(simulation, 1, project)
    for found in several:
        for a, b in zip(found, one_by_one, strict=True):
            assert a.tobytes() == b.tobytes()


@pytest.mark.compiles
@pytest.mark.parametrize(("case", "algebra"), in_turn(CASES), ids=name_of)
def test_simulations_of_a_batch_have_the_bits_of_single_ones(case: Any, algebra: Any, monkeypatch: Any) -> None:
    integrator, loads, count = case
    simulation = dynamics.Simulation(bodies(algebra, count), list(loads), integrator=integrator)
    assert_the_bits_of_single_ones(simulation, monkeypatch)


@pytest.mark.compiles
@pytest.mark.parametrize(("case", "algebra"), in_turn(PINNED), ids=name_of)
def test_pinned_bodies_of_a_batch_have_the_bits_of_single_ones(case: Any, algebra: Any, monkeypatch: Any) -> None:
    integrator, loads, count = case
    pins = [dynamics.Pin(algebra.point(x)) for x in POINTS[:count]]
    body = bodies(algebra, 1)
    simulation = dynamics.Simulation(body, list(loads), pins, integrator=integrator, stabilization="null-space")
    assert_the_bits_of_single_ones(simulation, monkeypatch, project=True)


@pytest.mark.compiles
@pytest.mark.parametrize("case", CONSTRAINED, ids=lambda c: f"{c[0]}-{len(c[1])}-{c[2]}-{c[3]}")
def test_constraints_of_a_batch_have_the_bits_of_single_ones(case: Any, monkeypatch: Any) -> None:
    integrator, loads, count, how = case
    options: dict[str, Any] = {"integrator": integrator, "stabilization": how}
    if count == 1:
        pin = dynamics.Pin(bs.cga3d.point(POINTS[0]))
        simulation = dynamics.Simulation(bodies(bs.cga3d, 1), list(loads), [pin], **options)
    else:
        circles = [bs.cga3d.circle(x, axis, 1.0) for x, axis in zip(POINTS, ((0, 1, 0), (0.6, 0, 0.8)), strict=True)]
        ends = zip(("base", "body0"), ("body0", "body1"), circles, strict=True)
        system = dynamics.System(bodies(bs.cga3d, 2).bodies, [kinematics.Revolute(*each) for each in ends])
        simulation = dynamics.Simulation(system, list(loads), coordinates="maximal", **options)
    assert_the_bits_of_single_ones(simulation, monkeypatch, project=True)


@pytest.mark.compiles
@pytest.mark.parametrize("integrator", ["adaptive", "taylor"])
def test_a_simulation_that_fails_leaves_the_others_as_they_are(integrator: str, monkeypatch: Any) -> None:
    rng = np.random.default_rng(6)
    spin = rng.normal(size=(COUNT, 3))
    spin[13], spin[40] = 1e200, 1e160

    def run() -> list[np.ndarray]:
        body = dynamics.RigidBody(1.0, (1.0, 2.0, 2.5), angular_velocity=spin)
        return arrays_of(dynamics.Simulation(body, LOADED, integrator=integrator).run(0.5, times=TIMES, rtol=1e-9))

    several = run()
    monkeypatch.setattr(driver, "WIDE_BATCH", 1 << 30)
    for a, b in zip(several, run(), strict=True):
        assert a.tobytes() == b.tobytes()
    assert several[1][13] != "ok" and (np.delete(several[1], (13, 40)) == "ok").all()


def test_large_results_run_one_by_one() -> None:
    """A thread's stack has no room for those of eight simulations."""
    body = dynamics.RigidBody(np.full(COUNT, 1.0), (1.0, 2.0, 2.5))
    simulation = dynamics.Simulation(body, integrator="rk4")
    found = simulation.run(1.0, step=1e-3, times=np.linspace(0.0, 1.0, 1000))
    assert (np.asarray(found.ending) == "ok").all() and found.position.shape == (COUNT, 1000, 3)


def test_what_runs_several_at_once() -> None:
    assert wide.is_wide(DynamicsConfig(method="rk4"))
    for changed in ({"callbacks": True}, {"tangents": 2}, {"method": "implicit"}):
        assert not wide.is_wide(DynamicsConfig(**{"method": "rk4", **changed}))
