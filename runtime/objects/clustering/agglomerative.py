"""Merging of similar objects (thesis 3.12.2): the two of least cost become their mean, until all costs are too high.

Arguments are checked here, and results named; the loop is compiled (`greedy`).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...codegen.errors import InputError
from ...codegen.interrupts import keep_partial
from ...common import parallel
from ...common.deprecation import renamed_attribute
from ...common.progress import ProgressOption, open_progress
from ...common.validation import as_bool, as_choice, as_float, broadcast_to, finite_array, positive_array
from ...core.multivector import Multivector
from ...dispatch.formulas import evaluate
from ...dispatch.item_statuses import raise_first
from ..arguments import as_objects, concatenate_objects
from ..rotors.local_origin import Frame
from .agglomerative_driver import TARGETS, Greedy

Array = NDArray[Any]
#: Weights differ at most by this factor: means of point pairs and circles have fourth powers of them.
WEIGHT_RANGE = 1e60
#: The algebra that the driver is compiled for.
ALGEBRA = "cga3d"

#: An array, or one for each grade of a list of objects.
Arrays: TypeAlias = NDArray[Any] | tuple[NDArray[Any], ...]


@dataclass(frozen=True)
class MergeResult:
    """Result of merging. Unpacks as two: ``Y, groups = merge_similar(X, threshold)``.

    Attributes
    ----------
    objects : Multivector, shape (m,)
        Means, in the order of the first member of each.
    groups : integer array, shape of the input
        For each input object the place of its mean in ``objects``.
    counts : array (m,)
        Members of each mean.
    merge_costs : array (k,)
        Cost of each merge, in order. It may fall now and then: a mean can be nearer to others than its parents.
    pairs : array (k, 2)
        The groups that each merge joined, by the place of their first member among the input objects.
    evaluations : int
        Costs that were computed.
    """

    objects: Multivector | tuple[Multivector, ...]
    groups: Arrays
    counts: Arrays
    merge_costs: Arrays
    pairs: Arrays
    evaluations: int

    merges = renamed_attribute("merge_costs")

    def __iter__(self) -> Iterator[Any]:
        return iter((self.objects, self.groups))


def merge_similar(
    X: Any,
    threshold: float,
    weights: ArrayLike | None = None,
    align: bool = True,
    progress: ProgressOption = False,
    *,
    origin: ArrayLike | None = None,
    strict: bool = False,
    threads: int | None = None,
    target: str = "c",
) -> MergeResult:
    """Merge objects near each other: of all pairs the one of least cost is replaced by its mean, again and again.

    Parameters
    ----------
    X : Multivector of shape (...), or list of multivectors
        Points, point pairs, lines, circles, planes or spheres; a list may mix flats and rounds of one grade, and
        may hold several grades: each is merged on its own.
    threshold : float
        Pairs of a greater cost (`cost_matrix`, the positive cost) stay apart. For lines the cost is about
        (angle^2 + 3 (distance between their points next to the origin)^2)/4, for planes alike, for points
        3 distance^2/4: it depends on the unit of length.
    weights : array (...), optional
        What each object counts for in means (for several grades a list of such). Default: 1 each.
    align : bool
        X and -X are one object: the second of two is turned like the first, whose orientation the mean has. Otherwise
        opposite ones are far apart.
    progress : bool or callable
        True: a bar on standard error. A callable gets a `bladesmith.Progress` of merges.
    origin : array (3,), optional
        Where costs are measured from, since the cost of a rotation grows with the distance of its axis from the
        origin. Default: the mean of the objects' positions (of flats the points next to the world's origin).
        `cost_matrix` measures from (0, 0, 0).
    strict : bool
        Raise for an item that is not a valid object, instead of leaving it alone.
    threads : int, optional
        For the first search; merging itself is one thread. Default: the package's (`bladesmith.set_threads`). The
        result is the same for any number.
    target : {"c", "cuda"}
        What makes the first search: "cuda" is a GPU, an object in each thread, with the same result. Merging itself is
        compiled C.

    Returns
    -------
    MergeResult
        ``objects, groups``, and more by name. Items that are no objects stay, as NaN of status `INVALID`. For several
        grades ``objects`` is a tuple with one batch per grade, in order of appearance, and ``groups`` has an array
        for each entry of the list, with places in the batch of its grade; the other fields are tuples by grade.

    Raises
    ------
    InputError, GradeError, ShapeError
        If the threshold is negative or NaN, a weight is not positive and finite or `WEIGHT_RANGE` times less than
        another, or X is not made of objects.
    SingularError
        With ``strict``.
    DeviceError, MissingExtraError
        If the target is "cuda", and there is no GPU or no compiler for it.
    Interrupted
        On an interrupt; its ``partial`` holds the objects that were merged until then (of the grade at work).

    Notes
    -----
    Thesis 3.12.2 computes all costs again for each merge, O(n^3). Here the result is the same, from a tree over
    positions, directions and coefficients with proven lower bounds of the cost: about O(n log n) as long as objects
    are spread out at the scale of their nearest neighbours, which are all that is looked at. Pairs without a mean (for
    example opposite lines with ``align=False``), or without a rotor, are never merged. Memory: about 0.3 kB
    per flat or point, 0.6 kB per round.

    Examples
    --------
    >>> import bladesmith as bs
    >>> lines = bs.cga3d.line([(0, 0, 0), (0, 0.01, 0), (5, 0, 0)], [(1, 0, 0), (-1, 0, 0), (0, 0, 1)])
    >>> merged, groups = bs.objects.merge_similar(lines, 1e-3)
    >>> merged.shape, groups.tolist()
    ((2,), [0, 0, 1])
    """
    limit, align, strict = (
        as_float(threshold, "the threshold", 0, np.inf),
        as_bool(align, "align"),
        as_bool(strict, "strict"),
    )
    as_choice(target, "target", TARGETS)
    entries = [as_objects(x, f"the objects: entry {i}") for i, x in enumerate(X)] if _is_list(X) else None
    if entries and len({x.grades for x in entries}) > 1:
        return _by_grade(entries, limit, weights, align, progress, origin, strict, threads, target)
    x = concatenate_objects(entries) if entries else as_objects(X)
    if x.algebra.name != ALGEBRA:
        raise InputError(f"the objects belong to {x.algebra.name}; merging is for those of {ALGEBRA}.")
    if as_bool(strict, "strict"):
        raise_first(x._status, "merge_similar")
    flat = x.reshape(x.size).astype(np.float64)
    counted = _weights(weights, x.shape).reshape(x.size)
    counted = counted / counted.max(initial=np.finfo(float).smallest_subnormal)
    frame = _frame(flat, origin)
    parallel.thread_count(threads)  # checked before any work
    greedy = Greedy(x.kind.name, frame.to_local(flat)._data, counted, limit, align, target)
    with (
        open_progress(progress, "merge", "merges") as report,
        keep_partial(lambda: _result(x, flat, frame, greedy)),
    ):
        merged = 0
        greedy.find(threads)
        while done := greedy.step():
            merged += done
            report(merged)
    return _result(x, flat, frame, greedy)


def _is_list(X: Any) -> bool:
    return isinstance(X, (list, tuple)) and len(X) > 0


def _weights(weights: ArrayLike | None, shape: tuple[int, ...]) -> Array:
    if weights is None:
        return np.ones(shape)
    found = broadcast_to(positive_array(weights, "weights"), shape, "weights")
    heaviest = found.max(initial=0.0)
    light = found < heaviest / WEIGHT_RANGE
    if light.any():
        place = tuple(int(i) for i in np.argwhere(light)[0])
        raise InputError(
            f"the weight of object {place} is {found[place]}, that of another {heaviest}; "
            f"weights may differ by a factor of {WEIGHT_RANGE:g}."
        )
    return found


def _frame(x: Multivector, origin: ArrayLike | None) -> Frame:
    """Local frame in which costs are measured."""
    if origin is None:
        position = evaluate(x.algebra, "local.anchor", x).value._data
        good = np.isfinite(position).all(-1)
        position = position[good].mean(0) if good.any() else np.zeros(3)
    else:
        position = finite_array(x.algebra.spatial(origin, "origin").rows(), "origin", (3,))
    return Frame(position, x.algebra.translator(position))


def _result(x: Multivector, flat: Multivector, frame: Frame, greedy: Greedy) -> MergeResult:
    costs, kept, gone = greedy.history
    parent = np.arange(flat.size)
    parent[gone] = kept
    for _ in range(max(1, flat.size).bit_length() + 1):  # a group keeps the slot of its first member: parents only fall
        parent = parent[parent]
    first, groups, counts = np.unique(parent, return_inverse=True, return_counts=True)
    data = flat._data[first]
    moved = counts > 1
    means = flat._make(flat._type, greedy.rows[first[moved]], (int(moved.sum()),))
    data[moved] = frame.to_world(means)._data
    status = None if flat._status is None else flat._status[first]
    objects = flat._make(flat._type, data, first.shape, status).astype(x.dtype)
    pairs = np.stack([kept, gone], -1).astype(np.int64)
    return MergeResult(objects, groups.reshape(x.shape), counts, costs, pairs, greedy.evaluations)


def _by_grade(
    entries: Sequence[Multivector], threshold: float, weights: Any, align: bool, progress: ProgressOption, *rest: Any
) -> MergeResult:
    """Each grade on its own."""
    if weights is not None and (not _is_list(weights) or len(weights) != len(entries)):
        raise InputError(f"weights for {len(entries)} batches of several grades are a list of {len(entries)} arrays.")
    found, groups = [], [np.zeros(x.shape, np.int64) for x in entries]
    origin, strict, threads, target = rest
    for grades in dict.fromkeys(x.grades for x in entries):
        own = [i for i, x in enumerate(entries) if x.grades == grades]
        parts = [_weights(None if weights is None else weights[i], entries[i].shape).ravel() for i in own]
        merged = merge_similar(
            concatenate_objects([entries[i] for i in own]), threshold, np.concatenate(parts), align, progress,
            origin=origin, strict=strict, threads=threads, target=target,
        )  # fmt: skip
        ends = np.cumsum([entries[i].size for i in own])
        for i, part in zip(own, np.split(merged.groups, ends[:-1]), strict=True):
            groups[i] = part.reshape(entries[i].shape)
        found.append(merged)
    fields = ("objects", "counts", "merge_costs", "pairs")
    objects, counts, merges, pairs = (tuple(getattr(m, name) for m in found) for name in fields)
    return MergeResult(objects, tuple(groups), counts, merges, pairs, sum(m.evaluations for m in found))
