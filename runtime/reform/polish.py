"""The motor of least positive cost over given matches, how well it is known, and which motions are left free."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.programs.reform import KINDS
from .engine import Driver, Scene
from .fisher import widening
from .freedom import FREE
from .sides import Side
from .stages import MOTOR, RATES

Array = NDArray[Any]
#: Gauss-Newton steps at most; a step that changes the twist by less ends them.
STEPS, SETTLED = 30, 1e-14
#: Halvings of a step at most; what rounding may add to a cost, relative to it, and squared absolutely.
HALVINGS, SLACK = 8, 1e-14
#: What a match leaves of its own residual counts as no less: it alone tells a motion.
ALONE = 1e-3
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
    steps : int
    """

    motor: Array
    rates: Rates
    steps: int

    @property
    def cost(self) -> float:
        """Sum over the matches."""
        return float(self.rates.costs.sum())


def rates(scene: Scene, motor: Array, matches: Matches) -> Rates:
    """Of all matches; of one without a rotor zeros."""
    parts = [scene.rates(kind, motor, *pairs) for kind, pairs in matches.items()]
    found = np.concatenate([np.empty((0, RATES)), *parts])
    found[~np.isfinite(found).all(-1)] = 0.0
    return Rates(found[:, 0], found[:, 1:7], _full(found[:, 7:]))


def stiffness(side: Side) -> Array:
    """The matrix (6, 6) of how objects resist twists: that of the cost of all of them against themselves."""
    places = {kind: np.arange(len(rows), dtype=np.int32) for kind, rows in side.rows.items()}
    kinds = np.repeat([KINDS.index(kind) for kind in places], [len(x) for x in places.values()])
    scene = Scene(side, side, kinds, np.concatenate(list(places.values())))
    found = rates(scene, np.eye(MOTOR)[0], {kind: (x, x) for kind, x in places.items()})
    return np.asarray(found.matrices.sum(0))


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
        step = -_inverse(here.matrices.sum(0)) @ here.gradients.sum(0)
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
    return Polished(motor, here, taken)


def _inverse(matrix: Array) -> Array:
    """Inverse of a symmetric positive matrix where it has one, zero for what it leaves free."""
    values, vectors = np.linalg.eigh(matrix)
    stiff = values > FREE * max(float(values[-1]), 0.0)
    return np.asarray((vectors[:, stiff] / values[stiff]) @ vectors[:, stiff].T)


def covariance(found: Polished) -> tuple[Array, float]:
    """Of the twist b in exp(b) R, (6, 6), and by how much it is to be widened for the size of the sample.

    The product C is such that b' C^-1 b < 12.59 holds for the true pose with probability 0.95.

    How the matches disagree tells it: nothing is assumed of the sizes of their errors, which may differ, but that
    those of different matches are independent, without a bias. It is the sandwich B (sum g g') B of influences g
    and the inverse B of the matrix, where each match's influence on its own residual is taken out (HC2 of MacKinnon
    and White), times Hotelling's factor for the size of the sample: m matches that say as much about all six motions.
    m is taken from how unevenly they say it, so that quadratic forms of the estimate have the variance that they
    would have for m such (Satterthwaite). The factor is 2.1 for 20 lines and 1.06 for many; without it the region of
    20 lines holds 73 % of the true poses, that of 10 lines 40 %. Fewer than about 8 matches tell their own errors
    badly: the region is honest, and very large. Zero for matches without any error.
    """
    total = found.rates.matrices.sum(0)
    values, vectors = np.linalg.eigh(total)
    stiff = values > FREE * max(float(values[-1]), 0.0)
    if not stiff.any():
        return np.zeros((6, 6)), 1.0
    whiten = vectors[:, stiff] / np.sqrt(values[stiff])
    shares = whiten.T @ found.rates.matrices @ whiten  # these add up to 1
    left, own = np.linalg.eigh(np.eye(int(stiff.sum())) - shares)
    influence = np.einsum("nji,nj->ni", own, found.rates.gradients @ whiten)
    influence /= np.sqrt(np.maximum(left, ALONE))
    spread = np.einsum("nji,ni->nj", own, influence)
    back = whiten @ spread.T
    return back @ back.T, widening(effective(shares))


def effective(shares: Array) -> float:
    """How many equal matches would tell a covariance as well as these, whose shares (n, p, p) add up to 1."""
    p = shares.shape[-1]
    traces, squares = np.trace(shares, axis1=1, axis2=2), (shares * shares).sum((1, 2))
    return float(p * (p + 2) / (traces * traces + 2 * squares).sum())
