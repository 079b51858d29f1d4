"""Mechanisms at singular poses, and loops that do not close."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from bladesmith import cga3d as cga
from bladesmith import kinematics as kin
from bladesmith.codegen.errors import ConstraintError, UndeterminedError

from ...support.kinematics import AXIS, Delta, four_bar, six, twist
from ...support.mechanisms.poses import BAR, MOTORS

pytestmark = pytest.mark.filterwarnings("error")


def test_a_stretched_four_bar():
    """Crank and coupler in one line: the rocker is at its limit, and can not drive."""
    d, a, b, c = BAR.lengths
    theta = np.arccos(((a + b) ** 2 + d**2 - c**2) / (2 * (a + b) * d))
    way = np.array([np.cos(theta), np.sin(theta), 0])
    m = four_bar([0 * way, a * way, (a + b) * way, [d, 0, 0]])
    np.testing.assert_allclose(m.jacobian("a", "d"), 0, atol=1e-9)
    found = m.analysis("a", ["rocker"])
    assert not found.open.size and found.lost.shape == (6, 6)
    driven = m.analysis("d", "a")
    assert driven.residual[0] > 0.1 and driven.open.shape == (1, 1)
    with pytest.raises(ConstraintError, match=f"input 0 .*{driven.residual[0]:.3g}"):
        m.jacobian("d", "a")
    assert np.abs(m.jacobian("d", "a", strict=False)).max() < 10  # the least speeds, and no infinity


def test_a_delta_arm_in_line_loses_a_direction():
    robot = Delta()
    theta = np.array([2.0, 0.0, 0.0])
    out = np.cos(theta[0]) * robot.s[0] + np.sin(theta[0]) * AXIS
    elbow = np.asarray(robot.elbows(theta))[0]
    y = elbow - robot.effector * robot.s[0] + robot.fore * out
    for i in (1, 2):  # the other arms reach the same place

        def reach(t, i=i):
            return np.linalg.norm(np.asarray(robot.elbows([t] * 3))[i] - robot.effector * robot.s[i] - y) - robot.fore

        values = np.linspace(-1.5, 2.5, 400)
        k = next(k for k in range(399) if reach(values[k]) * reach(values[k + 1]) < 0)
        theta[i] = brentq(reach, values[k], values[k + 1], xtol=1e-15)
    m = robot.mechanism(theta, y=y)
    found = m.analysis(MOTORS, ("platform", y))
    assert found.lost.shape == (3, 1) and not found.open.size
    np.testing.assert_allclose(abs(found.lost[:, 0] @ out), 1, atol=1e-9)
    assert m.residual() < 1e-9 and np.linalg.matrix_rank(found.jacobian, tol=1e-8) == 2


def test_a_delta_with_level_rods_is_open():
    robot = Delta(lengths=(0.4, 0.15, 0.6, 0.7))
    theta = np.arccos((0.7 - 0.25) / 0.6)
    m = robot.mechanism(np.full(3, theta), y=[0, 0, 0.6 * np.sin(theta)])
    found = m.analysis(MOTORS, ("platform", [0, 0, 0.6 * np.sin(theta)]))
    assert found.open.shape == (3, 1)
    np.testing.assert_allclose(np.abs(found.open[:, 0]), [0, 0, 1], atol=1e-9)
    with pytest.raises((UndeterminedError, ConstraintError)):
        m.jacobian(MOTORS, ("platform", [0, 0, 0]))


@pytest.mark.slow
@settings(max_examples=25)
@given(st.floats(1e-5, 0.5), st.sampled_from([1e-3, 1.0, 1e3]))
def test_a_loop_that_is_open_says_by_how_much(gap, scale):
    """The pseudo-inverse would average in silence."""
    places = BAR.places(0.8) * scale
    m = four_bar(places, radius=scale)
    closed = m.at({})
    assert closed.residual() < 1e-12 and closed.mobility() == 1
    shifted = m.at({"rocker": cga.translator([0, 0, gap * scale])})
    assert set(n for n, v in shifted.residuals().items() if v > 1e-9) == {"c", "d"}
    assert gap / 10 < shifted.residual() < 10 * gap
    with pytest.raises(ConstraintError, match="apart"):
        shifted.mobility()
    with pytest.raises(ConstraintError, match="apart"):
        shifted.jacobian("a", "b")
    joint = kin.Spherical("g", "x", cga.point(scale * np.ones(3)), other=cga.point(scale * (1 + gap * AXIS)))
    with pytest.raises(ConstraintError, match="apart"):
        kin.Mechanism(["g", "x"], "g", joint).constraint_matrix()


def test_moved_as_one_it_is_the_same():
    places = BAR.places(0.8)
    m = four_bar(places)
    motor = (-0.3 * twist(cga, np.array([1, 2, 3, 4, 5, 6.0]))).exp()
    moved = m.at(dict.fromkeys(m.bodies, motor))
    assert moved.residual() < 1e-12
    np.testing.assert_allclose(moved.jacobian("a", "d"), m.jacobian("a", "d"), rtol=1e-9)
    twists = [
        six(x["coupler"]) for x in (moved.solve({"a": 1.0}), {"coupler": motor >> m.solve({"a": 1.0})["coupler"]})
    ]
    np.testing.assert_allclose(*twists, atol=1e-9)
    assert moved.at(dict.fromkeys(m.bodies, ~motor)).residual() < 1e-12
