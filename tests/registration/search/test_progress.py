"""Progress and interrupts of registration."""

from __future__ import annotations

import os
import signal
import subprocess
import sys

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import cga3d, registration
from bladesmith.errors import InputError, Interrupted

from ...support.registration import EXAMPLES, PATIENCE, POSE, apart, lines_and_planes, tables

CGA = bs.cga3d


def test_progress_is_told_in_steps(models, capsys):
    told = []
    result = registration.register(*models, progress=told.append)
    steps = [p.detail for p in told]
    assert steps and all(isinstance(s, registration.Step) for s in steps)
    assert [s.candidates for s in steps] == [p.done for p in told] == sorted(s.candidates for s in steps)
    assert max(s.tolerance for s in steps) == max(s.tolerance for s in result.history if s.name == "search")
    with pytest.raises(InputError, match="progress is 3; it is True, False or a function"):
        registration.register(*models, progress=3)
    assert capsys.readouterr().err == ""


def test_a_bar_is_shown_where_it_is_asked_for(models, capsys, monkeypatch):
    monkeypatch.setattr("bladesmith.codegen.progress.PATIENCE", 0)
    registration.register(*models, progress=True)
    assert "register" in capsys.readouterr().err


def test_an_interrupt_carries_the_best_so_far():
    query, reference = tables()

    def stop(progress):
        if progress.detail.hits > 10:
            raise KeyboardInterrupt

    with pytest.raises(Interrupted) as caught:
        registration.register(query, reference, progress=stop)
    found = caught.value.partial
    assert (found.converged, found.message, found.ambiguous) == (False, "interrupted", [])
    assert found.inliers.sum() == 22
    moved = (found.motor >> query.lines) * ~reference.lines[np.asarray(found.matches)]  # 1 or -1
    assert np.abs(np.abs(moved.values) - (np.arange(moved.values.shape[-1]) == 0)).max() < 1e-9


def test_an_interrupt_of_a_search_from_nearby():
    _, table = tables()
    query = table.transformed(CGA.translator((0.02, 0, 0.01)) * CGA.rotor((0, 0, 1), 0.02))

    def stop(progress):
        if progress.detail.hits == 22:
            raise KeyboardInterrupt

    with pytest.raises(Interrupted) as caught:
        registration.register(query, table, start="proximity", progress=stop)
    found = caught.value.partial
    assert (found.converged, found.message) == (False, "interrupted")
    np.testing.assert_array_equal(np.asarray(found.matches), np.arange(22))


def test_an_interrupt_before_anything_was_found(models):
    def stop(progress):
        raise KeyboardInterrupt

    with pytest.raises(Interrupted) as caught:
        registration.register(*models, progress=stop)
    found = caught.value.partial
    assert (found.converged, found.message, found.inliers.sum()) == (False, "interrupted", 0)
    assert len(found.matches) == 40 and (np.asarray(found.matches) == -1).all()


def test_a_real_interrupt_of_a_search_that_goes_on():
    code = """
import sys, time
from bladesmith import registration as reform
from bladesmith.registration.search import global_search as search
search.GlobalSearch._has_converged = lambda self, state, sets: False
def tell(progress):
    print(progress.detail.hits, flush=True)
    time.sleep(0.02)
query, reference = (reform.Model.load(path) for path in sys.argv[1:])
try:
    reform.register(query, reference, samples=100000, progress=tell)
except KeyboardInterrupt as interrupt:
    found = interrupt.partial
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


def test_one_interrupt_ends_all_the_scales_of_a_similarity():
    interrupts = []

    def once(progress):
        if not interrupts:
            interrupts.append(progress)
            os.kill(os.getpid(), signal.SIGINT)

    query = lines_and_planes()
    with pytest.raises(Interrupted) as caught:
        registration.register(query, query.transformed(cga3d.dilator(3.0) * POSE), similarity=True, progress=once)
    result = caught.value.partial
    assert interrupts and result.message == "interrupted" and not result.converged


def test_an_interrupt_of_the_iteration_keeps_its_motor():
    reference = lines_and_planes()

    def stop(progress):
        raise KeyboardInterrupt

    query = reference.transformed(CGA.translator((0.01, 0, 0)))
    with pytest.raises(Interrupted) as caught:
        registration.iterate(query, reference, progress=stop)
    result = caught.value.partial
    assert result.message == "interrupted" and not result.converged and result.history[0].name == "match"
    assert np.abs((result.motor - CGA.translator((-0.01, 0, 0))).values).max() < 1e-9


def test_an_interrupt_of_the_first_round_returns_where_it_started(monkeypatch):
    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("bladesmith.registration.search.ransac._draw_minimal_samples", interrupted)
    reference = lines_and_planes()
    with pytest.raises(Interrupted) as caught:
        registration.register(reference.transformed(~POSE), reference, start=POSE)
    result = caught.value.partial
    assert result.message == "interrupted" and result.inliers.all() and apart(result.motor, POSE) < 1e-12
