"""Studies of kinematics: truths of 50 digits against definitions, methods against truths, what counts as lost, and the
peers of the benchmark."""

from __future__ import annotations

import importlib
import importlib.util
from dataclasses import replace

import numpy as np
import pytest

from bladesmith import cga3d as cga
from bladesmith.benchmarks.harness import runner
from bladesmith.benchmarks.harness import study as harness
from bladesmith.benchmarks.harness.runner import Measurement, run_study
from bladesmith.benchmarks.harness.vectors import cross, dot, subtract
from bladesmith.benchmarks.registry import load_study
from bladesmith.benchmarks.studies.kinematics import (
    chains,
    delta,
    delta_joints,
    mechanisms,
    mechanisms_reaching,
)
from bladesmith.benchmarks.studies.kinematics.chains_exact import ExactArm
from bladesmith.benchmarks.studies.kinematics.delta_exact import (
    ExactDelta,
    differences,
    floats,
)
from bladesmith.dynamics import screw_coordinates
from bladesmith.kinematics.delta.robot import DeltaRobot

from ..support.scripts import script

NAMES = ("delta", "chains", "mechanisms", "reaching")
#: Usual lengths, a platform larger than the base, and a needle.
LENGTHS = [delta.LENGTHS, (0.1, 0.35, 0.6, 1.1), (0.3, 0.25, 0.02, 1.0)]
ANGLES = [(0.2, -0.1, 0.7), (0.9, 0.4, 0.1)]


def seeded(seed=3):
    return np.random.default_rng(seed)


def named(study, start):
    return next(case for case in study.cases if case.name.startswith(start))


# -- truths ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("lengths", LENGTHS)
@pytest.mark.parametrize("angles", ANGLES)
def test_exact_deltas_keep_their_lengths(lengths, angles):
    digits = ExactDelta(DeltaRobot(*lengths))
    theta = digits.numbers(angles)
    y, small = digits.forward(theta), digits.mp.mpf(10) ** -45
    centers = digits.centers(theta)
    for a in centers:
        assert abs(digits.mp.sqrt(dot(subtract(y, a), subtract(y, a))) - digits.mp.mpf(lengths[3])) < small
    normal = cross(subtract(centers[1], centers[0]), subtract(centers[2], centers[0]))
    assert dot(normal, subtract(y, centers[0])) > 0  # far: beyond the elbows, which run counter-clockwise
    assert max(abs(a - b) for a, b in zip(digits.inverse(y), theta, strict=True)) < small


@pytest.mark.parametrize("lengths", LENGTHS)
def test_exact_jacobians_are_differences_of_50_digits(lengths):
    digits = ExactDelta(DeltaRobot(*lengths))
    theta = digits.numbers(ANGLES[0])
    y, step = digits.forward(theta), digits.mp.mpf(10) ** -16
    for found, solve, x in (
        (digits.forward_jacobian(theta), digits.forward, theta), (digits.inverse_jacobian(y), digits.inverse, y)
    ):  # fmt: skip
        truth = differences(digits.mp, solve, x, step)
        assert max(abs(a - b) for p, q in zip(found, truth, strict=True) for a, b in zip(p, q, strict=True)) < 1e-25


def test_poses_that_are_not_there_have_no_truth():
    digits = ExactDelta(DeltaRobot(*delta.LENGTHS))
    far, apart = digits.numbers((0, 0, 9)), ExactDelta(DeltaRobot(3, 1, 2, 1.5)).forward(digits.numbers((0, 0, 0)))
    assert digits.inverse(far) is None and digits.inverse_jacobian(far) is None and apart is None
    assert np.isnan(floats(None, (3, 3))).all()


def test_exact_arms_are_products_of_exponentials():
    arm = chains.random(seeded(), 2, 4)
    digits, mp = arm.digits, arm.digits.mp
    for q in arm.q:
        pose = mp.eye(4)
        columns = []
        for a, p, x in zip(digits.axes, digits.positions, q, strict=True):
            here = [dot(list(pose[k, :3]), a) for k in range(3)]
            at = [dot(list(pose[k, :3]), p) + pose[k, 3] for k in range(3)]
            columns.append((here, at))
            v = cross(p, a)
            twist = mp.matrix([[0, -a[2], a[1], v[0]], [a[2], 0, -a[0], v[1]], [-a[1], a[0], 0, v[2]], [0, 0, 0, 0]])
            pose = pose * mp.expm(twist * mp.mpf(float(x)))
        pose = pose * mp.matrix(
            [[1, 0, 0, digits.tool[0]], [0, 1, 0, digits.tool[1]], [0, 0, 1, digits.tool[2]], [0, 0, 0, 1]]
        )
        truth = np.array(pose.tolist(), float)[:3]
        assert np.abs(digits.matrix(q) - truth).max() < 1e-15
        tool = [pose[k, 3] for k in range(3)]
        exact = np.array([[float(c) for c in (*a, *cross(a, subtract(tool, p)))] for a, p in columns]).T
        assert np.abs(digits.jacobian(q) - exact).max() < 1e-15


