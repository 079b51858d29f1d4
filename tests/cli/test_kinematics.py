"""`bladesmith kinematics`: a robot in, a report and files out, exit statuses."""

from __future__ import annotations

import json
import os
from pathlib import Path

import numpy as np
import pytest

from bladesmith.cli import main
from bladesmith.kinematics.delta.robot import DeltaRobot

from ..support.files import names

DELTA = """
[delta]
base_radius = 0.4
effector_radius = 0.15
upper_arm = 0.6
forearm = 1.2

[pose]
position = [0.2, -0.1, 1.2]
"""
ROBOT = DeltaRobot(0.4, 0.15, 0.6, 1.2)


@pytest.fixture
def delta(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "delta.toml").write_text(DELTA)
    return "delta.toml"


def asked(capsys, *arguments):
    assert main.run(["kinematics", *map(str, arguments), "--json"]) == 0
    out, err = capsys.readouterr()
    return json.loads(out), err


@pytest.mark.slow
def test_a_robot_is_told_and_nothing_is_written(delta, tmp_path, capsys):
    assert main.run(["kinematics", delta]) == 0
    out, err = capsys.readouterr()
    lines = out.splitlines()
    assert lines[0] == "Delta robot:           11 bodies, 15 joints (cga3d)"
    assert "mobility:              9 (rank 51 of 51 constraints on 60 speeds)" in lines
    assert "redundant constraints: 0" in lines and sum("alone: it turns about" in x for x in lines) == 6
    assert "tool (platform):       (0.2, -0.1, 1.2) m" in lines
    condition = np.linalg.cond(ROBOT.forward_jacobian(ROBOT.inverse([0.2, -0.1, 1.2])))
    assert f"condition number:      {condition:.5g}" in lines
    assert err == "" and names(tmp_path) == ["delta.toml"]


def test_the_same_as_json(delta, capsys):
    data, err = asked(capsys, delta)
    theta = ROBOT.inverse([0.2, -0.1, 1.2])
    assert np.allclose(list(data["pose"].values()), theta, atol=1e-12) and err == ""
    assert np.allclose(data["jacobian"]["matrix"], ROBOT.forward_jacobian(theta), atol=1e-10)
    assert data["file"] == "delta.toml" and data["mobility"] == 9 and len(data["joints"]) == 15


@pytest.mark.slow
def test_options_win_over_the_file(delta, capsys):
    data, _ = asked(capsys, delta, "-j", "motor_1=30", "-j", "motor_3=10", "--degrees")
    assert np.allclose(list(data["pose"].values())[::2], np.radians([30, 10]))
    assert np.allclose(data["tool"]["position"], ROBOT.forward(list(data["pose"].values())))
    data, _ = asked(capsys, delta, "--position", 0, 0.1, 1.1)
    assert np.allclose(data["tool"]["position"], [0, 0.1, 1.1], atol=1e-12)
    data, err = asked(capsys, delta, "--to", -0.2, 0.1, 1.3, "--duration", 2, "--samples", 11, "--motion", "a.npz")
    assert err == "wrote a.npz\n"
    with np.load("a.npz") as motion:
        assert np.allclose(motion["position"][[0, -1]], [[0.2, -0.1, 1.2], [-0.2, 0.1, 1.3]], atol=1e-12)
        assert np.array_equal(motion["time"], np.linspace(0, 2, 11))
        assert np.allclose(motion["coordinates"], ROBOT.inverse(motion["position"]), atol=1e-12)


@pytest.mark.slow
def test_everything_that_can_be_asked_for(delta, tmp_path, capsys):
    files = "-o robot.pdf --motion a.csv --motion b.npz --workspace slices.png --to 0 0 1.3 --quiet"
    assert main.run(["kinematics", delta, *files.split(), "--box", "-1", "1", "-1", "1", "0.9", "1.3"]) == 0
    out, err = capsys.readouterr()
    assert err == "" and "Jacobian:" in out
    assert names(tmp_path) == ["a.csv", "b.npz", "delta.toml", "robot.pdf", "slices.png"]
    for name, begins in {"slices.png": b"\x89PNG", "robot.pdf": b"%PDF", "a.csv": b"t [s],motor_1 [rad]"}.items():
        assert Path(name).read_bytes().startswith(begins)


