"""Joints without mass between them: systems have one joint for them, of the same mobility as the mechanism."""

import pickle

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import dynamics, kinematics
from bladesmith.errors import InputError

from .texts import joint, link, robot

ALGEBRAS = [bs.cga3d, bs.pga3d]


def chain(*joints):
    """A base, joints between links without mass, and a body at the end: (kind, axis, place)."""
    names = "abcd"[: len(joints) + 1]
    text = "".join(link(name) for name in names[:-1])
    text += link(names[-1], 2.0, (0.1, 0.2, 0.25), '<origin xyz="0.3 0 1"/>')
    for i, (kind, axis, place) in enumerate(joints):
        inside = f'<origin xyz="{place}"/><axis xyz="{axis}"/>'
        text += joint(f"j{i}", kind, names[i], names[i + 1], inside)
    return robot(text)


@pytest.mark.parametrize("algebra", ALGEBRAS, ids=lambda a: a.name)
@pytest.mark.parametrize(
    ("joints", "kind"),
    [
        ([("revolute", "1 0 0", "1 2 3"), ("revolute", "0 1 0", "0 0 0"), ("continuous", "0 0 1", "0 0 0")],
         kinematics.Spherical),
        ([("revolute", "1 0 0", "1 2 3"), ("revolute", "1 1 0", "0.5 0 0"), ("revolute", "0 0 1", "0 0 0")],
         kinematics.Spherical),
        ([("revolute", "0 1 1", "1 2 3"), ("prismatic", "0 1 1", "0 0 0")], kinematics.Cylindrical),
        ([("prismatic", "0 0 1", "1 2 3"), ("revolute", "0 0 -1", "0 0 5")], kinematics.Cylindrical),
        ([("prismatic", "1 0 0", "0 0 2"), ("prismatic", "1 1 0", "0 0 0"), ("revolute", "0 0 1", "0 0 0")],
         kinematics.Planar),
        ([("revolute", "0 0 1", "0 0 2"), ("revolute", "0 0 1", "1 0 0"), ("revolute", "0 0 -1", "0 1 1")],
         kinematics.Planar),
    ],
)  # fmt: skip
def test_joints_with_names(load, joints, kind, algebra):
    found = load(chain(*joints), algebra)
    system = found.system()
    (one,) = system.joints
    assert type(one) is kind and (one.a, one.b) == ("a", "abcd"[len(joints)])
    mechanism = kinematics.Mechanism(["a", one.b], "a", [one])
    assert mechanism.mobility() == found.mechanism().mobility() == len(joints)
    # the same twists: those of the file's mechanism are among those of the one joint
    for motion in found.mechanism().free_motions():
        mechanism.solve({one.b: motion[one.b]})


def test_universal_joints(load):
    text = chain(("revolute", "1 0 0", "1 2 3"), ("revolute", "0 1 0", "0 0 0"))
    (one,) = load(text).system([0.3, 0.4]).joints
    assert type(one) is kinematics.Universal
    whole = load(text).mechanism([0.3, 0.4])
    mechanism = kinematics.Mechanism(["a", "c"], "a", [one])
    for motion in whole.free_motions():
        mechanism.solve({"c": motion["c"]})
    with pytest.raises(InputError, match="universal ones in cga3d"):
        load(text, bs.pga3d).system()


def test_a_ball_of_three_hinges_falls_as_a_ball_does(load):
    axes = ("1 0 0", "0 1 0", "0 0 1")
    found = load(chain(*(("revolute", axis, "0 0 2" if axis == "1 0 0" else "0 0 0") for axis in axes)))
    system = found.system()
    run = dynamics.Simulation(system, [dynamics.Gravity((0, 0, -9.81))]).run(0.2, times=[0.2])
    body = system.bodies["d"]
    ball = kinematics.Spherical("a", "d", bs.cga3d.point([0, 0, 2]))
    other = dynamics.Simulation(dynamics.System({"d": body}, [ball], "a"), [dynamics.Gravity((0, 0, -9.81))])
    truth = other.run(0.2, times=[0.2])
    assert np.abs(run.position - truth.position).max() < 1e-12


@pytest.mark.parametrize(
    "joints",
    [
        [("revolute", "1 0 0", "0 0 0"), ("revolute", "1 0 0", "0 0 1")],  # a parallelogram's arm
        [("revolute", "1 0 0", "0 0 0"), ("revolute", "1 1 0", "0 0 0")],  # not at right angles
        [("revolute", "1 0 0", "0 0 0"), ("revolute", "0 1 0", "0 0 1")],  # they miss each other
        [("revolute", "1 0 0", "0 0 0"), ("prismatic", "0 1 0", "0 0 0")],
        [("prismatic", "1 0 0", "0 0 0"), ("prismatic", "0 1 0", "0 0 0"), ("revolute", "0 1 1", "0 0 0")],
        [("revolute", "1 0 0", "0 0 0"), ("revolute", "0 1 0", "0 0 0"), ("revolute", "1 1 0", "0 0 0")],
        [("prismatic", "1 0 0", "0 0 0"), ("prismatic", "0 1 0", "0 0 0"), ("prismatic", "0 0 1", "0 0 0")],
    ],
)
def test_joints_without_a_name(load, joints):
    with pytest.raises(InputError, match="name='b'> moves by <joint name='j0'>, carries others, and has no mass"):
        load(chain(*joints)).system()


def test_lumps_without_mass_that_branch(load):
    text = robot(
        link("a") + link("b") + link("c", 1.0) + link("d", 1.0) + joint("j", "revolute", "a", "b")
        + joint("k", "revolute", "b", "c", '<axis xyz="1 0 0"/>') + joint("l", "revolute", "b", "d")
    )  # fmt: skip
    with pytest.raises(InputError, match="name='b'> moves by <joint name='j'>"):
        load(text).system()


def test_followers_without_their_leader_follow_each_other(load):
    follow = '<axis xyz="1 0 0"/><mimic joint="j" multiplier="%s"/>'
    text = robot(
        link("a") + link("b") + link("c", 1.0) + link("d", 1.0) + joint("j", "revolute", "a", "b")
        + joint("k", "prismatic", "a", "c", follow % 2) + joint("l", "prismatic", "a", "d", follow % -3)
    )  # fmt: skip
    system = load(text).system()
    assert len(system.joints) == 2 and system.couplings == ({(1, 0): 2.0, (0, 0): 3.0},)


def test_robots_are_pickled(load):
    found = load(chain(("revolute", "1 0 0", "0 0 0")))
    q = np.linspace(0, 1, 5)[:, None]
    before, torques = found.poses(q), found.gravity_torques(q)
    again = pickle.loads(pickle.dumps(found))
    assert np.array_equal(again.poses(q)["b"].values, before["b"].values)
    assert np.array_equal(again.gravity_torques(q), torques) and again.mobility() == 1
