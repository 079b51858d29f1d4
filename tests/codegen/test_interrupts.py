"""Interrupts that wait for the end of a block: none is swallowed by foreign code."""

from __future__ import annotations

import signal
import threading

import pytest

from bladesmith.codegen import interrupts


def test_an_interrupt_that_foreign_code_swallows_is_told_at_its_end() -> None:
    reached = False
    with pytest.raises(KeyboardInterrupt), interrupts.deferred_interrupts():
        try:
            signal.raise_signal(signal.SIGINT)
        except BaseException:  # as trimesh does around its imports
            pytest.fail("it should wait")
        reached = True
    assert reached
    with pytest.raises(KeyboardInterrupt):  # and the usual handler is back
        signal.raise_signal(signal.SIGINT)


def test_an_interrupt_wins_over_the_error_of_the_block() -> None:
    with pytest.raises(KeyboardInterrupt), interrupts.deferred_interrupts():
        signal.raise_signal(signal.SIGINT)
        raise ImportError("half of it")


def test_other_threads_and_processes_that_ignore_interrupts_are_left_alone() -> None:
    seen = []

    def work() -> None:
        with interrupts.deferred_interrupts():
            seen.append(True)

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert seen == [True]
    usual = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        with interrupts.deferred_interrupts():
            assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGINT, usual)
