"""Estimators of the motor between matched objects, in the frames of two models: by a quadratic form, by Algorithm 1,
by quasi-Newton steps in the space of bivectors, and by consensus of minimal sets.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import InputError
from ...codegen.programs.registration.registration import DIRECTED, KINDS, matched_as
from ...core.multivector import Algebra, Multivector
from ...dispatch.formulas import evaluate
from ..backends.driver import Driver
from ..backends.model_rows import ModelData
from ..backends.scene import Matches, Scene
from ..matching.matching import center_of, squares
from ..model.model import Model
from ..model.normalization import NormalizedModel, normalize_pair, scale_coefficients
from ..search.invariant_tables import sign_choices
from .refinement import MAX_STEPS, rates, refine_pose

Array = NDArray[Any]
#: Axes are parallel if their second singular value is at most this fraction of the first.
PARALLEL = 0.1
#: Largest number of loops of Algorithm 1.
LOOPS = 500
#: Change of the motor in a loop that ends it: rounding, also of long loops.
LOOP_TOLERANCE = 1e-13
#: Axis and angle of a rotation that is independent of any model.
RESTART_ROTATION = ((0.36, 0.48, 0.8), 1.0)
#: Largest number of quasi-Newton iterations.
ITERATIONS = 200
#: Largest component of the cost's gradient that ends them.
GRADIENT_TOLERANCE = 1e-12
#: Kinds between which rotors dilate.
ROUNDS = frozenset(("point_pair", "circle", "sphere"))
#: Number of minimal sets of a consensus.
CONSENSUS_SETS = 64
#: Pairs of a minimal set.
SET_SIZE = 3
#: Largest number of pairs whose residuals rate a motor.
MAX_RATED = 64
#: With outliers, a motor is rated by the better half of the pairs, but by at least this many.
MIN_RATED = 6


@dataclass(frozen=True)
class Pairs:
    """Matched objects: numbers of kinds (n,), rows of the query and of the reference, and relative orientations."""

    kinds: Array
    query: Array
    reference: Array
    signs: Array

    def __len__(self) -> int:
        return len(self.kinds)

    def take(self, which: Array) -> Pairs:
        """Subset by a mask or by indices."""
        return Pairs(self.kinds[which], self.query[which], self.reference[which], self.signs[which])

    def by_kind(self) -> Matches:
        """Rows of the query and of the reference, by kind."""
        parts = {k: self.kinds == i for i, k in enumerate(KINDS)}
        return {k: (self.query[mask], self.reference[mask]) for k, mask in parts.items() if mask.any()}


@dataclass(frozen=True)
class EstimatorResult:
    """A motor (8,), its number of iterations, a value of each, and True if these converged."""

    motor: Array
    iterations: int
    history: tuple[float, ...]
    settled: bool


class ModelPair:
    """Two models in frames of their own, with one unit of length: ``length`` times their size.

    Attributes
    ----------
    query, reference : NormalizedModel
    driver, scene
        Compiled stages (see `backends.scene`).
    """

    def __init__(self, query: Model, reference: Model, length: float = 1.0, threads: int | None = None) -> None:
        common = tuple(k for k in query.counts if k in reference.counts)
        self.driver = Driver(common, threads)
        models = [m.subset({k: slice(None) for k in common}) for m in (query, reference)]
        centers = [center_of(self.driver, m) for m in models]  # parameters keep the digits that coefficients lose
        near = (m.in_frame(c).objects for m, c in zip(models, centers, strict=True))
        self.query, self.reference = (
            _with_unit(self.driver, replace(local, center=local.center + c), length)
            for local, c in zip(normalize_pair(self.driver, *near), centers, strict=True)
        )
        nothing = np.empty(0, np.int32)
        self.scene = Scene(self.query.data, self.reference.data, nothing, nothing, threads)

    @property
    def algebra(self) -> Algebra:
        """Algebra of the objects."""
        return next(iter(self.query.objects.values())).algebra

    def motors(self, rows: Array) -> Multivector:
        """Rows (.., 8) as motors."""
        wrapped: Multivector = self.algebra.wrap(self.algebra.kind("motor"), rows)
        return wrapped

    def squares(self, pairs: Pairs, motors: Array, align: bool | None = None) -> Array:
        """Weighted squares (c, n) of the distances of matched objects under motors (c, 8); see `matching.squares`.

        Orientations are those of the pairs, unless ``align`` is given.
        """
        values = np.empty((len(motors), len(pairs)))
        for number, kind in enumerate(KINDS):
            rows_of_kind = np.flatnonzero(pairs.kinds == number)
            if not len(rows_of_kind):
                continue
            transformed = self.motors(motors)[:, None] >> self.query.objects[kind][pairs.query[rows_of_kind]][None]
            data = np.asarray(transformed.as_kind(matched_as(kind), check=False)._data)
            rows = data.reshape(-1, data.shape[-1])
            elements = self.driver.elements(kind, rows).reshape(len(motors), len(rows_of_kind), -1)
            others = self.reference.data.elements[kind][pairs.reference[rows_of_kind]]
            signs = pairs.signs[rows_of_kind] if align is None else None
            values[:, rows_of_kind] = squares(self.driver, kind, elements, others, bool(align), signs)
        return values

    def orient(self, pairs: Pairs, motor: Array) -> Pairs:
        """Pairs with the orientations that are nearer under a motor."""
        other = replace(pairs, signs=-pairs.signs)
        nearer = self.squares(pairs, motor[None])[0] <= self.squares(other, motor[None])[0]
        return replace(pairs, signs=np.where(nearer, pairs.signs, -pairs.signs))


def motor_to_frames(motor: Multivector | None, query: NormalizedModel, reference: NormalizedModel) -> Array:
    """A motor of the world, in the frames of two models (8,). None stands for the identity."""
    algebra = next(iter(query.objects.values())).algebra
    found = algebra.translator(query.center - reference.center)
    if motor is not None:
        found = algebra.translator(-reference.center) * motor * algebra.translator(query.center)
    inside = scale_coefficients(found.as_kind("motor", check=False), 1 / query.unit)
    return np.array(inside._data, np.float64)


def _with_unit(driver: Driver, local: NormalizedModel, length: float) -> NormalizedModel:
    """A model in another unit of length."""
    if length == 1:
        return local
    inside = {kind: scale_coefficients(x, 1 / length) for kind, x in local.objects.items()}
    rows = {kind: np.ascontiguousarray(x._data, np.float64) for kind, x in inside.items()}
    side = ModelData(rows, {kind: driver.elements(kind, part) for kind, part in rows.items()})
    return NormalizedModel(local.center, local.unit * length, inside, side)


# -- methods -----------------------------------------------------------------------------------------------


def linear(models: ModelPair, pairs: Pairs, start: Array, iterations: int | None = None) -> EstimatorResult:
    """The motor of least |R X - Y R|^2 over all pairs, then of least positive cost by Gauss-Newton steps."""
    motors, determined = samples(models, pairs, np.arange(len(pairs))[None], pairs.signs[None])
    first = motors[0] if determined[0] else start
    before = float(rates(models.scene, first, pairs.by_kind()).costs.sum())
    steps = MAX_STEPS if iterations is None else iterations
    refined = refine_pose(models.scene, models.driver, first, pairs.by_kind(), steps)
    return EstimatorResult(refined.motor, refined.steps, (before, refined.cost), bool(np.isfinite(refined.motor).all()))


def direct(
    models: ModelPair, pairs: Pairs, start: Array, iterations: int | None = None, tolerance: float = LOOP_TOLERANCE
) -> EstimatorResult:
    """Algorithm 1: half of the remaining displacement, pair after pair, until a loop through all pairs changes nothing.

    Parallel axes determine no rotation about themselves: where all are parallel, it starts from the linear motor.
    Where every object is opposite to its counterpart, no step is defined: it starts from another rotation.
    """
    pair_arrays = (pairs.kinds, pairs.query, pairs.reference, _partners(models, pairs), pairs.signs)
    loops = LOOPS if iterations is None else iterations
    if _parallel(models, pairs):
        linear_motor = linear(models, pairs, start, 0).motor
        start = linear_motor if np.isfinite(linear_motor).all() else start
    motor, changes, skipped = models.scene.direct(start, pair_arrays, loops, tolerance)
    if skipped == len(pairs) > 0:
        turn = models.algebra.rotor(*RESTART_ROTATION)
        rotated = np.array((models.motors(start) * turn).as_kind("motor", check=False)._data, np.float64)
        motor, changes, skipped = models.scene.direct(rotated, pair_arrays, loops, tolerance)
    settled = bool(len(changes)) and bool(changes[-1] < tolerance) and skipped < len(pairs)
    return EstimatorResult(motor, len(changes), tuple(changes.tolist()), settled)


def _parallel(models: ModelPair, pairs: Pairs) -> bool:
    """True if the axes of several objects, not only planes, are parallel or nearly so."""
    kinds = {kind: pairs.kinds == number for number, kind in enumerate(KINDS) if (pairs.kinds == number).any()}
    if len(pairs) < 2 or not set(kinds) <= DIRECTED or set(kinds) == {"plane"}:
        return False
    axes = [models.query.data.elements[kind][pairs.query[rows_of_kind], 3:6] for kind, rows_of_kind in kinds.items()]
    sizes = np.linalg.svd(np.concatenate(axes), compute_uv=False)
    return bool(sizes[1] <= PARALLEL * sizes[0])


def _partners(models: ModelPair, pairs: Pairs) -> Array:
    """Index of another pair of the kind, half of the model away, for points and spheres; -1 for other kinds."""
    partners = np.full(len(pairs), -1)
    for number, kind in enumerate(KINDS):
        rows_of_kind = np.flatnonzero(pairs.kinds == number)
        if kind in DIRECTED or not len(rows_of_kind):
            continue
        positions = models.query.data.elements[kind][pairs.query[rows_of_kind], :3]
        order = rows_of_kind[np.argsort(positions[:, np.ptp(positions, axis=0).argmax()], kind="stable")]
        partners[order] = np.roll(order, -(len(rows_of_kind) // 2))
    return partners


def optimize(
    models: ModelPair, pairs: Pairs, start: Array, iterations: int | None = None, cost: str = "positive"
) -> EstimatorResult:
    """The motor of least cost by b in exp(b) R, by quasi-Newton steps (BFGS of `scipy.optimize`).

    Raises
    ------
    InputError
        For the printed cost between rounds, which has no minimum.
    """
    if cost == "thesis" and not ROUNDS.isdisjoint(pairs.by_kind()):
        what = "the printed cost (5.1) is not bounded from below between point pairs, circles and spheres"
        raise InputError(what, remedy="Use cost='positive'")
    from scipy.optimize import minimize  # type: ignore[import-untyped, unused-ignore]

    costs: list[float] = []

    def motor_and_jacobian(b: Array) -> tuple[Array, Array]:
        outcome = evaluate(
            models.algebra, "estimation.motor_rates", models.algebra.wrap(models.algebra.kind("twist"), b)
        )
        motor = outcome.value * models.motors(start)
        return np.asarray(motor.as_kind("motor", check=False)._data), outcome.values[1].reshape(6, 6)

    def value(b: Array) -> tuple[float, Array]:
        motor, twists = motor_and_jacobian(b)
        total, gradient = summed_rates(models, pairs, motor, cost)
        return total, twists @ gradient

    def note(b: Array) -> None:
        costs.append(value(b)[0])

    limit = ITERATIONS if iterations is None else iterations
    optimum = minimize(
        value,
        np.zeros(6),
        jac=True,
        method="BFGS",
        callback=note,
        options={"maxiter": limit, "gtol": GRADIENT_TOLERANCE},
    )
    motor = motor_and_jacobian(optimum.x)[0]
    settled = optimum.status in (0, 2)  # 2: rounding lets no step get any better
    return EstimatorResult(motor, int(optimum.nit), tuple(costs), bool(settled and np.isfinite(motor).all()))


def summed_rates(models: ModelPair, pairs: Pairs, motor: Array, cost: str) -> tuple[float, Array]:
    """Sum of the pairs' costs and its gradient (6,) by the twist; pairs without a rotor are ignored."""
    if cost == "positive":
        derivatives = rates(models.scene, motor, pairs.by_kind())
        return float(derivatives.costs.sum()), derivatives.gradients.sum(0)
    total, gradient = 0.0, np.zeros(6)
    for kind, (rows, others) in pairs.by_kind().items():
        x, y = models.query.objects[kind][rows], models.reference.objects[kind][others]
        costs, slopes = evaluate(models.algebra, "estimation.printed_rates", models.motors(motor), x, y).values
        finite = np.isfinite(costs[..., 0]) & np.isfinite(slopes).all(-1)
        total, gradient = total + float(costs[finite].sum()), gradient + slopes[finite].sum(0)
    return total, gradient


