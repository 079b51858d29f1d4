"""One pose in a call: the same as in a batch, and what is not as usual is said as there."""

import threading

import numpy as np
import pytest

from bladesmith import Status
from bladesmith import cga3d as cga
from bladesmith import kinematics as kin
from bladesmith.codegen.errors import BladesmithError, InputError
from bladesmith.kinematics.mechanism.poses import item

from ...support.kinematics import ALGEBRAS, AXIS, FourBar, four_bar, hinge, slide, twist
from ...support.mechanisms.poses import BAR, MOTORS, START, THETA, bar, delta, moved

pytestmark = pytest.mark.filterwarnings("error")


@pytest.fixture
def short(monkeypatch):
    """How many calls took the short way."""
    taken = []
    call = item.PosePlan.__call__
    monkeypatch.setattr(item.PosePlan, "__call__", lambda *a: (taken.append(call(*a)), taken[-1])[1])
    return taken


def assert_same(one, many, k):
    np.testing.assert_array_equal(one.own, many.own[k])
    np.testing.assert_array_equal(one.residual, many.residual[k])
    assert type(one.residual) is np.ndarray and one.residual.shape == one.shape == ()
    assert one.status == many.status[k] and type(one.status) is Status


@pytest.mark.compiles
@pytest.mark.parametrize("algebra", ALGEBRAS)
@pytest.mark.parametrize("has_start", [False, True])
def test_the_bits_of_a_batch(algebra, has_start, short):
    m = bar(algebra)
    start = m.solve_pose({"a": 0.4}) if has_start else None
    theta = np.array([0.4, 0.4001, 0.0, -1.3, 2.0, 0.4 + 2 * np.pi, 0.3 - 4 * np.pi, 1e-9, 80.0])
    many = m.solve_pose({"a": theta}, start=start)
    assert not many.status.any()
    del short[:]
    for k, value in enumerate(theta.tolist()):
        assert_same(m.solve_pose({"a": value}, start=start), many, k)
        assert_same(m.solve_pose({m.joints[0]: np.float64(value)}, start=start, strict=True), many, k)
    assert len(short) == 2 * len(theta) and None not in short


def test_it_counts_from_the_start_by_whole_turns():
    m = bar()
    start = m.solve_pose({"a": 3.0})
    for turns in (-2, 1, 5):
        there = m.solve_pose({"a": 3.1 + 2 * np.pi * turns}, start=start)
        np.testing.assert_allclose(there.own, m.solve_pose({"a": 3.1}, start=start).own, atol=1e-13)
    np.testing.assert_allclose(there.coordinates("a"), [3.1], atol=1e-12)


def test_what_is_driven_slides_or_is_several(short):
    places = cga.line([0, 0, 0], [1, 0, 0]), cga.plane(AXIS, 0)
    guide = kin.Prismatic("ground", "cart", *places)
    lift = kin.Prismatic("cart", "hook", cga.line([0, 0, 0], AXIS), cga.plane([1, 0, 0], 0))
    m = kin.Mechanism(["ground", "cart", "hook"], "ground", [guide, lift])
    many = m.solve_pose({guide: np.array([0.5, 12.0]), lift: np.array([-7.0, 1e-9])})
    assert_same(m.solve_pose({lift: -7.0, guide: 0.5}), many, 0)  # in any order
    assert_same(m.solve_pose({guide: 12.0, lift: 1e-9}), many, 1)
    assert None not in short and len(short) == 2
    hook = moved(m.solve_pose({guide: 0.5, lift: -7.0}), "hook", [0, 0, 0])
    np.testing.assert_allclose(np.abs(hook), [0.5, 0, 7], atol=1e-14)


