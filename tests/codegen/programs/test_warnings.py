"""All C of the package compiles without a warning: texts that hold what the others do at a level at which the compiler
looks into functions (all, with all bars); of the others its front end reads all, and nothing is made of it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bladesmith import cga3d as cga
from bladesmith import dynamics, kinematics
from bladesmith.codegen.build.toolchain import compiler
from bladesmith.codegen.targets.c.source import ExtensionSource
from bladesmith.dynamics.integration import program as dynamics_program
from bladesmith.errors import InputError

from ...support.build.programs import PROGRAMS, warnings_of
from ...support.effort import FULL

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
INTEGRATORS = ("auto", "taylor", "rk4", "rkmk4", "midpoint", "cf4", "strang", "adaptive", "implicit")
#: Simulations, and options of their runs.
SIMULATIONS: dict[str, tuple[Callable[..., Any], dict[str, Any]]] = {
    "free": (lambda **o: dynamics.Simulation(top(), [GRAVITY], **o), {}),
    "loads": (lambda **o: dynamics.Simulation(top(), [GRAVITY, SPRING, DAMPER], **o), {}),
    "function": (lambda **o: dynamics.Simulation(top(), [dynamics.WorldWrench(pushed)], **o), {}),
    "pinned": (lambda **o: dynamics.Simulation(top(), [GRAVITY], [PIN], **o), {}),
    "system": (lambda **o: dynamics.Simulation(rods(cga), [GRAVITY], **o), {}),
    "gradients": (
        lambda **o: dynamics.Simulation(top(), [GRAVITY, SPRING], **o),
        {"sensitivities": ["mass", "gravity"]},
    ),
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


#: Simulations and programs that are looked into.
LOOKED_INTO = {
    "loads", "function", "gradients of a system", "specimens of kernels", "general", "merge", "reform",
    "scene, nothing", "scene, plain", "scene, disc", "scene, circles by companion", "scene, point pairs",
    "scene, free point pairs", "chains of pga3d", "mechanisms of pga3d",
}  # fmt: skip

assert {*SIMULATIONS, *PROGRAMS} >= LOOKED_INTO


#: Integrators of which simulations are looked into: of the other ones these have the algorithms.
LOOKED_INTO_OF = ("taylor", "adaptive", "implicit")
#: What makes gcc read a text, with all warnings of the lowest level, and stop before it makes code: a half of the time.
READ_ALONE = ("-O0", "-flto", "-fno-fat-lto-objects", "-flto-compression-level=0")


def level_of(is_looked_into: bool) -> tuple[str, ...]:
    """The compiler's options for a text."""
    if FULL or is_looked_into:
        return ("-O1",)
    found = compiler()
    return READ_ALONE if found and "Free Software Foundation" in found.version else ("-O0",)


class SeenError(Exception):
    """A program was asked for."""


@pytest.fixture
def programs(monkeypatch: pytest.MonkeyPatch) -> Iterator[dict[str, ExtensionSource]]:
    """Programs that a test asks for, by their texts; none is compiled and run."""
    found: dict[str, ExtensionSource] = {}

    def load(extension: ExtensionSource) -> Any:
        found[extension.source] = extension
        raise SeenError

    monkeypatch.setattr(dynamics_program, "load", load)
    dynamics_program.program_for.cache_clear()
    yield found
    dynamics_program.program_for.cache_clear()


@pytest.mark.compiles
@pytest.mark.slow
@pytest.mark.skipif(compiler() is None, reason="no compiler")
@pytest.mark.parametrize("name", SIMULATIONS)
def test_simulations(name: str, programs: dict[str, ExtensionSource], tmp_path: Path) -> None:
    make, options = SIMULATIONS[name]
    for integrator in (*LOOKED_INTO_OF, *(i for i in INTEGRATORS if i not in LOOKED_INTO_OF)):
        seen = {*programs}
        with suppress(InputError, SeenError):  # not all integrators do everything
            make(integrator=integrator).run(0.01, **options)
        for source in {*programs} - seen:
            extension = programs[source]
            functions = FUNCTIONS if "bs_dynamics_user(void *handle" in source else ""
            text = replace(extension, source=source + functions)
            level = level_of(name in LOOKED_INTO and integrator in LOOKED_INTO_OF)
            assert warnings_of([text.main()], tmp_path, level) == "", extension.name
    assert len(programs) >= 2


@pytest.mark.compiles
@pytest.mark.slow
@pytest.mark.skipif(compiler() is None, reason="no compiler")
@pytest.mark.parametrize("name", PROGRAMS)
def test_all_other_programs(name: str, tmp_path: Path) -> None:
    is_straight = name.startswith("kernels of")  # no branch, of which an optimiser could know more
    level = ("-O0",) if FULL and is_straight else level_of(name in LOOKED_INTO)
    assert warnings_of(PROGRAMS[name](), tmp_path, level) == ""
