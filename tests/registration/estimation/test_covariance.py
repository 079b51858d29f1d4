"""Whether what a registration says of its errors is to be believed: the covariance of its pose."""

from __future__ import annotations

import numpy as np
import pytest
from mpmath import mp
from scipy import stats

from bladesmith import cga3d
from bladesmith.registration import Model, register
from bladesmith.registration.estimation.confidence import CHI_SQUARE, hotelling_inflation
from bladesmith.registration.estimation.refinement import effective_sample_size

from ...support.effort import FULL, seeds
from ...support.registration import scene, twist
from ...support.vectors import unit


def test_inflation_is_hotellings_factor():
    assert mp.gammainc(3, 0, CHI_SQUARE / 2, regularized=True) == pytest.approx(0.95, rel=1e-14)
    for m in (6.0, 6.5, 7.5, 12.0, 20.0, 99.5, 1005.0):
        f = hotelling_inflation(m) * CHI_SQUARE * (m - 5) / (6 * m)
        level = mp.betainc(3, (m - 5) / 2, 0, 6 * f / (6 * f + m - 5), regularized=True)  # Fisher's distribution
        assert 1 - level == pytest.approx(0.05, rel=1e-12)
    assert hotelling_inflation(2.0) == hotelling_inflation(6.0) > 100  # never more than for one residual
    assert hotelling_inflation(1e6) == pytest.approx(1, abs=1e-4)
    rng = np.random.default_rng(0)
    m, inside = 12, []
    for _ in range(4000):
        sample = rng.normal(size=(m, 6))
        inside.append(
            (b := rng.normal(size=6)) @ np.linalg.solve(sample.T @ sample / m * hotelling_inflation(m), b) < CHI_SQUARE
        )
    assert np.mean(inside) == pytest.approx(0.95, abs=0.015)


def test_equal_matches_count_one_each():
    shares = np.full(15, 1 / 15)  # of the identity
    assert effective_sample_size(6, 6 * shares, 6 * shares**2) == pytest.approx(15)
    shares[0] *= 8
    shares /= shares.sum()
    assert effective_sample_size(6, 6 * shares, 6 * shares**2) < 7  # one that says most


@pytest.mark.slow
@pytest.mark.parametrize(
    "spec",
    [{"lines": 20}, {"lines": 50}, {"lines": 100}, {"lines": 10, "planes": 10}, {"lines": 25, "planes": 25}],
    ids=["20", "50", "100", "10+10", "25+25"],
)
def test_the_ellipsoid_holds_the_true_pose(spec):
    inside, range_ = [], seeds(120, 2000)
    for seed in range_:
        query, reference, motor, _ = scene(spec, seed, noise=1e-2)
        found = register(query, reference, threads=1)
        b = twist(motor, found.motor)
        inside.append(b @ np.linalg.solve(found.covariance, b) < stats.chi2.ppf(0.95, 6))
    slack = 0.02 if FULL else 0.055
    assert abs(np.mean(inside) - 0.95) <= slack, np.mean(inside)


def test_the_covariance_is_that_of_the_world():
    """The same scene far away, and in another unit: turns are as well known, shifts are about another origin."""
    query, reference, motor, _ = scene({"lines": 30}, 1, noise=1e-2)
    here = register(query, reference, threads=1)
    query, reference, moved_, _ = scene({"lines": 30}, 1, noise=1e-2, size=1024.0, center=(3e3, -2e3, 1e3))
    there = register(query, reference, threads=1)
    turns = [
        k for k, blade in enumerate(motor.algebra.kind("twist").blades) if blade in motor.algebra.kind("rotor").blades
    ]
    assert len(turns) == 3
    assert np.allclose(*(np.diag(found.covariance)[turns] for found in (here, there)), rtol=1e-3)
    distances = []
    for found, true in ((here, motor), (there, moved_)):
        b = twist(true, found.motor)
        distances.append(b @ np.linalg.solve(found.covariance, b))
    assert distances[0] == pytest.approx(distances[1], rel=1e-2)


def test_few_matches_have_wide_regions():
    """Seven lines: the region is large, and holds the true pose."""
    inside = []
    for seed in range(30):
        query, reference, motor, _ = scene({"lines": 7}, seed, noise=1e-3)
        found = register(query, reference, threads=1)
        b = twist(motor, found.motor)
        inside.append(b @ np.linalg.solve(found.covariance, b) < CHI_SQUARE)
    assert np.mean(inside) >= 0.9


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_regions_hold_the_pose_where_few_of_many_matches_carry_the_cost(seed):
    """Of twelve lines and four small circles, the circles: their gradients do not span all motions."""
    rng, inside = np.random.default_rng(seed), []
    lines, axes = rng.uniform(-1, 1, (12, 3)), unit(rng.normal(size=(12, 3)))
    middles, normals = rng.uniform(-1, 1, (4, 3)), unit(rng.normal(size=(4, 3)))
    radii = rng.uniform(0.1, 0.5, 4)

    def model(noise):
        def off(x):
            return x + noise * rng.normal(size=x.shape)

        rounds = np.column_stack([off(middles), off(normals), off(radii)])
        return Model(lines=np.stack([off(lines), off(axes)], 1), circles=rounds)

    reference = model(0)
    for _ in range(10):
        found = register(model(2e-3), reference, threads=1)
        b = twist(cga3d.translator((0, 0, 0)).as_kind("motor"), found.motor)
        inside.append(b @ np.linalg.solve(found.covariance, b) < CHI_SQUARE)
    assert np.mean(inside) >= 0.9
