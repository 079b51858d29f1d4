"""Motors estimated from matches: exact, with outliers and noise, free motions, units, far away."""

from __future__ import annotations

import numpy as np
import pytest

from bladesmith import Status, objects, registration
from bladesmith import cga3d as cga
from bladesmith.codegen.build.extension import compiler
from bladesmith.errors import InputError, ShapeError, SingularError, UndeterminedError
from bladesmith.registration import Model
from bladesmith.registration.estimation.estimate_rotor import METHODS, estimate_rotor

from ...support.matching.scenes import EVERY, LINES, SPECS, scene
from ...support.registration import apart

pytestmark = pytest.mark.skipif(compiler() is None, reason="no C compiler")


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
@SPECS
def test_exact_matches_give_the_motor_from_any_displacement(spec, method):
    for seed in range(4):
        for align in (False, True):
            query, reference, motor, _ = scene(spec, seed, turn=align)
            found = estimate_rotor(query, reference, method, align=align, details=True)
            assert found.status == Status.OK and len(found.undetermined) == 0
            assert apart(found.motor, motor) < 1e-12
            assert found.cost < 1e-20 and float(found.motor.grade(0).values[0]) >= 0
            if method == "direct":
                assert found.iterations <= 20 and found.history[-1] < 1e-13 < found.history[0]


def test_signs_tell_which_are_turned_round():
    query, reference, _, _ = scene(LINES, 2)
    signs = np.where(np.arange(20) % 3, 1.0, -1.0)
    lines = reference.lines
    found = estimate_rotor(query, lines._make(lines._type, lines._data * signs[:, None], lines.shape), details=True)
    np.testing.assert_array_equal(found.signs["lines"], signs)


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
@SPECS
def test_outliers_are_left_out(spec, method):
    spec = {kind: 2 * n for kind, n in spec.items()}
    for seed in range(3):
        query, reference, motor, bad = scene(spec, seed, wrong=0.3, turn=True)
        found = estimate_rotor(query, reference, method, robust=True, details=True)
        assert apart(found.motor, motor) < 1e-9
        for kind, wrong in bad.items():
            np.testing.assert_array_equal(found.inliers[kind], ~wrong)
        plain = estimate_rotor(query, reference, method, start=motor)
        assert apart(plain, motor) > 1e-5
        near = estimate_rotor(query, reference, method, threshold=0.05, details=True)
        assert apart(near.motor, motor) < 1e-9


@pytest.mark.slow
def test_noise_leaves_every_method_near_the_least_cost():
    errors = {method: [] for method in METHODS}
    for seed in range(12):
        query, reference, motor, _ = scene({"lines": 60}, seed, noise=1e-2)
        results = {m: estimate_rotor(query, reference, m, details=True) for m in METHODS}
        for method, found in results.items():
            errors[method].append(apart(found.motor, motor))
            assert found.cost >= results["linear"].cost * (1 - 1e-9)
        assert apart(results["optimize"].motor, results["linear"].motor) < 1e-6
        assert results["direct"].cost < 1.2 * results["linear"].cost
    medians = {m: np.median(e) for m, e in errors.items()}
    assert medians["direct"] < 2 * medians["linear"] < 1e-2


@pytest.mark.compiles
def test_the_optimised_cost_is_a_minimum_of_either_cost():
    query, reference, _, _ = scene({"lines": 12, "planes": 8}, 3, noise=0.05)
    for cost in ("positive", "thesis"):
        found = estimate_rotor(query, reference, "optimize", cost=cost, details=True)
        center, unit = found.center, found.unit
        assert list(found.history) == sorted(found.history, reverse=True)

        def total(motor, cost=cost, center=center, unit=unit):
            x, y = (m.in_frame(center, unit).objects for m in (query.transformed(motor), reference))
            rotors = [objects.rotor_between(x[k], y[k]) for k in x]
            return sum(objects.rotor_cost(r, cost).sum() for r in rotors)

        least = total(found.motor)
        np.testing.assert_allclose(found.cost, least, rtol=1e-9)
        local = cga.translator(center)
        for twist in np.vstack([np.eye(6), -np.eye(6)]):
            step = cga.wrap(cga.kind("twist"), 1e-3 * twist * np.repeat([1, unit], 3)).exp()
            assert total(local * step * ~local * found.motor) > least


@pytest.mark.parametrize("method", METHODS)
def test_what_matches_leave_free_is_told(method):
    for objects_, free in ((cga.line([(0, 0, 1)], [(1, 0, 0)]), 2), (cga.point([(0, 1, 2), (3, 1, 0)]), 1)):
        motor = cga.translator((1, 2, 3)) * cga.rotor((1, 1, 0), 0.7)
        target = (motor >> objects_).as_kind(objects_.kind.name, check=False)
        found = estimate_rotor(objects_, target, method, details=True)
        assert found.status == Status.NOT_UNIQUE and found.undetermined.shape == (free,)
        np.testing.assert_allclose((found.motor >> objects_)._data, target._data, atol=1e-10)
        step = (found.undetermined[0] * 0.3).exp()  # a free motion leaves the target as it is
        stays = (step >> target).as_kind(target.kind.name, check=False)
        np.testing.assert_allclose(stays._data, target._data, atol=1e-9)


