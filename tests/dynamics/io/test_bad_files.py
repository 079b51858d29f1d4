"""What users may get wrong in files of simulations that are run: keys of the message, names that are no files."""

from __future__ import annotations

import os
from typing import Any

import numpy as np
import pytest

from bladesmith import dynamics
from bladesmith.cli import main
from bladesmith.errors import (
    InputError,
    SimulationError,
)

from ...support.dynamics.input import refused

BODY = "[body]\nmass = 2.0\nmoments = [1.0, 2.0, 2.5]\npoints = { tip = [0.0, 0.0, 0.5] }\n"
ON = '[[constraints]]\nkind = "incidence"\npoint = "tip"\non = { kind = "sphere", center = [0, 0, 0], radius = 1 }\n'
RUN = "[simulation]\nduration = 0.01\n"
FILES = [
    (BODY + RUN + "times = []", "line 7: simulation.times is []; it has 0 items where 1 are the least"),
    (BODY + RUN + "times = [nan]", "line 7: simulation.times[0] is nan; numbers are finite"),
    (BODY + RUN + "times = 3", "line 7: simulation.times is 3; an array is needed"),
    (BODY + RUN + "rtol = inf", "line 7: simulation.rtol is inf; numbers are finite"),
    (BODY + RUN + "rtol = 2", "rtol is 2; it is a relative error, at most 0.1"),
    (BODY + RUN + "baumgarte = 3", 'the rate baumgarte goes with stabilization = "baumgarte"'),
    (BODY + RUN + "project = 1", "line 7: simulation.project is 1; true or false is needed"),
    (BODY + RUN + "step = 1e-30", "the step is 1e-30, which is rounded away"),
    (BODY + RUN + "hurry = true", "line 7: simulation.hurry is not a known key; known keys: duration"),
    ("body = 3\n" + RUN, "line 1: body is 3; a table is needed"),
    ("\0", "line 1, column 1: invalid statement"),
    (BODY + ON + RUN, "Give simulation.project = true, and the start is moved"),
    (BODY + ON + RUN + 'project = true\nintegrator = "strang"', 'Use simulation.integrator = "adaptive", or another'),
    (
        BODY + ON + RUN + 'project = true\nstabilization = "null-space"',
        'simulation.stabilization = "null-space" is for',
    ),
]


@pytest.mark.compiles
@pytest.mark.parametrize(("text", "says"), FILES, ids=[says[:40] for _, says in FILES])
def test_files(text: str, says: str, tmp_path: Any) -> None:
    path = tmp_path / "body.toml"
    path.write_text(text)
    error = refused(lambda: dynamics.load_simulation(path).run(), says, InputError)
    assert str(error).startswith(str(path))


@pytest.mark.compiles
def test_failures_of_files_speak_of_keys_and_keep_the_trajectory(tmp_path: Any) -> None:
    path = tmp_path / "body.toml"
    stiff = '[[loads]]\nkind = "spring"\npoint = [0, 0, 0]\nanchor = [1, 0, 0]\nstiffness = 1e300\n'
    path.write_text(BODY + stiff.replace("1e300", "1e60") + RUN)
    error = refused(lambda: dynamics.load_simulation(path).run(strict=True), "no longer finite", SimulationError)
    assert error.remedy is not None and 'simulation.integrator = "adaptive"' in error.remedy
    assert len(error.trajectory) >= 1  # type: ignore[attr-defined]


def test_places_that_are_no_files(tmp_path: Any, capsys: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    refused(lambda: dynamics.load_simulation(tmp_path), "cannot be read: Is a directory", InputError)
    refused(lambda: dynamics.load_simulation(np.eye(3)), "array([[1., 0...[0., 0., 1.]]) names none", InputError)
    refused(lambda: dynamics.load_trajectory(None), "a trajectory is read from a file, and None names none", InputError)
    path = tmp_path / "body.toml"
    path.write_text(BODY + RUN)
    monkeypatch.setattr("os.access", lambda place, mode: mode != os.W_OK)
    assert main.run(["simulate", str(path), "-o", str(tmp_path / "a.npz")]) == 2
    assert "a.npz: cannot be written: no permission." in capsys.readouterr().err
