"""`estimate_rotor`: the motor between objects that are matched already (thesis 5.3)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..arrays import truth
from ..codegen.errors import ShapeError, SingularError, UndeterminedError
from ..codegen.programs.reform import KINDS
from ..multivector import Multivector
from ..objects.inputs import chosen
from ..status import Status
from .estimators import Estimated, Ground, Pairs, consensus, direct, inward, linear, optimized, summed_rates
from .frames import outward, scaled
from .freedom import free_motions, in_words, told
from .given import as_motor, both, count, positive
from .matching import ROTOR_COSTS
from .model import Model
from .parameters import PLURALS
from .polish import rates
from .result import PerItem

Array = NDArray[Any]
METHODS = ("direct", "optimize", "linear")
#: Outliers are pairs more than this many times as far apart as the middle one; what rounding leaves are none.
SPREAD, LEAST_SPREAD = 4.0, 1e-7
#: Rounds of leaving outliers out; pairs that are never left out.
TRIMS, LEAST_KEPT = 12, 3


@dataclass(frozen=True)
class Estimate:
    """A motor between matched objects, and how it was found.

    Attributes
    ----------
    motor : Multivector
        Takes the query's objects to the reference's.
    cost : float
        Sum of the costs of the inliers, in the reference's frame (``center``, ``unit``).
    iterations : int
        Loops of Algorithm 1, steps of the descent; of the last round where outliers are left out.
    history : tuple of float
        "direct": how far each loop moved the motor. "optimize": the cost after each step. "linear": the cost before and
        after the descent.
    status : Status
        OK; NOT_CONVERGED: the iterations ended before it came to rest; NOT_UNIQUE: the objects leave motions free
        (``undetermined``), one of many is returned.
    inliers : PerItem of bool
        Pairs that count.
    signs : PerItem of float
        -1 for pairs whose orientations are opposite, else 1.
    undetermined : Multivector, shape (m,)
        Twists of the motions that are left free.
    center, unit : array (3,), float
        Where costs are measured from, and the length that counts as 1.
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


@dataclass(frozen=True)
class How:
    """How motors are estimated: as of `estimate_rotor`; ``reach`` is the threshold in units of the frame."""

    method: str = "direct"
    cost: str = "positive"
    iterations: int | None = None
    robust: bool = False
    reach: float | None = None

    @property
    def trims(self) -> bool:
        """Whether outliers are left out."""
        return self.robust or self.reach is not None


