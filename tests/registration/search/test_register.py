"""Registration of models: poses and matches over many scenes, symmetric models, and input that tells no pose."""

from __future__ import annotations

import numpy as np
import pytest

from bladesmith import cga3d, registration
from bladesmith.errors import BladesmithError, InputError, SingularError, UndeterminedError
from bladesmith.registration import Model, register
from bladesmith.registration.estimation.refinement import refine_pose
from bladesmith.registration.model.normalization import motors_to_world, scale_coefficients
from bladesmith.registration.search.problem import RegistrationProblem

from ...support.effort import seeds
from ...support.registration import (
    apart,
    fresh,
    lines_and_planes,
    moved,
    noisy,
    pose,
    right,
    scene,
    seen,
    table,
)
from ...support.vectors import unit

KINDS = ("points", "point_pairs", "lines", "circles", "planes", "spheres")
Z = np.array([0.0, 0.0, 1.0])


def allowed(count, share):
    """How many of so many scenes may fail, at a bar."""
    return int(count * (1 - share) + 1e-9)


# -- bars ------------------------------------------------------------------------------------------------------


@pytest.mark.compiles
@pytest.mark.parametrize("spec", [{"lines": 20}, {"lines": 10, "planes": 10}, {"lines": 60}])
@pytest.mark.parametrize("wrong", [0.0, 0.3])
def test_exact_scenes_are_exact(spec, wrong):
    failed, range_ = 0, seeds(30, 200)
    for seed in range_:
        query, reference, motor, true = scene(spec, seed, wrong, wrong)
        found = register(query, reference, threads=1)
        failed += apart(found.motor, motor) > 1e-9 or not right(found, true) or not found.converged
    assert failed <= allowed(len(range_), 0.99)


@pytest.mark.slow
@pytest.mark.parametrize("n", [20, 100, 400])
@pytest.mark.parametrize(("noise", "wrong"), [(1e-3, 0.3), (1e-2, 0.0), (1e-2, 0.3)])
def test_any_displacement(n, noise, wrong):
    failed, range_ = 0, seeds(30 if n < 400 else 8, 200)
    for seed in range_:
        query, reference, motor, _ = scene({"lines": n}, seed, wrong, wrong, noise)
        found = register(query, reference, threads=1)
        failed += apart(found.motor, motor) > 10 * noise
    assert failed <= allowed(len(range_), 0.98)


@pytest.mark.compiles
@pytest.mark.parametrize("kind", KINDS)
def test_every_kind(kind):
    for seed in seeds(4, 100):
        query, reference, motor, true = scene({kind: 30}, seed, 0.3, 0.3)
        found = register(query, reference, threads=1)
        assert found.converged and apart(found.motor, motor) < 1e-9 and right(found, true)


@pytest.mark.compiles
def test_all_kinds_together():
    query, reference, motor, true = scene(dict.fromkeys(KINDS, 8), 3, 0.25, 0.25, 1e-3)
    found = register(query, reference, threads=1)
    assert found.converged and apart(found.motor, motor) < 3e-3
    assert sum((found.matches[kind] != rows).sum() for kind, rows in true.items()) <= 2


def least(query, reference, motor, true):
    """The motor of the least positive cost over the true matches."""
    problem = RegistrationProblem(query, reference, threads=1)
    to, back = cga3d.translator(-problem.reference.center), cga3d.translator(problem.query.center)
    start = scale_coefficients(to * motor * back, 1 / problem.reference.unit)._data.reshape(-1)
    pairs = {k.removesuffix("s"): (np.flatnonzero(m >= 0), m[m >= 0]) for k, m in true.items()}
    found = refine_pose(problem.scene, problem.driver, start, pairs)
    return motors_to_world(problem.driver, found.motor[None], problem.query, problem.reference, problem.algebra)[0]