def test_a_joint_that_is_added_is_seen():
    first = hinge("ground", "a", [0, 0, 0], AXIS)
    m = kin.Mechanism(["ground", "a", "b"], "ground", [first])
    m.add(hinge("a", "b", [1, 0, 0], AXIS), "elbow")
    assert m.solve_pose({first: 0.5, "elbow": 0.0}).status == Status.OK
    m.couple({"elbow": 1, first: -2})
    np.testing.assert_allclose(m.solve_pose({first: 0.5}).coordinates("elbow"), [1.0], atol=1e-14)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 1e300])
def test_numbers_that_are_none(value):
    m = bar()
    for start in (None, m.solve_pose({"a": 0.1})):
        one, many = m.solve_pose({"a": value}, start=start), m.solve_pose({"a": np.array([value])}, start=start)
        assert_same(one, many, 0)
        assert np.isfinite(value) or (one.status == Status.INVALID and np.isnan(one.own).all())


def test_bars_that_do_not_reach(short):
    m = four_bar(FourBar(ground=3.0, crank=2.0, coupler=1.5, rocker=2.0).places(0.3))
    theta = np.array([0.1, 2.5, -0.2, 1.9])  # the crank cannot go round
    many = m.solve_pose({"a": theta})
    assert [s == Status.OK for s in many.status] == [True, False, True, False]
    for k, value in enumerate(theta.tolist()):
        assert_same(m.solve_pose({"a": value}), many, k)
    assert [x is None for x in short] == [False, True, False, True]
    with pytest.raises(BladesmithError):
        m.solve_pose({"a": 2.5}, strict=True)
    assert m.solve_pose({"a": 0.1}, start=m.solve_pose({"a": 2.5})).status == Status.INVALID


def test_bad_input():
    m, other = bar(), four_bar(BAR.places(START))
    good = m.solve_pose({"a": 0.1})
    for bad in ({"b b": 0.1}, {"a": "x"}, {"a": None}, {"a": 0.1, m.joints[0]: 0.1}, {1: 0.1}, {other.joints[0]: 0.1}):
        with pytest.raises(BladesmithError):
            m.solve_pose(bad, start=good)
    with pytest.raises(InputError, match="another mechanism"):
        m.solve_pose({"a": 0.1}, start=other.solve_pose({"a": 0.1}))
    for name, value in (("strict", 1), ("threads", 0), ("path", True)):
        with pytest.raises(BladesmithError):
            m.solve_pose({"a": 0.1}, start=good, **{name: value})
    good.own = good.own[:2]
    with pytest.raises((BladesmithError, ValueError)):
        m.solve_pose({"a": 0.1}, start=good)


def test_threads_have_arrays_of_their_own():
    m = bar()
    theta = np.linspace(-1, 1, 40)
    expected, found = m.solve_pose({"a": theta}), {}

    def work(part):
        for k in part:
            found[k] = m.solve_pose({"a": float(theta[k])})

    threads = [threading.Thread(target=work, args=(range(i, 40, 4),)) for i in range(4)]
    for t in threads:
        t.start()
    for t in threads:
        t.join()
    for k, one in found.items():
        assert_same(one, expected, k)
    assert len(found) == 40


# -- Jacobians ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("method", ["elimination", "general"])
def test_jacobians_have_the_bits_of_a_batch(method):
    robot, m = delta()
    q = np.random.default_rng(7).uniform(-0.3, 0.3, (5, 3))
    poses = m.solve_pose({name: q[:, i] for i, name in enumerate(MOTORS)})
    place, along = robot.place(THETA), twist(m.algebra, slide(np.eye(3)))
    requests = [
        (MOTORS, [("platform", place)]), (list(m.joints[:3]), ["platform", "motor_1"]),
        ([MOTORS[2], MOTORS[0], MOTORS[1]], [("platform", place), ("upper_1", place + 1)]),
        (("platform", along), MOTORS), (("platform", 2 * along), MOTORS[::-1]),
    ]  # fmt: skip
    for inputs, outputs in requests:
        values, status = m.jacobian(inputs, outputs, poses=poses, method=method, status=True)
        assert not status.any()
        for k in range(len(q)):
            one = kin.Poses(m, poses.own[k], np.zeros(()), np.zeros((), np.uint8))
            for _ in range(2):  # the second from what the first has prepared
                found, code = m.jacobian(inputs, outputs, poses=one, method=method, status=True)
                np.testing.assert_array_equal(found, values[k])
                assert code == Status.OK and code.shape == () and code.dtype == np.uint8
    doubled = m.jacobian(("platform", 2 * along), MOTORS, poses=one)
    np.testing.assert_allclose(doubled, 2 * m.jacobian(("platform", along), MOTORS, poses=one), rtol=1e-12)


