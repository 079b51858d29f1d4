"""Refinement of a pose: the motor of least cost over given matches, and its covariance."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.algorithms.registration_layout import MOTOR, RATES, TWIST
from ...codegen.programs.registration.pose import COST_SLACK, FREE, MAX_HALVINGS, MIN_STEP, MODE_REUSE_STEP
from ...codegen.programs.registration.registration import KINDS
from ..backends.driver import Driver
from ..backends.model_rows import ModelData
from ..backends.scene import Matches, Scene
from .confidence import hotelling_inflation

Array = NDArray[Any]
#: Largest number of Gauss-Newton steps.
MAX_STEPS = 30
#: Matches up to which all steps are one compiled call, a single thread's; more are shared over threads at each step.
MANY_MATCHES = 4096
#: Effective matches from which on their gradients alone, one of each, estimate a covariance.
FEW_MATCHES = 9.0
#: Residuals of a match that the pose does not take up, at the least.
MIN_FREE_RESIDUALS = 0.25


@dataclass(frozen=True)
class Rates:
    """Costs of matches (n,), their gradients (n, 6) and Gauss-Newton matrices by the twist b in exp(b) R, as upper
    halves (n, 21), row by row.
    """

    costs: Array
    gradients: Array
    halves: Array

    @property
    def matrices(self) -> Array:
        """(n, 6, 6)."""
        return full(self.halves)

    @cached_property
    def normal_matrix(self) -> Array:
        """Sum of the matrices (6, 6)."""
        return full(self.halves.sum(0))

    @cached_property
    def modes(self) -> tuple[Array, Array]:
        """Eigenvalues (6,) of the normal matrix, ascending, and eigenvectors in columns."""
        return eigenmodes(self.normal_matrix)


@dataclass(frozen=True)
class RefinedPose:
    """Pose of least cost.

    Attributes
    ----------
    motor : array (8,)
        Motor in the frames of the models.
    rates : Rates
        Derivatives of the costs at this motor.
    steps : int
    """

    motor: Array
    rates: Rates
    steps: int

    @property
    def cost(self) -> float:
        """Sum of the costs of the matches."""
        return float(self.rates.costs.sum())


def rates(scene: Scene, motor: Array, matches: Matches) -> Rates:
    """Costs and derivatives of all matches; zeros for a match without a rotor."""
    return rates_of([scene.rates(kind, motor, *pairs) for kind, pairs in matches.items()])


def rates_of(parts: list[Array]) -> Rates:
    """Rates of rows (n, 28) of several kinds; zeros for rows that are not finite."""
    values = parts[0] if len(parts) == 1 else np.concatenate([np.empty((0, RATES)), *parts])
    finite = np.isfinite(values)
    if not finite.all():
        values[~finite.all(-1)] = 0.0
    return Rates(values[:, 0], values[:, 1:7], values[:, 7:])


def eigenmodes(matrix: Array) -> tuple[Array, Array]:
    """Eigenvalues, ascending, and eigenvectors, in columns, of a symmetric matrix."""
    values, vectors = np.linalg.eigh(matrix)
    return values, vectors


def normal_matrix(side: ModelData) -> Array:
    """Normal matrix (6, 6) of a model's objects, matched with themselves, by a twist."""
    rows_by_kind = {kind: np.arange(len(rows), dtype=np.int32) for kind, rows in side.rows.items()}
    kinds = np.repeat([KINDS.index(kind) for kind in rows_by_kind], [len(x) for x in rows_by_kind.values()])
    scene = Scene(side, side, kinds, np.concatenate(list(rows_by_kind.values())))
    derivatives = rates(scene, np.eye(MOTOR)[0], {kind: (x, x) for kind, x in rows_by_kind.items()})
    return derivatives.normal_matrix


