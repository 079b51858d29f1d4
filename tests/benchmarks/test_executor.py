"""Studies on the workers of an executor."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import pytest

from bladesmith.benchmarks.harness import runner, write
from bladesmith.benchmarks.registry import load_study
from bladesmith.errors import Interrupted


def test_each_study_is_a_call_and_the_report_grows(tmp_path, monkeypatch):
    ran, told = [], []
    monkeypatch.setattr(write, "run_study", lambda study, quick: ran.append((study.name, quick)) or [])
    monkeypatch.setattr(write, "plot", lambda study, rows, path: None)
    names = ["distance", "exponential", "products"]
    with ThreadPoolExecutor(2) as pool:
        found = list(write.measure(names, tmp_path, True, told.append, pool))
    assert sorted(ran) == [(name, True) for name in names] and sorted(s.name for s, _ in found) == names
    assert [(p.done, p.total, p.unit) for p in told] == [(i, 3, "studies") for i in (1, 2, 3)]
    assert (tmp_path / "report.json").exists()


def test_an_interrupt_keeps_the_measurements(monkeypatch):
    def stop(progress):
        if progress.done == 2:
            raise KeyboardInterrupt

    monkeypatch.setattr(runner, "_measure", lambda study, case, method, *rest: method.name)
    with pytest.raises(Interrupted) as caught:
        runner.run_study(load_study("distance"), True, stop)
    assert len(caught.value.partial) == 2
