"""The Delta robot with all fifteen joints: its points, the nullity of its joints, twists of the motors."""

import numpy as np
import pytest

from bladesmith import cga3d as cga
from bladesmith import dynamics

from ...oracles.delta_robots import USUAL, as_floats, frame, modes, poses

pytestmark = pytest.mark.filterwarnings("error")


def test_points_of_the_whole_robot():
    """7.7.1 and 7.7.3: lengths of all limbs, the platform a triangle about its centre, rods of an arm parallel."""
    theta, y = poses(USUAL, 30, seed=12)
    found = USUAL.pose(theta)
    lengths = np.linalg.norm(found.bottoms - found.tops, axis=-1)
    assert np.abs(lengths - USUAL.forearm).max() < 1e-12
    assert np.abs(np.linalg.norm(found.elbows - found.shoulders, axis=-1) - USUAL.upper_arm).max() < 1e-14
    assert np.abs((found.tops - found.bottoms)[:, ::2] - (found.tops - found.bottoms)[:, 1::2]).max() < 1e-14
    for rods in ((1, 2), (3, 4), (5, 0)):
        assert np.abs(found.bottoms[:, rods[0]] - found.bottoms[:, rods[1]]).max() < 1e-14
    assert np.abs(found.corners.mean(1) - y).max() < 1e-14
    sides = np.linalg.norm(found.corners - np.roll(found.corners, 1, 1), axis=-1)
    assert np.abs(sides - 2 * np.sqrt(3) * USUAL.effector_radius).max() < 1e-14
    outer = np.array([modes(USUAL, *each) == [1, 1, 1] for each in zip(theta, y, strict=True)])
    back = USUAL.pose_at(y[outer])
    assert outer.sum() > 10 and np.abs(back.elbows - found.elbows[outer]).max() < 1e-12
    lost = USUAL.pose_at([[0, 0, 9.0], [0, 0, 1.0]])
    assert np.isnan(lost.tops[0]).all() and np.isfinite(lost.tops[1]).all()


def test_the_fifteen_joints_have_nullity_nine():
    """51 independent rows of 60 columns: three motions and the spins of six rods; and they give the Jacobian."""
    theta = np.array([0.3, 0.1, 0.5])
    mechanism = USUAL.mechanism(theta)
    found = mechanism.jacobian(list(mechanism.joints)[:3], ("platform", USUAL.forward(theta)))
    assert mechanism.mobility() == 9 and np.abs(found - USUAL.forward_jacobian(theta)).max() < 1e-12
    shared = USUAL.joint_objects(theta).incidences()
    bodies = [*dict.fromkeys(name for a, b, _ in shared for name in (a, b) if name != "base")]
    twists = [dynamics.twist(w, v) for w, v in [(e, 0) for e in np.eye(3)] + [(0, e) for e in np.eye(3)]]
    rows = []
    for a, b, x in shared:
        block = np.stack([x.commutator(t).values for t in twists], 1)
        row = np.zeros((len(block), 6 * len(bodies)))
        for sign, name in ((1, a), (-1, b)):
            if name != "base":
                row[:, 6 * bodies.index(name) :][:, :6] = sign * block
        rows.append(row)
    matrix = np.concatenate(rows)
    assert len(shared) == 15 and matrix.shape[1] == 60
    values = np.linalg.svd(matrix)[1]
    assert (values > 1e-9).sum() == 51
    null = np.linalg.svd(matrix)[2][51:].T
    speeds = []
    for i in range(3):  # the speed of a motor is its twist's angular part along the axis
        at = 6 * bodies.index(f"upper_arm_{i + 1}")
        speeds.append(as_floats(frame(i)[1]) @ null[at : at + 3])
    at = 6 * bodies.index("platform")
    turning, moving = null[at : at + 3], null[at + 3 : at + 6]
    assert np.abs(turning).max() < 1e-12
    jacobian = moving @ np.linalg.pinv(np.array(speeds), rcond=1e-9)
    assert np.abs(jacobian - USUAL.forward_jacobian(theta)).max() < 1e-12


def test_motor_twists_turn_the_elbows():
    """dX = X x Omega is the elbow's rate per radian, in its arm's plane."""
    theta = np.array([0.3, 0.1, 0.5])
    rates = cga.point(USUAL.pose(theta).elbows).commutator(USUAL.motor_twists())
    for i in range(3):
        s = as_floats(frame(i)[0])
        path = USUAL.upper_arm * (np.cos(theta[i]) * np.array([0, 0, 1]) - np.sin(theta[i]) * s)
        assert np.abs([rates[i][e] for e in ("e1", "e2", "e3")] - path).max() < 1e-15


def test_batches_of_joint_objects():
    theta, _ = poses(USUAL, 7, seed=13)
    found = USUAL.joint_objects(theta)
    assert found.circles.shape == (7, 3) and found.tops.shape == (7, 6) and found.corners.shape == (7, 3)
    one = USUAL.joint_objects(theta[4])
    assert np.allclose(one.circles.values, found.circles[4].values, atol=1e-14)
    read = one.circles.parameters()
    assert np.allclose(read.radius, USUAL.upper_arm) and np.allclose(read.normal[0], [0, -1, 0])
    assert [type(j).__name__ for j in one.joints()] == ["Revolute"] * 3 + ["Spherical"] * 12
    assert {n for j in one.joints() for n in (j.a, j.b)} == {
        "base", "platform", *(f"upper_arm_{i}" for i in (1, 2, 3)), *(f"forearm_{i}" for i in range(1, 7))
    }  # fmt: skip
