"""Stages of the compiled registration driver against NumPy."""

from __future__ import annotations

import numpy as np
import pytest

from bladesmith import cga3d as cga
from bladesmith.codegen.build.extension import compiler
from bladesmith.codegen.formulas.registration import registration
from bladesmith.codegen.programs.registration.registration import DIRECTED, KINDS, matched_as
from bladesmith.dispatch.formulas import ArrayOperand, evaluate
from bladesmith.registration.backends.driver import Driver
from bladesmith.registration.backends.model_rows import MatchCriterion, ModelData
from bladesmith.registration.backends.scene import Scene
from bladesmith.registration.estimation.refinement import MAX_STEPS, descend, rates_of, weighted
from bladesmith.registration.search.invariant_tables import MANY_KEYS, Tables, pair_indices, stable_order

from ...oracles.registration import ALGEBRA, PAIRS

needs_compiler = pytest.mark.skipif(compiler() is None, reason="no C compiler")
#: Objects of each kind of the query; the reference has two more.
COUNT = 5
WEIGHTS, LIMIT = (0.75, 0.25, 0.75), 0.5
HALVES = [(i, j) for i in range(8) for j in range(i, 8)]


def random_rows(kind: str, n: int, seed: int) -> np.ndarray:
    random = np.random.default_rng([seed, KINDS.index(kind)])
    p, d, r = random.uniform(-1, 1, (n, 3)), random.normal(size=(n, 3)), random.uniform(0.2, 0.6, n)
    made = {
        "point": lambda: cga.point(p),
        "point_pair": lambda: cga.point_pair(p, p + d),
        "line": lambda: cga.line(p, d),
        "circle": lambda: cga.circle(p, d, r),
        "plane": lambda: cga.plane(d, r),
        "sphere": lambda: cga.sphere(p, r),
    }[matched_as(kind)]()
    return np.ascontiguousarray(made._data)


def wrapped(kind: str, rows: np.ndarray):
    return cga.wrap(cga.kind(matched_as(kind)), rows)


def formula(name: str, *operands):
    """Results of a formula by NumPy, as arrays."""
    return [getattr(v, "_data", v) for v in evaluate(cga, name, *operands).values]


class World:
    """A query, a reference with some more objects, and the motor between them, nearly."""

    def __init__(self) -> None:
        self.motor = np.array((cga.translator((0.2, -0.1, 0.1)) * cga.rotor((1, 2, 3), 0.4))._data)
        self.query = {k: random_rows(k, COUNT, 1) for k in KINDS}
        random = np.random.default_rng(5)  # each is a little off
        shifts, axes = 0.02 * random.normal(size=(COUNT, 3)), random.normal(size=(COUNT, 3))
        truth = cga.translator(shifts) * cga.rotor(axes, 0.03) * wrapped("motor", self.motor)
        self.reference = {}
        for kind, rows in self.query.items():
            images = (truth >> wrapped(kind, rows)).as_kind(matched_as(kind), check=False)._data
            signs = np.where(np.arange(COUNT) % 2, -1.0, 1.0)[:, None] if kind in DIRECTED else 1.0
            self.reference[kind] = np.concatenate([random_rows(kind, 2, 9), images * signs])
        self.driver = Driver(KINDS, 1)
        sides = [
            ModelData(m, {k: self.driver.elements(k, r) for k, r in m.items()}) for m in (self.query, self.reference)
        ]
        self.kinds = np.repeat(np.arange(len(KINDS), dtype=np.int32), COUNT)
        self.rows = np.tile(np.arange(COUNT, dtype=np.int32), len(KINDS))
        self.scene = Scene(*sides, self.kinds, self.rows, 2)
        self.elements = sides[1].elements

    def moved_elements(self, motor: np.ndarray, kind: str) -> np.ndarray:
        return formula("registration.moved_element", wrapped("motor", motor), wrapped(kind, self.query[kind]))[0]

    def nearest(self, motor: np.ndarray, align: bool = True):
        """Rows of counterparts or -1, squares, signs of all, by looking at all pairs."""
        found = []
        for kind in KINDS:
            e, r = self.moved_elements(motor, kind)[:, None], self.elements[kind][None]
            cosine = (e[..., 3:6] * r[..., 3:6]).sum(-1)
            away = np.maximum((kind in DIRECTED) - (np.abs(cosine) if align else cosine), 0)
            d = WEIGHTS[0] * ((e - r)[..., :3] ** 2).sum(-1) + 2 * WEIGHTS[1] * away + WEIGHTS[2] * (e - r)[..., 6] ** 2
            best = d.argmin(1)
            least, c = d[np.arange(COUNT), best], cosine[np.arange(COUNT), best]
            near = least < LIMIT
            sign = np.where(align & (c < 0) & near, -1.0, 1.0)
            found.append((np.where(near, best, -1), np.where(near, least, LIMIT), sign))
        return [np.concatenate(part) for part in zip(*found, strict=True)]

    def form(self, kind: int, i: int, j: int, sign: float) -> np.ndarray:
        """The 8 x 8 matrix of one pair."""
        name = KINDS[kind]
        operands = (wrapped(name, self.query[name][i]), wrapped(name, self.reference[name][j]))
        return full(formula("registration.motor_form", *operands, ArrayOperand(sign, 0, "sign"))[0])


