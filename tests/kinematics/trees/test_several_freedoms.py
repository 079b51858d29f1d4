"""Roots that float, and joints of several freedoms: torques and accelerations beside other software, and bad input."""

from __future__ import annotations

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import Status, kinematics
from bladesmith.errors import InputError, ShapeError
from bladesmith.kinematics.robots.frames import rotation_of_quaternion

from ...support.mechanisms.robots import each_robot, needs_robots, real_robots
from ..mjcf.models import ARM

ROBOTS = real_robots()
BAR = 1e-12
BOX = (
    '<inertial><origin xyz="0.1 0.2 0.3"/><mass value="2"/>'
    '<inertia ixx="0.1" iyy="0.2" izz="0.25" ixy="0.01" ixz="0" iyz="0"/></inertial>'
)
JOINT = (
    '<joint name="{0}" type="{1}"><parent link="{2}"/><child link="{3}"/><origin xyz="0.1 0.2 -0.1" rpy="{4}"/>'
    '<axis xyz="{5}"/><limit lower="-2" upper="2" effort="1" velocity="1"/></joint>'
)


def load(tmp_path, joints, links="abc", **options):
    boxes = "".join(f'<link name="{name}">{BOX if name.islower() else ""}</link>' for name in links)
    (tmp_path / "robot.urdf").write_text(f'<robot name="r">{boxes}{"".join(JOINT.format(*x) for x in joints)}</robot>')
    return kinematics.load_urdf(tmp_path / "robot.urdf", **options)


def off(found, expected, least=1e-300):
    return np.abs(found - expected).max() / max(np.abs(expected).max(), least)


def unit_quaternions(rng, items):
    x = rng.normal(size=(items, 4))
    return x / np.linalg.norm(x, axis=-1, keepdims=True)


def motion(robot, seed=0, items=3):
    """Random coordinates, speeds, accelerations."""
    rng = np.random.default_rng(seed)
    q = rng.uniform(-2, 2, (items, robot.nq))
    for name, part in robot.coordinate_slices.items():
        if robot.joints[name].type in ("ball", "floating"):
            q[:, part.stop - 4 : part.stop] = unit_quaternions(rng, items)
        elif robot.joints[name].type == "planar":
            q[:, part.stop - 1] = np.sin(q[:, part.stop - 2])
            q[:, part.stop - 2] = np.cos(q[:, part.stop - 2])
    return q, *rng.uniform(-2, 2, (2, items, robot.nv))


class Peer:
    """Pinocchio's model of a file with a root that floats, with joints in our order."""

    def __init__(self, path, robot):
        import pinocchio as pin

        self.pin, self.robot, self.model = pin, robot, pin.buildModelFromUrdf(str(path), pin.JointModelFreeFlyer())
        self.data = self.model.createData()
        names = [*robot.coordinate_slices]
        self.joints = [self.model.joints[self.model.getJointId(name)] for name in names]
        self.order = np.concatenate([np.arange(j.idx_v, j.idx_v + j.nv) for j in self.joints])
        assert len(self.order) == robot.nv == self.model.nv

    def coordinates(self, q):
        x = self.pin.neutral(self.model)
        for joint, (name, part) in zip(self.joints, self.robot.coordinate_slices.items(), strict=True):
            one = joint.nq == 2 and self.robot.joints[name].type == "continuous"
            x[joint.idx_q : joint.idx_q + joint.nq] = [np.cos(q[part][0]), np.sin(q[part][0])] if one else q[part]
        return x

    def rates(self, values):
        found = np.zeros(self.model.nv)
        found[self.order] = values
        return found


@pytest.mark.peers
@pytest.mark.slow
@each_robot()
def test_every_floating_robot_beside_pinocchio(name):
    pin = pytest.importorskip("pinocchio")
    algebra = (bs.cga3d, bs.pga3d)[len(name) % 2]
    options = {"mimic": "free", "ignore": ["command_effort"], "impossible": "keep", "base": "floating"}
    try:
        robot = kinematics.load_urdf(ROBOTS[name], algebra, **options)
    except InputError:
        assert name == "ur/ur3"
        return
    peer, (q, qd, qdd) = Peer(ROBOTS[name], robot), motion(robot)
    found = robot.inverse_dynamics(q, qd, qdd), robot.mass_matrix(q), robot.gravity_torques(q)
    back, model, data, order = robot.forward_dynamics(q, qd, qdd), peer.model, peer.data, peer.order
    for i in range(len(q)):
        x, v, a = peer.coordinates(q[i]), peer.rates(qd[i]), peer.rates(qdd[i])
        upper = np.triu(pin.crba(model, data, x))
        mass = (upper + np.triu(upper, 1).T)[np.ix_(order, order)]
        assert off(found[0][i], pin.rnea(model, data, x, v, a)[order]) < BAR
        assert off(found[1][i], mass) < BAR
        assert off(found[2][i], pin.computeGeneralizedGravity(model, data, x)[order]) < BAR
        condition = np.linalg.cond(mass)
        if condition < 1e12:  # others have joints that move nothing
            assert off(back[i], pin.aba(model, data, x, v, a)[order]) < BAR + 1e-17 * condition