def estimate_rotor(
    query_objects: Any, reference_objects: Any, method: str = "direct", *, cost: str = "positive", align: bool = True,
    robust: bool = False, threshold: float | None = None, start: Multivector | None = None,
    iterations: int | None = None, length: float = 1.0, seed: int = 0, threads: int | None = None,
    details: bool = False, strict: bool = False,
) -> Any:  # fmt: skip
    """The motor that takes objects to others, each to its own counterpart.

    Parameters
    ----------
    query_objects, reference_objects : Model, Multivector (n,), list of Multivector, or mapping
        As many of each kind; the first belongs to the first, and so on.
    method : "direct", "optimize" or "linear"
        "direct": Algorithm 1. "optimize": least cost by quasi-Newton steps in the space of bivectors, with an analytic
        gradient; it needs scipy (extra "optimize"). "linear": the least sum of |R X - Y R|^2, and from there the least
        positive cost by Gauss and Newton; the fastest, and the only one that needs no start.
    cost : "positive" or "thesis"
        What "optimize" makes least, and what is returned; see `objects.rotor_cost`.
    align : bool
        It does not matter how objects are turned. Otherwise orientations must agree.
    robust : bool
        Leave outliers out: pairs more than 4 times as far apart as the middle one, again and again until they stay.
        It starts from the vote of a few pairs at a time, and holds as long as more than half of the pairs are right.
    threshold : float, optional
        Leave out pairs that are farther apart than this instead, as of `match`.
    start : Multivector, optional
        A motor. Default: "direct" starts from the models' centres laid on each other, "optimize" from the linear motor.
    iterations : int, optional
        At most. Default: 500 loops of Algorithm 1, 200 of BFGS, 30 of Gauss and Newton.
    length : float
        What a rotation by a radian counts as, against translations, in units of the models' size.
    seed : int
        Of the sets that vote.
    threads : int, optional
        Default: all processors of this process. The result does not depend on it.
    details : bool
        Return an `Estimate`.
    strict : bool
        Raise where the objects leave motions free, or the iterations end early.

    Returns
    -------
    Multivector or Estimate
        A motor with <R>_0 >= 0. Its ``status`` is `Status.NOT_UNIQUE` where the objects leave motions free: it is one
        of many then, and ``details`` tell which motions.

    Raises
    ------
    InputError
        If there are no objects, an argument makes no sense, or the printed cost is to be made least between rounds.
    ShapeError
        If there are not as many of each kind.
    UndeterminedError
        With ``strict``, where the objects leave motions free: it names them, and has them as ``motions``.
    SingularError
        With ``strict``, where the iterations ended before the motor came to rest.
    MissingExtraError
        For "optimize" without scipy.

    Notes
    -----
    Thesis 5.3. Algorithm 1 takes each object half of its way by the square root of its rotor, with the corrections of
    docs/decisions: it stops where a loop changes the motor by less than 1e-13, whatever its sign. Rounds go by their
    carriers (centre and axis), since the rotor between rounds is no motor, and the motor next to it leads nowhere.
    Points and spheres take their axes from another one, half of the model away; by themselves they would never turn.
    Nor would parallel axes turn about themselves: where all are, it starts from the linear motor.
    Exact objects are met to rounding, 20 lines in about 6 loops, 20 planes in 12, five of either in 20 to 100. Noisy
    objects leave it going round in each loop: the middle of its last motors is returned, which is nearly as good as the
    least cost (the last one is not: it depends on the order, and gets no better with more objects).

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
    whole, refuses = truth(details, "details"), truth(strict, "strict")
    query, reference = both(query_objects, reference_objects)
    _check_counts(query, reference)
    ground = Ground(query, reference, positive(length, "length"), threads)
    reach = None if threshold is None else positive(threshold, "threshold") / ground.reference.unit
    way, ending = chosen(method, METHODS, "method"), chosen(cost, ROTOR_COSTS, "cost")
    most = None if iterations is None else count(iterations, "iterations")
    how = How(way, ending, most, truth(robust, "robust"), reach)
    first = None if start is None else inward(as_motor(start, "start"), ground.query, ground.reference)
    pairs, first = _prepared(ground, truth(align, "align"), how, first, count(seed, "seed", 0))
    motor, keep, last = estimated(ground, pairs, how, first)
    found = _result(ground, pairs, motor, keep, last, how)
    if refuses:
        _refuse(found)
    return found if whole else found.motor


def _refuse(found: Estimate) -> None:
    """Raise where a motor is one of many, or not at rest."""
    if found.status == Status.NOT_UNIQUE:
        raise UndeterminedError(
            f"the objects leave free, or nearly free, {in_words(found.undetermined)}.",
            remedy="Give objects that move with them, or leave strict out", motions=found.undetermined, result=found,
        )  # fmt: skip
    if found.status != Status.OK:
        what = f"the motor has not come to rest after {found.iterations} iterations: {found.status.name}."
        raise SingularError(what, remedy="Allow more iterations, use another method, or leave strict out")


def _check_counts(query: Model, reference: Model) -> None:
    for kind in KINDS:
        n, m = (model.counts.get(kind, 0) for model in (query, reference))
        if n != m:
            raise ShapeError(
                f"the query has {n} {PLURALS[kind]} and the reference {m}; matched objects come in equal numbers.",
                remedy="Match them first, with reform.match or reform.register",
            )


def _prepared(ground: Ground, align: bool, how: How, start: Array | None, seed: int) -> tuple[Pairs, Array]:
    """All pairs, turned the same way, and where to start."""
    counts = [len(rows) for rows in ground.query.side.rows.values()]
    kinds = np.repeat([KINDS.index(k) for k in ground.query.side.rows], counts).astype(np.int32)
    rows = np.concatenate([np.arange(n, dtype=np.int32) for n in counts])
    pairs = Pairs(kinds, rows, rows, np.ones(len(rows)))
    identity = np.array(ground.algebra.translator((0.0, 0.0, 0.0)).as_kind("motor", check=False)._data, np.float64)
    voted = None
    if start is None and (align or how.trims or how.method == "optimize"):
        voted = consensus(ground, pairs, align, how.trims, np.random.default_rng(seed))
    near = start if start is not None else voted if voted is not None else identity
    if align:
        pairs = ground.turned(pairs, near)
    if how.method == "optimize" and start is None and not how.trims:
        near = linear(ground, pairs, near, 0).motor
    return pairs, near if start is not None or how.trims or how.method != "direct" else identity


def estimated(ground: Ground, pairs: Pairs, how: How, start: Array) -> tuple[Array, Array, Estimated]:
    """The motor (8,) of pairs, which of them count (n,), and how the last estimate went."""
    if not how.trims:
        found = _estimate(ground, pairs, how, start)
        return found.motor, np.ones(len(pairs), bool), found
    motor, keep = start, _near(ground.squares(pairs, start[None])[0], how.reach)
    for _ in range(TRIMS):
        found = _estimate(ground, pairs.some(keep), how, motor)
        if not np.isfinite(found.motor).all():
            break
        motor = found.motor
        before, keep = keep, _near(ground.squares(pairs, motor[None])[0], how.reach)
        if np.array_equal(keep, before):
            break
    return motor, keep, found


def _estimate(ground: Ground, pairs: Pairs, how: How, start: Array) -> Estimated:
    if how.method == "direct":
        return direct(ground, pairs, start, how.iterations)
    if how.method == "linear":
        return linear(ground, pairs, start, how.iterations)
    return optimized(ground, pairs, start, how.iterations, how.cost)


def _near(squares: Array, reach: float | None) -> Array:
    """Which pairs are near: within the reach, or by what is usual; the nearer half at least, as long as they come."""
    squares = np.where(np.isfinite(squares), squares, np.inf)
    middle = float(np.median(squares))
    limit = max(SPREAD * SPREAD * middle, LEAST_SPREAD**2) if reach is None else max(reach * reach, middle)
    least = np.sort(squares)[min(LEAST_KEPT, len(squares)) - 1]
    return np.asarray(squares <= max(limit, float(least)))


def _result(ground: Ground, pairs: Pairs, motor: Array, keep: Array, last: Estimated, how: How) -> Estimate:
    world = outward(ground.driver, motor[None], ground.query, ground.reference, ground.algebra)[0]
    good = pairs.some(keep)
    free = told(free_motions(rates(ground.scene, motor, good.by_kind()).modes), ground.algebra)
    twists = ground.algebra.wrap(ground.algebra.kind("twist"), free)
    status = Status.OK if last.settled else Status.NOT_CONVERGED
    if len(free):
        status = Status.NOT_UNIQUE
        world = world._make(world._type, world._data, world.shape, np.uint8(status))
    return Estimate(
        motor=world, cost=summed_rates(ground, good, motor, how.cost)[0], iterations=last.iterations,
        history=last.history, status=status, inliers=_per_item(pairs, keep), signs=_per_item(pairs, pairs.signs),
        undetermined=ground.algebra.translator(ground.reference.center) >> scaled(twists, ground.reference.unit),
        center=ground.reference.center, unit=ground.reference.unit,
    )  # fmt: skip


def _per_item(pairs: Pairs, values: Array) -> PerItem:
    parts = {kind: values[pairs.kinds == i] for i, kind in enumerate(KINDS)}
    return PerItem({kind: part for kind, part in parts.items() if len(part)})


__all__ = ["Estimate", "estimate_rotor"]
