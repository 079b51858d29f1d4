"""A batch of simulations in parts over the workers of an executor: threads, processes, a cluster; the same bits."""

from __future__ import annotations

import os
from concurrent.futures import Executor
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.errors import BladesmithError, InputError
from . import engine
from .functions import reason
from .given import shown
from .starts import check_start

if TYPE_CHECKING:
    from .simulation import Simulation

Array = NDArray[Any]
#: Arrays of a run that workers send back.
RESULTS = (
    "motors", "twists", "reactions", "violations", "status", "reached", "steps", "stored", "start", "start_rows", "off",
)  # fmt: skip
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


def check_executor(executor: Any) -> None:
    """Raise `InputError` for what is no executor."""
    if isinstance(executor, type) or not (isinstance(executor, Executor) or hasattr(executor, "submit")):
        raise InputError(
            f"the executor is {shown(executor)}; a concurrent.futures.Executor is needed.",
            remedy="Make one, with ThreadPoolExecutor() or ProcessPoolExecutor()",
        )


def shared(
    simulation: Simulation, driver: engine.Driver, times: Array,
    settings: tuple[float, float, float | None, float | None], project: bool, executor: Executor,
) -> engine.Run:  # fmt: skip
    """A run whose results come from the workers of an executor.

    Raises
    ------
    InputError
        If the executor is closed or breaks, or the simulation cannot be sent.
    """
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
    try:
        parts = [future.result() for future in futures]
    except BladesmithError:
        raise
    except Exception as error:  # of a pool that broke, or of what cannot be sent
        raise InputError(
            f"the workers of the executor failed: {reason(error)}.", remedy="Run without an executor"
        ) from error
    run = engine.Run.__new__(engine.Run)
    run.driver, run.times = driver, np.ascontiguousarray(times)
    for name in RESULTS:
        setattr(run, name, np.concatenate([part[name] for part in parts]))
    check_start(run, project)
    return run
