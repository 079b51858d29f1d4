"""Poses of mechanisms, and Jacobians at many of them, against closed forms and 50-digit closures."""

import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from bladesmith import Status
from bladesmith import cga3d as cga
from bladesmith import kinematics as kin
from bladesmith.codegen.errors import BladesmithError, Interrupted, SingularError

from ...support.kinematics import ALGEBRAS, AXIS, FourBar, columns, four_bar, slide, turn, twist
from ...support.mechanisms.poses import BAR, MOTORS, NAN, START, THETA, bar, delta, moved

pytestmark = pytest.mark.filterwarnings("error")


# -- four bars: Freudenstein ---------------------------------------------------------------------------------------


@pytest.mark.compiles
@pytest.mark.parametrize("algebra", ALGEBRAS)
def test_a_crank_turns_a_rocker(algebra):
    m = bar(algebra)
    theta = np.random.default_rng(0).uniform(-np.pi, np.pi, (4, 25))
    poses = m.solve_pose({"a": theta - START})
    assert poses.shape == (4, 25) and not poses.status.any() and poses.residual.max() < 1e-13
    rocker = BAR.rocker_angle(theta) - BAR.rocker_angle(START)
    found = poses.coordinates("d")[..., 0]
    np.testing.assert_allclose(np.exp(1j * found), np.exp(-1j * rocker), atol=1e-12)
    crank = poses.coordinates(m.joints[0])[..., 0]
    np.testing.assert_allclose(np.exp(1j * crank), np.exp(1j * (theta - START)), atol=1e-12)
    ends = np.array([[BAR.places(t)[2] for t in row] for row in theta])
    for body in ("rocker", "coupler"):
        np.testing.assert_allclose(moved(poses, body, BAR.places(START)[2]), ends, atol=1e-12)
    assert (poses["ground"].values == m.algebra.scalar(1.0).as_kind("motor").values).all()


def test_a_path_goes_round():
    m, theta = bar(), np.linspace(START, START + 4 * np.pi, 200)
    poses = m.solve_pose({"a": theta - START}, path=True)
    assert not poses.status.any()
    rocker = BAR.rocker_angle(theta) - BAR.rocker_angle(START)
    np.testing.assert_allclose(np.exp(1j * poses.coordinates("d")[..., 0]), np.exp(-1j * rocker), atol=1e-12)
    turned = poses["crank"].values  # the motor goes on: after one turn it has the other sign
    assert np.abs(np.diff(turned, axis=0)).max() < 0.1
    again = m.solve_pose({"a": theta[100:] - START}, start={b: poses[b][99] for b in m.bodies}, path=True)
    np.testing.assert_allclose(moved(again, "coupler", [0, 0, 0]), moved(poses, "coupler", [0, 0, 0])[100:], atol=1e-12)
    several = m.solve_pose({"a": np.stack([theta, -theta]) - START}, path=True)
    np.testing.assert_array_equal(several["coupler"].values[0], poses["coupler"].values)


def test_batches_and_threads_give_the_same_bits():
    m = bar()
    theta = np.random.default_rng(1).uniform(-2, 2, 40)
    one = m.solve_pose({"a": theta}, threads=1)
    two = m.solve_pose({"a": theta}, threads=2)
    rows = [m.solve_pose({"a": t}) for t in theta]
    for b in m.bodies:
        np.testing.assert_array_equal(one[b].values, two[b].values)
        np.testing.assert_array_equal(one[b].values, [np.broadcast_to(r[b].values, 8) for r in rows])
    j = [m.jacobian("a", "rocker", poses=one, threads=t) for t in (1, 2)]
    np.testing.assert_array_equal(*j)


@pytest.mark.parametrize("scale, centre", [(1e-6, 0), (1e3, 0), (1, 1e4)])
def test_lengths_do_not_matter(scale, centre):
    m = four_bar(BAR.places(START) * scale + centre, radius=scale)
    theta = np.linspace(-3, 3, 20)
    poses = m.solve_pose({"a": theta - START})
    assert not poses.status.any()
    rocker = BAR.rocker_angle(theta) - BAR.rocker_angle(START)
    bar = 1e-12 if not centre else 1e-6
    np.testing.assert_allclose(np.exp(1j * poses.coordinates("d")[..., 0]), np.exp(-1j * rocker), atol=bar)
    place = moved(poses, "coupler", BAR.places(START)[2] * scale + centre)
    np.testing.assert_allclose((place - centre) / scale, [BAR.places(t)[2] for t in theta], atol=bar)


