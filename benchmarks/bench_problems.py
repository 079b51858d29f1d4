"""Published problems of multibody dynamics (examples/dynamics/published_problems.py), beside MuJoCo.

MuJoCo keeps loops by soft constraints: Bricard's mechanism is given stiff ones. Both give a thousand results of a
motion. Times are the least of several runs, without what is made once.

    python benchmarks/bench_problems.py
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from timing import Row, arguments, run_parts, seconds

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "examples" / "dynamics"))

import published_problems as problems  # noqa: E402

HEAD = """<option integrator="RK4" timestep="{step}" gravity="{gravity}">
  <flag energy="enable" contact="disable"/></option>"""
PENDULUM = """<body><joint axis="0 0 1"/><inertial pos="-1 0 0" mass="1" diaginertia="1e-6 1e-6 1e-6"/></body>"""
GOVERNOR = """
<body pos="0 0 0"><joint name="shaft" axis="0 0 1"/><geom type="box" size=".005 .005 .5" pos="0 0 .5" density="3000"/>
  <body pos="0 0 .5"><joint axis="0 0 1" type="slide"/><geom type="box" size=".05 .05 .05" density="3000"/>
    <site name="right" pos=".05 0 0"/><site name="left" pos="-.05 0 0"/></body>
  <body pos=".05 0 1" euler="0 30 0"><joint axis="0 1 0"/>
    <geom type="box" size=".5 .005 .005" pos=".5 0 0" density="3000"/>
    <site name="right_rod" pos=".5 0 0"/>
    <body pos="1 0 0"><inertial pos="0 0 0" mass="5" diaginertia="1e-9 1e-9 1e-9"/></body></body>
  <body pos="-.05 0 1" euler="0 -30 0"><joint axis="0 1 0"/>
    <geom type="box" size=".5 .005 .005" pos="-.5 0 0" density="3000"/>
    <site name="left_rod" pos="-.5 0 0"/>
    <body pos="-1 0 0"><inertial pos="0 0 0" mass="5" diaginertia="1e-9 1e-9 1e-9"/></body></body>
</body>"""
SPRINGS = """
<tendon>
  <spatial springlength=".5" stiffness="8e5" damping="4e4"><site site="right"/><site site="right_rod"/></spatial>
  <spatial springlength=".5" stiffness="8e5" damping="4e4"><site site="left"/><site site="left_rod"/></spatial>
</tendon>"""


def bricard() -> tuple[str, str]:
    """Bodies from hinge to hinge, the last one welded to the world by two connections."""
    corners = np.array([[0, 0, 0], [1, 0, 0], [1, -1, 0], [1, -1, 1], [0, -1, 1], [0, 0, 1]], float)
    edges = np.roll(corners, -1, axis=0) - corners
    text, before = "", np.zeros(3)
    for i in range(5):
        pos, axis = corners[i] - before, np.cross(edges[i - 1], edges[i])
        moments = (1 + 0.1**2 - np.abs(edges[i]) * (1 - 0.1**2)) / 12
        text += f'<body name="r{i}" pos="{words(pos)}"><joint axis="{words(axis)}"/>'
        text += f'<inertial pos="{words(edges[i] / 2)}" mass="1" diaginertia="{words(moments)}"/>'
        before = corners[i]
    hinge = np.cross(edges[4], edges[5])
    loop = "".join(
        f'<connect body1="r4" anchor="{words(edges[4] + shift * hinge)}" solref="2e-3 1" solimp=".9999 .9999 .001"/>'
        for shift in (-0.5, 0.5)
    )
    return text + "</body>" * 5, f"<equality>{loop}</equality>"


def words(numbers: Any) -> str:
    """Numbers for an attribute."""
    return " ".join(f"{x:.17g}" for x in numbers)


def mujoco_motion(bodies: str, rest: str, gravity: str, step: float, speed: float = 0.0) -> tuple[float, Any, float]:
    """Seconds, energies, and where the second joint ends."""
    import mujoco

    head = HEAD.format(step=step, gravity=gravity)
    model = mujoco.MjModel.from_xml_string(f"<mujoco>{head}<worldbody>{bodies}</worldbody>{rest}</mujoco>")
    data = mujoco.MjData(model)
    per = max(1, round(0.01 / step))

    def run() -> None:
        mujoco.mj_resetData(model, data)
        data.qvel[0] = speed
        energies.clear()
        for _ in range(1000):
            mujoco.mj_step(model, data, per)
            energies.append(data.energy.sum())

    energies: list[float] = []
    took = seconds(run, 3)
    return took, np.array(energies), float(data.qpos[1]) if model.nq > 1 else 0.0


def ours(number: str) -> Iterator[Row]:
    """This package."""
    problem = next(problem for problem in problems.PROBLEMS if problem.name.startswith(number))
    simulation, times = problem.simulation(), np.linspace(0, problem.duration, 1001)
    run = partial(simulation.run, problem.duration, times=times, strict=True)
    error = problem.error(run())
    yield {"what": problem.name, "method": f"ours, {problem.what}", "error": error, "ns": seconds(run, 3) * 1e9}


def part(number: str, peer: Callable[[], Iterator[Row]] | None = None) -> Any:
    """A problem by us, and by MuJoCo where it is installed."""

    def rows(_: Any) -> Iterator[Row]:
        yield from ours(number)
        try:
            yield from peer() if peer else ()
        except ImportError:
            return

    return rows


def energies(name: str, bodies: str, rest: str) -> Iterator[Row]:
    """How far MuJoCo's energy varies."""
    for step in (1e-2, 1e-3):
        took, found, _ = mujoco_motion(bodies, rest, "0 -9.81 0", step)
        yield {"what": name, "method": f"MuJoCo, steps of {step:g} s", "error": float(np.ptp(found)), "ns": took * 1e9}


def heights() -> Iterator[Row]:
    """How far MuJoCo's slider is from SciPy's at the end."""
    expected = problems.governor_by_scipy(np.array([0.0, 10.0]))[-1] - 0.5
    for step in (1e-4, 2e-5):
        took, _, height = mujoco_motion(GOVERNOR, SPRINGS, "0 0 -9.81", step, problems.SPEED)
        name = f"MuJoCo, steps of {step:g} s"
        yield {"what": "A05 stiff flyball governor", "method": name, "error": abs(height - expected), "ns": took * 1e9}


PARTS = {
    "A01": part("A01", partial(energies, "A01 pendulum", PENDULUM, "")),
    "A03": part("A03"),
    "A04": part("A04", lambda: energies("A04 Bricard's mechanism", *bricard())),
    "A05": part("A05", heights),
}


def main() -> None:
    run_parts(arguments(__doc__, PARTS).parse_args(), PARTS)


if __name__ == "__main__":
    main()
