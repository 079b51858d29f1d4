"""Iterative matching and sampling: near starts, local minima, thresholds, symmetric models."""

from __future__ import annotations

import numpy as np
import pytest

from bladesmith import cga3d as cga
from bladesmith import registration
from bladesmith.codegen.build.extension import compiler
from bladesmith.registration.estimation.estimate_rotor import METHODS
from bladesmith.registration.matching.icp import iterate

from ...support.matching.scenes import EVERY, scene
from ...support.registration import apart

pytestmark = pytest.mark.skipif(compiler() is None, reason="no C compiler")


def table() -> registration.Model:
    """A slab on four legs of four edges each: 22 lines, 16 of them parallel; half a turn leaves it as it is."""
    rows = [((0, y, 0.7), (1, 0, 0)) for y in (-0.4, 0.4)] + [((x, 0, 0.7), (0, 1, 0)) for x in (-0.7, 0.7)]
    rows += [
        ((sx * (0.65 - dx), sy * (0.35 - dy), 0), (0, 0, 1))
        for sx in (-1, 1)
        for sy in (-1, 1)
        for dx in (0, 0.06)
        for dy in (0, 0.06)
    ]
    rows += [((0, y, 0.1), (1, 0, 0)) for y in (-0.3, 0.3)]
    return registration.Model(lines=np.array(rows, float))


def displaced(model, seed, angle, shift):
    """The model moved away, and the motor back."""
    rng = np.random.default_rng([seed, 11])
    motor = cga.translator(shift * rng.normal(size=3) / np.sqrt(3)) * cga.rotor(rng.normal(size=3), angle)
    return model.transformed(~motor), motor


def is_right(result, motor) -> bool:
    return any(apart(m, motor) < 1e-9 for m in (result.motor, *result.ambiguous))


@pytest.mark.parametrize("estimate", METHODS)
def test_iteration_finds_what_is_near(estimate):
    for seed in range(3):
        query, reference, motor, bad = scene({"lines": 60}, seed, wrong=0.2, angle=0.1, shift=0.1, turn=True)
        order = np.random.default_rng(seed).permutation(60)
        found = iterate(query, reference.subset({"lines": order}), estimate=estimate)
        assert found.converged and apart(found.motor, motor) < 1e-9
        expected = np.where(bad["lines"], -1, np.argsort(order))
        np.testing.assert_array_equal(found.matches["lines"], expected)
        rounds = [s for s in found.history if s.name == "match"]
        assert 1 <= len(rounds) < 20 and rounds[-1].cost <= rounds[0].cost
        assert [s.candidates for s in rounds] == list(range(1, len(rounds) + 1))


@pytest.mark.parametrize("assignment", ["one_sided", "symmetric"])
def test_iteration_of_every_kind(assignment):
    right = 0
    for seed in range(4):
        query, reference, motor, _ = scene({k: 8 for k in EVERY}, seed, angle=0.15, shift=0.15)
        for given in (None, motor):
            found = iterate(query, reference, given, assignment=assignment, robust=assignment == "one_sided")
            assert not found.converged or is_right(found, motor)
            right += is_right(found, motor)
    assert right >= 7


def test_a_threshold_bounds_what_counts():
    query, reference, motor, _ = scene({"lines": 60}, 5, wrong=0.3, angle=0.1, shift=0.1)
    found = iterate(query, reference, threshold=0.05)
    assert found.converged and apart(found.motor, motor) < 1e-9
    assert iterate(query, reference, threshold=0.05).motor.values.tolist() == found.motor.values.tolist()


def test_sampling_leaves_local_minima_of_the_table_and_none_is_believed():
    model, stuck, left = table(), 0, 0
    for seed in range(10):
        query, motor = displaced(model, seed, 1.0, 0.5)
        near = iterate(query, model)
        assert near.converged == is_right(near, motor), near.message
        found = registration.register(query, model, seed=seed, start="proximity")
        assert found.converged == is_right(found, motor), found.message
        stuck += not is_right(near, motor)
        left += is_right(found, motor) and not is_right(near, motor)
    assert stuck >= 3 and left >= 2


def test_sampling_from_a_start_and_with_outliers():
    for seed in range(3):
        query, reference, motor, _ = scene({"lines": 40}, seed, wrong=0.3, noise=1e-3, turn=True)
        start = cga.translator((0.05, -0.05, 0.05)) * motor
        found = registration.register(query, reference, seed=3, start=start.as_kind("motor", check=False))
        assert found.converged and apart(found.motor, motor) < 1e-2
        again = registration.register(query, reference, seed=3, start=start.as_kind("motor", check=False), threads=1)
        np.testing.assert_array_equal(found.motor.values, again.motor.values)
        samples = [s for s in found.history if s.name == "sample"]
        assert samples and samples[0].candidates == 64
        assert [s.hits for s in samples] == sorted(s.hits for s in samples) or samples[-1].hits >= 20
    short = registration.register(query, reference, start="proximity", iterations=2)
    assert len([s for s in short.history if s.name == "sample"]) <= 2


def test_the_half_turn_of_the_table_is_told():
    query, motor = displaced(table(), 1, 0.1, 0.1)
    found = registration.register(query, table(), start="proximity")
    half = cga.rotor((0, 0, 1), np.pi)
    assert apart(found.motor, motor) < 1e-9  # the near one of the two
    assert any(apart(m, half * motor) < 1e-9 for m in found.ambiguous)
