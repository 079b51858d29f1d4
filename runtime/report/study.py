"""What a study is: methods with a knob, cases with a reference, and a measure of error. Declarations only."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

Errors = NDArray[np.float64]
#: ordinary inputs; stiff ones (scales far apart); extreme ones (near a limit of the method); singular ones.
Nature = Literal["ordinary", "stiff", "extreme", "singular"]


@dataclass(frozen=True)
class Method:
    """One way to compute an answer, with a knob that trades time for error.

    Parameters
    ----------
    name : str
    run : callable
        ``run(inputs, setting)`` returns the answer for all items of a case: the call that is timed.
    knob : str
        What is turned, for the reader: "samples", "precision", ...
    settings : tuple
        Values of the knob, cheap first.
    slow : bool
        Left out of quick runs.
    copies : int, optional
        Where it differs from the study's: how many times each item is computed in one call.
    most : int, optional
        It takes long: of a case with more items it gets one with so many.
    repeats : int, optional
        Timings, where it takes long; with 0 the run that gives the answer is timed too.
    prepare : callable, optional
        Called once before all: imports and compiles what would else be timed.
    """

    name: str
    run: Callable[[Any, Any], Any]
    knob: str = ""
    settings: tuple[Any, ...] = (None,)
    slow: bool = False
    copies: int | None = None
    most: int | None = None
    repeats: int | None = None
    prepare: Callable[[], Any] | None = None


@dataclass(frozen=True)
class Case:
    """Inputs of one nature.

    Parameters
    ----------
    name : str
    make : callable
        ``make(rng, count)`` returns inputs; ``rng`` is a seeded `numpy.random.Generator`.
    nature : str
        "ordinary", "stiff", "extreme" or "singular".
    describe : callable
        ``describe(inputs, index)`` prints one item, for the worst error.
    sweep : tuple of str and float, optional
        What is varied, and its value here: cases of one sweep are drawn as a curve over it.
    """

    name: str
    make: Callable[[np.random.Generator, int], Any]
    nature: Nature = "ordinary"
    describe: Callable[[Any, int], str] = field(default=lambda inputs, index: f"item {index}")
    sweep: tuple[str, float] | None = None


def swept(
    what: str, values: Sequence[float], make: Callable[[float], Any], describe: Callable[[Any, int], str]
) -> tuple[Case, ...]:
    """One case for each value of what is varied; ``make(value)`` makes the maker of its inputs."""
    return tuple(Case(f"{what} {v:.3g}", make(v), "extreme", describe, (what, v)) for v in values)


@dataclass(frozen=True)
class Study:
    """Methods, cases, a reference of high precision, and an error measure.

    Parameters
    ----------
    name, title : str
    methods, cases : tuples
    reference : callable
        ``reference(inputs)``: the truth, from an independent computation of high precision.
    error : callable
        ``error(answer, truth, inputs)`` gives one error per item; infinite where an answer is lost or false.
    unit : str
        What the error is relative to.
    count : int
        Items per case (a tenth in a quick run).
    answer : callable
        ``answer(result, inputs, index)``: what came out, in words, shown for singular cases.
    copies : int
        How many times a method computes each item in one call: times are per computation.
    shares : bool
        Sweeps are drawn with the share of items that are not lost, above their errors.
    promised : float, optional
        The share of items that a method says will not be lost: the picture holds what is found against that.
    source : str
        Where the method comes from.
    """

    name: str
    title: str
    methods: tuple[Method, ...]
    cases: tuple[Case, ...]
    reference: Callable[[Any], Any]
    error: Callable[[Any, Any, Any], Errors]
    unit: str
    count: int = 200
    answer: Callable[[Any, Any, int], str] | None = None
    copies: int = 1
    shares: bool = False
    promised: float | None = None
    source: str = ""
    notes: str = ""
