"""Declarations of studies: methods with a parameter, cases with a reference, and a measure of error."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
Errors = NDArray[np.float64]
#: Precisions of kernels, as settings of a method.
PRECISIONS = ("float32", "float64")
#: Nature of inputs: ordinary, stiff (scales far apart), extreme (near a limit of the method), singular.
Nature = Literal["ordinary", "stiff", "extreme", "singular"]


@dataclass(frozen=True)
class Method:
    """A method to compute an answer, with a parameter that trades time for error.

    Parameters
    ----------
    name : str
    run : callable
        ``run(inputs, setting)`` returns the answer for all items of a case: the call that is timed.
    knob : str
        Name of the parameter, for the reader: "samples", "precision", "step", ...; of a number of things the plural.
    settings : tuple
        Values of the parameter, cheap first.
    slow : bool
        True if quick runs leave it out.
    copies : int, optional
        Number of computations of each item in one call, if it differs from the study's.
    most : int, optional
        Largest number of items, for methods that take long.
    repeats : int, optional
        Number of timings, for methods that take long; with 0 the run that gives the answer is timed.
    prepare : callable, optional
        Function that is called once before all runs: imports and compilation, which are not timed.
    requires : str, optional
        Package without which the method is left out.
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
    requires: str = ""


def setting_text(knob: str, setting: Any) -> str:
    """A setting with its name: "5 iterations", "step 0.001", "float32"; nothing for methods without one."""
    text = "" if setting is None else str(setting)
    if text in ("", *PRECISIONS):
        return text
    return f"{text} {knob}" if text.isdecimal() else f"{knob} {text}"


@dataclass(frozen=True)
class Case:
    """A case: inputs of one nature.

    Parameters
    ----------
    name : str
    make : callable
        ``make(rng, count)`` returns inputs; ``rng`` is a seeded `numpy.random.Generator`.
    nature : str
        "ordinary", "stiff", "extreme" or "singular".
    sweep : tuple of str and float, optional
        Varied quantity and its value: cases of one sweep are drawn as a curve over it.
    """

    name: str
    make: Callable[[np.random.Generator, int], Any]
    nature: Nature = "ordinary"
    sweep: tuple[str, float] | None = None


def sweep_cases(
    quantity: str, values: Sequence[float], make: Callable[[np.random.Generator, int, float], Any]
) -> tuple[Case, ...]:
    """One case for each value of a quantity; ``make(rng, count, value)`` returns its inputs."""

    def case(value: float) -> Case:
        inputs = lambda rng, count: make(rng, count, value)  # noqa: E731
        return Case(f"{quantity} {value:.3g}", inputs, "extreme", (quantity, value))

    return tuple(case(value) for value in values)


@dataclass(frozen=True)
class Study:
    """Methods, cases, a reference of high precision, and an error measure.

    Parameters
    ----------
    name, title : str
    methods, cases : tuples
    reference : callable
        ``reference(inputs)``: the exact result, from an independent computation of high precision.
    error : callable
        ``error(answer, truth, inputs)`` gives one error per item; infinite where an answer is lost or false.
    unit : str
        Unit of the error.
    count : int
        Items per case (a tenth in a quick run).
    describe : callable
        ``describe(inputs, index)`` prints one item, for the worst error.
    answer : callable
        ``answer(result, inputs, index)``: description of a result, printed for singular cases.
    copies : int
        Number of computations of each item in one call: times are per computation.
    draws_fractions : bool
        True if sweeps are drawn with the fraction of items that are not lost, above their errors.
    promised : float, optional
        Fraction of items that should not be lost according to the method: the picture compares it with the results.
    source : str
        Source of the method.
    """

    name: str
    title: str
    methods: tuple[Method, ...]
    cases: tuple[Case, ...]
    reference: Callable[[Any], Any]
    error: Callable[[Any, Any, Any], Errors]
    unit: str
    count: int = 200
    describe: Callable[[Any, int], str] = lambda inputs, index: f"item {index}"
    answer: Callable[[Any, Any, int], str] | None = None
    copies: int = 1
    draws_fractions: bool = False
    promised: float | None = None
    source: str = ""
    notes: str = ""

    @property
    def missing_packages(self) -> list[str]:
        """Packages that are not installed: methods that require them are left out."""
        return sorted({m.requires for m in self.methods if m.requires and find_spec(m.requires) is None})


@cache
def optional_module(name: str) -> Any:
    """The module, or None if it or a system library that it needs is missing."""
    try:
        return import_module(name)
    except (ImportError, OSError):
        return None


def on_copies(run: Callable[[Any, Any], Array], copies: int) -> Callable[[Any, Any], Array]:
    """A method on copies of its inputs, a dataclass of arrays (n, ...); the answers of the first."""

    def run_copies(inputs: Any, setting: Any) -> Array:
        arrays = {f.name: getattr(inputs, f.name) for f in fields(inputs)}
        many = replace(inputs, **{name: np.concatenate([a] * copies) for name, a in arrays.items()})
        return run(many, setting)[: len(next(iter(arrays.values())))]

    return run_copies


def errors_by_item(error: Callable[[Any, Any], float], answer: Array, truth: Sequence[Any]) -> Errors:
    """Error of each row of an answer against its truth; infinite where the row is not finite."""
    pairs = zip(answer, truth, strict=True)
    return np.array([error(row, true) if np.isfinite(row).all() else np.inf for row, true in pairs])


def lost_beyond(errors: Array, limit: float) -> Errors:
    """Errors, infinite from a limit on and where they are NaN."""
    return np.where(errors < limit, errors, np.inf)
