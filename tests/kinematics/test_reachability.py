"""What `Chain.inverse` and `Mechanism.solve_pose` call UNREACHABLE is proved: never a pose that there is."""

import numpy as np
import pytest

import bladesmith as bs
from bladesmith.kinematics import Chain, Mechanism, Revolute, prismatic_axis, revolute_axis, screw_axis
from bladesmith.kinematics.mechanism.reachability import is_too_far
from bladesmith.kinematics.serial.reachability import is_beyond

from ..support.kinematics import ALGEBRAS

HALF = np.pi / 2
#: a, alpha, d and theta at zero of each joint (classic Denavit-Hartenberg), metres.
UR5 = [
    (0, HALF, 0.089159, 0), (-0.425, 0, 0, 0), (-0.39225, 0, 0, 0), (0, HALF, 0.10915, 0), (0, -HALF, 0.09465, 0),
    (0, 0, 0.0823, 0),
]  # fmt: skip
PUMA = [
    (0, HALF, 0.67183, 0), (0.4318, 0, 0.1397, 0), (0.0203, -HALF, 0.15005, 0), (0, HALF, 0.4318, 0), (0, -HALF, 0, 0),
    (0, 0, 0.0565, 0),
]  # fmt: skip
SEVEN = [
    (0, -HALF, 0.34, 0), (0, HALF, 0, 0), (0, HALF, 0.4, 0), (0, -HALF, 0, 0), (0, -HALF, 0.4, 0), (0, HALF, 0, 0),
    (0, 0, 0.126, 0),
]  # fmt: skip
ARMS = {"ur5": UR5, "puma": PUMA, "seven": SEVEN}


def frames(parameters):
    """Matrices of all joints' frames and the tool's, all at zero: products of the table's four motions."""
    now, found = np.eye(4), []
    for a, alpha, d, theta in parameters:
        found.append(now)
        c, s, ca, sa = np.cos(theta), np.sin(theta), np.cos(alpha), np.sin(alpha)
        now = now @ [[c, -s * ca, s * sa, a * c], [s, c * ca, -c * sa, a * s], [0, sa, ca, d], [0, 0, 0, 1]]
    return found, now


def arm(parameters, algebra=bs.cga3d, limits=None):
    joints, tool = frames(parameters)
    axes = [revolute_axis(f[:3, 3], f[:3, 2], algebra) for f in joints]
    return Chain(axes, algebra.motor_from_matrix(tool), limits=limits)


def proved(chain, targets, tolerance=1e-12):
    return is_beyond(chain, targets.as_kind("motor"), tolerance)


@pytest.mark.parametrize("name", ALGEBRAS)
@pytest.mark.parametrize("parameters", ARMS.values(), ids=ARMS)
def test_no_pose_of_an_arm_is_proved_away(parameters, name):
    """Of 20 000 poses, many stretched or folded; nor by the search with one attempt, which misses hundreds."""
    chain = arm(parameters, ALGEBRAS[name])
    rng = np.random.default_rng(4)
    q = rng.uniform(-np.pi, np.pi, (20000, chain.count))
    q[::3] = np.round(q[::3] / HALF) * HALF
    targets = chain.forward(q)
    assert not proved(chain, targets).any()
    found = chain.inverse(targets[:2000], attempts=1, iterations=20)
    missed = found.status == bs.Status.NOT_CONVERGED
    assert missed.sum() > 100
    assert np.isin(found.status[~missed], (bs.Status.OK, bs.Status.NOT_UNIQUE)).all()
    assert np.isnan(found.q[missed]).all()


@pytest.mark.slow
def test_a_pose_that_the_attempts_miss_is_found_by_more():
    """Poses of a UR5 at which few attempts come to rest: NOT_CONVERGED, and other starts reach them."""
    chain = arm(UR5)
    q = np.random.default_rng(0).uniform(-np.pi, np.pi, (20000, 6))
    targets = chain.forward(q)
    found = chain.inverse(targets, attempts=4, threads=None)
    assert not (found.status == bs.Status.UNREACHABLE).any()
    missed = np.flatnonzero(found.status == bs.Status.NOT_CONVERGED)
    assert 0 < len(missed) < 1000
    again = chain.inverse(targets[missed], attempts=256)
    assert np.isin(again.status, (bs.Status.OK, bs.Status.NOT_UNIQUE)).all()


