"""Runs of batches of simulations, several at once: the same algorithm, in a program of its own."""

from __future__ import annotations

import hashlib
import json
from typing import NamedTuple

from ...algorithms.dynamics.records import CONSTANTS, CONSTANTS_OF_ROWS, work_records
from ...build import text_cache
from ...build.cpu_features import best_instances
from ...targets.c.source import ExtensionSource
from .. import extension_of
from ..algorithms import algorithm_files
from .config import DynamicsConfig

#: Methods that gain. A program of implicit steps compiles longer than it saves.
METHODS = ("chart", "rk4", "cf4", "midpoint", "composition", "adaptive", "taylor")
#: What each simulation has of its own, beside what the algorithm changes.
OWN = ("numbers", "bodies")


class WideRun(NamedTuple):
    """A run of several simulations at once.

    Attributes
    ----------
    source : ExtensionSource
        Its C text, ready to compile.
    tag : str
        Of its loop.
    numbers : int
        Of the work, integers included, that each simulation has there.
    """

    source: ExtensionSource
    tag: str
    numbers: int


def is_wide(needs: DynamicsConfig) -> bool:
    """Whether batches of simulations run several at once, where the processor has wide vectors."""
    return needs.method in METHODS and not needs.callbacks and not needs.tangents


def wide_run(needs: DynamicsConfig) -> WideRun | None:
    """The run of simulations for several at once; None: this processor gains nothing.

    Parameters
    ----------
    needs : DynamicsConfig
        Of which `is_wide` holds.
    """
    (instance,) = best_instances("f64")
    if not instance.wide:
        return None

    def make() -> str:
        from .dynamics import parts_with_series, simulation_algorithms_of

        run = simulation_algorithms_of(needs, of_items=True).entries.run.instance()
        shared = [p.name for p in run.parameters if p.access == "in" and p.name not in OWN]
        work = work_records(parts_with_series(needs, of_items=True)[0])
        constants = [name for name in (*CONSTANTS, *CONSTANTS_OF_ROWS, "held") if name in work.integers.offsets]
        extents = [work.integers.extent(name) for name in constants]
        still = {"p": [first + k for first, count in extents for k in range(count)]}
        files = algorithm_files(run, (instance,), shared, still=still)
        return json.dumps([files, work.whole.size + work.integers.size])

    sources = ("programs/dynamics/wide.py", "../templates/c/programs/algorithm.c.j2", f"specs/{needs.algebra}.toml")
    key = hashlib.sha256(repr(needs).encode()).hexdigest()
    files, numbers = json.loads(text_cache.made_once("dynamics_run", sources, f"{key}_{instance.tag}.json", make))
    source = extension_of(f"dynamics_run_{needs.algebra}_{needs.bodies}_{needs.method}", files)
    return WideRun(source, instance.tag, numbers)
