"""`bladesmith register`: files in, a summary, files out, exit statuses, interrupts."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from bladesmith import reform
from bladesmith.cli import main

EXAMPLES = Path(__file__).resolve().parent.parent / "examples" / "chapter5"
TABLE, QUERY = str(EXAMPLES / "table.json"), str(EXAMPLES / "table_query.json")
PATIENCE = 60.0  # seconds for a process on a busy machine


def test_a_result_is_told_and_written(tmp_path, capsys):
    output, picture = tmp_path / "result.json", tmp_path / "result.png"
    assert main.run(["register", QUERY, TABLE, "-o", str(output), "--picture", str(picture), "--seed", "3"]) == 0
    out, err = capsys.readouterr()
    for line in ("pose:        turn by ", "matches:     22 of 22 lines", "converged:   yes", "ambiguous:   "):
        assert f"\n{line}" in f"\n{out}"
    assert err == f"wrote {output}\nwrote {picture}\n"
    found = reform.load_registration(output)
    models = [reform.Model.load(path) for path in (QUERY, TABLE)]
    assert found.motor.values.tobytes() == reform.register(*models, seed=3).motor.values.tobytes()
    data = json.loads(output.read_text())
    assert data["settings"]["seed"] == 3 and data["settings"]["start"] == "global"
    assert data["query"] == {"name": "table, moved", "lines": 22}
    assert picture.read_bytes()[1:4] == b"PNG"
    assert sorted(p.name for p in tmp_path.iterdir()) == ["result.json", "result.png"]


def test_options_reach_the_registration(monkeypatch, tmp_path, capsys):
    seen = {}

    def register(query, reference, **settings):
        seen.update(settings)
        return real(query, reference, seed=settings["seed"])

    real = reform.register
    monkeypatch.setattr(reform, "register", register)
    options = (
        "--samples 9 --sample-size 3 --iterations 5 --seed 4 --threads 1 --backend c --oriented --length 2 --quiet"
    )
    assert main.run(["register", QUERY, TABLE, *options.split()]) == 0
    progress = seen.pop("progress")
    assert not progress
    assert seen == {
        "samples": 9, "sample_size": 3, "iterations": 5, "seed": 4, "threads": 1, "backend": "c", "align": False,
        "length": 2.0, "start": "global",
    }  # fmt: skip
    assert capsys.readouterr().err == ""


def test_a_result_can_be_gone_on_from(tmp_path, monkeypatch, capsys):
    output = tmp_path / "result.json"
    assert main.run(["register", QUERY, TABLE, "-o", str(output), "--quiet"]) == 0
    wanted, seen = reform.load_registration(output).motor, []
    real = reform.register

    def register(*models, start, **settings):
        seen.append(start)
        return real(*models, **settings)

    monkeypatch.setattr(reform, "register", register)
    assert main.run(["register", QUERY, TABLE, "--start", str(output), "--quiet"]) == 0
    assert seen[0].values.tobytes() == wanted.values.tobytes()
    assert main.run(["register", QUERY, TABLE, "--start", TABLE]) == 2
    assert f'{TABLE}: is no registration: it has no "format"' in capsys.readouterr().err


def test_a_pose_that_is_not_to_be_relied_on_is_a_failure(tmp_path, capsys):
    random = np.random.default_rng(0)
    paths = [str(tmp_path / name) for name in ("a.json", "b.json")]
    for path in paths:
        reform.Model(points=random.uniform(-1, 1, (10, 3))).save(path)
    assert main.run(["register", *paths, "-o", str(tmp_path / "r.json"), "--quiet"]) == 1
    assert "converged:   no: " in capsys.readouterr().out
    assert not reform.load_registration(tmp_path / "r.json").converged


def test_motions_that_are_left_free_are_a_failure_in_words(tmp_path, capsys):
    path = str(tmp_path / "a.json")
    reform.Model(lines=[[(0, 0, z), (1, 0, 0)] for z in range(3)]).save(path)
    assert main.run(["register", path, path]) == 1
    assert "translation along (1, 0, 0)" in "".join(capsys.readouterr())


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ([], "Missing argument"),
        (["no.json", TABLE], "InputError: no.json: cannot be read: No such file"),
        (["broken.json", TABLE], "broken.json: lines[0].direction is [0.0, 0.0, 0.0]; a direction is not zero"),
        (["misspelt.json", TABLE], "misspelt.json: lines[0].directon is not a known key; did you mean 'direction'?"),
        (["empty.json", TABLE], "InputError: the query is empty; a pose needs objects."),
        (["points.json", TABLE], "InputError: the models have no kind of object in common: points and lines."),
        ([QUERY, TABLE, "--samples", "0"], "InputError: samples is 0; a whole number from 1 to"),
        ([QUERY, TABLE, "--samples", "many"], "Invalid value for '--samples'"),
        ([QUERY, TABLE, "--seed", "-1"], "InputError: seed is -1; a whole number of at least 0"),
        ([QUERY, TABLE, "--length", "0"], "InputError: length is 0; "),
        ([QUERY, TABLE, "--threads", "0"], "Invalid value for '--threads'"),
        ([QUERY, TABLE, "--backend", "fortran"], "Invalid value for '--backend'"),
        ([QUERY, TABLE, "--start", "nearby"], "InputError: start is 'nearby'; it is one of global, proximity"),
        ([QUERY, TABLE, "--start", "none.json"], "InputError: none.json: cannot be read"),
        ([QUERY, TABLE, "-o", "no/r.json"], "InputError: no/r.json: there is no folder no."),
        ([QUERY, TABLE, "-o", "."], "InputError: .: it is a folder."),
        ([QUERY, "empty.json", "-o", "empty.json"], "empty.json: the result would take the place of a model."),
        ([QUERY, TABLE, "--picture", "p.xyz"], "InputError: p.xyz: 'xyz' is no format of pictures. Use one of"),
        ([QUERY, TABLE, "--picture", "p.png", "-o", "p.png"], "InputError: p.png: result and picture have one name."),
    ],
)  # fmt: skip
def test_bad_input_is_one_line_and_exit_status_2(arguments, says, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    head = '{"format": "bladesmith-model", "version": 1'
    for name, rest in {
        "empty": "", "points": ', "points": [{"xyz": [0.0, 0.0, 0.0]}]',
        "broken": ', "lines": [{"point": [0, 0, 0], "direction": [0, 0, 0]}]',
        "misspelt": ', "lines": [{"point": [0, 0, 0], "directon": [0, 0, 1]}]',
    }.items():  # fmt: skip
        (tmp_path / f"{name}.json").write_text(f"{head}{rest}}}")
    before = {p.name: p.read_bytes() for p in tmp_path.iterdir()}
    assert main.run(["register", *arguments]) == 2
    out, err = capsys.readouterr()
    assert says in err and out == "" and "Traceback" not in err
    assert {p.name: p.read_bytes() for p in tmp_path.iterdir()} == before


@pytest.mark.parametrize("when", ["text", "picture"])
@pytest.mark.parametrize("what", [OSError(28, "No space left on device"), KeyboardInterrupt()])
def test_nothing_is_left_under_the_final_name_by_a_full_disk_or_an_interrupt(when, what, tmp_path, monkeypatch, capsys):
    def fail(*_, **__):
        raise what

    target = {"text": "pathlib.Path.write_bytes", "picture": "matplotlib.figure.Figure.savefig"}[when]
    monkeypatch.setattr(target, fail)
    places = {name: tmp_path / name for name in ("r.json", "p.png")}
    status = main.run(["register", QUERY, TABLE, "-o", str(places["r.json"]), "--picture", str(places["p.png"])])
    assert status == (1 if isinstance(what, OSError) else main.INTERRUPTED)
    err = capsys.readouterr().err.splitlines()[-1]
    name = places["r.json" if when == "text" else "p.png"]
    assert err == (f"{name}: No space left on device" if isinstance(what, OSError) else "interrupted")
    left = [p.name for p in tmp_path.iterdir()]
    assert left == ([] if when == "text" else ["r.json"])  # which is whole
    if left:
        assert reform.load_registration(places["r.json"]).converged


CODE = """
import sys, time
from bladesmith.cli.main import main
from bladesmith.reform import job, search
search.Search._is_enough = lambda self, here: False
tell = job.Job.tell
def slowly(self, found):
    tell(self, found)
    print(int(found.hits[0]) if len(found.hits) else 0, flush=True)
    time.sleep(0.02)
job.Job.tell = slowly
main(["register", *sys.argv[1:], "--samples", "100000", "-o", "result.json"])
"""


def test_an_interrupt_keeps_the_best_so_far_under_another_name(tmp_path):
    process = subprocess.Popen(
        [sys.executable, "-c", CODE, QUERY, TABLE],
        cwd=tmp_path,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    try:
        for line in process.stdout:
            if line.strip() == "22":
                process.send_signal(signal.SIGINT)
                break
        _, err = process.communicate(timeout=PATIENCE)
    finally:
        process.kill()
    assert process.returncode == 1
    assert err.strip() == "interrupted: the best so far matches 22 of 22 objects: result.partial.json"
    assert [p.name for p in tmp_path.iterdir()] == ["result.partial.json"]
    found = reform.load_registration(tmp_path / "result.partial.json")
    assert (found.converged, found.message, found.inliers.sum()) == (False, "interrupted", 22)
