"""Products that take long: an interrupt takes effect between calls of compiled code."""

from __future__ import annotations

import signal
import threading
import time

import numpy as np
import pytest

import bladesmith as bs
from bladesmith.dispatch import plans, product_tables

pytestmark = pytest.mark.skipif(product_tables.library() is None, reason="no compiled product")


def test_batches_are_multiplied_in_parts_of_bounded_work(monkeypatch: pytest.MonkeyPatch) -> None:
    algebra = bs.algebra(6)
    blades = algebra.multivector(np.ones(64)).kind.blades
    table = product_tables.product_table(algebra, "geometric", blades, blades)
    x, y = np.random.default_rng(2).normal(size=(2, 10, 64))
    whole, parts = np.empty((2, 10, 64))
    plans.table_rows(table, 0)(whole, x, y, 10)
    monkeypatch.setattr(plans, "MOST_TERMS", 3 * table.terms + 1)
    calls = []
    module = product_tables.library()

    class Watched:
        class lib:  # noqa: N801  as of cffi
            @staticmethod
            def bs_multiply(product: object, single: int, begin: int, end: int, *more: object) -> None:
                calls.append((begin, end))
                module.lib.bs_multiply(product, single, begin, end, *more)

    monkeypatch.setattr(product_tables, "library", lambda: Watched)
    plans.table_rows(table, 0)(parts, x, y, 10)
    assert (whole == parts).all() and calls == [(0, 3), (3, 10)]  # which were short


@pytest.mark.service
def test_an_interrupt_of_a_long_product_takes_effect_soon() -> None:
    x = bs.algebra(9).multivector(np.ones((8000, 512)))
    _ = x[:1] * x[:1]
    start = time.monotonic()
    threading.Timer(0.2, signal.raise_signal, (signal.SIGINT,)).start()
    with pytest.raises(KeyboardInterrupt):
        for _ in range(20):
            x * x
    assert time.monotonic() - start < 2
