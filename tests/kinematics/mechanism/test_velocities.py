"""Velocities of mechanisms against closures of 50 digits and dense solutions."""

import time

import numpy as np
import pytest

from bladesmith import cga3d as cga
from bladesmith import kinematics as kin
from bladesmith.codegen.errors import (
    ConstraintError,
)

from ...support.kinematics import (
    ALGEBRAS,
    AXIS,
    Delta,
    columns,
    four_bar,
    full_matrix,
    six,
    slide,
    turn,
    twist,
    velocity,
)
from ...support.mechanisms.poses import BAR, MOTORS, THETA

pytestmark = pytest.mark.filterwarnings("error")


@pytest.mark.parametrize("algebra", ALGEBRAS)
@pytest.mark.parametrize("theta", [0.8, 2.0, -2.5])
def test_a_four_bar_against_fifty_digits(theta, algebra):
    m = four_bar(BAR.places(theta), ALGEBRAS[algebra])
    slope = BAR.slope(theta)
    np.testing.assert_allclose(m.jacobian("a", "d"), [[-slope]], rtol=1e-10)  # the last joint is from rocker to ground
    np.testing.assert_allclose(m.jacobian("d", "a"), [[-1 / slope]], rtol=1e-10)
    np.testing.assert_allclose(
        m.jacobian(m.joints[0], ["rocker"])[:, 0], twist_values(m, slope * turn(AXIS, [3, 0, 0])), atol=1e-10
    )
    places = BAR.places(theta)
    point = m.jacobian("a", ("coupler", places[2]))[:, 0]
    np.testing.assert_allclose(point, slope * np.cross(AXIS, places[2] - places[3]), atol=1e-10)
    np.testing.assert_allclose(m.jacobian("a", ("coupler", m.algebra.point(places[2])))[:, 0], point, atol=0)
    np.testing.assert_allclose(m.jacobian("a", ["b", "c"]).sum() + 1 + m.jacobian("a", "d")[0, 0], 0, atol=1e-12)


def twist_values(m, value):
    return twist(m.algebra, value).values


@pytest.mark.parametrize("scale, centre", [(1, 0), (1e-6, 0), (1e3, 0), (1, 1e4)])
@pytest.mark.parametrize("algebra", ALGEBRAS)
def test_a_delta_against_fifty_digits(scale, centre, algebra):
    robot = Delta(scale, np.full(3, float(centre)))
    m = robot.mechanism(THETA, ALGEBRAS[algebra])
    slope = robot.slope(THETA)
    found = m.jacobian(MOTORS, ("platform", robot.place(THETA)))
    bar = 1e-7 if centre else 1e-11
    np.testing.assert_allclose(found / scale, slope / scale, atol=bar)
    ways = twist(m.algebra, slide(np.eye(3)))
    back = m.jacobian(("platform", ways), MOTORS)
    np.testing.assert_allclose(back @ found, np.eye(3), atol=10 * bar)
    analysis = m.analysis(MOTORS, ("platform", robot.place(THETA)))
    assert analysis.residual.max() < bar and not analysis.open.size and not analysis.lost.size
    assert 1 < analysis.condition < 100 and m.residual() < 1e-9


@pytest.mark.slow
def test_split_columns_are_the_dense_solution():
    """(7.25) mended: y = -U C_u^+ C_k K x, with [C_k C_u] the thesis's full matrix; as printed it is something else."""
    m = Delta().mechanism(THETA)
    full = full_matrix(m)
    at = 6 * m.moving.index("platform")
    known = full[:, at : at + 6]
    unknown = np.delete(full, np.s_[at : at + 6], 1)
    K = np.concatenate([np.zeros((3, 3)), np.eye(3)])
    others = -np.linalg.pinv(unknown, rcond=1e-10) @ known @ K
    bodies = [b for b in m.moving if b != "platform"]
    for b in ("upper_0", "upper_1", "upper_2"):  # rods spin as they like
        i = 6 * bodies.index(b)
        found = m.jacobian(("platform", twist(cga, slide(np.eye(3)))), b)
        np.testing.assert_allclose(np.linalg.solve(columns(cga), found), others[i : i + 6], atol=1e-11)
    printed = -np.linalg.pinv(full, rcond=1e-10)[np.r_[0:at, at + 6 : 60]] @ known @ K
    assert np.abs(printed - others).max() > 0.1 * np.abs(others).max()


def test_twists_of_all_bodies():
    places = BAR.places(0.8)
    m = four_bar(places)
    slope = BAR.slope(0.8)
    found = m.solve({"a": 2.0})
    assert list(found) == ["ground", "crank", "rocker", "coupler"] or set(found) == set(m.bodies)
    np.testing.assert_allclose(six(found["crank"]), turn(2 * AXIS, places[0]), atol=1e-12)
    np.testing.assert_allclose(six(found["rocker"]), turn(2 * slope * AXIS, places[3]), atol=1e-11)
    for a, b, p in (("ground", "crank", 0), ("crank", "coupler", 1), ("coupler", "rocker", 2), ("rocker", "ground", 3)):
        np.testing.assert_allclose(velocity(six(found[a]), places[p]), velocity(six(found[b]), places[p]), atol=1e-11)
    for known in (
        {"crank": found["crank"]},
        {"rocker": found["rocker"]},
        {"d": -2 * slope},
        {m.joints[3]: [-2 * slope]},
        {"a": 2, "d": -2 * slope},
        {"a": np.float32(2), "coupler": found["coupler"]},
    ):
        again = m.solve(known)
        for b in m.bodies:
            np.testing.assert_allclose(six(again[b]), six(found[b]), atol=1e-10)
    near = m.solve({"a": 2.0, "d": 1.0}, strict=False)
    assert np.isfinite(six(near["coupler"])).all()
    with pytest.raises(ConstraintError, match="violates? the joint constraints"):
        m.solve({"a": 2.0, "d": 1.0})
    with pytest.raises(ConstraintError, match="violates? the joint constraints"):
        m.solve({"crank": twist(cga, slide(AXIS))})


@pytest.mark.slow
def test_a_chain_sums_its_joints():
    """Twist accumulation (7.2 to 7.14): the columns of a chain are its axes; and a thousand bodies are no work."""
    rng = np.random.default_rng(0)
    count = 1000
    places = np.cumsum(rng.normal(size=(count, 3)) * 0.3, 0)
    axes = rng.normal(size=(count, 3))
    axes /= np.linalg.norm(axes, axis=-1, keepdims=True)
    joints = [
        kin.Revolute(f"b{i}", f"b{i + 1}", cga.circle(p, n, 1.0))
        for i, (p, n) in enumerate(zip(places, axes, strict=True))
    ]
    names = [f"b{i}" for i in range(count + 1)]
    kin.Mechanism(names[:3], "b0", joints[:2]).jacobian(joints[:2], "b2")  # what a first call loads
    used = []
    for _ in range(2):
        m = kin.Mechanism(names, "b0", joints)
        start = time.process_time()
        matrix, mobility, jacobian = m.constraint_matrix(), m.mobility(), m.jacobian(joints, names[-1])
        used.append(time.process_time() - start)
    assert mobility == count and matrix.shape == (5 * count, 6 * count) and matrix.nnz <= 2 * 36 * count
    np.testing.assert_allclose(np.linalg.solve(columns(cga), jacobian), turn(axes, places).T, atol=1e-10)
    assert min(used) <= 1.0
    small = m.jacobian(joints[:500], "b500")
    np.testing.assert_allclose(np.linalg.solve(columns(cga), small), turn(axes, places)[:500].T, atol=1e-10)
