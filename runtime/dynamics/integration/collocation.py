"""Coefficients of Radau IIA collocation: exact for polynomials, at the roots of Legendre's P_s - P_(s-1).

Hairer and Wanner, Solving Ordinary Differential Equations II, IV.5 and IV.8.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from ...codegen.algorithms.dynamics.steps.collocated import MORE_ROWS

Array = NDArray[np.float64]
#: Errors of a step from which on methods of 3 and of 5 stages are taken; below them 7.
FEW_STAGES, MORE_STAGES = 1e-4, 1e-6


@dataclass(frozen=True, eq=False)
class Collocation:
    """A Radau IIA method.

    Attributes
    ----------
    c : array (s,)
        Times of the stages, the last one 1.
    inverse : array (s, s)
        That of its matrix.
    triangle : array (s, s)
        The inverse of the lower one of its matrix's factors, with which stages are solved.
    estimate : array (s,)
        Weights of an error estimate on the stages.
    """

    c: Array
    inverse: Array
    triangle: Array
    estimate: Array

    dense_rows = 0

    @property
    def stages(self) -> int:
        """Stages of a step."""
        return len(self.c)

    @property
    def all_stages(self) -> int:
        """The same: the interpolant needs no others."""
        return len(self.c)

    @property
    def order(self) -> int:
        """That of the error estimate and one more: a step goes by the root of its error."""
        return len(self.c) + 1

    @property
    def kept_rows(self) -> int:
        """States that a simulation keeps."""
        return 3 * self.stages + MORE_ROWS

    @property
    def numbers(self) -> Array:
        """All of it in a row, as algorithms read it."""
        return np.concatenate([self.c, self.estimate, self.inverse.ravel(), self.triangle.ravel()])


def stages_of(rtol: float) -> int:
    """Number of stages that serves a tolerance with the least work."""
    return 3 if rtol >= FEW_STAGES else 5 if rtol >= MORE_STAGES else 7


@cache
def radau(stages: int) -> Collocation:
    """The method of an odd number of stages, of order 2 s - 1."""
    s = stages
    nodes = np.sort(legendre.legroots([0.0] * (s - 1) + [-1.0, 1.0]).real)
    for _ in range(3):  # roots of companion matrices have some roundings
        value = legendre.legval(nodes, [0.0] * (s - 1) + [-1.0, 1.0])
        nodes = nodes - value / legendre.legval(nodes, legendre.legder([0.0] * (s - 1) + [-1.0, 1.0]))
    nodes[-1] = 1.0
    values = np.stack([legendre.legval(nodes, np.eye(s)[j]) for j in range(s)], 1)
    integrals = np.stack([legendre.legval(nodes, legendre.legint(np.eye(s)[j], lbnd=-1)) / 2 for j in range(s)], 1)
    matrix = integrals @ np.linalg.inv(values)
    inverse = values @ np.linalg.inv(integrals)
    triangle = np.tril(np.linalg.inv(_lower_factor(matrix)))
    # a quadrature that has the rates at the start too, so that its error is solved with the system of the first stage
    ends = np.array([(-1.0) ** j for j in range(s)]) / triangle[0, 0]  # Legendre's polynomials at the start
    weights = np.linalg.solve(values.T, -ends)
    return Collocation((nodes + 1) / 2, inverse, triangle, weights @ inverse)


def _lower_factor(a: Array) -> Array:
    """The lower one of Crout's factors, of which the upper one has ones on its diagonal."""
    lower, upper = np.zeros_like(a), np.eye(len(a))
    for j in range(len(a)):
        lower[j:, j] = a[j:, j] - lower[j:, :j] @ upper[:j, j]
        upper[j, j + 1 :] = (a[j, j + 1 :] - lower[j, :j] @ upper[:j, j + 1 :]) / lower[j, j]
    return lower
