"""Robots of MJCF files beside MuJoCo: poses, masses, inertias; and what MuJoCo reads of robots that were written."""

import warnings
from pathlib import Path

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import kinematics
from bladesmith.kinematics.robots.frames import rotation_of_quaternion

from ...support.mechanisms.robots import each_robot, real_robots
from .models import ARM, LOOP

pytestmark = pytest.mark.peers
ALGEBRAS = [bs.cga3d, bs.pga3d]
#: Types of joints in MuJoCo that take quaternions.
FREE, BALL = 0, 1
ROBOTS = real_robots()


def motor_of(algebra, position, quaternion):
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = rotation_of_quaternion(quaternion), position
    return matrix, algebra.motor_from_matrix(matrix)


def beside(mujoco, model, found, seed=0):
    """Largest differences of poses and of inertias, at random coordinates."""
    algebra, rng, data = found.algebra, np.random.default_rng(seed), mujoco.MjData(model)
    bodies = [model.body(i).name or f"body_{i}" for i in range(model.nbody)]
    mine, q = {}, {}
    for j in range(model.njnt):
        body = model.jnt_bodyid[j]
        k, count = j - model.body_jntadr[body], model.body_jntnum[body]
        mine[j] = model.joint(j).name or f"{bodies[body]}_joint" + (f"_{k + 1}" if count > 1 else "")
        at, joint = model.jnt_qposadr[j], found.joints[mine[j]]
        if model.jnt_type[j] == FREE:
            x = rng.normal(size=7)
            data.qpos[at : at + 7] = x
            pose, _ = motor_of(algebra, x[:3], x[3:])
            q[joint.name] = algebra.motor_from_matrix(np.linalg.inv(joint.origin) @ pose)
        elif model.jnt_type[j] == BALL:
            x = rng.normal(size=4)
            data.qpos[at : at + 4] = x
            q[joint.name] = motor_of(algebra, np.zeros(3), x)[1]
        elif joint.name in found.joint_names:
            data.qpos[at] = q[joint.name] = rng.uniform(-1, 1)
    for j, name in mine.items():
        if name in found.followers:
            follows = found.followers[name]
            data.qpos[model.jnt_qposadr[j]] = follows.multiplier * q[follows.joint] + follows.offset
    mujoco.mj_normalizeQuat(model, data.qpos)
    mujoco.mj_kinematics(model, data)
    poses, off, heavy = found.poses(q), 0.0, 0.0
    for i, name in enumerate(bodies):
        frame = np.eye(4)
        frame[:3, :3], frame[:3, 3] = data.xmat[i].reshape(3, 3), data.xpos[i]
        off = max(off, float(np.abs(algebra.matrix(poses[name]) - frame).max()))
        if i and model.body_mass[i]:
            inertia, turn = found.inertias[name], rotation_of_quaternion(model.body_iquat[i])
            tensor = turn @ np.diag(model.body_inertia[i]) @ turn.T
            assert inertia.mass == pytest.approx(model.body_mass[i], rel=1e-13)
            assert np.abs(inertia.center - model.body_ipos[i]).max() < 1e-13
            heavy = max(heavy, float(np.abs(inertia.tensor_along_link - tensor).max() / np.abs(tensor).max()))
    return off, heavy


@pytest.mark.parametrize("algebra", ALGEBRAS, ids=lambda a: a.name)
@pytest.mark.parametrize("text", [ARM, ARM.replace('eulerseq="zYx"', 'eulerseq="XYZ" angle="radian"')])
def test_bodies_and_inertias(tmp_path, text, algebra):
    mujoco = pytest.importorskip("mujoco")
    (tmp_path / "model.xml").write_text(text)
    found = kinematics.load_mjcf(tmp_path / "model.xml", algebra)
    model = mujoco.MjModel.from_xml_string(text)
    for seed in range(3):
        off, heavy = beside(mujoco, model, found, seed)
        assert off < 1e-12 and heavy < 1e-12
    limits = dict(zip(found.joint_names, found.limits, strict=True))
    for name in ("turn", "lift", "roll", "elbow"):
        own = model.joint(name)
        expected = own.range if own.limited else [-np.inf, np.inf]
        assert np.allclose(limits[name], expected, rtol=1e-15)


