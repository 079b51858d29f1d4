"""What is told of long work: a bar, a user's function, or nothing."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from typing import TypeVar

import numpy as np

from .codegen.errors import InputError

Sign = TypeVar("Sign")


@contextmanager
def told(
    wanted: bool | Callable[[Sign], None] | None,
    takes: str,
    bar: Callable[[], AbstractContextManager[Callable[[Sign], None]]],
) -> Iterator[Callable[[Sign], None]]:
    """A function to be called with every sign of life.

    Parameters
    ----------
    wanted : bool or callable
        True: a bar on stderr.
    takes : str
        What such a function is a function of.
    bar : callable
        Opens the bar.

    Raises
    ------
    InputError
        If it is neither.
    """
    if callable(wanted):
        yield wanted
    elif not isinstance(wanted, bool | np.bool_ | None):
        raise InputError(f"progress is a {type(wanted).__name__}; it is True, False or a function of {takes}.")
    elif not wanted:
        yield lambda sign: None
    else:
        with bar() as tell:
            yield tell
