"""Equality constraints of MJCF files beside MuJoCo: classes, sites, welds without rotation, joints that are held."""

import numpy as np
import pytest

import bladesmith as bs
from bladesmith.errors import InputError
from bladesmith.kinematics.robots.frames import rotation_of_quaternion

GEOM = '<geom size="0.1"/>'


def body(name, joint, place="", inside=""):
    return f'<body name="{name}" {place}>{joint}{GEOM}{inside}</body>'


def model(bodies, equality, before=""):
    return f"<mujoco>{before}<worldbody>{bodies}</worldbody><equality>{equality}</equality></mujoco>"


def hinge(name, more=""):
    return f'<joint name="{name}" {more}/>'


THREE = "".join(body(f"b{x}", hinge(x, f'ref="{r}"')) for x, r in (("j", 10), ("k", -20), ("l", 5)))


@pytest.mark.peers
@pytest.mark.parametrize("equality", ['<joint joint1="k" joint2="j"{}/>', '<connect body1="bj" anchor="0 0 0"{}/>'])
@pytest.mark.parametrize(
    ("defaults", "which"),
    [
        ('<equality active="false"/>', ""),
        ('<default class="zz"><equality active="false"/></default>', ' class="zz"'),
        ('<equality active="false"/><default class="zz"><equality active="true"/></default>', ' class="zz"'),
        ('<joint range="-1 1"/><equality active="false"/>', ' active="true"'),
    ],
)
def test_defaults_of_all_kinds_are_those_of_equality(load, equality, defaults, which):
    mujoco = pytest.importorskip("mujoco")
    text = model(THREE, equality.format(which), f"<default>{defaults}</default>")
    found, active = load(text), bool(mujoco.MjModel.from_xml_string(text).eq_active0[0])
    assert len(found.followers) + len(found.loops) == int(active)


@pytest.mark.peers
@pytest.mark.parametrize("kind", ["capsule", "cylinder", "box", "ellipsoid"])
def test_sites_between_two_ends(load, kind):
    mujoco = pytest.importorskip("mujoco")
    site = f'<site name="s" type="{kind}" size="0.1" fromto="0 0 0 2 0.5 1"/>'
    text = model(
        body("a", hinge("j"), inside=site) + body("b", hinge("k"), inside='<site name="u"/>'),
        '<weld site1="s" site2="u"/>',
    )
    peer, (loop,) = mujoco.MjModel.from_xml_string(text), load(text).loops
    assert np.abs(loop.frame_a[:3, 3] - peer.site_pos[0]).max() < 1e-15
    assert np.abs(loop.frame_a[:3, :3] - rotation_of_quaternion(peer.site_quat[0])).max() < 1e-14


def test_sites_between_two_ends_close_loops(load):
    axis = 'axis="0 1 0"'
    inner = body("c", hinge("l", axis), 'pos="0 0 -1"', '<site name="u" pos="0 0 1"/>')
    text = model(
        body("a", hinge("j", axis), inside='<site name="s" type="capsule" size="0.1" fromto="0 0 0 2 0 0"/>')
        + body("b", hinge("k", axis), 'pos="1 0 0"', inner),
        '<connect site1="s" site2="u"/>',
    )
    found = load(text)
    assert found.loops[0].frame_a[:3, 3].tolist() == [1, 0, 0]
    assert found.mechanism().residual() < 1e-12
    with pytest.raises(InputError, match="or is of a sphere, in <site name='s'>"):
        load(text.replace('type="capsule"', ""))


@pytest.mark.peers
@pytest.mark.parametrize("polycoef", [None, "", "0.2", "0.2 -3", "0 0", "0.1 2 0"])
def test_coefficients_that_are_missing(load, polycoef):
    mujoco = pytest.importorskip("mujoco")
    given = "" if polycoef is None else f'polycoef="{polycoef}"'
    text = model(THREE, f'<joint joint1="j" joint2="k" {given}/>')
    peer = mujoco.MjModel.from_xml_string(text)
    follows = load(text).followers["j"]
    at_zero, slope = peer.eq_data[0, :2]
    assert follows.multiplier == slope
    assert follows.offset == pytest.approx(peer.qpos0[0] + at_zero - slope * peer.qpos0[1], abs=1e-15)