@pytest.mark.parametrize("path", [False, True])
def test_workers_of_an_executor_find_the_same_bits(path, monkeypatch):
    monkeypatch.setattr("bladesmith.kinematics.mechanism.poses.solver.POSES_PER_CALL", 8)
    m, theta, reports = bar(), np.linspace(-0.4, 0.4, 40).reshape(8, 5), []
    here = m.solve_pose({"a": theta}, path=path)
    with ThreadPoolExecutor(2) as pool:
        there = m.solve_pose({"a": theta}, path=path, executor=pool, progress=reports.append)
    for name in ("own", "residual", "status"):
        np.testing.assert_array_equal(getattr(here, name), getattr(there, name))
    assert [p.done for p in reports] == ([5, 10, 15, 20, 25, 30, 35, 40] if path else [8, 16, 24, 32, 40])


class SlowPool(ThreadPoolExecutor):
    """Calls take long enough for the first result to be seen before the last."""

    def submit(self, function, /, *arguments):
        def after_a_while():
            time.sleep(0.1)
            return function(*arguments)

        return super().submit(after_a_while)


@pytest.mark.parametrize("on_workers", [False, True])
def test_an_interrupt_keeps_the_poses_that_were_found(on_workers, monkeypatch):
    def stop(progress):
        raise KeyboardInterrupt

    monkeypatch.setattr("bladesmith.kinematics.mechanism.poses.solver.POSES_PER_CALL", 20)
    m, theta = bar(), np.linspace(-0.4, 0.4, 200)
    whole = m.solve_pose({"a": theta})
    with SlowPool(1) as pool, pytest.raises(Interrupted) as caught:
        m.solve_pose({"a": theta}, threads=1, progress=stop, executor=pool if on_workers else None)
    poses = caught.value.partial
    found = np.isfinite(poses.own).all((-1, -2))
    assert 0 < found.sum() < 200 and (poses.status[~found] == Status.NOT_CONVERGED).all()
    np.testing.assert_array_equal(poses.own[found], whole.own[found])


def test_targets_and_starts():
    m = bar()
    theta = np.linspace(-1, 2.5, 15)
    poses = m.solve_pose({"a": theta - START})
    crank = np.array([BAR.places(t)[1] for t in theta])
    found = m.solve_pose(targets={"crank": (BAR.places(START)[1], crank)})
    assert not found.status.any()
    np.testing.assert_allclose(found.coordinates("a")[..., 0], theta - START, atol=1e-11)
    same = m.solve_pose(targets={"crank": (cga.point(BAR.places(START)[1]), cga.point(crank))})
    np.testing.assert_array_equal(same["coupler"].values, found["coupler"].values)
    # from the other branch, which hangs together with another start
    other = FourBar(branch=-1)
    begin = {"rocker": turned(BAR, other, START), "coupler": coupled(BAR, other, START)}
    assert m.at(begin).residual() < 1e-12
    mirrored = m.solve_pose({"a": theta - START}, start=begin)
    assert not mirrored.status.any()
    np.testing.assert_allclose(
        moved(mirrored, "rocker", BAR.places(START)[2]), [other.places(t)[2] for t in theta], atol=1e-12
    )
    # a start far round: the short way to the same place
    round_ = m.solve_pose({"a": 3.6}, start=m.solve_pose({"a": 3.5}))
    np.testing.assert_allclose(round_["coupler"].values, m.solve_pose({"a": 3.6})["coupler"].values, atol=1e-12)
    onward = m.solve_pose({"a": theta - START}, start=poses)
    np.testing.assert_allclose(onward["coupler"].values, poses["coupler"].values, atol=1e-13)


def turned(first, second, theta):
    """The motor of the rocker from one branch to the other."""
    angle = second.rocker_angle(theta) - first.rocker_angle(theta)
    return (-angle / 2 * twist(cga, turn(AXIS, [3, 0, 0]))).exp()


def coupled(first, second, theta):
    ends = [bar.places(theta) for bar in (first, second)]
    angles = [np.arctan2(*(e[2] - e[1])[1::-1]) for e in ends]
    return (-(angles[1] - angles[0]) / 2 * twist(cga, turn(AXIS, ends[0][1]))).exp()


