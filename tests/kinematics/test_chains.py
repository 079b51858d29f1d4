"""Serial chains against matrix exponentials of 50 digits, near and far, large and small."""

import pickle
import time
from concurrent.futures import ThreadPoolExecutor

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import bladesmith as bs
from bladesmith.codegen.programs.chains import CLASSES, class_of
from bladesmith.dynamics import screw_coordinates, twist
from bladesmith.errors import AlgebraMismatchError, GradeError, InputError, Interrupted, ShapeError, SingularError
from bladesmith.kinematics.serial.axes import prismatic_axis, revolute_axis, screw_axis
from bladesmith.kinematics.serial.chain import Chain
from bladesmith.status import Status

ALGEBRAS = [bs.cga3d, bs.pga3d]
DIGITS = 50
UP = (0.0, 0.0, 1.0)


def hat(s):
    """The matrix of a twist's six numbers (w, v)."""
    w, v = s[:3], s[3:]
    return mp.matrix([[0, -w[2], w[1], v[0]], [w[2], 0, -w[0], v[1]], [-w[1], w[0], 0, v[2]], [0, 0, 0, 0]])


def oracle(screws, tool, q):
    """exp(q1 S1) ... exp(qn Sn) tool, and what stands before each joint's exponential and behind the last."""
    pose, before = mp.eye(4), []
    for s, x in zip(screws, q, strict=True):
        before.append(pose)
        pose = pose * mp.expm(hat([mp.mpf(float(c)) * mp.mpf(float(x)) for c in s]))
    return pose * mp.matrix(tool.tolist()), [*before, pose]


def columns(screws, before):
    """Twists of the joints where they are, six numbers each: R w, R v + p x R w."""
    found = []
    for s, pose in zip(screws, before, strict=False):
        w, v = (pose[:3, :3] * mp.matrix([mp.mpf(float(c)) for c in part]) for part in (s[:3], s[3:]))
        p = pose[:3, 3]
        cross = [p[1] * w[2] - p[2] * w[1], p[2] * w[0] - p[0] * w[2], p[0] * w[1] - p[1] * w[0]]
        found.append([*w, *(v[k] + cross[k] for k in range(3))])
    return mp.matrix(found).T


def mixed(algebra, seed, count=6, scale=1.0, origin=0.0):
    """A chain of turns, slides and screws, around a place."""
    rng = np.random.default_rng(seed)
    center = origin * np.array([0.6, -0.7, 0.4])
    axes = []
    for i in range(count):
        p, d = center + scale * rng.normal(size=3), rng.normal(size=3)
        kind = rng.integers(4) if i else 0
        axes.append(
            prismatic_axis(d, algebra) if kind == 1
            else screw_axis(p, d, scale * rng.normal(), algebra) if kind == 2
            else revolute_axis(p, d, algebra)
        )  # fmt: skip
    tool = algebra.translator(center + scale * rng.normal(size=3)) * algebra.rotor(rng.normal(size=3), rng.normal())
    chain = Chain(axes, tool)
    q = rng.uniform(-3, 3, (4, count))
    slides = np.abs(np.stack([screw_coordinates(a)[:3] for a in axes])).max(-1) == 0
    q[:, slides] *= scale
    return chain, q


def arm(algebra=bs.cga3d, scale=1.0, center=(0.0, 0.0, 0.0), **options):
    """Six axes, three of them parallel."""
    positions = scale * np.array(
        [[0, 0, 0.1], [0, 0.1, 0.3], [0, 0.1, 0.9], [0.4, 0.1, 0.9], [0.5, 0.1, 0.9], [0.6, 0.1, 0.9]]
    )
    directions = [[0, 0, 1], [0, 1, 0], [0, 1, 0], [1, 0, 0], [0, 1, 0], [1, 0, 0]]
    tool = algebra.translator(np.add(center, scale * np.array([0.7, 0.1, 0.9])))
    return Chain(revolute_axis(np.add(center, positions), directions, algebra), tool, **options)


@pytest.fixture(autouse=True)
def digits():
    with mp.workdps(DIGITS):
        yield


# -- poses ---------------------------------------------------------------------------------------------------