def test_too_few_iterations_are_told_and_a_start_is_used():
    query, reference, motor, _ = scene(LINES, 4)
    short = estimate_rotor(query, reference, iterations=2, details=True)
    assert short.status == Status.NOT_CONVERGED and short.iterations == 2
    assert estimate_rotor(query, reference, start=motor, details=True).iterations < 3
    with pytest.raises(ShapeError, match="the query has 20 lines and the reference 3"):
        estimate_rotor(query, reference.subset([0, 1, 2]))


def test_a_motor_that_is_one_of_many_says_so_and_strict_refuses_it():
    along = Model(lines=[[(0, 0, z), (1, 0, 0)] for z in (0.0, 1.0, 3.0)])
    pose = cga.translator((0, 0.5, 1)) * cga.rotor((0, 0, 1), 0.2)
    there = along.transformed(pose)
    for method in ("direct", "linear"):
        found = registration.estimate_rotor(along, there, method)
        assert found.status == Status.NOT_UNIQUE
        Model(lines=found >> along.lines)  # it serves all the same
        with pytest.raises(UndeterminedError, match="leave free, .*the translation along") as caught:
            registration.estimate_rotor(along, there, method, strict=True)
        assert caught.value.motions.shape == (1,)
        slide = caught.value.motions.values[0]  # on e12, e13, e1ni, e23, e2ni, e3ni
        assert np.abs(slide[[0, 1, 3]]).max() < 1e-9 * np.abs(slide).max()
        assert np.abs(np.cross(slide[[2, 4, 5]], (np.cos(0.2), np.sin(0.2), 0))).max() < 1e-9 * np.abs(slide).max()
        assert caught.value.result.status == Status.NOT_UNIQUE
    more = Model(lines=[*along.parameters["line"].reshape(-1, 2, 3), [(0, 0, 0), (0, 1, 1)]])
    exact = registration.estimate_rotor(more, more.transformed(pose), strict=True)
    assert exact.status == Status.OK and apart(exact, pose) < 1e-10
    with pytest.raises(SingularError, match="no convergence after 2 iterations: NOT_CONVERGED"):
        registration.estimate_rotor(more, more.transformed(pose), iterations=2, strict=True)


def test_half_turns_that_leave_algorithm_1_no_step():
    """Lines of a plane turned by half a turn about its normal: every one faces its counterpart."""
    rng = np.random.default_rng(3)
    places, along = (np.column_stack([rng.normal(size=(8, 2)), np.zeros(8)]) for _ in range(2))
    lines = cga.line(places - places.mean(0), along)
    motor = cga.rotor((0, 0, 1), np.pi)
    turned_ = (motor >> lines).as_kind("line", check=False)
    for method in ("direct", "linear"):
        found = estimate_rotor(lines, turned_, method, align=False, details=True)
        assert found.status == Status.OK and apart(found.motor, motor) < 1e-10


@pytest.mark.parametrize("scale", [2.0**-20, 2.0**17])
@pytest.mark.parametrize("method", METHODS)
def test_another_unit_of_length_scales_the_motion_and_nothing_else(method, scale):
    query, reference, _, _ = scene(EVERY, 6, noise=0.01)
    dilator = cga.dilator(scale)
    one = estimate_rotor(query, reference, method, align=False)
    other = estimate_rotor(*(m.transformed(dilator) for m in (query, reference)), method, align=False)
    back = (~dilator * other * dilator).as_kind("motor", check=False)
    assert apart(one, back) < 1e-9


def test_length_balances_translations_and_rotations():
    """Directions turned where positions stay: directions decide where a radian counts much, and not where little."""
    rng = np.random.default_rng(4)
    angle, axis = 0.3, (0.0, 0.0, 1.0)
    places, along = rng.uniform(-1, 1, (30, 3)), rng.normal(size=(30, 3))
    turned = cga.rotor(axis, angle) >> cga.line(np.zeros((30, 3)), along)
    query, reference = cga.line(places, along), cga.line(places, turned.parameters()[1])
    angles = []
    for length in (0.01, 1.0, 100.0):
        found = estimate_rotor(query, reference, "linear", length=length)
        angles.append(2 * np.arccos(min(1.0, float(found.grade(0).values.ravel()[0]))))
    assert abs(angles[2] - angle) < 1e-3 and angles == sorted(angles)
    assert angles[0] < 0.6 * angle  # what the lines' positions say, which turn with their directions


def test_far_from_the_origin_no_digits_are_lost():
    query, reference, motor, _ = scene(EVERY, 7)
    far = cga.translator((1e4, -2e4, 1e4))
    for method in ("direct", "linear"):
        found = estimate_rotor(query.transformed(far), reference.transformed(far), method)
        local = (~far * found * far).as_kind("motor", check=False)
        assert apart(local, motor) < 1e-7


def test_the_printed_cost_is_refused_between_rounds():
    query, reference, _, _ = scene(EVERY, 1)
    with pytest.raises(InputError, match="not bounded from below"):
        estimate_rotor(query, reference, "optimize", cost="thesis")
