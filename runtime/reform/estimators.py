"""Motors of matched objects, in the frames of two models: by a quadratic form, by Algorithm 1, by descent in bivectors,
and by vote of a few pairs at a time.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..algebras import Algebra
from ..calls import call
from ..codegen.errors import InputError, MissingExtraError
from ..codegen.programs.reform import DIRECTED, KINDS
from ..multivector import Multivector
from .engine import Driver, Scene
from .frames import Local, local_pair, scaled
from .matching import center_of, squares
from .model import Model
from .polish import Matches, polish, rates
from .sides import Side
from .tables import sign_choices

Array = NDArray[Any]
#: Axes that spread by less, as a share of their length, are parallel.
PARALLEL = 0.1
#: Loops of Algorithm 1 at most, and the change of the motor in a loop that ends it: rounding, of long loops too.
LOOPS, LOOP_SETTLED = 500, 1e-13
#: Axis and angle of a turn that has nothing to do with any model.
ELSEWHERE = ((0.36, 0.48, 0.8), 1.0)
#: Iterations of the descent in bivectors at most, and the greatest rate of the cost that ends it.
ITERATIONS, FLAT = 200, 1e-12
#: Kinds between which rotors dilate.
ROUNDS = frozenset(("point_pair", "circle", "sphere"))
#: Sets that vote for a motor, pairs of a set, and pairs by which votes are counted.
VOTES, SET_SIZE, COUNTED = 64, 3, 64
#: Where outliers are reckoned with, the better half of the pairs judges a motor; but never fewer than this.
FEWEST_JUDGES = 6


@dataclass(frozen=True)
class Pairs:
    """Which objects are one: numbers of kinds (n,), rows of the query and of the reference, and signs."""

    kinds: Array
    query: Array
    reference: Array
    signs: Array

    def __len__(self) -> int:
        return len(self.kinds)

    def some(self, which: Array) -> Pairs:
        """Those of a mask, or of numbers."""
        return Pairs(self.kinds[which], self.query[which], self.reference[which], self.signs[which])

    def by_kind(self) -> Matches:
        """Rows of each kind."""
        parts = {k: self.kinds == i for i, k in enumerate(KINDS)}
        return {k: (self.query[own], self.reference[own]) for k, own in parts.items() if own.any()}


@dataclass(frozen=True)
class Estimated:
    """A motor (8,), iterations that it took, what happened in each, and whether it came to rest."""

    motor: Array
    iterations: int
    history: tuple[float, ...]
    settled: bool


class Ground:
    """Two models in frames of their own, with one unit of length: ``length`` times their size.

    Attributes
    ----------
    query, reference : Local
    driver, scene
        What computes (see `engine`).
    """

    def __init__(self, query: Model, reference: Model, length: float = 1.0, threads: int | None = None) -> None:
        common = tuple(k for k in query.counts if k in reference.counts)
        self.driver = Driver(common, threads)
        models = [m.subset({k: slice(None) for k in common}) for m in (query, reference)]
        centers = [center_of(self.driver, m) for m in models]  # parameters keep the digits that coefficients lose
        near = (m.in_frame(c).objects for m, c in zip(models, centers, strict=True))
        self.query, self.reference = (
            _remeasured(self.driver, replace(local, center=local.center + c), length)
            for local, c in zip(local_pair(self.driver, *near), centers, strict=True)
        )
        nothing = np.empty(0, np.int32)
        self.scene = Scene(self.query.side, self.reference.side, nothing, nothing, threads)

    @property
    def algebra(self) -> Algebra:
        """That of the objects."""
        return next(iter(self.query.objects.values())).algebra

    def motors(self, rows: Array) -> Multivector:
        """Rows (.., 8) as motors."""
        wrapped: Multivector = self.algebra.wrap(self.algebra.kind("motor"), rows)
        return wrapped

    def squares(self, pairs: Pairs, motors: Array, align: bool | None = None) -> Array:
        """Weighted squares (c, n) of the distances of matched objects under motors (c, 8); see `matching.squares`.

        Orientations are those of the pairs, unless ``align`` is given.
        """
        found = np.empty((len(motors), len(pairs)))
        for number, kind in enumerate(KINDS):
            own = np.flatnonzero(pairs.kinds == number)
            if not len(own):
                continue
            moved = self.motors(motors)[:, None] >> self.query.objects[kind][pairs.query[own]][None]
            rows = np.asarray(moved.as_kind(kind, check=False)._data).reshape(-1, moved._data.shape[-1])
            elements = self.driver.elements(kind, rows).reshape(len(motors), len(own), -1)
            others = self.reference.side.elements[kind][pairs.reference[own]]
            signs = pairs.signs[own] if align is None else None
            found[:, own] = squares(self.driver, kind, elements, others, bool(align), signs)
        return found

    def turned(self, pairs: Pairs, motor: Array) -> Pairs:
        """The pairs, each turned as it is nearer under a motor."""
        other = replace(pairs, signs=-pairs.signs)
        nearer = self.squares(pairs, motor[None])[0] <= self.squares(other, motor[None])[0]
        return replace(pairs, signs=np.where(nearer, pairs.signs, -pairs.signs))


def inward(motor: Multivector | None, query: Local, reference: Local) -> Array:
    """A motor of the world (8,) between the frames of two models; None: the models stay where they are."""
    algebra = next(iter(query.objects.values())).algebra
    found = algebra.translator(query.center - reference.center)
    if motor is not None:
        found = algebra.translator(-reference.center) * motor * algebra.translator(query.center)
    inside = scaled(found.as_kind("motor", check=False), 1 / query.unit)
    return np.array(inside._data, np.float64)


def _remeasured(driver: Driver, local: Local, length: float) -> Local:
    """A model in another unit of length."""
    if length == 1:
        return local
    inside = {kind: scaled(x, 1 / length) for kind, x in local.objects.items()}
    rows = {kind: np.ascontiguousarray(x._data, np.float64) for kind, x in inside.items()}
    side = Side(rows, {kind: driver.elements(kind, part) for kind, part in rows.items()})
    return Local(local.center, local.unit * length, inside, side)


# -- methods -----------------------------------------------------------------------------------------------


def linear(ground: Ground, pairs: Pairs, start: Array, iterations: int | None = None) -> Estimated:
    """The least |R X - Y R|^2 over all pairs, and then the least positive cost by Gauss and Newton."""
    motors, good = samples(ground, pairs, np.arange(len(pairs))[None], pairs.signs[None])
    first = motors[0] if good[0] else start
    before = float(rates(ground.scene, first, pairs.by_kind()).costs.sum())
    limit = {} if iterations is None else {"steps": iterations}
    found = polish(ground.scene, ground.driver, first, pairs.by_kind(), **limit)
    return Estimated(found.motor, found.steps, (before, found.cost), bool(np.isfinite(found.motor).all()))


def direct(
    ground: Ground, pairs: Pairs, start: Array, iterations: int | None = None, tolerance: float = LOOP_SETTLED
) -> Estimated:
    """Algorithm 1: half of what is left, pair after pair, until a loop through all changes nothing.

    Where all axes are parallel, which turns nothing about them, it starts from the linear motor.
    Where every object faces its counterpart, which leaves no step, it starts from elsewhere.
    """
    given = (pairs.kinds, pairs.query, pairs.reference, _partners(ground, pairs), pairs.signs)
    loops = LOOPS if iterations is None else iterations
    if _parallel(ground, pairs):
        near = linear(ground, pairs, start, 0).motor
        start = near if np.isfinite(near).all() else start
    motor, changes, skipped = ground.scene.direct(start, given, loops, tolerance)
    if skipped == len(pairs) > 0:
        turn = ground.algebra.rotor(*ELSEWHERE)
        away = np.array((ground.motors(start) * turn).as_kind("motor", check=False)._data, np.float64)
        motor, changes, skipped = ground.scene.direct(away, given, loops, tolerance)
    settled = bool(len(changes)) and bool(changes[-1] < tolerance) and skipped < len(pairs)
    return Estimated(motor, len(changes), tuple(changes.tolist()), settled)


def _parallel(ground: Ground, pairs: Pairs) -> bool:
    """Whether there are several objects, not planes alone, whose axes are all parallel, or nearly."""
    kinds = {kind: pairs.kinds == number for number, kind in enumerate(KINDS) if (pairs.kinds == number).any()}
    if len(pairs) < 2 or not set(kinds) <= DIRECTED or set(kinds) == {"plane"}:
        return False
    axes = [ground.query.side.elements[kind][pairs.query[own], 3:6] for kind, own in kinds.items()]
    sizes = np.linalg.svd(np.concatenate(axes), compute_uv=False)
    return bool(sizes[1] <= PARALLEL * sizes[0])


def _partners(ground: Ground, pairs: Pairs) -> Array:
    """For points and spheres another pair of the kind, half of the model away: a point alone turns nothing."""
    found = np.full(len(pairs), -1)
    for number, kind in enumerate(KINDS):
        own = np.flatnonzero(pairs.kinds == number)
        if kind in DIRECTED or not len(own):
            continue
        places = ground.query.side.elements[kind][pairs.query[own], :3]
        order = own[np.argsort(places[:, np.ptp(places, axis=0).argmax()], kind="stable")]
        found[order] = np.roll(order, -(len(own) // 2))
    return found


def optimized(
    ground: Ground, pairs: Pairs, start: Array, iterations: int | None = None, cost: str = "positive"
) -> Estimated:
    """The least sum of costs by b in exp(b) R, by quasi-Newton steps (BFGS of `scipy.optimize`) along its gradient.

    Raises
    ------
    InputError
        For the printed cost between rounds, which has no least value.
    MissingExtraError
        If there is no scipy.
    """
    if cost == "thesis" and not ROUNDS.isdisjoint(pairs.by_kind()):
        what = "the printed cost (5.1) is not bounded from below between point pairs, circles and spheres"
        raise InputError(what, remedy="Use cost='positive'")
    try:
        from scipy.optimize import minimize  # type: ignore[import-untyped, unused-ignore]
    except ImportError:
        raise MissingExtraError("optimize", "The optimisation of a motor's bivector") from None
    costs: list[float] = []

    def moved(b: Array) -> tuple[Array, Array]:
        outcome = call(ground.algebra, "estimation.motor_rates", ground.algebra.wrap(ground.algebra.kind("twist"), b))
        motor = outcome.value * ground.motors(start)
        return np.asarray(motor.as_kind("motor", check=False)._data), outcome.values[1].reshape(6, 6)

    def value(b: Array) -> tuple[float, Array]:
        motor, twists = moved(b)
        total, gradient = summed_rates(ground, pairs, motor, cost)
        return total, twists @ gradient

    def note(b: Array) -> None:
        costs.append(value(b)[0])

    limit = ITERATIONS if iterations is None else iterations
    found = minimize(
        value, np.zeros(6), jac=True, method="BFGS", callback=note, options={"maxiter": limit, "gtol": FLAT}
    )
    motor = moved(found.x)[0]
    settled = found.status in (0, 2)  # 2: rounding lets no step get any better
    return Estimated(motor, int(found.nit), tuple(costs), bool(settled and np.isfinite(motor).all()))


def summed_rates(ground: Ground, pairs: Pairs, motor: Array, cost: str) -> tuple[float, Array]:
    """The sum of the pairs' costs and its gradient (6,) by the twist; pairs without a rotor say nothing."""
    if cost == "positive":
        found = rates(ground.scene, motor, pairs.by_kind())
        return float(found.costs.sum()), found.gradients.sum(0)
    total, gradient = 0.0, np.zeros(6)
    for kind, (rows, others) in pairs.by_kind().items():
        x, y = ground.query.objects[kind][rows], ground.reference.objects[kind][others]
        costs, slopes = call(ground.algebra, "estimation.printed_rates", ground.motors(motor), x, y).values
        known = np.isfinite(costs[..., 0]) & np.isfinite(slopes).all(-1)
        total, gradient = total + float(costs[known].sum()), gradient + slopes[known].sum(0)
    return total, gradient