def test_a_urdf_by_itself(tmp_path, monkeypatch, capsys):
    from bladesmith.kinematics.urdf.reader import urdf_example

    monkeypatch.chdir(tmp_path)
    data, _ = asked(capsys, urdf_example("scara"), "-j", "inner=0.4", "-j", "plunge=0.3")
    assert (
        data["kind"] == "robot 'scara'" and data["tool"]["body"] == "gripper" and data["outside_limits"] == ["plunge"]
    )
    data, _ = asked(capsys, urdf_example("arm"), "--tip", "forearm", "--root", "shoulder")
    assert list(data["pose"]) == ["lift", "elbow"] and data["fixed"] == "shoulder"


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ([], "Missing argument"),
        (["none.toml"], "InputError: none.toml: cannot be read: No such file"),
        (["none.urdf"], "none.urdf"),
        (
            ["broken.toml"],
            "InputError: broken.toml, line 3: delta.base_radios is not a known key; did you mean 'base_radius'?",
        ),
        (["delta.toml", "--motion", "a.npz"], "InputError: delta.toml: has no path. Describe one under [path]"),
        (["delta.toml", "--motion", "a.txt"], "InputError: a.txt: motions are written as .npz or .csv, not .txt."),
        (["delta.toml", "--motion", "no/a.csv"], "InputError: no/a.csv: there is no folder no."),
        (["delta.toml", "--motion", "folder.csv"], "InputError: folder.csv: it is a folder."),
        (["delta.toml", "-o", "a.png", "--workspace", "./a.png"], "InputError: a.png: two results have this name."),
        (["delta.toml", "-o", "a.xyz"], "InputError: a.xyz: 'xyz' is not a format of pictures. Use one of"),
        (["link.csv", "--motion", "link.csv"], "the result would take the place of the robot's file."),
        (["delta.toml", "-j", "motor_1"], "InputError: --joint is 'motor_1'; it is NAME=VALUE, such as motor_1=0.5."),
        (["delta.toml", "-j", "motor_1=inf"], "it is NAME=VALUE, such as motor_1=0.5."),
        (
            ["delta.toml", "-j", "moter_1=1"],
            "'moter_1' is not an actuated joint (did you mean 'motor_1'?); there are",
        ),
        (["delta.toml", "--position", "nan", "0", "1"], "InputError: --position[0] is nan; a finite number"),
        (["delta.toml", "--position", "0", "1"], "Option '--position' requires 3 arguments"),
        (["delta.toml", "--duration", "2"], "--duration and --samples are of a path, and there is none. Give --to"),
        (["delta.toml", "--to", "0", "0", "1", "--duration", "0"], "InputError: --duration is 0.0; a positive number"),
        (["delta.toml", "--to", "0", "0", "1", "--samples", "1"], "--samples is 1; a whole number from 2 to"),
        (["delta.toml", "--tip", "platform"], "InputError: delta.toml: tip and root are of robots' files."),
    ],
)
def test_bad_input_is_one_line_and_exit_status_2(arguments, says, delta, tmp_path, capsys):
    (tmp_path / "broken.toml").write_text(DELTA.replace("base_radius", "base_radios"))
    (tmp_path / "folder.csv").mkdir()
    os.link(tmp_path / "delta.toml", tmp_path / "link.csv")
    before = names(tmp_path)
    assert main.run(["kinematics", *arguments]) == 2
    out, err = capsys.readouterr()
    assert says in err and out == "" and "Traceback" not in err, err
    assert names(tmp_path) == before and (tmp_path / "delta.toml").read_text() == DELTA


def test_a_pose_that_cannot_be_taken_is_exit_status_1(delta, tmp_path, capsys):
    assert main.run(["kinematics", delta, "--position", "1.4", "0", "1", "-o", "a.png"]) == 1
    out, err = capsys.readouterr()
    assert err == "SingularError: delta.toml: no pose has the tool at (1.4, 0, 1): UNREACHABLE, arms 2, 3.\n"
    assert out == "" and names(tmp_path) == ["delta.toml"]


