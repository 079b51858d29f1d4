"""Signs of life of commands that take long: a notice that something is prepared, and bars."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from typing import Any

import click

#: Seconds without a sign of life, after which a command says what it is doing.
PATIENCE = 1.5


@contextmanager
def noticed(notice: str, shown: bool, patience: float = PATIENCE) -> Iterator[Callable[[], None]]:
    """Say that something is prepared, if the block takes long; what it gets calls that off."""
    timer = threading.Timer(patience, click.echo, (notice,), {"err": True})
    timer.daemon = True
    if shown:
        timer.start()
    try:
        yield timer.cancel
    finally:
        timer.cancel()


@contextmanager
def noticed_bar(notice: str, bar: AbstractContextManager[Callable[[Any], None]] | None) -> Iterator[Any]:
    """What a run is to tell: a bar, and before its first sign of life that something is prepared; False without one."""
    if bar is None:
        yield False
        return
    with noticed(notice, True) as called_off, bar as told:

        def tell(step: Any) -> None:
            called_off()
            told(step)

        yield tell


@contextmanager
def counted(name: str, unit: str, shown: bool) -> Iterator[Callable[[int, int], None] | None]:
    """A bar for what counts (done, in all)."""
    if not shown:
        yield None
        return
    from tqdm import tqdm

    with tqdm(desc=name, unit=f" {unit}", leave=False) as bar:

        def tell(done: int, total: int) -> None:
            bar.total, bar.n = total, done
            bar.refresh()

        yield tell
