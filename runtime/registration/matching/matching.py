"""Proximity matching (thesis 5.2): nearest or mutually nearest objects of a query and a reference by the costs of
rotors. Costs are computed in blocks: no (n, m) matrix is stored unless it is requested.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ... import objects
from ...codegen.algorithms.registration_layout import ELEMENT, MOTOR
from ...codegen.programs.registration.registration import KINDS
from ...common.validation import as_bool, as_choice, positive_float
from ...core.multivector import Multivector
from ..backends.driver import Driver
from ..backends.model_rows import MatchCriterion, ModelData
from ..backends.scene import Scene
from ..model.arguments import as_length, model_pair
from ..model.model import Model
from ..model.normalization import criterion_within, model_size, robust_center
from ..result import PerItem

Array = NDArray[Any]
#: Number of costs in memory at a time: 8 MiB.
BLOCK = 1 << 20
#: A distance, in units of the frame, that excludes no match; its square is finite.
ANYWHERE = 1e100
ASSIGNMENTS = ("one_sided", "symmetric")
#: Names of costs of rotors.
ROTOR_COSTS = ("positive", "thesis")
#: Names of costs of matches.
COSTS = (*ROTOR_COSTS, "distance")


@dataclass(frozen=True)
class Matching:
    """Matches of a query and a reference, by the cost of the rotor between two objects.

    Attributes
    ----------
    indices : PerItem of int
        Row of each query object's counterpart among the reference's objects of the same kind, -1 for none.
    costs : PerItem of float
        Cost of each match; infinite for none.
    signs : PerItem of float
        -1 if the counterpart has the opposite orientation, else 1.
    center, unit : array (3,), float
        Origin and unit of length of costs.
    """

    indices: PerItem
    costs: PerItem
    signs: PerItem
    center: Array
    unit: float

    @property
    def total(self) -> float:
        """C_total of 5.2: the sum of the costs of the matches."""
        costs = np.asarray(self.costs)
        return float(costs[np.isfinite(costs)].sum())


@dataclass(frozen=True)
class MatchingRule:
    """Options of `match`; ``max_distance`` is the threshold in units of the frame."""

    assignment: str = "one_sided"
    cost: str = "positive"
    align: bool = True
    max_distance: float = math.inf
    threads: int | None = None


#: Matches of one kind: rows of counterparts or -1, costs, signs.
KindMatches = tuple[Array, Array, Array]


def match(
    query: Any, reference: Any, *, assignment: str = "one_sided", cost: str = "positive", align: bool = True,
    threshold: float | None = None, length: float = 1.0, threads: int | None = None,
) -> Matching:  # fmt: skip
    """Nearest object of the reference for each object of the query, at the present poses of the models.

    Parameters
    ----------
    query, reference : Model, Multivector (n,), list of Multivector, or mapping
        Models, or batches of unit objects, by kind if there are several. Objects of kinds that only one of them has
        have no counterparts.
    assignment : "one_sided" or "symmetric"
        "one_sided": each query object has its nearest; several may have the same. "symmetric": only objects that are
        each other's nearest.
    cost : "positive", "thesis" or "distance"
        The first two are those of `objects.rotor_cost`: sums of squares, or (5.1) as printed, which dilations make
        negative: between rounds of different radii it prefers wrong matches. Between rounds both grow as radii shrink.
        "distance": (a^2 + 3 d^2)/4 with an angle a and a distance d of positions, and of radii; this is the cost of the
        rotor between points or planes, and the measure by which `register` matches. It is the best one for rounds.
    align : bool
        True if x and -x are the same object. Otherwise orientations must agree.
    threshold : float, optional
        Largest distance of a match, in the models' unit of length: the square root of "distance", where one radian is
        equivalent to ``length`` times the reference's size. Default: no limit.
    length : float
        Length that a rotation by one radian is equivalent to, in units of the reference's size.
    threads : int, optional
        Number of threads. Default: the package's (`bladesmith.set_threads`). The result does not depend on it.

    Raises
    ------
    InputError
        If a model is empty, they have no kind in common, or an argument is invalid.

    Notes
    -----
    Thesis 5.2. Costs of rotors depend on the origin and on the unit of length: they are those of
    `objects.cost_matrix` in a frame at the center of the reference, in units of its size (a power of two) times
    ``length``. Of equal costs the first row is chosen. Time grows with n m, memory does not: a block is 8 MiB.
    """
    x, y, center, unit = _in_common_frame(query, reference, length)
    max_distance = math.inf if threshold is None else positive_float(threshold, "threshold") / unit
    sided, ending = as_choice(assignment, "assignment", ASSIGNMENTS), as_choice(cost, "cost", COSTS)
    rule = MatchingRule(sided, ending, as_bool(align, "align"), max_distance, threads)
    matches = match_kinds(x, y, rule)
    missing = {k: (np.full(len(b), -1), np.full(len(b), math.inf), np.ones(len(b))) for k, b in x.items()}
    indices, costs, signs = (PerItem({k: matches.get(k, missing[k])[i] for k in x}) for i in range(3))
    return Matching(indices, costs, signs, center, unit)


def cost_matrix(
    query: Any, reference: Any, *, cost: str = "positive", align: bool = True, length: float = 1.0,
    threads: int | None = None,
) -> dict[str, Array]:  # fmt: skip
    """Costs of all pairs, by which `match` decides: (n, m) of each kind that both models have.

    Parameters
    ----------
    query, reference, cost, align, length, threads
        See `match`.

    Returns
    -------
    dict of kind to array (n, m)
        Infinite where there is no rotor.

    Raises
    ------
    InputError
        If a model is empty, they have no kind in common, or an argument is invalid.
    """
    x, y, _, _ = _in_common_frame(query, reference, length)
    ending, turned = as_choice(cost, "cost", COSTS), as_bool(align, "align")
    rule = MatchingRule(cost=ending, align=turned, threads=threads)
    if ending == "distance":
        common = tuple(k for k in x if k in y)
        driver = Driver(common, threads)
        a, b = (_model_data(driver, part, common).elements for part in (x, y))
        return {k: _distances(driver, k, a[k], b[k], turned) for k in common}
    return {k: np.concatenate(list(_blocks(x[k], y[k], rule))) for k in x if k in y}


def match_kinds(
    x: Mapping[str, Multivector], y: Mapping[str, Multivector], rule: MatchingRule
) -> dict[str, KindMatches]:
    """Matches of objects in one frame, of the kinds that both have."""
    common = tuple(k for k in x if k in y)
    driver = Driver(common, rule.threads)
    query, reference = [_model_data(driver, part, common) for part in (x, y)]
    nearest = _nearest_in_grid(query, reference, rule) if rule.cost == "distance" else {}
    matches = {}
    for kind in common:
        indices, costs = nearest[kind] if kind in nearest else _nearest(x[kind], y[kind], rule)
        signs = np.ones(len(indices))
        paired = np.flatnonzero(indices >= 0)
        first, second = query.elements[kind][paired], reference.elements[kind][indices[paired]]
        signs[
            paired[(first[:, 3:6] * second[:, 3:6]).sum(1) < 0]
        ] = -1  # of axes: rounds far apart agree by another sign
        if math.isfinite(rule.max_distance):
            too_far = paired[squares(driver, kind, first, second, rule.align) > rule.max_distance * rule.max_distance]
            indices[too_far], costs[too_far], signs[too_far] = -1, math.inf, 1
        matches[kind] = indices, costs, signs
    return matches


def _model_data(driver: Driver, objects: Mapping[str, Multivector], kinds: tuple[str, ...]) -> ModelData:
    rows = {k: np.ascontiguousarray(objects[k]._data, np.float64) for k in kinds}
    return ModelData(rows, {k: driver.elements(k, part) for k, part in rows.items()})


def _nearest(x: Multivector, y: Multivector, rule: MatchingRule) -> tuple[Array, Array]:
    n, m = x.shape[0], y.shape[0]
    indices, costs = np.full(n, -1), np.full(n, math.inf)
    query_of, query_costs = np.full(m, -1), np.full(m, math.inf)
    begin = 0
    for block in _blocks(x, y, rule):
        part = slice(begin, begin + len(block))
        indices[part] = best = block.argmin(1)
        costs[part] = block[np.arange(len(block)), best]
        if rule.assignment == "symmetric":
            best = block.argmin(0)
            least = block[best, np.arange(m)]
            better = least < query_costs
            query_of[better], query_costs[better] = begin + best[better], least[better]
        begin += len(block)
    unmatched = np.isinf(costs)
    if rule.assignment == "symmetric":
        unmatched |= query_of[indices] != np.arange(n)
    indices[unmatched], costs[unmatched] = -1, math.inf
    return indices, costs


def _nearest_in_grid(query: ModelData, reference: ModelData, rule: MatchingRule) -> dict[str, tuple[Array, Array]]:
    """Matches by distance, of all kinds, from the driver: with a threshold, distant pairs are skipped."""
    limit = criterion_within(min(rule.max_distance, ANYWHERE), 0.0, rule.align)
    matches = _match_with_driver(query, reference, limit, rule.threads)
    if rule.assignment == "symmetric":
        for kind, (query_of, _) in _match_with_driver(reference, query, limit, rule.threads).items():
            counterparts = matches[kind][0]
            counterparts[query_of[counterparts] != np.arange(len(counterparts))] = -1
    for indices, costs in matches.values():
        costs[indices < 0] = math.inf
    return matches


def _match_with_driver(
    query: ModelData, reference: ModelData, limit: MatchCriterion, threads: int | None
) -> dict[str, tuple[Array, Array]]:
    rows = [np.arange(len(part), dtype=np.int32) for part in query.rows.values()]
    kinds = [np.full(len(part), KINDS.index(k), np.int32) for k, part in query.rows.items()]
    scene = Scene(query, reference, np.concatenate(kinds), np.concatenate(rows), threads)
    scene.set_criterion(limit)
    indices, costs, _ = scene.match(np.eye(MOTOR)[0])
    ends = np.cumsum([len(part) for part in rows])[:-1]
    parts = (np.split(values, ends) for values in (indices.astype(np.int64), costs))
    return {k: (i.copy(), c.copy()) for k, i, c in zip(query.rows, *parts, strict=True)}


def _blocks(x: Multivector, y: Multivector, rule: MatchingRule) -> Iterator[Array]:
    """Costs of all pairs, some rows at a time; infinite without a rotor."""
    step = max(1, BLOCK // y.shape[0])
    for i in range(0, x.shape[0], step):
        block = objects.cost_matrix(x[i : i + step], y, rule.cost, rule.align, rule.threads)
        yield np.where(np.isnan(block), math.inf, block)


def _distances(driver: Driver, kind: str, a: Array, b: Array, align: bool) -> Array:
    """Squared distances of all pairs of elements."""
    step = max(1, BLOCK // (ELEMENT * len(b)))
    return np.concatenate(
        [squares(driver, kind, a[i : i + step, None], b[None], align) for i in range(0, len(a), step)]
    )


def squares(driver: Driver, kind: str, a: Array, b: Array, align: bool = True, signs: Array | None = None) -> Array:
    """Weighted squared distances of elements (.., 7), as of matches: 0.75 d^2 + 0.25 angle^2 for small ones.

    ``signs`` are relative orientations; without them, ``align`` allows both.
    """
    return driver.squared_distances(kind, a, b, criterion_within(1.0, align=align), signs)


def center_of(driver: Driver, model: Model) -> Array:
    """Robust center (3,) of all objects of a model."""
    return robust_center(driver, {k: driver.elements(k, x._data) for k, x in model.objects.items()})


def _in_common_frame(
    query: Any, reference: Any, length: float
) -> tuple[dict[str, Multivector], dict[str, Multivector], Array, float]:
    """Objects of both models in the frame of the reference, its center and its unit."""
    first, second = model_pair(query, reference)
    scale = as_length(length)
    driver = Driver(tuple(second.counts))
    center = center_of(driver, second)
    near = second.in_frame(center)
    size = model_size({k: driver.elements(k, x._data) for k, x in near.objects.items()})
    unit = scale * (2.0 ** round(math.log2(size)) if size > 0 else 1.0)
    return first.in_frame(center, unit).objects, second.in_frame(center, unit).objects, center, unit
