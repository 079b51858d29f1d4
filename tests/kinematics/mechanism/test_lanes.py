"""Batches of poses and Jacobians several at a time: the bits of single items, also where items part."""

import numpy as np
import pytest

from bladesmith import Status
from bladesmith import kinematics as kin
from bladesmith.codegen.build import extension
from bladesmith.codegen.targets.c.instances import BY_TAG
from bladesmith.kinematics.mechanism import driver, loop_calls

from ...support.kinematics import ALGEBRAS, FourBar, four_bar
from ...support.mechanisms.poses import BAR, MOTORS, START, delta, held_by
from ...support.targets.lanes import TAGS

pytestmark = [
    pytest.mark.filterwarnings("error"), pytest.mark.compiles,
    pytest.mark.skipif(extension.compiler() is None, reason="no C compiler"),
]  # fmt: skip
WIDE = [tag for tag in TAGS if BY_TAG[tag].wide]
MANY = 53  # of four lanes and of eight some are left over


def outcome(found):
    """All numbers of poses, or of Jacobians and their statuses."""
    return (found.own, found.residual, np.asarray(found.status)) if isinstance(found, kin.Poses) else found


def assert_same_bits(monkeypatch, mechanism, run):
    """One by one, and by each instance; what one by one gives."""
    monkeypatch.setattr(driver, "WIDE_STEPS", 1 << 60)
    expected = run()
    monkeypatch.setattr(driver, "WIDE_STEPS", 1)
    for tag in WIDE:
        monkeypatch.setattr(loop_calls, "best_instances", lambda _, tag=tag: (BY_TAG[tag],))
        mechanism._forget()
        found = run()
        if isinstance(found, kin.Poses):
            (plan,) = mechanism.drivers.values()
            assert {key[1]: call.lanes for key, call in plan._calls.items()} == {True: int(BY_TAG[tag].bytes) // 8}
        for a, b in zip(outcome(found), outcome(expected), strict=True):
            np.testing.assert_array_equal(a, b, err_msg=tag)
    mechanism._forget()
    return expected


@pytest.mark.parametrize("algebra", ALGEBRAS)
def test_a_four_bar_that_often_does_not_reach(monkeypatch, algebra):
    m = four_bar(FourBar(3.0, 2.0, 2.5, 1.0).places(1.0), ALGEBRAS[algebra])
    limit = np.arccos((4 + 9 - 3.5**2) / 12) - 1.0  # where the bars are stretched
    theta = np.random.default_rng(0).uniform(-2.5, 2.0, MANY)
    theta[:9] = 0.0, 1e-15, 0.1, np.nan, limit, limit * (1 + 1e-15), limit + 1e-9, 1e300, np.inf
    found = assert_same_bits(monkeypatch, m, lambda: m.solve_pose({"a": theta}))
    counts = [int(np.sum(found.status == s)) for s in (Status.OK, Status.UNREACHABLE, Status.INVALID)]
    assert min(counts[:2]) > 10 and counts[2] >= 2
    nearby = np.where(np.isfinite(theta), theta, 0.0) + np.random.default_rng(1).uniform(-0.2, 0.2, MANY)
    assert_same_bits(monkeypatch, m, lambda: m.solve_pose({"a": nearby}, start=found))


def test_paths(monkeypatch):
    m = four_bar(BAR.places(START))
    theta = np.linspace(0, 3.0, 23) * np.linspace(-3, 3, 11)[:, None] ** 3  # each as fast as it likes
    theta[4, 7:9] = np.nan
    found = assert_same_bits(monkeypatch, m, lambda: m.solve_pose({"a": theta}, path=True, threads=2))
    assert (found.status == Status.OK).sum() > 200 and (found.status == Status.INVALID).sum() == 2
    start = m.solve_pose({"a": theta[:, :1] + 0.1})
    assert_same_bits(monkeypatch, m, lambda: m.solve_pose({"a": theta}, start=start, path=True))


def test_targets_near_and_out_of_reach(monkeypatch):
    robot, m = delta()
    rng = np.random.default_rng(2)
    place = robot.place(np.array([0.3, 0.5, 0.1]))
    ends = place + rng.normal(size=(MANY, 3)) * np.repeat([0.02, 0.2, 3.0], 18)[:MANY, None]
    found = assert_same_bits(monkeypatch, m, lambda: m.solve_pose(targets={"platform": (place, ends)}))
    assert len(np.unique(found.status)) > 1
    near = m.solve_pose({name: rng.uniform(-0.3, 0.3, MANY) for name in MOTORS})
    assert_same_bits(monkeypatch, m, lambda: m.solve_pose(targets={"platform": near["platform"]}, start=near))


@pytest.mark.parametrize("kind", ["spherical", "cylindrical", "universal", "on a plane"])
def test_joints_of_several_freedoms(monkeypatch, kind):
    m = held_by(kind)
    to = np.random.default_rng(3).normal(size=(MANY, 3))
    assert_same_bits(monkeypatch, m, lambda: m.solve_pose(targets={"x": ([1, 2, 3], to)}))


@pytest.mark.parametrize("method", ["elimination", "general"])
def test_jacobians_at_regular_and_singular_poses(monkeypatch, method):
    robot, m = delta()
    rng = np.random.default_rng(4)
    q = rng.uniform(-0.35, 0.5, (MANY, 3))
    q[::7] = -0.3, -0.5, -0.1  # its own pose moved back: alike angles
    poses = m.solve_pose({name: q[:, i] for i, name in enumerate(MOTORS)})
    poses.own[5], poses.own[6, 0] = np.nan, 2 * poses.own[6, 0]
    place = robot.place(np.array([0.3, 0.5, 0.1]))
    for inputs, outputs in ((MOTORS, [("platform", place), "rod_0"]), (MOTORS[:2], ["platform"]), ("platform", MOTORS)):
        if inputs == "platform" and method == "general":
            continue
        values = assert_same_bits(
            monkeypatch, m,
            lambda i=inputs, o=outputs: m.jacobian(i, o, poses=poses, method=method, status=True, strict=False),
        )  # fmt: skip
        assert len(np.unique(np.asarray(values[1]))) > 1
    stretched = four_bar([[0, 0, 0], [1.0, 0, 0], [3, 0, 0], [2.5, 0, 0]])
    at = stretched.solve_pose({"a": np.zeros(MANY)})
    assert_same_bits(
        monkeypatch, stretched, lambda: stretched.jacobian("a", "rocker", poses=at, status=True, strict=False)
    )
