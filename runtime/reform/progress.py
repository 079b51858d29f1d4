"""What is told of a registration under way: a bar, a user's function, or nothing."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from typing import Any

from .. import progress
from .result import Step

Tell = Callable[[Step], None]
#: Seconds before a bar is shown: most registrations are through by then.
PATIENCE = 0.3


def told(wanted: bool | Tell | None) -> AbstractContextManager[Tell]:
    """A function of steps, which is called after each block of motors: see `bladesmith.progress.told`."""
    return progress.told(wanted, "a reform.Step", _bar)


@contextmanager
def _bar() -> Iterator[Tell]:
    from tqdm import tqdm

    with tqdm(unit=" motors", unit_scale=True, desc="register", delay=PATIENCE, leave=False) as bar:
        yield lambda step: _show(bar, step)


def _show(bar: Any, step: Step) -> None:
    bar.set_postfix_str(f"{step.hits} objects within {step.tolerance:.2g} of the size", refresh=False)
    bar.update(step.candidates - bar.n)