@pytest.mark.slow
@pytest.mark.parametrize("wrong", [0.0, 0.3])
def test_noise_costs_no_more_than_it_must(wrong):
    """Twenty lines: a start at too small a tolerance must not end in a few matches."""
    worse, range_ = 0, seeds(60, 300)
    for seed in range_:
        query, reference, motor, true = scene({"lines": 20}, seed, wrong, wrong, (1e-2, 3e-3)[seed % 2])
        found = register(query, reference, threads=1)
        worse += apart(found.motor, motor) > 2 * apart(least(query, reference, motor, true), motor)
    assert worse <= allowed(len(range_), 0.98)


def test_a_query_whose_first_objects_have_no_counterpart_is_found():
    """Motors are given up early where few of the first objects meet: not always the same ones."""
    query, reference, motor, _ = scene({"lines": 100}, 58, 0.3, 0.3, 1e-3)
    found = register(query, reference, threads=1)
    assert found.converged and apart(found.motor, motor) < 1e-2


# -- symmetric models ------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("noise", [0.0, 1e-3, 1e-2])
@pytest.mark.parametrize("missing", [0.0, 0.2])
def test_a_table_has_two_poses(noise, missing):
    failed = claimed = 0
    range_ = seeds(25, 200)
    for seed in range_:
        rng = np.random.default_rng([seed, 9])
        lines = table()
        query, motor, _ = seen({"lines": lines}, rng, noise)
        kept = rng.permutation(len(lines))[int(missing * len(lines)) :]
        found = register(Model(**query), Model(lines=lines[kept]), threads=1, seed=seed)
        poses = [found.motor, *found.ambiguous]
        failed += min(apart(r, motor) for r in poses) > max(10 * noise, 1e-9)
        claimed += found.converged
        assert all(apart(a, b) > 1e-3 for i, a in enumerate(poses) for b in poses[:i])
    assert failed <= allowed(len(range_), 0.99)
    assert claimed >= 0.9 * len(range_)


def test_the_second_pose_is_the_first_half_a_turn_later():
    query, motor, _ = seen({"lines": table()}, np.random.default_rng(3))
    found = register(Model(**query), Model(lines=table()), threads=1)
    turn = cga3d.rotor(Z, np.pi)
    assert len(found.ambiguous) == 1
    assert apart(turn * found.motor, found.ambiguous[0]) < 1e-9
    assert min(apart(found.motor, motor), apart(found.ambiguous[0], motor)) < 1e-9


def test_a_cube_has_24_poses():
    places = np.concatenate([np.eye(3), -np.eye(3)])
    query, motor, _ = seen({"points": places}, np.random.default_rng(5))
    found = register(Model(**query), Model(points=places), threads=1)
    assert len(found.ambiguous) == 23 and found.converged
    assert min(apart(r, motor) for r in (found.motor, *found.ambiguous)) < 1e-9


# -- what cannot be told ---------------------------------------------------------------------------------------


def free(**model):
    """The error of models that leave motions free, and those motions."""
    rng = np.random.default_rng(1)
    turn, shift, _ = pose(rng)
    query = {kind: moved(kind, x, turn.T, -turn.T @ shift) for kind, x in model.items()}
    with pytest.raises(UndeterminedError) as caught:
        register(Model(**query), Model(**model), threads=1)
    assert isinstance(caught.value, SingularError) and not caught.value.result.converged
    motions, objects = caught.value.motions, Model(**query).objects
    for x in objects.values():
        for motion in motions:
            near = (motion * 0.3).exp() >> x
            same = np.minimum(np.abs(near.values - x.values).max(-1), np.abs(near.values + x.values).max(-1))
            assert same.max() < 1e-6
    assert np.linalg.matrix_rank(motions.values, 1e-6) == len(motions)
    return len(motions), str(caught.value)


