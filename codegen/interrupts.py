"""Interrupts: deferred, for code that would swallow them or break; and with what was computed until then."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

from .errors import ExecutorError, Interrupted


@contextmanager
def deferred_interrupts() -> Iterator[Callable[[], None]]:
    """An interrupt inside the block takes effect at its end, or where the block calls what it gets.

    Importing trimesh, and reading files with it, catches every exception in many places, KeyboardInterrupt too: a
    Ctrl-C at that moment would be lost. Waiting for futures and drawing bars takes locks that an exception between two
    lines leaves locked for ever. A second interrupt takes effect at once, for blocks that hang. Elsewhere than in the
    main thread, where no interrupts come, nothing is done.
    """
    usual = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or not callable(usual):
        yield lambda: None
        return
    came: list[FrameType | None] = []

    def keep(number: int, frame: FrameType | None) -> None:
        came.append(frame)
        if len(came) > 1:
            tell()

    def tell() -> None:
        if came:
            frame = came[-1]
            came.clear()
            usual(signal.SIGINT, frame)

    signal.signal(signal.SIGINT, keep)
    try:
        yield tell
    finally:
        signal.signal(signal.SIGINT, usual)
        tell()


class keep_partial:
    """Errors with what there is: an interrupt inside the block becomes an `Interrupted`.

    Parameters
    ----------
    partial : callable
        Gives what was computed.
    interrupted, failed : types
        Exceptions of an interrupt, and of an executor whose workers fail.
    """

    def __init__(
        self,
        partial: Callable[[], object],
        interrupted: Callable[[Any], Interrupted] = Interrupted,
        failed: type[ExecutorError] = ExecutorError,
    ) -> None:
        self._partial, self._interrupted, self._failed = partial, interrupted, failed

    def __enter__(self) -> None:
        """Nothing is done: a class costs a tenth of a generator."""

    def __exit__(self, _: object, error: BaseException | None, __: object) -> None:
        if isinstance(error, KeyboardInterrupt):
            raise self._interrupted(self._partial()) from None
        if isinstance(error, ExecutorError):
            raise self._failed(error.what, remedy=error.remedy, partial=self._partial()) from error.__cause__