@pytest.mark.compiles
@pytest.mark.parametrize("algebra", ALGEBRAS, ids=lambda a: a.name)
@pytest.mark.parametrize(("scale", "origin"), [(1.0, 0.0), (1.0, 1e4), (1e-6, 0.0), (1e3, 0.0)])
def test_poses_are_products_of_exponentials(algebra, scale, origin):
    for seed in range(3):
        chain, q = mixed(algebra, seed, scale=scale, origin=origin)
        screws = screw_coordinates(chain.axes)
        tool = algebra.matrix(chain.tool)
        found = algebra.matrix(chain.forward(q))
        for x, matrix in zip(q[:2], found, strict=False):
            truth, _ = oracle(screws, tool, x)
            truth = np.array(truth.tolist(), float)
            assert np.abs(matrix[:3, :3] - truth[:3, :3]).max() < 4e-15
            assert np.abs(matrix[:3, 3] - truth[:3, 3]).max() < 4e-14 * (scale + origin)


@pytest.mark.compiles
@given(
    st.lists(
        st.tuples(st.integers(0, 2), *[st.floats(-4, 4)] * 6, st.floats(-7, 7)), min_size=1, max_size=12
    )
)  # fmt: skip
def test_chains_of_any_joints(joints):
    """Against 4x4 matrices of turns and translations, written out."""
    axes, matrix, q = [], np.eye(4), []
    for kind, a, b, c, x, y, z, angle in joints:
        p, d = np.array([a, b, c]), np.array([x, y, z])
        if np.linalg.norm(d) < 1e-3:
            d = np.array(UP)
        u = d / np.linalg.norm(d)
        pitch = (0.0, 0.0, 0.7)[kind]
        axes.append(prismatic_axis(d) if kind == 1 else screw_axis(p, d, pitch) if kind else revolute_axis(p, d))
        own = np.eye(4)
        if kind == 1:
            own[:3, 3] = angle * u
        else:
            k = np.cross(np.eye(3), u)
            own[:3, :3] = np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * k @ k
            own[:3, 3] = p - own[:3, :3] @ p + pitch * angle * u
        matrix, q = matrix @ own, [*q, angle]
    chain = Chain(axes)
    assert np.abs(bs.cga3d.matrix(chain.forward(q)) - matrix).max() < 1e-12
    if len(q) >= 2:
        step = 1e-6
        j = chain.jacobian(q, point=[0.3, -0.2, 0.5])
        ends = [
            (bs.cga3d.matrix(chain.forward(np.add(q, s * step * np.eye(len(q))))) @ [0.3, -0.2, 0.5, 1])[:, :3]
            for s in (1, -1)
        ]
        assert np.abs(((ends[0] - ends[1]) / (2 * step)).T - j[3:]).max() < 1e-6


@pytest.mark.compiles
@pytest.mark.parametrize("algebra", ALGEBRAS, ids=lambda a: a.name)
def test_links_and_their_frames(algebra):
    chain, q = mixed(algebra, 5)
    screws = screw_coordinates(chain.axes)
    _, poses = oracle(screws, np.eye(4), q[0])
    found = algebra.matrix(chain.forward(q, all=True))
    assert found.shape == (4, 6, 4, 4)
    for link, pose in zip(found[0], poses[1:], strict=True):
        assert np.abs(link - np.array(pose.tolist(), float)).max() < 1e-13
    frames = algebra.translator(np.arange(18.0).reshape(6, 3)).as_kind("motor")
    with_frames = Chain(chain.axes, chain.tool, frames=frames).forward(q, all=True)
    assert np.abs(algebra.matrix(with_frames) - found @ algebra.matrix(frames)).max() < 1e-12
    assert (
        np.abs(algebra.matrix(with_frames[:, -1] * ~frames[-1] * chain.tool) - algebra.matrix(chain.forward(q))).max()
        < 1e-12
    )


def test_axes_of_any_length_and_lines():
    line = bs.cga3d.line([0.3, 0.1, 0], [0, 2.0, 1.0])
    unit = revolute_axis([0.3, 0.1, 0], [0, 2.0, 1.0])
    once, thrice = Chain([line]), Chain([3 * unit])
    assert np.abs(once.forward([0.6]).values - Chain([unit]).forward([0.6]).values).max() < 1e-15
    assert np.abs(once.forward([0.6]).values - thrice.forward([0.2]).values).max() < 1e-15
    p_line = bs.pga3d.line([0.3, 0.1, 0], [0, 2.0, 1.0])
    m = bs.pga3d.matrix(Chain([p_line]).forward([0.6]))
    assert np.abs(m - bs.cga3d.matrix(once.forward([0.6]))).max() < 1e-15
    moved = bs.cga3d.matrix(Chain([revolute_axis([1, 0, 0], UP)]).forward([np.pi / 2]))
    assert np.allclose(moved @ [2, 0, 0, 1], [1, 1, 0, 1], atol=1e-15)  # counter-clockwise