def _half_indices() -> Array:
    """Indices of the entries of a symmetric matrix in its upper half."""
    indices = np.zeros((TWIST, TWIST), np.int64)
    indices[np.triu_indices(TWIST)] = np.arange(TWIST * (TWIST + 1) // 2)
    return np.maximum(indices, indices.T)


_HALF_INDICES = _half_indices()


def full(halves: Array) -> Array:
    """Symmetric matrices (.., 6, 6) from their upper halves (.., 21), row by row."""
    return halves.take(_HALF_INDICES, -1)


def refine_pose(
    scene: Scene, driver: Driver, motor: Array, matches: Matches, steps: int = MAX_STEPS, weights: Array | None = None
) -> RefinedPose:
    """The motor of least positive cost over matches, which may have weights (n,), near another one."""
    if sum(len(rows) for rows, _ in matches.values()) <= MANY_MATCHES:
        motor, found, taken = scene.descend(motor, matches, weights, steps)
        return RefinedPose(motor, Rates(found[:, 0], found[:, 1:7], found[:, 7:]), taken)

    def rates_at(motor: Array) -> Rates:
        found = [scene.rates(kind, motor, *pairs) for kind, pairs in matches.items()]
        return rates_of([weighted(np.concatenate(found), weights)])

    return descend(rates_at, driver, motor, steps)


def weighted(rows: Array, weights: Array | None) -> Array:
    """Rates of matches that count more or less; none of those that do not count."""
    return rows if weights is None else np.where(weights[:, None] > 0, weights[:, None] * rows, 0.0)


def descend(rates_at: Callable[[Array], Rates], driver: Driver, motor: Array, steps: int = MAX_STEPS) -> RefinedPose:
    """Gauss-Newton on a cost that is a sum of squares, or nearly; a step that makes it worse is halved."""
    derivatives = rates_at(motor)
    n_steps, size, modes = 0, math.inf, None
    while n_steps < steps:
        n_steps += 1
        modes = derivatives.modes if modes is None or size > MODE_REUSE_STEP else modes
        step = -_pseudo_solve(modes, derivatives.gradients.sum(0))
        cost = derivatives.costs.sum()
        for _ in range(MAX_HALVINGS):
            trial = driver.step(motor, step)
            trial_derivatives = rates_at(trial)
            if trial_derivatives.costs.sum() <= cost * (1 + COST_SLACK) + COST_SLACK * COST_SLACK:
                break
            step = step / 2
        else:
            break
        motor, derivatives = trial, trial_derivatives
        size = float(np.abs(step).max())
        if size < MIN_STEP:
            break
    return RefinedPose(motor, derivatives, n_steps)


def _pseudo_solve(modes: tuple[Array, Array], vector: Array) -> Array:
    """Minimum-norm solution for a symmetric positive matrix, given by its eigenmodes; zero along free motions."""
    values, vectors = modes
    constrained = values > FREE * max(float(values[-1]), 0.0)
    return np.asarray(
        vectors @ (np.divide(1, values, out=np.zeros_like(values), where=constrained) * (vector @ vectors))
    )


def covariance(pose: RefinedPose, driver: Driver) -> tuple[Array, float]:
    """Covariance (6, 6) of the twist b in exp(b) R, and its inflation for the size of the sample.

    Their product C is such that b' C^-1 b < 12.59 holds for the true pose with probability 0.95.

    It is estimated from the residuals of the matches, whose errors may differ in size, but are assumed independent
    and without bias: the sandwich B (sum g g') B of influences g and the inverse B of the matrix, where each match's
    influence on its own residual is removed (HC2 of MacKinnon and White). Hotelling's factor corrects for the size of
    the sample: m matches with equal information about all six motions. The m of unequal matches gives quadratic forms
    of the estimate the variance that they would have for m equal ones (Satterthwaite). The factor is 2.1 for 20 lines
    and 1.06 for many; without it the region of 20 lines holds 73 % of the true poses, that of 10 lines 40 %. Fewer than
    about 8 such matches estimate their errors badly, and their gradients need not span all motions: of many matches,
    too, if few carry the cost, as small circles do. What is known of each match by its own residuals is added then, and
    the region is correct, but very large. Zero for exact matches.
    """
    values, vectors = pose.rates.modes
    constrained = values > FREE * max(float(values[-1]), 0.0)
    if not constrained.any():
        return np.zeros((6, 6)), 1.0
    whiten = np.zeros((TWIST, TWIST))
    whiten[:, constrained] = vectors[:, constrained] / np.sqrt(values[constrained])
    rows = np.column_stack([pose.rates.costs, pose.rates.gradients, pose.rates.halves])
    factor, traces, squares = driver.influences(rows, whiten)  # informations sum to identity
    motions = int(constrained.sum())
    sample = effective_sample_size(motions, traces, squares)
    spread = factor.T @ factor
    if sample < FEW_MATCHES:
        spread = spread + _own_spread(pose.rates, whiten, traces)
    return spread, hotelling_inflation(sample)


def _own_spread(rates: Rates, whiten: Array, traces: Array) -> Array:
    """Covariance (6, 6) by the size of each match's own error, as if it were the same in all of its residuals.

    The variance of a match is its cost over the number of its residuals, less the part of them that the pose takes up.
    """
    counts = np.linalg.matrix_rank(rates.matrices, hermitian=True)
    variances = rates.costs / np.maximum(counts - traces, MIN_FREE_RESIDUALS)
    inverse = whiten @ whiten.T
    return np.asarray(inverse @ np.tensordot(variances, rates.matrices, 1) @ inverse)


def effective_sample_size(p: int, traces: Array, squares: Array) -> float:
    """Number of equal matches that would estimate a covariance of p motions as well, by the traces (n,) of informations
    (p, p), which sum to identity, and the sums of their squares."""
    return float(p * (p + 2) / (traces * traces + 2 * squares).sum())
