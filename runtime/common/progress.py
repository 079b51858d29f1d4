"""The option ``progress=``: as in `codegen.progress`; and, for one release, functions of (done, total)."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from contextlib import AbstractContextManager
from typing import Any

from ..codegen import progress
from ..codegen.errors import InputError
from ..codegen.progress import Progress, ProgressOption, Report
from .deprecation import warn_renamed


def open_progress(
    option: ProgressOption, title: str, unit: str, total: float | None = None
) -> AbstractContextManager[Report]:
    """Report the progress of a job as the option says: see `codegen.progress.open_progress`."""
    return progress.open_progress(_of_progress(option), title, unit, total)


def _of_progress(option: Any) -> Any:
    """Function of one `Progress`, also for an old one of two arguments."""
    if not callable(option) or _takes(option, 1):
        return option
    if not _takes(option, 2):
        raise InputError(
            f"progress takes {inspect.signature(option)}; a function of one bladesmith.Progress is needed."
        )
    warn_renamed("progress=function of (done, total)", "a function of one bladesmith.Progress")
    return lambda progress: option(progress.done, progress.total)


def _takes(function: Callable[..., Any], count: int) -> bool:
    try:
        inspect.signature(function).bind(*[None] * count)
    except TypeError:
        return False
    except ValueError:  # nothing is known about functions written in C
        pass
    return True


__all__ = ["Progress", "ProgressOption", "Report", "open_progress"]
