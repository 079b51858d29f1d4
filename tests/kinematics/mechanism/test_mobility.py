"""Mobility and null space of mechanisms against dense linear algebra on the thesis's own constraints, and statics."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bladesmith import cga3d as cga
from bladesmith import kinematics as kin
from bladesmith import pga3d as pga
from bladesmith.kinematics.mechanism.loop_closure import Loops

from ...support.kinematics import (
    STEWART,
    Delta,
    bennett,
    columns,
    four_bar,
    full_matrix,
    line_joint,
    rank,
    sarrus,
    six,
    stewart,
    velocity,
)
from ...support.mechanisms.poses import BAR, MOTORS, THETA

pytestmark = pytest.mark.filterwarnings("error")


def random_chain(seed, joints, algebra=cga, spread=1.0):
    """A closed loop of revolute joints anywhere."""
    rng = np.random.default_rng(seed)
    names = [f"b{i}" for i in range(joints)]
    m = kin.Mechanism(names, "b0")
    for i in range(joints):
        m.add(line_joint(algebra, names[i], names[(i + 1) % joints], spread * rng.normal(size=3), rng.normal(size=3)))
    return m


def random_net(seed, bodies=6, extra=3):
    """A tree of joints of all sorts, and some more that close loops."""
    rng = np.random.default_rng(seed)
    names = [f"b{i}" for i in range(bodies)]
    ends = [(int(rng.integers(i)), i) for i in range(1, bodies)]
    ends += [tuple(rng.permutation(bodies)[:2].tolist()) for _ in range(extra)]
    m = kin.Mechanism(names, names[int(rng.integers(bodies))])
    for a, b in ends:
        p, n = rng.normal(size=(2, 3))
        n /= np.linalg.norm(n)
        make = [
            lambda x, y, p=p, n=n: kin.Revolute(x, y, cga.circle(p, n, 1)),
            lambda x, y, p=p, n=n: kin.Spherical(x, y, cga.point(p)),
            lambda x, y, p=p, n=n: kin.Cylindrical(x, y, cga.line(p, n)),
            lambda x, y, p=p, n=n: kin.Planar(x, y, cga.plane(n, p @ n)),
        ]
        m.add(make[int(rng.integers(len(make)))](names[a], names[b]))
    return m


#: Mechanisms, and their mobility.
MECHANISMS = {
    "four bar": (lambda: four_bar(BAR.places(0.8)), 1),
    "four bar, pga": (lambda: four_bar(BAR.places(0.8), pga), 1),
    "Bennett": (lambda: four_bar(bennett()[0], axes=bennett()[1]), 1),
    "Bennett, pga": (lambda: four_bar(bennett()[0], pga, bennett()[1]), 1),
    "four bars anywhere": (lambda: random_chain(1, 4), 0),
    "six bars anywhere": (lambda: random_chain(2, 6), 0),
    "seven bars anywhere": (lambda: random_chain(3, 7), 1),
    "nine bars anywhere, pga": (lambda: random_chain(4, 9, pga), 3),
    "Sarrus": (sarrus, 1),
    "Delta": (lambda: Delta().mechanism(THETA), 9),
    "Delta, pga": (lambda: Delta().mechanism(THETA, pga), 9),
    "Stewart with spinning legs, pga": (lambda: stewart(*STEWART, pga), 12),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", MECHANISMS)
def test_mobility_and_null_space_are_those_of_the_thesis(name):
    m, mobility = MECHANISMS[name][0](), MECHANISMS[name][1]
    full = full_matrix(m)
    assert m.mobility() == mobility == 6 * len(m.moving) - rank(full)
    assert m.rank() == rank(full)
    own = m.constraint_matrix().toarray() @ np.kron(np.eye(len(m.moving)), columns(m.algebra))
    assert rank(own) == m.rank()
    spaces = [np.linalg.pinv(c, rcond=1e-9) @ c for c in (own, full)]
    np.testing.assert_allclose(*spaces, atol=1e-9)


def test_a_stewart_platform_has_six_freedoms():
    m = stewart(*STEWART)
    assert m.constraint_matrix().shape == (6 * (4 + 5 + 3), 78)
    assert m.mobility() == 6 and m.rank() == rank(m.constraint_matrix().toarray()) == 72
    assert m.allowed_twists("top").shape == (6,) and not m.self_stresses()


def test_the_thesis_counts_a_delta():
    """15 constraints of circles and points, 51 independent rows of 60 columns; three ways to move, and six spins."""
    m = Delta().mechanism(THETA)
    full = full_matrix(m)
    assert len(m.joints) == 15 and full.shape[1] == 60 and rank(full) == m.rank() == 51 and m.mobility() == 9
    motions = m.free_motions()
    assert [x.idle for x in motions] == [True] * 6 + [False] * 3
    assert [x.driver for x in motions[6:]] == MOTORS
    for k, motion in enumerate(motions[:6]):
        assert motion.bodies == [f"rod_{k}"]
        ends = [c.x.parameters().xyz for j in m.joints if f"rod_{k}" in (j.a, j.b) for c in j.conditions()]
        found = six(motion[f"rod_{k}"])
        way = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
        np.testing.assert_allclose(np.cross(found[:3], way), 0, atol=1e-12 * np.linalg.norm(found))
        for end in ends:
            np.testing.assert_allclose(velocity(found, end), 0, atol=1e-12 * np.linalg.norm(found))
    allowed = six(m.allowed_twists("platform"))
    assert len(allowed) == 3 and np.abs(allowed[:, :3]).max() < 1e-12  # it does not turn
    assert m.allowed_twists("rod_0").shape == (4,) and m.allowed_twists("platform", "platform").shape == (0,)


@pytest.mark.parametrize("name", MECHANISMS)
def test_free_motions_obey_all_joints(name):
    m = MECHANISMS[name][0]()
    motions = m.free_motions()
    stacked = np.array([np.concatenate([six(x[b]) for b in m.moving]) for x in motions]).reshape(-1, 6 * len(m.moving))
    assert len(motions) == m.mobility() == (np.linalg.matrix_rank(stacked) if motions else 0)
    sizes = np.linalg.norm(stacked, axis=-1, keepdims=True)
    assert np.abs(full_matrix(m) @ (stacked / sizes).T).max(initial=0) < 1e-10
    for motion in motions:
        assert (
            np.abs(six(motion[m.fixed])).max() == 0 and len(motion) == len(m.bodies) and list(motion) == list(m.bodies)
        )


@pytest.mark.parametrize("name", ["four bar", "four bar, pga", "Bennett", "Sarrus", "four bars anywhere"])
def test_self_stresses_are_in_equilibrium(name):
    """Wrenches that each body's joints put on it add up to nothing, and do no work at any joint."""
    m = MECHANISMS[name][0]()
    stresses = m.self_stresses()
    full = sum(6 - {"Revolute": 1}[type(j).__name__] for j in m.joints)
    assert len(stresses) == full - m.rank() == {"four bars anywhere": 2}.get(name, 1 if name == "Sarrus" else 3)
    for stress in stresses:
        given = {name: six(w) for name, w in stress.items()}  # (force, moment about the origin)
        size = max(np.abs(v).max() for v in given.values())
        for body in m.moving:
            net = sum(
                (
                    v * ((j.b == body) - (j.a == body))
                    for j, n in zip(m.joints, m.joint_names, strict=True)
                    if (v := given.get(n)) is not None
                ),
                start=np.zeros(6),
            )
            assert np.abs(net).max() < 1e-10 * size
        for joint, label in zip(m.joints, m.joint_names, strict=True):
            if label in given:
                p = joint.conditions()[0].x.parameters() if m.algebra is cga else None
                place = p.center if p is not None else joint.point.parameters().xyz
                axis = p.normal if p is not None else joint.geometry.parameters().direction
                force, moment = given[label][:3], given[label][3:]
                assert abs((moment - np.cross(place, force)) @ axis) < 1e-10 * size
    stacked = np.array(
        [np.concatenate([six(s[n]) if n in s else np.zeros(6) for n in m.joint_names]) for s in stresses]
    )
    assert np.linalg.matrix_rank(stacked) == len(stresses)


