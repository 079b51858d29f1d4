"""Spheres and circles at the least sum of squared distances: unknowns under conditions, and damped steps for many sets.

Distances and their derivatives are `codegen.formulas.objects.fits`; here is how to descend with them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.multivector import Algebra
from ...dispatch.formulas import evaluate
from .algebraic import EPS, metric, normalize_vectors, positions, products, vectors

Array = NDArray[np.float64]
#: Gauss-Newton steps, of which ordinary sets take 3 to 10; sets whose distances stay large go on with Newton's, and
#: count as not converged after the most.
GAUSS_STEPS, MOST_STEPS = 12, 60
#: Step of the differences that Newton's matrix is taken by: the root of the rounding unit.
DIFFERENCE = 2.0**-26
#: A set is done when a step changes its unit unknowns by less.
SMALL_STEP = 64 * EPS
#: Damping relative to the mean curvature of the cost: at first, by which factor it changes, and the least and the most.
DAMPING, FACTOR, LEAST_DAMPING, MOST_DAMPING = 1e-4, 8.0, 1e-13, 1e12


class SphereModel:
    """A unit dual sphere s: five unknowns under one condition."""

    def __init__(self, algebra: Algebra) -> None:
        self.algebra = algebra

    def residuals(self, unknowns: Array, xyz: Array) -> tuple[Array, Array]:
        """Distances (k, n, 1) and their derivatives (k, n, 1, 5)."""
        s = vectors(self.algebra, unknowns[:, None])
        outcome = evaluate(self.algebra, "fits.sphere_distance", s, positions(self.algebra, xyz))
        distance, gradient = outcome.values
        return distance, gradient[..., None, :]

    def conditions(self, unknowns: Array) -> Array:
        """Derivatives of s^2, as columns (k, 5, 1)."""
        return (unknowns @ metric(self.algebra))[..., None]

    def project(self, unknowns: Array) -> Array:
        """Unknowns that hold the conditions."""
        return normalize_vectors(self.algebra, unknowns)


class CircleModel:
    """A unit dual sphere s about a point of the unit dual plane p: ten unknowns under four conditions."""

    def __init__(self, algebra: Algebra) -> None:
        self.algebra = algebra
        self.infinity = np.zeros(5)
        self.infinity[-1] = 1.0  # n_inf, the last of e1 e2 e3 no ni

    def residuals(self, unknowns: Array, xyz: Array) -> tuple[Array, Array]:
        """Heights and distances in the plane (k, n, 2) and their derivatives (k, n, 2, 10)."""
        s, p = (vectors(self.algebra, part[:, None]) for part in (unknowns[:, :5], unknowns[:, 5:]))
        outcome = evaluate(self.algebra, "fits.circle_distances", s, p, positions(self.algebra, xyz))
        distances, gradient = outcome.values
        by = np.zeros((*distances.shape, 10))
        by[..., 0, 5:] = gradient[..., :5]
        by[..., 1, :] = gradient[..., 5:]
        return distances, by

    def conditions(self, unknowns: Array) -> Array:
        """Derivatives of s^2, p^2, s . p and p . n_inf, as columns (k, 10, 4)."""
        lowered = unknowns.reshape(-1, 2, 5) @ metric(self.algebra)
        found = np.zeros((len(unknowns), 10, 4))
        found[:, :5, 0] = found[:, 5:, 2] = lowered[:, 0]
        found[:, 5:, 1] = found[:, :5, 2] = lowered[:, 1]
        found[:, 5:, 3] = self.infinity @ metric(self.algebra)
        return found

    def project(self, unknowns: Array) -> Array:
        """Unknowns that hold the conditions."""
        s, p = unknowns[:, :5], unknowns[:, 5:].copy()
        lowered = self.infinity @ metric(self.algebra)
        p -= (p @ lowered / (lowered @ lowered))[:, None] * lowered
        p = normalize_vectors(self.algebra, p)
        s = normalize_vectors(self.algebra, s - products(self.algebra, s, p)[:, None] * p)
        return np.concatenate([s, p], -1)


# -- steps -------------------------------------------------------------------------------------------------


def refine(
    model: SphereModel | CircleModel, start: Array, xyz: Array, weight: Array
) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Unknowns at the nearest minimum of the sum of weighted squared distances, its value, and whether they converged.

    Levenberg's method on the tangent space of the conditions, all sets at once; a set that is done leaves.
    """
    unknowns = start.copy()
    here = _linear(model, start, xyz, weight)
    done = ~np.isfinite(here.value)
    converged = np.zeros(len(start), bool)
    damping = np.full(len(start), DAMPING)
    for count in range(MOST_STEPS):
        live = np.flatnonzero(~done)
        if not len(live):
            break
        now = here.take(live)
        matrix = now.curvature if count < GAUSS_STEPS else _newton(model, unknowns[live], now, xyz[live], weight[live])
        step = _step(matrix, now, damping[live])
        trial = model.project(unknowns[live] + step)
        there = _linear(model, trial, xyz[live], weight[live])
        better = there.value <= now.value * (1 + 8 * EPS) + EPS * EPS
        unknowns[live[better]] = trial[better]
        here.replace(live[better], there.take(better))
        damping[live] = np.where(better, np.maximum(damping[live] / FACTOR, LEAST_DAMPING), damping[live] * FACTOR)
        small = np.abs(step).max(-1) <= SMALL_STEP * np.maximum(1.0, np.abs(unknowns[live]).max(-1))
        converged[live] = small
        done[live] = small | (damping[live] > MOST_DAMPING)
    return unknowns, here.value, converged