@pytest.mark.compiles
def test_a_long_chain_takes_linear_time_and_keeps_its_digits():
    rng = np.random.default_rng(0)
    n = 1000
    places = np.cumsum(rng.normal(size=(n, 3)), 0)
    directions = rng.normal(size=(n, 3))
    chain = Chain(revolute_axis(places, directions), bs.cga3d.translator(places[-1]))
    q = rng.normal(size=n)
    pose = np.eye(4, dtype=np.longdouble)
    for p, d, x in zip(places.astype(np.longdouble), directions.astype(np.longdouble), q, strict=True):
        u = d / np.sqrt((d * d).sum())
        k = np.cross(np.eye(3, dtype=np.longdouble), u)
        turn = np.eye(3) + np.sin(np.longdouble(x)) * k + (1 - np.cos(np.longdouble(x))) * k @ k
        own = np.eye(4, dtype=np.longdouble)
        own[:3, :3], own[:3, 3] = turn, p - turn @ p
        pose = pose @ own
    pose[:3, 3] += pose[:3, :3] @ places[-1]
    found = bs.cga3d.matrix(chain.forward(q))
    assert np.abs(found[:3, :3] - pose[:3, :3]).max() < 1e-13
    assert np.abs(found[:3, 3] - pose[:3, 3]).max() < 1e-12 * np.abs(places).max()
    assert chain.jacobian(q).shape == (6, n)
    assert class_of(n) == CLASSES[-1]

    def best(count):
        own = Chain(chain.axes[np.arange(count) % n])
        x = np.zeros((20, count))
        own.jacobian(x)
        times = []
        for _ in range(7):
            start = time.process_time()
            own.jacobian(x)
            times.append(time.process_time() - start)
        return min(times)

    assert best(4000) < 10 * best(1000)  # linear: 4, quadratic: 16


# -- Jacobians and twists --------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("algebra", ALGEBRAS, ids=lambda a: a.name)
@pytest.mark.parametrize(("scale", "origin"), [(1.0, 0.0), (1.0, 1e4), (1e-6, 0.0)])
def test_jacobians_against_differences_at_fifty_digits(algebra, scale, origin):
    chain, q = mixed(algebra, 11, scale=scale, origin=origin)
    screws, tool, x = screw_coordinates(chain.axes), algebra.matrix(chain.tool), q[0]
    pose, _ = oracle(screws, tool, x)
    step = mp.mpf(10) ** -20
    point = scale * np.array([0.2, -0.1, 0.4])
    for j in range(chain.count):
        ends = []
        for sign in (1, -1):
            moved = [mp.mpf(float(v)) for v in x]
            total = mp.eye(4)
            moved[j] += sign * step
            for s, v in zip(screws, moved, strict=True):
                total = total * mp.expm(hat([mp.mpf(float(c)) * v for c in s]))
            ends.append(total * mp.matrix(tool.tolist()))
        rate = (ends[0] - ends[1]) / (2 * step)
        turn = rate[:3, :3] * pose[:3, :3].T
        w = np.array([turn[2, 1], turn[0, 2], turn[1, 0]], float)
        v = np.array(list(rate * mp.matrix([*point.tolist(), 1]))[:3], float)
        rotation = np.array(pose[:3, :3].tolist(), float)
        found = chain.jacobian(x, point=point)[:, j]
        far = 1e-12 * origin  # the axis itself is rounded
        assert np.abs(found[:3] - w).max() < 1e-14
        assert np.abs(found[3:] - v).max() < 4e-14 * max(scale, np.abs(v).max()) + far
        seen = chain.jacobian(x, "tool", point)[:, j]
        assert np.abs(seen[:3] - rotation.T @ w).max() < 1e-14
        assert np.abs(seen[3:] - rotation.T @ v).max() < 4e-14 * max(scale, np.abs(v).max()) + far
        about = chain.jacobian(x)[:, j]
        place = np.array(list(pose * mp.matrix([*point.tolist(), 1]))[:3], float)
        assert np.abs(about[3:] - (v + np.cross(place, w))).max() < 1e-13 * max(scale + origin, np.abs(v).max())


