"""Registration of models of different scales."""

from __future__ import annotations

import numpy as np
import pytest

from bladesmith.errors import UndeterminedError
from bladesmith.registration import Model, register
from bladesmith.registration.search.problem import RegistrationProblem
from bladesmith.registration.search.scale import register_similarity, scales

from ...support.effort import seeds
from ...support.registration import apart, fresh, scene


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