# -- votes -------------------------------------------------------------------------------------------------


def samples(models: ModelPair, pairs: Pairs, members: Array, signs: Array) -> tuple[Array, Array]:
    """Motors (c, 8) of sets (c, k) of indices of pairs, and a mask of the sets that determine a motor."""
    motors, scores, _, _ = models.scene.samples(
        pairs.kinds[members], pairs.query[members], pairs.reference[members], signs, math.inf
    )
    return motors, (scores >= 0) & np.isfinite(motors).all(1)


def consensus(models: ModelPair, pairs: Pairs, align: bool, robust: bool, random: np.random.Generator) -> Array | None:
    """The motor (8,) of a minimal set with the least residuals of all pairs, or with ``robust`` of the better half.

    Least trimmed squares (Rousseeuw) by random sets: it needs no start and no orientations. None if no set determines
    a motor.
    """
    n = len(pairs)
    size = min(SET_SIZE, n)
    sets = np.array([random.choice(n, size, replace=False) for _ in range(CONSENSUS_SETS if n > size else 1)])
    samples_, signs = [], []
    for sample in sets:
        flips = sign_choices(tuple(KINDS[k] for k in pairs.kinds[sample])) if align else np.ones((1, size))
        samples_.append(np.tile(sample, (len(flips), 1)))
        signs.append(flips * pairs.signs[sample])
    motors, determined = samples(models, pairs, np.concatenate(samples_), np.concatenate(signs))
    if not determined.any():
        return None
    judging_pairs = pairs.take(random.permutation(n)[:MAX_RATED])
    residuals = np.sort(models.squares(judging_pairs, motors[determined], align if align else None), axis=1)
    count = max((len(judging_pairs) + 1) // 2, min(MIN_RATED, len(judging_pairs))) if robust else len(judging_pairs)
    best: Array = motors[determined][
        np.nanargmin(np.where(np.isfinite(residuals), residuals, np.inf)[:, :count].sum(1))
    ]
    return best
