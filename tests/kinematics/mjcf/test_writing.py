"""Robots written as MJCF that MuJoCo refused: inertias that break the triangle inequality, rotations behind a ball."""

import warnings

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import kinematics

from ..robots.texts import joint, link, robot

pytestmark = pytest.mark.peers


@pytest.fixture
def written(tmp_path, monkeypatch):
    """What MuJoCo compiles of a robot that is written; it writes a log where it stands."""
    monkeypatch.chdir(tmp_path)
    mujoco = pytest.importorskip("mujoco")

    def compiled(found):
        kinematics.save_mjcf(found, tmp_path / "out.xml")
        return mujoco.MjModel.from_xml_path(str(tmp_path / "out.xml"))

    return compiled


def one_body(tmp_path, moments, **options):
    (tmp_path / "robot.urdf").write_text(robot(link("a") + link("b", 1.0, moments) + joint()))
    return kinematics.load_urdf(tmp_path / "robot.urdf", **options)


@pytest.mark.parametrize("choice", ["error", "nearest"])
def test_moments_beyond_the_sum_of_the_others(tmp_path, written, choice):
    found = one_body(tmp_path, (1.0, 1.0, 2.001), impossible=choice)
    with pytest.warns(UserWarning, match="the nearest ones are taken: <link name='b'>"):
        moments = np.sort(written(found).body("b").inertia)
    assert moments[2] <= moments[:2].sum() * (1 + 1e-15) and np.abs(moments - [1, 1, 2]).max() < 1e-3


@pytest.mark.parametrize("excess", [1e-7, 1e-12, 1e-15])
@pytest.mark.parametrize("choice", ["error", "keep"])
def test_moments_that_are_rounded(tmp_path, written, choice, excess):
    found = one_body(tmp_path, (0.1, 0.2, 0.3 * (1 + excess)), impossible=choice)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert np.abs(np.sort(written(found).body("b").inertia) - [0.1, 0.2, 0.3]).max() < 1e-7


def test_moments_that_are_kept(tmp_path, written):
    found = one_body(tmp_path, (1.0, 1.0, 2.001), impossible="keep")
    words = "MuJoCo will refuse the file: .* in b; impossible='nearest'"
    with pytest.raises(ValueError, match="A . B >= C"), pytest.warns(UserWarning, match=words) as caught:
        written(found)
    assert caught[0].filename == __file__


def chain(tmp_path, kinds):
    """Joints one behind the other, with nothing between them."""
    joints = "".join(
        f'<body name="b{i}" pos="0.1 0.2 0.3"><joint name="j{i}" type="{kind}" axis="1 {i} 2"/>'
        for i, kind in enumerate(kinds)
    )
    geom = '<geom size="0.1"/>' + "</body>" * len(kinds)
    (tmp_path / "model.xml").write_text(f"<mujoco><worldbody>{joints}{geom}</worldbody></mujoco>")
    return kinematics.load_mjcf(tmp_path / "model.xml")


@pytest.mark.parametrize(
    ("kinds", "bodies"),
    [
        ("ball hinge", 2), ("ball slide", 1), ("ball slide hinge", 2), ("hinge ball", 1), ("ball ball", 2),
        ("ball hinge hinge", 2), ("slide slide slide hinge hinge hinge", 1), ("hinge slide slide slide ball", 2),
        ("hinge hinge slide hinge hinge hinge hinge", 2),
    ],
)  # fmt: skip
def test_crossings_that_mujoco_takes(tmp_path, written, kinds, bodies):
    found = chain(tmp_path, kinds.split())
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # a body of a nanogram
        model = written(found)
    assert model.nbody == 1 + bodies and model.njnt == len(kinds.split())
    again = kinematics.load_mjcf(tmp_path / "out.xml")
    turn = bs.cga3d.motor_from_matrix(
        [[0.36, 0.48, -0.8, 0], [-0.8, 0.6, 0, 0], [0.48, 0.64, 0.6, 0], [0, 0, 0, 1]]
    )
    q = {j.name: turn if j.type == "ball" else 0.3 for j in found.joints.values()}
    tip = f"b{len(kinds.split()) - 1}"
    assert np.abs(bs.cga3d.matrix(found.poses(q)[tip]) - bs.cga3d.matrix(again.poses(q)[tip])).max() < 1e-13
