"""`iterate`: matching and estimation by turns, from where the models are (thesis 5.4)."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..arrays import truth
from ..codegen.programs.reform import KINDS
from ..multivector import Multivector
from ..objects.inputs import chosen
from .challenge import challenged
from .chance import meetings_of
from .contest import Contest
from .estimate import METHODS, How, estimated
from .estimators import SET_SIZE, Ground, Pairs, inward
from .finish import finish
from .frames import outward
from .given import as_motor, both, count, positive
from .job import Job
from .matching import ASSIGNMENTS, COSTS, Rule, matched
from .result import Registration, Step
from .search import TOLERANCES, Found

Array = NDArray[Any]
#: Rounds at most, and of the last refinement.
ROUNDS, FINAL_ROUNDS = 50, 10


def iterate(
    query: Any, reference: Any, start: Multivector | None = None, *, estimate: str = "direct",
    assignment: str = "one_sided", cost: str = "distance", iterations: int = ROUNDS, threshold: float | None = None,
    robust: bool = True, align: bool = True, length: float = 1.0, threads: int | None = None,
) -> Registration:  # fmt: skip
    """Register a query that lies near its reference: match, estimate the motor, move, until the matches stay.

    Parameters
    ----------
    query, reference : Model, Multivector (n,), list of Multivector, or mapping
        As of `match`.
    start : Multivector, optional
        A motor that moves the query before the first match. Default: it stays where it is.
    estimate : "direct", "optimize" or "linear"
        See `estimate_rotor`.
    assignment, cost, align
        See `match`.
    iterations : int
        Rounds at most.
    threshold : float, optional
        Distance, in the models' unit of length, up to which matches count, as of `match`; as long as the middle one is
        farther, that one's.
    robust : bool
        Leave out matches more than 4 times as far apart as the middle one, if there is no threshold.
    length : float
        What a rotation by a radian counts as, against translations, in units of the models' size.
    threads : int, optional
        Default: all processors of this process. The result does not depend on it.

    Returns
    -------
    Registration
        The pose where the matches stay, finished as every registration: matches by distance, least positive cost. Of
        ``history`` each step "match" tells the largest distance of matches that count, in the models' size, the round,
        how many count, and the cost of all. ``converged`` says that the agreement is no chance, and that a quick search
        from everywhere finds none that is clearly better: models with many parallel lines or planes agree in part in
        many places (5.4).

    Raises
    ------
    InputError
        If a model is empty, they have no kind in common, or an argument makes no sense.
    MissingExtraError
        For "optimize" without scipy.

    Notes
    -----
    Thesis 5.4, an iterative closest point algorithm for objects of any grade. It ends when a matching comes back.
    """
    first, second = both(query, reference)
    ground = Ground(first, second, positive(length, "length"), threads)
    reach = None if threshold is None else positive(threshold, "threshold") / ground.reference.unit
    way, ending = chosen(estimate, METHODS, "estimate"), chosen(cost, COSTS, "cost")
    how = How(way, "thesis" if ending == "thesis" else "positive", None, truth(robust, "robust"), reach)
    rule = Rule(chosen(assignment, ASSIGNMENTS, "assignment"), ending, truth(align, "align"), math.inf, threads)
    given = None if start is None else as_motor(start, "start")
    rounds = count(iterations, "iterations")
    motor, history = _settled(ground, how, rule, inward(given, ground.query, ground.reference), rounds)
    job = Job(first.objects, second.objects, threads=threads, align=rule.align, length=float(length))
    job.history.extend(history)
    world = outward(ground.driver, motor[None], ground.query, ground.reference, ground.algebra)[0]
    best = inward(world, job.query, job.reference)
    meetings = meetings_of(job.scene, job.algebra, job.align, job.length)
    found = Found(
        motors=best[None], scores=np.zeros(1), hits=np.zeros(1, np.int32), tolerance=TOLERANCES[-1],
        candidates=len(history), contest=Contest(job.scene, meetings, SET_SIZE, job.align, job.length),
    )  # fmt: skip
    return challenged(job, finish(job, found, FINAL_ROUNDS, first.counts))


def _settled(ground: Ground, how: How, rule: Rule, motor: Array, rounds: int) -> tuple[Array, list[Step]]:
    """The motor (8,) where matches stay, or come back, and what was done."""
    history: list[Step] = []
    known: set[bytes] = set()
    for number in range(1, rounds + 1):
        pairs, cost = _matched(ground, rule, motor)
        state = b"".join(a.tobytes() for a in (pairs.kinds, pairs.query, pairs.reference))
        if not len(pairs) or state in known:
            break
        known.add(state)
        moved, keep, _ = estimated(ground, pairs, how, motor)
        if not np.isfinite(moved).all():
            break
        motor = moved
        far = math.sqrt(float(ground.squares(pairs.some(keep), motor[None]).max(initial=0)))
        history.append(Step("match", far, number, int(keep.sum()), cost))
    return motor, history


def _matched(ground: Ground, rule: Rule, motor: Array) -> tuple[Pairs, float]:
    """Which objects are nearest where a motor leads the query, and the cost of all."""
    moved = {k: (ground.motors(motor) >> x).as_kind(k, check=False) for k, x in ground.query.objects.items()}
    parts: list[tuple[Array, ...]] = []
    total = 0.0
    for kind, (indices, costs, signs) in matched(moved, ground.reference.objects, rule).items():
        rows = np.flatnonzero(indices >= 0)
        total += float(costs[rows].sum())
        parts.append((np.full(len(rows), KINDS.index(kind)), rows, indices[rows], signs[rows]))
    kinds, query, reference, signs = (np.concatenate(p) for p in zip(*parts, strict=True))
    return Pairs(kinds.astype(np.int32), query.astype(np.int32), reference.astype(np.int32), signs), total


__all__ = ["iterate"]
