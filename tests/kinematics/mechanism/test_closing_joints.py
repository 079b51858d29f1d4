"""Joints that close a loop as outputs at many poses: beside one pose at a time, and differences of coordinates."""

import numpy as np
import pytest

from bladesmith import Status
from bladesmith import kinematics as kin

from ...support.kinematics import ALGEBRAS
from ...support.mechanisms.poses import BAR, START, bar

pytestmark = pytest.mark.filterwarnings("error")
ANGLES = np.array([0.0, 0.05, 0.2, 0.1])


def spatial(algebra, closing):
    """A loop of four bars in space: two hinges, and joints that leave one freedom in all."""
    al = ALGEBRAS[algebra]
    rng = np.random.default_rng(5)
    places, axes = rng.normal(size=(4, 3)), rng.normal(size=(4, 3))

    def hinge(a, b, k):
        objects = (al.line(places[k], axes[k]), al.point(places[k])) if al.is_degenerate else (
            al.circle(places[k], axes[k], 0.3),
        )  # fmt: skip
        return kin.Revolute(a, b, *objects)

    cylinders = [
        kin.Cylindrical(a, b, al.line(places[k], axes[k])) for a, b, k in (("crank", "rod", 1), ("rod", "r", 2))
    ]
    last = hinge("ground", "r", 3)
    if closing == "cylinder":
        last = kin.Cylindrical("ground", "r", al.line(places[3], axes[3]))
    if closing == "ball":
        cylinders[0] = kin.Spherical("crank", "rod", al.point(places[1]))
    m = kin.Mechanism(["ground", "crank", "rod", "r"], "ground")
    for name, joint in zip(
        ("motor", "first", "second", "last"), (hinge("ground", "crank", 0), *cylinders, last), strict=True
    ):
        m.add(joint, name)
    return m


@pytest.mark.compiles
@pytest.mark.parametrize("algebra", ALGEBRAS)
@pytest.mark.parametrize("closing", ["cylinder", "ball"])
def test_speeds_of_a_joint_that_closes_a_loop_in_space(algebra, closing):
    m = spatial(algebra, closing)
    assert m.mobility() == 1
    (name,) = (m.joint_names[j] for j in m.tree.loop_joints)
    assert (name == "first") == (closing == "ball")
    poses = m.solve_pose({"motor": ANGLES})
    assert not poses.status.any()
    together = m.jacobian("motor", ["crank", name, ("rod", [1.0, 0, 0]), name], poses=poses)
    count = m.joints[m.find_joint(name)].mobility
    assert together.shape == (4, 6 + 3 + 2 * count, 1)
    own = together[:, 6 : 6 + count]
    np.testing.assert_array_equal(own, together[:, -count:])
    np.testing.assert_array_equal(own, m.jacobian("motor", name, poses=poses))
    turns = poses["crank"].to_matrix()[:, :3, :3]
    for k in range(len(ANGLES)):
        there = m.at({body: poses[body][k] for body in m.moving})
        expected = there.jacobian("motor", name)  # of a ball about axes of the world
        np.testing.assert_allclose(turns[k] @ own[k] if closing == "ball" else own[k], expected, atol=1e-9)
        one = m.jacobian("motor", name, poses=m.solve_pose({"motor": float(ANGLES[k])}))
        np.testing.assert_allclose(one, own[k], atol=1e-11)
    if closing == "cylinder":
        h = 1e-4
        ends = m.solve_pose({"motor": ANGLES[1] + np.array([-h, h])}).coordinates(name)
        np.testing.assert_allclose(own[1, :, 0], (ends[1] - ends[0]) / (2 * h), rtol=1e-6)


@pytest.mark.parametrize("algebra", ALGEBRAS)
def test_the_hinge_that_closes_a_four_bar(algebra):
    m = bar(algebra)
    (name,) = (m.joint_names[j] for j in m.tree.loop_joints)
    angles = np.append(np.linspace(-1.0, 2.0, 5), np.nan)
    poses = m.solve_pose({"a": angles})
    rates, status = m.jacobian("a", name, poses=poses, status=True)
    assert status.tolist() == [Status.OK] * 5 + [Status.INVALID] and np.isnan(rates[-1]).all()
    h = 1e-4
    around = m.solve_pose({"a": angles[:-1, None] + [-h, h]}).coordinates(name)[..., 0]
    np.testing.assert_allclose(rates[:-1, 0, 0], np.diff(around, axis=-1)[:, 0] / (2 * h), rtol=1e-6, atol=1e-8)


def test_dead_points_are_zeros_of_the_rate_of_the_rocker():
    """Crank and coupler in one line, by the law of cosines, and what the analysis says of it."""
    from scipy.optimize import brentq

    m = bar()
    d, a, b, c = BAR.lengths

    def rate(angle):
        return m.jacobian("a", "d", poses=m.solve_pose({"a": angle}))[0, 0]

    x = np.linspace(0, 2 * np.pi, 33)
    rates = m.jacobian("a", "d", poses=m.solve_pose({"a": x}, path=True))[:, 0, 0]
    found = [brentq(rate, x[i], x[i + 1], xtol=1e-14) for i in np.flatnonzero(rates[:-1] * rates[1:] < 0)]
    reach = np.array([a + b, b - a])
    angles = np.arccos((reach**2 + d**2 - c**2) / (2 * reach * d)) + [0, np.pi]
    off = np.subtract.outer(found, angles - START)
    assert len(found) == 2 and np.allclose(np.abs(np.exp(1j * off) - 1).min(0), 0, atol=1e-9)
    for angle in found:
        there = m.at(m.solve_pose({"a": angle}))
        onward, back = there.analysis("a", "d"), there.analysis("d", "a")
        assert onward.singular and back.singular and onward.idle_inputs.shape == (1, 1) and not back.idle_inputs.size
        text = str(onward).splitlines()
        assert text[0] == "a -> d: singular (inverse)" and text[1:] == [
            "  does not move, for any inputs: d", "  has no effect: a",
        ]  # fmt: skip
        assert str(back).startswith(
            "d -> a: singular (forward)\n  moves while all inputs rest: a\n  the joints forbid: d ("
        )
    regular = m.analysis("a", ["coupler", ("rocker", [1.0, 0, 0])])
    assert not regular.singular and str(regular).startswith(
        "a -> coupler e12, coupler e13, coupler e1ni and 6 more: reg"
    )
    assert regular.outputs[-1] == "rocker z"
