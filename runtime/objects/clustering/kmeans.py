"""k-means clustering of objects by the cost of the rotors between them (thesis 3.12.3)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import InputError
from ...codegen.interrupts import keep_partial
from ...common.deprecation import renamed_keywords
from ...common.progress import ProgressOption, open_progress
from ...common.validation import as_bool, as_choice, as_float, as_int, check_shape, positive_array
from ...core.multivector import Multivector
from ...status import Status
from ..arguments import as_objects
from ..rotors import local_origin
from ..rotors.costs import COSTS, is_far
from .lloyd import Clustering, Labels

#: Ways to choose the first centroids.
STARTS = ("k-means++", "random")
#: Iterations at most where the caller names no number.
MAX_ITERATIONS = 300
#: Iterations end when the cost falls by less than this part of itself: noise of assignments, not of the clusters.
TOLERANCE = 1e-4


@dataclass(frozen=True)
class Clusters:
    """Result of `kmeans`. Unpacks as two: ``labels, centroids = kmeans(X, k)``.

    Attributes
    ----------
    labels : array of int64, shape of the objects
        Cluster of each object.
    centroids : Multivector, shape (k,)
        Unit objects.
    cost : float
        Sum of the objects' costs to their centroids, each times its weight.
    iterations : int
        How often the centroids were moved.
    converged : bool
        Whether no centroid moved any more, or the cost no longer fell.
    status : Status
        `OK`, or `NOT_CONVERGED` where the iterations ran out.
    """

    labels: Labels
    centroids: Multivector
    cost: float
    iterations: int
    converged: bool

    @property
    def status(self) -> Status:
        """OK if the iterations converged, else NOT_CONVERGED."""
        return Status.OK if self.converged else Status.NOT_CONVERGED

    @property
    def message(self) -> str:
        """Why it has not converged; else empty."""
        return "" if self.converged else f"the {self.iterations} iterations ran out"

    def __iter__(self) -> Iterator[Any]:
        return iter((self.labels, self.centroids))


@renamed_keywords(kind="cost", max_iterations="iterations")
def kmeans(
    X: Any,
    k: int,
    seed: int = 0,
    init: str = "k-means++",
    weights: Any = None,
    iterations: int = MAX_ITERATIONS,
    tolerance: float = TOLERANCE,
    cost: str = "positive",
    align: bool = True,
    threads: int | None = None,
    progress: ProgressOption = False,
) -> Clusters:
    """Clusters of objects around k centroids.

    Each object goes to the centroid that it costs least to reach (`cost_matrix`); each centroid becomes the sum of its
    objects, projected to the nearest object; and so on.

    Parameters
    ----------
    X : Multivector or list, shape (n,)
        Unit objects of one grade, flats and rounds mixed as you like. Objects of several grades are several calls.
    k : int
        Number of clusters.
    seed : int
        Of the random start; the result depends on nothing else, nor on the number of threads.
    init : str
        "k-means++": spread out, the best of a few draws each time. "random": k of the objects, as printed.
    weights : array (n,), optional
        How much each object counts; not negative, not all zero.
    iterations : int
        At most so many; the status is `NOT_CONVERGED` where they ran out.
    tolerance : float
        Stop when the cost falls by less than this part of itself. 0: only when no centroid moves.
    cost : str
        "positive" or "thesis"; see `rotor_cost`.
    align : bool
        Orientation does not matter: L and -L are one line. Members are added in the orientation of their centroid.
        Otherwise L and -L are as different as lines can be.
    threads : int, optional
        Default: the package's (`bladesmith.set_threads`).
    progress : bool or callable
        True: a bar on standard error. A callable gets a `bladesmith.Progress` of iterations.

    Returns
    -------
    Clusters
        ``.labels``, ``.centroids``, ``.cost``, ``.iterations``, ``.converged``, ``.status``.

    Raises
    ------
    InputError
        If there are no objects, fewer than k, or one is invalid (which); if k, the weights or the numbers of
        iterations are none.
    GradeError, AlgebraMismatchError
        If the objects are not of one grade and algebra.
    Interrupted
        On an interrupt; its ``partial`` holds the clusters of the last iteration.

    Notes
    -----
    Thesis 3.12.3. A cluster that loses its last object starts again at the object that is farthest from its centroid;
    where a sum vanishes, or is no real object, the centroid stays. So it does where the mean would raise the cost of
    its members: the mean does not minimise the cost, and as printed the iterations need not end (1e5 random circles
    about 50 centroids: 300 iterations, and the cost 10 % above that of the start).

    Costs belong to the world's origin. Rounds some hundred radii away from it, whose costs would have no digits, are
    seen from an origin in their middle; ``.cost`` then is the one there.
    """
    objects = as_objects(X, "the objects")
    rows = objects.reshape(-1)
    frame = local_origin.frame(rows, shared=True) if is_far(rows, rows) else None
    rows = rows if frame is None else frame.to_local(rows)
    cost, init = as_choice(cost, "cost", tuple(COSTS)), as_choice(init, "init", STARTS)
    most = as_int(iterations, "iterations")
    counted, unit = _weights(weights, objects.shape)
    run = Clustering(rows, as_int(k, "k"), counted, cost, as_bool(align, "align"), threads)
    tolerance = as_float(tolerance, "tolerance", 0, below=1)
    random = np.random.default_rng(as_int(seed, "seed", 0))

    def result(labels: Labels, centroids: Multivector, total: float, steps: int, converged: bool) -> Clusters:
        centroids = centroids if frame is None else frame.to_world(centroids)
        return Clusters(labels.reshape(objects.shape), centroids, total * unit, steps, converged)

    with open_progress(progress, "kmeans", "iterations", most) as report, np.errstate(over="ignore"):  # infinite costs
        first = run.spread_start(random) if init == STARTS[0] else run.random_start(random)
        states = run.iterations(first, most, tolerance)
        latest = next(states)
        with keep_partial(lambda: result(*latest)):
            for state in states:
                latest = state
                report(state[3])
    return result(*latest)


# -- arguments ---------------------------------------------------------------------------------------------


def _weights(weights: Any, shape: tuple[int, ...]) -> tuple[NDArray[np.float64] | None, float]:
    """Weights below 2, and their unit, a power of two: sums of great ones do not overflow."""
    if weights is None:
        return None, 1.0
    given = positive_array(weights, "weights", zero=True)
    check_shape(given, "weights", shape, remedy="Give one for each object")
    given = given.ravel()
    if given.size and not given.any():
        raise InputError("all weights are zero.")
    exponent = int(np.frexp(given.max(initial=0))[1]) - 1
    return np.ldexp(given, -exponent), 2.0**exponent
