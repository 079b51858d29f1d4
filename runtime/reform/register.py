"""`register`: from two models to a pose, whatever their displacement."""

from __future__ import annotations

import math
from typing import Any

from .finish import finish
from .job import Job
from .result import Registration, Step
from .search import CHANCE, TOLERANCES, Found, Search

#: Rounds of iterative matching of a candidate, unless asked otherwise.
ROUNDS = 30


def register(
    query: Any, reference: Any, samples: int = 64, sample_size: int | None = None, iterations: int | None = None,
    seed: int = 0, threads: int | None = 2, backend: str = "c",
) -> Registration:  # fmt: skip
    """The motor that takes a query model to a reference, and which objects are one."""
    job = Job(query.objects, reference.objects, seed=seed, threads=threads, backend=backend)
    found = searched(job, samples, sample_size)
    return finish(job, found, iterations or ROUNDS, query.counts)


def searched(job: Job, samples: int, sample_size: int | None) -> Found:
    """The global start, at rising tolerances."""
    search = Search(
        job.scene, job.driver, job.query, job.reference, samples, sample_size, job.random, job.align, job.length
    )
    found = Found()
    for tolerance in TOLERANCES:
        found = search.run(tolerance, found)
        hits = int(found.hits[0]) if len(found.hits) else 0
        job.history.append(Step("search", tolerance, found.candidates, hits, math.nan))
        if found.doubt <= math.log10(CHANCE):
            break
    return found