def test_arms_with_axes_of_any_length():
    arm = chains.six_at(seeded().uniform(-3, 3, (1, 6)))
    longer = ExactArm(arm.positions, 7 * arm.directions, arm.tool)
    assert np.array_equal(longer.matrix(arm.q[0]), arm.digits.matrix(arm.q[0]))


# -- the Delta robot ---------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("back", [False, True])
@pytest.mark.parametrize("away", [0.0, 10.0])
def test_all_ways_to_its_jacobians(back, away):
    asked = delta.usual(seeded(), 3, is_inverse=back, away=away, is_swept=False)
    for method in delta.STUDY.methods:
        found = method.run(asked, method.settings[1] if len(method.settings) > 1 else None)
        if found is None:
            assert away and ("rods" in method.name or method.name.startswith(("direct", "differences")))
            continue
        assert found.shape == (3, 3, 3)
        limit = 1e-7 if method.name == "differences" else 1e-13 * max(1, away) ** 2
        assert delta.error(found, asked.exact, asked).max() < limit, method.name


def test_known_poses_close_all_joints():
    asked = delta.usual(seeded(), 2, unit=1e-3, away=3e-3)
    mechanism, poses, *_ = asked.jointed_robot
    for i in range(2):
        moved = mechanism.at({name: poses[name][i] for name in mechanism.moving})
        assert moved.residual() < 1e-12
        platform = (poses["platform"][i] >> cga.point(asked.jointed_robot.point)).parameters().xyz
        assert np.abs(platform - asked.known_pose[1][i] - asked.position).max() < 1e-12


def test_the_thesis_matrix_allows_what_the_joints_allow():
    asked = delta.usual(seeded(), 1, away=1.0)
    (matrix,) = delta_joints.constraints(asked.points, asked.position)
    assert matrix.shape == (51, 60) and np.linalg.matrix_rank(matrix) == 51
    mechanism, poses, *_ = asked.jointed_robot
    moved = mechanism.at({name: poses[name][0] for name in mechanism.moving})
    assert moved.mobility() == 9
    for motion in moved.free_motions():
        twists = np.concatenate([screw_coordinates(motion[name]) for name in mechanism.moving])
        assert np.abs(twists).max() > 1e-3 and np.abs(matrix @ twists).max() < 1e-11 * np.abs(twists).max()


@pytest.mark.parametrize("back", [False, True])
@pytest.mark.parametrize("condition", [1e2, 1e6, 1e8])
def test_poses_are_as_near_to_singular_ones_as_is_said(back, condition):
    asked = delta.singular(seeded(), 3, condition, back)
    assert (np.abs(np.log10(asked.condition / condition)) < 0.5).all()
    assert f"condition number {asked.condition[1]:.3g}" in delta.describe(asked, 1)


def test_errors_of_jacobians_are_relative_and_nothing_right_is_lost():
    asked = delta.usual(seeded(), 4)
    found = asked.exact.copy()
    found[1] *= 1.001
    found[2] = -found[2]
    found[3, 0, 0] = np.nan
    error = delta.error(found, asked.exact, asked)
    assert error[0] == 0 and np.isclose(error[1], 1e-3, rtol=1e-9) and np.isinf(error[2:]).all()


def measured(method, case, error, ns, lost=0, setting=""):
    return Measurement(method, "", setting, case, "ordinary", 1, error, "", lost, "", ns, "")


def test_the_table_has_times_and_largest_errors():
    rows = [
        measured("direct", "forward Jacobian", 1e-16, 80.0),
        measured("direct" + delta.SINGLY, "forward Jacobian", 1e-16, 9000.0),
        measured("direct", "condition number of J 1e+08", 1e-3, 80.0, lost=1),
        measured("differences", "forward Jacobian", 1e-6, 400.0, setting="0.001"),
        measured("differences", "forward Jacobian", 1e-10, 500.0, setting="1e-05"),
    ]
    first, second = delta.table(rows)
    assert (first.method, first.batch, first.single) == ("direct", 80.0, 9000.0)
    assert first.errors["J"] == 1e-16 and first.errors["J, 1e8"] == 1e-3 and np.isnan(first.errors["J*"])
    assert first.lost["J, 1e8"] == 1 and not first.lost["J"]
    assert second.errors["J"] == 1e-10 and np.isnan(second.single)
    assert set(delta.COLUMNS) <= {case.name for case in delta.STUDY.cases}


