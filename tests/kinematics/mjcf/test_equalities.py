"""Equalities, sites, joints and names as MuJoCo reads them; see test_beside_mujoco.py for whole models."""

import numpy as np
import pytest

import bladesmith as bs
from bladesmith.errors import InputError
from bladesmith.kinematics import load_mjcf, load_urdf, save_mjcf


def two(joint: str = "", more: str = "", before: str = "") -> str:
    return (
        f'<mujoco>{before}<worldbody><body name="a"><joint name="j" {joint}/><geom size="0.1"/><body name="b">'
        f'<joint name="k"/><geom size="0.1"/></body></body></worldbody>{more}</mujoco>'
    )


def equal(text: str) -> str:
    return f"<equality>{text}</equality>"


@pytest.mark.parametrize("element", ['<joint joint1="k" joint2="j"/>', '<connect body1="b" anchor="0 0 0"/>'])
@pytest.mark.parametrize("own", ["", 'class="off"'])
def test_equalities_that_defaults_switch_off(load, element, own):
    off = '<equality active="false"/><joint active="true"/>'
    before = f'<default>{off if not own else f"""<default class="off">{off}</default>"""}</default>'
    robot = load(two(more=equal(element.replace("/>", f" {own}/>")), before=before))
    assert robot.joint_names == ("j", "k") and not robot.loops


def test_sites_between_two_points(load):
    robot = load("""<mujoco><worldbody>
    <body name="a"><joint name="j" axis="0 1 0"/><geom size="0.1"/>
      <site name="s" type="capsule" size="0.01" fromto="0 0 0 2 0 0"/></body>
    <body name="c" pos="1 0 -1"><joint name="l" axis="0 1 0"/><geom size="0.1"/><site name="u" pos="0 0 1"/></body>
    </worldbody><equality><connect site1="s" site2="u"/></equality></mujoco>""")
    frame = robot.loops[0].frame_a
    assert frame[:3, 3].tolist() == [1, 0, 0] and np.allclose(frame[:3, 2], [-1, 0, 0])
    assert robot.mechanism().mobility() >= 0


def test_coefficients_that_are_left_out(load):
    robot = load(two(more=equal('<joint joint1="k" joint2="j" polycoef="0.2"/>')))
    assert robot.followers["k"].multiplier == 1 and robot.followers["k"].offset == 0.2
    with pytest.raises(InputError, match="more than five numbers"):
        load(two(more=equal('<joint joint1="k" joint2="j" polycoef="0 1 2 3 4 5"/>')))


def test_what_follows_a_joint_that_is_held_is_held(load):
    """In any order, and by any polynomial."""
    held, follows = '<joint joint1="j" polycoef="0.3"/>', '<joint joint1="k" joint2="j" polycoef="0 2 1"/>'
    for text in (held + follows, follows + held):
        robot = load(two(more=equal(text)))
        assert robot.joint_names == ()
        turn = bs.cga3d.matrix(robot.poses()["b"])[:2, :2]
        angle = 0.3 + 2 * 0.3 + 0.3**2
        assert np.allclose(turn, [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


def test_a_weld_that_holds_no_rotation_is_a_point(load):
    robot = load(two('type="ball"', equal('<weld body1="a" torquescale="0" anchor="0 0 0"/>')))
    assert [loop.type for loop in robot.loops] == ["ball"]


def test_frames_that_free_joints_would_move(load):
    text = two().replace('<joint name="j" />', '<joint name="j" type="free"/>')
    assert load(text).links
    with pytest.raises(InputError, match="alignfree"):
        load(text.replace("<mujoco>", '<mujoco><compiler alignfree="true"/>'))


def test_meshes_without_mass_leave_inertias_alone(load):
    mesh = '<geom type="mesh" mesh="m" mass="0"/><geom type="mesh" mesh="m" density="0"/>'
    robot = load(two().replace('<geom size="0.1"/>', f'<geom size="0.1"/>{mesh}', 1))
    assert robot.lumps["a"].inertia.mass == pytest.approx(4 / 3 * np.pi)
    with pytest.warns(UserWarning, match="not computed: 'a'"):
        load(two().replace('<geom size="0.1"/>', '<geom size="0.1"/><geom type="hfield" hfield="h"/>', 1))


def test_bounds_of_masses_are_of_bodies_without_geoms_too(load):
    text = two(before='<compiler boundmass="0.5" boundinertia="0.1"/>').replace('<geom size="0.1"/>', "", 1)
    assert load(text).lumps["a"].inertia.mass == 0.5


def test_inertias_of_rotors_are_told(load):
    with pytest.warns(UserWarning, match="armature.*'j'"):
        load(two('armature="0.5"'))


def test_long_axes_and_quaternions(load):
    """No square of a number overflows."""
    robot = load(two('axis="1e200 1e200 0"').replace('<body name="b">', '<body name="b" quat="1e200 0 0 1e200">'))
    same = load(two('axis="1 1 0"').replace('<body name="b">', '<body name="b" quat="1 0 0 1">'))
    ours, theirs = (bs.cga3d.matrix(each.poses([0.3, 0.2])["b"]) for each in (robot, same))
    assert np.allclose(ours, theirs, atol=1e-15)


def test_names_that_are_made_up_are_free_ones(load):
    robot = load("""<mujoco><worldbody><body name="arm"><geom size="0.1"/>
    <body><joint name="arm_weld"/><joint name="j"/><geom size="0.1"/>
    <body name="body_2"><joint/><geom size="0.1"/></body>
    <body name="body_2_/arm_weld"><geom size="0.1"/></body></body></body></worldbody></mujoco>""")
    assert {"arm_weld", "arm_weld_"} <= set(robot.joints) and len(robot.joints) == 5


def test_written_files_are_such_that_mujoco_reads(load, tmp_path):
    mujoco = pytest.importorskip("mujoco")
    path = tmp_path / "made.urdf"
    path.write_text(
        '<robot name="r"><link name="a"/><link name="b"><inertial><mass value="1"/><inertia ixx="1" iyy="1" '
        'izz="2.0005"/></inertial></link><joint name="j" type="continuous"><parent link="a"/><child link="b"/></joint>'
        "</robot>"
    )
    robot = load_urdf(path)
    with pytest.warns(UserWarning, match="the nearest ones"):
        save_mjcf(robot, tmp_path / "made.xml")
    assert mujoco.MjModel.from_xml_path(str(tmp_path / "made.xml")).nq == 1
    with pytest.warns(UserWarning, match="MuJoCo refuses .*'?b"):
        save_mjcf(load_urdf(path, impossible="keep"), tmp_path / "kept.xml")


@pytest.mark.parametrize("ignore", [5, None, "x", [1]])
def test_ignored_tags_are_a_list(load, tmp_path, ignore):
    path = tmp_path / "a.urdf"
    path.write_text('<robot name="r"><link name="a"/></robot>')
    for read in (lambda: load(two(), ignore=ignore), lambda: load_urdf(path, ignore=ignore)):
        with pytest.raises(InputError, match="ignore is .*list of tags"):
            read()


def test_paths_may_be_bytes(tmp_path):
    path = tmp_path / "a.xml"
    path.write_text(two())
    assert load_mjcf(str(path).encode()).joint_names == ("j", "k")
