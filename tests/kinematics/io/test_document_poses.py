"""Poses that mechanism files ask for: by joints and places, best ones, singular and unreachable ones."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from bladesmith.errors import SingularError
from bladesmith.kinematics.delta.robot import DeltaRobot
from bladesmith.kinematics.io.reader import load_mechanism
from bladesmith.status import Status

from ...support.mechanisms.documents import DELTA, written


@pytest.mark.slow
def test_workers_sample_the_same_workspace(setups, monkeypatch):
    monkeypatch.setattr("bladesmith.kinematics.delta.workspace.POSITIONS_PER_CALL", 1000)
    for name in ("scara", "delta"):
        here, reports = setups[name].workspace(), []
        with ThreadPoolExecutor(2) as pool:
            there = setups[name].workspace(progress=reports.append, executor=pool)
        np.testing.assert_array_equal(here.condition, there.condition)
        assert len(reports) > 1 and reports[-1].done == there.reachable.size


def test_poses_by_joints_and_by_places_are_one(tmp_path):
    robot = DeltaRobot(0.4, 0.15, 0.6, 1.2)
    by_angles = load_mechanism(
        written(tmp_path, DELTA + "[pose]\njoints = { motor_1 = 20, motor_3 = 30 }\ndegrees = true\n")
    )
    found = by_angles.solve_pose()
    assert np.allclose(found.coordinates[0, [0, 2]], np.radians([20, 30]))
    there = ", ".join(repr(float(x)) for x in robot.forward(found.coordinates[0]))
    back = load_mechanism(written(tmp_path, DELTA + f"[pose]\nposition = [{there}]\n")).solve_pose()
    assert np.abs(back.coordinates - found.coordinates).max() < 1e-12
    assert abs(back.condition[0] - np.linalg.cond(robot.forward_jacobian(found.coordinates[0]))) < 1e-9


def test_a_delta_stands_where_it_is_best_if_nothing_is_said(tmp_path):
    found = load_mechanism(written(tmp_path, DELTA)).solve_pose()
    assert np.ptp(found.coordinates) < 1e-12 and np.abs(found.position[0, :2]).max() < 1e-12
    robot, axis = DeltaRobot(0.4, 0.15, 0.6, 1.2), np.zeros((500, 3))
    axis[:, 2] = np.linspace(0.01, 1.79, 500)
    theta, status = robot.inverse(axis, status=True)
    others = [np.linalg.cond(robot.forward_jacobian(x)) for x in theta[status == Status.OK]]
    assert found.condition[0] < 1.001 * min(others)


def test_what_cannot_be_reached_says_why(tmp_path):
    with pytest.raises(
        SingularError, match=r"robot.toml: no pose has the tool at \(1.4, 0, 1\): UNREACHABLE, arms 2, 3"
    ):
        load_mechanism(written(tmp_path, DELTA + "[pose]\nposition = [1.4, 0, 1]\n")).solve_pose()


def test_a_stretched_arm_is_singular_and_loses_the_direction_along_it(tmp_path):
    angle = np.radians(120)
    way = np.array([np.cos(angle), 0, np.sin(angle)])
    place = np.array([0.25, 0, 0]) + 1.8 * way
    text = f"[pose]\nposition = [{', '.join(map(repr, place.tolist()))}]\n"
    shown = load_mechanism(written(tmp_path, DELTA + text)).report()
    data = shown.data["jacobian"]
    assert data["status"] == "SINGULAR" and data["condition"] is None
    (lost,), (stuck,) = data["lost"], data["without_effect"]
    assert np.linalg.norm(np.cross(lost, way)) < 1e-6 * np.linalg.norm(lost)
    assert abs(stuck[0]) > 1 - 1e-6  # its own motor does not move the platform
    assert "infinite: the pose is singular" in shown.text() and "the tool cannot move:" in shown.text()


def test_the_pose_of_an_arm_may_be_turned(setups, tmp_path):
    arm = setups["arm"]
    home = arm.solve_pose()
    place = home.position[0] + (0.02, -0.03, 0.05)
    values = ", ".join(f"{n} = {x!r}" for n, x in zip(arm.model.inputs, home.coordinates[0].tolist(), strict=True))
    text = f"""
[urdf]
example = "arm"
[pose]
joints = {{ {values} }}
position = [{", ".join(map(repr, place.tolist()))}]
orientation = {{ axis = [0, 0, 1], degrees = 25 }}
"""
    moved = load_mechanism(written(tmp_path, text))
    assert moved.model.tool == "flange"  # behind all joints, and what is welded to them
    found = moved.solve_pose()
    before, after = (arm.model.chain.algebra.matrix(arm.model.chain.forward(x.coordinates[0])) for x in (home, found))
    c, s = np.cos(np.radians(25)), np.sin(np.radians(25))
    assert np.abs(after[:3, :3] - np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) @ before[:3, :3]).max() < 1e-10
    assert np.abs(after[:3, 3] - place).max() < 1e-10