def full(upper: np.ndarray) -> np.ndarray:
    matrix = np.zeros((8, 8))
    for value, (i, j) in zip(upper, HALVES, strict=True):
        matrix[i, j] = matrix[j, i] = value
    return matrix


def least_motor(matrix: np.ndarray) -> np.ndarray:
    """The motor of the least form: q' eliminated, the least eigenvector, the next motor."""
    inner, cross = matrix[4:, 4:], matrix[:4, 4:]
    inverse = np.linalg.pinv(inner, rcond=1e-12, hermitian=True)
    _, vectors = np.linalg.eigh(matrix[:4, :4] - cross @ inverse @ cross.T)
    q = vectors[:, 0]
    raw = np.zeros(8)
    order = [cga.kind("motor").blades.index(b) for b in registration.motor_blades(ALGEBRA)]
    raw[order] = np.concatenate([q, -inverse @ cross.T @ q])
    return unit_motor(raw)


def unit_motor(raw: np.ndarray) -> np.ndarray:
    return formula("registration.near_motor", cga.wrap(cga.layout("motor"), raw))[0]


def same_motor(a: np.ndarray, b: np.ndarray, tolerance: float = 1e-12) -> None:
    assert min(np.abs(a - b).max(), np.abs(a + b).max()) < tolerance


@pytest.fixture(scope="module")
def world() -> World:
    made = World()
    made.scene.set_criterion(MatchCriterion(WEIGHTS, LIMIT, 0.0, True))
    return made


@needs_compiler
def test_driver_elements_invariants_and_steps(world):
    for kind, rows in world.query.items():
        np.testing.assert_allclose(
            world.driver.elements(kind, rows), formula("registration.element", wrapped(kind, rows))[0], atol=1e-13
        )
    i, j = np.indices((COUNT, COUNT)).reshape(2, -1)
    for a, b in PAIRS:
        found = world.driver.invariants((a, b), (world.query[a], world.query[b]), (i, j))
        operands = wrapped(a, world.query[a][i]), wrapped(b, world.query[b][j])
        np.testing.assert_allclose(found, formula("registration.pair_invariants", *operands)[0], atol=1e-12)
    twist = np.array([0.1, -0.2, 0.05, 0.3, -0.1, 0.2])
    expected = formula("registration.step_motor", wrapped("motor", world.motor), wrapped("twist", twist))[0]
    np.testing.assert_allclose(world.driver.step(world.motor, twist), expected, atol=1e-15)


@needs_compiler
def test_a_scene_keeps_nothing_of_what_was_asked_before(world):
    scene, half = world.scene, slice(None, None, 2)
    before = len(scene._shared)
    try:
        for _ in range(3):
            scene.select_objects(world.kinds[half], world.rows[half])
            found = scene.match(world.motor)
            np.testing.assert_array_equal(found[0], world.nearest(world.motor)[0][half])
        assert len(scene._shared) == before
    finally:
        scene.select_objects(world.kinds, world.rows)


@needs_compiler
@pytest.mark.parametrize("align", [True, False])
def test_driver_finds_the_nearest_of_all(world, align):
    world.scene.set_criterion(MatchCriterion(WEIGHTS, LIMIT, 0.0, align))
    try:
        for found, expected in zip(world.scene.match(world.motor), world.nearest(world.motor, align), strict=True):
            np.testing.assert_allclose(found, expected, atol=1e-13)
    finally:
        world.scene.set_criterion(MatchCriterion(WEIGHTS, LIMIT, 0.0, True))


