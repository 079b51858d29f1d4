"""Merging of similar objects: exactly the greedy loop over all pairs, whatever the tree leaves out, and its cost."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import bladesmith as bs
from bladesmith import cga3d as cga
from bladesmith.codegen.algorithms.merging_layout import EVALUATIONS
from bladesmith.codegen.build.extension import compiler
from bladesmith.codegen.formulas.objects import costs
from bladesmith.codegen.ir.loops.language import number_type
from bladesmith.codegen.programs.merging import greedy
from bladesmith.dispatch import stock_algorithms
from bladesmith.errors import GradeError, InputError, ShapeError, SingularError
from bladesmith.objects.clustering import agglomerative
from bladesmith.objects.clustering.agglomerative import merge_similar
from bladesmith.objects.clustering.agglomerative_driver import Greedy

from ..support.build.numba_code import numba_text_as_python
from ..support.clusters import same_partition
from ..support.effort import FULL
from ..support.objects.merging import KINDS, all_pairs, bounds_of, clustered, mixed, table_of

pytestmark = pytest.mark.skipif(compiler() is None, reason="no compiler")
WORLD = (0.0, 0.0, 0.0)


# -- the same as the loop over all pairs -----------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("align", [True, False])
def test_merges_are_those_of_the_loop_over_all_pairs(kind, align):
    x = mixed(kind, 36, seed=3)
    spent, pairs, means = all_pairs(x, 0.2, align)
    found = merge_similar(x, 0.2, align=align, origin=WORLD)
    assert len(spent) >= 4  # or nothing was tested
    np.testing.assert_array_equal(found.pairs, pairs)
    np.testing.assert_allclose(found.merge_costs, spent, rtol=1e-9, atol=1e-14)
    np.testing.assert_allclose(found.objects.values, means, rtol=1e-9, atol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("scale", [0.1, 30.0])
@pytest.mark.parametrize("kind", KINDS)
def test_so_they_are_in_any_unit(kind, scale):
    x = mixed(kind, 36, seed=5, scale=scale)
    threshold = 0.05 * max(1.0, scale)
    spent, pairs, _ = all_pairs(x, threshold, True)
    found = merge_similar(x, threshold, origin=WORLD)
    np.testing.assert_array_equal(found.pairs, pairs)
    np.testing.assert_allclose(found.merge_costs, spent, rtol=1e-7, atol=1e-13)


def mixture(kind, n, seed):
    """Flats among rounds, some of these so large that they are nearly flat and lie beside a flat."""
    flats = mixed({"circle": "line", "sphere": "plane"}[kind], n, seed)
    rng = np.random.default_rng(seed)
    rounds = mixed(kind, n, seed)
    radii = 10.0 ** rng.uniform(0.5, 3, n)
    if kind == "circle":
        found = flats.parameters()
        foot, along = found.point, found.direction
        side = np.cross(along, rng.normal(size=(n, 3)))
        side /= np.linalg.norm(side, axis=1)[:, None]
        near = cga.circle(foot + radii[:, None] * side, np.cross(side, along), radii)
    else:
        normal, offset = flats.parameters()
        near = cga.sphere((offset - radii)[:, None] * normal, radii)
    order = rng.permutation(3 * n)
    return agglomerative.concatenate_objects([flats, rounds, near])[order]


@pytest.mark.parametrize("kind", ["circle", "sphere"])
@pytest.mark.parametrize("seed", [0, 1])
def test_and_of_flats_among_rounds(kind, seed):
    x = mixture(kind, 15, seed)
    spent, pairs, _ = all_pairs(x, 0.1, True)
    found = merge_similar(x, 0.1, origin=WORLD)
    np.testing.assert_array_equal(found.pairs, pairs)
    np.testing.assert_allclose(found.merge_costs, spent, rtol=1e-6, atol=1e-12)
    bound = bounds_of(kind, x)
    least = np.fmin(table_of(costs.pair_cost, x), table_of(costs.aligned_cost, x))
    assert len(spent) > 10 and not (bound > least + 1e-20).any()


def test_and_with_weights():
    x = mixed("line", 30, seed=9)
    weights = np.random.default_rng(1).uniform(0.1, 10, len(x))
    spent, pairs, means = all_pairs(x, 0.2, True, weights)
    found = merge_similar(x, 0.2, weights=weights, origin=WORLD)
    np.testing.assert_array_equal(found.pairs, pairs)
    np.testing.assert_allclose(found.objects.values, means, rtol=1e-9, atol=1e-12)
    assert len(spent) > 5


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("unit", [5e-324, 1e-300, 1e300, 1.7e308])
def test_the_unit_of_weights_does_not_matter(kind, unit):
    x = mixed(kind, 30, seed=4)
    one, other = merge_similar(x, 0.2), merge_similar(x, 0.2, weights=np.full(30, unit))
    np.testing.assert_array_equal(one.objects.values, other.objects.values)
    assert len(one.merge_costs) > 3


@pytest.mark.parametrize("kind", KINDS)
def test_weights_of_the_greatest_range(kind):
    x = mixed(kind, 30, seed=4)
    light = np.append(np.full(29, 1e-59), 1.0)
    one, other = merge_similar(x[:29], 0.2, origin=WORLD), merge_similar(x, 0.2, weights=light, origin=WORLD)
    first, second = ({tuple(p) for p in m.pairs.tolist() if 29 not in p} for m in (one, other))
    assert len(first) > 3 and len(first - second) <= 2  # what the heavy one takes away


@settings(max_examples=25)
@given(st.integers(0, 2**32 - 1), st.sampled_from(KINDS), st.sampled_from([1e-3, 0.05, 1.0]))
def test_afterwards_no_pair_is_within_the_threshold(seed, kind, threshold):
    x = mixed(kind, 30, seed)
    found = merge_similar(x, threshold, origin=WORLD)
    cost = table_of(costs.aligned_cost, found.objects)
    cost = np.where(np.isnan(cost) | np.eye(len(cost), dtype=bool), np.inf, cost)
    assert cost.min() > threshold * (1 - 1e-6)
    assert (found.merge_costs <= threshold).all() and found.counts.sum() == len(x) == len(found.merge_costs) + len(
        found.objects
    )
    np.testing.assert_array_equal(np.bincount(found.groups), found.counts)


# -- results ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", KINDS)
def test_clusters_are_found(kind):
    x, label = clustered(kind, 8, 30, 12, noise=1e-3, scale=3.0)
    found, groups = merge_similar(x, 2e-2)
    assert same_partition(groups, label)
    assert found.kind.name == kind and found.shape == (8,)
    assert bool(found.isclose(found.as_kind(kind)).all())


def test_the_mean_is_turned_like_the_first():
    line = cga.line((0, 0, 1), (1, 0, 0))
    both = agglomerative.concatenate_objects([line, -1.0 * line])
    found = merge_similar(both, 1e-6)
    assert bool(found.objects[0].isclose(line)) and found.groups.tolist() == [0, 0]
    assert merge_similar(both, 1e-6, align=False).groups.tolist() == [0, 1]
    assert merge_similar(both, np.inf, align=False).groups.tolist() == [0, 1]  # there is no mean of L and -L


def test_flats_and_rounds_of_one_grade():
    rng = np.random.default_rng(0)
    lines = cga.line(1e-3 * rng.normal(size=(20, 3)), (1.0, 0.0, 0.0) + 1e-3 * rng.normal(size=(20, 3)))
    circles = cga.circle(1e-3 * rng.normal(size=(20, 3)), (0.0, 0.0, 1.0) + 1e-3 * rng.normal(size=(20, 3)), 1.0)
    large = cga.circle((0, 1e3, 0), (0, 0, 1), 1e3)  # nearly the line through the origin
    found, groups = merge_similar([lines, circles, large], 1e-2)
    assert groups.tolist() == [0] * 20 + [1] * 20 + [0]
    assert cga.classify(found).tolist() == ["circle", "circle"]


def test_grades_are_merged_on_their_own():
    points, label = clustered("point", 3, 5, 0, 1e-4)
    lines, line_label = clustered("line", 4, 6, 0, 1e-4)
    sphere = cga.sphere((0, 0, 0), 1.0)
    found, groups = merge_similar([points, sphere, lines[:10], lines[10:]], 1e-3)
    assert [x.kind.name for x in found] == ["point", "sphere", "line"]
    assert [x.shape for x in found] == [(3,), (1,), (4,)]
    assert same_partition(groups[0], label)
    assert same_partition(np.concatenate(groups[2:]), line_label)
    assert groups[1].tolist() == 0
    weights = [np.ones(15), 1.0, np.ones(10), np.ones(14)]
    again = merge_similar([points, sphere, lines[:10], lines[10:]], 1e-3, weights=weights)
    np.testing.assert_array_equal(again.objects[2].values, found[2].values)


def test_moving_the_scene_moves_the_result():
    """Costs are measured from the middle of the objects, and far coordinates cost no more digits than they must."""
    shift = np.array([1e5, -2e5, 5e4])
    rng = np.random.default_rng(3)
    label = rng.permutation(np.repeat(np.arange(6), 10))
    centers = rng.normal(size=(6, 3))[label] + 1e-3 * rng.normal(size=(60, 3))
    near, far = (merge_similar(cga.point(centers + t), 1e-2) for t in (0.0, shift))
    np.testing.assert_allclose(far.merge_costs, near.merge_costs, rtol=1e-4)
    np.testing.assert_array_equal(far.pairs, near.pairs)
    spheres = cga.sphere(centers + shift, 0.5 + label / 6)
    assert same_partition(merge_similar(spheres, 1e-2).groups, label)
    assert len(merge_similar(spheres, 1e-2, origin=WORLD).counts) > 6  # from afar the same steps cost more


def test_threads_and_steps_change_nothing():
    x = mixed("circle", 1500, 7)
    one, two = (merge_similar(x, 0.05, threads=n) for n in (1, 2))
    np.testing.assert_array_equal(one.objects.values, two.objects.values)
    np.testing.assert_array_equal(one.pairs, two.pairs)
    greedy = Greedy("circle", x.values, np.ones(len(x)), 0.05, True)
    greedy.find()
    while greedy.step(1):
        pass
    assert greedy.step(10) == 0
    other = Greedy("circle", x.values, np.ones(len(x)), 0.05, True)
    other.find()
    other.step(10**6)
    for a, b in zip(greedy.history, other.history, strict=True):
        np.testing.assert_array_equal(a, b)


@pytest.mark.compiles
@pytest.mark.parametrize("kind", ["line", "circle"])
def test_text_for_numba_has_the_bits_of_c(kind, monkeypatch):
    with numba_text_as_python():
        assert_same_merges(kind, 12, monkeypatch)


@pytest.mark.compiles
@pytest.mark.peers
@pytest.mark.skipif(not FULL, reason="no full bars: a quarter of a minute for text that runs as Python above")
@pytest.mark.parametrize("kind", ["line", "circle"])
def test_numba_has_the_bits_of_c(kind, monkeypatch):
    assert_same_merges(kind, 60, monkeypatch)


def assert_same_merges(kind, clusters, monkeypatch):
    """Merges of so many clusters, means, and all that is noted on the way, through several builds of the tree."""
    x = clustered(kind, clusters, 5, 7, 0.05)[0]
    caches = stock_algorithms.stock_algorithm, stock_algorithms._numba_module

    def merged():
        greedy = Greedy(kind, x.values, np.ones(len(x)), 0.3, True)
        greedy.find(2)
        while greedy.step(7):
            pass
        return greedy

    compiled = merged()
    monkeypatch.setattr(stock_algorithms, "_c_loop", lambda *_: None)
    for cache in caches:
        cache.cache_clear()
    by_numba = merged()
    for cache in caches:
        cache.cache_clear()
    assert len(compiled.history[0]) > 3 * clusters and compiled.evaluations == by_numba.evaluations
    for a, b in zip((*compiled.history, compiled.rows), (*by_numba.history, by_numba.rows), strict=True):
        np.testing.assert_array_equal(a, b)


@pytest.mark.parametrize("kind", ["point", "line", "sphere"])
def test_the_text_run_as_python_merges_the_same(kind):
    x = clustered(kind, 5, 4, 2, 0.03)[0]
    compiled, by_text = (Greedy(kind, x.values, np.ones(len(x)), 0.2, True) for _ in range(2))
    compiled.find(1)
    compiled.step()

    def run(name, **numbers):
        text = getattr(greedy, name)
        state = {"kind": kind, **by_text._state, **numbers}
        return text.function(*(state[p.name] for p in text.text.parameters))

    by_text._state["slots"][:, 1:] = -1
    by_text._state["landmarks"][:] = np.nan
    with number_type(np.float64):
        run("begin")
        by_text._counts[EVALUATIONS] += run("find", begin=0, end=len(x))
        run("queue")
        run("step", most=len(x))
    for a, b in zip(compiled.history[1:], by_text.history[1:], strict=True):
        np.testing.assert_array_equal(a, b)
    np.testing.assert_allclose(by_text.history[0], compiled.history[0], rtol=1e-7, atol=1e-15)
    np.testing.assert_allclose(by_text.rows, compiled.rows, rtol=1e-9, atol=1e-12)
    assert len(compiled.history[0]) >= 10


def test_precision_shape_and_progress(capsys, monkeypatch):
    monkeypatch.setattr("bladesmith.codegen.progress.PATIENCE", 0)
    x = clustered("plane", 4, 6, 0, 1e-3)[0]
    found = merge_similar(x.astype(np.float32).reshape(4, 6), 1e-2, progress=True)
    assert found.objects.dtype == np.float32 and found.groups.shape == (4, 6) and found.counts.sum() == 24
    assert "merge" in capsys.readouterr().err
    alone = merge_similar(x[0], 1.0)
    assert alone.groups.shape == () and alone.objects.shape == (1,)
    np.testing.assert_array_equal(alone.objects.values[0], x.values[0])  # what is not merged is not touched


# -- bad input -------------------------------------------------------------------------------------------------


def test_items_that_are_no_objects_stay_alone():
    x = clustered("line", 2, 5, 0, 1e-4)[0]
    values = x.values.copy()
    values[3] = np.nan
    values[6] *= 2.0
    broken = cga.multivector(values, blades=x.blades)
    found, groups = merge_similar(broken, 1e-2)
    assert found.shape == (4,)
    alone = groups[[3, 6]]
    assert np.isnan(found.values[alone]).all() and (found.status[alone] == bs.Status.INVALID).all()
    assert np.isfinite(np.delete(found.values, alone, 0)).all()
    with pytest.raises(SingularError, match=r"item 3 is INVALID"):
        merge_similar(broken, 1e-2, strict=True)


def test_nothing_gives_nothing():
    empty = cga.line(np.zeros((0, 3)), np.zeros((0, 3)))
    found = merge_similar(empty, 1.0)
    assert found.objects.shape == (0,) and found.groups.shape == (0,) and found.merge_costs.shape == (0,)


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ({"threshold": -1.0}, InputError, "threshold is -1.0"),
        ({"threshold": np.nan}, InputError, "threshold is nan"),
        ({"threshold": "low"}, InputError, "threshold is 'low'"),
        ({"threshold": 10**400}, InputError, "a number of at least 0"),
        ({"threshold": np.zeros(3)}, InputError, "one number"),
        ({"weights": [1, 1j, 1]}, InputError, "weights holds complex128"),
        ({"weights": [1, 10**400, 1]}, InputError, "weights holds object"),
        ({"weights": [1, 1e-70, 1]}, InputError, r"weight of object \(1,\) is 1e-70, that of another 1.0"),
        ({"align": np.zeros(3)}, InputError, "align is array"),
        ({"strict": np.zeros(3)}, InputError, "strict is array"),
        ({"progress": np.zeros(3)}, InputError, "progress is array"),
        ({"weights": [1, 1, 0]}, InputError, r"weights\[2\] is 0.0"),
        ({"weights": [1, np.nan, 1]}, InputError, r"weights\[1\] is nan"),
        ({"weights": [1, 1]}, ShapeError, r"does not broadcast to \(3,\)"),
        ({"origin": (0, 0)}, ShapeError, "origin has shape"),
        ({"origin": (0, 0, np.inf)}, InputError, "a finite number"),
        ({"threads": 0}, InputError, "threads is 0"),
        ({"X": np.zeros((3, 6))}, InputError, "a multivector is needed"),
        ({"X": cga.rotor((0, 0, 1), 1.0)}, GradeError, "the objects"),
        ({"X": bs.algebra(3).vector(np.eye(3)) if hasattr(bs.algebra(3), "vector") else 3}, InputError, "objects"),
        ({"X": []}, InputError, "empty list"),
    ],
)
def test_bad_input_is_named(arguments, error, message):
    given_ = {"X": cga.line(np.zeros((3, 3)), np.eye(3)), "threshold": 1.0, **arguments}
    with pytest.raises(error, match=message):
        merge_similar(**given_)