@pytest.mark.parametrize("algebra", ALGEBRAS, ids=lambda a: a.name)
def test_twists_add_up_along_the_chain(algebra):
    chain, q = mixed(algebra, 3)
    rng = np.random.default_rng(1)
    dq, ddq = rng.normal(size=q.shape), rng.normal(size=q.shape)
    screws, tool = screw_coordinates(chain.axes), algebra.matrix(chain.tool)
    links = screw_coordinates(chain.velocity(q, dq, all=True))
    rates = screw_coordinates(chain.acceleration(q, dq, ddq, all=True))
    assert links.shape == rates.shape == (4, 6, 6)
    step = mp.mpf(10) ** -18
    for k in range(2):

        def twists(t, k=k):
            x = [mp.mpf(float(a)) + mp.mpf(float(b)) * t + mp.mpf(float(c)) * t * t / 2
                 for a, b, c in zip(q[k], dq[k], ddq[k], strict=True)]  # fmt: skip
            speeds = [mp.mpf(float(b)) + mp.mpf(float(c)) * t for b, c in zip(dq[k], ddq[k], strict=True)]
            pose, before = mp.eye(4), []
            for s, v in zip(screws, x, strict=True):
                before.append(pose)
                pose = pose * mp.expm(hat([mp.mpf(float(c)) * v for c in s]))
            found, total = [], mp.matrix(6, 1)
            for j, column in enumerate(columns(screws, before).T.tolist()):
                total = total + mp.matrix(column) * speeds[j]
                found.append(list(total))
            return mp.matrix(found)

        assert np.abs(links[k] - np.array(twists(mp.mpf(0)).tolist(), float)).max() < 1e-13
        truth = (twists(step) - twists(-step)) / (2 * step)
        assert np.abs(rates[k] - np.array(truth.tolist(), float)).max() < 1e-12
    assert np.abs(screw_coordinates(chain.velocity(q, dq)) - links[:, -1]).max() == 0
    assert np.abs(np.einsum("kij,kj->ki", chain.jacobian(q), dq) - links[:, -1]).max() < 1e-13
    bias = screw_coordinates(chain.acceleration(q, dq))
    assert np.abs(bias + np.einsum("kij,kj->ki", chain.jacobian(q), ddq) - rates[:, -1]).max() < 1e-12
    # the twist moves the tool: dX = X x Omega for a point of it
    x = algebra.point([0.1, 0.2, 0.3])
    h = 1e-6
    moved = [(chain.forward(q[0] + s * h * dq[0]) >> x).parameters().xyz for s in (1, -1)]
    now = chain.forward(q[0]) >> x
    v = bs.dynamics.velocity_at(chain.velocity(q[0], dq[0]), now.parameters().xyz)
    assert np.abs((moved[0] - moved[1]) / (2 * h) - v).max() < 1e-7
    assert tool.shape == (4, 4)


def test_any_number_of_threads_gives_the_same_bits():
    chain, _ = mixed(bs.cga3d, 2)
    q = np.random.default_rng(0).uniform(-3, 3, (103, 6))
    point = np.random.default_rng(1).normal(size=(103, 3))

    def everything(threads=1):
        return [
            chain.forward(q, threads=threads).values, chain.forward(q, all=True, threads=threads).values,
            chain.jacobian(q, threads=threads), chain.jacobian(q, "tool", point, threads=threads),
            chain.velocity(q, q, threads=threads).values, chain.acceleration(q, q, q, threads=threads).values,
        ]  # fmt: skip

    truth = everything()
    for a, b in zip(everything(3), truth, strict=True):
        assert a.tobytes() == b.tobytes()
    for k in (0, 57, 102):
        assert chain.forward(q[k]).values.tobytes() == truth[0][k].tobytes()


def test_shapes_and_empty_batches():
    chain = arm()
    assert chain.forward(np.zeros(6)).shape == ()
    assert chain.forward(np.zeros((2, 3, 6))).shape == (2, 3)
    assert chain.forward(np.zeros((0, 6))).shape == (0,)
    assert chain.forward(np.zeros((0, 6)), all=True).shape == (0, 6)
    assert chain.jacobian(np.zeros((2, 3, 6)), point=np.zeros((3, 3))).shape == (2, 3, 6, 6)
    assert chain.jacobian(np.zeros((0, 6))).shape == (0, 6, 6)
    assert chain.velocity(np.zeros((2, 6)), np.ones(6)).shape == (2,)
    assert chain.inverse(chain.forward(np.zeros((0, 6)))).q.shape == (0, 6)
    assert chain.singularity(np.zeros((2, 3, 6))).singular_values.shape == (2, 3, 6)
    assert np.abs(chain.forward(np.ones(6, np.float32)).values - chain.forward(np.ones(6)).values).max() == 0


