"""`estimate_rotor`: the motor between matched objects (thesis 5.3)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...codegen.errors import ShapeError, SingularError, UndeterminedError
from ...codegen.programs.registration.registration import KINDS
from ...common.validation import as_bool, as_choice, as_int, positive_float
from ...core.multivector import Multivector
from ...status import Status
from ..matching.matching import ROTOR_COSTS
from ..model.arguments import as_length, as_motor, model_pair
from ..model.model import Model
from ..model.normalization import motors_to_world, scale_coefficients
from ..model.parameters import PLURALS
from ..result import PerItem
from .estimators import (
    EstimatorResult,
    ModelPair,
    Pairs,
    consensus,
    direct,
    linear,
    motor_to_frames,
    optimize,
    summed_rates,
)
from .gauge_freedom import canonical_twist_basis, describe_twists, free_motions
from .refinement import rates

Array = NDArray[Any]
METHODS = ("direct", "optimize", "linear")
#: Outliers are pairs whose distance is more than this many times the median.
OUTLIER_FACTOR = 4.0
#: Pairs up to this distance are no outliers: rounding.
MIN_OUTLIER_DISTANCE = 1e-7
#: Largest number of rounds of trimming outliers.
TRIMMING_ROUNDS = 12
#: Smallest number of inliers.
MIN_INLIERS = 3


@dataclass(frozen=True)
class Estimate:
    """A motor between matched objects, with details of its estimation.

    Attributes
    ----------
    motor : Multivector
        Takes the query's objects to the reference's.
    cost : float
        Sum of the costs of the inliers, in the reference's frame (``center``, ``unit``).
    iterations : int
        Loops of Algorithm 1, or steps of the minimization; of the last round where outliers are trimmed.
    history : tuple of float
        "direct": change of the motor in each loop. "optimize": the cost after each step. "linear": the cost before and
        after the refinement.
    status : Status
        OK; NOT_CONVERGED: the iterations ended too early; NOT_UNIQUE: the objects leave motions free
        (``undetermined``), one of many motors is returned.
    inliers : PerItem of bool
        Pairs that are no outliers.
    signs : PerItem of float
        -1 for pairs of opposite orientations, else 1.
    undetermined : Multivector, shape (m,)
        Twists of the free motions.
    center, unit : array (3,), float
        Origin and unit of length of costs.
    """

    motor: Multivector
    cost: float
    iterations: int
    history: tuple[float, ...]
    status: Status
    inliers: PerItem
    signs: PerItem
    undetermined: Multivector
    center: Array
    unit: float

    @property
    def converged(self) -> bool:
        """True if the status is OK."""
        return self.status == Status.OK

    @property
    def message(self) -> str:
        """Why it has not converged; else empty."""
        return _MESSAGES.get(self.status, "")


_MESSAGES = {
    Status.NOT_CONVERGED: "the iterations ended too early",
    Status.NOT_UNIQUE: "the objects leave motions free",
}


@dataclass(frozen=True)
class EstimationOptions:
    """Options of `estimate_rotor`; ``max_distance`` is the threshold in units of the frame."""

    method: str = "direct"
    cost: str = "positive"
    iterations: int | None = None
    robust: bool = False
    max_distance: float | None = None

    @property
    def trims(self) -> bool:
        """True if outliers are trimmed."""
        return self.robust or self.max_distance is not None


@overload
def estimate_rotor(
    query_objects: Any, reference_objects: Any, method: str = ..., *, cost: str = ..., align: bool = ...,
    robust: bool = ..., threshold: float | None = ..., start: Multivector | ArrayLike | None = ...,
    iterations: int | None = ..., length: float = ..., seed: int = ...,
    threads: int | None = ..., details: Literal[False] = ..., strict: bool = ...,
) -> Multivector: ...  # fmt: skip
@overload
def estimate_rotor(
    query_objects: Any, reference_objects: Any, method: str = ..., *, cost: str = ..., align: bool = ...,
    robust: bool = ..., threshold: float | None = ..., start: Multivector | ArrayLike | None = ...,
    iterations: int | None = ..., length: float = ..., seed: int = ...,
    threads: int | None = ..., details: Literal[True], strict: bool = ...,
) -> Estimate: ...  # fmt: skip
def estimate_rotor(
    query_objects: Any, reference_objects: Any, method: str = "direct", *, cost: str = "positive", align: bool = True,
    robust: bool = False, threshold: float | None = None, start: Multivector | ArrayLike | None = None,
    iterations: int | None = None, length: float = 1.0, seed: int = 0, threads: int | None = None,
    details: bool = False, strict: bool = False,
) -> Multivector | Estimate:  # fmt: skip
    """The motor that takes objects to others, each to its own counterpart.

    Parameters
    ----------
    query_objects, reference_objects : Model, Multivector (n,), list of Multivector, or mapping
        Matched objects: equally many of each kind, in the same order.
    method : "direct", "optimize" or "linear"
        "direct": Algorithm 1. "optimize": least cost by quasi-Newton steps in the space of bivectors, with an analytic
        gradient. "linear": the least sum of ``|R X - Y R|^2``, and from there the least positive cost by Gauss-Newton
        steps; the fastest, and the only one that needs no start.
    cost : "positive" or "thesis"
        Cost that "optimize" minimizes and that is returned; see `objects.rotor_cost`.
    align : bool
        True if x and -x are the same object. Otherwise orientations must agree.
    robust : bool
        Trim outliers: pairs whose distance is more than 4 times the median, until they stay the same. It starts from a
        consensus of minimal sets, and works as long as more than half of the pairs are correct.
    threshold : float, optional
        Trim pairs at a larger distance than this instead, as in `match`.
    start : Multivector or array (4, 4), optional
        Initial motor, of cga3d or pga3d, or its matrix. Default: "direct" starts with coincident centers of the models,
        "optimize" from the linear motor.
    iterations : int, optional
        Largest number. Default: 500 loops of Algorithm 1, 200 steps of BFGS, 30 Gauss-Newton steps.
    length : float
        Length that a rotation by one radian is equivalent to, in units of the models' size.
    seed : int
        Seed of the minimal sets of the consensus.
    threads : int, optional
        Number of threads. Default: the package's (`bladesmith.set_threads`). The result does not depend on it.
    details : bool
        Return an `Estimate`.
    strict : bool
        Raise an error if the objects leave motions free, or the iterations end too early.

    Returns
    -------
    Multivector or Estimate
        A motor with <R>_0 >= 0. Its ``status`` is `Status.NOT_UNIQUE` if the objects leave motions free: it is one of
        many then, and ``details`` contain the motions.

    Raises
    ------
    InputError
        If there are no objects, an argument is invalid, or the printed cost is to be minimized between rounds.
    ShapeError
        If the numbers of objects of a kind differ.
    UndeterminedError
        With ``strict``, if the objects leave motions free: the error describes them and holds them as ``motions``.
    SingularError
        With ``strict``, if the iterations ended too early.

    Notes
    -----
    Weights and covariances do not count here, and segments are the lines through their ends: `register` and `iterate`
    refine by them.

    Thesis 5.3. Algorithm 1 moves each object half of its displacement by the square root of its rotor, with the
    corrections that this needs: it stops when a loop changes the motor, up to sign, by less than 1e-13. Rounds are
    represented by their carriers (center and axis), since the rotor between rounds is not a motor, and the motor next
    to it does not converge. Points and spheres take their axes from another one, half of the model away; a point alone
    determines no rotation. Parallel axes determine no rotation about themselves: where all are parallel, the linear
    motor is the start.
    Exact objects are reached to rounding, 20 lines in about 6 loops, 20 planes in 12, five of either in 20 to 100. With
    noise the motor follows a cycle in each loop: the mean of its last motors is returned, which is nearly as good as
    the least cost (the last one is not: it depends on the order, and does not improve with more objects).

    Examples
    --------
    >>> import bladesmith as bs
    >>> from bladesmith import reform
    >>> lines = bs.cga3d.line([(0, 0, 0), (1, 0, 0), (0, 2, 0)], [(1, 0, 1), (0, 1, 0), (0, 1, 3)])
    >>> motor = bs.cga3d.translator((1, 2, 3)) * bs.cga3d.rotor((0, 0, 1), 0.5)
    >>> found = reform.estimate_rotor(lines, motor >> lines)
    >>> abs((found * ~motor - 1).values).max() < 1e-12
    True
    """
    whole, refuses = as_bool(details, "details"), as_bool(strict, "strict")
    query, reference = model_pair(query_objects, reference_objects)
    _check_counts(query, reference)
    models = ModelPair(query, reference, as_length(length), threads)
    max_distance = None if threshold is None else positive_float(threshold, "threshold") / models.reference.unit
    way, ending = as_choice(method, "method", METHODS), as_choice(cost, "cost", ROTOR_COSTS)
    most = None if iterations is None else as_int(iterations, "iterations")
    options = EstimationOptions(way, ending, most, as_bool(robust, "robust"), max_distance)
    first = None if start is None else motor_to_frames(as_motor(start, "start"), models.query, models.reference)
    pairs, first = _initial_pairs(models, as_bool(align, "align"), options, first, as_int(seed, "seed", 0))
    motor, inliers, last = estimate_with_trimming(models, pairs, options, first)
    found = _result(models, pairs, motor, inliers, last, options)
    if refuses:
        _refuse(found)
    return found if whole else found.motor


def _refuse(found: Estimate) -> None:
    """Raise where a motor is one of many, or not at rest."""
    if found.status == Status.NOT_UNIQUE:
        raise UndeterminedError(
            f"the objects leave free, or nearly free, {describe_twists(found.undetermined)}.",
            remedy="Give objects that move with them, or leave strict out", motions=found.undetermined, result=found,
        )  # fmt: skip
    if found.status != Status.OK:
        what = f"no convergence after {found.iterations} iterations: {found.status.name}."
        raise SingularError(what, remedy="Allow more iterations, use another method, or leave strict out")


def _check_counts(query: Model, reference: Model) -> None:
    for kind in KINDS:
        n, m = (model.counts.get(kind, 0) for model in (query, reference))
        if n != m:
            raise ShapeError(
                f"the query has {n} {PLURALS[kind]} and the reference {m}; matched objects come in equal numbers.",
                remedy="Match them first, with reform.match or reform.register",
            )


def _initial_pairs(
    models: ModelPair, align: bool, options: EstimationOptions, start: Array | None, seed: int
) -> tuple[Pairs, Array]:
    """All pairs with their orientations, and the initial motor."""
    counts = [len(rows) for rows in models.query.data.rows.values()]
    kinds = np.repeat([KINDS.index(k) for k in models.query.data.rows], counts).astype(np.int32)
    rows = np.concatenate([np.arange(n, dtype=np.int32) for n in counts])
    pairs = Pairs(kinds, rows, rows, np.ones(len(rows)))
    identity = np.array(models.algebra.translator((0.0, 0.0, 0.0)).as_kind("motor", check=False)._data, np.float64)
    consensus_motor = None
    if start is None and (align or options.trims or options.method == "optimize"):
        consensus_motor = consensus(models, pairs, align, options.trims, np.random.default_rng(seed))
    initial = start if start is not None else consensus_motor if consensus_motor is not None else identity
    if align:
        pairs = models.orient(pairs, initial)
    if options.method == "optimize" and start is None and not options.trims:
        initial = linear(models, pairs, initial, 0).motor
    return pairs, initial if start is not None or options.trims or options.method != "direct" else identity


def estimate_with_trimming(
    models: ModelPair, pairs: Pairs, options: EstimationOptions, start: Array
) -> tuple[Array, Array, EstimatorResult]:
    """Motor (8,) of pairs, mask of the inliers (n,), and the last estimate."""
    if not options.trims:
        result = _estimate(models, pairs, options, start)
        return result.motor, np.ones(len(pairs), bool), result
    motor, inliers = start, _inlier_mask(models.squares(pairs, start[None])[0], options.max_distance)
    for _ in range(TRIMMING_ROUNDS):
        result = _estimate(models, pairs.take(inliers), options, motor)
        if not np.isfinite(result.motor).all():
            break
        motor = result.motor
        before, inliers = inliers, _inlier_mask(models.squares(pairs, motor[None])[0], options.max_distance)
        if np.array_equal(inliers, before):
            break
    return motor, inliers, result


def _estimate(models: ModelPair, pairs: Pairs, options: EstimationOptions, start: Array) -> EstimatorResult:
    if options.method == "direct":
        return direct(models, pairs, start, options.iterations)
    if options.method == "linear":
        return linear(models, pairs, start, options.iterations)
    return optimize(models, pairs, start, options.iterations, options.cost)


def _inlier_mask(squares: Array, max_distance: float | None) -> Array:
    """Inlier mask: distance at most ``max_distance`` or the median, whichever is larger; or 4 times the median."""
    squares = np.where(np.isfinite(squares), squares, np.inf)
    middle = float(np.median(squares))
    limit = (
        max(OUTLIER_FACTOR * OUTLIER_FACTOR * middle, MIN_OUTLIER_DISTANCE**2)
        if max_distance is None
        else max(max_distance * max_distance, middle)
    )
    least = np.sort(squares)[min(MIN_INLIERS, len(squares)) - 1]
    return np.asarray(squares <= max(limit, float(least)))


def _result(
    models: ModelPair, pairs: Pairs, motor: Array, inliers: Array, last: EstimatorResult, options: EstimationOptions
) -> Estimate:
    world = motors_to_world(models.driver, motor[None], models.query, models.reference, models.algebra)[0]
    inlier_pairs = pairs.take(inliers)
    free = canonical_twist_basis(free_motions(rates(models.scene, motor, inlier_pairs.by_kind()).modes), models.algebra)
    twists = models.algebra.wrap(models.algebra.kind("twist"), free)
    center, unit = models.reference.center, models.reference.unit
    status = Status.OK if last.settled else Status.NOT_CONVERGED
    if len(free):
        status = Status.NOT_UNIQUE
        world = world._make(world._type, world._data, world.shape, np.uint8(status))
    return Estimate(
        motor=world, cost=summed_rates(models, inlier_pairs, motor, options.cost)[0], iterations=last.iterations,
        history=last.history, status=status, inliers=_per_item(pairs, inliers), signs=_per_item(pairs, pairs.signs),
        undetermined=models.algebra.translator(center) >> scale_coefficients(twists, unit), center=center, unit=unit,
    )  # fmt: skip


def _per_item(pairs: Pairs, values: Array) -> PerItem:
    parts = {kind: values[pairs.kinds == i] for i, kind in enumerate(KINDS)}
    return PerItem({kind: part for kind, part in parts.items() if len(part)})
