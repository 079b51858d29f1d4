"""Runs studies: one reference per case, every method at every setting, the largest error with its input."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from .study import Case, Method, Study

SEED = 20260101
#: A timing is the least of several; each lasts at least this long, so that the clock's step does not matter.
REPEATS, QUICK_REPEATS, LEAST_SECONDS = 5, 3, 0.02
#: Memory that is freed once before timing: the C library then keeps what arrays give back, and times hold no page
#: faults (some 100 ns per item of a batch otherwise).
KEPT_BYTES = 16 * 2**20
#: Cases of a sweep have this many times fewer items: there are many of them.
SWEPT = 4
#: Units of time, in nanoseconds, the smallest first.
UNITS = (("ns", 1.0), ("us", 1e3), ("ms", 1e6), ("s", 1e9))
Progress = Callable[[int, int, str], None]


@dataclass(frozen=True)
class Measurement:
    """One method at one setting on one case.

    ``max_error`` and ``worst`` are over all items with a finite error; ``lost`` counts the others (an answer that
    is missing, false or not finite). No item is left out.
    """

    method: str
    knob: str
    setting: str
    case: str
    nature: str
    count: int
    max_error: float
    worst: str
    lost: int
    first_lost: str
    nanoseconds: float
    answer: str
    sweep: str = ""
    value: float | None = None


def run_study(study: Study, quick: bool = False, progress: Progress | None = None) -> list[Measurement]:
    """Run every method on every case.

    Parameters
    ----------
    study : Study
    quick : bool
        A tenth of the items and fewer timings: for demonstrations and tests.
    progress : callable, optional
        ``progress(done, total, text)``.
    """
    methods = [m for m in study.methods if not (quick and m.slow)]
    total = len(study.cases) * sum(len(m.settings) for m in methods)
    done, rows = 0, []
    for method in methods:
        if method.prepare is not None:
            method.prepare()
    for number, case in enumerate(study.cases):
        count = max(study.count // (SWEPT if case.sweep else 1) // (10 if quick else 1), 10)
        made: dict[int, tuple[Any, Any]] = {}
        for method in methods:
            items = min(count, method.most or count)
            if items not in made:
                inputs = case.make(np.random.default_rng([SEED, number]), items)
                made[items] = inputs, study.reference(inputs)
            for setting in method.settings:
                if progress:
                    progress(done, total, f"{study.name}: {case.name}, {method.name} {setting or ''}")
                row = _measure(study, case, method, setting, *made[items], items, quick)
                rows += [] if row is None else [row]
                done += 1
    if progress:
        progress(total, total, study.name)
    return rows


def _measure(
    study: Study, case: Case, method: Method, setting: Any, inputs: Any, truth: Any, count: int, quick: bool
) -> Measurement | None:
    """None where the method says that it is not made for this case."""
    start = time.perf_counter()
    result = method.run(inputs, setting)
    seconds = time.perf_counter() - start
    if result is None:
        return None
    if method.repeats != 0:
        repeats = QUICK_REPEATS if quick else REPEATS
        seconds = _time(lambda: method.run(inputs, setting), min(repeats, method.repeats or repeats))
    errors = np.asarray(study.error(result, truth, inputs), float)
    finite = np.isfinite(errors)
    worst = int(np.argmax(np.where(finite, errors, -1.0))) if finite.any() else -1
    lost = np.flatnonzero(~finite)
    answer = ""
    if study.answer is not None and case.nature == "singular":
        answer = study.answer(result, inputs, worst if worst >= 0 else 0)
    return Measurement(
        method.name,
        method.knob,
        "" if setting is None else str(setting),
        case.name,
        case.nature,
        count,
        float(errors[worst]) if worst >= 0 else float("nan"),
        case.describe(inputs, worst) if worst >= 0 else "",
        int(lost.size),
        case.describe(inputs, int(lost[0])) if lost.size else "",
        seconds / (count * (method.copies or study.copies)) * 1e9,
        answer,
        *(case.sweep or ()),
    )


def _time(call: Callable[[], Any], repeats: int) -> float:
    """Seconds of one call: the least of several rounds, each long enough to be measured."""
    np.empty(KEPT_BYTES, np.uint8)
    start = time.perf_counter()
    call()
    once = max(time.perf_counter() - start, 1e-7)
    rounds = max(1, int(LEAST_SECONDS / once))
    best = once
    for _ in range(repeats):
        start = time.perf_counter()
        for _ in range(rounds):
            call()
        best = min(best, (time.perf_counter() - start) / rounds)
    return best


def time_unit(nanoseconds: Sequence[float]) -> tuple[str, float]:
    """Name and size (in nanoseconds) of the unit in which the middle one of some times is 1 or more."""
    middle = sorted(nanoseconds)[len(nanoseconds) // 2]
    return max((unit for unit in UNITS if unit[1] <= middle), key=lambda unit: unit[1], default=UNITS[0])


def time_text(nanoseconds: float) -> str:
    """A time in words, in the unit that suits it."""
    name, unit = time_unit([nanoseconds])
    return f"{nanoseconds / unit:.3g} {name}"