def test_chains_go_to_other_processes():
    chain = arm(limits=[[-3, 3]] * 6)
    truth = chain.forward(np.ones(6)).values
    again = pickle.loads(pickle.dumps(chain))
    assert again.names == chain.names and (again.forward(np.ones(6)).values == truth).all()
    with pytest.raises(ValueError, match="read-only"):
        chain.limits[0] = 0


# -- inverse ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("algebra", ALGEBRAS, ids=lambda a: a.name)
@pytest.mark.parametrize(
    ("scale", "center"), [(1.0, (0, 0, 0)), (1.0, (6e3, -7e3, 4e3)), (1e-6, (0, 0, 0)), (1e3, (0, 0, 0))]
)
def test_inverse_reaches_poses(algebra, scale, center):
    chain = arm(algebra, scale, center)
    q = np.random.default_rng(0).uniform(-2, 2, (100, 6))
    targets = chain.forward(q)
    near = chain.inverse(targets, q + 0.05)
    assert (near.status == 0).all()
    exact = 1e-10 + 1e-14 * np.abs(center).max() / scale * 1e3  # where the axes themselves are rounded
    good = chain.singularity(q).singular_values[:, -1] > 1e-2
    assert good.sum() > 50
    assert np.abs(near.q - q)[good].max() < exact
    far = chain.inverse(targets)
    assert (far.status == 0).all()
    assert far.angle.max() < 2e-14 and far.distance.max() < 2e-14 * chain.length  # what rounding leaves
    turned_over = chain.inverse(algebra.wrap(targets.kind, -targets.values), q + 0.05)  # R and -R are one pose
    assert (turned_over.q == near.q).all()
    error = algebra.matrix(chain.forward(far.q)) - algebra.matrix(targets)
    assert np.abs(error[:, :3, :3]).max() < 1e-12
    assert np.abs(error[:, :3, 3]).max() < 1e-12 * (scale + np.abs(center).max())


def test_targets_in_single_precision():
    chain = arm()
    targets = chain.forward(np.random.default_rng(8).uniform(-1, 1, (5, 6)))
    single = chain.inverse(targets.astype(np.float32), tolerance=1e-6)
    assert (single.status == 0).all()
    assert np.abs(chain.forward(single.q).values - targets.values).max() < 1e-5


def test_inverse_of_mixed_chains():
    for seed in range(4):
        chain, q = mixed(bs.cga3d, seed, count=7)
        q, status = chain.inverse(chain.forward(q), q + 0.1)
        assert np.isin(status, (0, 3)).all()


def test_inverse_stays_within_limits():
    limits = np.array([[-1, 1], [-1.5, 0.2], [0.1, 2.0], [-2, 2], [-1, 1], [0.2, 0.3]])
    chain = arm(limits=limits)
    q = np.random.default_rng(1).uniform(limits[:, 0], limits[:, 1], (60, 6))
    found = chain.inverse(chain.forward(q))
    reached = found.status == 0
    assert reached.mean() > 0.9
    assert (found.q[reached] >= limits[:, 0]).all() and (found.q[reached] <= limits[:, 1]).all()
    assert np.abs(chain.forward(found.q[reached]).values - chain.forward(q[reached]).values).max() < 1e-11
    outside = q.copy()
    outside[:, 5] += 2.5  # another roll than any that is allowed, with most others
    beyond = chain.inverse(chain.forward(outside), nearest=True)
    assert (beyond.q >= limits[:, 0]).all() and (beyond.q <= limits[:, 1]).all()
    resting = np.flatnonzero(beyond.status == bs.Status.NOT_CONVERGED)  # within all lengths: nothing is proved
    assert len(resting) > 20
    poses, goals = (bs.cga3d.matrix(chain.forward(x[resting])) for x in (beyond.q, outside))
    j = chain.jacobian(beyond.q[resting], point=np.zeros(3)) / np.repeat([1, chain.length], 3)[:, None]
    for x, now, goal, matrix in zip(beyond.q[resting], poses, goals, j, strict=True):
        turn = Rotation.from_matrix(goal[:3, :3] @ now[:3, :3].T).as_rotvec()
        missing = np.concatenate([turn, (goal[:3, 3] - now[:3, 3]) / chain.length])
        pull = missing @ matrix
        free = (x > limits[:, 0]) & (x < limits[:, 1])
        assert np.abs(pull[free]).max(initial=0) < 1e-3 * np.linalg.norm(missing)  # nothing more to gain
        assert (pull[x >= limits[:, 1]] > -1e-3).all() and (pull[x <= limits[:, 0]] < 1e-3).all()


