"""Dynamics of robots from files: beside Pinocchio on those of example-robot-data, welded links, and bad files."""

from __future__ import annotations

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import kinematics
from bladesmith.errors import InputError

from ...support.mechanisms.robots import each_robot, needs_robots, real_robots

ROBOTS = real_robots()
#: Largest difference relative to the largest number of a result.
BAR = 1e-12
BOX = (
    '<inertial><origin xyz="{xyz}"/><mass value="{mass}"/>'
    '<inertia ixx="0.1" iyy="0.2" izz="0.25" ixy="0.01"/></inertial>'
)


def off(found, expected, least=1e-300):
    """The largest difference, relative to the largest number or to one that is rounding's, where all cancels."""
    return np.abs(found - expected).max() / max(np.abs(expected).max(), least)


class Peer:
    """Pinocchio's model of a file, with joints in our order."""

    def __init__(self, path, names):
        import pinocchio as pin

        self.pin, self.model = pin, pin.buildModelFromUrdf(str(path))
        self.data = self.model.createData()
        self.joints = [self.model.joints[self.model.getJointId(name)] for name in names]
        self.order = np.array([joint.idx_v for joint in self.joints])

    def coordinates(self, q):
        x = self.pin.neutral(self.model)
        for joint, value in zip(self.joints, q, strict=True):
            values = [np.cos(value), np.sin(value)] if joint.nq == 2 else [value]
            x[joint.idx_q : joint.idx_q + joint.nq] = values
        return x

    def rates(self, values):
        found = np.zeros(self.model.nv)
        found[self.order] = values
        return found

    def all(self, q, qd, qdd):
        pin, model, data, x, order = self.pin, self.model, self.data, self.coordinates(q), self.order
        forces = pin.rnea(model, data, x, self.rates(qd), self.rates(qdd))[order]
        upper = np.triu(pin.crba(model, data, x))
        mass = (upper + np.triu(upper, 1).T)[np.ix_(order, order)]
        if model.nv == len(order):
            accelerations = pin.aba(model, data, x, self.rates(qd), self.rates(qdd))[order]
        else:  # the other joints are held
            bias = pin.nonLinearEffects(model, data, x, self.rates(qd))[order]
            accelerations = np.linalg.lstsq(mass, qdd - bias, rcond=0)[0]
        return forces, mass, pin.computeGeneralizedGravity(model, data, x)[order].copy(), accelerations


def load(name):
    algebra = (bs.cga3d, bs.pga3d)[len(name) % 2]
    return kinematics.load_urdf(ROBOTS[name], algebra, mimic="free", ignore=["command_effort"], impossible="keep")


def assert_beside(ours, peer, names):
    rng = np.random.default_rng(0)
    q, qd, qdd = rng.uniform(-2, 2, (3, 4, len(names)))
    found = [ours.inverse_dynamics(q, qd, qdd), ours.mass_matrix(q), ours.gravity_torques(q)]
    found.append(ours.forward_dynamics(q, qd, qdd))
    wheel = 9.81e-2 * peer.pin.computeTotalMass(peer.model)  # held by its axis: the torque of the weight at 1 cm
    for i in range(4):
        expected = peer.all(q[i], qd[i], qdd[i])
        for one, other, least in zip(found[:3], expected[:3], (wheel, 1e-300, wheel), strict=True):
            assert off(one[i], other, least) < BAR
        condition = np.linalg.cond(expected[1])
        if condition < 1e12:  # others have joints that move nothing
            is_whole = peer.model.nv == len(names)
            assert off(found[3][i], expected[3]) < BAR + (1e-17 if is_whole else 1e-15) * condition


@pytest.mark.peers
@pytest.mark.slow
@each_robot()
def test_every_robot_beside_pinocchio(name):
    pytest.importorskip("pinocchio")
    try:
        robot = load(name)
    except InputError as error:
        assert name in ("ur/ur3", "anymal_b_simple/anymal", "anymal_b_simple/anymal-kinova"), error
        return
    if robot.joint_names:
        assert_beside(robot, Peer(ROBOTS[name], robot.joint_names), robot.joint_names)