@pytest.mark.peers
@pytest.mark.compiles
@needs_robots
def test_derivatives_beside_pinocchio():
    """By what moves the root: derivatives along unit twists of its frame."""
    pin = pytest.importorskip("pinocchio")
    path = ROBOTS["bolt/bolt"]
    robot = kinematics.load_urdf(path, base="floating")
    peer, (q, qd, qdd) = Peer(path, robot), motion(robot, items=2)
    found = [*robot.inverse_dynamics_derivatives(q, qd, qdd), *robot.forward_dynamics_derivatives(q, qd, qdd)]
    grid, model, data = np.ix_(peer.order, peer.order), peer.model, peer.data
    for i in range(2):
        given = peer.coordinates(q[i]), peer.rates(qd[i]), peer.rates(qdd[i])
        pin.computeRNEADerivatives(model, data, *given)
        mass = np.triu(data.M) + np.triu(data.M, 1).T
        expected = [data.dtau_dq.copy(), data.dtau_dv.copy(), mass]
        pin.computeABADerivatives(model, data, *given)
        expected += [data.ddq_dq, data.ddq_dv, np.triu(data.Minv) + np.triu(data.Minv, 1).T]
        for one, other in zip(found, expected, strict=True):
            assert off(one[i], other[grid]) < BAR


@pytest.mark.peers
def test_free_and_ball_joints_beside_mujoco(tmp_path):
    """A ball off its body's origin, joints with references: inertias and torques, of which the free one's differ."""
    mujoco = pytest.importorskip("mujoco")
    (tmp_path / "arm.xml").write_text(ARM)
    robot, model = kinematics.load_mjcf(tmp_path / "arm.xml"), mujoco.MjModel.from_xml_string(ARM)
    data, (q, qd, qdd) = mujoco.MjData(model), motion(robot, items=4)
    mass, forces = robot.mass_matrix(q), robot.inverse_dynamics(q, qd, qdd)
    names = _numbers_of(model, robot)
    for i in range(4):
        to_ours = np.zeros((robot.nv, model.nv))
        drift = np.zeros(model.nv)
        for name, j in names.items():
            joint, part, speed = robot.joints[name], robot.coordinate_slices[name], robot.speed_slices[name]
            at, place = model.jnt_qposadr[j], model.jnt_dofadr[j]
            x, columns = q[i, part], np.eye(speed.stop - speed.start)
            if joint.type == "floating":
                frame = joint.origin.copy()
                turn = frame[:3, :3] @ rotation_of_quaternion(np.roll(x[3:], 1))
                data.qpos[at : at + 3] = frame[:3, :3] @ x[:3] + frame[:3, 3]
                data.qpos[at + 3 : at + 7] = bs.poses.to_quaternion(bs.poses.from_matrix(turn))
                columns[:3, :3] = turn.T  # MuJoCo's velocity is along the world's axes
                v, w = qd[i, speed][:3], qd[i, speed][3:]
                drift[place : place + 3] = turn @ np.cross(w, v)
            elif joint.type == "ball":
                data.qpos[at : at + 4] = np.roll(x, 1)
            else:
                data.qpos[at] = x[0]
            to_ours[speed, place : place + len(columns)] = columns
        data.qvel = to_ours.T @ qd[i]
        mujoco.mj_forward(model, data)
        data.qacc = to_ours.T @ qdd[i] + drift
        full, result = np.zeros((model.nv, model.nv)), np.zeros(model.nv)
        mujoco.mj_fullM(model, data, full) if mujoco.__version__ >= "3.5" else mujoco.mj_fullM(model, full, data.qM)
        mujoco.mj_rne(model, data, 1, result)
        assert off(mass[i], to_ours @ full @ to_ours.T) < BAR
        assert off(forces[i], to_ours @ result) < BAR


def _numbers_of(model, robot):
    """MuJoCo's number of each joint of ours: by name, or in order where it has none."""
    named = {model.joint(j).name: j for j in range(model.njnt) if model.joint(j).name}
    without = [j for j in range(model.njnt) if not model.joint(j).name]
    return {name: named[name] if name in named else without.pop(0) for name in robot.coordinate_slices}


def test_a_single_body_obeys_newton_and_euler(tmp_path):
    robot = load(tmp_path, [], "a", base="floating")
    q, qd, tau = motion(robot)
    m, c, tensor = 2.0, np.array([0.1, 0.2, 0.3]), np.array([[0.1, 0.01, 0], [0.01, 0.2, 0], [0, 0, 0.25]])
    found = robot.forward_dynamics(q, qd, tau)
    for i in range(len(q)):
        turn = rotation_of_quaternion(np.roll(q[i, 3:], 1))
        (v, w), (a, dw) = qd[i].reshape(2, 3), found[i].reshape(2, 3)
        spin = np.cross(w, v) + a + np.cross(dw, c) + np.cross(w, np.cross(w, c))  # acceleration of the center
        force = m * (spin - turn.T @ [0, 0, -9.81])
        moment = tensor @ dw + np.cross(w, tensor @ w) + np.cross(c, force)
        assert np.abs(np.concatenate([force, moment]) - tau[i]).max() < 1e-13 * np.abs(tau).max() * 100


