"""Runs of batches of simulations, several at once: the same algorithm, in a program of its own."""

from __future__ import annotations

import hashlib
import json

from ...algorithms.dynamics.records import CONSTANTS, work_records
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


def is_wide(needs: DynamicsConfig) -> bool:
    """Whether batches of simulations run several at once, where the processor has wide vectors.

    Not with constraints, unless they are pins that leave a group of motions: how many equations hold differs between
    simulations, and with it the path.
    """
    return needs.mode in ("free", "subspace") and needs.method in METHODS and not needs.callbacks and not needs.tangents


def wide_run(needs: DynamicsConfig) -> tuple[ExtensionSource, str] | None:
    """C text of the run of simulations, ready to compile, and the tag of its loop; None: this processor gains nothing.

    Parameters
    ----------
    needs : DynamicsConfig
        Of which `is_wide` holds.
    """
    (instance,) = best_instances("f64")
    if not instance.wide:
        return None

    def make() -> str:
        from .dynamics import simulation_algorithms_of, simulation_parts

        run = simulation_algorithms_of(needs, of_items=True).entries.run.instance()
        shared = [p.name for p in run.parameters if p.access == "in" and p.name not in OWN]
        integers = work_records(simulation_parts(needs)).integers
        still = {"p": [integers.offsets[name] for name in CONSTANTS]}
        return json.dumps(algorithm_files(run, (instance,), shared, still))

    sources = ("programs/dynamics/wide.py", "../templates/c/programs/algorithm.c.j2", f"specs/{needs.algebra}.toml")
    key = hashlib.sha256(repr(needs).encode()).hexdigest()
    text = text_cache.made_once("dynamics_run", sources, f"{key}_{instance.tag}.json", make)
    return extension_of(f"dynamics_run_{needs.algebra}_{needs.bodies}_{needs.method}", json.loads(text)), instance.tag
