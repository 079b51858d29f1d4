"""Progress of long work: a bar, a user's function, or nothing."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from .errors import InputError, one_line
from .interrupts import deferred_interrupts

#: Seconds before a bar is shown: most work ends earlier.
PATIENCE = 0.3
#: Form of bars of what is measured, not counted.
MEASURED = "{desc}: {percentage:3.0f}%|{bar}| {n:.4g}/{total:.4g}{unit} [{elapsed}<{remaining}]"


@dataclass(frozen=True)
class Progress:
    """How far long work has come.

    Attributes
    ----------
    done : int or float
        What is done.
    total : int or float, optional
        What is to be done, at most; None if that is not known.
    unit : str
        What is counted: "pixels", "iterations"; or measured: "s".
    detail : object
        What is at work, or the state of it: text, or an object that has more to say, such as a step of a registration.
    """

    done: float
    total: float | None = None
    unit: str = ""
    detail: Any = ""


#: The option ``progress=`` of functions: False, True for a bar on standard error, or a function.
ProgressOption = bool | Callable[[Progress], Any]


class Report(Protocol):
    """Function that reports what is done."""

    def __call__(self, done: float, detail: Any = "", /) -> None: ...


def open_progress(
    option: Any, title: str, unit: str, total: float | None = None
) -> AbstractContextManager[Report]:
    """Report the progress of a job as the option ``progress=`` says.

    Parameters
    ----------
    option : bool or callable
        True: a bar on standard error. A callable gets a `Progress`.
    title : str
        Title of the bar.
    unit, total
        Those of each `Progress`.

    Raises
    ------
    InputError
        If the option is neither.
    """
    return _SILENT if option is False else _open(option, title, unit, total)


@contextmanager
def _open(option: Any, title: str, unit: str, total: float | None) -> Iterator[Report]:
    if callable(option) and not isinstance(option, type):

        def report(done: float, detail: Any = "", /) -> None:
            option(Progress(done, total, unit, detail))

        yield report
    elif not isinstance(option, bool | np.bool_ | None):
        raise InputError(f"progress is {one_line(option)}; it is True, False or a function of one bladesmith.Progress.")
    elif not option:
        yield lambda done, detail="": None
    else:
        with progress_bar(title) as show:
            yield lambda done, detail="": show(Progress(done, total, unit, detail))


def _nothing(done: float, detail: Any = "", /) -> None:
    """Report nothing."""


_SILENT: AbstractContextManager[Report] = nullcontext(_nothing)


@contextmanager
def progress_bar(title: str) -> Iterator[Callable[[Progress], None]]:
    """Function that shows each `Progress` in a bar on standard error."""
    from tqdm import tqdm

    with deferred_interrupts():  # it takes locks
        bar = tqdm(desc=title, unit_scale=True, delay=PATIENCE, leave=False)

    def show(progress: Progress) -> None:
        if isinstance(progress.total, float):
            bar.bar_format = MEASURED
        bar.total, bar.unit = progress.total, f" {progress.unit}"
        bar.set_postfix_str(str(progress.detail), refresh=False)
        bar.update(progress.done - bar.n)

    try:
        yield show
    finally:
        with deferred_interrupts():
            bar.close()
