"""Screws, and a joint that is declared here: all that joints have follows from one class."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import permutations
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import dynamics, kinematics
from bladesmith.core.multivector import Multivector
from bladesmith.errors import BladesmithError, InputError
from bladesmith.mechanics.joints.base import Condition, Joint, direction_of

ALGEBRAS = [bs.cga3d, bs.pga3d]
UP = np.array([0.0, 0.0, 1.0])
GRAVITY = dynamics.Gravity((0, 0, -9.81))


@pytest.mark.parametrize("algebra", ALGEBRAS)
@pytest.mark.parametrize(("size", "away"), [(1.0, 0.0), (1e-3, 0.0), (1e3, 1e4)])
def test_screws_of_mechanisms(algebra: Any, size: float, away: float) -> None:
    place, axis, pitch = np.array([1.0, 0.5, -2.0]) * size + away, np.array([0.6, 0.0, 0.8]), -0.3 * size
    screw = kinematics.Screw("a", "b", algebra.line(place, axis), pitch=pitch)
    mechanism = kinematics.Mechanism(["a", "b"], fixed="a", joints=[screw])
    assert mechanism.mobility() == 1 and mechanism.rank() == 5
    twist = mechanism.solve({screw: 2.0})["b"]
    w, v = np.split(dynamics.screw_coordinates(twist), 2)
    np.testing.assert_allclose(w, 2 * axis, atol=1e-9)
    np.testing.assert_allclose(v + np.cross(w, place), 2 * pitch * axis, atol=1e-9 * size)
    angles = np.array([0.0, 1.0, 7.0, -20.0])
    poses = mechanism.solve_pose({screw: angles})
    np.testing.assert_allclose(poses.coordinates(screw)[:, 0], angles, atol=1e-7 if away else 1e-12)
    moved = algebra.matrix(poses["b"]) @ np.append(place, 1.0)
    expected = place + np.outer(angles, pitch * axis)
    np.testing.assert_allclose(moved[:, :3], expected, atol=1e-11 * (size + away))


@pytest.mark.parametrize("order", list(permutations(range(3))))
def test_a_nut_on_a_rod(order: tuple[int, ...]) -> None:
    """A loop of three joints, of which any may close it: the nut turns, and the rod slides."""
    line = bs.cga3d.line((0, 0, 0), UP)
    joints = [
        kinematics.Revolute("base", "nut", bs.cga3d.circle((0, 0, 0), UP, 1.0)),
        kinematics.Screw("nut", "rod", line, pitch=0.05),
        kinematics.Prismatic("base", "rod", line, bs.cga3d.direction((0, 1.0, 0))),
    ]
    mechanism = kinematics.Mechanism(["base", "nut", "rod"], fixed="base", joints=[joints[k] for k in order])
    assert mechanism.mobility() == 1
    np.testing.assert_allclose(mechanism.jacobian(joints[0], joints[2]), [[-0.05]], atol=1e-12)
    poses = mechanism.solve_pose({joints[0]: np.array([0.5, 1.5, 3.0])}, path=True)
    np.testing.assert_allclose(bs.cga3d.matrix(poses["rod"])[:, 2, 3], [-0.025, -0.075, -0.15], atol=1e-12)


PITCH, ARM = 0.1, 0.3


def falling(algebra: Any, joint: Any, **options: Any) -> Any:
    body = dynamics.RigidBody(2.0, (0.1, 0.2, 0.3), (1.0 + ARM, 0.5, 0.2), algebra=algebra)
    return dynamics.Simulation(dynamics.System({"b": body}, [joint]), [GRAVITY], **options)


@pytest.mark.compiles
@pytest.mark.slow
@pytest.mark.parametrize("algebra", ALGEBRAS)
@pytest.mark.parametrize(
    "options",
    [{}, {"coordinates": "maximal"}, {"coordinates": "maximal", "integrator": "adaptive"},
     {"coordinates": "maximal", "integrator": "rk4"}],
)  # fmt: skip
def test_falling_along_a_screw(algebra: Any, options: dict[str, str]) -> None:
    """I q'' + m p^2 q'' = -m g p about the axis."""
    screw = kinematics.Screw("base", "b", algebra.line((1, 0.5, 0), UP), pitch=PITCH)
    run = falling(algebra, screw, **options).run(2.0, times=[0.0, 1.0, 2.0], step=1e-3)
    q = -2 * 9.81 * PITCH / (0.3 + 2 * ARM**2 + 2 * PITCH**2) * run.time**2 / 2
    expected = np.stack([1 + ARM * np.cos(q), 0.5 + ARM * np.sin(q), 0.2 + PITCH * q], -1)
    np.testing.assert_allclose(run.bodies["b"].position, expected, atol=1e-10)
    assert np.ptp(run.energy) < 1e-9
    np.testing.assert_allclose(np.ravel(run.coordinates(0)), q, atol=1e-10)


@pytest.mark.compiles
@pytest.mark.slow
def test_a_press() -> None:
    """The rod falls as its nut lets it: (m + I/p^2) a = -m g."""
    line = bs.cga3d.line((0, 0, 0), UP)
    bodies = {
        "nut": dynamics.RigidBody(1.0, (0.1, 0.1, 0.2)), "rod": dynamics.RigidBody(2.0, (0.1, 0.1, 0.02), (0, 0, 0.3)),
    }  # fmt: skip
    joints = [
        kinematics.Revolute("base", "nut", bs.cga3d.circle((0, 0, 0), UP, 1.0)),
        kinematics.Screw("nut", "rod", line, pitch=0.05),
        kinematics.Prismatic("base", "rod", line, bs.cga3d.direction((0, 1.0, 0))),
    ]
    run = dynamics.Simulation(dynamics.System(bodies, joints), [GRAVITY]).run(1.0, times=[0.0, 0.5, 1.0])
    path = -9.81 * 2 / (2 + 0.2 / 0.05**2) * run.time**2 / 2
    np.testing.assert_allclose(run.bodies["rod"].position[:, 2], 0.3 + path, atol=1e-11)


TABLE = """
[mechanism]
algebra = "pga3d"
bodies = ["a", "b"]
fixed = "a"

