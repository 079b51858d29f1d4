"""The scripts of examples/kinematics run, say what is right and draw; the pictures' geometry by numbers."""

import importlib.util
import sys

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import kinematics
from bladesmith.errors import InputError
from bladesmith.kinematics.plotting import picture
from bladesmith.kinematics.plotting.glyphs import Mark, mechanism_sketch
from bladesmith.plot import drawing

from ..support.checkout import CHECKOUT

EXAMPLES = CHECKOUT / "examples" / "kinematics"
SCRIPTS = {
    "delta": (["100000 reached", "[1.4 0.  1. ] UNREACHABLE ['OK', 'UNREACHABLE', 'UNREACHABLE']"],
              ["delta_curves.png", "delta_poses.png"]),
    "delta_dynamics": (["falling: the platform from", "held by [-12.655 -10.216 -11.485] N m"], ["delta_falling.png"]),
    "four_bar": (["mobility 1, rank 17 of 20 constraints; 3", "0.363636 times as fast as the crank; in PGA 0.363636"],
                 ["four_bar_poses.png"]),
    "stewart": (["of mobility 6", "condition number here 6.296"], ["stewart_slices.png"]),
    "arm": (["arm stretched out: rank 5", "random poses: 1000 found"], ["arm_line.csv", "arm_line.png"]),
    "scara": (["the gripper has 4 freedoms", "at z = 0.2 it reaches 56% of the box"],
              ["scara_slices.png", "scara_way.csv", "scara_way.png"]),
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("name", SCRIPTS)
def test_scripts_run(name, tmp_path, monkeypatch, capsys):
    says, files = SCRIPTS[name]
    spec = importlib.util.spec_from_file_location(f"kinematics_{name}", EXAMPLES / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    monkeypatch.setattr(sys, "argv", [f"{name}.py", "--out", str(tmp_path / "out")])
    spec.loader.exec_module(module)
    module.main()
    out = capsys.readouterr().out
    for text in says:
        assert text in out, out
    assert sorted(p.name for p in (tmp_path / "out").iterdir()) == files
    for path in (tmp_path / "out").glob("*.png"):
        assert path.read_bytes().startswith(b"\x89PNG") and path.stat().st_size > 5000


def test_every_file_has_its_figure():
    source = (EXAMPLES / "figures.py").read_text()
    for path in EXAMPLES.glob("*.toml"):
        assert f'"{path.stem}"' in source


# -- what is drawn ---------------------------------------------------------------------------------------------


def tripod(algebra):
    m = kinematics.Mechanism(["base", "arm", "cart"], "base")
    place = (1.0, 2.0, 3.0)
    if algebra is bs.pga3d:
        m.add(kinematics.Revolute("base", "arm", algebra.line(place, (0, 0, 1)), algebra.point(place)), "turn")
    else:
        m.add(kinematics.Revolute("base", "arm", algebra.circle(place, (0, 0, 1), 0.1)), "turn")
    m.add(kinematics.Cylindrical("arm", "cart", algebra.line((4, 2, 9), (0, 0, -1))), "slide")
    return m


@pytest.mark.parametrize("algebra", [bs.cga3d, bs.pga3d], ids=["cga", "pga"])
def test_joints_without_a_place_are_drawn_beside_the_others(algebra):
    pose = mechanism_sketch(tripod(algebra), "cart", (4.0, 3.0, 3.0))
    turn, slide = pose.marks
    assert np.allclose(turn.position, (1, 2, 3)) and np.allclose(turn.axes, [(0, 0, 1)])
    assert (
        np.allclose(slide.position, (4, 2, 3)) and np.allclose(slide.axes, [(0, 0, -1)]) and slide.kind == "cylindrical"
    )
    assert np.allclose(pose.bodies["arm"], [(1, 2, 3), (4, 2, 3)])
    assert np.allclose(pose.bodies["cart"], [(4, 3, 3), (4, 2, 3)]) and pose.span == 3.0
    moved = tripod(algebra).at({"arm": algebra.rotor((0, 0, 1), 0.0), "cart": algebra.translator((0, 0, 2.0))})
    assert np.allclose(mechanism_sketch(moved).marks[0].position, (1, 2, 3))


def test_bodies_are_sticks_or_the_hulls_of_their_joints():
    corners, plate = picture.outline(np.array([(0, 0, 1), (2, 0, 1), (1, 0.2, 1), (2, 2, 1), (0, 2, 1), (2.0, 0, 1)]))
    assert plate and sorted(map(tuple, corners)) == [(0, 0, 1), (0, 2, 1), (2, 0, 1), (2, 2, 1)]
    line, plate = picture.outline(np.array([(0.0, 0, 0), (2, 2, 2), (1, 1, 1)]))
    assert not plate and np.abs(np.diff(line, axis=0)).max() == 1.0  # in order along it
    assert picture.outline(np.zeros((0, 3)))[0].shape == (0, 3) and len(picture.outline(np.ones((4, 3)))[0]) == 1


@pytest.mark.parametrize("kind", ["revolute", "cylindrical", "prismatic", "planar", "universal"])
def test_marks_are_about_their_place_and_axis(kind):
    way = np.array([2.0, -1, 2]) / 3
    axes = [way, np.cross(way, (1.0, 0, 0))] if kind == "universal" else [way]
    mark = Mark("j", kind, np.array([1.0, 2, 3]), np.array(axes))
    lines = picture.mark_lines(mark, 10.0)
    points = np.concatenate(lines)
    assert np.isfinite(points).all() and 0.1 < np.linalg.norm(points - mark.position, axis=1).max() < 1.0
    if kind in ("revolute", "cylindrical"):
        ring = lines[0] - mark.position
        assert np.abs(ring @ way).max() < 1e-12 and np.ptp(np.linalg.norm(ring, axis=1)) < 1e-12
    assert picture.mark_lines(Mark("j", "spherical", mark.position, np.zeros((0, 3))), 10.0) == []


def test_pictures_have_equal_axes_and_a_name_for_each_body(tmp_path):
    ax = picture.picture(tripod(bs.cga3d), tmp_path / "a.png", tool="cart", position=(4.0, 3.0, 3.0), title="A $ b")
    limits = np.array([ax.get_xlim3d(), ax.get_ylim3d(), ax.get_zlim3d()])
    assert np.allclose(np.ptp(limits, axis=1) / np.array(ax._box_aspect), np.ptp(limits[0]) / ax._box_aspect[0])
    assert [handle.get_label() for handle in drawing.picture_of(ax).handles] == ["base", "arm", "cart"]
    assert (tmp_path / "a.png").stat().st_size > 5000
    with pytest.raises(InputError, match="at least one pose"):
        picture.picture([])
    with pytest.raises(InputError, match=r"is a DeltaRobot; .*robot\.mechanism\(q\).*delta\.mechanism\(theta\)"):
        picture.picture(kinematics.DeltaRobot(0.4, 0.15, 0.6, 1.2))
    with pytest.raises(InputError, match="not a format of pictures"):
        picture.picture(tripod(bs.cga3d), "a.xyz")