@pytest.mark.peers
@pytest.mark.slow
@each_robot()
def test_every_chain_beside_pinocchio(name):
    """From the root to each link at an end, other joints held at zero."""
    pytest.importorskip("pinocchio")
    try:
        robot = load(name)
    except InputError:
        return
    parents = {joint.parent for joint in robot.joints.values()}
    seen = set()
    for tip in (link for link in robot.links if link not in parents):
        try:
            chain = robot.chain(tip)
        except InputError:  # nothing moves it
            continue
        if chain.names in seen or not chain.links.any():
            continue
        seen.add(chain.names)
        assert_beside(chain, Peer(ROBOTS[name], chain.names), chain.names)


@pytest.mark.peers
@pytest.mark.compiles
@needs_robots
@pytest.mark.parametrize("name", ["ur/ur5_robot", "panda/panda", "talos_data/talos_reduced"])
def test_derivatives_beside_pinocchio(name):
    pin = pytest.importorskip("pinocchio")
    made = load(name)
    peer = Peer(ROBOTS[name], made.joint_names)
    q, qd, qdd = np.random.default_rng(1).uniform(-2, 2, (3, 2, len(made.joint_names)))
    found = [*made.inverse_dynamics_derivatives(q, qd, qdd), *made.forward_dynamics_derivatives(q, qd, qdd)]
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
    bound = made.bound()
    assert np.array_equal(bound.inverse_dynamics(q[0], qd[0], qdd[0]), made.inverse_dynamics(q[0], qd[0], qdd[0]))
    assert np.array_equal(bound.forward_dynamics(q[0], qd[0], qdd[0]), made.forward_dynamics(q[0], qd[0], qdd[0]))
    assert np.array_equal(bound.mass_matrix(q[0]), made.mass_matrix(q[0]))


def robot(tmp_path, links, joints="", **options):
    file = tmp_path / "robot.urdf"
    file.write_text(f'<robot name="r">{links}{joints}</robot>')
    return kinematics.load_urdf(file, **options)


def link(name, inertial=""):
    return f'<link name="{name}">{inertial}</link>'


def joint(name, parent, child, kind="revolute", xyz="0 0 0", axis="0 1 0"):
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/><origin xyz="{xyz}"/>'
        f'<axis xyz="{axis}"/><limit lower="-2" upper="2" effort="1" velocity="1"/></joint>'
    )


def test_welded_links_are_one(tmp_path):
    box = BOX.format(xyz="0.1 0 0", mass=2)
    welded = robot(
        tmp_path,
        link("base", box) + link("arm", box) + link("flange") + link("tool", box),
        joint("turn", "base", "arm") + joint("weld", "arm", "flange", "fixed", "1 0 0")
        + joint("weld 2", "flange", "tool", "fixed", "0 0 1"),
    )  # fmt: skip
    # the boxes' centers are at (0.1, 0, 0) and (1.1, 0, 1)
    moment = 2 * 0.2 + 2 * 0.1**2 + 2 * (1.1**2 + 1)
    assert welded.mass_matrix([0.7]) == pytest.approx(moment, rel=1e-14)
    assert welded.gravity_torques([0.0]) == pytest.approx(-9.81 * 2 * 1.2, rel=1e-14)
    chain = welded.chain("tool")
    assert chain.mass_matrix([0.7]) == pytest.approx(moment, rel=1e-14)


