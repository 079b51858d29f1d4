"""The scale of a similarity: ratios of distances and radii of possible matches vote. Each likely scale is tried, and
the best one is refined from the matches.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from itertools import combinations_with_replacement
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import Interrupted, UndeterminedError
from ...codegen.programs.registration.registration import DIRECTED
from ..model.model import Model
from ..result import Registration
from ..verification.scale_significance import check_scale, least_squares_scale
from .interrupted import INTERRUPTED
from .invariant_tables import COSINE, expand_ranges, pair_indices
from .problem import RegistrationProblem
from .size_ratio import describe_unusual_ratio, size_ratio

Array = NDArray[Any]
#: If the ratio of the models' sizes is beyond this, the query is first scaled by a power of two, which is exact.
MAX_SIZE_RATIO = 4.0
#: Largest number of pairs of either model that vote, for each two kinds.
MAX_PAIRS = 3000
#: Widths of a bin of the log scale, each with the largest difference of the cosines of two matching pairs: for exact
#: models and for noisy ones.
BINS = ((0.01, 3e-3), (0.05, 3e-2))
#: Largest log scale, relative to the ratio of the models' sizes.
MAX_LOG_SCALE = float(np.log(100.0))
#: Largest number of scales of each bin width that are tried.
TRIALS_PER_WIDTH = 4
#: Bins on either side of one that give its expected number of votes.
SMOOTHING_BINS = 20
#: Pairs at a smaller distance, in units of the models' size, do not vote.
MIN_DISTANCE = 0.02
#: Largest number of rounds of refining scale and pose in turn.
MAX_ROUNDS = 12
#: A smaller relative change of the scale ends them.
MIN_CHANGE = 1e-13


def register_similarity(
    query: Model, reference: Model, run: Callable[[Model], Registration], length: float = 1.0
) -> Registration:
    """Scale and pose of a query: x goes to motor (scale x), scaled about the world's origin. ``run`` registers a scaled
    query, with this ``length`` of `register`.

    Raises
    ------
    UndeterminedError
        If no two objects determine a scale: where there are only planes, or lines through one point.
    """
    problem = RegistrationProblem(query, reference, threads=1, length=length)
    given, ratio, factor = problem, size_ratio(problem), 1.0
    if abs(math.log(ratio)) > math.log(MAX_SIZE_RATIO):  # not for NaN
        factor = 2.0 ** round(math.log2(ratio))
        problem = RegistrationProblem(_scale_query(query, factor), reference, threads=1, length=length)
    result: Registration | None = None

    def run_at(scale: float) -> Registration:
        try:
            return check_scale(problem, replace(run(_scale_query(query, scale)), scale=float(scale)))
        except Interrupted as interrupt:
            best = replace(interrupt.partial, scale=float(scale))
            best = best if result is None or best.doubt < result.doubt else result
            raise Interrupted(replace(best, converged=False, message=INTERRUPTED)) from None

    frames = [(problem, factor), (given, 1.0)][: 1 if problem is given else 2]  # sizes of few objects may mislead
    for scale in (unit * x for side, unit in frames for x in scales(side)):
        trial = run_at(scale)
        if result is None or trial.doubt < result.doubt:
            result = trial
        if result.converged:
            break
    unusual = describe_unusual_ratio(ratio)
    if result is None:
        what = "the objects that the models have in common do not determine a scale"
        what = f"{what}; {unusual}" if unusual else what
        remedy = "Give points, rounds, or lines that do not all meet; or leave similarity out"
        raise UndeterminedError(what, remedy=remedy)
    for _ in range(MAX_ROUNDS):
        change = factor * least_squares_scale(problem, result)[0] / result.scale
        if not np.isfinite(change) or abs(change - 1) < MIN_CHANGE:
            break
        result = run_at(result.scale * change)
    return result if result.converged or not unusual else replace(result, message=f"{result.message}; {unusual}")


def _scale_query(query: Model, scale: float) -> Model:
    return query.in_frame((0.0, 0.0, 0.0), 1 / scale)


def scales(problem: RegistrationProblem, trials: int = TRIALS_PER_WIDTH) -> Array:
    """Candidate scales (k,) of the query, relative to the present one, the likeliest first: at most ``trials`` of each
    bin width.
    """
    random = np.random.default_rng(0)
    kinds = list(problem.query.data.rows)
    model_data = (problem.query.data, problem.reference.data)
    pairs = {
        pair: tuple(_pairs(problem, side.rows, pair, random) for side in model_data)
        for pair in combinations_with_replacement(kinds, 2)
    }
    peaks = []
    for width, angle in BINS:
        total = np.zeros(2 * round(MAX_LOG_SCALE / width) + 1)
        for pair, (first, second) in pairs.items():
            total += _votes(first, second, angle if set(pair) <= DIRECTED else 2.0, width)
        for kind in kinds:
            query_radii, reference_radii = (side.elements[kind][:, 6] for side in model_data)
            if (query_radii > 0).all() and (reference_radii > 0).all():
                total += _histogram(np.log(reference_radii[None, :] / query_radii[:, None]).ravel(), width)
        peaks.append(_peaks(total, width, trials))
    merged = [
        x
        for merged in zip(*(np.pad(f, (0, trials - len(f)), constant_values=np.nan) for f in peaks), strict=True)
        for x in merged
    ]
    return np.array([x for x in merged if np.isfinite(x)])


def _peaks(votes: Array, width: float, max_count: int) -> Array:
    """Scales whose numbers of votes exceed the expected ones most."""
    smooth = np.convolve(votes, (0.5, 1.0, 0.5), "same")
    expected = np.convolve(smooth, np.ones(2 * SMOOTHING_BINS + 1) / (2 * SMOOTHING_BINS + 1), "same")
    significance = (smooth - expected) / np.sqrt(expected + 1)
    peaks: list[float] = []
    while len(peaks) < max_count and significance.max() > 0:
        highest = int(significance.argmax())
        window = slice(max(highest - 1, 0), highest + 2)
        peaks.append(float((np.arange(len(votes))[window] @ votes[window]) / max(votes[window].sum(), 1e-300)))
        significance[max(highest - 2, 0) : highest + 3] = 0
    return np.asarray(np.exp((np.array(peaks) - len(votes) // 2) * width))


def _pairs(problem: RegistrationProblem, rows: Any, kinds: tuple[str, str], random: np.random.Generator) -> Array:
    """Invariants (n, 4) of a random subset of the pairs of two kinds."""
    first, second = (len(rows[k]) for k in kinds)
    i, j = pair_indices(kinds, first, second)
    drawn = random.permutation(len(i))[:MAX_PAIRS]
    indices = i[drawn].astype(np.int32), j[drawn].astype(np.int32)
    return np.asarray(problem.driver.invariants(kinds, (rows[kinds[0]], rows[kinds[1]]), indices))


def _votes(query: Array, reference: Array, angle: float, width: float) -> Array:
    """Votes for each log scale, from pairs whose cosines agree."""
    query, reference = (x[np.abs(x[:, 0]) > MIN_DISTANCE] for x in (query, reference))
    order = np.argsort(np.abs(reference[:, COSINE]), kind="stable")
    angles, cosines = np.abs(reference[order, COSINE]), np.abs(query[:, COSINE])
    low, high = np.searchsorted(angles, cosines - angle), np.searchsorted(angles, cosines + angle)
    source, ranks = expand_ranges(low, high)
    position = order[ranks]
    return _histogram(np.log(np.abs(reference[position, 0] / query[source, 0])), width)


def _histogram(logs: Array, width: float) -> Array:
    middle = round(MAX_LOG_SCALE / width)
    bins = np.round(logs / width).astype(np.int64) + middle
    good = (bins >= 0) & (bins <= 2 * middle)
    return np.bincount(bins[good], minlength=2 * middle + 1).astype(np.float64)
