"""`register`: the pose of one model in another one, from any displacement."""

from __future__ import annotations

from concurrent.futures import Executor
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from ...codegen.errors import InputError
from ...codegen.interrupts import keep_partial
from ...common.progress import ProgressOption, open_progress
from ...common.validation import as_bool, as_choice, as_instance, as_int
from ...core.multivector import Multivector
from ..estimation.objective import LOSSES, check_uncertainties
from ..model.arguments import as_length, as_motor, check_common_kind
from ..model.model import Model
from ..result import Registration
from ..verification.alternatives import search_globally
from ..verification.assemble_result import assemble_result
from ..verification.cross_check import cross_check_with_global_search
from .interrupted import interrupted_result
from .problem import RegistrationProblem
from .ransac import ransac_search
from .scale import register_similarity
from .size_ratio import compare_sizes

#: Default number of rounds of iterative matching of a candidate.
ROUNDS = 30
#: Largest number of minimal sets.
MAX_SAMPLES = 1 << 20
#: Largest number of objects of a minimal set.
MAX_SAMPLE_SIZE = 64
#: Names of starts.
STARTS = ("global", "proximity")


def register(
    query: Model,
    reference: Model,
    samples: int = 64,
    sample_size: int | None = None,
    iterations: int | None = None,
    seed: int = 0,
    threads: int | None = None,
    backend: str = "c",
    *,
    start: str | Multivector | ArrayLike = "global",
    align: bool = True,
    length: float = 1.0,
    similarity: bool = False,
    loss: str = "linear",
    executor: Executor | None = None,
    progress: ProgressOption = False,
) -> Registration:
    """The motor that takes a query model to a reference, and the matches of their objects (thesis chapter 5).

    Parameters
    ----------
    query, reference : Model
        Models of any kinds of objects; kinds that only one of them has are ignored.
    samples : int
        Largest number of minimal sets of query objects that vote at each tolerance. With ``start="proximity"``: subsets
        of the matches in each round (5.5).
    sample_size : int, optional
        Objects of a minimal set. Default: two where these determine a motor, else three.
    iterations : int, optional
        Largest number of rounds of iterative matching (5.4) of each candidate. Default: 30.
    seed : int
        Seed of the random choices: the same seed gives the same result, with any number of threads, with an executor,
        and with any backend.
    threads : int, optional
        Default: the package's (`bladesmith.set_threads`); with an executor those of each worker, one by default.
    backend : "c", "numba" or "cuda"
        Implementation of the compiled stages.
    start : "global", "proximity", Multivector or array (4, 4)
        "global": from any displacement, by invariants of motions. "proximity": REFORM as in the text (5.5), from the
        present pose of the query, or from the pose that is given here: a motor of cga3d or pga3d, or a matrix.
    align : bool
        True if x and -x are the same object. Otherwise orientations must agree.
    length : float
        Length that a rotation by one radian is equivalent to, in units of the models' size.
    similarity : bool
        The reference may be larger or smaller than the query: the result's ``scale`` s is estimated too, and a point x
        goes to motor (s x), scaled about the world's origin. By any factor: units of length may differ.
    loss : "linear", "huber", "soft_l1", "cauchy" or "tukey"
        What the refinement of the pose minimizes over the matches: their costs, or a robust loss of them, as in
        `scipy.optimize.least_squares` ("tukey": the biweight). Its scale is the standard deviation that covariances
        give, or the one estimated from the median of the costs, times the factor of 95 % efficiency.
    executor : concurrent.futures.Executor, optional
        Executor over whose workers the samples are shared, for example a cluster's.
    progress : bool or callable
        True: a bar on standard error. A callable gets a `bladesmith.Progress` after each block of motors, whose
        ``detail`` is a `Step`.

    Returns
    -------
    Registration
        The pose. If no pose is found: the best one, with ``converged`` False and a ``message``.

    Raises
    ------
    InputError
        If a model is empty, the models have no kind in common, or an argument is invalid.
    UndeterminedError
        If no pose is found because the objects leave a motion free: the error describes the motions and holds them as
        ``motions``.
    ExecutorError
        If workers of the executor fail or end, and do so again.
    Interrupted
        On an interrupt. As that of an `ExecutorError`, its ``partial`` is the best result so far.

    Notes
    -----
    Pairs of objects have invariants of motions: distances, angles. Pairs of the query vote for the pairs of the
    reference with the same invariants; where a pair leaves a motion free, triples do. The motor of each such sample
    minimizes ``|R X - Y R|^2`` over its pairs, linear in R for every kind of object; it is verified by the number of
    objects that it matches. Tolerances rise from rounding to 3 % of the models' size, until a pose is significant. The
    best motors are refined by iterative matching, and the result minimizes the positive rotor cost over the matches:
    of segments the squared distances of their ends from the lines of their counterparts, and along these where both
    ends are there; of objects with covariances the squares of their residuals over their variances.

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
    length = as_length(length)
    register_motion = partial(
        _register_motion, reference=reference, samples=samples, sample_size=sample_size, iterations=iterations,
        seed=seed, threads=threads, backend=backend, start=start, align=align, length=length, loss=loss,
        executor=executor, progress=progress,
    )  # fmt: skip
    if as_bool(similarity, "similarity"):
        return register_similarity(query, reference, register_motion, length)
    return register_motion(query, compares_sizes=True)


def _register_motion(
    query: Model, reference: Model, samples: int, sample_size: int | None, iterations: int | None, seed: int,
    threads: int | None, backend: str, start: str | Multivector | ArrayLike, align: bool, length: float, loss: str,
    executor: Executor | None, progress: ProgressOption, compares_sizes: bool = False,
) -> Registration:  # fmt: skip
    """`register` without a scale."""
    samples = as_int(samples, "samples", high=MAX_SAMPLES)
    sample_size = None if sample_size is None else as_int(sample_size, "sample_size", high=MAX_SAMPLE_SIZE)
    rounds = ROUNDS if iterations is None else as_int(iterations, "iterations", high=MAX_SAMPLES)
    motor = as_motor(start, "start") if isinstance(start, Multivector | np.ndarray | list | tuple) else None
    from_nearby = motor is not None or as_choice(start, "start", STARTS) == "proximity"
    problem = RegistrationProblem(
        query, reference, seed=as_int(seed, "seed", 0), threads=threads, backend=backend,
        executor=executor, align=as_bool(align, "align"), length=length, loss=as_choice(loss, "loss", LOSSES),
    )  # fmt: skip
    with (
        open_progress(progress, "register", "motors") as report,
        keep_partial(lambda: interrupted_result(problem, query.counts)),
    ):
        problem.progress = lambda step: report(step.candidates, step)

        def find() -> Registration:
            if not from_nearby:
                problem.best = search_globally(problem, samples, sample_size)
                return assemble_result(problem, problem.best, rounds, query.counts)
            problem.best = ransac_search(problem, samples, sample_size, iterations and rounds, motor)
            return cross_check_with_global_search(problem, assemble_result(problem, problem.best, ROUNDS, query.counts))

        return compare_sizes(problem, find) if compares_sizes else find()


def _check_models(query: Model, reference: Model) -> None:
    for name, model in (("query", query), ("reference", reference)):
        if not len(as_instance(model, f"the {name}", Model, "a reform.Model")):
            raise InputError(f"the {name} is empty; a pose needs objects.")
    check_common_kind(query, reference)
    check_uncertainties(query, reference)
