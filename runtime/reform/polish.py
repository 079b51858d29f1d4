"""The motor of least positive cost over given matches, how well it is known, and which motions are left free."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .engine import Driver, Scene

Array = NDArray[Any]
#: Gauss-Newton steps at most; a step that changes the twist by less ends them.
STEPS, SETTLED = 30, 1e-14
#: Halvings of a step at most; what rounding may add to a cost, relative to it, and squared absolutely.
HALVINGS, SLACK = 8, 1e-14
#: A motion is free if the matches resist it less than this, relative to the most.
FREE = 1e-9
#: Of each kind: rows of the query, and of the reference.
Matches = Mapping[str, tuple[Array, Array]]


@dataclass(frozen=True)
class Rates:
    """Costs of matches (n,), their gradients (n, 6) and Gauss-Newton matrices (n, 6, 6) by the twist b in exp(b) R."""

    costs: Array
    gradients: Array
    matrices: Array


@dataclass(frozen=True)
class Polished:
    """The least cost.

    Attributes
    ----------
    motor : array (8,)
        In the frames of the models.
    rates : Rates
        There.
    free : array (m, 6)
        Twists, in the reference's frame, of motions that the matches do not resist.
    steps : int
    """

    motor: Array
    rates: Rates
    free: Array
    steps: int

    @property
    def cost(self) -> float:
        """Sum over the matches."""
        return float(self.rates.costs.sum())


def rates(scene: Scene, motor: Array, matches: Matches) -> Rates:
    """Of all matches; of one without a rotor zeros."""
    found = np.concatenate([scene.rates(kind, motor, *pairs) for kind, pairs in matches.items()])
    found[~np.isfinite(found).all(-1)] = 0.0
    return Rates(found[:, 0], found[:, 1:7], _full(found[:, 7:]))


def _full(upper: Array) -> Array:
    """Symmetric 6 x 6 matrices from their upper halves, row by row."""
    found = np.empty((len(upper), 6, 6))
    rows, columns = np.triu_indices(6)
    found[:, rows, columns] = found[:, columns, rows] = upper
    return found


def polish(scene: Scene, driver: Driver, motor: Array, matches: Matches, steps: int = STEPS) -> Polished:
    """Gauss-Newton on the positive cost, which is a sum of squares; a step that makes it worse is halved."""
    here = rates(scene, motor, matches)
    taken = 0
    while taken < steps:
        taken += 1
        step = -_inverse(here.matrices.sum(0))[0] @ here.gradients.sum(0)
        best = here.costs.sum()
        for _ in range(HALVINGS):
            trial = driver.step(motor, step)
            there = rates(scene, trial, matches)
            if there.costs.sum() <= best * (1 + SLACK) + SLACK * SLACK:
                break
            step = step / 2
        else:
            break
        motor, here = trial, there
        if float(np.abs(step).max()) < SETTLED:
            break
    return Polished(motor, here, _inverse(here.matrices.sum(0))[1], taken)


def _inverse(matrix: Array) -> tuple[Array, Array]:
    """Inverse of a symmetric positive matrix, and the unit vectors (m, 6) of what it leaves free, where it is none."""
    values, vectors = np.linalg.eigh(matrix)
    stiff = values > FREE * max(float(values[-1]), 0.0)
    inverse = (vectors[:, stiff] / values[stiff]) @ vectors[:, stiff].T
    return inverse, vectors[:, ~stiff].T


def covariance(found: Polished) -> Array:
    """Of the twist b in exp(b) R, (6, 6), from how the matches disagree, with nothing assumed of their errors.

    The sandwich estimate with each match's own influence taken out (HC3): it holds for unequal and for few matches.
    """
    bread, _ = _inverse(found.rates.matrices.sum(0))
    influence = np.eye(6) - found.rates.matrices @ bread
    left_out = np.linalg.pinv(influence) @ found.rates.gradients[..., None]
    meat = left_out[..., 0].T @ left_out[..., 0]
    result: Array = bread @ meat @ bread
    return result