def test_the_model_of_mujoco_itself():
    mujoco = pytest.importorskip("mujoco")
    path = Path(mujoco.__file__).parent / "testdata" / "model.xml"
    model = mujoco.MjModel.from_xml_path(str(path))
    with pytest.warns(UserWarning, match="meshes, height fields and shells is not computed: 'body_9' are without"):
        found = kinematics.load_mjcf(path)
    model.body_mass[9] = 0  # that mesh
    assert max(beside(mujoco, model, found)) < 1e-12


def test_followers_and_loops(tmp_path):
    mujoco = pytest.importorskip("mujoco")
    (tmp_path / "model.xml").write_text(LOOP)
    found = kinematics.load_mjcf(tmp_path / "model.xml")
    model = mujoco.MjModel.from_xml_string(LOOP)
    off, heavy = beside(mujoco, model, found)
    assert "held" not in found.joint_names and heavy < 1e-13
    # the relation of MuJoCo: y - y0 = a0 + a1 (x - x0)
    assert found.followers["finger"].multiplier == -3 and found.followers["finger"].offset == 0.1 + 0.2 - 3 * -0.5
    data = mujoco.MjData(model)
    data.qpos[:] = [0.5, 0, 0, 0.3, 0.4]
    mujoco.mj_kinematics(model, data)
    poses = found.poses({"crank": 0.5})
    for name in ("crank", "coupler", "badge", "rocker", "finger", "held"):
        frame = np.eye(4)
        body = data.body(name)
        frame[:3, :3], frame[:3, 3] = body.xmat.reshape(3, 3), body.xpos
        assert np.abs(bs.cga3d.matrix(poses[name]) - frame).max() < 1e-13
    mujoco.mj_forward(model, data)  # nothing is violated of what joins and couples there
    assert data.ne == 5 and np.abs(data.efc_pos[: data.ne]).max() < 1e-12
    mechanism = found.mechanism({"crank": 0.5})
    assert mechanism.mobility() == 1 and mechanism.residual() < 1e-12  # the four-bar; the finger follows it
    assert len(mechanism.self_stresses()) == 1  # across the plane of the linkage
    with pytest.raises(bs.errors.ConstraintError, match="joint: the geometry of its two bodies"):
        found.mechanism({"crank": 0.9}).mobility()
    system = found.system({"crank": 0.5})
    assert len(system.joints) == 5 and len(system.bodies) == 4


@pytest.mark.slow
@pytest.mark.parametrize("algebra", ALGEBRAS, ids=lambda a: a.name)
@pytest.mark.parametrize("name", ["arm", "loop"])
def test_models_that_are_written(tmp_path, name, algebra):
    mujoco = pytest.importorskip("mujoco")
    (tmp_path / "model.xml").write_text(ARM.replace("ref", "user") if name == "arm" else LOOP)
    found = kinematics.load_mjcf(tmp_path / "model.xml", algebra)
    kinematics.save_mjcf(found, tmp_path / "again.xml")
    model = mujoco.MjModel.from_xml_string((tmp_path / "again.xml").read_text())
    again = kinematics.load_mjcf(tmp_path / "again.xml", algebra)
    assert set(again.joint_names) == set(found.joint_names) and set(again.links) == set(found.links)
    assert again.followers == found.followers and len(again.loops) == len(found.loops)
    assert beside(mujoco, model, again)[0] < 1e-12
    q = dict.fromkeys(found.joint_names, 0.4)
    ours, theirs = found.poses(q), again.poses(q)
    for link in found.links:
        assert np.abs(algebra.matrix(ours[link]) - algebra.matrix(theirs[link])).max() < 1e-13
    for link, lump in found.lumps.items():
        if link != "world" and lump.inertia is not None and lump.inertia.mass:
            other = again.lumps[link].inertia
            assert other.mass == pytest.approx(lump.inertia.mass, rel=1e-13)
            assert np.abs(other.tensor_along_link - lump.inertia.tensor_along_link).max() < 1e-12