[[joints]]
kind = "screw"
a = "a"
b = "b"
"""


def test_files(tmp_path: Path) -> None:
    file = tmp_path / "screw.toml"
    file.write_text(TABLE + "point = [1, 0, 0]\naxis = [0, 0, 1]\npitch = 0.2\n", encoding="utf-8")
    mechanism = kinematics.load_mechanism(file).model.mechanism
    (joint,) = mechanism.joints
    assert isinstance(joint, kinematics.Screw) and joint.pitch == 0.2 and mechanism.mobility() == 1
    for rest, told in (("point = [1, 0, 0]\naxis = [0, 0, 1]\n", "pitch"), ("pitch = 0.2\n", "axis|point"),
                       ("point = [1, 0, 0]\naxis = [0, 0, 1]\npitch = nan\n", "pitch")):  # fmt: skip
        file.write_text(TABLE + rest, encoding="utf-8")
        with pytest.raises(BladesmithError, match=told):
            kinematics.load_mechanism(file)


@pytest.mark.parametrize("pitch", [np.nan, np.inf, "x", None])
def test_pitches_that_are_none(pitch: Any) -> None:
    with pytest.raises(InputError, match="its pitch"):
        kinematics.Screw("a", "b", bs.cga3d.line((0, 0, 0), UP), pitch=pitch)


@dataclass(frozen=True, eq=False)
class Turntable(Joint):
    """A point and a plane through it: one rotation about the normal. All that the package knows of it is here."""

    a: str
    b: str
    point: Multivector
    plane: Multivector
    mobility = 1
    is_sequence = True

    def conditions(self) -> list[Condition]:
        return [Condition(x, x) for x in (self.point, self.plane)]

    def axes(self, objects: list[Multivector]) -> Any:
        return direction_of(objects[1])


@pytest.mark.compiles
@pytest.mark.parametrize("algebra", ALGEBRAS)
def test_a_joint_is_one_class(algebra: Any) -> None:
    axis = np.array([0.6, 0.0, 0.8])
    point = algebra.point((1.0, 0.5, 0.0))
    table = Turntable("base", "b", point, algebra.plane(axis, float(axis @ (1.0, 0.5, 0.0))))
    hinge = kinematics.Revolute("base", "b", algebra.line((1.0, 0.5, 0.0), axis), point)
    results = []
    for joint in (table, hinge):
        mechanism = kinematics.Mechanism(["base", "b"], fixed="base", joints=[joint])
        poses = mechanism.solve_pose({joint: np.array([0.3, 1.2])})
        maximal = falling(algebra, joint, coordinates="maximal").run(0.3, times=[0.3])
        tree = falling(algebra, joint).run(0.3, times=[0.3])
        results.append((
            mechanism.mobility(), mechanism.solve({joint: 1.0})["b"].values, algebra.matrix(poses["b"]),
            maximal.bodies["b"].position, tree.bodies["b"].position, np.ravel(tree.coordinates(0)),
        ))  # fmt: skip
    for x, y in zip(*results, strict=True):
        np.testing.assert_allclose(x, y, atol=1e-9)
    np.testing.assert_allclose(results[0][3], results[0][4], atol=1e-9)
