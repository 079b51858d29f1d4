"""One program of each chapter, in a process of its own where nothing was compiled at install: `chapters.py OUT LEVEL`.

Results go to the file OUT, by the names of `capabilities.PROGRAMS`; of programs that need a compiler, where there is
none, nothing. LEVEL is the compiler's of programs, where it is not the package's own.
"""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Callable
from typing import Any

import numpy as np

STOCK = ("cga3d", "pga3d", "cga2d", "general", "scene", "merge", "reform")
#: A part of the scenes: surfaces along curves.
SWEEPS = "sweeps"
if __name__ == "__main__":  # their imports fail
    sys.modules.update({f"bladesmith.generated.{name}._kernels": None for name in STOCK})  # type: ignore[misc]

import bladesmith as bs  # noqa: E402
from bladesmith import cga3d as cga  # noqa: E402
from bladesmith import codegen, dynamics, kinematics, objects, registration, tracer  # noqa: E402
from bladesmith.codegen.build import extension  # noqa: E402
from bladesmith.codegen.language import Int, Out, Real, Rows, Vector, cos, exp, sqrt  # noqa: E402
from bladesmith.errors import CompilerMissingError  # noqa: E402

RNG = np.random.default_rng(3)
LINES = cga.line(RNG.normal(size=(40, 3)), RNG.normal(size=(40, 3)))
ROBOT = kinematics.DeltaRobot(0.4, 0.1, 0.5, 1.0)
MOTOR = cga.translator([0.1, 0.2, 0.3]).as_kind("motor")


@codegen.kernel(cga.kind("motor"), cga.kind("point"))
def moved(m: Any, x: Any) -> Any:
    return m * x * ~m


@codegen.algorithm
def decayed(rows: Rows[3], out: Out[Vector[3]], count: Int) -> Real:
    """A damped sum."""
    out[:] = 0.0
    total = 0.0
    for i in range(len(rows)):
        for k in range(3):
            out[k] += cos(rows[i, k]) * exp(-float(i) / float(count))
        total += sqrt(rows[i, 0] * rows[i, 0] + rows[i, 1] * rows[i, 1])
    return total


def kernels() -> list[Any]:
    points = RNG.normal(size=(99, 3))
    results = [moved(MOTOR.astype(t), cga.point(points.astype(t))).values for t in (np.float64, np.float32)]
    return [*results, (MOTOR.log() * 0.5).exp().values]


def picture(surface: Any) -> list[Any]:
    camera = tracer.Camera.look_at((0.0, -8.0, 2.0), (0.0, 0.0, 0.5))
    return [np.asarray(tracer.Scene(camera, [tracer.Light((4, -6, 8))], [surface]).render(24, 18))]


def simulations() -> list[Any]:
    start = ROBOT.inverse(np.array([0.1, 0.2, 0.9]))
    run = dynamics.Simulation(ROBOT.system(start)).run(0.02)
    return [run.time, run.violation, run["platform"].motor.values]


def chain() -> Any:
    return kinematics.Chain(kinematics.revolute_axis([[0, 0, 0], [1, 0, 0]], [0, 0, 1]))


def mechanisms() -> list[Any]:
    poses = ROBOT.mechanism(ROBOT.inverse(np.array([0.1, 0.2, 0.9]))).solve_pose()
    return [pose.values for pose in poses.values()]


CHAPTERS: dict[str, Callable[[], list[Any]]] = {
    "kernels": kernels,
    "algorithms": lambda: list(decayed(RNG.normal(size=(7, 3)), 5)),
    "table products": lambda: [
        (bs.algebra(2, 1, 1).multivector(RNG.normal(size=16)) * bs.algebra(2, 1, 1).multivector(np.ones(16))).values
    ],
    "all pairs": lambda: [objects.cost_matrix(LINES, LINES), objects.kmeans(LINES, 3).labels],
    "scenes": lambda: picture(tracer.Sphere((1, 0, 0), 1.0)),
    SWEEPS: lambda: picture(tracer.EvolvedCircles([((0, 0, 0), (0, 0, 1), 1.0), ((0, 0, 1), (0.1, 0, 1), 0.5)])),
    "registration": lambda: [
        registration.register(registration.Model(lines=LINES), registration.Model(lines=MOTOR >> LINES)).motor.values
    ],
    "merging": lambda: [objects.merge_similar(LINES, 2.0).objects.values],
    "simulations": simulations,
    "chains": lambda: [chain().forward([0.1, 0.2]).values, chain().jacobian([0.1, 0.2])],
    "mechanisms": mechanisms,
}


def main() -> None:
    """Run all, and keep what they give."""
    found: dict[str, Any] = {}
    if level := "".join(sys.argv[2:]):
        extension.C_FLAGS = tuple(level if flag.startswith("-O") else flag for flag in extension.C_FLAGS)
    for name, run in CHAPTERS.items():
        with contextlib.suppress(CompilerMissingError):
            found |= {f"{name} {k}": np.asarray(value) for k, value in enumerate(run())}
    np.savez(sys.argv[1], **found)


if __name__ == "__main__":
    main()
