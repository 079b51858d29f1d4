"""How much larger a reference is than a query: ratios of distances and radii of objects that may be the same vote.
Each likely scale is tried; the best is made exact by the matches.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import combinations_with_replacement
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.errors import UndeterminedError
from ..codegen.programs.reform import DIRECTED
from .job import Job
from .model import Model
from .result import Registration
from .similarities import similarity
from .tables import COSINE
from .unfinished import INTERRUPTED

Array = NDArray[Any]
#: Pairs of either model that vote, of each two kinds.
PAIRS = 3000
#: Widths of a bin of log scale, with the greatest difference of the cosines of pairs that may be one: for exact models
#: and for noisy ones.
WIDTHS = ((0.01, 3e-3), (0.05, 3e-2))
#: How far scales may be from that of the models' sizes; scales of each width that are worth a trial; how many bins on
#: either side of one are looked at for what is usual.
WIDEST, TRIALS, USUAL = float(np.log(100.0)), 4, 20
#: Distances below this, in units of the models' size, tell no scale.
LEAST_DISTANCE = 0.02
#: Rounds in which scale and pose are made exact in turn; a smaller change of the scale ends them.
ROUNDS, SETTLED = 12, 1e-13


def similar(query: Model, reference: Model, run: Callable[[Model], Registration]) -> Registration:
    """The scale and the pose: x goes to motor (scale x), scaled about the world's origin.

    Parameters
    ----------
    query, reference : Model
    run : callable
        Registers a query that has been scaled.

    Raises
    ------
    UndeterminedError
        If no two objects tell a scale: where there are only planes, or lines through one point.
    """
    job = Job(query.objects, reference.objects, threads=1)
    found = None
    for scale in scales(job):
        here = run(_scaled(query, scale))
        if found is None or here.doubt < found.doubt:
            found = replace(here, scale=float(scale))
        if here.message == INTERRUPTED:
            return replace(found, converged=False, message=INTERRUPTED)
        if found.converged:
            break
    if found is None:
        what = "nothing that the models have in common tells their scale"
        remedy = "Give points, rounds, or lines that do not all meet; or leave similarity out"
        raise UndeterminedError(what, remedy=remedy)
    for _ in range(ROUNDS):
        ratio = _exact(job, found) / found.scale
        if not np.isfinite(ratio) or abs(ratio - 1) < SETTLED:
            break
        scale = found.scale * ratio
        here = run(_scaled(query, scale))
        if here.message == INTERRUPTED:
            return replace(found, converged=False, message=INTERRUPTED)
        found = replace(here, scale=scale)
    return found


def _scaled(query: Model, scale: float) -> Model:
    return query.in_frame((0.0, 0.0, 0.0), 1 / scale)


def _exact(job: Job, found: Registration) -> float:
    """The scale of least squares over the matches, of the shift too, for the rotation that is known.

    Matches ask of scale s and shift t that s R x + t - y be zero, but along lines and planes, and s r equal to r'.
    """
    turn = similarity(found.motor)[1]
    rows, sides = [np.zeros((0, 4))], [np.zeros(0)]
    for kind in job.query.side.rows:
        matched = found.matches[kind]
        x = job.query.side.elements[kind][matched >= 0]
        y = job.reference.side.elements[kind][matched[matched >= 0]]
        across = np.einsum("ni,nj->nij", y[:, 3:6], y[:, 3:6])
        free = {"plane": across, "line": np.eye(3) - across}.get(kind, np.broadcast_to(np.eye(3), across.shape))
        rows.append(np.concatenate([(free @ (x[:, :3] @ turn.T)[..., None]), free], -1).reshape(-1, 4))
        sides.append((free @ y[:, :3, None]).ravel())
        rows.append(np.stack([x[:, 6], *np.zeros((3, len(x)))], -1))
        sides.append(y[:, 6])
    solved, _, rank, _ = np.linalg.lstsq(np.concatenate(rows), np.concatenate(sides), rcond=None)
    return float(solved[0]) if rank == 4 and solved[0] > 0 else np.nan


def scales(job: Job, trials: int = TRIALS) -> Array:
    """Scales (k,) by which the query may have to be multiplied, the likeliest first.

    Parameters
    ----------
    job : Job
        Of both models as they are.
    trials : int
        How many of each width of bins, at most.
    """
    random = np.random.default_rng(0)
    kinds = list(job.query.side.rows)
    sides = (job.query.side, job.reference.side)
    pairs = {
        pair: tuple(_pairs(job, side.rows, pair, random) for side in sides)
        for pair in combinations_with_replacement(kinds, 2)
    }
    found = []
    for width, angle in WIDTHS:
        total = np.zeros(2 * round(WIDEST / width) + 1)
        for pair, (first, second) in pairs.items():
            total += _votes(first, second, angle if set(pair) <= DIRECTED else 2.0, width)
        for kind in kinds:
            own, other = (side.elements[kind][:, 6] for side in sides)
            if (own > 0).all() and (other > 0).all():
                total += _counted(np.log(other[None, :] / own[:, None]).ravel(), width)
        found.append(_peaks(total, width, trials))
    both = [
        x
        for both in zip(*(np.pad(f, (0, trials - len(f)), constant_values=np.nan) for f in found), strict=True)
        for x in both
    ]
    return np.array([x for x in both if np.isfinite(x)])


def _peaks(votes: Array, width: float, most: int) -> Array:
    """Scales that have more votes than those about them, for what chance gives."""
    smooth = np.convolve(votes, (0.5, 1.0, 0.5), "same")
    usual = np.convolve(smooth, np.ones(2 * USUAL + 1) / (2 * USUAL + 1), "same")
    standing = (smooth - usual) / np.sqrt(usual + 1)
    found: list[float] = []
    while len(found) < most and standing.max() > 0:
        best = int(standing.argmax())
        near = slice(max(best - 1, 0), best + 2)
        found.append(float((np.arange(len(votes))[near] @ votes[near]) / max(votes[near].sum(), 1e-300)))
        standing[max(best - 2, 0) : best + 3] = 0
    return np.asarray(np.exp((np.array(found) - len(votes) // 2) * width))


def _pairs(job: Job, rows: Any, kinds: tuple[str, str], random: np.random.Generator) -> Array:
    """Invariants (n, 4) of some pairs of objects of two kinds."""
    first, second = (len(rows[k]) for k in kinds)
    if kinds[0] == kinds[1]:
        i, j = np.triu_indices(first, 1)
    else:
        i, j = (x.ravel() for x in np.indices((first, second)))
    some = random.permutation(len(i))[:PAIRS]
    places = i[some].astype(np.int32), j[some].astype(np.int32)
    return np.asarray(job.driver.invariants(kinds, (rows[kinds[0]], rows[kinds[1]]), places))


def _votes(query: Array, reference: Array, angle: float, width: float) -> Array:
    """Votes for each log scale, of pairs whose cosines agree."""
    query, reference = (x[np.abs(x[:, 0]) > LEAST_DISTANCE] for x in (query, reference))
    order = np.argsort(np.abs(reference[:, COSINE]), kind="stable")
    angles, asked = np.abs(reference[order, COSINE]), np.abs(query[:, COSINE])
    low, high = np.searchsorted(angles, asked - angle), np.searchsorted(angles, asked + angle)
    count = high - low
    source = np.repeat(np.arange(len(query)), count)
    place = order[np.arange(len(source)) + np.repeat(low - np.cumsum(count) + count, count)]
    return _counted(np.log(np.abs(reference[place, 0] / query[source, 0])), width)


def _counted(logs: Array, width: float) -> Array:
    middle = round(WIDEST / width)
    bins = np.round(logs / width).astype(np.int64) + middle
    good = (bins >= 0) & (bins <= 2 * middle)
    return np.bincount(bins[good], minlength=2 * middle + 1).astype(np.float64)
