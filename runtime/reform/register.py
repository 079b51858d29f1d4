"""`register`: from two models to a pose, whatever their displacement."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any

from ..arrays import truth
from ..codegen.errors import InputError
from ..multivector import Multivector
from ..objects.inputs import chosen
from .challenge import challenged
from .finish import finish
from .given import as_motor, check_common, count, positive
from .job import Job
from .model import Model
from .progress import told
from .result import Registration, Step
from .rivals import looked_again
from .sampling import sampled
from .scale import similar
from .search import CHANCE, TOLERANCES, Found, Search
from .unfinished import unfinished

#: Rounds of iterative matching of a candidate, unless asked otherwise.
ROUNDS = 30
#: More sets than any search can use, and more objects than any set needs.
MOST_SAMPLES, MOST_SIZE = 1 << 20, 64
STARTS = ("global", "proximity")


def register(
    query: Model,
    reference: Model,
    samples: int = 64,
    sample_size: int | None = None,
    iterations: int | None = None,
    seed: int = 0,
    threads: int | None = 2,
    backend: str = "c",
    *,
    start: str | Multivector = "global",
    align: bool = True,
    length: float = 1.0,
    similarity: bool = False,
    executor: Any = None,
    progress: bool | Callable[[Step], None] = False,
) -> Registration:
    """The motor that takes a query model to a reference, and which objects are one (thesis chapter 5).

    Parameters
    ----------
    query, reference : Model
        Of any kinds; those that only one of them has take no part.
    samples : int
        Sets of query objects that vote, at each tolerance and at most. With ``start="proximity"``: subsets of the
        matches in each round (5.5).
    sample_size : int, optional
        Objects of a set. Default: two where that places a motor, else three.
    iterations : int, optional
        Rounds of iterative matching (5.4) of each candidate, at most. Default: 30.
    seed : int
        Of the random choices: the same seed gives the same result, with any number of threads, with an executor, and
        with any backend.
    threads : int or None
        None: all processors of this process.
    backend : "c", "numba" or "cuda"
        What computes.
    start : "global", "proximity" or Multivector
        "global": from any displacement, by what no motion changes. "proximity": REFORM as in the text (5.5), from the
        query where it stands, or moved by a motor that is given here.
    align : bool
        x and -x are one object. Otherwise orientations must agree.
    length : float
        What a rotation by a radian counts as, against translations, in units of the models' size.
    similarity : bool
        The reference may be larger or smaller than the query: the result's ``scale`` s is found too, and a point x goes
        to motor (s x), scaled about the world's origin.
    executor : concurrent.futures.Executor, optional
        Shares the samples over its workers, for example a cluster's.
    progress : bool or callable
        Show a bar; or call a function with a `Step` after each block of motors.

    Returns
    -------
    Registration
        If nothing is found, or an interrupt comes before the end: the best so far, with ``converged`` False and a
        ``message``.

    Raises
    ------
    InputError
        If a model is empty, the models have no kind in common, or an argument makes no sense.
    UndeterminedError
        If nothing is found because the objects leave a motion free: it names the motions, and has them as ``motions``.

    Notes
    -----
    Pairs of objects have numbers that no motion changes: distances, angles. Pairs of the query vote for the pairs of
    the reference with the same ones; where a pair leaves a motion free, triples. The motor of each such sample is that
    of the least |R X - Y R|^2 over its pairs, linear in R for every kind of object; it is verified by how many objects
    it lays on others. Tolerances rise from rounding to 3 % of the models' size, until the agreement is no chance. The
    best motors are refined by iterative matching, and the answer is that of the least positive rotor cost over the
    matches.

    Examples
    --------
    >>> import bladesmith as bs
    >>> from bladesmith import reform
    >>> lines = bs.cga3d.line([(0, 0, 0), (1, 0, 0), (0, 2, 0)], [(1, 0, 1), (0, 1, 0), (0, 1, 3)])
    >>> pose = bs.cga3d.rotor((0, 0, 1), 2.0)
    >>> found = reform.register(reform.Model(lines=pose >> lines), reform.Model(lines=lines))
    >>> found.converged, found.matches["lines"].tolist()
    (True, [0, 1, 2])
    >>> abs((found.motor * pose - 1).values).max() < 1e-12
    True
    """
    _check_models(query, reference)
    if truth(similarity, "similarity"):
        same = partial(
            register, reference=reference, samples=samples, sample_size=sample_size, iterations=iterations, seed=seed,
            threads=threads, backend=backend, start=start, align=align, length=length, executor=executor,
            progress=progress,
        )  # fmt: skip
        return similar(query, reference, same)
    samples = count(samples, "samples", most=MOST_SAMPLES)
    sample_size = None if sample_size is None else count(sample_size, "sample_size", most=MOST_SIZE)
    rounds = ROUNDS if iterations is None else count(iterations, "iterations", most=MOST_SAMPLES)
    motor = as_motor(start, "start") if isinstance(start, Multivector) else None
    near = motor is not None or chosen(start, STARTS, "start") == "proximity"
    length = positive(length, "length")
    job = Job(
        query.objects, reference.objects, seed=count(seed, "seed", 0), threads=threads, backend=backend,
        executor=executor, align=truth(align, "align"), length=length,
    )  # fmt: skip
    with told(progress) as job.progress:
        try:
            if not near:
                job.found = searched(job, samples, sample_size)
                return finish(job, job.found, rounds, query.counts)
            job.found = sampled(job, samples, sample_size, iterations and rounds, motor)
            return challenged(job, finish(job, job.found, ROUNDS, query.counts))
        except KeyboardInterrupt:
            return unfinished(job, query.counts)


def _check_models(query: Model, reference: Model) -> None:
    for name, model in (("query", query), ("reference", reference)):
        if not isinstance(model, Model):
            raise InputError(f"the {name} is {type(model).__name__}; a reform.Model is needed.")
        if not len(model):
            raise InputError(f"the {name} is empty; a pose needs objects.")
    check_common(query, reference)


def searched(job: Job, samples: int, sample_size: int | None) -> Found:
    """The global start, at rising tolerances."""
    search = Search(
        job.scene, job.driver, job.query, job.reference, samples, sample_size, job.random, job.align, job.length
    )
    search.tell = job.tell
    found = Found()
    for tolerance in TOLERANCES:
        found = search.run(tolerance, found)
        hits = int(found.hits[0]) if len(found.hits) else 0
        job.history.append(Step("search", tolerance, found.candidates, hits, math.nan))
        if found.doubt <= math.log10(CHANCE):
            break
    return looked_again(job, search, found)