@dataclass
class _Linear:
    """The cost, its slope and Gauss-Newton curvature in tangent directions, these directions as columns, and the
    slope in all unknowns."""

    value: Array
    slope: Array
    curvature: Array
    basis: Array
    full_slope: Array

    def take(self, indices: Any) -> _Linear:
        """Subset by index."""
        return _Linear(*(part[indices] for part in vars(self).values()))

    def replace(self, indices: Any, other: _Linear) -> None:
        """Put others in the place of some sets."""
        for part, new in zip(vars(self).values(), vars(other).values(), strict=True):
            part[indices] = new


def _linear(model: SphereModel | CircleModel, unknowns: Array, xyz: Array, weight: Array) -> _Linear:
    finite = np.asarray(np.isfinite(unknowns).all(-1))
    safe = np.where(finite[:, None], unknowns, 1.0)
    with np.errstate(all="ignore"):
        rows, right = _weighted_rows(model, safe, xyz, weight)
        conditions = model.conditions(safe)
        frame, _ = np.linalg.qr(conditions, mode="complete")
        basis = frame[..., conditions.shape[-1] :]
        inner = rows @ basis
        value = np.where(finite, (right * right).sum(-1), np.inf)
        full_slope = (np.swapaxes(rows, -1, -2) @ right[..., None])[..., 0]
        slope = (np.swapaxes(inner, -1, -2) @ right[..., None])[..., 0]
        return _Linear(value, slope, np.swapaxes(inner, -1, -2) @ inner, basis, full_slope)


def _weighted_rows(model: SphereModel | CircleModel, unknowns: Array, xyz: Array, weight: Array) -> tuple[Array, Array]:
    """Rows of derivatives and distances, with their weights."""
    distance, derivative = model.residuals(unknowns, xyz)
    k, size = unknowns.shape
    rows = (derivative * weight[..., None, None]).reshape(k, -1, size)
    return rows, (distance * weight[..., None]).reshape(k, -1)


def _step(matrix: Array, now: _Linear, damping: Array) -> Array:
    """-matrix^-1 slope with damping; directions of negative curvature are descended too."""
    size = matrix.shape[-1]
    values, modes = np.linalg.eigh(matrix)
    level = np.trace(now.curvature, axis1=-2, axis2=-1) / size
    level = np.where(level > 0, level, 1.0)
    values = np.abs(values) + (damping * level)[:, None]
    inner = (np.swapaxes(modes, -1, -2) @ now.slope[..., None])[..., 0] / values
    return np.asarray(-(now.basis @ (modes @ inner[..., None]))[..., 0])


def _newton(model: SphereModel | CircleModel, unknowns: Array, now: _Linear, xyz: Array, weight: Array) -> Array:
    """The curvature of the cost along the conditions: differences of its slope less theirs (Lagrange's multipliers)."""
    k, size, q = now.basis.shape
    conditions = model.conditions(unknowns)
    factors = np.linalg.pinv(conditions) @ now.full_slope[..., None]
    moved = unknowns[:, None] + DIFFERENCE * np.swapaxes(now.basis, -1, -2)
    flat = moved.reshape(k * q, size)
    rows, right = _weighted_rows(model, flat, np.repeat(xyz, q, 0), np.repeat(weight, q, 0))
    slopes = (np.swapaxes(rows, -1, -2) @ right[..., None])[..., 0]
    slopes -= (model.conditions(flat) @ np.repeat(factors, q, 0))[..., 0]
    first = now.full_slope - (conditions @ factors)[..., 0]
    change = (slopes.reshape(k, q, size) - first[:, None]) / DIFFERENCE
    matrix = change @ now.basis
    return np.asarray((matrix + np.swapaxes(matrix, -1, -2)) / 2)


__all__ = ["CircleModel", "SphereModel", "refine"]
