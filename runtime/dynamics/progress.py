"""What is told of a simulation under way: a bar, a user's function, or nothing."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np

from ..codegen.errors import InputError

Tell = Callable[[float], None]
#: Seconds before a bar is shown: most simulations are through by then.
PATIENCE = 0.3


@contextmanager
def told(wanted: bool | Tell | None, duration: float) -> Iterator[Tell]:
    """A function of the time that a simulation has reached.

    Parameters
    ----------
    wanted : bool or callable
        True: a bar on stderr.

    Raises
    ------
    InputError
        If it is neither.
    """
    if callable(wanted):
        yield wanted
    elif not isinstance(wanted, bool | np.bool_ | None):
        raise InputError(f"progress is a {type(wanted).__name__}; it is True, False or a function of the time reached.")
    elif not wanted:
        yield lambda time: None
    else:
        from tqdm import tqdm

        form = "{desc}: {percentage:3.0f}%|{bar}| {n:.4g}/{total:.4g} s [{elapsed}<{remaining}]"
        with tqdm(total=duration, desc="simulate", delay=PATIENCE, leave=False, bar_format=form) as bar:
            yield lambda time: bar.update(time - bar.n)