def test_too_many_coefficients(load):
    with pytest.raises(InputError, match="five numbers at most are read, in <joint>"):
        load(model(THREE, '<joint joint1="j" joint2="k" polycoef="0 1 0 0 0 1"/>'))


@pytest.mark.peers
@pytest.mark.parametrize("turned", [False, True])
def test_followers_of_held_joints_are_held(load, turned):
    """Wherever the joint that is held stands in the file."""
    mujoco = pytest.importorskip("mujoco")
    rows = ['<joint joint1="j" polycoef="0.3"/>', '<joint joint1="k" joint2="j" polycoef="0 2"/>',
            '<joint joint1="l" joint2="k" polycoef="0.1 -1"/>']  # fmt: skip
    text = model(THREE, "".join(rows[::-1] if turned else rows))
    found = load(text)
    assert not found.joint_names and not found.followers
    peer = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(peer)
    data.qpos[:] = peer.qpos0 + [0.3, 2 * 0.3, 0.1 - 2 * 0.3]
    mujoco.mj_forward(peer, data)
    assert data.ne == 3 and np.abs(data.efc_pos[:3]).max() < 1e-15
    poses = found.poses([])
    for name in ("bj", "bk", "bl"):
        turn = bs.cga3d.matrix(poses[name])[:3, :3]
        assert np.abs(turn - data.body(name).xmat.reshape(3, 3)).max() < 1e-15
    assert load(text, mimic="free").joint_names == ("j", "k", "l")
    with pytest.raises(InputError, match="'j' is held already, in <joint>"):
        load(model(THREE, rows[0] + '<joint joint1="j" joint2="k"/>'))


TWISTED = body("a", hinge("j", 'ref="20"'), 'pos="1 2 3" euler="10 20 30"') + body(
    "b", hinge("k", 'ref="40"'), 'pos="3 2 1" euler="30 50 10"'
)
COUPLED = '<joint joint1="j" polycoef="0.2"/><joint joint1="k" polycoef="0.1"/>'


@pytest.mark.peers
@pytest.mark.parametrize("before", ["", COUPLED])
@pytest.mark.parametrize("scale", [1, 0])
@pytest.mark.parametrize(
    "more", ["", 'anchor="1 2 3"', 'relpose="1 0 0 1 0 1 0"', 'anchor="1 2 3" relpose="4 5 6 1 2 3 4"']
)
def test_welds(load, more, scale, before):
    """The point in both bodies, and the rotation unless nothing holds it; whatever joints are held by."""
    mujoco = pytest.importorskip("mujoco")
    text = model(TWISTED, before + f'<weld body1="a" body2="b" {more} torquescale="{scale}"/>')
    data = mujoco.MjModel.from_xml_string(text).eq_data[-1]
    (loop,) = load(text).loops
    assert loop.type == ("fixed" if scale else "ball")
    assert np.abs(loop.frame_b[:3, 3] - data[:3]).max() < 1e-14
    assert np.abs(loop.frame_a[:3, 3] - data[3:6]).max() < 1e-14
    turn = loop.frame_a[:3, :3] @ loop.frame_b[:3, :3].T
    assert np.abs(turn - rotation_of_quaternion(data[6:10])).max() < 1e-14


@pytest.mark.peers
@pytest.mark.parametrize("before", ["", COUPLED, '<joint joint1="j" joint2="k" polycoef="0.3 2"/>'])
def test_points_are_where_the_file_draws_them(load, before):
    mujoco = pytest.importorskip("mujoco")
    text = model(TWISTED, before + '<connect body1="a" body2="b" anchor="1 2 3"/>')
    data = mujoco.MjModel.from_xml_string(text).eq_data[-1]
    (loop,) = load(text).loops
    assert np.abs(np.r_[loop.frame_a[:3, 3], loop.frame_b[:3, 3]] - data[:6]).max() < 1e-14


def test_class_of_torquescale(load):
    text = model(TWISTED, '<weld body1="a" body2="b"/>', '<default><equality torquescale="0"/></default>')
    with pytest.raises(InputError, match="torquescale"):
        load(text.replace('"0"', '"x"'))
    assert load(text).loops[0].type == "ball"
