"""Matches of two models: least costs, thresholds, orientation, bad input."""

from __future__ import annotations

import numpy as np
import pytest

from bladesmith import cga3d as cga
from bladesmith import objects, registration
from bladesmith.codegen.build.extension import compiler
from bladesmith.errors import InputError
from bladesmith.registration.estimation.estimate_rotor import estimate_rotor
from bladesmith.registration.matching import matching
from bladesmith.registration.matching.icp import iterate
from bladesmith.registration.matching.matching import cost_matrix, match

from ...support.matching.scenes import EVERY, SPECS, scene
from ...support.registration import fresh

pytestmark = pytest.mark.skipif(compiler() is None, reason="no C compiler")


@pytest.mark.parametrize("cost", ["positive", "thesis", "distance"])
@SPECS
def test_matches_are_the_least_of_all_costs(spec, cost, monkeypatch):
    query, reference, _, _ = scene(spec, 1, angle=0.2, shift=0.2, turn=True)
    reference = reference.subset(np.random.default_rng(2).permutation(len(reference)))
    whole = cost_matrix(query, reference, cost=cost)
    one = match(query, reference, cost=cost)
    monkeypatch.setattr(matching, "BLOCK", 7 * 20)  # some rows at a time
    for found in (one, match(query, reference, cost=cost, threads=2)):
        for kind, matrix in whole.items():
            np.testing.assert_array_equal(found.indices[kind], matrix.argmin(1))
            np.testing.assert_allclose(found.costs[kind], matrix.min(1), atol=1e-12)
    both = match(query, reference, cost=cost, assignment="symmetric")
    for kind, matrix in whole.items():
        best = matrix.argmin(1)
        mutual = matrix.argmin(0)[best] == np.arange(len(best))
        np.testing.assert_array_equal(both.indices[kind], np.where(mutual, best, -1))
        assert np.isinf(both.costs[kind][~mutual]).all()
    np.testing.assert_allclose(one.total, sum(m.min(1).sum() for m in whole.values()))


def test_costs_are_those_of_objects_in_the_frame_of_the_reference():
    query, reference, _, _ = scene(EVERY, 3, angle=0.3)
    found = match(query, reference)
    frames = [m.in_frame(found.center, found.unit) for m in (query, reference)]
    for kind, matrix in cost_matrix(query, reference).items():
        expected = objects.cost_matrix(frames[0].objects[kind], frames[1].objects[kind], align=True)
        np.testing.assert_allclose(matrix, expected, rtol=1e-12)
    for s in (2.0**-17, 2.0**20):  # another unit of length changes nothing but the unit
        other = match(*(m.transformed(cga.dilator(s)) for m in (query, reference)))
        np.testing.assert_array_equal(other.indices, found.indices)
    half = cost_matrix({"lines": query.lines}, {"line": reference.lines}, length=0.5)["line"]
    unit = match(query, reference, length=0.5).unit
    assert unit == found.unit / 2 and half.shape == (5, 5)


def test_orientation_is_seen_or_not():
    lines = cga.line([(0, 0, 0), (0, 0, 1), (0, 0, 2)], [(1, 0, 0), (0, 1, 0), (1, 1, 0)])
    other = -lines[np.array([2, 0, 1])]
    found = match(lines, other)
    assert found.indices["lines"].tolist() == [1, 2, 0] and (found.signs["lines"] == -1).all()
    assert found.total < 1e-20
    assert match(lines, other, align=False).total > 1
    both = cga.line([(0, 0, 0), (0, 0, 0)], [(1, 0, 0), (-1, 0.1, 0)])
    assert match(lines[:1], both, align=False).indices["lines"].tolist() == [0]
    assert match(-lines[:1], both, align=False).indices["lines"].tolist() == [1]


def test_a_threshold_leaves_far_objects_alone():
    points = cga.point([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 5)])
    shifted = cga.point([(0, 0, 0.1), (1, 0, 0.2), (0, 1, 0.4)])
    reach = np.sqrt(0.75) * 0.3
    for cost in ("positive", "distance"):
        found = match(points, shifted, threshold=reach, cost=cost)
        assert found.indices["points"].tolist() == [0, 1, -1, -1]
        assert np.isinf(found.costs["points"][2:]).all()
    assert match(points, shifted).indices["points"].tolist()[:3] == [0, 1, 2]


def test_kinds_that_one_model_lacks_have_no_matches():
    query = registration.Model(points=[[0, 0, 0]], lines=[[(0, 0, 0), (1, 0, 0)]])
    reference = registration.Model(lines=[[(0, 0, 1), (1, 0, 0)], [(0, 0, 0), (1, 0, 0)]])
    found = match(query, reference)
    assert found.indices["points"].tolist() == [-1] and found.indices["lines"].tolist() == [1]
    assert list(cost_matrix(query, reference)) == ["line"]


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda x: match(registration.Model(), x), "the query's objects are empty"),
        (lambda x: match(x, registration.Model(points=[[0, 0, 0]])), "no kind of object in common: lines and points"),
        (lambda x: match(x, 3), "the reference's objects"),
        (lambda x: match(x, x, assignment="both"), "assignment is 'both'"),
        (lambda x: match(x, x, cost="least"), "cost is 'least'"),
        (lambda x: match(x, x, threshold=0), "threshold is 0; a positive number"),
        (lambda x: match(x, x, length=np.nan), "length is nan"),
        (lambda x: match({"cubes": 1}, x), "'cubes' is not a kind"),
        (lambda x: match(x.lines * np.nan, x), r"lines\[0\]"),
        (lambda x: estimate_rotor(x, x, method="newton"), "method is 'newton'"),
        (lambda x: estimate_rotor(x, x, start=1), "start is 1; a motor, or an array"),
        (lambda x: estimate_rotor(x, x, iterations=0), "iterations is 0"),
        (lambda x: estimate_rotor(x, x, cost="distance"), "cost is 'distance'"),
        (lambda x: iterate(x, x, estimate="all"), "estimate is 'all'"),
        (lambda x: iterate(x, x, iterations=True), "iterations is True"),
        (lambda x: registration.register(x, x, start="here"), "start is 'here'"),
        (
            lambda x: registration.register(x, x, start="proximity", sample_size=6),
            "sample_size is 6, and there are 5 matches",
        ),
    ],
)
def test_bad_input_is_told(call, message):
    lines = registration.Model(lines=fresh("lines", 5, np.random.default_rng(1)))
    with pytest.raises(InputError, match=message):
        call(lines)
