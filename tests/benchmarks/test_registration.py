"""Studies of registration: scenes whose pose is known, errors of poses, what others are given, and the studies run."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bladesmith import cga3d
from bladesmith.benchmarks.harness import plot, runner
from bladesmith.benchmarks.harness import study as harness
from bladesmith.benchmarks.harness.runner import Measurement, run_study
from bladesmith.benchmarks.harness.study import Case, Method, Study
from bladesmith.benchmarks.registry import load_study
from bladesmith.benchmarks.studies.registration import claims, pose_peers, poses, registrations, segments, symmetries

NAMES = ("registrations", "robustness", "symmetries", "claims", "coverage", "segments")
EVERY = {"point": 6, "point_pair": 5, "line": 7, "circle": 5, "plane": 6, "sphere": 5}


def distances(points, rows):
    """How far points (n, 3) are from lines (n, 6), by cross products."""
    away = np.cross(points - rows[:, :3], rows[:, 3:])
    return np.linalg.norm(away, axis=1) / np.linalg.norm(rows[:, 3:], axis=1)


def rows_of(results, case, method):
    return [r for r in results if (r.case, r.method) == (case, method)]


# -- scenes ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("displacement", [None, 0.1])
def test_the_pose_of_a_scene_takes_counterparts_to_each_other(displacement):
    scene = poses.scene(np.random.default_rng(1), EVERY, displacement=displacement, outliers=0.3, missing=0.3)
    turn, shift = scene.pose[:3, :3], scene.pose[:3, 3]
    assert np.allclose(turn @ turn.T, np.eye(3), atol=1e-14) and np.linalg.det(turn) > 0
    for kind, true in scene.true.items():
        query, reference = scene.query.parameters[kind], scene.reference.parameters[kind]
        known = true >= 0
        here, there = query[known], reference[true[known]]
        if kind == "line":
            assert np.abs(distances(here[:, :3] @ turn.T + shift, there)).max() < 1e-13
            assert np.allclose(here[:, 3:] @ turn.T, there[:, 3:], atol=1e-13)
        elif kind == "plane":  # the foot of the plane stays in it
            feet = (here[:, :3] * here[:, 3:]) @ turn.T + shift
            assert np.abs((feet * there[:, :3]).sum(1) - there[:, 3]).max() < 1e-13
        else:
            assert np.allclose(here[:, :3] @ turn.T + shift, there[:, :3], atol=1e-13)
        wrong, missing = round(0.3 * EVERY[kind]), round(0.3 * EVERY[kind])
        assert len(query) == EVERY[kind] and len(reference) == EVERY[kind] - missing
        assert EVERY[kind] - wrong - missing <= known.sum() <= EVERY[kind] - max(wrong, missing)
        assert len(set(true[known])) == known.sum()


def test_small_displacements_and_noise_are_as_large_as_was_asked():
    rng = np.random.default_rng(2)
    for asked in (0.01, 0.3, 3.0):
        turn, shift = poses.rigid(rng, asked)
        assert np.isclose(np.arccos((np.trace(turn) - 1) / 2), asked) and np.isclose(np.linalg.norm(shift), asked)
    scene = poses.scene(rng, {"point": 2000}, noise=0.01)
    moved = scene.query.parameters["point"] @ scene.pose[:3, :3].T + scene.pose[:3, 3]
    off = moved - scene.reference.parameters["point"][scene.true["point"]]
    assert 0.0095 < off.std() < 0.0105


def test_errors_of_poses_are_displacements_of_corners():
    scene = poses.scene(np.random.default_rng(3), {"line": 4})
    true = np.tile(scene.pose, (5, 1, 1))
    found = true.copy()
    found[1, :3, 3] += (0.0, 3e-3, 4e-3)
    angle = 0.01  # about the third axis through the models' middle: corners are the root of two from it
    spin = np.eye(4)
    spin[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    found[2] = spin @ true[2]
    found[3, :3, 3] += 1.0
    found[4] = np.nan
    errors = poses.pose_errors(found, true)
    assert errors[0] < 1e-14 and np.isclose(errors[1], 5e-3)
    assert np.isclose(errors[2], 2 * np.sin(angle / 2) * np.sqrt(2)) and np.isclose(errors[3], np.sqrt(3))
    assert errors[4] == np.inf
    assert np.isfinite(poses.right_poses(found, true)).tolist() == [True, True, True, False, False]


@pytest.mark.parametrize("shape", [symmetries.table, symmetries.box, symmetries.prism, symmetries.cube])
def test_symmetries_take_shapes_to_themselves(shape):
    lines, turns = shape()
    assert len(turns) == {"table": 2, "box": 4, "prism": 12, "cube": 24}[shape.__name__]
    assert len({tuple(np.round(t, 9).ravel() + 0.0) for t in turns}) == len(turns)
    for turn in turns:
        assert np.isclose(np.linalg.det(turn), 1)
        places, ways = lines[:, :3] @ turn.T, lines[:, 3:] @ turn.T
        for place, way in zip(places, ways, strict=True):
            along = np.linalg.norm(np.cross(lines[:, 3:], way), axis=1) < 1e-12
            assert (along & (distances(np.tile(place, (len(lines), 1)), lines) < 1e-12)).sum() == 1


def test_true_poses_of_symmetric_scenes_begin_with_the_one_that_was_made():
    made = symmetries.symmetric_scenes(np.random.default_rng(4), 2, symmetries.prism)
    for scene, every in zip(made.items, symmetries.true_symmetric(made), strict=True):
        assert every.shape == (12, 4, 4) and np.allclose(every[0], scene.pose, atol=1e-14)


# -- what others get ---------------------------------------------------------------------------------------


def test_points_for_others_lie_on_the_lines_and_are_never_the_same():
    scene = poses.scene(np.random.default_rng(5), {"line": 8}, displacement=0.1, offset=1.0)
    query, reference = pose_peers.clouds(scene)
    for cloud, model in ((query, scene.query), (reference, scene.reference)):
        rows = model.parameters["line"]
        each = len(cloud) // len(rows)
        assert each == round(2 * poses.HALF_SEGMENT / pose_peers.SPACING)
        assert distances(cloud, np.repeat(rows, each, axis=0)).max() < 1e-13
    moved = query @ scene.pose[:3, :3].T + scene.pose[:3, 3]
    apart = np.linalg.norm(moved[:, None] - reference, axis=-1).min(1)
    assert apart.min() > 1e-6


def test_others_run_where_they_are_installed_and_are_left_out_where_not(monkeypatch):
    scene = poses.scene(np.random.default_rng(6), {"line": 20}, displacement=0.1)
    if harness.optional_module("small_gicp"):
        assert poses.pose_errors(pose_peers.local(scene)[None], scene.pose[None])[0] < 0.01
    if harness.optional_module("open3d"):
        assert poses.pose_errors(pose_peers.anywhere(scene, 10_000)[None], scene.pose[None])[0] < poses.RIGHT
    monkeypatch.setattr(runner, "optional_module", lambda name: None)
    monkeypatch.setattr(harness, "find_spec", lambda name: None)
    small = replace(registrations.STUDY, cases=registrations.STUDY.cases[:1], count=10)
    small = replace(small, methods=tuple(replace(m, settings=m.settings[:1], most=1) for m in small.methods))
    assert [row.method for row in run_study(small)] == ["register", "REFORM by proximity", "iterative matching"]
    assert small.missing_packages == ["clifford", "open3d", "small_gicp"]


@pytest.mark.slow
def test_rotors_of_clifford_become_poses():
    g3c = pytest.importorskip("clifford.g3c")
    motor = cga3d.translator((1.0, -2.0, 0.5)) * cga3d.rotor((1.0, 2.0, 3.0), 1.2)
    (rotor,) = motor.reshape(1).to_clifford(g3c.layout)
    assert np.allclose(pose_peers.clifford_pose(rotor), motor.to_matrix(), atol=1e-14)
    assert np.isnan(pose_peers.clifford_pose(rotor * np.nan)).all()


# -- studies -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", NAMES)
def test_studies_are_listed_and_their_cases_can_be_made(name):
    study = load_study(name)
    assert study.name == name and len({case.name for case in study.cases}) == len(study.cases)
    for case in study.cases[:: 1 if len(study.cases) < 10 else 5]:
        inputs = case.make(np.random.default_rng(0), 2)
        assert len(study.reference(inputs)) == len(inputs.items) == 2 and study.describe(inputs, 1)


def test_registrations_find_what_the_text_does_not():
    study = load_study("registrations")
    ours = tuple(replace(m, settings=m.settings[:1], most=3) for m in study.methods[:3])
    results = run_study(replace(study, methods=ours, cases=study.cases[:2]), quick=True)
    near, anywhere = (case.name for case in study.cases[:2])
    for method in ours:
        (row,) = rows_of(results, near, method.name)
        assert row.lost == 0 and row.max_error < 1e-9 and row.count == 3 and row.nanoseconds > 0
    (row,) = rows_of(results, anywhere, "register")
    assert row.lost == 0 and row.max_error < 1e-9


def test_sweeps_are_run_at_one_setting_and_drawn_with_fractions():
    study = load_study("robustness")
    ours = (replace(study.methods[0], most=2, repeats=0),)
    cases = (study.cases[0], *(c for c in study.cases if c.sweep and c.sweep[1] in (0.1, 0.2)))
    small = replace(study, methods=ours, cases=cases)
    results = run_study(small, quick=True)
    assert {r.setting for r in results} == {str(registrations.USUAL)}
    figure = plot.draw_sweeps(small, results)
    sweeps = {c.sweep[0] for c in cases if c.sweep}
    assert len(figure.axes) == 2 * len(sweeps)
    assert figure.axes[0].get_ylabel() == "fraction not lost"
    heights = np.concatenate([line.get_ydata() for line in figure.axes[0].lines])
    assert ((heights >= 0) & (heights <= 1)).all() and len(heights)


def test_all_poses_of_a_box_are_listed():
    study = load_study("symmetries")
    box = next(c for c in study.cases if c.name.startswith("box"))
    results = run_study(replace(study, methods=tuple(replace(m, most=3) for m in study.methods), cases=(box,)), True)
    assert [r.lost for r in results] == [0, 0, 0]


def test_listed_poses_are_judged_by_what_is_asked():
    made = symmetries.symmetric_scenes(np.random.default_rng(7), 1, symmetries.box)
    true = symmetries.true_symmetric(made)
    other = np.eye(4)
    other[:3, 3] = 2.0
    lists = {"all": true[0], "first": true[0][:1], "others": true[0][1:], "one more": np.stack([*true[0], other])}
    found = {
        (name, criterion): bool(
            np.isfinite(symmetries.error(symmetries.ListedPoses([given], criterion), true, made))[0]
        )
        for name, given in lists.items()
        for criterion in ("one", "all", "only")
    }
    assert [key for key, good in found.items() if not good] == [
        ("first", "all"), ("others", "one"), ("others", "all"), ("one more", "only"),
    ]  # fmt: skip


def test_strangers_are_never_believed():
    study = load_study("claims")
    results = run_study(replace(study, methods=tuple(replace(m, most=8) for m in study.methods),
                                cases=study.cases[:2]), True)  # fmt: skip
    assert [(r.method, r.lost) for r in results] == 2 * [("all poses", 8), ("converged ones", 0)]


def test_false_claims_are_counted():
    scenes = poses.scenes(np.random.default_rng(8), 3, {"line": 5})
    true = poses.true_poses(scenes)
    wrong = true[1].copy()
    wrong[:3, 3] += 1
    answer = claims.Claims([true[:1], wrong[None], wrong[None]], np.array([True, True, False]))
    assert claims.error(answer, true, scenes).tolist() == [pytest.approx(0, abs=1e-14), np.inf, 0.0]


def test_a_window_of_a_front_stands_where_its_pose_says():
    for scene in claims.windows(np.random.default_rng(2), 3, 0.0).items:
        seen = scene.true["line"] >= 0
        assert np.bincount(scene.true["line"][seen]).tolist() == [1] * 5 and len(scene.query) == 15
        assert len(scene.reference) == 30
        turn, shift = scene.pose[:3, :3], scene.pose[:3, 3]
        query, rows = scene.query.parameters["line"][seen], scene.reference.parameters["line"][scene.true["line"][seen]]
        for along in (0, 1):  # two points of each line
            points = (query[:, :3] + along * query[:, 3:]) @ turn.T + shift
            assert distances(points, rows).max() < 1e-12


@pytest.mark.parametrize("is_cut", [False, True])
def test_the_bound_of_segments_is_that_of_their_true_matches(is_cut):
    """Without noise it is the pose; with noise no small motion makes the sum of squares of the ends less."""
    rng = np.random.default_rng(10)
    exact = segments.scenes(rng, 2, count=20, noise=0.0, is_cut=is_cut)
    assert poses.pose_errors(segments.least_squares(exact, None), poses.true_poses(exact)).max() < 1e-12
    (scene,) = segments.scenes(rng, 1, count=20, is_cut=is_cut).items
    pose = segments.least_squares(poses.Scenes([scene]), None)[0]
    begin = scene.reference_ends[:, :1]
    along = (scene.reference_ends[:, 1:] - begin) / np.linalg.norm(scene.reference_ends[:, 1:] - begin, axis=-1)[
        ..., None
    ]

    def squares(matrix):
        off = scene.query_ends @ matrix[:3, :3].T + matrix[:3, 3] - scene.reference_ends
        return ((off - (off * along).sum(-1, keepdims=True) * along * is_cut) ** 2).sum()

    for _ in range(20):
        near = (cga3d.translator(1e-4 * rng.normal(size=3)) * cga3d.rotor(rng.normal(size=3), 1e-4)).to_matrix()
        assert squares(near @ pose) > squares(pose)
    true = scene.true["segment"]
    moved = scene.query.segments[true >= 0] @ scene.pose[:3, :3].T + scene.pose[:3, 3]
    there = scene.reference.segments[true[true >= 0]]
    off = np.cross(moved - there[:, :1], there[:, 1:] - there[:, :1])
    assert np.linalg.norm(off, axis=-1).max() < 5 * segments.NOISE


def test_covariances_are_of_the_size_of_errors():
    from bladesmith.benchmarks.studies.registration import coverage

    inputs = poses.scenes(np.random.default_rng(9), 40, {"line": 20}, noise=1e-2)
    squares = coverage.squared_radii(inputs, None)
    assert 2 < np.median(squares) < 9  # chi squared with six degrees of freedom has 5.3
    assert np.isinf(coverage.error(np.array([12.5, 12.7, np.nan]), squares, inputs)).tolist() == [False, True, True]


def test_methods_that_take_long_get_few_items_and_runs():
    calls, ready = [], []

    def run(inputs, setting):
        calls.append(len(inputs))
        return inputs

    long = Method("long", run, most=4, repeats=0, prepare=lambda: ready.append(len(calls)))
    case = Case("c", lambda rng, count: rng.random(count))
    study = Study("s", "S", (long,), (case,), lambda x: x, lambda a, b, c: np.abs(a - b), "units")
    (row,) = run_study(study)
    assert isinstance(row, Measurement) and row.count == 4 and calls == [4] and ready == [0]