# -- votes -------------------------------------------------------------------------------------------------


def samples(ground: Ground, pairs: Pairs, members: Array, signs: Array) -> tuple[Array, Array]:
    """Motors (c, 8) of sets of pairs (c, k), by their numbers, and which sets leave no rotation free."""
    motors, scores, _, _ = ground.scene.samples(
        pairs.kinds[members], pairs.query[members], pairs.reference[members], signs, math.inf
    )
    return motors, (scores >= 0) & np.isfinite(motors).all(1)


def consensus(ground: Ground, pairs: Pairs, align: bool, robust: bool, random: np.random.Generator) -> Array | None:
    """The motor (8,) of a few pairs that suits all, or with ``robust`` the better half of them, best; None: no set
    leaves none free. Least trimmed squares (Rousseeuw) by random sets; it needs no start and no orientations.
    """
    n = len(pairs)
    size = min(SET_SIZE, n)
    sets = np.array([random.choice(n, size, replace=False) for _ in range(VOTES if n > size else 1)])
    members, signs = [], []
    for one in sets:
        turns = sign_choices(tuple(KINDS[k] for k in pairs.kinds[one])) if align else np.ones((1, size))
        members.append(np.tile(one, (len(turns), 1)))
        signs.append(turns * pairs.signs[one])
    motors, good = samples(ground, pairs, np.concatenate(members), np.concatenate(signs))
    if not good.any():
        return None
    judges = pairs.some(random.permutation(n)[:COUNTED])
    found = np.sort(ground.squares(judges, motors[good], align if align else None), axis=1)
    count = max((len(judges) + 1) // 2, min(FEWEST_JUDGES, len(judges))) if robust else len(judges)
    best: Array = motors[good][np.nanargmin(np.where(np.isfinite(found), found, np.inf)[:, :count].sum(1))]
    return best
