"""Simulations by numba have the bits of C, and their text for GPUs compiles."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import dynamics, kinematics
from bladesmith.codegen.programs.dynamics.config import DynamicsConfig
from bladesmith.codegen.programs.dynamics.dynamics import dynamics_program
from bladesmith.codegen.targets.cuda.printer import stock_source
from bladesmith.dynamics.integration.program import program_for
from bladesmith.errors import InputError

from ...support import cuda
from ...support.build.numba_code import numba_text_as_python
from ...support.effort import FULL

CGA, PGA = bs.cga3d, bs.pga3d
GRAVITY = dynamics.Gravity((0.3, -0.2, -9.81))
DAMPED = (dynamics.Damper(0.1, 0.2), dynamics.Spring((0.2, 0.1, 0.0), (0.0, 0.0, 2.0), 30.0, 0.5, 0.3))
POINT, SPIN = np.array([0.2, 0.1, 1.0]), np.array([0.4, 1.3, -0.6])
TIMES = [0.03, 0.1]


def body(algebra: Any, count: int | None = None) -> dynamics.RigidBody:
    """A body, or some, whose point stays where it is."""
    mass = 2.0 if count is None else np.linspace(1.0, 3.0, count)
    return dynamics.RigidBody(
        mass, (1.0, 2.0, 2.5), velocity=np.cross(SPIN, -POINT), angular_velocity=SPIN, algebra=algebra
    )


def pushed(algebra: Any) -> dynamics.WorldWrench:
    """A wrench that depends on time and twist."""

    def wrench(t: float, _: Any, twist: Any) -> Any:
        return dynamics.wrench((np.sin(t), 0.2, 0.3), (0, 0, 0), algebra=algebra) - 0.1 * twist

    return dynamics.WorldWrench(wrench)


def path(algebra: Any) -> Callable[[float], Any]:
    return lambda t: algebra.point(POINT + np.array([0.0, 0.1, 0.2]) * t**3)


def pendulum(algebra: Any) -> dynamics.System:
    bodies = {
        "upper": dynamics.RigidBody(1.0, (0.15, 0.2, 0.3), (0, 0.5, 0), algebra=algebra),
        "lower": dynamics.RigidBody(2.0, (0.3, 0.2, 0.25), (0, 1.4, 0.2), algebra=algebra),
    }
    joints = [
        kinematics.Spherical("base", "upper", algebra.point((0, 0, 0))),
        kinematics.Spherical("upper", "lower", algebra.point((0, 1, 0))),
    ]
    return dynamics.System(bodies, joints)


#: Algebra, body or system, loads, constraints, options of the simulation, and of the run.
CASES: dict[str, tuple[Any, ...]] = {
    "flight": (CGA, body, [GRAVITY], [], {"integrator": "rk4"}, {}),
    "loads": (PGA, body, [GRAVITY, *DAMPED], [], {"integrator": "cf4"}, {}),
    "batch": (CGA, lambda a: body(a, 5), [GRAVITY, *DAMPED], [], {"integrator": "adaptive", "map": "cayley"}, {}),
    "implicit": (PGA, lambda a: body(a, 3), [GRAVITY, *DAMPED], [], {"integrator": "implicit"}, {}),
    "implicit and held": (
        CGA, pendulum, [GRAVITY, dynamics.Damper(50.0, 0.0, "upper", "lower")], [], {"integrator": "implicit"}, {},
    ),
    "flows": (PGA, body, [GRAVITY], [dynamics.Pin(PGA.point(POINT))], {"integrator": "yoshida6"}, {}),
    "function": (CGA, body, [GRAVITY, pushed(CGA)], [], {"integrator": "midpoint"}, {}),
    "null space": (CGA, body, [GRAVITY], [dynamics.Pin(CGA.point(POINT))], {"integrator": "midpoint"}, {}),
    "path": (
        PGA, body, [GRAVITY], [dynamics.PinPath(PGA.point(POINT), path(PGA))], {"integrator": "adaptive"},
        {"project": True},
    ),
    "system": (CGA, pendulum, [GRAVITY], [], {"integrator": "rk4"}, {}),
    "series": (CGA, body, [GRAVITY, *DAMPED], [], {"integrator": "taylor"}, {}),
    "series in flight": (PGA, body, [GRAVITY], [], {"integrator": "taylor"}, {}),
    "series and reactions": (
        CGA, body, [GRAVITY, DAMPED[0]], [dynamics.Pin(CGA.point(POINT))],
        {"integrator": "taylor", "stabilization": "projection"}, {},
    ),
    "gradients": (
        PGA, body, [GRAVITY, *DAMPED], [], {"integrator": "rkmk4"}, {"sensitivities": ["mass", "velocity[1]"]},
    ),
}  # fmt: skip


#: That which numba compiles, for a quarter of a minute: the text of all of them runs as Python.
NUMBA_CASES = ["function"]
#: Those that run as text for GPUs.
GPU_CASES = ["flight", "batch", "implicit", "flows", "null space", "system", "series", "gradients"]


def ends(case: str, target: str) -> list[Any]:
    """All that a simulation leaves."""
    algebra, make, loads, constraints, options, run = CASES[case]
    simulation = dynamics.Simulation(make(algebra), loads, constraints, target=target, **options)
    found = simulation.run(TIMES[-1], times=TIMES, step=0.01, **run)
    own = found._run
    return [own._states, own.tangents, own.steps, own.start, own.reached, np.array(found.message)]


def assert_same_bits(case: str) -> None:
    assert all(x.tobytes() == y.tobytes() for x, y in zip(ends(case, "c"), ends(case, "numba"), strict=True))


@pytest.mark.slow
@pytest.mark.compiles
@pytest.mark.parametrize("case", CASES)
def test_text_for_numba_has_the_bits_of_c(case: str) -> None:
    program_for.cache_clear()
    with numba_text_as_python():
        assert_same_bits(case)
    program_for.cache_clear()


@pytest.mark.peers
@pytest.mark.slow
@pytest.mark.compiles
@pytest.mark.parametrize("case", CASES if FULL else NUMBA_CASES)
def test_numba_has_the_bits_of_c(case: str) -> None:
    pytest.importorskip("numba")
    assert_same_bits(case)


@pytest.mark.gpu
@pytest.mark.slow
@pytest.mark.compiles
@pytest.mark.parametrize("case", GPU_CASES)
@cuda.each_device
def test_text_for_gpus_has_the_bits_of_c(case: str, where: str) -> None:
    """Each simulation is a thread, with work of its own."""
    algebra, make, loads, constraints, options, run = CASES[case]

    def states(target: str) -> list[Any]:
        simulation = dynamics.Simulation(make(algebra), loads, constraints, target=target, **options)
        own = simulation.run(TIMES[-1], times=TIMES, step=0.01, **run)._run
        return [own._states, own.tangents, own.steps, own.start, own.reached, own.status]

    expected = states("c")
    with cuda.devices(where) as devices:
        program_for.cache_clear()
        found = states("cuda")
        assert devices
    program_for.cache_clear()
    assert all(x.tobytes() == y.tobytes() for x, y in zip(expected, found, strict=True))


#: Programs whose text for GPUs is compiled: what they need, and what they have.
PROGRAMS = {
    "flight": DynamicsConfig(method="rk4", loads=("gravity",)),
    "adaptive": DynamicsConfig(method="adaptive", loads=("gravity", "drag", "spring")),
    "series": DynamicsConfig(method="taylor", loads=("gravity", "drag", "spring"), springs=1),
    "constraints": DynamicsConfig("pga3d", 2, "constrained", ("gravity",), ("point",), 6, "cf4"),
}


@pytest.mark.gpu
@pytest.mark.slow
@pytest.mark.parametrize("name", PROGRAMS)
def test_the_text_for_gpus_compiles(name: str) -> None:
    needs = PROGRAMS[name]
    launchers = {f"launch_bs_{each}_items_f64" for each in ("run", "evaluate", *(["project"] * (needs.rows > 0)))}
    cuda.assert_clean(stock_source(dynamics_program(needs).files), "compute_90", launchers, FULL or name == "flight")


def test_functions_do_not_run_on_gpus() -> None:
    simulation = dynamics.Simulation(body(CGA), [pushed(CGA)], integrator="rk4", target="cuda")
    with pytest.raises(InputError, match="functions of time or state do not run on a GPU"):
        simulation.run(0.1)
