"""Proximity matching (thesis 5.2): each object of a query with the one of a reference that the rotor of least cost
leads to, or both with each other. Costs are made in blocks: no (n, m) matrix is kept unless it is asked for.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import objects
from ..arrays import truth
from ..codegen.programs.reform import KINDS
from ..multivector import Multivector
from ..objects.inputs import chosen
from .engine import Driver, Scene
from .frames import closeness_within, middle, size_of
from .given import both, positive
from .model import Model
from .result import PerItem
from .sides import ELEMENT, Closeness, Side
from .stages import MOTOR

Array = NDArray[Any]
#: Pairs whose costs are in memory at a time: 8 MiB of them.
BLOCK = 1 << 20
#: A distance, in units of the frame, that says nothing; its square is a number.
ANYWHERE = 1e100
ASSIGNMENTS = ("one_sided", "symmetric")
#: Costs of rotors; and of matches besides, by what they are made from.
ROTOR_COSTS = ("positive", "thesis")
COSTS = (*ROTOR_COSTS, "distance")


@dataclass(frozen=True)
class Matching:
    """Which objects belong together, by what it costs to take one to the other.

    Attributes
    ----------
    indices : PerItem of int
        For each query object the row of its counterpart among the reference's of the same kind, -1 for none.
    costs : PerItem of float
        What each match costs; infinite for none.
    signs : PerItem of float
        -1 where the counterpart is turned the other way round, else 1.
    center, unit : array (3,), float
        Where costs are measured from, and the length that counts as 1.
    """

    indices: PerItem
    costs: PerItem
    signs: PerItem
    center: Array
    unit: float

    @property
    def total(self) -> float:
        """C_total of 5.2: the sum over the objects that have a counterpart."""
        costs = np.asarray(self.costs)
        return float(costs[np.isfinite(costs)].sum())


@dataclass(frozen=True)
class Rule:
    """How objects are matched: as of `match`; ``reach`` is the threshold in units of the frame."""

    assignment: str = "one_sided"
    cost: str = "positive"
    align: bool = True
    reach: float = math.inf
    threads: int | None = None


#: Of one kind: rows of counterparts or -1, costs, signs.
Found = tuple[Array, Array, Array]


def match(
    query: Any, reference: Any, *, assignment: str = "one_sided", cost: str = "positive", align: bool = True,
    threshold: float | None = None, length: float = 1.0, threads: int | None = None,
) -> Matching:  # fmt: skip
    """For each object of the query the nearest one of the reference, where the two models are.

    Parameters
    ----------
    query, reference : Model, Multivector (n,), list of Multivector, or mapping
        Models, or plain batches of unit objects, by kind where there are several. Kinds that only one of them has have
        no counterparts.
    assignment : "one_sided" or "symmetric"
        "one_sided": each query object has its nearest; several may have the same. "symmetric": only objects that are
        each other's nearest.
    cost : "positive", "thesis" or "distance"
        The first two: see `objects.rotor_cost`: sums of squares, or (5.1) as printed, which dilations make negative:
        between rounds of different radii it prefers wrong ones. Between rounds both grow as radii get small.
        "distance": (a^2 + 3 d^2)/4 with an angle a and a distance d of positions, and of radii, which is what the
        rotor between points or planes costs; the measure by which `register` matches. Rounds are matched best by it.
    align : bool
        x and -x are one object. Otherwise orientations must agree.
    threshold : float, optional
        Distance, in the models' unit of length, up to which two objects may be one: the square root of "distance", a
        radian counting ``length`` times the reference's size. Default: any.
    length : float
        What a rotation by a radian counts as, against translations, in units of the reference's size.
    threads : int, optional
        Default: all processors of this process. The result does not depend on it.

    Raises
    ------
    InputError
        If a model is empty, they have no kind in common, or an argument makes no sense.

    Notes
    -----
    Thesis 5.2. Costs of rotors depend on the origin and on the unit of length: they are those of
    `objects.cost_matrix` seen from the middle of the reference, in units of its size (a power of two) times
    ``length``. Of equal costs the first row wins. Time grows with n m, memory does not: a block is 8 MiB.
    """
    x, y, center, unit = _framed(query, reference, length)
    reach = math.inf if threshold is None else positive(threshold, "threshold") / unit
    sided, ending = chosen(assignment, ASSIGNMENTS, "assignment"), chosen(cost, COSTS, "cost")
    rule = Rule(sided, ending, truth(align, "align"), reach, threads)
    found = matched(x, y, rule)
    missing = {k: (np.full(len(b), -1), np.full(len(b), math.inf), np.ones(len(b))) for k, b in x.items()}
    indices, costs, signs = (PerItem({k: found.get(k, missing[k])[i] for k in x}) for i in range(3))
    return Matching(indices, costs, signs, center, unit)


def cost_matrix(
    query: Any, reference: Any, *, cost: str = "positive", align: bool = True, length: float = 1.0,
    threads: int | None = None,
) -> dict[str, Array]:  # fmt: skip
    """The costs by which `match` decides: (n, m) of each kind that both models have.

    Parameters
    ----------
    query, reference, cost, align, length, threads
        As of `match`.

    Returns
    -------
    dict of kind to array (n, m)
        Infinite where there is no rotor.

    Raises
    ------
    InputError
        If a model is empty, they have no kind in common, or an argument makes no sense.
    """
    x, y, _, _ = _framed(query, reference, length)
    ending, turned = chosen(cost, COSTS, "cost"), truth(align, "align")
    rule = Rule(cost=ending, align=turned, threads=threads)
    if ending == "distance":
        common = tuple(k for k in x if k in y)
        driver = Driver(common, threads)
        a, b = (_side(driver, part, common).elements for part in (x, y))
        return {k: _distances(driver, k, a[k], b[k], turned) for k in common}
    return {k: np.concatenate(list(_blocks(x[k], y[k], rule))) for k in x if k in y}


def matched(x: Mapping[str, Multivector], y: Mapping[str, Multivector], rule: Rule) -> dict[str, Found]:
    """Matches of the kinds that both have, of objects in one frame."""
    common = tuple(k for k in x if k in y)
    driver = Driver(common, rule.threads)
    query, reference = [_side(driver, part, common) for part in (x, y)]
    near = _nearest_in_grid(query, reference, rule) if rule.cost == "distance" else {}
    found = {}
    for kind in common:
        indices, costs = near[kind] if kind in near else _nearest(x[kind], y[kind], rule)
        signs = np.ones(len(indices))
        has = np.flatnonzero(indices >= 0)
        first, second = query.elements[kind][has], reference.elements[kind][indices[has]]
        signs[has[(first[:, 3:6] * second[:, 3:6]).sum(1) < 0]] = -1  # of axes: rounds far apart agree by another sign
        if math.isfinite(rule.reach):
            far = has[squares(driver, kind, first, second, rule.align) > rule.reach * rule.reach]
            indices[far], costs[far], signs[far] = -1, math.inf, 1
        found[kind] = indices, costs, signs
    return found


def _side(driver: Driver, given: Mapping[str, Multivector], kinds: tuple[str, ...]) -> Side:
    rows = {k: np.ascontiguousarray(given[k]._data, np.float64) for k in kinds}
    return Side(rows, {k: driver.elements(k, part) for k, part in rows.items()})


def _nearest(x: Multivector, y: Multivector, rule: Rule) -> tuple[Array, Array]:
    n, m = x.shape[0], y.shape[0]
    indices, costs = np.full(n, -1), np.full(n, math.inf)
    back, back_costs = np.full(m, -1), np.full(m, math.inf)
    begin = 0
    for block in _blocks(x, y, rule):
        part = slice(begin, begin + len(block))
        indices[part] = best = block.argmin(1)
        costs[part] = block[np.arange(len(block)), best]
        if rule.assignment == "symmetric":
            best = block.argmin(0)
            least = block[best, np.arange(m)]
            better = least < back_costs
            back[better], back_costs[better] = begin + best[better], least[better]
        begin += len(block)
    lost = np.isinf(costs)
    if rule.assignment == "symmetric":
        lost |= back[indices] != np.arange(n)
    indices[lost], costs[lost] = -1, math.inf
    return indices, costs


def _nearest_in_grid(query: Side, reference: Side, rule: Rule) -> dict[str, tuple[Array, Array]]:
    """The same by distance, of all kinds, from the driver: far pairs are not looked at where there is a threshold."""
    limit = closeness_within(min(rule.reach, ANYWHERE), 0.0, rule.align)
    found = _driven(query, reference, limit, rule.threads)
    if rule.assignment == "symmetric":
        for kind, (back, _) in _driven(reference, query, limit, rule.threads).items():
            there = found[kind][0]
            there[back[there] != np.arange(len(there))] = -1
    for indices, costs in found.values():
        costs[indices < 0] = math.inf
    return found


def _driven(query: Side, reference: Side, limit: Closeness, threads: int | None) -> dict[str, tuple[Array, Array]]:
    rows = [np.arange(len(part), dtype=np.int32) for part in query.rows.values()]
    kinds = [np.full(len(part), KINDS.index(k), np.int32) for k, part in query.rows.items()]
    scene = Scene(query, reference, np.concatenate(kinds), np.concatenate(rows), threads)
    scene.closeness(limit)
    indices, costs, _ = scene.match(np.eye(MOTOR)[0])
    ends = np.cumsum([len(part) for part in rows])[:-1]
    parts = (np.split(values, ends) for values in (indices.astype(np.int64), costs))
    return {k: (i.copy(), c.copy()) for k, i, c in zip(query.rows, *parts, strict=True)}


def _blocks(x: Multivector, y: Multivector, rule: Rule) -> Iterator[Array]:
    """Costs of all pairs, some rows at a time; infinite where there is none."""
    step = max(1, BLOCK // y.shape[0])
    for i in range(0, x.shape[0], step):
        block = objects.cost_matrix(x[i : i + step], y, rule.cost, rule.align, rule.threads)
        yield np.where(np.isnan(block), math.inf, block)


def _distances(driver: Driver, kind: str, a: Array, b: Array, align: bool) -> Array:
    """Squares of the distances of all pairs of elements."""
    step = max(1, BLOCK // (ELEMENT * len(b)))
    return np.concatenate(
        [squares(driver, kind, a[i : i + step, None], b[None], align) for i in range(0, len(a), step)]
    )


def squares(driver: Driver, kind: str, a: Array, b: Array, align: bool = True, signs: Array | None = None) -> Array:
    """Weighted squares of how far elements (.., 7) are apart, as of matches: 0.75 d^2 + 0.25 angle^2 for small ones.

    ``signs`` says which are turned round; where it is not given, ``align`` does.
    """
    return driver.apart(kind, a, b, closeness_within(1.0, align=align), signs)


def center_of(driver: Driver, model: Model) -> Array:
    """The point (3,) nearest to all objects of a model together."""
    return middle(driver, {k: driver.elements(k, x._data) for k, x in model.objects.items()})


def _framed(
    query: Any, reference: Any, length: float
) -> tuple[dict[str, Multivector], dict[str, Multivector], Array, float]:
    """Objects of both models in the frame of the reference, its centre and its unit."""
    first, second = both(query, reference)
    scale = positive(length, "length")
    driver = Driver(tuple(second.counts))
    center = center_of(driver, second)
    near = second.in_frame(center)
    size = size_of({k: driver.elements(k, x._data) for k, x in near.objects.items()})
    unit = scale * (2.0 ** round(math.log2(size)) if size > 0 else 1.0)
    return first.in_frame(center, unit).objects, second.in_frame(center, unit).objects, center, unit


__all__ = ["Matching", "cost_matrix", "match"]
