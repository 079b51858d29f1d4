"""Runner of studies: one reference per case, every method at every setting, the largest error with its input."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...codegen.interrupts import keep_partial
from ...common.progress import ProgressOption, open_progress
from .study import Case, Method, Study, optional_module, setting_text

#: Seed of all inputs.
SEED = 20260101
#: Number of timings, of which the least counts.
REPEATS = 5
#: The same in quick runs.
QUICK_REPEATS = 3
#: Shortest timing, so that the clock's resolution does not matter.
MIN_SECONDS = 0.02
#: Memory that is freed once before timing: the C library then reuses the memory of arrays, and times contain no page
#: faults (some 100 ns per item of a batch otherwise).
HEAP_BYTES = 16 * 2**20
#: Cases of a sweep have this many times fewer items: there are many of them.
SWEEP_DIVISOR = 4
#: Units of time, in nanoseconds, the smallest first.
UNITS = (("ns", 1.0), ("us", 1e3), ("ms", 1e6), ("s", 1e9))


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

    @property
    def setting_text(self) -> str:
        """The setting with its name."""
        return setting_text(self.knob, self.setting)


def run_study(study: Study, quick: bool = False, progress: ProgressOption = False) -> list[Measurement]:
    """Run every method on every case.

    Parameters
    ----------
    study : Study
    quick : bool
        A tenth of the items and fewer timings: for demonstrations and tests.
    progress : bool or callable
        True: a bar on standard error. A callable gets a `bladesmith.Progress` of runs.

    Raises
    ------
    Interrupted
        On an interrupt; its ``partial`` are the measurements until then.
    """
    methods = [m for m in study.methods if not (quick and m.slow) and (not m.requires or optional_module(m.requires))]
    total = len(study.cases) * sum(len(m.settings) for m in methods)
    done, rows = 0, list[Measurement]()
    for method in methods:
        if method.prepare is not None:
            method.prepare()
    with open_progress(progress, study.name, "runs", total) as report, keep_partial(lambda: rows):
        for number, case in enumerate(study.cases):
            count = max(study.count // (SWEEP_DIVISOR if case.sweep else 1) // (10 if quick else 1), 10)
            inputs_by_count: dict[int, tuple[Any, Any]] = {}
            for method in methods:
                items = min(count, method.most or count)
                if items not in inputs_by_count:
                    inputs = case.make(np.random.default_rng([SEED, number]), items)
                    inputs_by_count[items] = inputs, study.reference(inputs)
                for setting in method.settings:
                    named = setting_text(method.knob, setting)
                    report(done, ", ".join(part for part in (case.name, method.name, named) if part))
                    row = _measure(study, case, method, setting, *inputs_by_count[items], items, quick)
                    rows += [] if row is None else [row]
                    done += 1
        report(total)
    return rows


def _measure(
    study: Study, case: Case, method: Method, setting: Any, inputs: Any, truth: Any, count: int, quick: bool
) -> Measurement | None:
    """Measure a method on a case; None if the method does not apply to it."""
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
        study.describe(inputs, worst) if worst >= 0 else "",
        int(lost.size),
        study.describe(inputs, int(lost[0])) if lost.size else "",
        seconds / (count * (method.copies or study.copies)) * 1e9,
        answer,
        *(case.sweep or ()),
    )


def _time(call: Callable[[], Any], repeats: int) -> float:
    """Seconds of one call: the least of several rounds, each long enough to be measured."""
    np.empty(HEAP_BYTES, np.uint8)
    start = time.perf_counter()
    call()
    once = max(time.perf_counter() - start, 1e-7)
    rounds = max(1, int(MIN_SECONDS / once))
    best = once
    for _ in range(repeats):
        start = time.perf_counter()
        for _ in range(rounds):
            call()
        best = min(best, (time.perf_counter() - start) / rounds)
    return best


def time_unit(nanoseconds: Sequence[float]) -> tuple[str, float]:
    """Name and size (in nanoseconds) of the unit in which the median of some times is 1 or more."""
    middle = sorted(nanoseconds)[len(nanoseconds) // 2]
    return max((unit for unit in UNITS if unit[1] <= middle), key=lambda unit: unit[1], default=UNITS[0])


def time_text(nanoseconds: float) -> str:
    """Text of a time in a unit of its size."""
    name, unit = time_unit([nanoseconds])
    return f"{nanoseconds / unit:.3g} {name}"


def duration_text(seconds: float) -> str:
    """Rounded text of a duration: 40 s, 12 min."""
    return f"{max(round(seconds / 5) * 5, 5)} s" if seconds < 100 else f"{round(seconds / 60)} min"
