"""Batches of tops one at a time and several at once on vector lanes: the same errors, against run time."""

from __future__ import annotations

from functools import partial
from typing import Any

from ....dynamics.integration.driver import WIDE_BATCH
from ...harness.study import Case, Method
from . import integrators
from .tops import COUNT, CUBOID, free, heavy

#: How often each motion is computed at once: fewer bodies than are put on lanes together, and many more.
ONE_AT_A_TIME, ON_LANES = (WIDE_BATCH - 1) // COUNT, 8 * WIDE_BATCH // COUNT
#: Integrators, what is set of them, and to what.
INTEGRATORS: dict[str, tuple[str, tuple[Any, ...]]] = {
    "rk4": ("steps", (250, 1000, 4000)),
    "cf4": ("steps", (250, 1000)),
    "adaptive": ("tolerance", (1e-5, 1e-8, 1e-11)),
    "taylor": ("tolerance", (1e-5, 1e-8, 1e-11)),
}


def pairs() -> tuple[Method, ...]:
    """Each integrator one at a time, and on lanes."""
    return tuple(
        Method(f"{name}, {how}", partial(integrators.integrate, integrator=name, copies=copies), knob, settings,
               most=COUNT, repeats=3, copies=copies)
        for name, (knob, settings) in INTEGRATORS.items()
        for how, copies in (("one at a time", ONE_AT_A_TIME), ("on lanes", ON_LANES))
    )  # fmt: skip


STUDY = integrators.study(
    name="lanes",
    title="Batches of tops one at a time and on lanes",
    methods=pairs(),
    cases=(
        Case("free, no two moments equal, t = 20", partial(free, moments=CUBOID, spin=(1.5, 1.0, 2.0), duration=20.0)),
        Case(
            "heavy, no symmetry, t = 3",
            partial(heavy, moments=(0.1, 0.2, 0.25), spin=(1.0, 5.0, 2.0), arm=(0.1, 0.2, 0.3)),
        ),
    ),
    count=COUNT,
    source="docs/algebra/algorithms.md, several items at once",
    notes=f"A point is a motion. Batches of fewer than {WIDE_BATCH} bodies run one at a time, larger ones several "
    "at once, as many as a vector has lanes; the states are the same bits, and so the errors are equal.",
)