@pytest.mark.parametrize(
    ("model", "count", "words"),
    [
        ({"lines": [((x, y, 0), Z) for x, y in np.random.default_rng(0).normal(size=(9, 2))]}, 1, "the translation"),
        ({"lines": [((1, 2, 0), Z)] * 4}, 2, "the translation"),
        ({"lines": [((1, 1, 1), Z)]}, 2, "and the rotation about the line through"),
        ({"points": np.outer(np.linspace(-1, 2, 8), (1, 2, 2)) + (1, 0, 0)}, 1, "the rotation"),
        ({"points": [(1, 2, 3)]}, 3, "the rotation"),
        ({"points": [(1, 2, 3), (0, 1, 0)]}, 1, "the rotation"),
        pytest.param(
            *({"planes": [(np.cos(a), np.sin(a), 0, 0) for a in np.linspace(0, 3, 7)]}, 1, "the translation"),
            marks=pytest.mark.slow,
        ),
        pytest.param({"planes": [(0, 0, 1, a) for a in (0, 1, 3)]}, 3, "the translation", marks=pytest.mark.slow),
        pytest.param(*({"spheres": [(1, 2, 3, 1), (1, 2, 3, 2)]}, 3, "the rotation"), marks=pytest.mark.slow),
        pytest.param(
            {"circles": [(0, 0, a, 0, 0, 1, 1 + a) for a in (0, 1, 3)]}, 1, "the rotation", marks=pytest.mark.slow
        ),
        pytest.param({"point_pairs": [((1, 2, 3), (0, 0, 1))]}, 1, "the rotation", marks=pytest.mark.slow),
    ],
)
def test_free_motions_are_told(model, count, words):
    found, message = free(**{kind: np.array(x, float) for kind, x in model.items()})
    assert found == count and words in message and "query" in message


def test_matches_that_leave_a_motion_free_are_reported():
    """The models tell the pose; what they have in common does not."""
    rng = np.random.default_rng(2)
    shared = np.array([((x, y, 0), Z) for x, y in rng.normal(size=(12, 2))])
    reference = np.concatenate([shared, fresh("lines", 3, rng)])
    turn, shift, motor = pose(rng)
    query = moved("lines", np.concatenate([shared, fresh("lines", 3, rng)]), turn.T, -turn.T @ shift)
    found = register(Model(lines=query), Model(lines=reference), threads=1)
    assert not found.converged and found.message


@pytest.mark.slow
def test_what_noise_leaves_nearly_free_is_reported():
    """Lines that are nearly parallel say nothing about shifts along them, where directions are no better known."""
    rng = np.random.default_rng(4)
    lines = np.stack([rng.uniform(-1, 1, (30, 3)), unit(Z + 0.005 * rng.normal(size=(30, 3)))], 1)
    turn, shift, _ = pose(rng)
    exact = register(Model(lines=moved("lines", lines, turn.T, -turn.T @ shift)), Model(lines=lines), threads=1)
    assert exact.converged and not len(exact.undetermined)
    worse = noisy("lines", moved("lines", lines, turn.T, -turn.T @ shift), 1e-2, rng)
    found = register(Model(lines=worse), Model(lines=lines), threads=1)
    assert not found.converged and len(found.undetermined) == 1 and "the translation along" in found.message
    assert np.abs(found.undetermined.values).max() > 0


@pytest.mark.parametrize("e", [1e-1, 1e-2, 1e-3])
def test_nearly_parallel_lines_and_nearly_collinear_points_without_noise(e):
    rng = np.random.default_rng(6)
    lines = np.stack([rng.uniform(-1, 1, (12, 3)), unit(Z + e * rng.normal(size=(12, 3)))], 1)
    points = np.outer(rng.uniform(-1, 1, 12), Z) + e * rng.normal(size=(12, 3))
    for model in ({"lines": lines}, {"points": points}):
        query, motor, _ = seen(model, rng)
        found = register(Model(**query), Model(**model), threads=1)
        assert found.converged and apart(found.motor, motor) < 1e-12 / e**2


def test_lines_through_one_point():
    lines = np.stack([np.tile((1.0, 2.0, 3.0), (12, 1)), np.random.default_rng(7).normal(size=(12, 3))], 1)
    query, motor, _ = seen({"lines": lines}, np.random.default_rng(8))
    found = register(Model(**query), Model(lines=lines), threads=1)
    assert found.converged and apart(found.motor, motor) < 1e-12


