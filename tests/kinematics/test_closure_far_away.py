"""What a new user meets: joints by the names they are given, conditions with a value, loops far away, bad requests."""

from __future__ import annotations

import copy
import pickle
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from bladesmith import Status, kinematics
from bladesmith import cga3d as cga
from bladesmith.cli import main
from bladesmith.errors import ConstraintError, InputError, ShapeError, SingularError

FAR = [(0.0, 0.0, 0.0), (1e4, -3e3, 2e3), (0.0, 1e4, 0.0)]


def hinge(a: str, b: str, at: object, axis: object) -> kinematics.Joint:
    return kinematics.Revolute(a, b, cga.circle(at, axis, 0.2))


def test_joints_without_a_name_are_found_by_what_joint_names_says() -> None:
    mechanism = kinematics.Mechanism(bodies=["base", "arm"], fixed="base")
    joint = mechanism.add(hinge("base", "arm", (1, 0, 0), (0, 0, 1)))
    (name,) = mechanism.joint_names
    assert np.array_equal(mechanism.jacobian(name, "arm"), mechanism.jacobian(joint, "arm"))
    assert np.array_equal(mechanism.solve({name: 2.0})["arm"].values, 2.0 * mechanism.allowed_twists("arm").values[0])
    mechanism.add(hinge("base", "arm", (1, 0, 1), (0, 0, 1)))
    with pytest.raises(InputError, match="2 joints are"):
        mechanism.jacobian(name, "arm")


@pytest.mark.parametrize("distance", [3.0, 3e-3, 3e3])
def test_a_condition_may_have_a_number_for_its_value(distance: float) -> None:
    ends = cga.point((1, 0, 0)), cga.point((1 + distance, 0, 0))  # a rod: X . Y = -d^2 / 2
    for value in (-(distance**2) / 2, cga.multivector({"": -(distance**2) / 2}), None):
        rod = kinematics.Bilinear("a", "b", *ends, product="inner", H=value)
        assert kinematics.Mechanism(["a", "b"], "a", [rod]).mobility() == 5
    wrong = kinematics.Mechanism(["a", "b"], "a", [kinematics.Bilinear("a", "b", *ends, "inner", H=distance**2)])
    with pytest.raises(ConstraintError, match="apart"):
        wrong.mobility()


def bennett(away: NDArray[np.float64]) -> kinematics.Mechanism:
    """Bennett's loop by Denavit-Hartenberg: opposite links alike, sin(twist) / length the same for all."""
    lengths, twists = np.array([1.0, 1.5, 1.0, 1.5]), np.arcsin(np.array([1.0, 1.5, 1.0, 1.5]) * np.sin(0.6))
    first = 0.7
    second = 2 * np.arctan(
        np.sin((twists[1] + twists[0]) / 2) / np.sin((twists[1] - twists[0]) / 2) / np.tan(first / 2)
    )
    names, joints, pose = ["frame", "one", "two", "three"], [], np.eye(4)
    angles = (first, second, -first, -second)
    for i, (t, a, s) in enumerate(zip(angles, lengths, twists, strict=True)):
        joints.append(hinge(names[i - 1], names[i], away + pose[:3, 3], pose[:3, 2]))
        c, s, ct, st = np.cos(t), np.sin(t), np.cos(s), np.sin(s)
        pose = pose @ [[c, -s * ct, s * st, a * c], [s, c * ct, -c * st, a * s], [0, st, ct, 0], [0, 0, 0, 1]]
    assert np.abs(pose - np.eye(4)).max() < 1e-14
    return kinematics.Mechanism(names, "frame", joints)


@pytest.mark.parametrize("away", FAR)
def test_loops_that_close_by_their_geometry_keep_their_mobility_far_away(away: tuple[float, float, float]) -> None:
    place = np.array(away)
    assert bennett(place).mobility() == 1
    axes = [np.array(x) / np.linalg.norm(x) for x in ((0, 0, 1), (1, 0.2, 1), (1, 1, 0.3), (0.1, 1, 0.2))]
    ends = [("frame", "a"), ("a", "b"), ("b", "c"), ("frame", "c")]
    ball = kinematics.Mechanism(
        ["frame", "a", "b", "c"], "frame", [hinge(*e, place + x, x) for e, x in zip(ends, axes, strict=True)]
    )
    ratio = np.linalg.solve(np.column_stack([axes[1], axes[2], -axes[3]]), -axes[0])[2]
    assert ball.mobility() == 1 and len(ball.redundant()) == 3
    assert abs(ball.jacobian(*(ball.joints[i] for i in (0, 3)))[0, 0] / ratio - 1) < 1e-5
    loose = hinge("frame", "c", place + axes[3], axes[3] + (0, 0, 1e-4))  # no longer through the middle
    tight = kinematics.Mechanism(["frame", "a", "b", "c"], "frame", [*ball.joints[:3], loose])
    assert tight.mobility() == 0