@pytest.mark.parametrize("axis", ["0 0 1", "1 -2 0.5"])
def test_energy_of_planar_joints(tmp_path, axis):
    """By differences of the poses of the links."""
    planar = load(tmp_path, [("hand", "revolute", "b", "c", "0 0 0", "0 1 0"),
                             ("move", "planar", "a", "b", "0.3 0.1 0.2", axis)])
    q, qd, qdd = motion(planar)
    energy = np.einsum("ni,nij,nj->n", qd, planar.mass_matrix(q), qd) / 2
    h = 1e-6
    part, speed = planar.coordinate_slices["move"], planar.speed_slices["move"]
    ends = []
    for sign in (-1, 1):  # the pose a moment before and after: kinetic energies by differences
        moved = q + 0
        moved[:, 0] += sign * h * qd[:, 0]
        angle = np.arctan2(q[:, part][:, 3], q[:, part][:, 2])
        v, w = qd[:, speed][:, :2], qd[:, speed][:, 2]
        cos, sin = np.cos(angle), np.sin(angle)
        moved[:, 1] += sign * h * (cos * v[:, 0] - sin * v[:, 1])
        moved[:, 2] += sign * h * (sin * v[:, 0] + cos * v[:, 1])
        turned = angle + sign * h * w
        moved[:, 3], moved[:, 4] = np.cos(turned), np.sin(turned)
        ends.append({name: planar.algebra.matrix(pose) for name, pose in planar.poses(moved).items()})
    found = np.zeros(len(q))
    for name in "bc":
        frames = [end[name] @ planar.inertias[name].origin for end in ends]
        middle = planar.algebra.matrix(planar.poses(q)[name]) @ planar.inertias[name].origin
        rate = (frames[1] - frames[0]) / (2 * h)
        spin = np.swapaxes(middle[:, :3, :3], -1, -2) @ rate[:, :3, :3]
        w = np.stack([spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]], -1)
        found += planar.inertias[name].mass * (rate[:, :3, 3] ** 2).sum(-1) / 2
        found += np.einsum("ni,ij,nj->n", w, planar.inertias[name].tensor, w) / 2
    assert energy == pytest.approx(found, rel=1e-7)


def test_by_name_and_in_arrays(tmp_path):
    """A motor for the root, a twist along its axes; poses of the same arrays."""
    robot = load(tmp_path, [("hip", "revolute", "a", "b", "0.3 0 0", "0 1 0")], "ab", base="floating")
    assert (robot.root, robot.nq, robot.nv) == ("world", 8, 7)
    assert robot.coordinate_slices == {"root_joint": slice(0, 7), "hip": slice(7, 8)}
    q, qd, qdd = (x[0] for x in motion(robot))
    pose = bs.poses.from_quaternion(q[3:7], q[:3], "xyzw")
    motor = robot.algebra.motor_from_matrix(bs.poses.to_matrix(pose))
    named = {"root_joint": motor, "hip": q[7]}, {"root_joint": qd[:6], "hip": qd[6]}, {"hip": qdd[6]}
    qdd[:6] = 0
    expected = robot.inverse_dynamics(q, qd, qdd)
    assert off(robot.inverse_dynamics(*named), expected) < 1e-14
    assert off(robot.bound().inverse_dynamics(q, qd, qdd), expected) == 0
    assert off(robot.mass_matrix({}), robot.mass_matrix(robot.neutral)) == 0
    assert np.array_equal(robot.gravity_torques(0), robot.gravity_torques(robot.neutral))
    one, other = robot.poses(named[0]), robot.poses(q)
    matrix = robot.algebra.matrix
    assert all(np.abs(matrix(one[name]) - matrix(other[name])).max() < 1e-14 for name in robot.links)
    with pytest.raises(ShapeError, match=r"qd.* ends in 7|qd.*7"):
        robot.bias_forces(q, qd[:6])
    with pytest.raises(InputError, match="did you mean 'hip'"):
        robot.bias_forces(q, {"hib": 1.0})
    with pytest.raises(InputError, match=r"quaternion .* of 'root_joint' is not unit: its length is 2.*qx, qy, qz, qw"):
        robot.mass_matrix([0, 0, 0, 0, 0, 0, 2, 0.3])
    codes = robot.inverse_dynamics(np.stack([q, np.full(8, np.nan)]), qd, qdd, status=True)[1]
    assert codes.tolist() == [Status.OK, Status.INVALID]
    with pytest.raises(InputError, match="base"):
        load(tmp_path, [], "a", base="flying")


def test_a_real_part_that_is_first_is_said(tmp_path):
    robot = load(tmp_path, [], "a", base="floating")
    with pytest.warns(UserWarning, match="half turns about x: their order is x, y, z, w"):
        robot.mass_matrix([0, 0, 0, 1, 0, 0, 0])
