"""Joints that follow others (`<mimic>`): against the same robot with free joints, moved as the relation says."""

import os
import pickle
import time

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import dynamics, kinematics
from bladesmith.dynamics import screw_coordinates
from bladesmith.errors import InputError
from bladesmith.status import Status

from .texts import joint, link, robot

ALGEBRAS = [bs.cga3d, bs.pga3d]
ORIGIN = '<origin xyz="0.3 0.1 0.2" rpy="0.3 -0.2 0.5"/>'
GRIPPER = robot(
    link("a", 1.0) + link("b", 1.0) + link("c", 1.0) + link("d", 1.0)
    + joint("j", "revolute", "a", "b", ORIGIN + '<axis xyz="0 1 1"/><limit lower="-1" upper="2"/>')
    + joint("k", "prismatic", "b", "c", ORIGIN + '<axis xyz="1 0 0"/><mimic joint="j" multiplier="-2" offset="0.5"/>')
    + joint("l", "continuous", "b", "d", ORIGIN + '<axis xyz="1 0 2"/><mimic joint="k" multiplier="3" offset="-1"/>')
)  # fmt: skip


def relations(x):
    """Coordinates by hand: k = 0.5 - 2 j, l = 3 k - 1."""
    return {"j": x, "k": 0.5 - 2 * x, "l": 3 * (0.5 - 2 * x) - 1}


@pytest.mark.parametrize("algebra", ALGEBRAS, ids=lambda a: a.name)
def test_poses_chains_and_velocities(load, algebra):
    found, free = load(GRIPPER, algebra), load(GRIPPER, algebra, mimic="free")
    assert found.joint_names == ("j",) and free.joint_names == ("j", "k", "l")
    assert found.followers["l"].joint == "j"
    assert (found.followers["l"].multiplier, found.followers["l"].offset) == (-6.0, 0.5)
    for x in (0.0, 0.7):
        poses, truth = found.poses([x]), free.poses(relations(x))
        for name in found.links:
            assert np.abs(algebra.matrix(poses[name]) - algebra.matrix(truth[name])).max() < 1e-14
    chain = found.chain("d", "b")
    assert chain.names == ("j",)
    expected = free.chain("d", "b").forward([relations(0.7)["l"]])
    assert np.abs(algebra.matrix(chain.forward([0.7])) - algebra.matrix(expected)).max() < 1e-14
    mechanism = found.mechanism([0.7])
    assert mechanism.mobility() == 1 and free.mechanism().mobility() == 3
    assert mechanism.constraint_matrix().shape == (3 * 5 + 2, 18) and mechanism.rank() == 17
    twists = mechanism.solve({"j": 1.3})
    truth = free.mechanism(relations(0.7)).solve({"j": 1.3, "k": -2.6, "l": -7.8})
    for name in found.links:
        assert np.abs(screw_coordinates(twists[name]) - screw_coordinates(truth[name])).max() < 1e-12
    (motion,) = mechanism.free_motions()
    assert set(motion.bodies) == set("bcd")
    # a finite difference of poses
    h = 1e-6
    sides = [algebra.matrix(found.poses([0.7 + s * h])["d"]) for s in (-1, 1)]
    rate = (sides[1] - sides[0]) / (2 * h) @ np.linalg.inv(algebra.matrix(found.poses([0.7])["d"]))
    column = np.array([rate[2, 1], rate[0, 2], rate[1, 0], *rate[:3, 3]])
    assert np.abs(column - screw_coordinates(mechanism.solve({"j": 1.0})["d"])).max() < 1e-8


def test_redundant_couplings_bear_against_each_other(load):
    mechanism = load(GRIPPER).mechanism()
    mechanism.couple({"l": 1.0, "k": -3.0})
    assert mechanism.mobility() == 1 and mechanism.constraint_matrix().shape[0] == 18
    (stress,) = mechanism.self_stresses()
    assert len(stress) >= 2 and set(stress) <= {"k", "l", "j"}
    again = pickle.loads(pickle.dumps(mechanism))
    assert again.couplings == mechanism.couplings and again.mobility() == 1
    assert mechanism.at({}).mobility() == 1