@pytest.mark.slow
@each_robot(("panda", "ur", "solo", "tiago_pro"))
def test_real_robots_that_are_written(tmp_path, name):
    mujoco = pytest.importorskip("mujoco")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            found = kinematics.load_urdf(ROBOTS[name])
        except bs.errors.InputError:
            return
        kinematics.save_mjcf(found, tmp_path / "robot.xml")
        model = mujoco.MjModel.from_xml_string((tmp_path / "robot.xml").read_text())
        again = kinematics.load_mjcf(tmp_path / "robot.xml")
    assert beside(mujoco, model, again)[0] < 1e-12
    q = dict(zip(found.joint_names, np.random.default_rng(1).uniform(-1, 1, len(found.joint_names)), strict=True))
    ours, theirs = found.poses(q), again.poses(q)
    for link in found.links:
        if link in again.links:
            assert np.abs(bs.cga3d.matrix(ours[link]) - bs.cga3d.matrix(theirs[link])).max() < 1e-13


ASSETS = (
    '<asset><mesh name="q" vertex="0 0 0 1 0 0 0 1 0 0 0 1"/>'
    '<hfield name="h" nrow="2" ncol="2" size="1 1 1 1" elevation="0 1 0 1"/></asset>'
)
BALL = '<joint/><geom type="sphere" size="1" mass="2"/>'


@pytest.mark.parametrize(
    "geom",
    [
        '<geom type="mesh" mesh="q" mass="0"/>', '<geom type="mesh" mesh="q" density="0"/>', '<geom class="visual"/>',
        '<geom type="hfield" hfield="h" mass="0"/>', '<geom size="1" shellinertia="true" mass="0"/>',
    ],
)  # fmt: skip
def test_geoms_without_mass_leave_the_others(tmp_path, geom):
    mujoco = pytest.importorskip("mujoco")
    default = '<default><default class="visual"><geom type="mesh" mesh="q" density="0"/></default></default>'
    text = f'<mujoco>{default}{ASSETS}<worldbody><body name="a">{BALL}{geom}</body></worldbody></mujoco>'
    (tmp_path / "model.xml").write_text(text)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = kinematics.load_mjcf(tmp_path / "model.xml")
    assert found.inertias["a"].mass == 2
    assert max(beside(mujoco, mujoco.MjModel.from_xml_string(text), found)) < 1e-13


def test_height_fields_have_a_mass_that_is_not_known(tmp_path):
    field = '<geom type="hfield" hfield="h"/>'
    text = f'<mujoco>{ASSETS}<worldbody><body name="a">{BALL}{field}</body></worldbody></mujoco>'
    (tmp_path / "model.xml").write_text(text)
    with pytest.warns(UserWarning, match="height fields and shells is not computed: 'a' are without"):
        assert not kinematics.load_mjcf(tmp_path / "model.xml").inertias


@pytest.mark.parametrize("bounds", ['boundmass="0.5" boundinertia="0.1"', 'boundmass="0.5"', 'boundinertia="0.1"'])
def test_bounds_are_of_all_bodies(tmp_path, bounds):
    mujoco = pytest.importorskip("mujoco")
    text = (
        f'<mujoco><compiler {bounds}/><worldbody><body name="s"/><body name="a">{BALL}<body name="w"/></body>'
        "</worldbody></mujoco>"
    )
    (tmp_path / "model.xml").write_text(text)
    found, model = kinematics.load_mjcf(tmp_path / "model.xml"), mujoco.MjModel.from_xml_string(text)
    for name in ("s", "a", "w"):
        own = found.inertias[name]
        assert own.mass == model.body(name).mass[0] and np.allclose(own.tensor, np.diag(model.body(name).inertia))
    assert found.mass_matrix([0.0])[0, 0] == pytest.approx(model.body_inertia[2:, 2].sum(), rel=1e-13)