@needs_compiler
def test_driver_samples_are_the_least_eigenvectors_of_their_forms(world):
    random = np.random.default_rng(2)
    members = np.array([random.choice(len(world.kinds), 3, replace=False) for _ in range(40)])
    kinds, query = world.kinds[members], world.rows[members]
    signs = np.where((query % 2 == 1) & np.isin(kinds, [KINDS.index(k) for k in DIRECTED]), -1.0, 1.0)
    motors, scores, hits, tested = world.scene.samples(kinds, query, query + 2, signs, np.inf)
    compared = 0
    for n in range(len(members)):
        matrix = sum(world.form(*pair) for pair in zip(kinds[n], query[n], query[n] + 2, signs[n], strict=True))
        sizes = np.linalg.eigvalsh(matrix[4:, 4:])
        if sizes[0] < 1e-3 * sizes[-1] or scores[n] < 0:
            continue  # a translation is nearly free
        same_motor(motors[n], least_motor(matrix), 1e-8)
        indices, squares, _ = world.nearest(motors[n])
        assert hits[n] == (indices >= 0).sum() and tested[n] == len(indices)
        np.testing.assert_allclose(scores[n], (1 - squares / LIMIT).sum(), atol=1e-10)
        compared += 1
    assert compared > 20


@needs_compiler
def test_driver_refines_by_matching_and_estimating(world):
    start = world.driver.step(world.motor, np.array([0.02, -0.01, 0.02, 0.05, -0.02, 0.03]))
    motors, scores, hits, taken = world.scene.refine(start[None], 4, 0.0)
    motor = start
    for _ in range(4):
        indices, squares, signs = world.nearest(motor)
        near = 1 - squares / LIMIT
        matrix = sum(
            near[n] ** 2 * world.form(world.kinds[n], world.rows[n], indices[n], signs[n])
            for n in np.flatnonzero(indices >= 0)
        )
        motor = least_motor(matrix)
    same_motor(motors[0], motor, 1e-11)
    indices, squares, _ = world.nearest(motor)
    assert taken[0] == 4 and hits[0] == (indices >= 0).sum()
    np.testing.assert_allclose(scores[0], (1 - squares / LIMIT).sum(), atol=1e-10)


@needs_compiler
def test_driver_stiffness_is_the_least_pivot(world):
    random = np.random.default_rng(4)
    members = np.array([random.choice(len(world.kinds), 3, replace=False) for _ in range(30)])
    found = world.scene.conditioning(world.kinds[members], world.rows[members])
    for n, one in enumerate(members):
        total = np.zeros((8, 8))
        for k, i in zip(world.kinds[one], world.rows[one], strict=True):
            x = wrapped(KINDS[k], world.query[KINDS[k]][i])
            total += full(formula("registration.motor_form", x, x, ArrayOperand(1.0, 0, "sign"))[0])
        left, least = total[1:7, 1:7], np.inf  # without 1 and the pseudoscalar
        while len(left):
            t = int(np.diag(left).argmax())
            least = min(least, left[t, t])
            rest = [i for i in range(len(left)) if i != t]
            left = left[np.ix_(rest, rest)] - np.outer(left[rest, t], left[t, rest]) / left[t, t]
        np.testing.assert_allclose(found[n], least, rtol=1e-8, atol=1e-13)
    assert (world.scene.conditioning(np.array([[2, 2]]), np.array([[0, 0]])) < 1e-13).all()  # one line twice


@pytest.mark.slow
@needs_compiler
@pytest.mark.parametrize("kind", KINDS)
def test_driver_rates_are_those_of_the_formula(world, kind):
    i = np.arange(COUNT)
    found = world.scene.rates(kind, world.motor, i, i + 2)
    operands = wrapped(kind, world.query[kind]), wrapped(kind, world.reference[kind][2:])
    expected = np.hstack(formula("registration.moved_rates", wrapped("motor", world.motor), *operands))
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9)