def test_a_chain_may_begin_anywhere(tmp_path):
    """From a hand to the base: the links move that moved least."""
    box = BOX.format(xyz="0.1 0.2 0.3", mass=2)
    made = robot(
        tmp_path,
        link("base", box) + link("upper", box) + link("lower", box) + link("hand", box),
        joint("a", "base", "upper") + joint("b", "upper", "lower", xyz="1 0 0", axis="0 0 1")
        + joint("c", "lower", "hand", xyz="1 0 0.5", axis="1 0 0"),
    )  # fmt: skip
    back = made.chain("base", root="hand")
    q, qd = np.array([0.3, -0.4, 0.6]), np.array([0.5, -0.2, 0.9])
    energy = 0.5 * qd @ back.mass_matrix(q) @ qd
    # the same relative motion, seen from the other end: the energy of the links by their own twists
    found = 0.0
    step = 1e-6
    poses = [made.poses(dict(zip(back.names, q + s * step * qd, strict=True))) for s in (-1, 1)]
    centers, turns = [], []
    for pose in poses:
        hand = np.linalg.inv(made.algebra.matrix(pose["hand"]))
        at = {name: hand @ made.algebra.matrix(pose[name]) @ made.inertias[name].origin for name in made.links}
        centers.append({name: m[:3, 3] for name, m in at.items()})
        turns.append({name: m[:3, :3] for name, m in at.items()})
    for name in ("base", "upper", "lower"):
        v = (centers[1][name] - centers[0][name]) / (2 * step)
        rate = (turns[1][name] - turns[0][name]) / (2 * step)
        spin = turns[0][name].T @ rate
        w = np.array([spin[2, 1], spin[0, 2], spin[1, 0]])
        found += made.inertias[name].mass * v @ v / 2 + w @ made.inertias[name].tensor @ w / 2
    assert energy == pytest.approx(found, rel=1e-5)


def test_files_without_inertia_or_with_a_bad_one(tmp_path):
    plain = robot(tmp_path, link("base") + link("arm"), joint("turn", "base", "arm"))
    assert plain.chain("arm").forward([0.1]).shape == ()  # its kinematics are known
    for model in (plain, plain.chain("arm")):
        with pytest.raises(InputError, match="no link of 'r' that moves has an <inertial>.*kinematics"):
            model.inverse_dynamics([0.0])
    thin = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="3"/></inertial>'
    bad = robot(tmp_path, link("base") + link("arm", thin), joint("turn", "base", "arm"))
    with pytest.raises(InputError, match=r"robot.urdf.*<link name='arm'>.*exceeds the sum.*impossible='keep'"):
        bad.mass_matrix([0.0])
    kept = robot(tmp_path, link("base") + link("arm", thin), joint("turn", "base", "arm"), impossible="keep")
    assert kept.mass_matrix([0.0]) == 1.0
    with pytest.raises(InputError, match="impossible"):
        robot(tmp_path, link("base"), impossible="never")
    floating = robot(
        tmp_path, link("world") + link("base", BOX.format(xyz="0 0 0", mass=1)),
        joint("free", "world", "base", "floating"),
    )  # fmt: skip
    assert np.linalg.matrix_rank(floating.mass_matrix(floating.neutral)) == 6


def test_coordinates_are_in_the_order_of_the_file(tmp_path):
    """Children before parents in the file, and two branches."""
    box = BOX.format(xyz="0.1 0.2 0.3", mass=2)
    made = robot(
        tmp_path,
        link("base", box) + link("a", box) + link("b", box) + link("c", box),
        joint("jc", "a", "c", xyz="0 1 0", axis="1 0 0") + joint("jb", "a", "b", "prismatic", xyz="1 0 0", axis="0 0 1")
        + joint("ja", "base", "a"),
    )  # fmt: skip
    assert made.joint_names == ("jc", "jb", "ja")
    q, qd, qdd = np.random.default_rng(0).uniform(-1, 1, (3, 2, 3))
    mass = made.mass_matrix(q)
    assert (mass[:, 1, 1] == 2.0).all() and (mass[:, 0, 1] == 0).all() and (mass[:, 2, 2] > 3).all()
    forces = made.inverse_dynamics(q, qd, qdd)
    assert np.abs((mass @ qdd[..., None])[..., 0] + made.bias_forces(q, qd) - forces).max() < 1e-12
    assert np.abs(made.forward_dynamics(q, qd, forces) - qdd).max() < 1e-11
    held = made.gravity_torques(q)
    assert held[:, 1] == pytest.approx(2 * 9.81 * np.cos(q[:, 2]), rel=1e-13)
