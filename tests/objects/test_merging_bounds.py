"""What merging need not look at: least costs that landmarks leave possible, and how costs grow."""

from __future__ import annotations

import itertools

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bladesmith import cga3d as cga
from bladesmith.codegen.algorithms import merging_bounds
from bladesmith.codegen.build.extension import compiler
from bladesmith.codegen.formulas.objects import costs
from bladesmith.codegen.ir.loops.language import number_type
from bladesmith.codegen.programs.merging.kinds import KINDS as KERNELS
from bladesmith.objects.clustering.agglomerative import merge_similar

from ..support.objects.merging import KINDS, bounds_of, clustered, cost_of, table_of

pytestmark = pytest.mark.skipif(compiler() is None, reason="no compiler")
WORLD = (0.0, 0.0, 0.0)

# -- what the tree leaves out ----------------------------------------------------------------------------------


@pytest.mark.parametrize("scale", [0.1, 1.0, 30.0])
@pytest.mark.parametrize("kind", KINDS)
def test_landmarks_never_promise_more_than_the_cost(kind, scale):
    near, far = clustered(kind, 12, 4, 1, 1e-3, scale)[0], clustered(kind, 48, 1, 2, 0.0, scale)[0]
    for x in (near, far):
        least = np.fmin(table_of(costs.pair_cost, x), table_of(costs.aligned_cost, x))
        bound = bounds_of(kind, x)
        assert np.isfinite(least).mean() > 0.9 and not (bound > least + 1e-20).any()
        np.testing.assert_allclose(bound, bound.T, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("kind", ["line", "plane", "point"])
def test_they_are_tight_for_flats_and_points(kind):
    x = clustered(kind, 10, 6, 4, 1e-3)[0]
    cost = table_of(costs.aligned_cost, x)
    bound = bounds_of(kind, x)
    near = (cost < 1e-3) & (cost > 1e-9)
    assert near.sum() > 50 and (bound[near] > 0.98 * cost[near]).all()


@given(st.floats(0.001, 1.5), st.floats(0, 5), st.floats(0, 5))
def test_the_cost_of_lines_is_what_the_bound_is_proved_from(angle, distance, shift):
    """4 sin^2(t/4) + 3 (q^2 sin^2(t/2) + d^2/4): a screw about an axis along e3 at the distance q."""
    foot = np.array([distance, 0.0, 0.0])
    first = cga.line(foot, (1.0, 0.0, 0.0))
    second = cga.line(foot + (0, 0, shift), (np.cos(angle), np.sin(angle), 0.0))
    cost = float(cost_of(costs.pair_cost, "line", first.values[None], second.values[None])[0])
    turn = 4 * np.sin(angle / 4) ** 2 + 3 * distance**2 * np.sin(angle / 2) ** 2
    assert cost == pytest.approx(turn + 0.75 * shift**2, rel=1e-9)


@pytest.mark.parametrize("kind", KINDS)
def test_so_they_do_with_fifty_digits(kind):
    """The bound without rounding: the text on numbers of mpmath, against the formula on them."""
    context = mpmath.mp.clone()
    context.dps = 50
    x = clustered(kind, 3, 2, 8, noise=0.3)[0]
    kernels = KERNELS[kind]
    with number_type(context):
        marks = [kernels.landmark(row) for row in x.values]
        for i, j in itertools.combinations(range(len(x)), 2):
            bound = merging_bounds.least_cost(marks[i], marks[j], marks[j], context.mpf(0))
            cost = kernels.cost(x.values[i], kernels.align(x.values[j], x.values[i]))
            assert 0 <= bound <= cost or context.isnan(cost)


# -- growth: costs are counted, not seconds --------------------------------------------------------------------


def evaluations(x, threshold):
    return merge_similar(x, threshold).evaluations / len(x)


@pytest.mark.parametrize("threshold", [1e-6, 0.1])
def test_costs_per_line_hardly_grow(threshold):
    """Among random lines: none within the threshold of each other, or all of them merged again and again."""
    rng = np.random.default_rng(0)
    few, many = (
        evaluations(cga.line(rng.normal(size=(n, 3)), rng.normal(size=(n, 3))), threshold) for n in (500, 8000)
    )
    assert many < 12 and many < 4 * few + 2  # all pairs would be 4000 per line, and 16 times as many


@pytest.mark.parametrize("kind", KINDS)
def test_dense_clusters_do_not_cost_all_pairs(kind):
    few, many = (evaluations(clustered(kind, 20, each, 1)[0], 1e-2) for each in (20, 160))
    assert many < 60 and many < 4 * few  # all pairs: 8 times as many


@pytest.mark.parametrize("kind", KINDS)
def test_copies_do_not_either(kind):
    x = clustered(kind, 2, 1500, 0, noise=0.0)[0]
    found = merge_similar(x, 1e-6)
    assert found.evaluations < 20 * len(x) and found.counts.tolist() == [1500, 1500]
