"""A batch of simulations in parts over the workers of an executor: threads, processes, a cluster; the same bits."""

from __future__ import annotations

import os
from concurrent.futures import Executor
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.errors import InputError
from . import engine
from .starts import check_start

if TYPE_CHECKING:
    from .simulation import Simulation

Array = NDArray[Any]
#: Arrays of a run that workers send back.
RESULTS = ("motors", "twists", "reactions", "violations", "status", "reached", "steps", "stored", "start", "start_rows")
#: Parts for each worker, so that none waits long for another.
PARTS = 4


def run_part(
    simulation: Simulation, times: Array, settings: tuple[float, float, float | None, float | None], project: bool,
    begin: int, end: int,
) -> dict[str, Array]:  # fmt: skip
    """Simulations begin to end - 1 of a batch; what a worker does."""
    from .simulation import start_of

    made, method = simulation._prepared(*settings)
    driver = simulation._driver(made, method, slice(begin, end))
    motors, twists = simulation._projected(made, settings[0]) if project else start_of(made)
    run = engine.Run(driver, times, motors[begin:end], twists[begin:end], 1, project)
    run.to(len(times))
    driver.raise_error()
    return {name: getattr(run, name) for name in RESULTS}


def shared(
    simulation: Simulation, driver: engine.Driver, times: Array,
    settings: tuple[float, float, float | None, float | None], project: bool, executor: Executor,
) -> engine.Run:  # fmt: skip
    """A run whose results come from the workers of an executor.

    Raises
    ------
    InputError
        If it is no open executor, or the simulation cannot be sent.
    """
    if not isinstance(executor, Executor) and not hasattr(executor, "submit"):
        raise InputError(
            f"the executor is a {type(executor).__name__}; a concurrent.futures.Executor is needed.",
        )
    if driver.made.called.functions:
        raise InputError("functions of time or state stay in this process; run without an executor.")
    workers = getattr(executor, "_max_workers", None) or os.cpu_count() or 1
    bounds = np.linspace(0, driver.size, min(driver.size, PARTS * workers) + 1).astype(int)
    try:
        futures = [
            executor.submit(run_part, simulation, times, settings, project, int(a), int(b))
            for a, b in zip(bounds[:-1], bounds[1:], strict=True)
        ]
    except RuntimeError as error:
        raise InputError(f"the executor takes no work: {error}") from error
    parts = [future.result() for future in futures]
    run = engine.Run.__new__(engine.Run)
    run.driver, run.times = driver, np.ascontiguousarray(times)
    for name in RESULTS:
        setattr(run, name, np.concatenate([part[name] for part in parts]))
    check_start(run, project)
    return run
