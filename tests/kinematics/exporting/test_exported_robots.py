"""Robots as C files: the bits of the package, at ordinary, singular and unreachable poses."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

import bladesmith as bs
from bladesmith.cli.main import run
from bladesmith.errors import InputError
from bladesmith.kinematics import Chain, DeltaRobot, load_urdf
from bladesmith.kinematics.io.reader import load_mechanism
from bladesmith.kinematics.urdf.reader import urdf_example

from ...support.checkout import CHECKOUT
from ...support.export.shaders import assert_valid
from ...support.export.shared import SharedLibrary

EXAMPLES = CHECKOUT / "examples" / "kinematics"
#: A six-axis arm, and one with joints that translate.
ROWS = {
    "six_axis": ("RRRRRR", [(0, np.pi / 2, 0.1625, 0), (-0.425, 0, 0, 0), (-0.3922, 0, 0, 0),
                            (0, np.pi / 2, 0.1333, 0), (0, -np.pi / 2, 0.0997, 0), (0, 0, 0.0996, 0)]),
    "scara": ("RRPR", [(0.3, 0, 0.4, 0), (0.25, np.pi, 0, 0), (0, 0, 0, 0), (0, 0, 0.1, 0.5)]),
}  # fmt: skip


@pytest.mark.compiles
@pytest.mark.parametrize("algebra", ["pga3d", "cga3d"])
@pytest.mark.parametrize("name", list(ROWS))
def test_exported_chain_has_the_bits_of_the_chain(name: str, algebra: str, tmp_path: Path) -> None:
    letters, rows = ROWS[name]
    arm = Chain.from_dh(rows, joints=letters, algebra=getattr(bs, algebra))
    (path,) = arm.export("c99", tmp_path, name)
    assert "malloc" not in path.read_text() and path.read_text().count("#include") == 2
    library = SharedLibrary(tmp_path, name, {"motor": 2, "matrix": 2, "jacobian": 2})
    rng, n = np.random.default_rng(1), len(rows)
    for q in (*rng.normal(size=(20, n)), np.zeros(n), np.full(n, 1e6), np.full(n, np.nan), np.full(n, 1e-310)):
        motor, matrix, jacobian = np.zeros(8), np.zeros((4, 4)), np.zeros((6, n))
        library("motor", q, motor)
        library("matrix", q, matrix)
        library("jacobian", q, jacobian)
        assert np.array_equal(motor, arm.forward(q).values, equal_nan=True)
        assert np.array_equal(jacobian, arm.jacobian(q, point=np.zeros(3)), equal_nan=True)
        assert np.array_equal(matrix, arm.forward(q).to_matrix(), equal_nan=True)


@pytest.mark.compiles
def test_exported_delta_robot_has_the_bits_of_the_robot(tmp_path: Path) -> None:
    robot = DeltaRobot(0.4, 0.1, 0.5, 1.0)
    robot.export("c99", tmp_path)
    library = SharedLibrary(
        tmp_path, "delta", {"inverse": 3, "forward": 3, "inverse_jacobian": 3, "forward_jacobian": 3}
    )
    rng = np.random.default_rng(2)
    positions = [*(rng.normal(size=(30, 3)) * 0.4 + (0, 0, 0.8)), np.full(3, 9.0), np.full(3, np.nan)]
    for y in positions:
        code, angles, back, matrix = np.zeros(1), np.zeros(3), np.zeros(3), np.zeros((3, 3))
        library("inverse", angles, code, y)
        expected, status = robot.inverse(y, status=True)
        assert int(code[0]) == int(status) and np.array_equal(angles, expected, equal_nan=True)
        library("inverse_jacobian", matrix, code, y)
        assert np.array_equal(matrix, robot.inverse_jacobian(y, status=True)[0], equal_nan=True)
        theta = rng.normal(size=3)
        library("forward", back, code, theta)
        expected, status = robot.forward(theta, status=True)
        assert int(code[0]) == int(status) and np.array_equal(back, expected, equal_nan=True)
        library("forward_jacobian", matrix, code, theta)
        assert np.array_equal(matrix, robot.forward_jacobian(theta, status=True)[0], equal_nan=True)


@pytest.mark.slow
@pytest.mark.parametrize("file", ["four_bar.toml", "stewart.toml"])
def test_exported_mechanism_has_the_bits_of_the_mechanism(file: str, tmp_path: Path) -> None:
    model = load_mechanism(EXAMPLES / file).model
    mechanism = model.mechanism
    mechanism.export("c99", tmp_path, model.inputs, "machine")
    library = SharedLibrary(tmp_path, "machine", {"poses": -4})
    count = len(mechanism.moving)
    start, motors, matrices = np.tile(np.eye(8)[0], (count, 1)), np.zeros((count, 8)), np.zeros((count, 4, 4))
    for value in (0.0, 0.05, -0.03, 0.1):
        wanted = np.full(len(model.inputs), value)
        assert library("poses", wanted, start, motors, matrices) == 0
        poses = mechanism.solve_pose(dict(zip(model.inputs, wanted.tolist(), strict=True)))
        assert np.array_equal(motors, poses.own)
        assert np.array_equal(matrices, [poses[body].to_matrix() for body in mechanism.moving])
    wanted = np.full(len(model.inputs), np.nan)
    assert library("poses", wanted, start, motors, matrices) == 3
    if len(model.inputs) > 1:  # one leg much longer than the others
        assert library("poses", 50.0 * np.eye(len(model.inputs))[0], start, motors, matrices) in (1, 2)


def test_robots_that_a_language_cannot_have_are_refused(tmp_path: Path) -> None:
    arm = Chain.from_dh(ROWS["scara"][1], joints="RRPR")
    with pytest.raises(InputError, match="hands a part of"):
        arm.export("glsl", tmp_path / "new")
    model = load_mechanism(EXAMPLES / "four_bar.toml").model
    for options in ({"language": "glsl"}, {"language": "c99", "dtype": "float32"}):
        with pytest.raises(InputError, match="found with float64 numbers"):
            model.mechanism.export(folder=tmp_path / "new", driven=model.inputs, **options)
    assert not (tmp_path / "new").exists()
    (path,) = DeltaRobot(0.4, 0.1, 0.5, 1.0).export("glsl", tmp_path)
    assert_valid(path)


def test_robot_of_a_file_is_exported_as_its_chain(tmp_path: Path) -> None:
    robot = load_urdf(urdf_example("arm"))
    (path,) = robot.export("c99", tmp_path, "arm")
    expected = path.read_text()
    robot.chain("flange").export("c99", tmp_path, "arm")
    assert path.read_text() == expected
    shutil.copy(urdf_example("arm"), tmp_path / "arm.urdf")
    assert run(["export", str(tmp_path / "arm.urdf"), "-l", "c99", "-o", str(tmp_path), "--tip", "flange"]) == 0
    assert path.read_text() == expected
    paths = robot.export("c99", tmp_path / "part", "part", tip="wrist_1", root="shoulder", dtype="float32", split=True)
    assert [p.name for p in paths] == ["part.h", "part.c"]
    assert "void part_matrix(const float q[3], float matrix[16]);" in paths[0].read_text()
    for option in ({"tip": "nobody"}, {"root": "nobody"}, {"tip": "base"}, {"dtype": "int8"}):
        with pytest.raises(InputError):
            robot.export("c99", tmp_path / "new", **option)
    assert not (tmp_path / "new").exists()


@pytest.mark.parametrize("name", ["double", "9lives", "a b", "é", "", "a__b"])
def test_names_that_the_language_cannot_have_are_refused_before_anything_is_written(name: str, tmp_path: Path) -> None:
    arm = Chain.from_dh(ROWS["scara"][1], joints="RRPR")
    with pytest.raises(InputError):
        arm.export("c99", tmp_path / "new", name)
    assert not (tmp_path / "new").exists()


def test_joints_of_a_mechanism_that_cannot_be_driven_are_refused(tmp_path: Path) -> None:
    mechanism = load_mechanism(EXAMPLES / "four_bar.toml").model.mechanism
    for driven in ([], ["nobody"]):
        with pytest.raises(InputError):
            mechanism.export("c99", tmp_path, driven)
    assert not list(tmp_path.iterdir())