# -- input -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("spec", "confirmed"), [({"lines": 2}, False), ({"lines": 3}, True), ({"points": 3}, False)])
def test_few_objects(spec, confirmed):
    """A pose that nothing confirms is given, and not claimed."""
    query, reference, motor, true = scene(spec, 5)
    found = register(query, reference, threads=1)
    assert found.converged == confirmed and bool(found.message) != confirmed
    assert (found.inliers == np.ones(len(query), bool)).all()
    if confirmed:
        assert apart(found.motor, motor) < 1e-9 and right(found, true)


@pytest.mark.parametrize(("seed", "count"), [(6, 12), (7, 20)])
def test_points_and_their_mirror_image(seed, count):
    """Any three of them fit exactly, and a fourth nearly, which refinement drops: what is left confirms nothing."""
    points = np.random.default_rng(seed).uniform(-1, 1, (count, 3))
    found = register(Model(points=points * (1, 1, -1)), Model(points=points), threads=1)
    assert found.inliers.sum() == 3 and not found.converged
    assert "refinement lost inliers" in found.message


@pytest.mark.parametrize("size", [0, 1, 4])
def test_sample_sizes_that_make_no_sense(size):
    query, reference, _, _ = scene({"lines": 3}, 1)
    with pytest.raises(InputError, match="sample_size"):
        register(query, reference, sample_size=size, threads=1)


def test_samples_that_place_no_motor():
    query, reference, _, _ = scene({"points": 9}, 1)
    with pytest.raises(InputError, match="sample_size"):
        register(query, reference, sample_size=2, threads=1)


def test_kinds_of_one_model_only_take_no_part():
    query, reference, motor, _ = scene({"lines": 12, "planes": 4}, 2)
    found = register(query, reference.subset({"lines": np.arange(12)}), threads=1)
    assert found.converged and apart(found.motor, motor) < 1e-9
    assert (found.matches["planes"] == -1).all() and len(found.matches) == len(query)


def test_no_common_kind_and_empty_models():
    lines, points = Model(lines=fresh("lines", 4, np.random.default_rng(0))), Model(points=np.eye(3))
    with pytest.raises(InputError, match="in common"):
        register(lines, points)
    for pair in ((Model(), lines), (lines, Model())):
        with pytest.raises(InputError, match="empty"):
            register(*pair)


def test_duplicates_match_the_same_object():
    query, reference, motor, true = scene({"lines": 12}, 4)
    twice = Model(lines=np.concatenate([query.parameters["line"].reshape(-1, 2, 3)] * 2))
    found = register(twice, reference, threads=1)
    assert found.converged and apart(found.motor, motor) < 1e-9
    assert found.matches["lines"].tolist() == [*true["lines"], *true["lines"]]


@pytest.mark.parametrize(
    ("size", "center", "error"),
    [(1e-6, (0, 0, 0), 1e-12), (1e6, (0, 0, 0), 1e-12), (1.0, (1e6, -2e6, 1e6), 1e-7), (1e-6, (1, 2, 3), 1e-7)],
)
@pytest.mark.parametrize("kind", ["lines", pytest.param("circles", marks=pytest.mark.slow)])
def test_far_small_and_large_models(size, center, error, kind):
    query, reference, motor, true = scene({kind: 15}, 6, 0.2, 0.2, size=size, center=center)
    found = register(query, reference, threads=1)
    assert found.converged and right(found, true)
    places = cga3d.point(np.asarray(center, float) + size * np.eye(3))
    gone, wanted = ((r >> places).values[:, :3] for r in (found.motor, motor))
    assert np.abs(gone - wanted).max() < error * size


@pytest.mark.parametrize("kind", ["points", "spheres", "lines", "planes"])
@pytest.mark.parametrize("far", [1e2, 1e6])
def test_a_few_objects_far_away_place_no_frame(kind, far):
    for seed in range(3):
        rng = np.random.default_rng(seed)
        reference = {kind: fresh(kind, 20, rng)}
        query, motor, _ = seen(reference, rng, 1e-3)
        away = {"points": np.s_[:3], "spheres": np.s_[:3, :3], "lines": np.s_[:3, 0], "planes": np.s_[:3, 3]}[kind]
        query[kind][away] += far * rng.normal(size=query[kind][away].shape)
        found = register(Model(**query), Model(**reference), threads=1)
        assert found.converged and apart(found.motor, motor) < 0.02