def test_what_can_not_be_reached():
    m = bar()
    there, away = BAR.places(START)[1], [9.0, 0, 0]
    found = m.solve_pose(targets={"crank": (there, [there, away])})
    assert found.status.tolist() == [Status.OK, Status.UNREACHABLE]
    np.testing.assert_allclose(found.residual[1] * m.frame.unit, 8.0, rtol=1e-3)  # of a crank of length 1
    with pytest.raises(BladesmithError, match="item 1"):
        m.solve_pose(targets={"crank": (there, [there, away])}, strict=True)
    short = FourBar(3.0, 2.0, 2.5, 1.0)  # a crank that does not go round
    rocking = four_bar(short.places(1.0))
    assert rocking.solve_pose({"a": 0.1}).status == Status.OK
    limit = np.arccos((4 + 9 - 3.5**2) / 12)
    found = rocking.solve_pose({"a": np.array([limit - 1e-3, limit + 0.05, 3.0]) - 1.0})
    assert found.status.tolist() == [Status.OK, Status.UNREACHABLE, Status.UNREACHABLE]
    path = rocking.solve_pose({"a": np.array([0.1, 1.5, 0.2])}, path=True)
    assert path.status[[0, 1]].tolist() == [Status.OK, Status.UNREACHABLE]


def test_items_that_are_no_numbers():
    m = bar()
    found = m.solve_pose({"a": [0.1, NAN, 0.2, np.inf]})
    assert found.status.tolist() == [Status.OK, Status.INVALID, Status.OK, Status.INVALID]
    assert np.isnan(found["crank"].values[[1, 3]]).all() and np.isfinite(found["crank"].values[[0, 2]]).all()
    assert np.isnan(found.residual[[1, 3]]).all()
    clean = m.solve_pose({"a": [0.1, 0.2]})
    np.testing.assert_array_equal(found["coupler"].values[[0, 2]], clean["coupler"].values)
    path = m.solve_pose({"a": [NAN, 0.1, NAN, 0.2]}, path=True)
    assert path.status.tolist() == [Status.INVALID, Status.OK, Status.INVALID, Status.OK]
    np.testing.assert_allclose(path["coupler"].values[[1, 3]], clean["coupler"].values, atol=1e-13)
    place = BAR.places(START)[1]
    for targets in (
        {"crank": (place, [place, [NAN, 0, 0]])},
        {"crank": m.algebra.wrap(m.algebra.kind("motor"), np.stack([clean["crank"].values[0], np.full(8, NAN)]))},
    ):
        found = m.solve_pose(targets=targets)
        assert found.status.tolist() == [Status.OK, Status.INVALID]
    values, status = m.jacobian("a", "rocker", poses=m.solve_pose({"a": [0.1, NAN]}), status=True)
    assert status.tolist() == [Status.OK, Status.INVALID] and np.isnan(values[1]).all()
    onward = m.solve_pose({"a": [0.2, 0.2]}, start=m.solve_pose({"a": [0.1, NAN]}))
    assert onward.status.tolist() == [Status.OK, Status.INVALID]
    with pytest.raises(SingularError, match="item 1"):
        m.solve_pose({"a": [0.1, NAN]}, strict=True)


def test_numbers_of_all_sorts_and_none():
    m = bar()
    want = m.solve_pose({"a": [1.0, 0.0]})["coupler"].values
    for given in ([1, 0], np.float32([1, 0]), (True + 0, 0), np.array([1, 0], np.int8), np.array([[1], [0]])[:, 0]):
        np.testing.assert_allclose(m.solve_pose({"a": given})["coupler"].values, want, atol=1e-14)
    empty = m.solve_pose({"a": np.zeros((2, 0))})
    assert empty.shape == (2, 0) and empty["coupler"].shape == (2, 0) and empty.coordinates("a").shape == (2, 0, 1)
    assert m.solve_pose({"a": np.zeros((2, 0))}, path=True).shape == (2, 0)
    assert m.jacobian("a", ["rocker"], poses=empty).shape == (2, 0, 6, 1)
    assert m.solve_pose().shape == () and not m.solve_pose().status


# -- the Delta ------------------------------------------------------------------------------------------------------


