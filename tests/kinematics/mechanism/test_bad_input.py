"""Mechanisms against dense linear algebra on the thesis's own constraints, statics, and 50-digit closures."""

import itertools
import time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from bladesmith import cga3d as cga
from bladesmith import kinematics as kin
from bladesmith import pga3d as pga
from bladesmith.codegen.errors import (
    AlgebraMismatchError,
    BladesmithError,
    ConstraintError,
    InputError,
    KindError,
    ShapeError,
    UndeterminedError,
)

from ...support.kinematics import (
    ALGEBRAS,
    AXIS,
    STEWART,
    Delta,
    FourBar,
    bennett,
    columns,
    four_bar,
    full_matrix,
    hinge,
    line_joint,
    rank,
    sarrus,
    six,
    slide,
    stewart,
    turn,
    twist,
    velocity,
)

pytestmark = pytest.mark.filterwarnings("error")

THETA = np.array([0.3, 0.5, 0.1])
MOTORS = ["motor_0", "motor_1", "motor_2"]
BAR = FourBar()


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
    assert len(motions) == m.mobility() == np.linalg.matrix_rank(stacked)
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


# -- speeds that follow ---------------------------------------------------------------------------------------------


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


# -- singular poses, and loops that do not close -------------------------------------------------------------------


def test_a_stretched_four_bar():
    """Crank and coupler in one line: the rocker is at its limit, and can not drive."""
    d, a, b, c = BAR.lengths
    theta = np.arccos(((a + b) ** 2 + d**2 - c**2) / (2 * (a + b) * d))
    way = np.array([np.cos(theta), np.sin(theta), 0])
    m = four_bar([0 * way, a * way, (a + b) * way, [d, 0, 0]])
    np.testing.assert_allclose(m.jacobian("a", "d"), 0, atol=1e-9)
    found = m.analysis("a", ["rocker"])
    assert not found.open.size and found.lost.shape == (6, 6)
    driven = m.analysis("d", "a")
    assert driven.residual[0] > 0.1 and driven.open.shape == (1, 1)
    with pytest.raises(ConstraintError, match=f"input 0 .*{driven.residual[0]:.3g}"):
        m.jacobian("d", "a")
    assert np.abs(m.jacobian("d", "a", strict=False)).max() < 10  # the least speeds, and no infinity


def test_a_delta_arm_in_line_loses_a_direction():
    robot = Delta()
    theta = np.array([2.0, 0.0, 0.0])
    out = np.cos(theta[0]) * robot.s[0] + np.sin(theta[0]) * AXIS
    elbow = np.asarray(robot.elbows(theta))[0]
    y = elbow - robot.effector * robot.s[0] + robot.fore * out
    for i in (1, 2):  # the other arms reach the same place

        def reach(t, i=i):
            return np.linalg.norm(np.asarray(robot.elbows([t] * 3))[i] - robot.effector * robot.s[i] - y) - robot.fore

        values = np.linspace(-1.5, 2.5, 400)
        k = next(k for k in range(399) if reach(values[k]) * reach(values[k + 1]) < 0)
        theta[i] = brentq(reach, values[k], values[k + 1], xtol=1e-15)
    m = robot.mechanism(theta, y=y)
    found = m.analysis(MOTORS, ("platform", y))
    assert found.lost.shape == (3, 1) and not found.open.size
    np.testing.assert_allclose(abs(found.lost[:, 0] @ out), 1, atol=1e-9)
    assert m.residual() < 1e-9 and np.linalg.matrix_rank(found.jacobian, tol=1e-8) == 2


def test_a_delta_with_level_rods_is_open():
    robot = Delta(lengths=(0.4, 0.15, 0.6, 0.7))
    theta = np.arccos((0.7 - 0.25) / 0.6)
    m = robot.mechanism(np.full(3, theta), y=[0, 0, 0.6 * np.sin(theta)])
    found = m.analysis(MOTORS, ("platform", [0, 0, 0.6 * np.sin(theta)]))
    assert found.open.shape == (3, 1)
    np.testing.assert_allclose(np.abs(found.open[:, 0]), [0, 0, 1], atol=1e-9)
    with pytest.raises((UndeterminedError, ConstraintError)):
        m.jacobian(MOTORS, ("platform", [0, 0, 0]))