def test_a_path_that_is_not_all_reached_leaves_what_there_is(delta, tmp_path, capsys):
    assert main.run(["kinematics", delta, "--to", "2.5", "0", "1.2", "--motion", "a.csv", "-o", "a.png"]) == 1
    out, err = capsys.readouterr()
    assert "mobility:" in out and "first at t = 0." in err.splitlines()[-1] and "UNREACHABLE" in err.splitlines()[-1]
    assert names(tmp_path) == ["a.partial.csv", "a.png", "delta.toml"]
    rows = Path("a.partial.csv").read_text().splitlines()
    assert rows[1].endswith(",OK") and rows[-1].endswith(",nan,UNREACHABLE") and len(rows) == 102


@pytest.mark.slow
@pytest.mark.parametrize("what", [OSError(28, "No space left on device"), KeyboardInterrupt()])
@pytest.mark.parametrize("option", ["-o", "--motion", "--workspace"])
def test_nothing_is_left_half_written(what, option, delta, tmp_path, monkeypatch, capsys):
    real, name = os.replace, "a.csv" if option == "--motion" else "a.png"

    def fail(source, target, *rest):
        if Path(target).name == name:
            raise what
        return real(source, target, *rest)

    monkeypatch.setattr(os, "replace", fail)
    box = ["--box", "0", "0.2", "0", "0.2", "1.1", "1.2"]
    status = main.run(["kinematics", delta, "--to", "0", "0", "1.2", *box, option, name, "--quiet"])
    assert status == (130 if isinstance(what, KeyboardInterrupt) else 2)
    assert names(tmp_path) == ["delta.toml"]


def test_help_shows_an_example(capsys):
    assert main.run(["kinematics", "--help"]) == 0
    shown = " ".join(capsys.readouterr().out.split())
    assert "Example: bladesmith kinematics delta.toml -o robot.png --motion motion.csv --workspace slices.png" in shown
    assert main.run(["--help"]) == 0
    assert "kinematics Say what a robot can do, draw it, move it." in " ".join(capsys.readouterr().out.split())


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


FINGERS = """<mujoco><worldbody><body name="hand" pos="0 0 1"><freejoint/><geom size="0.1"/>
<body name="left"><joint name="left_joint" type="slide" axis="0 1 0" range="0 0.1"/><geom size="0.1"/></body>
<body name="right"><joint name="right_joint" type="slide" axis="0 -1 0"/><geom size="0.1"/></body></body></worldbody>
<equality><joint joint1="right_joint" joint2="left_joint"/></equality></mujoco>"""
DOOR = """<sdf version="1.9"><model name="door"><link name="frame"/><link name="leaf"/>
<joint name="hinge" type="revolute"><parent>frame</parent><child>leaf</child><axis><xyz>0 0 1</xyz></axis></joint>
</model></sdf>"""
BALL = '<mujoco><worldbody><body name="a"><joint name="j" type="ball"/><geom size="1"/></body></worldbody></mujoco>'


def test_files_of_other_formats(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for name, text in (("hand.xml", FINGERS), ("door.sdf", DOOR), ("door.xml", DOOR), ("ball.mjcf", BALL)):
        Path(name).write_text(text)
    data, _ = asked(capsys, "hand.xml")  # it floats: the hand is fixed
    assert data["fixed"] == "hand" and data["mobility"] == 1 and data["tool"]["body"] in ("left", "right")
    (row,) = data["couplings"]
    assert {(x["joint"], x["coefficient"]) for x in row} == {("left_joint", -1.0), ("right_joint", 1.0)}
    for name in ("door.sdf", "door.xml"):
        data, _ = asked(capsys, name)
        assert data["kind"] == "robot 'door'" and list(data["pose"]) == ["hinge"]
    data, _ = asked(capsys, "ball.mjcf")  # no chain goes there
    assert data["mobility"] == 3 and data["kind"] == "mechanism"
    assert main.run(["kinematics", "hand.xml"]) == 0
    assert "right_joint = 1 left_joint, in speeds" in capsys.readouterr().out
    Path("bad.xml").write_text('<!DOCTYPE m [<!ENTITY a "b">]><mujoco/>')
    assert main.run(["kinematics", "bad.xml"]) == 2
    assert "bad.xml:1: a document type is declared" in capsys.readouterr().err