@needs_compiler
def test_driver_steps_half_way_in_turn(world):
    """Algorithm 1, against its formulas one after the other; the middle of the last round where it has settled."""
    signs = np.where((world.rows % 2 == 1) & np.isin(world.kinds, [KINDS.index(k) for k in DIRECTED]), -1.0, 1.0)
    others = np.roll(np.arange(len(world.kinds)).reshape(-1, COUNT), -1, 1).ravel()
    partners = np.where(np.isin(world.kinds, [KINDS.index(k) for k in ("point", "sphere")]), others, -1)
    pairs = (world.kinds, world.rows, world.rows + 2, partners, signs)

    def pair(n: int):
        name, i = KINDS[world.kinds[n]], world.rows[n]
        return wrapped(name, world.query[name][i]), wrapped(name, world.reference[name][i + 2])

    def once(motor: np.ndarray) -> list[np.ndarray]:
        motors = [motor]
        for n, other in enumerate(partners):
            r = wrapped("motor", motors[-1])
            if other >= 0:
                step = formula("estimation.half_step_of_two", r, *pair(n), *pair(other))
            else:
                step = formula("estimation.half_step", r, *pair(n), ArrayOperand(signs[n], 0, "sign"))
            motors.append(step[0])
        return motors

    found, changes, skipped = world.scene.direct(np.eye(8)[0], pairs, 3, 0.0)
    motor = np.eye(8)[0]
    for change in changes:
        before, motor = motor, once(motor)[-1]
        same = formula("estimation.change", wrapped("motor", motor), wrapped("motor", before))[0]
        np.testing.assert_allclose(change, same[..., 0], rtol=1e-9, atol=1e-12)
    assert skipped == 0 and len(changes) == 3
    same_motor(found, motor)
    settled, changes, _ = world.scene.direct(np.eye(8)[0], pairs, 50, 1e-12)
    assert 2 < len(changes) < 50 and changes[-1] < 1e-12
    last = world.scene.direct(np.eye(8)[0], pairs, len(changes) - 1, 0.0)[0]
    middle = np.mean(once(last)[1:], 0)
    same_motor(settled, unit_motor(middle))
    assert np.abs(settled - last).max() > 1e-6


@needs_compiler
@pytest.mark.parametrize("kinds", [("line", "circle"), ("point_pair", "line")])
def test_tables_find_the_one_of_many_rounds_about_a_line(kinds):
    """They are as far from the line, and lean as much: but for the twist all would be possible."""
    turns = np.linspace(-1.4, 1.4, 15)
    axes = np.stack([np.sin(0.9) * np.cos(turns), np.sin(0.9) * np.sin(turns), np.full(15, np.cos(0.9))], 1)
    line, middle = cga.line([(0, 0, 0.4)], [(0, 0, 1)]), np.tile([0.8, 0, -0.3], (15, 1))
    made = {
        "line": lambda: line,
        "circle": lambda: cga.circle(middle, axes, 0.7),
        "point_pair": lambda: cga.point_pair(middle - 0.5 * axes, middle + 0.5 * axes),
    }
    rows = {k: np.ascontiguousarray(made[k]()._data) for k in kinds}
    driver = Driver(KINDS, 1)
    table = Tables(driver, rows, {k: np.arange(len(x)) for k, x in rows.items()})[kinds]
    rounds, lines = np.arange(15), np.zeros(15, int)
    places = (lines, rounds) if kinds[0] == "line" else (rounds, lines)
    motion = cga.translator((1, 2, 3)) * cga.rotor((1, -1, 2), 2.0)
    moved = [np.ascontiguousarray((motion >> wrapped(k, rows[k])).as_kind(k)._data) for k in kinds]
    found = table.find(driver.invariants(kinds, tuple(moved), places), 1e-6)
    np.testing.assert_array_equal(found.source, np.arange(15))
    np.testing.assert_array_equal(found.second if kinds[0] == "line" else found.first, rounds)


@pytest.mark.parametrize("n", [MANY_KEYS - 1, 20 * MANY_KEYS])
def test_the_order_of_keys_is_the_stable_one(n):
    random = np.random.default_rng(n)
    keys = {
        "random": random.random(n),
        "nearly all together": random.normal(size=n) ** 21,
        "ties": random.integers(0, 9, n) / 7,
        "one": np.full(n, 0.3),
        "tiny": 5e-324 * random.integers(0, 9, n),
        "huge": random.choice([-1.7e308, 1.7e308, 0.0], n),
        "infinite": random.choice([np.inf, 1.0, 2.0], n),
        "none": random.choice([np.nan, 1.0, 2.0], n),
    }
    for name, values in keys.items():
        np.testing.assert_array_equal(stable_order(values), values.argsort(kind="stable"), err_msg=name)