@pytest.mark.slow
@settings(max_examples=25)
@given(st.floats(1e-5, 0.5), st.sampled_from([1e-3, 1.0, 1e3]))
def test_a_loop_that_is_open_says_by_how_much(gap, scale):
    """The pseudo-inverse would average in silence."""
    places = BAR.places(0.8) * scale
    m = four_bar(places, radius=scale)
    closed = m.at({})
    assert closed.residual() < 1e-12 and closed.mobility() == 1
    shifted = m.at({"rocker": cga.translator([0, 0, gap * scale])})
    assert set(n for n, v in shifted.residuals().items() if v > 1e-9) == {"c", "d"}
    assert gap / 10 < shifted.residual() < 10 * gap
    with pytest.raises(ConstraintError, match="apart"):
        shifted.mobility()
    with pytest.raises(ConstraintError, match="apart"):
        shifted.jacobian("a", "b")
    joint = kin.Spherical("g", "x", cga.point(scale * np.ones(3)), other=cga.point(scale * (1 + gap * AXIS)))
    with pytest.raises(ConstraintError, match="apart"):
        kin.Mechanism(["g", "x"], "g", joint).constraint_matrix()


def test_moved_as_one_it_is_the_same():
    places = BAR.places(0.8)
    m = four_bar(places)
    motor = (-0.3 * twist(cga, np.array([1, 2, 3, 4, 5, 6.0]))).exp()
    moved = m.at(dict.fromkeys(m.bodies, motor))
    assert moved.residual() < 1e-12
    np.testing.assert_allclose(moved.jacobian("a", "d"), m.jacobian("a", "d"), rtol=1e-9)
    twists = [
        six(x["coupler"]) for x in (moved.solve({"a": 1.0}), {"coupler": motor >> m.solve({"a": 1.0})["coupler"]})
    ]
    np.testing.assert_allclose(*twists, atol=1e-9)
    assert moved.at(dict.fromkeys(m.bodies, ~motor)).residual() < 1e-12


# -- what is asked wrongly -----------------------------------------------------------------------------------------

POINT = cga.point((1, 2, 3))
TWIST = twist(cga, turn(AXIS, [0, 0, 0]))
NAN = float("nan")


def some():
    return four_bar(BAR.places(0.8))


