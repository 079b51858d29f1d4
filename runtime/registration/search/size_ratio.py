"""The ratio of the sizes of two models, from distances between their objects: neither a center nor outliers count."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from itertools import combinations_with_replacement
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import UndeterminedError
from ..backends.model_rows import ModelData
from ..model.normalization import model_size
from ..result import Registration
from ..verification.scale_significance import least_squares_scale
from .invariant_tables import pair_indices
from .problem import RegistrationProblem

Array = NDArray[Any]
#: Largest number of objects of each kind that are compared.
MAX_OBJECTS = 64
#: The size of a set of objects is this quantile of the distances of its pairs (Rousseeuw and Croux: Qn). A pair of true
#: objects is below it as long as half of the objects are true.
QUANTILE = 0.25
#: Distances below this fraction of the largest one are rounding.
ROUNDING = 1e-9
#: Without a scale the matches of models of unusual sizes have to agree that it is 1, about: of a model that is tiny all
#: objects match where a few of the other one meet.
MAX_SCALE_ERROR = 0.2
#: A ratio beyond this, or below its inverse, is reported: it may be that of two units of length.
UNUSUAL = 50.0
#: Models whose sizes with all objects, outliers too, are within this fraction are of usual ratios.
USUAL = 0.2


def size_ratio(problem: RegistrationProblem) -> float:
    """Size of the reference over that of the query: the weighted median over the pairs of kinds that have distances,
    and the kinds that have radii. NaN where there are none.
    """
    sides = problem.query.data, problem.reference.data
    chosen = [{kind: _some(len(rows)) for kind, rows in side.rows.items()} for side in sides]
    logs: list[float] = []
    weights: list[int] = []
    for pair in combinations_with_replacement(problem.query.data.rows, 2):
        _add_ratio(logs, weights, *(_distances(problem, *each, pair) for each in zip(sides, chosen, strict=True)))
    for kind in problem.query.data.rows:
        _add_ratio(
            logs, weights, *(side.elements[kind][some[kind], 6] for side, some in zip(sides, chosen, strict=True))
        )
    if not logs:
        return float("nan")
    order = np.argsort(logs, kind="stable")
    cumulated = np.cumsum(np.array(weights)[order])
    return float(np.exp(np.array(logs)[order][np.searchsorted(cumulated, cumulated[-1] / 2)]))


def describe_unusual_ratio(ratio: float) -> str:
    """Description of the ratio of two models' sizes (`size_ratio`); empty for a usual one, and for NaN."""
    if ratio >= UNUSUAL:
        return f"the query is {ratio:.3g} times smaller"
    return f"the query is {1 / ratio:.3g} times larger" if ratio <= 1 / UNUSUAL else ""


def compare_sizes(problem: RegistrationProblem, find: Callable[[], Registration]) -> Registration:
    """A result of registering without a scale: it has not converged where sizes differ and matches do not fit at the
    scale 1; messages say how sizes differ.
    """
    sizes = [model_size(side.data.elements) for side in (problem.query, problem.reference)]
    is_usual = max(sizes) * USUAL < min(sizes)  # most models: nothing more has to be computed
    unusual = "" if is_usual else describe_unusual_ratio(size_ratio(problem))
    if not unusual:
        return find()
    hint = f"{unusual}: another unit? similarity=True"
    try:
        result = find()
    except UndeterminedError as error:
        what = f"{error.what}; {hint}"
        raise UndeterminedError(what, where=error.where, motions=error.motions, result=error.result) from None
    if result.converged and abs(least_squares_scale(problem, result)[0] - 1) <= MAX_SCALE_ERROR:
        return result
    message = result.message or "the matches do not fit at one size"
    return replace(
        result, converged=False, doubt=math.inf if result.converged else result.doubt, message=f"{message}; {hint}"
    )


def _some(count: int) -> Array:
    return np.random.default_rng(0).permutation(count)[:MAX_OBJECTS]


def _distances(
    problem: RegistrationProblem, side: ModelData, chosen: dict[str, Array], kinds: tuple[str, str]
) -> Array:
    first, second = (side.rows[kind][chosen[kind]] for kind in kinds)
    i, j = pair_indices(kinds, len(first), len(second))
    indices = i.astype(np.int32), j.astype(np.int32)
    return np.asarray(np.abs(problem.driver.invariants(kinds, (first, second), indices)[:, 0]))


def _add_ratio(logs: list[float], weights: list[int], query: Array, reference: Array) -> None:
    """Add the log of the ratio of two sets of lengths, unless they are zero."""
    sizes = [float(np.quantile(x, QUANTILE)) if len(x) else 0.0 for x in (query, reference)]
    largest = [float(x.max(initial=0.0)) for x in (query, reference)]
    if all(size > ROUNDING * most for size, most in zip(sizes, largest, strict=True)):
        logs.append(float(np.log(sizes[1] / sizes[0])))
        weights.append(min(len(query), len(reference)))