@pytest.mark.parametrize("name", ALGEBRAS)
def test_what_is_further_or_nearer_than_the_lengths_is_proved(name):
    """The last joint's place against the sum of the lengths, from both sides of it."""
    algebra = ALGEBRAS[name]
    chain = arm(UR5, algebra)
    own = chain.parameters.tool[:3]
    lengths = np.linalg.norm(chain.parameters.joints[:, :3], axis=-1)
    assert np.isclose(chain.reach, lengths.sum() + np.linalg.norm(own))
    rng = np.random.default_rng(5)
    for share, beyond in ((1 - 1e-6, False), (1 + 1e-6, True), (3.0, True), (1e6, True)):
        way = rng.normal(size=(50, 3))
        way[:, 2] *= 0.01  # along the first axis the bound is lower
        way *= share * lengths.sum() / np.linalg.norm(way, axis=1)[:, None]
        turns = algebra.rotor(rng.normal(size=(50, 3)), rng.uniform(0, 3, 50))
        home = algebra.matrix(chain.tool)[:3, :3]
        ends = np.einsum("nij,jk,k->ni", algebra.matrix(turns)[:, :3, :3], home.T, own)
        targets = algebra.translator(way + chain.parameters.base + ends) * turns
        assert (proved(chain, targets) == beyond).all()
        if beyond:
            assert (chain.inverse(targets.as_kind("motor")).status == bs.Status.UNREACHABLE).all()
    long = Chain(revolute_axis([[0, 0, 0], [1, 0, 0], [1.2, 0, 0]], [[0, 0, 1], [0, 1, 0], [1, 0, 0]], algebra))
    hollow = algebra.translator(np.outer([0.0, 0.5, 0.79, 0.9, 1.1], [0, 1, 0]))
    at_wrist = Chain(long.axes, algebra.translator([1.2, 0, 0]).as_kind("motor"))
    assert proved(at_wrist, hollow)[:3].all()


def test_heights_and_turns_of_parallel_axes():
    up = [0, 0, 1.0]
    axes = [revolute_axis(p, up) for p in ([0, 0, 0], [0.3, 0, 0], [0.55, 0, 0])]
    tool = bs.cga3d.translator([0.55, 0, -0.1])
    slide = prismatic_axis([0, 0, -1])
    for limits, lowest in ((None, -np.inf), ([[-3, 3], [-3, 3], [0, 0.4], [-3, 3]], -0.5)):
        scara = Chain([axes[0], axes[1], slide, axes[2]], tool, limits=limits)
        heights = np.array([-30.0, -0.5 - 1e-6, -0.5 + 1e-6, -0.1, 0.3 - 1e-6])
        low = bs.cga3d.translator(np.stack([np.full(5, 0.4), np.zeros(5), heights], -1)).as_kind("motor")
        assert proved(scara, low).tolist() == (heights < lowest).tolist()
        tilted = low * bs.cga3d.rotor([1, 0, 0], 1e-3)
        assert proved(scara, tilted).all()
        assert not proved(scara, tilted, tolerance=1e-2)[heights > lowest].any()
    shoulder = Chain([*axes, revolute_axis([0.7, 0, 0], [0, 1, 0])], bs.cga3d.translator([0.8, 0, 0]))
    aside = bs.cga3d.translator([[0.5, 0, 0.11], [0.5, 0, 0.0]]).as_kind("motor")
    assert proved(shoulder, aside).tolist() == [True, False]  # the last axis keeps its height
    gantry = Chain([prismatic_axis(a) for a in np.eye(3)], limits=[[-1, 1]] * 3)
    corners = bs.cga3d.translator([[1, 1, 1.0], [0.2, 0.1, -1], [1, 1, 1.001], [-2, 0, 0]]).as_kind("motor")
    assert gantry.inverse(corners, attempts=2).status.tolist() == [0, 0, 4, 4]
    assert proved(gantry, bs.cga3d.rotor([[0, 0, 1]], 0.1)).all()


@pytest.mark.parametrize("name", ALGEBRAS)
@pytest.mark.parametrize("seed", range(30))
def test_poses_of_any_chain_are_never_proved_away(name, seed):
    """Turns, slides and screws, some parallel, with and without limits, far from the origin, poses at all limits."""
    algebra, rng = ALGEBRAS[name], np.random.default_rng(seed)
    count = int(rng.integers(1, 8))
    base = rng.normal(size=3) * 10.0 ** rng.integers(-2, 4)
    kinds = rng.integers(0, 3, count)
    ways = np.where(rng.random((count, 1)) < 0.5, np.eye(3)[2], rng.normal(size=(count, 3)))
    places = base + np.cumsum(rng.normal(size=(count, 3)) * rng.choice([0, 0.3, 2.0], (count, 1)), 0)
    made = [
        [revolute_axis(p, w, algebra), prismatic_axis(w, algebra), screw_axis(p, w, 0.2, algebra)][k]
        for k, p, w in zip(kinds, places, ways, strict=True)
    ]
    tool = algebra.translator(places[-1] + rng.normal(size=3)) * algebra.rotor(rng.normal(size=3), 1.0)
    limits = np.sort(rng.normal(size=(count, 2)) * 3, -1)
    chain = Chain(made, tool.as_kind("motor"), limits=limits)
    low, high = limits.T
    q = low + (high - low) * rng.choice([0, 1, 0.5, 0.1], (3000, count))
    targets = chain.forward(q)
    assert not proved(chain, targets, 0.0).any()
    free = Chain(made, tool.as_kind("motor"))
    assert not proved(free, free.forward(q * 50), 0.0).any()


