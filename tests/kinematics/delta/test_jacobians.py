"""The thesis's formulas of the Delta robot, corrected, and Jacobians against differences of 50 digits."""

import itertools

import numpy as np
import pytest

from bladesmith import cga3d as cga
from bladesmith.kinematics.delta.robot import DeltaRobot

from ...oracles.delta_robots import (
    LENGTHS,
    USUAL,
    as_floats,
    differences,
    exact,
    forward_exact,
    frame,
    inverse_exact,
    modes,
    poses,
)

pytestmark = pytest.mark.filterwarnings("error")


# -- the thesis's own formulas, corrected ----------------------------------------------------------------------


def end_of(pair):
    """-P (T . n_inf) with P = (1 + ~T/sqrt(T^2))/2: ~T where the text has T (MATHS); as a position."""
    square = np.sqrt((pair * pair)["1"])
    w = -(0.5 * (~(1 + ~pair / square))) * (pair | cga.ni)
    w = w.grade(1)
    weight = -(w | cga.ni)["1"]
    return np.array([w[e] for e in ("e1", "e2", "e3")]) / weight


def test_the_formulas_of_the_text():
    """Meets of circle and sphere, and of three spheres, in conformal geometry (7.7.2)."""
    base, platform, upper, forearm = LENGTHS[0]
    theta, y = poses(USUAL, 20, seed=5)
    for t, place in zip(theta, y, strict=True):
        duals = []
        for i in range(3):
            s = as_floats(frame(i)[0])
            x = cga.point(place + platform * s) - 0.5 * forearm**2 * cga.ni
            center = cga.point(base * s) - 0.5 * upper**2 * cga.ni
            sv = vector(s)
            circle = center ^ ((cga.e1 ^ cga.e2 ^ cga.e3) * (sv ^ cga.e3)).grade(1)
            pair = (circle ^ x).dual()
            ends = [end_of(p) for p in (pair, ~pair)]
            z = [e - base * s for e in ends]
            angles = [np.arctan2(v[2], v @ s) for v in z]
            assert np.abs(np.array(angles) - [USUAL.inverse(place, e)[i] for e in ("outer", "inner")]).max() < 1e-12
            a = (base - platform + upper * np.cos(t[i])) * s + upper * np.sin(t[i]) * np.array([0, 0, 1])
            duals.append(cga.point(a) - 0.5 * forearm**2 * cga.ni)
        pair = (duals[0] ^ duals[1] ^ duals[2]).dual()
        assert np.abs(end_of(pair) - USUAL.forward(t)).max() < 1e-12
        assert np.abs(end_of(~pair) - USUAL.forward(t, "near")).max() < 1e-12


def moved_end(pair, rate):
    """7.7.5: the end of a point pair and its rate, as positions; ~T for T, as everywhere (MATHS)."""
    t, dt = ~pair, ~rate
    square = (t * t)["1"]
    root = np.sqrt(square)
    p, dp = 0.5 * (1 + t / root), (root * dt - t * ((dt | t)["1"] / root)) / (2 * square)
    w = (-(~p) * (t | cga.ni)).grade(1)
    dw = (-(~dp) * (t | cga.ni) - ~p * (dt | cga.ni)).grade(1)
    weight, slope = (w | cga.ni)["1"], (dw | cga.ni)["1"]
    parts, rates = (np.array([x[e] for e in ("e1", "e2", "e3")]) for x in (w, dw))
    return -parts / weight, -rates / weight + parts * slope / weight**2


def test_the_derivatives_of_the_text():
    """Both Jacobians by the printed rules for point pairs and their projectors, in conformal geometry (7.7.5)."""
    base, platform, upper, forearm = LENGTHS[0]
    y = np.array([0.12, -0.07, 0.85])
    theta, e3 = USUAL.inverse(y), np.array([0, 0, 1.0])
    inverse, spheres, rates = np.zeros((3, 3)), [], []
    for i in range(3):
        s = as_floats(frame(i)[0])
        circle = (cga.point(base * s) - 0.5 * upper**2 * cga.ni) ^ (
            (cga.e1 ^ cga.e2 ^ cga.e3) * (vector(s) ^ cga.e3)
        ).grade(1)
        x = y + platform * s
        for j, way in enumerate(np.eye(3)):
            pair = ((cga.point(x) - 0.5 * forearm**2 * cga.ni) ^ circle).dual()
            w, dw = moved_end(pair, ((vector(way) + (way @ x) * cga.ni) ^ circle).dual())
            z = w - base * s
            inverse[i, j] = ((z @ s) * (dw @ e3) - (z @ e3) * (dw @ s)) / (z @ z)
        a = (base - platform + upper * np.cos(theta[i])) * s + upper * np.sin(theta[i]) * e3
        da = upper * (np.cos(theta[i]) * e3 - np.sin(theta[i]) * s)
        spheres.append(cga.point(a) - 0.5 * forearm**2 * cga.ni)
        rates.append(vector(da) + (da @ a) * cga.ni)
    assert np.abs(inverse - USUAL.inverse_jacobian(y)).max() < 1e-12
    pair = (spheres[0] ^ spheres[1] ^ spheres[2]).dual()
    for i in range(3):
        parts = [rates[k] if k == i else spheres[k] for k in range(3)]
        place, column = moved_end(pair, (parts[0] ^ parts[1] ^ parts[2]).dual())
        assert np.abs(place - y).max() < 1e-12
        assert np.abs(column - USUAL.forward_jacobian(theta)[:, i]).max() < 1e-12


