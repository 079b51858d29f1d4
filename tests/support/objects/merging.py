"""Objects to merge, and merging as a loop over all pairs."""

from __future__ import annotations

import numpy as np

import bladesmith as bs
from bladesmith import cga3d as cga
from bladesmith.codegen import algorithm
from bladesmith.codegen.algorithms import merging_bounds
from bladesmith.codegen.algorithms.merging_layout import SLACK
from bladesmith.codegen.formulas.objects import costs
from bladesmith.codegen.programs.merging.kinds import KINDS as KERNELS
from bladesmith.objects.clustering.agglomerative_driver import Greedy

from ..formulas import Traced, stock

KINDS = tuple(KERNELS)


def objects(kind, centers, axes, radii):
    """One object of a kind for each row of parameters."""
    if kind == "point":
        return cga.point(centers)
    if kind == "point_pair":
        half = axes * (radii / np.linalg.norm(axes, axis=1))[:, None]
        return cga.point_pair(centers - half, centers + half)
    if kind == "line":
        return cga.line(centers, axes)
    if kind == "circle":
        return cga.circle(centers, axes, radii)
    if kind == "plane":
        return cga.plane(axes, np.einsum("ij,ij->i", axes, centers))
    return cga.sphere(centers, radii)


def clustered(kind, clusters, each, seed, noise=0.01, scale=1.0):
    """``each`` noisy copies of some random objects, shuffled and turned at random, and whose copies they are."""
    rng = np.random.default_rng(seed)
    label = rng.permutation(np.repeat(np.arange(clusters), each))
    n = len(label)
    axes = rng.normal(size=(clusters, 3))
    axes /= np.linalg.norm(axes, axis=1)[:, None]
    turned = rng.choice([-1.0, 1.0], n)[:, None] if kind != "point_pair" else np.ones((n, 1))
    made = objects(
        kind,
        (scale * rng.normal(size=(clusters, 3)))[label] + noise * rng.normal(size=(n, 3)),
        turned * (axes[label] + noise * rng.normal(size=(n, 3))),
        rng.uniform(0.5, 2.0, clusters)[label] * np.exp(noise * rng.normal(size=n)),
    )
    return made, label


def mixed(kind, n, seed, scale=1.0):
    """Some pairs that are near each other among many that are not."""
    return clustered(kind, n // 3, 3, seed, noise=0.15, scale=scale)[0]


def cost_of(formula, kind, rows, others):
    """The formula itself on NumPy: no compiled code."""
    with np.errstate(all="ignore"):
        return Traced(stock("cga3d"), formula, kind, kind)(rows, others)


def table_of(formula, x):
    """Costs of all pairs, (n, n)."""
    i, j = np.indices((len(x), len(x))).reshape(2, -1)
    return cost_of(formula, x.kind.name, x.values[i], x.values[j]).reshape(len(x), len(x))


def all_pairs(x, threshold, align, weights=None):
    """The least of all costs, again and again: costs, pairs and means."""
    formula = costs.aligned_cost if align else costs.pair_cost

    def known(cost):
        return np.where(np.isnan(cost), np.inf, cost)

    rows = x.values.copy()
    weight = np.ones(len(x)) if weights is None else np.array(weights, float)
    alive = np.ones(len(x), bool)
    table = known(table_of(formula, x))
    spent, pairs = [], []
    while True:
        left = np.triu(np.outer(alive, alive), 1)
        a, b = np.unravel_index(np.argmin(np.where(left, table, np.inf)), table.shape)
        if not left[a, b] or table[a, b] > threshold:
            break
        spent.append(table[a, b])
        pairs.append((a, b))
        made = mean(x._make(x._type, rows[[a, b]], (2,)), weight[[a, b]], align)
        rows[a], alive[b] = made.values, False
        weight[a] += weight[b]
        table[a] = table[:, a] = known(cost_of(formula, x.kind.name, np.tile(made.values, (len(rows), 1)), rows))
    return np.array(spent), np.array(pairs).reshape(-1, 2), rows[alive]


def mean(pair, weight, align):
    """u x + v y on the blade manifold, y turned like x."""
    if pair.kind.name == "point":
        return cga.point(weight @ pair.parameters().xyz / weight.sum())
    x, y = pair
    sign = np.sign(float((x * y)["1"]) * float((x * x)["1"])) if align else 1.0
    return bs.objects.project_to_blade(weight[0] * x + weight[1] * sign * y).as_kind(x.kind)


least_cost = algorithm(merging_bounds.least_cost.function)


def bounds_of(kind, x):
    """Least costs that landmarks leave possible, of all pairs, (n, n)."""
    state = Greedy(kind, x.values, np.ones(len(x)), 1.0, True)._state
    marks = state["landmarks"]
    return least_cost(marks[:, None], marks[None], marks[None], state["limits"][SLACK])