def test_poses_of_mechanisms_follow(load):
    found = load(GRIPPER)
    mechanism = found.mechanism([0.0])
    x = np.linspace(0, 0.5, 4)
    poses = mechanism.solve_pose({"j": x})
    assert (poses.status == 0).all()
    for i, value in enumerate(x):
        truth, home = found.poses([value]), found.poses([0.0])
        moved = (truth["d"] * ~home["d"]).as_kind("motor")
        assert np.abs(bs.cga3d.matrix(poses["d"][i]) - bs.cga3d.matrix(moved)).max() < 1e-9
    many = mechanism.jacobian("j", ["d", "k"], poses=poses)
    for i, value in enumerate(x):
        one = found.mechanism([value]).jacobian("j", ["d", "k"])
        assert np.abs(many[i] - one).max() < 1e-8
    with pytest.raises(InputError, match=r"j and k are coupled, and not driven|k and j are coupled"):
        mechanism.solve_pose({}, {"d": found.poses([0.1])["d"]})


def test_couplings_that_are_wrong(load):
    mechanism = load(GRIPPER).mechanism()
    for wrong, words in (
        ({"m": 1.0}, "names 'm', which is not a joint"),
        ({("j", 1): 1.0}, "names freedom 1 of j, which has 1"),
        ({"j": 0.0}, "at least one coefficient"),
        ({"j": np.nan}, "the coefficient of j"),
        ({"j": 1.0, ("j", 0): 2.0}, "names j twice"),
        (3, "a mapping"),
    ):
        with pytest.raises(InputError, match=words):
            mechanism.couple(wrong)


def test_limits_of_leaders_keep_their_followers_within_theirs(load):
    text = GRIPPER.replace('<mimic joint="j"', '<limit lower="-0.5" upper="1.5"/><mimic joint="j"')
    assert load(text).limits.tolist() == [[-0.5, 0.5]]
    assert load(GRIPPER).limits.tolist() == [[-1.0, 2.0]]


def test_systems_hold_couplings_and_simulations_keep_them(load):
    found = load(GRIPPER)
    system = found.system([0.2])
    assert system.couplings == ({(1, 0): 1.0, (0, 0): 2.0}, {(2, 0): 1.0, (0, 0): 6.0})
    gravity = dynamics.Gravity((3.0, 2.0, -9.81))
    moved = dynamics.Simulation(system, [gravity]).run(0.2, times=[0.2])
    leader, first, second = (moved.coordinates(name) for name in system.joint_names)
    assert np.abs(first - first[0] + 2 * (leader - 0.2)).max() < 1e-13
    assert np.abs(second - second[0] + 6 * (leader - 0.2)).max() < 1e-13 and np.ptp(leader) > 1e-4
    with pytest.raises(InputError, match=r"coupled to another joint.*followers='lock'"):
        dynamics.Simulation(system, coordinates="maximal")
    locked = found.system([0.2], followers="lock")
    assert not locked.couplings and [j.mobility for j in locked.joints] == [1, 0, 0]
    assert [j.mobility for j in found.system([0.2], followers="free").joints] == [1, 1, 1]
    dynamics.Simulation(locked)


@pytest.mark.parametrize("algebra", ALGEBRAS, ids=lambda a: a.name)
def test_torques_are_those_of_free_joints_moved_alike(load, algebra):
    found, free = load(GRIPPER, algebra), load(GRIPPER, algebra, mimic="free")
    ratios = np.array([[1.0], [-2.0], [-6.0]])
    rng = np.random.default_rng(0)
    q, qd, qdd = rng.uniform(-1, 1, (3, 6, 1))
    every = np.array([list(relations(x).values()) for x in q[:, 0]])
    speeds, rates = qd @ ratios.T, qdd @ ratios.T
    assert found.joint_names == ("j",) and free.joint_names == ("j", "k", "l")
    tau = found.inverse_dynamics(q, qd, qdd)
    scale = np.abs(tau).max()
    assert np.abs(tau - free.inverse_dynamics(every, speeds, rates) @ ratios).max() < 1e-13 * scale
    matrices = ratios.T @ free.mass_matrix(every) @ ratios
    assert np.abs(found.mass_matrix(q) - matrices).max() < 1e-13 * matrices.max()
    assert np.abs(found.forward_dynamics(q, qd, tau) - qdd).max() < 1e-11
    assert found.forward_dynamics(q[0], qd, tau[0]).shape == (6, 1)
    values, status = found.forward_dynamics([[0.1], [np.nan]], qd[:1], tau[:1], status=True)
    assert np.isfinite(values[0]).all() and np.isnan(values[1]).all() and status.tolist() == [0, Status.INVALID]


