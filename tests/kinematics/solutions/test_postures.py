"""All postures of arms: each reaches its pose, and none that a search from many starts finds is missing."""

import copy

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import kinematics
from bladesmith.errors import InputError, SingularError
from bladesmith.kinematics.serial.axes import prismatic_axis, revolute_axis
from bladesmith.kinematics.serial.chain import Chain

from ...support.mechanisms.chains import ALGEBRAS, UP, arm

BAR = 1e-10
TURN = 2 * np.pi


def apart(a, b):
    """Largest difference of angles, modulo a turn."""
    difference = a - b
    return np.abs(difference - TURN * np.round(difference / TURN)).max(-1)


def axes(seed, kind):
    """Six axes: of any sort, or special ones."""
    rng = np.random.default_rng(seed)
    p, d = rng.normal(size=(6, 3)), rng.normal(size=(6, 3))
    if kind == "wrist":
        p[3:] = p[3]
    elif kind == "shoulder":
        p[:3] = p[0]
    elif kind == "parallel 2, 3, 4":
        d[1:4] = d[1] * np.array([[1], [-1], [2]])
    elif kind == "parallel 3, 4, 5":
        d[2:5] = d[2]
    elif kind == "parallel 1, 2, 3":
        d[:3] = d[0]
    elif kind == "pairs meet":
        p[1], p[4] = p[0], p[5]
    elif kind == "right angles":
        d = np.eye(3)[[2, 1, 1, 0, 1, 0]]
    return p, d


METHODS = {
    "any": "elimination", "wrist": "wrist", "shoulder": "wrist", "parallel 2, 3, 4": "parallel",
    "parallel 3, 4, 5": "parallel", "parallel 1, 2, 3": "elimination", "pairs meet": "elimination",
    "right angles": "elimination",
}  # fmt: skip


def numeric_postures(chain, pose, starts):
    """Postures that Newton's method finds from many starts, without limits."""
    free = copy.copy(chain)
    free.limits, free.searches = np.tile([-np.inf, np.inf], (6, 1)), {}
    many = chain.algebra.wrap(pose.kind, np.tile(pose.values, (len(starts), 1)))
    found, status = free.inverse(many, starts, attempts=1)
    return found[status == bs.Status.OK]


def assert_complete(chain, q, starts, seed=0):
    """All of q, and what is found from random starts, is listed; and what is listed reaches the pose."""
    poses = chain.forward(q)
    found = chain.all_solutions(poses)
    assert found.q.shape[1] == found.count.max() <= 16 and not found.status.any() and not found.singular.any()
    for i in range(len(q)):
        count = found.count[i]
        listed = found.q[i, :count]
        assert np.isfinite(listed).all() and np.isnan(found.q[i, count:]).all()
        reached = chain.algebra.matrix(chain.forward(listed))
        off = np.abs(reached - chain.algebra.matrix(poses[i]))
        assert off[:, :3, :3].max() < BAR and off[:, :3, 3].max() < BAR * chain.length
        assert found.angle[i, :count].max() < BAR and found.distance[i, :count].max() < BAR * chain.length
        begin = np.random.default_rng(seed + i).uniform(-np.pi, np.pi, (starts, 6))
        for known in (q[i : i + 1], numeric_postures(chain, poses[i], begin)):
            for x in known:
                assert apart(listed, x).min() < 1e-6
        between = apart(listed[:, None], listed[None]) + 9 * np.eye(count)
        assert between.min() > 1e-7
    return found


@pytest.mark.compiles
@pytest.mark.parametrize("kind", METHODS)
@pytest.mark.parametrize("algebra", ALGEBRAS, ids=lambda a: a.name)
def test_every_posture_is_listed(algebra, kind):
    for seed in range(3):
        p, d = axes(seed, kind)
        chain = Chain(revolute_axis(p, d, algebra), algebra.translator([0.3, 0.2, 0.1]))
        q = np.random.default_rng(seed).uniform(-np.pi, np.pi, (6, 6))
        assert assert_complete(chain, q, 200).method == METHODS[kind]


@pytest.mark.slow
@pytest.mark.parametrize("kind", METHODS)
def test_none_of_many_is_missing(kind):
    for seed in range(4):
        p, d = axes(100 + seed, kind)
        chain = Chain(revolute_axis(p, d))
        q = np.random.default_rng(seed).uniform(-np.pi, np.pi, (300, 6))
        found = chain.all_solutions(chain.forward(q))
        assert max(apart(found.q[i, : found.count[i]], q[i]).min(initial=9) for i in range(300)) < 1e-6


@pytest.mark.compiles
@pytest.mark.parametrize("kind", ["wrist", "parallel 2, 3, 4", "parallel 3, 4, 5"])
def test_closed_forms_and_elimination_agree(kind):
    p, d = axes(5, kind)
    chain = Chain(revolute_axis(p, d))
    poses = chain.forward(np.random.default_rng(1).uniform(-3, 3, (20, 6)))
    closed, general = chain.all_solutions(poses), chain.all_solutions(poses, method="elimination")
    assert np.array_equal(closed.count, general.count)
    for i, count in enumerate(closed.count):
        assert all(apart(general.q[i, :count], x).min() < 1e-8 for x in closed.q[i, :count])


@pytest.mark.compiles
def test_an_arm_of_sixteen_postures():
    """Manseur and Doty's: the numbers of its table, and the pose where all joints are at these angles."""
    small = np.deg2rad(1)
    rows = np.array([
        [0.3, np.pi / 2, 0, 0], [1, small, 0, 0], [0, np.pi / 2, 0.2, 0], [1.5, small, 0, 0], [0, np.pi / 2, 0, 0],
        [0, 0, 0, 0],
    ])  # fmt: skip
    chain = Chain.from_dh(rows)
    q = np.random.default_rng(3).uniform(-np.pi, np.pi, (400, 6))
    found = chain.all_solutions(chain.forward(q))
    assert found.count.max() == 16 and (found.count % 2 == 0).all()
    best = int(found.count.argmax())
    assert_complete(chain, q[best : best + 1], 2000)


