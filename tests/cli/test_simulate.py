"""`bladesmith simulate`: a file in, a summary, files out, exit statuses, interrupts."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from bladesmith import dynamics
from bladesmith.cli import main
from bladesmith.errors import SimulationError

from ..support.checkout import CHECKOUT
from ..support.files import names

EXAMPLES = CHECKOUT / "examples" / "dynamics"
PENDULUM = str(EXAMPLES / "pendulum_on_sphere.toml")
PATIENCE = 60.0  # seconds for a process on a busy machine

BODY = """
[body]
mass = 1.0
moments = [1.0, 2.0, 2.5]
angular_velocity = [0.1, 2.0, 0.1]
velocity = [1.0, 0.0, 0.0]

[simulation]
duration = 0.2
"""


@pytest.fixture
def body(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "body.toml").write_text(BODY)
    return "body.toml"


def test_a_trajectory_is_told_and_written(body, tmp_path, capsys):
    assert main.run(["simulate", body]) == 0
    out, err = capsys.readouterr()
    lines = dict(line.split(": ", 1) for line in out.splitlines())
    assert lines["states"].strip() == "1001, to t = 0.2 s" and lines["integrator"].strip().startswith("taylor, ")
    assert lines["energy"].strip().startswith("4.5175 J at the start, varies by ")
    assert lines["at the end"].strip().startswith("(0.2, ") and "violation" not in lines
    assert err == "wrote trajectory.npz\n" and names(tmp_path) == ["body.toml", "trajectory.npz"]
    record = dynamics.load_trajectory("trajectory.npz")
    assert np.array_equal(record.position, dynamics.load_simulation(body).run().position)


@pytest.mark.slow
def test_everything_that_can_be_asked_for(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    asked = "-o a.npz -o a.csv --plot --picture b.pdf --animate c.html --animate d.gif --rate 2 --speed 1 --quiet"
    assert main.run(["simulate", PENDULUM, *asked.split()]) == 0
    out, err = capsys.readouterr()
    assert err == "" and "violation: " in out
    assert names(tmp_path) == ["a.csv", "a.npz", "a.png", "b.pdf", "c.html", "d.gif"]
    for name, begins in {"a.png": b"\x89PNG", "b.pdf": b"%PDF", "c.html": b"<!doctype html>", "d.gif": b"GIF89a",
                         "a.npz": b"PK", "a.csv": b"t [s],x [m]"}.items():  # fmt: skip
        assert Path(name).read_bytes().startswith(begins)
    assert dynamics.load_trajectory("a.npz").sketch.title == "A pendulum whose end is on a sphere"


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ([], "Missing argument"),
        (["none.toml"], "InputError: none.toml: cannot be read: No such file"),
        (["broken.toml"], "InputError: broken.toml, line 3: body.mas is not a known key; did you mean 'mass'?"),
        (["off.toml"], "ConstraintError: off.toml: constraint 0 (Incidence) is violated at the start, by "),
        (["body.toml", "-o", "a.txt"], "InputError: a.txt: trajectories are written as .npz or .csv"),
        (["body.toml", "-o", "no/a.npz"], "InputError: no/a.npz: there is no folder no."),
        (["body.toml", "-o", "folder.npz"], "InputError: folder.npz: it is a folder."),
        (["body.toml", "-o", "a.npz", "-o", "./a.npz"], "InputError: a.npz: two results have this name."),
        (
            ["body.toml", "-o", "a.npz", "--plot", "--picture", "a.png"],
            "InputError: a.png: two results have this name.",
        ),
        (["body.toml", "--picture", "a.xyz"], "InputError: a.xyz: 'xyz' is not a format of pictures. Use one of"),
        (
            ["body.toml", "--animate", "a.avi"],
            "InputError: a.avi: films and pages are written as .gif, .mp4 or .html, not .avi.",
        ),
        (["body.toml", "--speed", "0"], "InputError: --speed is 0.0; a positive number is needed."),
        (["body.toml", "--rate", "nan"], "InputError: --rate is nan; a finite positive number is needed."),
        (["body.toml", "--rate", "fast"], "Invalid value for '--rate'"),
        (["link.npz", "-o", "link.npz"], "the result would take the place of the simulation file."),
    ],
)
def test_bad_input_is_one_line_and_exit_status_2(arguments, says, body, tmp_path, capsys):
    (tmp_path / "broken.toml").write_text(BODY.replace("mass", "mas"))
    on = '[[loads]]\nkind = "gravity"\n[[constraints]]\nkind = "incidence"\npoint = [0, 0, 0]\n'
    (tmp_path / "off.toml").write_text(on + 'on = { kind = "sphere", center = [3, 0, 0], radius = 1 }' + BODY)
    (tmp_path / "folder.npz").mkdir()
    os.link(tmp_path / "body.toml", tmp_path / "link.npz")
    before = names(tmp_path)
    assert main.run(["simulate", *arguments]) == 2
    out, err = capsys.readouterr()
    assert says in err and out == "" and "Traceback" not in err
    assert names(tmp_path) == before and (tmp_path / "body.toml").read_text() == BODY


def test_a_simulation_that_cannot_go_on_leaves_what_there_is(body, tmp_path, monkeypatch, capsys):
    real = dynamics.Simulation.run

    def run(self, duration, **options):
        found = real(self, duration / 2, **{**options, "times": options["times"][options["times"] <= duration / 2]})
        raise SimulationError("the state is no longer finite, at time 0.1.", trajectory=found)

    monkeypatch.setattr(dynamics.Simulation, "run", run)
    assert main.run(["simulate", body, "-o", "a.npz", "-o", "b.csv", "--plot"]) == 1
    out, err = capsys.readouterr()
    assert "to t = 0.1 s" in out
    assert err == (
        "the state is no longer finite, at time 0.1.; what there is, to t = 0.1: a.partial.npz, b.partial.csv\n"
    )
    assert names(tmp_path) == ["a.partial.npz", "b.partial.csv", "body.toml"]
    assert dynamics.load_trajectory("a.partial.npz").time[-1] == 0.1


@pytest.mark.compiles
def test_an_interrupt_leaves_whole_files(tmp_path):
    """Ctrl-C in a run that would take hours: what there is can be read, and nothing else was written."""
    text = BODY.replace("duration = 0.2", 'duration = 1e7\ninterval = 100.0\nintegrator = "rk4"\nstep = 1e-3')
    (tmp_path / "body.toml").write_text(text)
    process = subprocess.Popen(
        [sys.executable, "-m", "bladesmith", "simulate", "body.toml", "-o", "a.npz", "--plot"], cwd=tmp_path,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    try:
        _running(process.pid)
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=PATIENCE)
    finally:
        process.kill()
    assert process.returncode == 1 and "Traceback" not in err, err
    assert err.startswith("interrupted; what there is, to t = ") and err.endswith(": a.partial.npz\n")
    assert names(tmp_path) == ["a.partial.npz", "body.toml"]
    record = dynamics.load_trajectory(tmp_path / "a.partial.npz")
    assert len(record) >= 1 and record.message == "interrupted" and np.isfinite(record.position).all()


def _running(pid):
    """Wait until a process has spent some seconds of computing: by then it simulates."""
    enough = 4.0 * os.sysconf("SC_CLK_TCK")
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
        if int(fields[11]) + int(fields[12]) > enough:
            return
        time.sleep(0.05)
    raise AssertionError("the process does not compute")


@pytest.mark.slow
@pytest.mark.parametrize("what", [OSError(28, "No space left on device"), KeyboardInterrupt()])
@pytest.mark.parametrize("asked", [[], ["--plot"], ["--picture", "b.png"], ["--animate", "b.gif", "--rate", "2"]])
def test_nothing_is_left_half_written(what, asked, body, tmp_path, monkeypatch, capsys):
    real = os.replace

    last = {"--plot": "trajectory.png", "--picture": "b.png", "--animate": "b.gif"}.get(asked[0] if asked else "")
    target_name = last or "trajectory.npz"

    def fail(source, target, *rest):
        if Path(target).name == target_name:
            raise what
        return real(source, target, *rest)

    monkeypatch.setattr(os, "replace", fail)
    status = main.run(["simulate", body, *asked, "--quiet"])
    assert status == (130 if isinstance(what, KeyboardInterrupt) else 2)
    assert names(tmp_path) == sorted(["body.toml", *(["trajectory.npz"] if last else [])])


def test_help_shows_an_example(capsys):
    assert main.run(["simulate", "--help"]) == 0
    assert "Example: bladesmith simulate body.toml -o trajectory.npz --plot" in " ".join(
        capsys.readouterr().out.split()
    )