def test_followers_have_no_coordinates_of_their_own(load):
    with pytest.raises(InputError, match=r"'k' follows 'j'.*mimic='free'"):
        load(GRIPPER).poses({"k": 1.0})


MIMIC = '<axis xyz="0 0 1"/><mimic joint="%s"/>'


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (robot(link("a") + link("b") + joint(inside=MIMIC % "jj")), "no joint 'jj' to follow .did you mean 'j'"),
        (robot(link("a") + link("b") + joint(inside=MIMIC % "j")), "in a circle, as in <joint name='j'"),
        (robot(link("a") + link("b") + link("c") + joint(inside=MIMIC % "k")
               + joint("k", "revolute", "a", "c", MIMIC % "j")), "in a circle"),
        (robot(link("a") + link("b") + link("c") + joint(inside=MIMIC % "k") + joint("k", "fixed", "a", "c")),
         "'k' is fixed and has no coordinate to follow, as in <joint name='j'>"),
        (robot(link("a") + link("b") + joint(kind="floating", inside=MIMIC % "k")), "floating joint has no single"),
        (robot(link("a") + link("b") + joint(inside='<axis xyz="0 0 1"/><mimic joint="j" offset="x"/>')), "offset='x'"),
    ],
)  # fmt: skip
def test_followers_that_are_wrong(load, text, words):
    with pytest.raises(InputError, match=r"robot.urdf:1: .*" + words):
        load(text)


def test_unknown_attributes(load):
    inside = '<axis xyz="0 0 1"/><limit effort="1" current="2" gear="3"/>'
    text = robot(link("a") + link("b") + joint(inside=inside))
    with pytest.warns(UserWarning, match=r"robot.urdf: .*current \(line 1\), gear") as caught:
        load(text)
    assert len(caught) == 1
    assert load(text, ignore=["current", "gear"]).joint_names == ("j",)
    with pytest.raises(InputError, match=r"current='2' is not known.*<limit>.*ignore=\['current'\]"):
        load(text, strict=True)
    moved = robot(link("a") + link("b") + joint(inside='<axis xyz="0 0 1"/><origin quat="1 0 0 0"/>'))
    with pytest.raises(InputError, match="quat='1 0 0 0' is not known"):
        load(moved)
    assert load(moved, ignore=["quat"]).joint_names == ("j",)


def test_followers_of_followers_take_no_time(tmp_path):
    """A thousandth of a second each, in a row: composed once, not from the first for each."""
    count = 2000
    links = "".join(link(f"l{i}") for i in range(count + 1))
    joints = "".join(
        joint(f"j{i}", "continuous", f"l{i}", f"l{i + 1}", f'<mimic joint="j{i - 1}" offset="1"/>' if i else "")
        for i in range(count)
    )
    path = tmp_path / "row.urdf"
    path.write_text(robot(links + joints))
    begin = time.perf_counter()
    loaded = kinematics.load_urdf(path)
    assert time.perf_counter() - begin < 2.0
    assert loaded.joint_names == ("j0",)
    last = loaded.followers[f"j{count - 1}"]
    assert (last.joint, last.multiplier, last.offset) == ("j0", 1.0, count - 1.0)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes")
def test_pipes_are_no_robots(tmp_path):
    pipe = tmp_path / "robot.xml"
    os.mkfifo(pipe)
    whole = tmp_path / "whole.xml"
    whole.write_text(f'<mujoco><include file="{pipe.name}"/></mujoco>')
    loaders = [(kinematics.load_urdf, pipe), (kinematics.load_mjcf, whole), (kinematics.load_sdf, pipe)]
    for load, path in loaders:
        with pytest.raises(InputError, match="plain file"):
            load(path)