@pytest.mark.compiles
@pytest.mark.parametrize(
    "scale, centre, algebra", [(1, 0, "cga"), (1e-6, 0, "cga"), (1e3, 0, "cga"), (1, 1e4, "cga"), (1, 0, "pga")]
)
def test_a_delta(scale, centre, algebra):
    """Forward, inverse by a place and by a pose, and Jacobians by both methods, at many poses."""
    robot, m = delta(scale, centre, algebra)
    q = np.random.default_rng(2).uniform(-0.35, 0.5, (8, 3))
    bar = 1e-12 if not centre else 1e-6
    poses = m.solve_pose({name: q[:, i] for i, name in enumerate(MOTORS)})
    assert not poses.status.any()
    start, ends = robot.place(THETA), np.array([robot.place(THETA + row) for row in q])
    found = moved(poses, "platform", start)
    np.testing.assert_allclose((found - centre) / scale, (ends - centre) / scale, atol=bar)
    assert poses.residual.max() < 1e-13
    for targets in ({"platform": (start, ends)}, {"platform": poses["platform"]}):
        back = m.solve_pose(targets=targets)
        assert not back.status.any()
        np.testing.assert_allclose(np.concatenate([back.coordinates(n) for n in MOTORS], -1), q, atol=10 * bar)
    values = m.jacobian(MOTORS, [("platform", start)], poses=poses)
    slopes = np.array([robot.slope(THETA + row) for row in q])
    np.testing.assert_allclose(values / scale, slopes / scale, atol=10 * bar)
    general = m.jacobian(MOTORS, [("platform", start)], poses=poses, method="general")
    np.testing.assert_allclose(values / scale, general / scale, atol=1e-10 if not centre else 1e-6)
    back = m.jacobian(("platform", twist(m.algebra, slide(np.eye(3)))), MOTORS, poses=poses)
    np.testing.assert_allclose(back @ values, np.broadcast_to(np.eye(3), (8, 3, 3)), atol=10 * bar)
    one = m.at({b: poses[b][3] for b in m.bodies})
    np.testing.assert_allclose(one.jacobian(MOTORS, [("platform", ends[3])]) / scale, slopes[3] / scale, atol=10 * bar)


def test_a_delta_out_of_reach():
    robot, m = delta()
    found = m.solve_pose(targets={"platform": (robot.place(THETA), [[9.0, 0, 0], robot.place(THETA)])})
    assert found.status.tolist() == [Status.UNREACHABLE, Status.OK] and found.residual[0] > 1


def test_jacobians_at_poses_tell_what_is_wrong():
    m = bar()
    d, a, b, c = BAR.lengths
    limit = np.arccos(((a + b) ** 2 + d**2 - c**2) / (2 * (a + b) * d))
    poses = m.solve_pose({"a": np.array([0.0, limit - START])}, path=True)
    values, status = m.jacobian("a", ["b", "rocker"], poses=poses, status=True)
    assert not status.any()
    np.testing.assert_allclose(values[1, 1:], 0, atol=1e-7)
    broken = {"rocker": cga.translator([0, 0, 0.1])}
    for method in ("elimination", "general"):
        _, status = m.jacobian("a", ["b", "rocker"], poses=broken, method=method, status=True)
        assert status == Status.UNREACHABLE
        with pytest.raises(SingularError):
            m.jacobian("a", ["b", "rocker"], poses=broken, method=method)
    slopes = m.jacobian(["a"], ["b", "rocker"], poses=m.solve_pose({"a": np.array([0.3, 1.2])}))
    for k, theta in enumerate((START + 0.3, START + 1.2)):
        rocker = np.linalg.solve(columns(cga), slopes[k, 1:, 0])
        np.testing.assert_allclose(rocker, BAR.slope(theta) * turn(AXIS, [3, 0, 0]), atol=1e-11)


@pytest.mark.compiles
@pytest.mark.parametrize("seed", [3, 6])
def test_seven_hinges_anywhere(seed):
    """They have one freedom: the loop stays closed along it, and Jacobians are its slopes."""
    rng = np.random.default_rng(seed)
    names = [f"b{i}" for i in range(7)]
    places, axes = rng.normal(size=(2, 7, 3))
    m = kin.Mechanism(names, "b0")
    for i in range(7):
        m.add(kin.Revolute(names[i], names[(i + 1) % 7], cga.circle(places[i], axes[i], 1.0)), f"j{i}")
    speeds = np.abs([m.free_motions()[0].speeds[m.loops.offsets[b]] for b in range(6)])
    driven = m.joint_names[m.tree.joint[int(np.argmax(speeds))]]  # the one that goes furthest
    step = 1e-4
    poses = m.solve_pose({driven: np.array([0.05, 0.05 + step, 0.05 - step, 0.02, -0.05])})
    assert not poses.status.any() and poses.residual.max() < 1e-13
    for k in range(5):
        assert m.at({b: poses[b][k] for b in names}).residual() < 1e-10
    others = [n for n in m.joint_names if n != driven and m.find_joint(n) in m.tree.child_of]
    slopes = m.jacobian(driven, others, poses=poses)[0, :, 0]
    found = np.array([poses.coordinates(n)[:, 0] for n in others])
    np.testing.assert_allclose(slopes, (found[:, 1] - found[:, 2]) / (2 * step), rtol=1e-5, atol=1e-5)
    there = m.at({b: poses[b][0] for b in names})
    np.testing.assert_allclose(there.jacobian(driven, others)[:, 0], slopes, atol=1e-9)