def test_what_is_out_of_reach_says_so():
    chain = arm()
    far = bs.cga3d.translator([[5.0, 0, 0], [0.6, 0.2, 0.8]]).as_kind("motor")
    found = chain.inverse(far)
    assert found.status.tolist() == [bs.Status.UNREACHABLE, bs.Status.OK]
    assert np.isnan(found.q[0]).all() and found.steps[0] == 0
    nearest = chain.inverse(far, nearest=True)
    assert nearest.status[0] == bs.Status.UNREACHABLE
    place = bs.cga3d.matrix(chain.forward(nearest.q[0]))[:3, 3]
    assert 0 < nearest.distance[0] < 5 and np.isfinite(place).all()
    with pytest.raises(SingularError, match="item 0 is UNREACHABLE"):
        chain.inverse(far, strict=True)
    # within all lengths, and still nowhere: the wrist cannot be inside the base's hollow, turned so
    planar = Chain(revolute_axis([[0, 0, 0], [1, 0, 0]], UP), bs.cga3d.translator([1.5, 0, 0]))
    assert planar.inverse(bs.cga3d.translator([0.1, 0, 0])).status == bs.Status.UNREACHABLE
    assert planar.inverse(bs.cga3d.translator([1.2, 0, 0.3])).status == bs.Status.UNREACHABLE


def test_targets_that_are_none():
    chain = arm()
    targets = chain.forward(np.full((3, 6), 0.4))
    data = targets.values.copy()
    data[1] = np.nan
    found = chain.inverse(bs.cga3d.wrap(targets.kind, data), 0.3 * np.ones((3, 6)))
    assert found.status.tolist() == [0, bs.Status.INVALID, 0]
    start = np.full((3, 6), 0.3)
    start[2, 0] = np.inf
    assert chain.inverse(targets, start).status.tolist() == [0, 0, bs.Status.INVALID]
    one = chain.inverse(targets[0], start[0])
    assert one.status is bs.Status.OK and one.q.shape == (6,)
    assert chain.inverse(targets[0], iterations=1, attempts=1).status == bs.Status.NOT_CONVERGED


def test_singular_poses_are_reached_and_named():
    chain = arm()
    q = np.array([0.3, -0.4, 0.9, 0.5, 0.0, 0.2])  # the wrist's first and last axes are one line
    found = chain.inverse(chain.forward(q), q + 0.02)
    assert found.status is bs.Status.NOT_UNIQUE
    assert np.abs(chain.forward(found.q).values - chain.forward(q).values).max() < 1e-11
    regular = q + [0, 0, 0, 0, 0.7, 0]
    assert chain.inverse(chain.forward(regular), regular + 0.02).status is bs.Status.OK


def test_four_joints_reach_what_they_can():
    places = [[0, 0, 0], [0.3, 0, 0], [0.55, 0, 0]]
    axes = [revolute_axis(p, UP) for p in places]
    scara = Chain([axes[0], axes[1], prismatic_axis([0, 0, -1]), axes[2]], bs.cga3d.translator([0.55, 0, -0.1]))
    assert scara.freedom == 4
    q = np.random.default_rng(2).uniform(-1.5, 1.5, (50, 4))
    found = scara.inverse(scara.forward(q), q + 0.1)
    assert np.isin(found.status, (0, 3)).all()
    assert np.abs(scara.forward(found.q).values - scara.forward(q).values).max() < 1e-12
    tilted = scara.forward(q[0]) * bs.cga3d.rotor([1, 0, 0], 0.1)
    assert scara.inverse(tilted.as_kind("motor"), q[0]).status is bs.Status.UNREACHABLE


