"""What the refinement of a pose minimizes: costs of matches, their weights, and a robust loss.

Objects with covariances, and segments, have residuals in units of their standard deviations; those and all weights are
held while a pose is refined, and found again at the refined one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.algorithms.registration_layout import RESIDUALS, VECTORS
from ...codegen.errors import InputError
from ...codegen.programs.registration.registration import DIRECTED
from ..backends.driver import Driver
from ..backends.scene import Matches
from ..model.model import Model
from ..model.normalization import NormalizedModel
from ..model.parameters import rows_in_frame, transform_rows
from ..model.similarity import similarity
from ..model.uncertainty import Uncertainty
from .refinement import Rates, RefinedPose, descend, rates_of, refine_pose, weighted
from .residuals import CUT, Match, axes_of, linear_residuals, turned_rows, vectors, whitened

Array = NDArray[Any]
#: Weight of a squared distance in the cost of a match, as of the rotor between two points.
POSITION_WEIGHT = 0.75
#: Number of residuals of a match.
RESIDUAL_COUNTS = {"point": 3, "point_pair": 6, "line": 4, "segment": 4, "circle": 6, "plane": 3, "sphere": 4}
#: Residuals of a segment that are across the line; the others, one for each end, are along it.
ACROSS = 4
#: Smallest standard deviation, in units of the models' size: rounding.
MIN_DEVIATION = 1e-12


@dataclass(frozen=True)
class Loss:
    """A robust loss rho(z) of a mean square z over that of a standard deviation times ``factor``, and its derivative.

    The factor gives 95 % efficiency for normal errors.
    """

    factor: float
    value: Callable[[Array], Array]
    slope: Callable[[Array], Array]


#: Losses by the names of `scipy.optimize.least_squares`, which has no "tukey" (biweight). None: the squares themselves.
LOSSES: dict[str, Loss | None] = {
    "linear": None,
    "huber": Loss(1.345, lambda z: np.where(z <= 1, z, 2 * np.sqrt(z) - 1), lambda z: 1 / np.sqrt(np.maximum(z, 1))),
    "soft_l1": Loss(1.5, lambda z: 2 * (np.sqrt(1 + z) - 1), lambda z: 1 / np.sqrt(1 + z)),
    "cauchy": Loss(2.385, np.log1p, lambda z: 1 / (1 + z)),
    "tukey": Loss(4.685, lambda z: (1 - np.maximum(1 - z, 0) ** 3) / 3, lambda z: np.maximum(1 - z, 0) ** 2),
}


def check_uncertainties(query: Model, reference: Model) -> None:
    """Raise for weights of one model and covariances of the other.

    Raises
    ------
    InputError
    """
    if (query.weights and reference.covariances) or (query.covariances and reference.weights):
        raise InputError("one model has weights and the other covariances.",
                         remedy="Give both of one sort: weights are relative, covariances are not")  # fmt: skip
    for name, model in (("query", query), ("reference", reference)):
        if model.weights and not any(part.any() for part in model.weights.values()):
            raise InputError(f"the weights of the {name} are all zero: no object counts.")


@dataclass(frozen=True)
class WeightedSide:
    """A model in its frame, for residuals.

    Parameters
    ----------
    model : Model
    local : NormalizedModel
        The same in its frame, of the kinds that take part.
    """

    model: Model
    local: NormalizedModel

    @property
    def weights(self) -> Mapping[str, Array]:
        """Weights (n,) by kind; none for objects that are equally certain."""
        return self.model.weights or {}

    @cached_property
    def rows(self) -> Mapping[str, Array]:
        """Parameters (n, k) by kind."""
        center, unit = self.local.center, self.local.unit
        return {kind: rows_in_frame(self.model.parameters[kind], kind, center, unit) for kind in self.local.objects}

    @cached_property
    def covariances(self) -> Mapping[str, Array]:
        """Their covariances (n, k, k)."""
        if not self.model.covariances:
            return {}
        uncertainty = Uncertainty(covariances=self.model.covariances)
        return uncertainty.transformed(1 / self.local.unit, np.eye(3), -self.local.center / self.local.unit).covariances

    def variances(self, kind: str, rows: Array) -> Array | None:
        """Inverse weights of some objects: infinite for those that do not count, None for those of exact models."""
        if kind not in self.weights:
            return None
        with np.errstate(divide="ignore"):
            return np.asarray(1 / self.weights[kind][rows])


@dataclass(frozen=True)
class Part:
    """Matches of one kind: their rates (n, 28) at a motor, and weights (n,) or None."""

    kind: str
    rates_at: Callable[[Array], Array]
    weights: Array | None
    #: Whether they are the costs of rotors.
    is_plain: bool = False


class Objective:
    """The cost of matches and its rates.

    Parameters
    ----------
    scene
    query, reference : WeightedSide
    matches : mapping of kind to two arrays
        Rows of the query and of the reference.
    motor : Multivector
        Motor between the frames, near the one that is looked for: residuals and weights are held as they are there.
    loss : str
    align : bool
        True if x and -x are the same object.
    """

    def __init__(
        self, scene: Any, query: WeightedSide, reference: WeightedSide, matches: Matches, motor: Any, loss: str,
        align: bool,
    ) -> None:  # fmt: skip
        self._scene, self._query, self._reference, self._align = scene, query, reference, align
        self._is_absolute = bool(query.covariances or reference.covariances)
        self._motor = motor
        self._start = np.asarray(motor._data, np.float64)
        self._matches, self._parts = matches, [self._part(kind, *rows) for kind, rows in matches.items()]
        self._counts = np.concatenate(
            [np.empty(0), *(np.full(len(rows), RESIDUAL_COUNTS[k]) for k, (rows, _) in matches.items())]
        )
        self._loss, self._scale = LOSSES[loss], 1.0
        if self._loss is not None and len(self._counts):
            deviation = 1.0 if self._is_absolute else self._deviation()
            self._scale = max(self._loss.factor * deviation, MIN_DEVIATION) ** 2

    def __call__(self, motor: Array) -> Rates:
        """Costs of the matches, their gradients and Gauss-Newton matrices."""
        found = rates_of([weighted(part.rates_at(motor), part.weights) for part in self._parts])
        if self._loss is None or not len(self._counts):
            return found
        size = self._scale * self._counts
        z = found.costs / size
        slopes = self._loss.slope(z)[:, None]
        return Rates(size * self._loss.value(z), slopes * found.gradients, slopes * found.halves)

    def minimize(self, driver: Driver, motor: Array) -> RefinedPose:
        """The motor (8,) of least cost near another one."""
        if self._loss is not None or not all(part.is_plain for part in self._parts):
            return descend(self, driver, motor)
        weights = [part.weights for part in self._parts if part.weights is not None]  # of all parts, or of none
        known = np.concatenate(weights) if weights else None
        return refine_pose(self._scene, driver, motor, self._matches, weights=known)

    @cached_property
    def _displacement(self) -> tuple[Array, Array]:
        """Rotation (3, 3) and translation (3,) of the motor."""
        return similarity(self._motor)[1:]

    def _deviation(self) -> float:
        """Standard deviation of a residual, from the median of the costs of matches that count."""
        found = rates_of([weighted(part.rates_at(self._start), part.weights) for part in self._parts])
        counting = found.halves.any(1)
        return _deviation(found.costs[counting], self._counts[counting])

    def _part(self, kind: str, x: Array, y: Array) -> Part:
        query, reference = self._query, self._reference
        if self._is_absolute:
            first = query.covariances[kind][x] if query.covariances else None
            second = reference.covariances[kind][y] if reference.covariances else None
            return self._residuals(kind, x, y, first, second, None)
        variances = [query.variances(kind, x), reference.variances(kind, y)]
        known = [v for v in variances if v is not None]
        total = sum(known) if known else None
        weights = None if total is None else np.asarray(1 / total)
        if kind != "segment":
            return Part(kind, lambda motor: self._scene.rates(kind, motor, x, y), weights, is_plain=True)
        if total is None or weights is None:  # both ends of a whole segment as if they were two points
            each = np.full(len(x), 0.5 / POSITION_WEIGHT)
            return self._residuals(kind, x, y, each, each, None)
        counting = weights > 0
        first, second = (None if v is None else np.where(counting, v, 1.0) / POSITION_WEIGHT for v in variances)
        return self._residuals(kind, x, y, first, second, np.where(counting, 1.0, 0.0))

    def _residuals(
        self, kind: str, x: Array, y: Array, query: Array | None, reference: Array | None, weights: Array | None
    ) -> Part:  # fmt: skip
        """Residuals of parameters of some covariances (n, k, k), or variances (n,)."""
        rows, others = self._query.rows[kind][x], self._reference.rows[kind][y]
        moved = transform_rows(rows, kind, 1.0, *self._displacement)
        if self._align and kind in DIRECTED:
            turned = (axes_of(moved, kind) * axes_of(others, kind)).sum(1) < 0
            rows, moved = turned_rows(rows, kind, turned), turned_rows(moved, kind, turned)
            if query is not None and query.ndim > 1:
                turn = turned_rows(np.eye(rows.shape[1]), kind, np.ones(rows.shape[1], bool))
                query = np.where(turned[:, None, None], turn.T @ query @ turn, query)
        residuals = linear_residuals(kind, Match(rows, others, moved, self._displacement[0]))
        forms = whitened(residuals, query, reference, ACROSS if kind == "segment" else RESIDUALS)
        places, directed = vectors(rows, kind)
        if kind == "segment":
            values = (forms[..., :VECTORS] @ vectors(moved, kind)[0][..., None])[..., 0] - forms[..., VECTORS]
            forms[:, ACROSS:] *= _held_ends(values, self._is_absolute)[..., None]
        return Part(kind, lambda motor: self._scene.residual_rates(motor, places, directed, forms), weights)


def _deviation(squares: Array, counts: Array) -> float:
    """Standard deviation of residuals from the median of sums of their squares, so many each.

    The median of chi^2 is that of Wilson and Hilferty.
    """
    return math.sqrt(float(np.median(squares / (counts * (1 - 2 / (9 * counts)) ** 3)))) if len(squares) else 0.0


def _held_ends(values: Array, are_deviations: bool) -> Array:
    """Factors (n, 2) of residuals along the line: near 0 for an end that was cut off, or is far from the other one."""
    squares = (values[:, :ACROSS] ** 2).sum(1)
    deviation = 1.0 if are_deviations else max(_deviation(squares, np.full(len(squares), ACROSS)), MIN_DEVIATION)
    return np.asarray(np.maximum(1 - (values[:, ACROSS:] / (CUT * deviation)) ** 2, 0.0))
