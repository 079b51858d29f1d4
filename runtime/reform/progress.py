"""What is told of a registration under way: a bar, a user's function, or nothing."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from ..errors import InputError
from .result import Step

Tell = Callable[[Step], None]
#: Seconds before a bar is shown: most registrations are through by then.
PATIENCE = 0.3


@contextmanager
def told(wanted: bool | Tell | None) -> Iterator[Tell]:
    """A function of steps.

    Parameters
    ----------
    wanted : bool or callable
        True: a bar on stderr. A function is called with every `Step`, after each block of motors.

    Raises
    ------
    InputError
        If it is neither.
    """
    if callable(wanted):
        yield wanted
    elif not isinstance(wanted, bool | np.bool_ | None):
        raise InputError(f"progress is a {type(wanted).__name__}; it is True, False or a function of a reform.Step.")
    elif not wanted:
        yield lambda step: None
    else:
        from tqdm import tqdm

        with tqdm(unit=" motors", unit_scale=True, desc="register", delay=PATIENCE, leave=False) as bar:
            yield lambda step: _show(bar, step)


def _show(bar: Any, step: Step) -> None:
    bar.set_postfix_str(f"{step.hits} objects within {step.tolerance:.2g} of the size", refresh=False)
    bar.update(step.candidates - bar.n)
