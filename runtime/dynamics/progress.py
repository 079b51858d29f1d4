"""What is told of a simulation under way: a bar, a user's function, or nothing."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager

from .. import progress

Tell = Callable[[float], None]
#: Seconds before a bar is shown: most simulations are through by then.
PATIENCE = 0.3


def told(wanted: bool | Tell | None, duration: float) -> AbstractContextManager[Tell]:
    """A function of the time that a simulation has reached: see `bladesmith.progress.told`."""
    return progress.told(wanted, "the time reached", lambda: _bar(duration))


@contextmanager
def _bar(duration: float) -> Iterator[Tell]:
    from tqdm import tqdm

    form = "{desc}: {percentage:3.0f}%|{bar}| {n:.4g}/{total:.4g} s [{elapsed}<{remaining}]"
    with tqdm(total=duration, desc="simulate", delay=PATIENCE, leave=False, bar_format=form) as bar:
        yield lambda time: bar.update(time - bar.n)
