"""Registration of models of different scales."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from bladesmith.errors import UndeterminedError
from bladesmith.registration import Model, register
from bladesmith.registration.result import PerItem
from bladesmith.registration.search.problem import RegistrationProblem
from bladesmith.registration.search.scale import register_similarity, scales
from bladesmith.registration.search.size_ratio import size_ratio
from bladesmith.registration.verification.scale_significance import check_scale

from ...support.effort import seeds
from ...support.registration import POSE, apart, fresh, same, scene


def smaller(spec, seed, wrong, noise):
    """A scene whose query is smaller (or larger) by a factor between 0.2 and 5, and that factor."""
    query, reference, motor, _ = scene(spec, seed, wrong, wrong, noise)
    factor = float(np.exp(np.random.default_rng(seed).uniform(-1.6, 1.6)))
    return query.in_frame((0, 0, 0), factor), reference, motor, factor


@pytest.mark.slow
@pytest.mark.parametrize("spec", [{"lines": 20}, {"spheres": 20}, {"circles": 20}, {"points": 30}])
@pytest.mark.parametrize(("wrong", "noise"), [(0.0, 0.0), (0.3, 0.0), (0.3, 1e-2)])
def test_scale_and_pose(spec, wrong, noise):
    failed, range_ = 0, seeds(4, 100)
    for seed in range_:
        query, reference, motor, factor = smaller(spec, seed, wrong, noise)
        found = register_similarity(query, reference, lambda model: register(model, reference, threads=1))  # noqa: B023
        failed += max(abs(np.log(found.scale / factor)), apart(found.motor, motor)) > max(20 * noise, 1e-9)
    assert failed <= max(0.05 * len(range_), 1)


@pytest.mark.slow
def test_models_of_one_scale_have_scale_one():
    query, reference, motor, _ = scene({"lines": 15, "planes": 10, "circles": 5}, 1, 0.2, 0.2)
    found = register_similarity(query, reference, lambda model: register(model, reference, threads=1))
    assert found.converged and found.scale == pytest.approx(1, abs=1e-12) and apart(found.motor, motor) < 1e-9


def test_the_likeliest_scale_comes_first():
    query, reference, _, factor = smaller({"circles": 20}, 2, 0.3, 0.0)
    found = scales(RegistrationProblem(query, reference, threads=1))
    assert abs(np.log(found[0] / factor)) < 0.01
    assert 1 <= len(found) <= 8


def test_planes_alone_tell_no_scale():
    planes = Model(planes=fresh("planes", 9, np.random.default_rng(3)))
    with pytest.raises(UndeterminedError, match="scale"):
        register_similarity(planes, planes, lambda model: register(model, planes, threads=1))


# -- units of length -------------------------------------------------------------------------------------------

NOISE = 2e-3
SCENE = {"points": 20, "planes": 8}


def in_another_unit(factor, seed, spec=SCENE):
    """A query that is larger by a factor, the reference and the motor; 30 % of the query does not belong there."""
    query, reference, motor, _ = scene(spec, seed, wrong=0.3, noise=NOISE)
    return query.in_frame((0, 0, 0), 1 / factor), reference, motor


def outcomes(factor, range_):
    """How many are right, and how many wrong ones are claimed."""
    right, claimed = 0, 0
    for seed in range_:
        query, reference, motor = in_another_unit(factor, seed)
        found = register(query, reference, similarity=True, threads=1)
        is_right = max(abs(found.scale * factor - 1), apart(found.motor, motor)) < 20 * NOISE
        right, claimed = right + (is_right and found.converged), claimed + (found.converged and not is_right)
    return right, claimed


@pytest.mark.parametrize("factor", [1000, 1e-3])
def test_units_of_length_are_found(factor):
    assert outcomes(factor, range(2)) == (2, 0)


@pytest.mark.slow
@pytest.mark.parametrize("factor", [1, 50, 100, 1000, 1e-3, 1e9, 1e-9])
def test_any_factor_is_found(factor):
    right, claimed = outcomes(factor, range_ := seeds(10, 100))
    assert right >= 0.9 * len(range_) and not claimed


def test_a_power_of_two_changes_nothing_but_the_scale():
    query, reference, _ = in_another_unit(1, 3, {"points": 12})
    results = []
    for exponent in (10, 20, -20):
        found = register(query.in_frame((0, 0, 0), 2.0**exponent), reference, similarity=True, threads=1)
        results.append(replace(found, scale=found.scale / 2.0**exponent))
    same(results[0], results[1])
    same(results[0], results[2])


@pytest.mark.parametrize("far", [10.0, 1e3])
def test_far_outliers_do_not_change_the_size(far):
    rng = np.random.default_rng(1)
    places = rng.uniform(-1, 1, (30, 3))
    seen = places.copy()
    seen[:8] = far * rng.normal(size=(8, 3))
    problem = RegistrationProblem(Model(points=1000 * seen), Model(points=places), threads=1)
    assert size_ratio(problem) == pytest.approx(1e-3, rel=0.6)


def test_four_planes_do_not_confirm_a_scale():
    query, reference, motor = in_another_unit(1, 5, SCENE)
    problem = RegistrationProblem(query, reference, threads=1)
    found = register(query, reference, threads=1)
    assert check_scale(problem, found) is found
    matches = {"point": np.full(20, -1), "plane": found.matches["planes"].copy()}
    matches["plane"][np.flatnonzero(matches["plane"] >= 0)[4:]] = -1
    claimed = check_scale(problem, replace(found, matches=PerItem(matches)))
    assert not claimed.converged and "no match of points" in claimed.message and claimed.doubt > -2
    matches["point"][10] = 7  # one by chance
    assert not check_scale(problem, replace(found, matches=PerItem(matches))).converged


def test_planes_confirm_a_scale_where_no_point_is_right():
    query, reference, _ = in_another_unit(1, 6, {"points": 6, "planes": 20})
    found = register(query, reference, threads=1)
    matches = PerItem({"point": np.full(6, -1), "plane": found.matches["planes"]})
    assert check_scale(RegistrationProblem(query, reference, threads=1), replace(found, matches=matches)).converged


def test_messages_say_how_the_sizes_differ():
    hint = "the query is .* times larger: another unit. similarity=True"
    query, reference, _ = in_another_unit(1000, 1)
    assert re.search(hint, register(query, reference, threads=1).message)
    points = (query.subset({"points": slice(None)}), reference.subset({"points": slice(None)}))
    with pytest.raises(UndeterminedError, match=hint):
        register(*points, threads=1)
    assert "larger" not in register(*in_another_unit(3, 1)[:2], threads=1).message


def test_a_tiny_query_does_not_match_where_planes_meet():
    for seed in range(1, 4):
        query, reference, _ = in_another_unit(1e-3, seed)
        found = register(query, reference, threads=1)
        assert not found.converged and "times smaller: another unit" in found.message


def test_a_small_part_of_a_large_model_is_found_without_a_scale():
    rng = np.random.default_rng(0)
    places = np.concatenate([rng.uniform(-1, 1, (15, 3)), 300 * rng.uniform(-1, 1, (60, 3))])
    found = register(Model(points=places[:15]).transformed(POSE), Model(points=places), threads=1)
    assert found.converged and apart(~POSE, found.motor) < 1e-9 and (found.matches["points"] == np.arange(15)).all()
