"""Studies of integrators: references against a second method, errors that fall as they should, what "auto" takes, and
peers that solve the same problems."""

from __future__ import annotations

import importlib.util
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from bladesmith.benchmarks.harness.runner import Measurement, run_study
from bladesmith.benchmarks.registry import load_study
from bladesmith.benchmarks.studies.dynamics import (
    drift,
    exact_motions,
    integrators,
    lanes,
    pendulums,
    stiffness,
    tops,
    violations,
)

from ..support.scripts import script

NAMES = ("tops", "pendulums", "drift", "violations", "stiffness", "lanes")
GRAVITY = np.array([0.3, -1.0, -9.0])
UNEQUAL = np.array([1.0, 2.0, 2.5])


def cross_matrix(w):
    return np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])


def integrated(mass, moments, arm, gravity, rotation, spin, t):
    """Newton and Euler about the point that stays, with matrices, by scipy."""
    inertia = np.diag(moments) + mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))

    def rates(_, state):
        turn, w = state[:9].reshape(3, 3), state[9:]
        moment = np.cross(inertia @ w, w) + np.cross(arm, mass * (turn.T @ gravity))
        return np.concatenate([(turn @ cross_matrix(w)).ravel(), np.linalg.solve(inertia, moment)])

    start = np.concatenate([rotation.ravel(), spin])
    end = solve_ivp(rates, (0, t), start, "DOP853", rtol=2.3e-14, atol=1e-15).y[:, -1]
    return end[:9].reshape(3, 3), end[9:]


def motions_of(case, count=1):
    return case.make(np.random.default_rng(3), count)


# -- references --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("order", [(0, 1, 2), (2, 1, 0), (1, 0, 2), (2, 0, 1)])
@pytest.mark.parametrize("spin", [(1.0, 2.0, 3.0), (3.0, -0.2, -0.5), (-0.3, -2.0, 0.1)])
def test_elliptic_functions_and_power_series_are_one(order, spin):
    moments, spin, none = UNEQUAL[list(order)], np.array(spin), np.zeros((1, 3))
    turn, w = exact_motions.free_top(moments, spin, 1.5)
    turns, ws = exact_motions.turning(np.ones(1), moments[None], none, none[0], np.eye(3)[None], spin[None], 1.5)
    assert np.abs(turn - turns[0]).max() < 1e-15 and np.abs(w - ws[0]).max() < 1e-15


@pytest.mark.parametrize("moments", [(1.0, 1.0, 1.8), (1.0, 2.0, 2.0), (1.0, 1e6, 1e6 + 0.5), (1e-6, 2e-6, 2.5e-6)])
def test_momentum_and_energy_of_free_tops_stay(moments):
    moments, spin = np.array(moments), np.array([1.0, 0.3, 0.2])
    turn, w = exact_motions.free_top(moments, spin, 30.0)
    assert np.abs(turn @ turn.T - np.eye(3)).max() < 1e-15
    momentum = moments * spin
    assert np.linalg.norm(turn @ (moments * w) - momentum) < 1e-15 * np.linalg.norm(momentum)
    assert np.isclose((moments * w) @ w, momentum @ spin, rtol=1e-15)


def test_heavy_bodies_obey_newton_and_euler():
    rng = np.random.default_rng(1)
    mass, moments, arm = np.array([2.0, 0.5]), np.array([[1, 2, 2.5], [0.3, 0.4, 0.5]]), rng.normal(size=(2, 3))
    rotation, spin = integrators.rotations(rng, 2), rng.normal(size=(2, 3)) * 3
    turns, ws = exact_motions.turning(mass, moments, arm, GRAVITY, rotation, spin, 2.0)
    for i in range(2):
        turn, w = integrated(mass[i], moments[i], arm[i], GRAVITY, rotation[i], spin[i], 2.0)
        assert np.abs(turns[i] - turn).max() < 1e-12 and np.abs(ws[i] - w).max() < 1e-11


@pytest.mark.parametrize(("angle", "rate"), [(0.3, 0.0), (2.9, 3.0), (1.0, 9.0), (-1.0, -9.0), (0.0, 0.4), (0.0, 0.0)])
def test_pendulums_obey_their_equation(angle, rate):
    end = solve_ivp(lambda t, y: (y[1], -7.5 * np.sin(y[0])), (0, 5), (angle, rate), "DOP853", rtol=2.3e-14, atol=1e-15)
    assert np.allclose(exact_motions.pendulum(7.5, angle, rate, 5.0), end.y[:, -1], rtol=0, atol=2e-11)