ASKED = {
    "no bodies": (lambda: kin.Mechanism([], "g"), InputError, "not in bodies"),
    "None": (lambda: kin.Mechanism(None, "g"), InputError, "not in bodies"),
    "a number": (lambda: kin.Mechanism(3, "g"), InputError, "a list of them"),
    "a mapping": (lambda: kin.Mechanism({"a": 1}, "a"), InputError, "a list of them"),
    "a body twice": (lambda: kin.Mechanism(["a", "b", "a"], "a"), InputError, "two bodies 'a'"),
    "a body of no name": (lambda: kin.Mechanism(["a", ""], "a"), InputError, "a word"),
    "a list to fix": (lambda: kin.Mechanism(["a", "b"], ["a"]), InputError, "not in bodies"),
    "a near miss": (lambda: kin.Mechanism(["ground", "b"], "grund"), InputError, "did you mean 'ground'"),
    "a word for a tolerance": (lambda: kin.Mechanism(["a"], "a", tolerance="x"), InputError, "tolerance"),
    "a tolerance above one": (
        lambda: kin.Mechanism(["a"], "a", tolerance=2),
        InputError,
        "greater than 0 and less than 1",
    ),
    "a word for joints": (lambda: kin.Mechanism(["a", "b"], "a", "ab"), InputError, "joints are 'ab'"),
    "a class for a joint": (lambda: kin.Mechanism(["a", "b"], "a", [kin.Revolute]), InputError, "the class Revolute"),
    "no joint at all": (lambda: kin.Mechanism(["a", "b"], "a", [kin.Joint()]), InputError, "as Revolute"),
    "a joint twice": (lambda: (lambda m: m.add(m.joints[0]))(some()), InputError, "already"),
    "a name twice": (
        lambda: some().add(kin.Spherical("crank", "rocker", POINT), "a"),
        InputError,
        "the name 'a' is taken",
    ),
    "a name of a body": (
        lambda: some().add(kin.Spherical("crank", "rocker", POINT), "crank"),
        InputError,
        "is taken",
    ),
    "a name of letters": (
        lambda: some().add(kin.Spherical("crank", "rocker", POINT), ["x"]),
        InputError,
        "a word is needed",
    ),
    "an empty name": (lambda: some().add(kin.Spherical("crank", "rocker", POINT), ""), InputError, "a word is needed"),
    "an unknown body": (
        lambda: some().add(kin.Spherical("crank", "roker", POINT)),
        InputError,
        "did you mean 'rocker'",
    ),
    "two algebras": (
        lambda: some().add(kin.Spherical("crank", "rocker", pga.point((0, 0, 0)))),
        InputError,
        "of pga3d",
    ),
    "no joints": (lambda: kin.Mechanism(["a", "b"], "a").mobility(), InputError, "no joints"),
    "the fixed body alone": (lambda: kin.Mechanism(["a"], "a").constraint_matrix(), InputError, "no joints"),
    "loose bodies": (
        lambda: kin.Mechanism(["a", "b", "c"], "a", [kin.Spherical("b", "c", POINT)]).mobility(),
        InputError,
        "no joints hold b, c",
    ),
    "twists of nobody": (lambda: some().allowed_twists("x"), InputError, "no body 'x'"),
    "no outputs": (lambda: some().jacobian("a", []), InputError, "no outputs"),
    "no inputs": (lambda: some().jacobian([], "crank"), UndeterminedError, "inputs are missing"),
    "unknown inputs": (lambda: some().jacobian("x", "crank"), InputError, "no body 'x'"),
    "a set": (lambda: some().jacobian({"a", "b"}, "crank"), InputError, "no order"),
    "a tuple of names": (lambda: some().jacobian("a", ("crank", "rocker")), InputError, "as a list"),
    "a pair of three": (lambda: some().jacobian("a", ("crank", (0, 0, 0), 1)), InputError, "as a list"),
    "a flat point": (lambda: some().jacobian("a", ("crank", (0, 0))), ShapeError, "3. is needed"),
    "a point that is none": (lambda: some().jacobian("a", ("crank", (0, 0, NAN))), InputError, "finite"),
    "a line for a point": (lambda: some().jacobian("a", ("crank", cga.line((0, 0, 0), AXIS))), InputError, "is a line"),
    "points": (lambda: some().jacobian("a", ("crank", np.zeros((2, 3)))), InputError, r"\(3,\) is needed"),
    "the fixed body as input": (lambda: some().jacobian("ground", "crank"), InputError, "is fixed"),
    "an input twice": (lambda: some().jacobian(["a", "a"], "crank"), InputError, "twice"),
    "a twist of another algebra": (
        lambda: some().jacobian(("crank", twist(pga, np.ones(6))), "rocker"),
        AlgebraMismatchError,
        "pga3d",
    ),
    "a point for a twist": (lambda: some().jacobian(("crank", POINT), "rocker"), KindError, "twist"),
    "a twist that is none": (lambda: some().jacobian(("crank", NAN * TWIST), "rocker"), InputError, "not finite"),
    "all twists of a crank": (lambda: some().jacobian("crank", "rocker"), ConstraintError, "violates the joint"),
    "a joint of another": (lambda: some().jacobian(some().joints[0], "crank"), InputError, "not a joint of this"),
    "a status of one": (lambda: some().jacobian("a", "crank", status=True), InputError, "goes with poses"),
    "an unknown method": (lambda: some().jacobian("a", "crank", method="magic"), InputError, "no method 'magic'"),
    "nothing known": (lambda: some().solve({}), InputError, "a mapping"),
    "a list known": (lambda: some().solve(["a"]), InputError, "a mapping"),
    "no speed": (lambda: some().solve({"a": None}), InputError, "None"),
    "no twist": (lambda: some().solve({"crank": None}), InputError, "None"),
    "a number for a twist": (lambda: some().solve({"crank": 1.0}), InputError, "a multivector"),
    "many twists": (lambda: some().solve({"crank": twist(cga, np.ones((3, 6)))}), InputError, "one speed or twist"),
    "two speeds": (lambda: some().solve({"a": [1, 2]}), InputError, "1 numbers"),
    "a complex speed": (lambda: some().solve({"a": 1j}), InputError, "real"),
    "a speed that is none": (lambda: some().solve({"a": NAN}), InputError, "finite"),
    "the fixed body known": (lambda: some().solve({"ground": TWIST}), InputError, "is fixed"),
    "a number known": (lambda: some().solve({1: TWIST}), InputError, "no body 1"),
    "no pose": (lambda: some().at(None), InputError, "a mapping"),
    "a list for a motor": (lambda: some().at({"crank": [1, 2]}), InputError, "a multivector"),
    "a batch of poses": (lambda: some().at({"crank": cga.translator(np.zeros((2, 3)))}), InputError, "one item"),
    "a pose that is none": (lambda: some().at({"crank": NAN * cga.translator((0, 0, 0))}), InputError, "not finite"),
    "a pose of zero": (lambda: some().at({"crank": 0 * cga.translator((0, 0, 0))}), KindError, "motor"),
    "a pose of another algebra": (
        lambda: some().at({"crank": pga.translator((0, 0, 0))}),
        AlgebraMismatchError,
        "pga3d",
    ),
    "a point for a pose": (lambda: some().at({"crank": POINT}), KindError, "motor"),
}


