"""The motor of least positive cost over given matches, how well it is known, and which motions are left free."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.programs.reform import KINDS
from .engine import Driver, Scene
from .fisher import widening
from .freedom import FREE
from .sides import Side
from .stages import MOTOR, RATES, TWIST

Array = NDArray[Any]
#: Gauss-Newton steps at most; a step that changes the twist by less ends them.
STEPS, SETTLED = 30, 1e-14
#: After a smaller step the modes of the matrix stay what they were: the next step is as good to so many parts.
SAME_MODES = 1e-6
#: Halvings of a step at most; what rounding may add to a cost, relative to it, and squared absolutely.
HALVINGS, SLACK = 8, 1e-14
#: What a match leaves of its own residual counts as no less: it alone tells a motion.
ALONE = 1e-3
#: Of each kind: rows of the query, and of the reference.
Matches = Mapping[str, tuple[Array, Array]]


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
    def stiffness(self) -> Array:
        """Sum of the matrices (6, 6)."""
        return full(self.halves.sum(0))

    @cached_property
    def modes(self) -> tuple[Array, Array]:
        """Eigenvalues (6,) of that, rising, and eigenvectors in columns."""
        return modes_of(self.stiffness)


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
    found = parts[0] if len(parts) == 1 else np.concatenate([np.empty((0, RATES)), *parts])
    good = np.isfinite(found)
    if not good.all():
        found[~good.all(-1)] = 0.0
    return Rates(found[:, 0], found[:, 1:7], found[:, 7:])


def modes_of(matrix: Array) -> tuple[Array, Array]:
    """Eigenvalues, rising, and eigenvectors, in columns, of a symmetric matrix."""
    values, vectors = np.linalg.eigh(matrix)
    return values, vectors


def stiffness(side: Side) -> Array:
    """The matrix (6, 6) of how objects resist twists: that of the cost of all of them against themselves."""
    places = {kind: np.arange(len(rows), dtype=np.int32) for kind, rows in side.rows.items()}
    kinds = np.repeat([KINDS.index(kind) for kind in places], [len(x) for x in places.values()])
    scene = Scene(side, side, kinds, np.concatenate(list(places.values())))
    found = rates(scene, np.eye(MOTOR)[0], {kind: (x, x) for kind, x in places.items()})
    return found.stiffness


def _places() -> Array:
    """Where the entries of a symmetric matrix stand in its upper half."""
    places = np.zeros((TWIST, TWIST), np.int64)
    places[np.triu_indices(TWIST)] = np.arange(TWIST * (TWIST + 1) // 2)
    return np.maximum(places, places.T)


_PLACES = _places()


def full(halves: Array) -> Array:
    """Symmetric matrices (.., 6, 6) from their upper halves (.., 21), row by row."""
    return halves.take(_PLACES, -1)


def polish(scene: Scene, driver: Driver, motor: Array, matches: Matches, steps: int = STEPS) -> Polished:
    """Gauss-Newton on the positive cost, which is a sum of squares; a step that makes it worse is halved."""
    here = rates(scene, motor, matches)
    taken, size, modes = 0, math.inf, None
    while taken < steps:
        taken += 1
        modes = here.modes if modes is None or size > SAME_MODES else modes
        step = -_solved(modes, here.gradients.sum(0))
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
        size = float(np.abs(step).max())
        if size < SETTLED:
            break
    return Polished(motor, here, taken)


def _solved(modes: tuple[Array, Array], vector: Array) -> Array:
    """What a symmetric positive matrix, given by its modes, takes to a vector; zero along what it leaves free."""
    values, vectors = modes
    stiff = values > FREE * max(float(values[-1]), 0.0)
    return np.asarray(vectors @ (np.divide(1, values, out=np.zeros_like(values), where=stiff) * (vector @ vectors)))


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
    values, vectors = found.rates.modes
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
    traces, squares = np.einsum("nii->n", shares), np.einsum("nij,nij->n", shares, shares)
    return float(p * (p + 2) / (traces * traces + 2 * squares).sum())