@pytest.mark.parametrize("case", pendulums.STUDY.cases[:3], ids=lambda case: case.name)
def test_truths_of_pendulums_are_motions_about_what_stays(case):
    inputs = replace(motions_of(case), duration=1.0)
    found = integrators.truth(inputs)
    given = (inputs.mass[0], inputs.moments[0], inputs.arm[0], integrators.GRAVITY, inputs.rotation[0])
    if inputs.held == "point":
        turn, w = integrated(*given, inputs.spin[0], 1.0)
    else:  # a line along the second axis: the equations about the point hold but for what the line takes
        assert np.abs(inputs.rotation[0, :, 1] - [0, 1, 0]).max() < 1e-15 and np.abs(inputs.arm[0, 1]) == 0
        turn, w = integrated(*given, inputs.spin[0], 1.0)
    assert np.abs(found.orientation[0] - turn).max() < 1e-12 and np.abs(found.spin[0] - w).max() < 1e-11
    assert np.allclose(found.position[0], turn @ inputs.arm[0], atol=1e-12)


# -- errors ------------------------------------------------------------------------------------------------


def test_errors_are_angles_and_fractions():
    inputs = motions_of(tops.STUDY.cases[3], 4)
    exact = integrators.truth(replace(inputs, duration=0.1))
    angle = 1e-3
    turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    orientation, spin, position = exact.orientation.copy(), exact.spin.copy(), exact.position.copy()
    orientation[0] = turn @ orientation[0]
    spin[1] *= 1.01
    position[2] += (0, 0, 0.02 * np.linalg.norm(inputs.arm[2]))
    orientation[3] = np.nan
    found = integrators.error(integrators.States(orientation, spin, position), exact, inputs)
    assert np.allclose(found[:3], [1e-3, 0.01, 0.02], rtol=1e-6) and found[3] == np.inf
    assert np.isinf(integrators.error(replace(exact, spin=1.2 * exact.spin), exact, inputs)).all()


@pytest.mark.compiles
@pytest.mark.parametrize(
    ("name", "order", "few"),
    [("rk4", 4, 250), ("rkmk4", 4, 250), ("cf4", 4, 250), ("midpoint", 2, 1000), ("strang", 2, 250),
     ("blanes-moan", 4, 60), ("yoshida6", 6, 60)],
)  # fmt: skip
def test_errors_fall_with_the_order(name, order, few):
    inputs = replace(motions_of(tops.STUDY.cases[5]), duration=2.0)
    exact = integrators.truth(inputs)
    errors = [
        integrators.error(integrators.integrate(inputs, n, integrator=name), exact, inputs)[0] for n in (few, 2 * few)
    ]
    assert 0.75 * 2**order < errors[0] / errors[1] < 1.35 * 2**order


def short(case):
    """One body; of what takes long a fifth."""
    inputs = motions_of(case)
    return replace(inputs, duration=inputs.duration / 5) if np.abs(inputs.spin).max() > 1e3 else inputs


CASES = [c for study in (tops, pendulums, stiffness) for c in study.STUDY.cases if not c.sweep]


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_what_auto_takes_is_exact_everywhere(case):
    inputs = short(case)
    found = integrators.integrate(inputs, None, integrator="auto")
    assert integrators.error(found, integrators.truth(inputs), inputs)[0] < 1e-8
    (chosen,) = inputs.chosen
    assert integrators.describe(inputs, 0).endswith(f"auto takes {chosen}")


def test_what_has_no_flows_is_left_out():
    (hinge,) = (c for c in pendulums.STUDY.cases if c.name.startswith("on a line, to"))
    assert integrators.integrate(motions_of(hinge), 60, integrator="yoshida6") is None
    assert integrators.integrate(motions_of(hinge), None, integrator="rk4") is None


def test_copies_are_the_same_motion():
    inputs = motions_of(tops.STUDY.cases[4], 2)
    one, many = (integrators.integrate(inputs, 250, integrator="rk4", copies=n) for n in (1, 3))
    assert len(many.spin) == 2 and np.array_equal(one.orientation, many.orientation)


# -- studies -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", NAMES)
def test_studies_are_listed_and_their_cases_can_be_made(name):
    study = load_study(name)
    assert study.name == name and len({case.name for case in study.cases}) == len(study.cases)
    assert any(not case.sweep for case in study.cases) and all(method.most for method in study.methods)
    for case in study.cases:
        inputs = case.make(np.random.default_rng(0), 1)
        assert len(inputs) == 1 and study.describe(inputs, 0).startswith("moments (")


def test_a_small_study_runs_and_is_judged():
    methods = [m for m in tops.STUDY.methods if m.name in ("rk4", "auto")]
    small = replace(
        tops.STUDY, cases=tops.STUDY.cases[4:5],
        methods=tuple(replace(m, settings=m.settings[:2], most=1, repeats=0) for m in methods),
    )  # fmt: skip
    rows = run_study(small)
    assert [(r.method, r.setting) for r in rows] == [("rk4", "250"), ("auto", "")]
    (verdict,) = integrators.verdicts(rows, 1e-3)
    assert verdict.error < 1e-8 and verdict.fastest is verdict.exactest is rows[0]


def row(method, error, ns, lost=0, worst=""):
    return Measurement(method, "", "", "c", "ordinary", 1, error, worst, lost, "x; auto takes a", ns, "")