# -- chains and mechanisms ---------------------------------------------------------------------------------


@pytest.mark.parametrize("what", ["pose", "jacobian"])
def test_all_ways_along_an_arm(what):
    arm = chains.six(seeded(), 3, quantity=what, away=2.0)
    for method in chains.STUDY.methods:
        if method.requires and harness.optional_module(method.requires) is None:
            continue
        found = method.run(arm, None)
        assert chains.error(found, arm.exact, arm).max() < 2e-14, method.name
    wrong = arm.exact.copy()
    wrong[0] = -wrong[0]
    wrong[1] = np.nan
    assert np.isinf(chains.error(wrong, arm.exact, arm)[:2]).all()


def test_chains_are_studied_without_pinocchio(monkeypatch):
    monkeypatch.setattr(runner, "optional_module", lambda name: None)
    monkeypatch.setattr(harness, "find_spec", lambda name: None)
    assert chains.STUDY.missing_packages == ["pinocchio"]
    rows = run_study(replace(chains.STUDY, cases=chains.STUDY.cases[1:2], count=1), quick=True)
    assert len(rows) == 3 and not any("Pinocchio" in row.method for row in rows)
    assert all(row.max_error < 1e-14 and not row.lost for row in rows)


@pytest.mark.parametrize(("make", "size", "bodies"), [(mechanisms.chain, 12, 12), (mechanisms.ladder, 5, 15)])
def test_grown_mechanisms_both_ways(make, size, bodies):
    grown = make(seeded(), 1, float(size))
    assert grown.mobility == size and len(grown.bodies) == bodies + 1
    for solve in (mechanisms.by_loops, mechanisms.by_singular_values):
        mobility, jacobian = solve(grown)
        assert mobility == size and mechanisms.error((grown, (mobility, jacobian)), None, grown)[0] < 1e-12
        for wrong in ((size + 1, jacobian), (size, -jacobian)):
            assert np.isinf(mechanisms.error((grown, wrong), None, grown)[0])
    assert mechanisms.describe(grown, 0).startswith(f"{bodies} bodies")


def test_dense_matrices_are_left_out_where_they_take_long():
    assert mechanisms.by_singular_values(mechanisms.chain(seeded(), 1, 101.0)) is None


def test_long_chains_and_ladders_stay_exact():
    for make, size in ((mechanisms.chain, 300.0), (mechanisms.ladder, 60.0)):
        grown = make(seeded(), 1, size)
        assert mechanisms.error((grown, mechanisms.by_loops(grown)), None, grown)[0] < 1e-11


def test_families_are_run_by_size(monkeypatch):
    monkeypatch.setattr(mechanisms, "SIZES", (9, 102))
    inputs = mechanisms.family(seeded(), 1, mechanisms.ladder, 3)
    for solve, sizes in ((mechanisms.by_loops, (9, 102)), (mechanisms.by_singular_values, (9,))):
        found = {n: mechanisms.run(inputs, n, solve=solve) for n in (None, 9, 102)}
        assert tuple(n for n, x in found.items() if x is not None) == sizes
        for n in sizes:
            assert len(found[n][0].bodies) == n + 1 and mechanisms.error(found[n], None, inputs)[0] < 1e-12
    one = inputs.by_size[9]
    assert mechanisms.run(one, 9, solve=mechanisms.by_loops) is None
    assert mechanisms.run(one, None, solve=mechanisms.by_loops)[1][0] == 3


# -- reaching ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("what", ["angles", "position"])
@pytest.mark.parametrize("steps", [1, 4])
def test_poses_of_a_delta_are_reached(what, steps):
    goal = mechanisms_reaching.delta_goals(seeded(), 3, 0.4, what)
    found = mechanisms_reaching.by_newton(goal, None, steps=steps)
    assert mechanisms_reaching.error(found, goal.exact, goal).max() < 1e-12
    assert mechanisms_reaching.plain(goal, 5) is None and mechanisms_reaching.by_chain(goal, 5, attempts=1) is None


