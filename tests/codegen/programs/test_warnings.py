"""The C of simulations and mechanisms compiles without a warning."""

from __future__ import annotations

import subprocess
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bladesmith import cga3d as cga
from bladesmith import dynamics, kinematics
from bladesmith import pga3d as pga
from bladesmith.codegen.build.flags import C_FLAGS, WARNING_FLAGS
from bladesmith.codegen.build.toolchain import compiler
from bladesmith.codegen.targets.c.source import ExtensionSource
from bladesmith.dynamics.integration import driver as dynamics_driver
from bladesmith.errors import InputError
from bladesmith.kinematics.mechanism import driver as mechanism_driver

from ...support.kinematics import FourBar, four_bar

GRAVITY = dynamics.Gravity((0, 0, -9.81))
SPRING = dynamics.Spring((0.2, 0, 0), (0, 0, 2), stiffness=30.0, length=0.5, damping=0.1)
DAMPER = dynamics.Damper(angular=0.1, linear=0.2)
TURN = np.array([[0, 0, 1.0], [0, 1, 0], [-1, 0, 0]])


def top() -> dynamics.RigidBody:
    return dynamics.RigidBody(1.0, [0.1, 0.1, 0.02], (0, 0, 1), angular_velocity=(0.1, 0, 60.0), velocity=(0, -0.1, 0))


def rods(algebra: Any) -> dynamics.System:
    """Two rods, one hanging from the other."""
    rod = [1 / 12, 1 / 12, 1e-3]
    bodies = {name: dynamics.RigidBody(1.0, rod, (x, 0, 0), TURN) for name, x in (("upper", 0.5), ("lower", 1.5))}
    hinges = [
        kinematics.Revolute("base", "upper", algebra.circle((0, 0, 0), (0, 1, 0), 1.0)),
        kinematics.Revolute("upper", "lower", algebra.circle((1, 0, 0), (0, 1, 0), 1.0)),
    ]
    return dynamics.System(bodies, hinges)


def pushed(t: float) -> Any:
    return dynamics.wrench((0, 0, 0.1 * t), (0, 0, 0))


PIN = dynamics.Pin(cga.point((0, 0, -1.0)))
INTEGRATORS = ("auto", "taylor", "rk4", "rkmk4", "midpoint", "cf4", "strang", "adaptive")
#: Simulations, and options of their runs.
SIMULATIONS: dict[str, tuple[Callable[..., Any], dict[str, Any]]] = {
    "free": (lambda **o: dynamics.Simulation(top(), [GRAVITY], **o), {}),
    "loads": (lambda **o: dynamics.Simulation(top(), [GRAVITY, SPRING, DAMPER], **o), {}),
    "function": (lambda **o: dynamics.Simulation(top(), [dynamics.WorldWrench(pushed)], **o), {}),
    "pinned": (lambda **o: dynamics.Simulation(top(), [GRAVITY], [PIN], **o), {}),
    "system": (lambda **o: dynamics.Simulation(rods(cga), [GRAVITY], **o), {}),
    "gradients": (lambda **o: dynamics.Simulation(top(), [GRAVITY, SPRING], **o), {"sensitivities": ["mass"]}),
    "gradients of a system": (
        lambda **o: dynamics.Simulation(rods(cga), [GRAVITY], **o),
        {"sensitivities": ["gravity"]},
    ),
}


#: What cffi adds to programs that call users' functions.
FUNCTIONS = """
static int bs_dynamics_user(void *a, int32_t b, ptrdiff_t c, double d, const double *e, double *f)
{
  (void)a; (void)b; (void)c; (void)d; (void)e; (void)f;
  return 0;
}
"""


def warnings_of(extension: ExtensionSource, folder: Path) -> str:
    """What the compiler says of a program, at a level at which it looks into functions."""
    functions = FUNCTIONS if "bs_dynamics_user(void *handle" in extension.source else ""
    for name, text in {**extension.headers, "kernels.c": extension.source + functions}.items():
        (folder / name).write_text(text, encoding="utf-8")
    own = [option for option in extension.options if not option.startswith("-O")]
    chosen = compiler()
    assert chosen is not None
    command = [*chosen.command, *C_FLAGS, *own, "-O1", *WARNING_FLAGS, "-c", "kernels.c", "-o", "kernels.o"]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True).stderr[:2000]


@pytest.fixture
def programs(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[ExtensionSource]]:
    """Programs that a test loads."""
    found: list[ExtensionSource] = []
    for module in (dynamics_driver, mechanism_driver):

        def load(extension: ExtensionSource, load: Callable[[ExtensionSource], Any] = module.load) -> Any:
            found.append(extension)
            return load(extension)

        monkeypatch.setattr(module, "load", load)
    dynamics_driver.driver.cache_clear()
    yield found
    dynamics_driver.driver.cache_clear()


@pytest.mark.compiles
@pytest.mark.slow
@pytest.mark.skipif(compiler() is None, reason="no compiler")
@pytest.mark.parametrize("name", SIMULATIONS)
def test_simulations(name: str, programs: list[ExtensionSource], tmp_path: Path) -> None:
    make, options = SIMULATIONS[name]
    for integrator in INTEGRATORS:
        with suppress(InputError):  # not all integrators do everything
            make(integrator=integrator).run(0.01, **options)
    assert len(programs) >= 2
    for extension in programs:
        assert warnings_of(extension, tmp_path) == "", extension.name


@pytest.mark.compiles
@pytest.mark.skipif(compiler() is None, reason="no compiler")
@pytest.mark.parametrize("algebra", [cga, pga], ids=["cga3d", "pga3d"])
def test_mechanisms(algebra: Any, programs: list[ExtensionSource], tmp_path: Path) -> None:
    bars = four_bar(FourBar().places(0.8), algebra)
    poses = bars.solve_pose({"a": [0.1, 0.2]})
    bars.solve_pose(targets={"rocker": poses["rocker"][1]})
    bars.jacobian("a", ["c", "coupler"], poses=poses)
    assert len(programs) >= 2
    for extension in programs:
        assert warnings_of(extension, tmp_path) == "", extension.name