@pytest.mark.compiles
def test_batches_on_lanes_have_the_errors_of_those_one_at_a_time():
    motions = motions_of(lanes.STUDY.cases[1], lanes.COUNT)
    methods = {m.name: m for m in lanes.STUDY.methods}
    for name in ("rk4", "taylor"):
        setting = lanes.INTEGRATORS[name][1][0]
        one, several = (methods[f"{name}, {how}"].run(motions, setting) for how in ("one at a time", "on lanes"))
        for field in ("orientation", "spin", "position"):
            assert np.array_equal(getattr(one, field), getattr(several, field))


def test_verdicts_name_the_fastest_that_is_right_and_the_most_exact():
    rows = [row("a", 1e-3, 1.0), row("b", 1e-10, 2.0), row("c", 1e-14, 9.0), row("d", 0.0, 0.1, lost=1)]
    (verdict,) = integrators.verdicts([*rows, row("auto", 1e-12, 5.0, worst="y; auto takes b")])
    assert (verdict.chosen, verdict.error, verdict.fastest.method, verdict.exactest.method) == ("b", 1e-12, "b", "c")
    (verdict,) = integrators.verdicts([row("auto", float("nan"), 5.0, lost=1)])
    assert (verdict.chosen, verdict.error, verdict.fastest) == ("a", np.inf, None)


def test_flows_keep_energy_and_momentum_and_runge_kutta_does_not():
    cases = drift.study((3000.0,)).cases
    for case in cases:
        if case.sweep or "heavy" not in case.name:
            continue
        inputs = motions_of(case)
        kept = drift.largest_drift(inputs, None, integrator="yoshida6")[0]
        lost = drift.largest_drift(inputs, None, integrator="rk4")[0]
        assert kept < 1e-10 and lost > 10 * kept
    assert np.isinf(drift.STUDY.error(np.array([1.5, np.nan]), np.zeros(2), inputs)).all()


def test_long_runs_that_end_early_are_lost(monkeypatch):
    inputs = motions_of(drift.STUDY.cases[0])

    class Cut:
        time = np.zeros(3)

    monkeypatch.setattr(integrators, "run_if_possible", lambda *given, **options: Cut())
    assert drift.largest_drift(inputs, None, integrator="rk4").tolist() == [np.inf]


@pytest.mark.compiles
@pytest.mark.parametrize("way", violations.METHODS)
def test_violations_by_how_constraints_are_kept(way):
    found = {}
    for case in violations.STUDY.cases:
        if case.sweep and case.sweep[1] == 1e3:
            inputs = motions_of(case)
            answer = violations.integrate_constrained(inputs, None, method=way)
            found[inputs.held] = None if answer is None else violations.error(answer, 0, inputs)[0]
            assert violations.integrate_constrained(inputs, 250, method=way) is None
    if way == "null-space":
        assert found.pop("sphere") is None
    assert set(found) >= {"line", "point"}
    limit = 1e-12 if way in ("null-space", "projection") else 1e-2
    assert all(value < limit for value in found.values())
    if way == "none":
        assert found["sphere"] > 1e-9


@pytest.mark.slow
def test_the_ways_to_keep_constraints_give_one_motion():
    inputs = replace(motions_of(violations.STUDY.cases[1]), duration=1.0)
    exact = integrators.truth(inputs)
    errors = [
        violations.error(violations.integrate_constrained(inputs, 1000, method=way), exact, inputs)[0]
        for way in violations.METHODS
    ]
    assert max(errors) < 1e-9


# -- peers of the benchmark --------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def bench():
    with script("benchmarks", "bench_dynamics") as module:
        yield module


#: Peers of the `benchmark` extra are tested where they are installed.
PEERS = {
    "heyoka": "heyoka", "numba RK4": "numba", "scipy DOP853": "scipy", "MuJoCo RK4": "mujoco",
    "Pinocchio, RK4 in Python": "pinocchio",
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("peer", [name for name, module in PEERS.items() if importlib.util.find_spec(module)])
def test_peers_solve_the_same_problems(bench, peer):
    package, make, _ = bench.peers.PEERS[peer]
    assert package == PEERS[peer]
    for top in (bench.FREE, bench.HEAVY):
        top = replace(top, duration=1.0)
        end = make(top, 1e-8 if peer in ("heyoka", "scipy DOP853") else 500)()
        assert bench.off(bench.rotation(end[0]), np.array(end[1]), bench.truth(top)) < 1e-6


def test_ours_are_the_same_problems_too(bench):
    for top in (bench.FREE, bench.HEAVY):
        top = replace(top, duration=1.0)
        end = bench.simulation_of(top, integrator="auto").run(1.0, times=[1.0])
        assert bench.off(end.orientation[-1], end.angular_velocity[-1], bench.truth(top)) < 1e-9


def test_peers_that_are_missing_are_said_to_be(bench, monkeypatch):
    monkeypatch.setattr(bench.peers, "find_spec", lambda name: None)
    assert [(setting, run) for _, setting, run in bench.peers.runs(bench.FREE)] == 6 * [("not installed", None)]