@pytest.mark.slow
@settings(max_examples=40)
@given(st.integers(0, 10**6), st.integers(2, 7), st.integers(0, 4))
def test_random_nets(seed, bodies, extra):
    """Mobility by dense rank; the same whichever body is fixed; free motions, stresses and counts go together."""
    m = random_net(seed, bodies, extra)
    full = full_matrix(m)
    values = np.linalg.svd(full, compute_uv=False)
    if ((values > 1e-10 * values[0]) & (values < 1e-6 * values[0])).any():
        return  # too near to singular to tell
    assert m.mobility() == 6 * len(m.moving) - rank(full)
    assert len(m.free_motions()) == m.mobility()
    rows = sum(6 - j.mobility for j in m.joints)
    assert len(m.self_stresses()) == rows - m.rank() and m.constraint_matrix().shape[0] == rows
    other = kin.Mechanism(m.bodies, next(b for b in m.bodies if b != m.fixed), m.joints)
    assert other.mobility() == m.mobility()


def test_free_motions_of_a_long_chain_take_time_for_what_moves_alone(monkeypatch):
    n, asked = 300, []
    joints = [line_joint(cga, f"l{i}", f"l{i + 1}", (i, 0, 0), (0, 0, 1)) for i in range(n)]
    motions = kin.Mechanism([f"l{i}" for i in range(n + 1)], "l0", joints).free_motions()
    subspace = Loops.joint_subspace
    monkeypatch.setattr(Loops, "joint_subspace", lambda self, body: asked.append(body) or subspace(self, body))
    for k, motion in enumerate(motions[::30]):
        assert len(motion.bodies) == n - 30 * k
        assert np.abs(motion[f"l{n}"].values).max() > 0
    assert len(motions) == n and len(asked) == 20
