"""Lloyd's iterations on objects: starts, assignment to the nearest centroid, means (thesis 3.12.3).

Costs come from compiled loops over all pairs, sums from `numpy.bincount`: nothing here loops over objects.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import InputError
from ...core.multivector import Multivector
from ...dispatch.coefficients import embed
from ...dispatch.formulas import evaluate
from ..rotors.costs import COSTS, cost_via_rotors
from ..rotors.pairwise import nearest, pair_values

Labels = NDArray[np.int64]
Costs = NDArray[np.float64]


class Clustering:
    """One clustering: the objects, and what does not change.

    Parameters
    ----------
    x : Multivector, shape (n,)
        Objects as `inputs.as_objects` gives them.
    k : int
    weights : array (n,), optional
    cost : str
        Of the cost.
    align : bool
        Whether orientations do not matter.
    threads : int, optional

    Raises
    ------
    InputError
        If there are no objects, fewer than k, or one is invalid.
    """

    def __init__(
        self, x: Multivector, k: int, weights: NDArray[Any] | None, cost: str, align: bool, threads: int | None
    ) -> None:
        if not len(x):
            raise InputError("there are no objects to cluster.")
        bad = np.isnan(x._data).any(-1)
        if bad.any():
            raise InputError(f"object {int(bad.argmax())} is not an object ({int(bad.sum())} are not); leave them out.")
        if k > len(x):
            raise InputError(f"{k} clusters of {len(x)} objects: k is at most the number of objects.")
        self.x, self.k, self.weights, self.threads = x, k, weights, threads
        self.cost, self.align = cost, align
        self._columns = np.ascontiguousarray(x._data.T)
        self.formula = f"costs.{'aligned' if align else 'pair'}_cost{COSTS[cost]}"

    # -- starts --------------------------------------------------------------------------------------------

    def random_start(self, random: np.random.Generator) -> Multivector:
        """k different objects."""
        return self._items(np.sort(random.choice(len(self.x), self.k, replace=False)))

    def spread_start(self, random: np.random.Generator) -> Multivector:
        """k-means++: objects drawn by their cost to those before; of a few draws the one that saves most."""
        n, draws = len(self.x), 2 + int(np.log(self.k))
        weights = np.ones(n) if self.weights is None else self.weights
        indices = [int(_draw_indices(weights, 1, random)[0])]
        cost = self._to(indices)[0]
        while len(indices) < self.k:
            mass = weights * cost
            if not mass.sum() > 0:  # all others are where a centroid is
                rest = np.setdiff1d(np.arange(n), indices)
                indices.extend(int(i) for i in rest[: self.k - len(indices)])
                break
            candidates = _draw_indices(mass, draws, random)
            costs = np.minimum(cost, self._to(candidates))
            best = int((costs * weights).sum(1).argmin())  # not @: its bits may depend on the machine's threads
            indices.append(int(candidates[best]))
            cost = costs[best]
        return self._items(indices)

    def _items(self, indices: Any) -> Multivector:
        items: Multivector = self.x[indices]
        return items

    def _to(self, items: Any) -> Costs:
        """Costs from some objects to all, not negative; where no rotor is unique, the largest of the others."""
        cost = pair_values(self.formula, self._items(items), self.x, self.threads).astype(np.float64, copy=False)
        np.maximum(cost, 0, out=cost)
        usable = np.isfinite(cost)
        return cost if usable.all() else np.where(usable, cost, cost.max(where=usable, initial=1.0))

    # -- iterations ----------------------------------------------------------------------------------------

    def iterations(
        self, centroids: Multivector, max_iterations: int, tolerance: float
    ) -> Iterator[tuple[Labels, Multivector, float, int, bool]]:
        """Labels, centroids, cost, iterations and whether they converged: at the start, and after each iteration."""
        labels, cost = self._assign(self.x, centroids)
        total = self._total(cost)
        yield labels, centroids, total, 0, False
        for iteration in range(max_iterations):
            new = self._update_centroids(centroids, labels, cost)
            moved = (new._data != centroids._data).any(-1)
            if not moved.any():
                yield labels, centroids, total, iteration, True
                return
            new_labels, new_cost = self._reassign(new, moved, labels, cost)
            new_total = self._total(new_cost)
            has_settled = tolerance > 0 and total - new_total <= tolerance * abs(total)
            labels, centroids, cost, total = new_labels, new, new_cost, new_total
            yield labels, centroids, total, iteration + 1, has_settled
            if has_settled:
                return

    def _total(self, cost: Costs) -> float:
        return float(self._weigh(cost).sum())

    def _weigh(self, cost: Costs) -> Costs:
        """Cost times weight: nothing where the weight is zero, also of what is infinite."""
        if self.weights is None:
            return cost
        return np.asarray(np.multiply(cost, self.weights, out=np.zeros_like(cost), where=self.weights > 0))

    def _assign(self, x: Multivector, centroids: Multivector) -> tuple[Labels, Costs]:
        """Nearest centroid of each object, and the cost; the careful way for what has only unusual rotors."""
        labels, cost = nearest(self.formula, x, centroids, self.threads)
        cost = cost.astype(np.float64)
        lost = np.flatnonzero(labels < 0)
        if len(lost):
            i, j = np.repeat(lost, len(centroids)), np.tile(np.arange(len(centroids)), len(lost))
            careful, _ = cost_via_rotors(x[i], centroids[j], self.cost, self.align)
            table = careful.reshape(len(lost), -1)
            labels[lost], cost[lost] = table.argmin(1), table.min(1)
        return labels, cost

    def _reassign(
        self, centroids: Multivector, moved: NDArray[np.bool_], labels: Labels, cost: Costs
    ) -> tuple[Labels, Costs]:
        """`_assign` after only some centroids moved: objects of the others are compared with those alone."""
        if moved.all():
            return self._assign(self.x, centroids)
        labels, cost = labels.copy(), cost.copy()
        left = moved[labels]
        if left.any():
            labels[left], cost[left] = self._assign(self.x[left], centroids)
        names, stay = np.flatnonzero(moved), np.flatnonzero(~left)
        found, least = nearest(self.formula, self.x[stay], centroids[names], self.threads)
        names_found = names[found]
        better = (least < cost[stay]) | ((least == cost[stay]) & (names_found < labels[stay]))
        better &= found >= 0
        labels[stay[better]], cost[stay[better]] = names_found[better], least[better]
        return labels, cost

    def _update_centroids(self, centroids: Multivector, labels: Labels, cost: Costs) -> Multivector:
        """Centroids of the clusters: projected sums of members; for empty clusters the farthest objects."""
        data = self.x._data
        factors = np.ones(len(data)) if self.weights is None else self.weights
        if self.align:
            own = centroids[labels]
            turned = evaluate(own.algebra, "costs.agreement", self.x, own).value._data[..., 0] < 0
            factors = np.where(turned, -factors, factors)
        sums = _sums(self._columns, labels, factors, self.k)
        written = _sums(np.abs(self._columns), labels, np.abs(factors), self.k)
        layout = self.x.algebra.type_of(self.x.kind.layout, np.dtype(np.float64))
        total, size = (self.x._make(layout, s, (self.k,)) for s in (sums, written))
        projected = embed(evaluate(self.x.algebra, "blades.project_sum", total, size).value, self.x.kind)
        found = np.isfinite(projected).all(-1)
        new = np.where(found[:, None], projected, centroids._data).astype(data.dtype)
        changed = self._costs_to_assigned(self._centroids(new), labels)
        worse = self._of_clusters(changed, labels) > self._of_clusters(cost, labels)
        new[worse] = centroids._data[worse]
        self._reseed(new, labels, cost)
        return self._centroids(new)

    def _centroids(self, data: NDArray[Any]) -> Multivector:
        return self.x._make(self.x._type, data, (self.k,))

    def _costs_to_assigned(self, centroids: Multivector, labels: Labels) -> Costs:
        """Cost of each object to the centroid of its cluster; infinite where no rotor is unique."""
        cost = evaluate(self.x.algebra, self.formula, self.x, centroids[labels]).value._data[..., 0].astype(np.float64)
        return np.where(np.isnan(cost), np.inf, cost)

    def _of_clusters(self, cost: Costs, labels: Labels) -> Costs:
        """Total cost of each cluster."""
        return np.asarray(np.bincount(labels, self._weigh(cost), self.k), np.float64)

    def _reseed(self, new: NDArray[Any], labels: Labels, cost: Costs) -> None:
        """Each empty cluster takes one of the objects that cost most, unless that costs nothing."""
        mass = cost if self.weights is None else np.where(self.weights > 0, cost, 0)
        empty = np.flatnonzero(np.bincount(labels, minlength=self.k) == 0)
        if len(empty):
            farthest = np.argsort(-mass, kind="stable")[: len(empty)]
            usable = mass[farthest] > 0
            new[empty[usable]] = self.x._data[farthest[usable]]


def _sums(columns: NDArray[Any], labels: Labels, factors: NDArray[Any], k: int) -> NDArray[np.float64]:
    """Sums of numbers (m, n) times factors (n,), by label: (k, m)."""
    return np.stack([np.bincount(labels, factors * column, k) for column in columns], -1)


def _draw_indices(mass: NDArray[Any], count: int, random: np.random.Generator) -> Labels:
    """Indices drawn with these masses."""
    total = np.cumsum(mass)
    found = np.searchsorted(total, random.random(count) * total[-1], side="right")
    return np.asarray(np.minimum(found, np.flatnonzero(mass)[-1]), np.int64)