def test_a_target_that_is_no_motion_is_not_called_unreachable():
    chain = arm(UR5)
    motors = chain.forward(np.full((2, 6), 0.3)).values.copy()
    motors[0] *= 0.3
    assert not proved(chain, bs.cga3d.wrap(bs.cga3d.kind("motor"), motors)).any()


def bars(lengths, algebra=bs.cga3d):
    """Bars along x, hinged one to the next, about z and y in turn."""
    ends = np.cumsum([0, *lengths])
    m = Mechanism(["ground", *(f"bar{i}" for i in range(len(lengths)))], "ground")
    for i, (x, name) in enumerate(zip(ends, m.moving, strict=False)):
        at, way = [x, 0, 0], np.eye(3)[2 - i % 2]
        axis = algebra.line(at, way) if algebra is bs.pga3d else algebra.circle(at, way, 0.1)
        point = algebra.point(at) if algebra is bs.pga3d else None
        m.add(Revolute("ground" if not i else m.moving[i - 1], name, axis, point), f"q{i}")
    return m, ends[-1]


@pytest.mark.slow
@pytest.mark.parametrize("name", ALGEBRAS)
def test_what_lengths_of_a_mechanism_prove(name):
    """Of poses that there are nothing; of what is beyond all bars, by little, all of it."""
    m, whole = bars([1.0, 0.7, 0.4], ALGEBRAS[name])
    q = np.random.default_rng(2).uniform(-3, 3, (200, 3))
    q[::4] = np.round(q[::4])
    poses = m.solve_pose({f"q{i}": q[:, i] for i in range(3)})
    assert not poses.status.any()
    tip = (poses["bar2"] >> m.algebra.point([whole, 0, 0])).parameters().xyz
    driven = {i: q[:, i : i + 1] for i in range(3)}
    place = lambda x: (x - m.frame.center) / m.frame.unit  # noqa: E731
    for count in range(4):
        some = {i: driven[i] for i in range(count)}
        assert not is_too_far(m, some, [(2, np.array([whole, 0, 0]), place(tip))], 200).any()
        assert not is_too_far(m, some, [(2, None, poses.own[:, 2])], 200).any()
    hinge = (poses["bar0"] >> m.algebra.point([1.0, 0, 0])).parameters().xyz
    for share, beyond in ((1 - 1e-6, False), (1 + 1e-6, True)):
        way = np.random.default_rng(3).normal(size=(200, 3))
        way *= share / np.linalg.norm(way, axis=1)[:, None]
        aims = [(2, np.array([whole, 0, 0]), place(2.1 * way))]
        assert (is_too_far(m, {}, aims, 200) == beyond).all()
        aims = [(2, np.array([whole, 0, 0]), place(hinge + 1.1 * way))]
        assert (is_too_far(m, {0: driven[0]}, aims, 200) == beyond).all()


@pytest.mark.slow
def test_a_search_that_rests_proves_nothing():
    """Two bars, stretched: a place between them has no slope, and they reach it folded."""
    m = Mechanism(["ground", "upper", "fore"], "ground")
    for a, b, x in (("ground", "upper", 0), ("upper", "fore", 1)):
        m.add(Revolute(a, b, bs.cga3d.circle([x, 0, 0], [0, 0, 1], 0.1)), f"of {b}")
    found = m.solve_pose(targets={"fore": ([2.0, 0, 0], [[1.0, 0, 0], [2.1, 0, 0]])})
    assert found.status.tolist() == [bs.Status.NOT_CONVERGED, bs.Status.UNREACHABLE]
    folded = m.solve_pose({"of upper": np.pi / 3, "of fore": -2 * np.pi / 3})
    np.testing.assert_allclose((folded["fore"] >> bs.cga3d.point([2, 0, 0])).parameters().xyz, [1, 0, 0], atol=1e-12)


@pytest.mark.parametrize("far", [1.0, 100.0, 1e4, 1e8])
def test_slides_without_limits_go_far(far):
    x, y, z = np.eye(3)
    for axes in ([x], [x, x], [x, y], [x, y, z], [x, x + 0.3 * y]):
        found = Chain([prismatic_axis(a) for a in axes]).inverse(bs.cga3d.translator([far, 0, 0]))
        assert found.status == bs.Status.OK and found.distance < 1e-12 + 1e-15 * far
        np.testing.assert_allclose(found.q @ axes, [far, 0, 0], rtol=1e-14, atol=1e-14 * far)
        assert found.steps < 20
    rail = Chain([prismatic_axis(x), revolute_axis([0, 0, 0], z)], bs.cga3d.translator([0.5, 0, 0]).as_kind("motor"))
    q = np.array([min(far, 1e4), 1.0])
    found = rail.inverse(rail.forward(q))
    assert found.status == bs.Status.OK
    np.testing.assert_allclose(found.q, q, rtol=1e-13, atol=1e-11)