def test_pairs_of_one_kind_are_in_order():
    for n in (0, 1, 2, 65):
        found, expected = pair_indices(("line", "line"), n, n), np.triu_indices(n, 1)
        for own, other in zip(found, expected, strict=True):
            np.testing.assert_array_equal(own, other)


@needs_compiler
@pytest.mark.parametrize("kinds", [("line", "line"), ("point", "sphere")])
def test_invariants_of_all_pairs_are_those_one_by_one(world, kinds):
    rows = tuple(np.concatenate([world.reference[k], world.query[k]]) for k in kinds)
    some = np.array([1, 4, 6, 7, 11]), np.array([1, 4, 6, 7, 11] if kinds[0] == kinds[1] else [0, 2, 3])
    i, j = pair_indices(kinds, *map(len, some))
    found, begins = world.driver.invariants_of_all(kinds, rows, some)
    np.testing.assert_array_equal(found.T, world.driver.invariants(kinds, rows, (some[0][i], some[1][j])))
    np.testing.assert_array_equal(begins, [int((i < k).sum()) for k in range(len(some[0]))])


@needs_compiler
@pytest.mark.parametrize("has_weights", [False, True])
def test_all_steps_in_one_call_are_those_one_by_one(world, has_weights):
    """Against the same on NumPy's eigenvectors and sums, which stops at the same motor."""
    pairs = {k: (np.arange(COUNT), np.arange(2, COUNT + 2)) for k in KINDS}
    weights = np.random.default_rng(3).uniform(0, 2, COUNT * len(KINDS)) if has_weights else None
    if weights is not None:
        weights[::4] = 0.0

    def rates_at(motor):
        rows = [world.scene.rates(kind, motor, *pair) for kind, pair in pairs.items()]
        return rates_of([weighted(np.concatenate(rows), weights)])

    motor, found, steps = world.scene.descend(world.motor, pairs, weights, MAX_STEPS)
    expected = descend(rates_at, world.driver, world.motor)
    np.testing.assert_allclose(motor, expected.motor, atol=1e-13)
    rates = rates_at(motor)
    np.testing.assert_array_equal(found, np.column_stack([rates.costs, rates.gradients, rates.halves]))
    assert 1 < steps <= expected.steps + 2 and np.abs(rates.gradients.sum(0)).max() < 1e-12
    assert rates.costs.sum() < 0.9 * rates_at(world.motor).costs.sum()
    assert world.scene.descend(world.motor, pairs, weights, 0)[2] == 0


@needs_compiler
@pytest.mark.parametrize("free", [0, 2])
def test_influences_are_those_of_the_formula(world, free):
    random, n = np.random.default_rng(free), 9
    slopes, gradients = random.normal(size=(n, 3, 6)), random.normal(size=(n, 6))
    slopes[..., :free] = gradients[:, :free] = 0.0
    matrices = slopes.swapaxes(1, 2) @ slopes
    values, vectors = np.linalg.eigh(matrices.sum(0))
    whiten = np.where(values > 1e-9 * values[-1], vectors / np.sqrt(np.maximum(values, 1e-300)), 0.0)
    rows = np.column_stack([np.zeros(n), gradients, matrices[:, *np.triu_indices(6)]])
    found, traces, squares = world.driver.influences(rows, whiten)
    information = whiten.T @ matrices @ whiten
    for i in range(n):
        left, axes = np.linalg.eigh(np.eye(6) - information[i])
        root = axes @ np.diag(1 / np.sqrt(np.maximum(left, 1e-3))) @ axes.T
        np.testing.assert_allclose(found[i], whiten @ root @ whiten.T @ gradients[i], rtol=1e-10, atol=1e-12)
    np.testing.assert_allclose(traces, information.trace(axis1=1, axis2=2), rtol=1e-12)
    np.testing.assert_allclose(squares, (information**2).sum((1, 2)), rtol=1e-12)