def test_poses_of_an_arm_are_reached_and_fewer_steps_come_less_near():
    goal = mechanisms_reaching.arm_goals(seeded(), 5, 0.1)
    errors = [
        mechanisms_reaching.error(mechanisms_reaching.by_chain(goal, n, attempts=1), goal.exact, goal).max()
        for n in (4, 60)
    ]
    assert errors[1] < 1e-14 < errors[0]
    plain = [mechanisms_reaching.error(mechanisms_reaching.plain(goal, n), goal.exact, goal).max() for n in (2, 4, 8)]
    assert plain[0] > 100 * plain[1] and plain[2] < 1e-14
    assert mechanisms_reaching.by_newton(goal, None) is None
    nothing = np.full_like(goal.q, np.nan)
    assert np.isinf(mechanisms_reaching.error(nothing, goal.exact, goal)).all()
    elsewhere = goal.q + 0.1
    assert np.isinf(mechanisms_reaching.error(elsewhere, goal.exact, goal)).all()


# -- studies -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", NAMES)
def test_studies_are_listed_and_their_cases_can_be_made(name):
    study = load_study(name)
    assert study.name == name and len({case.name for case in study.cases}) == len(study.cases)
    assert any(not case.sweep for case in study.cases) and any(case.sweep for case in study.cases)
    for case in study.cases:
        if not case.sweep or case.sweep[1] <= 1e3:
            inputs = case.make(seeded(), 2)
            assert 1 <= len(inputs) <= 2 and study.describe(inputs, 0)


@pytest.mark.slow
def test_a_small_study_of_the_delta_runs():
    kept = ("direct", "screws, elimination", "differences")
    methods = tuple(replace(m, prepare=None) for m in delta.STUDY.methods if m.name in kept)
    cases = (named(delta.STUDY, "inverse Jacobian"), named(delta.STUDY, "condition number of J* 1e+04"))
    rows = run_study(replace(delta.STUDY, methods=methods, cases=cases), quick=True)
    assert {row.case for row in rows} == {case.name for case in cases}
    lines = {line.method: line for line in delta.table(rows)}
    assert tuple(lines) == kept
    assert lines["direct"].errors["J*, 1e4"] < 1e-14 < lines["screws, elimination"].errors["J*, 1e4"] < 1e-10
    assert all(line.errors["J*"] < 1e-8 for line in lines.values()) and lines["differences"].lost["J*, 1e4"] > 0


# -- peers of the benchmark --------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def bench():
    with script("benchmarks", "bench_kinematics") as module:
        yield module


@pytest.mark.slow
@pytest.mark.parametrize("peer", ["numba", "NumPy", "clifford, pose by pose"])
def test_peers_solve_the_same_problems(bench, peer):
    package, make, most = bench.peers.PEERS[peer]
    if importlib.util.find_spec(package) is None:
        pytest.skip(f"{package} is not installed")
    robot = DeltaRobot(*delta.LENGTHS)
    theta = np.array(ANGLES[: 1 if most else 2])
    for work in bench.peers.WORKS[: 2 if most else 4]:  # clifford's Jacobians are differences of these
        given = theta if work.startswith("forward") else robot.forward(theta)
        solve = make(delta.LENGTHS, work)
        found = solve(given) if most is None else np.stack([solve(x) for x in given])
        assert bench.off(found, getattr(robot, work)(given)) < 1e-14, work


def test_rows_are_told_with_bars_and_ratios(bench):
    first, second, third = bench.compared([
        {"method": "a", "ns": 50.0, "error": 1e-15, "bar": 40.0}, {"method": "b", "ns": 100.0}, {"method": "c: skipped"}
    ])  # fmt: skip
    with script("benchmarks", "timing") as timing:
        lines = [timing.row_text(row) for row in (first, second, third)]
    assert lines[0].endswith("bar 40 ns MISSED") and "times" not in lines[0]
    assert lines[1].endswith("2 times") and lines[2].strip() == "c: skipped"


def test_peers_that_are_missing_are_said_to_be(bench, monkeypatch):
    monkeypatch.setattr(bench.peers, "find_spec", lambda name: None)
    monkeypatch.setattr(bench, "seconds", lambda run, repeats=1: 1e-6)
    monkeypatch.setattr(bench, "BATCH", bench.LOOKED_AT)
    options = type("Options", (), {"skip_clifford": False})()
    rows = [row for part in (bench.delta_robot, bench.arm) for row in part(options)]
    assert sum(row["method"].endswith(": skipped") for row in rows) == 4 * 3 + 2 * 2
    assert all(row["error"] < 1e-14 for row in rows if "error" in row)