@pytest.mark.parametrize("name", ASKED)
def test_what_is_asked_wrongly_is_answered(name):
    call, error, why = ASKED[name]
    with pytest.raises(error, match=why) as caught:
        call()
    assert isinstance(caught.value, BladesmithError) and "\n" not in str(caught.value)


def test_bodies_that_are_one():
    m = kin.Mechanism(["g", "x", "y"], "g", [kin.Rigid("g", "x"), kin.Rigid("x", "y")])
    assert m.mobility() == 0 and m.free_motions() == [] == m.self_stresses() and m.rank() == 12
    assert m.allowed_twists("y").shape == (0,) and m.jacobian([], "y").shape == (6, 0)
    found = m.analysis(("y", twist(cga, slide(np.eye(3)))), "x")
    np.testing.assert_allclose(found.residual, 1)  # nothing of it is allowed
    with pytest.raises(ConstraintError, match="violate the joint constraints"):
        m.solve({"x": TWIST})


def test_what_is_unusual_and_right():
    m = some()
    assert kin.Mechanism("alone", "alone").residual() == 0.0
    assert m.jacobian((x for x in ["a"]), np.array(["crank", "rocker"])).shape == (12, 1)
    assert m.jacobian({"crank": TWIST}, "rocker").shape == (6, 1)
    assert m.jacobian("a", "ground").tolist() == [[0]] * 6
    assert m.allowed_twists("ground").shape == (0,)
    for order in itertools.permutations(range(4), 4):
        again = kin.Mechanism(m.bodies[::-1], "ground", [m.joints[i] for i in order])
        np.testing.assert_allclose(again.jacobian(m.joints[0], m.joints[3]), m.jacobian("a", "d"), rtol=1e-10)
    double = some()
    double.add(kin.Revolute("ground", "crank", cga.circle((0, 0, 1), AXIS, 2)), "again")  # one hinge by two pins
    assert double.mobility() == 1 and len(double.self_stresses()) == 8


def test_joints_without_a_name_are_found_by_what_joint_names_says() -> None:
    mechanism = kin.Mechanism(bodies=["base", "arm"], fixed="base")
    joint = mechanism.add(hinge("base", "arm", (1, 0, 0), (0, 0, 1)))
    (name,) = mechanism.joint_names
    assert np.array_equal(mechanism.jacobian(name, "arm"), mechanism.jacobian(joint, "arm"))
    assert np.array_equal(mechanism.solve({name: 2.0})["arm"].values, 2.0 * mechanism.allowed_twists("arm").values[0])
    mechanism.add(hinge("base", "arm", (1, 0, 1), (0, 0, 1)))
    with pytest.raises(InputError, match="2 joints are"):
        mechanism.jacobian(name, "arm")
