"""k-means clustering of objects by the cost of the rotors between them (thesis 3.12.3)."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from operator import index
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..arrays import real, truth
from ..codegen.errors import InputError, ShapeError
from ..multivector import Multivector
from ..status import Status
from . import local
from .costs import KINDS, is_far
from .inputs import as_objects, chosen, number
from .lloyd import Clustering, Labels

#: Ways to choose the first centroids.
STARTS = ("k-means++", "random")
#: Iterations at most where the caller names no number.
MAX_ITERATIONS = 300
#: Iterations end when the cost falls by less than this part of itself: noise of assignments, not of the clusters.
TOLERANCE = 1e-4


@dataclass(frozen=True)
class Clusters:
    """What `kmeans` found. Unpacks as two: ``labels, centroids = kmeans(X, k)``.

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
        """Whether the iterations led to an end."""
        return Status.OK if self.converged else Status.NOT_CONVERGED

    def __iter__(self) -> Iterator[Any]:
        return iter((self.labels, self.centroids))


def kmeans(
    X: Any,
    k: int,
    seed: int = 0,
    init: str = "k-means++",
    weights: Any = None,
    max_iterations: int = MAX_ITERATIONS,
    tolerance: float = TOLERANCE,
    kind: str = "positive",
    align: bool = True,
    threads: int | None = None,
    progress: bool | Callable[[int, int], None] = False,
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
    max_iterations : int
        The status is `NOT_CONVERGED` where they ran out.
    tolerance : float
        Stop when the cost falls by less than this part of itself. 0: only when no centroid moves.
    kind : str
        "positive" or "thesis"; see `rotor_cost`.
    align : bool
        Orientation does not matter: L and -L are one line. Members are added in the orientation of their centroid.
        Otherwise L and -L are as different as lines can be.
    threads : int, optional
        Default: all processors of this process.
    progress : bool or callable
        True: a bar on standard error. A callable gets (iterations done, iterations at most).

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
    frame = local.frame(rows, shared=True) if is_far(rows, rows) else None
    rows = rows if frame is None else frame.inward(rows)
    kind, init = chosen(kind, tuple(KINDS), "kind"), chosen(init, STARTS, "init")
    most = _count(max_iterations, "max_iterations")
    counted, unit = _weights(weights, objects.shape)
    run = Clustering(rows, _count(k, "k"), counted, kind, truth(align, "align"), threads)
    tolerance = number(tolerance, "tolerance")
    if not 0 <= tolerance < 1:
        raise InputError(f"tolerance is {tolerance}; a number from 0 to 1 is needed.")
    random = np.random.default_rng(_count(seed, "seed", least=0))
    with ExitStack() as stack, np.errstate(over="ignore"):  # a total cost beyond all numbers is infinite
        first = run.spread_start(random) if init == STARTS[0] else run.random_start(random)
        found = run.to_the_end(first, most, tolerance, _teller(progress, most, stack))
    labels, centroids, cost, iterations, converged = found
    centroids = centroids if frame is None else frame.outward(centroids)
    return Clusters(labels.reshape(objects.shape), centroids, cost * unit, iterations, converged)


# -- arguments ---------------------------------------------------------------------------------------------


def _count(value: Any, name: str, least: int = 1) -> int:
    try:
        count = index(value)
    except TypeError:
        raise InputError(f"{name} is {value!r}; a whole number is needed.") from None
    if count < least:
        raise InputError(f"{name} is {count}; at least {least} is needed.")
    return count


def _weights(weights: Any, shape: tuple[int, ...]) -> tuple[NDArray[np.float64] | None, float]:
    """Weights below 2, and their unit, a power of two: sums of great ones do not overflow."""
    if weights is None:
        return None, 1.0
    given = real(weights, "weights").astype(np.float64)
    if given.shape != shape:
        raise ShapeError(f"weights have shape {given.shape}, the objects {shape}; each object needs one.")
    given = given.ravel()
    bad = ~(np.isfinite(given) & (given >= 0))
    if bad.any():
        raise InputError(f"weight {int(bad.argmax())} is {given[bad.argmax()]}; weights are not negative, and finite.")
    if given.size and not given.any():
        raise InputError("all weights are zero.")
    exponent = int(np.frexp(given.max(initial=0))[1]) - 1
    return np.ldexp(given, -exponent), 2.0**exponent


def _teller(wanted: bool | Callable[[int, int], None], most: int, stack: ExitStack) -> Callable[[int], None]:
    """What is told after each iteration."""
    if callable(wanted):
        return lambda done: wanted(done, most)
    if not truth(wanted, "progress"):
        return lambda done: None
    from tqdm import tqdm

    bar = stack.enter_context(tqdm(total=None, desc="kmeans", unit="iteration"))
    return lambda done: bar.update(1) and None