def vector(v):
    return sum(c * e for c, e in zip(v, (cga.e1, cga.e2, cga.e3), strict=True))


def text_inverse_jacobian(robot, y, theta):
    """7.7.5 by arms, without the factor z.s/|z.s|: dW by differentiating |W - X| = forearm on the circle."""
    rows = []
    for i, t in enumerate(theta):
        s, e3 = as_floats(frame(i)[0]), np.array([0, 0, 1.0])
        z = robot.upper_arm * (np.cos(t) * s + np.sin(t) * e3)
        v = y + robot.effector_radius * s - robot.base_radius * s - z
        path = robot.upper_arm * (np.cos(t) * e3 - np.sin(t) * s)
        rows.append(v / (v @ path))
    return np.array(rows)


# -- Jacobians -------------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("lengths", LENGTHS[:4])
def test_jacobians_to_50_digits(lengths):
    """Against differences at 50 digits, at 1e-14 times the square of what the pose is ill-conditioned by."""
    robot = DeltaRobot(*lengths)
    theta, y = poses(robot, 12, seed=1)
    near = robot.singularity(theta)
    for i in range(len(theta)):
        sides = modes(robot, theta[i], y[i])
        words = tuple("outer" if s > 0 else "inner" for s in sides)
        truth = differences(lambda x, s=sides: inverse_exact(robot, x, s), exact(y[i]))
        bound = 1e-13 * np.abs(truth).max()
        bend, hold = np.abs(near.sines[i]).min(), abs(near.volume[i])
        for method in ("direct", "screw"):
            assert np.abs(robot.inverse_jacobian(y[i], method, words) - truth).max() < bound / bend**2
        truth = differences(lambda x: forward_exact(robot, x), exact(theta[i]))
        bound = 1e-13 * np.abs(truth).max()
        for method in ("direct", "screw"):
            assert np.abs(robot.forward_jacobian(theta[i], method) - truth).max() < bound / hold**2


def test_jacobians_agree():
    """Both methods, both ways: J J* = 1 to 1e-11 at the conditions of a robot at work, and the text's own rows."""
    rng = np.random.default_rng(2)
    y = np.concatenate([rng.uniform(-0.4, 0.4, (2000, 2)), rng.uniform(0.7, 1.1, (2000, 1))], 1)
    theta = USUAL.inverse(y, strict=True)
    inverse, forward = USUAL.inverse_jacobian(y), USUAL.forward_jacobian(theta)
    assert np.abs(forward @ inverse - np.eye(3)).max() < 1e-11
    assert np.abs(inverse - USUAL.inverse_jacobian(y, "screw")).max() < 1e-11
    assert np.abs(forward - USUAL.forward_jacobian(theta, "screw")).max() < 1e-11
    assert (
        np.abs(inverse[:50] - [text_inverse_jacobian(USUAL, *x) for x in zip(y[:50], theta[:50], strict=True)]).max()
        < 1e-11
    )


def test_each_posture_has_its_jacobian():
    """All eight working modes, and both roots: the derivative of that posture."""
    y = np.array([0.12, -0.07, 0.8])
    for words in itertools.product(("outer", "inner"), repeat=3):
        sides = [1 if w == "outer" else -1 for w in words]
        theta = USUAL.inverse(y, words)
        assert np.allclose(theta, as_floats(inverse_exact(USUAL, y, sides)), atol=1e-14)
        truth = differences(lambda x, s=sides: inverse_exact(USUAL, x, s), exact(y))
        for method in ("direct", "screw"):
            assert np.allclose(USUAL.inverse_jacobian(y, method, words), truth, rtol=1e-12)
    theta = np.array([0.3, 0.1, 0.5])
    for root, side in (("far", 1), ("near", -1)):
        truth = differences(lambda x, s=side: forward_exact(USUAL, x, s), exact(theta))
        for method in ("direct", "screw"):
            assert np.allclose(USUAL.forward_jacobian(theta, method, root), truth, rtol=1e-11, atol=1e-13)