def test_more_joints_than_needed():
    chain, q = mixed(bs.pga3d, 8, count=9)
    assert chain.freedom == 6
    found = chain.inverse(chain.forward(q))
    assert np.isin(found.status, (0, 3)).all()
    assert found.angle.max() < 1e-12 and found.distance.max() < 1e-12 * chain.length


# -- singular poses --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("algebra", ALGEBRAS, ids=lambda a: a.name)
def test_what_is_lost_at_singular_poses(algebra):
    chain = arm(algebra)
    q = np.array([[0.3, -0.4, 0.9, 0.5, 0.0, 0.2], [0.3, -0.4, 0.9, 0.5, 0.8, 0.2]])
    found = chain.singularity(q)
    assert found.rank.tolist() == [5, 6] and found.singular.tolist() == [True, False]
    assert found.manipulability[0] < 1e-15 < 1e-4 < found.manipulability[1]
    j = chain.jacobian(q)
    assert np.abs(j[0] @ found.null_rates[0]).max() < 1e-15
    assert np.abs(np.abs(found.null_rates[0][[3, 5]]) - np.sqrt(0.5)).max() < 1e-12
    # no joint rates give it, not even in part: one more column, and the rank is full
    lost = screw_coordinates(found.lost_twist)[0]
    assert np.linalg.matrix_rank(np.column_stack([j[0], lost]), 1e-9) == 6
    place = algebra.matrix(chain.forward(q[0]))[:3, 3]
    about = np.concatenate([lost[:3], (lost[3:] - np.cross(place, lost[:3])) / chain.length])
    own = chain.jacobian(q[0], point=np.zeros(3)) / np.repeat([1, chain.length], 3)[:, None]
    assert np.abs(about @ own).max() < 1e-14 and abs(np.linalg.norm(about) - 1) < 1e-12


def test_a_stretched_arm_cannot_move_outwards():
    stretched = Chain(revolute_axis([[0, 0, 0], [1, 0, 0]], UP), bs.cga3d.translator([2.0, 0, 0]))
    found = stretched.singularity([0.4, 0.0])
    assert found.rank == 2 and not found.singular  # two turns about parallel axes are never the same
    planar = Chain(revolute_axis([[0, 0, 0], [1, 0, 0], [2, 0, 0]], UP), bs.cga3d.translator([2.5, 0, 0]))
    found = planar.singularity([0.4, 0.0, 0.0])
    assert planar.freedom == 3 and found.rank == 2 and found.singular
    w, v = np.split(screw_coordinates(found.lost_twist), 2)
    along = np.array([np.cos(0.4), np.sin(0.4), 0])
    assert np.abs(w).max() < 1e-12
    assert abs(abs(v @ along) / np.linalg.norm(v) - 1) < 1e-12


