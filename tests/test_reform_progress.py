"""Progress and interrupts of registration."""

from __future__ import annotations

import signal
import subprocess
import sys

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import reform
from bladesmith.errors import InputError
from bladesmith.reform import unfinished

from .reform_support import EXAMPLES, PATIENCE, noisy_lines, tables

CGA = bs.cga3d


@pytest.fixture(scope="module")
def models():
    return noisy_lines()


def test_progress_is_told_in_steps(models, capsys):
    steps = []
    result = reform.register(*models, progress=steps.append)
    assert steps and all(isinstance(s, reform.Step) for s in steps)
    assert [s.candidates for s in steps] == sorted(s.candidates for s in steps)
    assert max(s.tolerance for s in steps) == max(s.tolerance for s in result.history if s.name == "search")
    with pytest.raises(InputError, match="progress is a int"):
        reform.register(*models, progress=3)
    assert capsys.readouterr().err == ""


def test_a_bar_is_shown_where_it_is_asked_for(models, capsys, monkeypatch):
    monkeypatch.setattr("bladesmith.reform.progress.PATIENCE", 0)
    reform.register(*models, progress=True)
    assert "motors" in capsys.readouterr().err


def test_an_interrupt_returns_the_best_so_far():
    query, reference = tables()

    def stop(step):
        if step.hits > 10:
            raise KeyboardInterrupt

    found = reform.register(query, reference, progress=stop)
    assert (found.converged, found.message, found.ambiguous) == (False, unfinished.INTERRUPTED, [])
    assert found.inliers.sum() == 22
    moved = (found.motor >> query.lines) * ~reference.lines[np.asarray(found.matches)]  # 1 or -1
    assert np.abs(np.abs(moved.values) - (np.arange(moved.values.shape[-1]) == 0)).max() < 1e-9


def test_an_interrupt_of_a_search_from_nearby():
    _, table = tables()
    query = table.transformed(CGA.translator((0.02, 0, 0.01)) * CGA.rotor((0, 0, 1), 0.02))

    def stop(step):
        if step.hits == 22:
            raise KeyboardInterrupt

    found = reform.register(query, table, start="proximity", progress=stop)
    assert (found.converged, found.message) == (False, unfinished.INTERRUPTED)
    np.testing.assert_array_equal(np.asarray(found.matches), np.arange(22))


def test_an_interrupt_before_anything_was_found(models):
    def stop(step):
        raise KeyboardInterrupt

    found = reform.register(*models, progress=stop)
    assert (found.converged, found.message, found.inliers.sum()) == (False, unfinished.INTERRUPTED, 0)
    assert len(found.matches) == 40 and (np.asarray(found.matches) == -1).all()


def test_a_real_interrupt_of_a_search_that_goes_on():
    code = """
import sys, time
from bladesmith import reform
from bladesmith.reform import search
search.Search._is_enough = lambda self, here: False
def tell(step):
    print(step.hits, flush=True)
    time.sleep(0.02)
query, reference = (reform.Model.load(path) for path in sys.argv[1:])
found = reform.register(query, reference, samples=100000, progress=tell)
print("message", found.message, found.converged, found.inliers.sum())
"""
    places = [str(EXAMPLES / name) for name in ("table_query.json", "table.json")]
    process = subprocess.Popen([sys.executable, "-c", code, *places], stdout=subprocess.PIPE, text=True)
    try:
        for line in process.stdout:
            if line.strip() == "22":
                process.send_signal(signal.SIGINT)
                break
        out, _ = process.communicate(timeout=PATIENCE)
    finally:
        process.kill()
    assert (process.returncode, out.splitlines()[-1]) == (0, "message interrupted False 22")