@pytest.mark.compiles
def test_any_size_and_place():
    p, d = axes(2, "any")
    q = np.random.default_rng(2).uniform(-np.pi, np.pi, (5, 6))
    plain = Chain(revolute_axis(p, d))
    expected = plain.all_solutions(plain.forward(q))
    for scale, center in ((1e-3, 0.0), (1e3, 0.0), (1.0, 1e3)):
        chain = Chain(revolute_axis(center + scale * p, d), bs.cga3d.translator(np.full(3, center)))
        found = chain.all_solutions(chain.forward(q))
        assert np.array_equal(found.count, expected.count)
        assert np.nanmax(np.abs(found.q - expected.q)) < 1e-8


@pytest.mark.compiles
def test_postures_are_within_limits():
    chain = kinematics.load_urdf(kinematics.urdf_example("arm")).chain("flange")
    q = np.array([0.3, -0.5, 0.8, 0.2, 0.4, -0.3])
    free = arm_without_limits(chain).all_solutions(chain.forward(q))
    found = chain.all_solutions(chain.forward(q))
    assert 0 < found.count <= free.count == 8
    low, high = chain.limits.T
    kept = found.q[: found.count]
    assert ((low <= kept) & (kept <= high)).all()
    inside = ((low <= free.q) & (free.q <= high)).all(-1)
    assert inside.sum() <= found.count
    # angles by whole turns: limits far from zero
    far = np.tile([TURN - 3.5, TURN + 3.5], (6, 1))
    shifted = Chain(chain.axes, chain.tool, limits=far).all_solutions(chain.forward(q))
    assert shifted.count == 8 and ((shifted.q >= far[:, 0]) & (shifted.q <= far[:, 1])).all()
    narrow = Chain(chain.axes, chain.tool, limits=np.column_stack([q - 1e-3, q + 1e-3]))
    only = narrow.all_solutions(chain.forward(q))
    assert only.count == 1 and np.abs(only.q[0] - q).max() < 1e-9


def arm_without_limits(chain):
    return Chain(chain.axes, chain.tool)


@pytest.mark.compiles
def test_families_are_said():
    """A stretched wrist, axes 4 and 6 in line; a shoulder, where the wrist's center is on axis 1."""
    chain = arm()
    stretched = chain.all_solutions(chain.forward([0.3, 0.4, 0.5, 0.2, 0.0, 0.1]))
    assert stretched.status == bs.Status.NOT_UNIQUE and stretched.singular.any() and not stretched.singular.all()
    assert stretched.angle[: stretched.count].max() < BAR
    assert chain.all_solutions(chain.forward(np.zeros(6)), strict=True).status == bs.Status.NOT_UNIQUE


@pytest.mark.compiles
def test_poses_without_a_posture():
    chain = arm()
    pose = chain.forward(np.random.default_rng(0).uniform(-2, 2, (4, 6)))
    values = pose.values.copy()
    values[1] = np.nan
    values[2] *= 1.1
    values[3] = (bs.cga3d.translator([9.0, 0, 0]) * pose[3]).as_kind("motor").values
    found = chain.all_solutions(bs.cga3d.wrap(pose.kind, values))
    codes = [bs.Status.OK, bs.Status.INVALID, bs.Status.INVALID, bs.Status.UNREACHABLE]
    assert found.status.tolist() == codes and found.count.tolist() == [8, 0, 0, 0]
    assert found.q.shape == (4, 8, 6) and np.isnan(found.q[1:]).all()
    alone = chain.all_solutions(bs.cga3d.wrap(pose.kind, values[3]))
    with pytest.raises(SingularError, match="all_solutions"):
        chain.all_solutions(bs.cga3d.wrap(pose.kind, values), strict=True)
    assert alone.q.shape == (0, 6) and alone.count == 0 and alone.status == bs.Status.UNREACHABLE
    assert chain.all_solutions(pose[:0]).q.shape == (0, 0, 6)


@pytest.mark.compiles
def test_axes_may_be_scaled():
    """A unit of a coordinate that is not a radian."""
    plain = arm()
    scaled = Chain(2.0 * plain.axes, plain.tool)
    pose = plain.forward(np.random.default_rng(4).uniform(-3, 3, (3, 6)))
    a, b = plain.all_solutions(pose), scaled.all_solutions(pose)
    assert np.array_equal(a.count, b.count)
    for i, count in enumerate(a.count):
        assert np.abs(bs.cga3d.matrix(scaled.forward(b.q[i, :count])) - bs.cga3d.matrix(pose[i])).max() < 1e-12


def test_bad_input():
    chain = arm()
    pose = chain.forward(np.zeros(6))
    with pytest.raises(InputError, match="no closed form 'parallel'"):
        chain.all_solutions(pose, method="parallel")
    with pytest.raises(InputError, match="method"):
        chain.all_solutions(pose, method="guess")
    with pytest.raises(InputError, match="tolerance"):
        chain.all_solutions(pose, tolerance=0)
    with pytest.raises(InputError, match="the pose"):
        chain.all_solutions([1, 2, 3])
    with pytest.raises(InputError, match="six axes, and this chain has 2"):
        Chain(revolute_axis([[0, 0, 0], [1, 0, 0]], UP)).all_solutions(pose)
    slide = Chain([prismatic_axis(UP), *chain.axes[1:]])
    with pytest.raises(InputError, match="joint_1 translates"):
        slide.all_solutions(pose)
