"""Interrupts that come while foreign code runs which would swallow them: kept, and told when it is through."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType


@contextmanager
def kept() -> Iterator[None]:
    """An interrupt inside the block takes effect at its end.

    Importing trimesh, and reading files with it, catches every exception in many places, KeyboardInterrupt too: a
    Ctrl-C at that moment would be lost. Elsewhere than in the main thread, where no interrupts come, nothing is done.
    """
    usual = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or not callable(usual):
        yield
        return
    came: list[FrameType | None] = []
    signal.signal(signal.SIGINT, lambda number, frame: came.append(frame))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, usual)
        if came:
            usual(signal.SIGINT, came[0])