def test_a_workspace_without_a_box_is_refused_before_anything_is_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    robot = tmp_path / "arm.toml"
    robot.write_text(
        '[mechanism]\nbodies = ["base", "arm"]\ninputs = ["motor"]\ntool = { body = "arm", point = [1, 0, 0] }\n'
        '[[joints]]\nname = "motor"\nkind = "revolute"\na = "base"\nb = "arm"\npoint = [0, 0, 0]\naxis = [0, 0, 1]\n'
        "[path]\njoints = { motor = [0, 1] }\nsamples = 3\n"
    )
    given = [str(robot), "--motion", str(tmp_path / "m.csv"), "--workspace", str(tmp_path / "w.png")]
    assert main.run(["kinematics", *given]) == 2
    assert "has no box" in capsys.readouterr().err
    assert [x.name for x in tmp_path.iterdir()] == ["arm.toml"]


@pytest.mark.parametrize("away", FAR)
def test_a_cardan_shaft_is_followed_around_far_away(away: tuple[float, float, float]) -> None:
    bend, place = 0.4, np.array(away)
    along, out, arm = np.array([1.0, 0, 0]), np.array([np.cos(bend), np.sin(bend), 0]), np.array([0, 0, 1.0])
    cross = kinematics.Universal("in", "out", cga.circle(place, arm, 1.0), cga.circle(place, np.cross(out, arm), 1.0))
    shaft = kinematics.Mechanism(["frame", "in", "out"], "frame")
    first = shaft.add(hinge("frame", "in", place - along, along))
    shaft.add(cross)
    last = shaft.add(hinge("frame", "out", place + out, out))
    assert shaft.mobility() == 1
    turns = np.linspace(0, 2 * np.pi, 25)
    found = shaft.solve_pose({first: turns}, path=True)
    expected = np.arctan2(np.sin(turns) * np.cos(bend), np.cos(turns))
    off = np.angle(np.exp(1j * (found.coordinates(last)[:, 0] - expected)))
    assert not found.status.any()
    assert np.abs(off).max() < (1e-6 if place.any() else 1e-12)
    assert abs(shaft.jacobian(first, last)[0, 0] - np.cos(bend)) < (1e-6 if place.any() else 1e-12)


def test_a_delta_robot_is_a_mechanism_at_one_pose_that_it_has() -> None:
    robot = kinematics.DeltaRobot(0.4, 0.15, 0.6, 1.2)
    assert robot.mechanism([0.1, 0.2, 0.3]).mobility() == 9
    with pytest.raises(ShapeError, match="one pose"):
        robot.mechanism([[0.1, 0.2, 0.3]])
    with pytest.raises(SingularError, match="INVALID"):
        robot.mechanism([np.nan, 0.2, 0.3])
    with pytest.raises(SingularError, match="UNREACHABLE"):
        kinematics.DeltaRobot(0.4, 0.15, 1.2, 0.6).mechanism([1.5, -1.5, 3.0])


@pytest.mark.filterwarnings("error")
def test_poses_that_are_not_found_are_no_numbers() -> None:
    up, bars = (0, 0, 1), kinematics.Mechanism(["frame", "left", "coupler", "right"], "frame")  # Watt's linkage
    ends = [("frame", "left", (0, 0, 0)), ("left", "coupler", (2, 0, 0)), ("coupler", "right", (2, 1, 0))]
    for a, b, at in [*ends, ("frame", "right", (4, 1, 0))]:
        bars.add(hinge(a, b, at, up))
    found = bars.solve_pose({bars.joints[0]: [0.0, 0.3, 3.0, 0.2]})
    assert found.status.tolist() == [Status.OK, Status.OK, Status.UNREACHABLE, Status.OK]
    none = np.isnan(found["coupler"].values)
    assert none[2].all() and not none[[0, 1, 3]].any() and np.isnan(found.coordinates(bars.joints[3])[2]).all()
    rates, status = bars.jacobian(bars.joints[0], "coupler", poses=found, status=True)
    assert np.isnan(rates[2]).all() and status[2] and not status[[0, 1, 3]].any()
    for other in (pickle.loads(pickle.dumps(found)), copy.deepcopy(found)):
        assert np.array_equal(other["left"].values, found["left"].values, equal_nan=True)
        again = other.mechanism.at({name: other[name][1] for name in other.mechanism.moving})
        assert again.mobility() == 1 and again.residual() < 1e-10
        assert pickle.loads(pickle.dumps(again)).mobility() == 1
