"""The stages of a registration as functions: matching, estimates of a motor, iteration, sampling."""

from __future__ import annotations

import numpy as np
import pytest

from bladesmith import Status, objects, registration
from bladesmith import cga3d as cga
from bladesmith.codegen.build.extension import compiler
from bladesmith.errors import InputError, ShapeError, SingularError, UndeterminedError
from bladesmith.registration import Model
from bladesmith.registration.estimation.estimate_rotor import METHODS, estimate_rotor
from bladesmith.registration.matching import matching
from bladesmith.registration.matching.icp import iterate
from bladesmith.registration.matching.matching import cost_matrix, match

from ...support.registration import fresh, noisy, pose, rotation, turned
from ...support.registration import moved as moved_parameters

pytestmark = pytest.mark.skipif(compiler() is None, reason="no C compiler")

#: Few sets of kinds: each has a driver of its own to compile.
LINES, POINTS = {"lines": 20}, {"points": 20}
EVERY = {"points": 5, "point_pairs": 5, "lines": 5, "circles": 5, "planes": 5, "spheres": 5}
SPECS = pytest.mark.parametrize("spec", [LINES, POINTS, EVERY], ids=["lines", "points", "every"])


def apart(a, b) -> float:
    """Largest difference of coefficients of two motors, or their negatives."""
    x, y = (np.asarray(m.as_kind("motor", check=False).values, float) for m in (a, b))
    return float(min(np.abs(x - y).max(), np.abs(x + y).max()))


def scene(spec, seed, noise=0.0, wrong=0.0, angle=None, shift=1.0, turn=False):
    """Matched models, the motor from one to the other, and for each kind which are wrong."""
    rng = np.random.default_rng([seed, 5])
    q, t, motor = pose(rng)
    if angle is not None:
        axis, t = rng.normal(size=3), shift * rng.normal(size=3) / np.sqrt(3)
        q, motor = rotation(axis, angle), cga.translator(t) * cga.rotor(axis, angle)
    query, reference, bad = {}, {}, {}
    for kind, n in spec.items():
        x = fresh(kind, n, rng)
        y = noisy(kind, moved_parameters(kind, x, q, t), noise, rng)
        bad[kind] = np.arange(n) < int(wrong * n)
        if bad[kind].any():
            y[bad[kind]] = fresh(kind, int(wrong * n), rng)
        query[kind], reference[kind] = x, turned(kind, y, rng) if turn else y
    return registration.Model(**query), registration.Model(**reference), motor, bad


# -- matching ----------------------------------------------------------------------------------------------


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
        (lambda x: estimate_rotor(x, x, start=1), "start is 1; one motor"),
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


# -- estimates ---------------------------------------------------------------------------------------------


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


# -- iteration and sampling --------------------------------------------------------------------------------


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