# -- bad input ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("make", "error", "words"),
    [
        (lambda: Chain([]), InputError, "at least one joint"),
        (lambda: Chain(3), InputError, "revolute_axis"),
        (lambda: Chain([0 * revolute_axis([0, 0, 0], UP)]), InputError, "axis of joint_1 .joint 0. is zero"),
        (lambda: Chain([revolute_axis([0, 0, 0], UP), revolute_axis([0, 0, 0], [0, 0, 0])]), InputError, "joint_2"),
        (lambda: Chain([bs.cga3d.point([0, 0, 0])]), GradeError, "axis 0"),
        (lambda: Chain([bs.cga3d.circle([0, 0, 0], UP, 1.0)]), GradeError, "not a line"),
        (lambda: Chain([revolute_axis([0, 0, 0], UP), revolute_axis([0, 0, 0], UP, bs.pga3d)]), AlgebraMismatchError,
         "axis 1"),
        (lambda: arm(names=["a", "b"]), ShapeError, "2 names for 6"),
        (lambda: arm(names=["a"] * 6), InputError, "two joints are called 'a'"),
        (lambda: arm(limits=[[0, 1]] * 5), ShapeError, "limits"),
        (lambda: arm(limits=[[0, 1]] * 5 + [[2, 1]]), InputError, "joint_6"),
        (lambda: arm(limits=[[0, np.nan]] * 6), InputError, "joint_1"),
        (lambda: arm(length=0.0), InputError, "length"),
        (lambda: Chain(revolute_axis([0, 0, 0], UP)), ShapeError, "shape"),
        (lambda: Chain([revolute_axis([0, 0, 0], UP)], bs.pga3d.translator([0, 0, 0])), AlgebraMismatchError, "tool"),
        (lambda: Chain([revolute_axis([0, 0, 0], UP)], target="cuda"), InputError, "one of c, numba"),
        (lambda: Chain([revolute_axis([0, 0, 0], UP)] * (CLASSES[-1] + 1)).forward(np.zeros(CLASSES[-1] + 1)),
         InputError, "longer than the longest"),
        (lambda: arm().forward([1, 2]), ShapeError, "q has shape"),
        (lambda: arm().forward(["a"] * 6), InputError, "q"),
        (lambda: arm().forward([np.nan] * 6, strict=True), SingularError, "INVALID"),
        (lambda: arm().jacobian(np.zeros(6), "base"), InputError, "frame"),
        (lambda: arm().jacobian([np.inf] * 6, strict=True), SingularError, "INVALID"),
        (lambda: arm().jacobian(np.zeros((2, 6)), point=np.zeros((3, 3))), ShapeError, "point"),
        (lambda: arm().velocity(np.zeros((2, 6)), np.zeros((3, 6))), ShapeError, "dq"),
        (lambda: arm().inverse(np.eye(4)), InputError, "targets"),
        (lambda: arm().inverse(bs.cga3d.point([0, 0, 0])), GradeError, "not a motor"),
        (lambda: arm().inverse(arm().tool, attempts=0), InputError, "attempts"),
        (lambda: arm().inverse(arm().tool, iterations=1.5), InputError, "iterations"),
        (lambda: arm().inverse(arm().tool, tolerance=-1), InputError, "tolerance"),
        (lambda: revolute_axis([0, 0, 0], [0, 0, 0], strict=True), SingularError, "INVALID"),
    ],
)  # fmt: skip
def test_bad_input(make, error, words):
    with pytest.raises(error, match=words):
        make()


def test_coordinates_that_are_not_finite_are_marked():
    chain = arm()
    q = np.zeros((3, 6))
    q[1, 2] = np.inf
    poses = chain.forward(q)
    assert poses.status.tolist() == [0, bs.Status.INVALID, 0]
    assert np.isnan(poses.values[1]).all() and np.isfinite(poses.values[[0, 2]]).all()
    j, status = chain.jacobian(q, status=True)
    assert status.tolist() == [0, bs.Status.INVALID, 0] and np.isfinite(j[[0, 2]]).all()
    assert chain.velocity(q, q).status.tolist() == [0, bs.Status.INVALID, 0]
    found = chain.singularity(q)
    assert np.isnan(found.singular_values[1]).all() and np.isfinite(found.singular_values[[0, 2]]).all()
    bad = revolute_axis([[0, 0, 0], [0, 0, 0]], [[0, 0, 0], UP])
    assert bad.status.tolist() == [bs.Status.INVALID, 0] and np.isnan(bad.values[0]).all()
    assert (prismatic_axis(UP) - twist(0, UP)).values.max() == 0


# -- many targets ----------------------------------------------------------------------------------------------


def test_workers_of_an_executor_find_the_same_bits(monkeypatch):
    monkeypatch.setattr("bladesmith.kinematics.serial.inverse.TARGETS_PER_CALL", 8)
    chain = arm()
    targets = chain.forward(np.random.default_rng(3).uniform(-1, 1, (40, 6)))
    here, told = chain.inverse(targets), []
    with ThreadPoolExecutor(2) as pool:
        there = chain.inverse(targets, executor=pool, progress=told.append)
    for name in ("q", "status", "angle", "distance", "steps"):
        np.testing.assert_array_equal(getattr(here, name), getattr(there, name))
    assert [p.done for p in told] == [8, 16, 24, 32, 40] and told[0].unit == "targets"


def test_an_interrupt_keeps_the_targets_that_were_reached(monkeypatch):
    def stop(progress):
        raise KeyboardInterrupt

    chain = arm()
    targets = chain.forward(np.random.default_rng(4).uniform(-1, 1, (200, 6)))
    with pytest.raises(Interrupted) as caught:
        chain.inverse(targets, threads=1, progress=stop)
    q, status = caught.value.partial
    found, codes = chain.inverse(targets)
    done = np.isfinite(q).all(-1)
    assert 0 < done.sum() < 200 and (status[~done] == Status.NOT_CONVERGED).all()
    np.testing.assert_array_equal(q[done], found[done])
    np.testing.assert_array_equal(status[done], codes[done])
