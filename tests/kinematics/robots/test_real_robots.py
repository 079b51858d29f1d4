"""Robots of the package example-robot-data: what loads, what becomes a system, and poses and Jacobians by Pinocchio."""

import warnings

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import kinematics
from bladesmith.dynamics import screw_coordinates
from bladesmith.errors import InputError
from bladesmith.kinematics.robots.description import unused_name

from ...support.mechanisms.robots import each_robot, real_robots

ROBOTS = real_robots()
#: One follows joints that it does not have; one is a part that others include.
BROKEN = {"alex/alex_psyonic_hands": "no joint 'index_q1' to follow", "ur/ur3": "no links.*part that other files"}
#: One body, without a joint that moves.
NO_SYSTEM = ("hector/quadrotor_base", "iris/iris_simple")
BAR = 1e-13
pytestmark = [pytest.mark.peers, pytest.mark.slow]


@pytest.fixture(autouse=True)
def warnings_are_for_users():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield


@each_robot()
def test_files_load_and_become_systems(name):
    if name in BROKEN:
        with pytest.raises(InputError, match=BROKEN[name]):
            kinematics.load_urdf(ROBOTS[name])
        return
    found = kinematics.load_urdf(ROBOTS[name])
    if name in NO_SYSTEM:
        with pytest.raises(InputError, match="one body"):
            found.system()
        assert len(found.system(base="free").bodies) == 1
        return
    system = found.system(inertia="nearest")
    assert 0 < len(system.bodies) <= len(found.lumps)


@each_robot()
def test_poses_and_jacobians_beside_pinocchio(name):
    pin = pytest.importorskip("pinocchio")
    if name in BROKEN:
        return
    algebra = (bs.cga3d, bs.pga3d)[len(name) % 2]
    found = kinematics.load_urdf(ROBOTS[name], algebra)
    model = pin.buildModelFromUrdf(str(ROBOTS[name]))
    data, rng = model.createData(), np.random.default_rng(0)
    q = rng.uniform(-2, 2, (3, len(found.joint_names)))
    poses = {link: algebra.matrix(x) for link, x in found.poses(q).items()}
    scale = 1 + max(float(np.abs(m[..., :3, 3]).max()) for m in poses.values())
    for i in range(3):
        values = dict(zip(found.joint_names, q[i], strict=True))
        values |= {n: f.multiplier * values[f.joint] + f.offset for n, f in found.followers.items()}
        x = pin.neutral(model)
        columns = {}
        for joint, value in values.items():
            own = model.joints[model.getJointId(joint)]
            x[own.idx_q : own.idx_q + own.nq] = [np.cos(value), np.sin(value)] if own.nq == 2 else [value]
            columns[joint] = own.idx_v
        pin.framesForwardKinematics(model, data, x)
        pin.computeJointJacobians(model, data, x)
        for link in found.links:
            frame = data.oMf[model.getFrameId(link, pin.FrameType.BODY)].homogeneous
            assert np.abs(poses[link][i] - frame).max() < BAR * scale
        if i:
            continue
        tips = [link for link in found.links if link not in {j.parent for j in found.joints.values()}]
        for tip in tips:
            try:
                chain = found.chain(tip)
            except InputError:  # nothing moves it
                continue
            ours = chain.jacobian([values[joint] for joint in chain.names])
            frame = model.getFrameId(tip, pin.FrameType.BODY)
            theirs = pin.computeFrameJacobian(model, data, x, frame, pin.LOCAL_WORLD_ALIGNED)
            at = poses[tip][0][:3, 3]
            expected = np.zeros((6, len(chain.names)))
            for joint in values:
                leader = found.followers[joint].joint if joint in found.followers else joint
                if leader in chain.names:
                    ratio = found.followers[joint].multiplier if joint in found.followers else 1.0
                    v, w = np.split(theirs[:, columns[joint]], 2)
                    expected[:, chain.names.index(leader)] += ratio * np.concatenate([w, v + np.cross(at, w)])
            assert np.abs(ours - expected).max() < BAR * scale
    if found.joint_names and not any(j.type == "floating" for j in found.joints.values()):
        tip = found.links[-1]
        mechanism = found.mechanism(q[0])
        names = [unused_name(joint, found.links) for joint in found.joint_names]
        twist = screw_coordinates(mechanism.solve(dict.fromkeys(names, 1.0))[tip])
        try:
            chain = found.chain(tip)
        except InputError:
            return
        at = [found.joint_names.index(joint) for joint in chain.names]
        assert np.abs(chain.jacobian(q[0][at]).sum(-1) - twist).max() < 1e-9 * scale