def test_jacobians_that_are_none(monkeypatch):
    m = four_bar([[0, 0, 0], [1.0, 0, 0], [3, 0, 0], [2.5, 0, 0]])  # stretched: the rocker may go either way
    one, many = (m.solve_pose({"a": x}) for x in (0.0, np.zeros(1)))
    _, expected = m.jacobian("a", "rocker", poses=many, status=True)
    _, code = m.jacobian("a", "rocker", poses=one, status=True)
    assert code == expected[0] != Status.OK
    with pytest.raises(BladesmithError):
        m.jacobian("a", "rocker", poses=one)
    good = bar()
    at, other = good.solve_pose({"a": 0.1}), good.solve_pose({"a": 0.2})
    assert good.jacobian("a", "rocker", poses=at).shape == (6, 1)
    wrong = [
        (m.joints[0], "rocker"), ("a", "nobody"), ("a", []), (["a", "a"], "rocker"), ("d", "rocker"),
        ("a", ("rocker", [0, 0])), ("a", "ground"),
    ]  # fmt: skip
    for inputs, outputs in wrong:
        for _ in range(2):
            with pytest.raises(BladesmithError):
                good.jacobian(inputs, outputs, poses=at)
    with pytest.raises(BladesmithError):
        good.jacobian("a", "rocker", poses=at, threads=0)
    open_ = kin.Poses(good, np.stack([*at.own[:2], other.own[2]]), np.zeros(()), np.zeros((), np.uint8))
    assert good.jacobian("a", "rocker", poses=open_, status=True)[1] != Status.OK


def test_plans_are_few(monkeypatch):
    m = four_bar(BAR.places(START))
    at = m.solve_pose({"a": 0.1})
    for k in range(3 * item.MOST_PLANS):
        point = np.array([k, 1.0, 0.0])
        found = m.jacobian("a", ("crank", point), poses=at)
        np.testing.assert_allclose(found[:, 0], np.cross(AXIS, moved(at, "crank", point)), atol=1e-10)
    assert len(m.jacobian_plans) <= item.MOST_PLANS and len(m.drivers) == 2
    assert len(m.pose_plans) == 1, "those of poses stay, however many points there are"


def test_joints_may_have_any_names():
    """Names that read like what is asked of a Jacobian."""
    m = kin.Mechanism(["ground", "x", "y", "z"], "ground")
    names = ("first", "second", "elimination")
    for k, (a, b) in enumerate((("ground", "x"), ("x", "y"), ("y", "z"))):
        m.add(hinge(a, b, [k, 0, 0], AXIS), names[k])
    for _ in range(2):
        poses = m.solve_pose(dict.fromkeys(names, 0.1))
        assert m.jacobian("first", "second", poses=poses, strict=False).shape == (1, 1)  # free: not determined


def test_motors_in_single_precision(short):
    m = bar()
    start = m.solve_pose({"a": 0.1})
    rounded = start.own.astype(np.float32)
    start.own = rounded.astype(float)
    expected = m.solve_pose({"a": 0.2}, start=start), m.solve_pose({"a": np.array([0.2])}, start=start)
    start.own = rounded
    for value, wanted in zip((0.2, np.array([0.2])), expected, strict=True):
        found = m.solve_pose({"a": value}, start=start)
        assert np.all(found.status == Status.OK)
        np.testing.assert_array_equal(found.own, wanted.own)
