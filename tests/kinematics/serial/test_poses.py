"""Poses, Jacobians and twists of serial chains against matrix exponentials of 50 digits, near and far."""

import pickle
import time

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import bladesmith as bs
from bladesmith.codegen.programs.chains import CLASSES, class_of
from bladesmith.dynamics import screw_coordinates
from bladesmith.kinematics.serial.axes import prismatic_axis, revolute_axis, screw_axis
from bladesmith.kinematics.serial.chain import Chain

from ...oracles.serial_chains import columns, hat, oracle
from ...support.mechanisms.chains import ALGEBRAS, UP, arm, mixed

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