@pytest.mark.slow
def test_motors_have_a_scalar_part_that_is_not_negative():
    for seed in range(12):
        query, reference, _, _ = scene({"lines": 8, "points": 6}, seed)
        found = register(query, reference, threads=1)
        assert all(float(r.grade(0).values.ravel()[0]) >= 0 for r in (found.motor, *found.ambiguous))
    found = register(Model(lines=table()), Model(lines=table()), threads=1)
    assert all(float(r.grade(0).values.ravel()[0]) >= 0 for r in (found.motor, *found.ambiguous))


@pytest.mark.slow
def test_what_is_there_many_times_is_found_among_other_things():
    """One of six windows, and twice as many lines that are nowhere: pairs of the window are never the rarest."""
    window = np.array([((0, 0, 0), (1, 0, 0)), ((0, 0.2, 0), (1, 0, 0)), ((0, 0, 0), (0, 1, 0)),
                       ((0.13, 0, 0), (0, 1, 0)), ((0.06, 0.1, 0), (0, 0, 1))])  # fmt: skip
    right = 0
    for seed in range(30):
        rng = np.random.default_rng([seed, 5])
        front = [window + np.stack([rng.uniform(-1, 1, 3), np.zeros(3)]) for _ in range(6)]
        part = np.concatenate([front[rng.integers(6)], fresh("lines", 10, rng)])
        query, motor, _ = seen({"lines": part}, rng, 1e-3)
        reference = np.concatenate([*front, fresh("lines", 5, rng)])
        found = register(Model(**query), Model(lines=reference), threads=1)
        right += min(apart(r, motor) for r in (found.motor, *found.ambiguous)) < 0.1
    assert right >= 27  # 24 of 30 where only the rarest vote


def test_a_part_of_a_model_ten_times_larger():
    rng = np.random.default_rng(9)
    part = fresh("lines", 30, rng)
    whole = np.concatenate([part, fresh("lines", 60, rng, 10.0)])
    query, motor, _ = seen({"lines": part}, rng)
    found = register(Model(**query), Model(lines=whole), threads=1)
    assert found.converged and apart(found.motor, motor) < 1e-9


def test_one_model_ten_times_larger_is_another_one():
    query, reference, _, _ = scene({"lines": 20}, 3)
    larger = Model(lines=reference.parameters["line"].reshape(-1, 2, 3) * ([10], [1]))
    found = register(query, larger, threads=1)
    assert not found.converged and found.message


@pytest.mark.slow
def test_nothing_is_raised_but_errors_of_the_package():
    rng = np.random.default_rng(11)
    for kinds in (("lines",), ("points",), ("lines", "planes"), ("circles",)) * 15:
        query, reference = ({kind: fresh(kind, int(rng.integers(1, 4)), rng) for kind in kinds} for _ in range(2))
        try:
            found = register(Model(**query), Model(**reference), threads=1)
        except BladesmithError as error:
            assert isinstance(error, UndeterminedError)
        else:
            assert not found.converged
            assert np.isfinite(found.motor.values).all()


def test_subsets_of_matches_are_drawn_in_blocks_and_are_the_same(monkeypatch):
    query, reference = lines_and_planes().transformed(cga3d.rotor((0, 0, 1), 0.1)), lines_and_planes()
    whole = registration.register(query, reference, start="proximity", samples=100)
    monkeypatch.setattr("bladesmith.registration.search.ransac.BLOCK", 60)  # three subsets of 18 matches
    parts = registration.register(query, reference, start="proximity", samples=100)
    assert np.array_equal(whole.motor.values, parts.motor.values) and whole.doubt == parts.doubt
    assert [step.candidates for step in whole.history] == [step.candidates for step in parts.history]
