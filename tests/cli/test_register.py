"""`bladesmith register`: files in, a summary, files out, exit statuses, interrupts."""

from __future__ import annotations

import json
import os
import signal
import stat
import subprocess
import sys
from importlib import import_module

import numpy as np
import pytest

from bladesmith import poses, registration
from bladesmith.cli import main
from bladesmith.errors import InputError

from ..support.checkout import CHECKOUT
from ..support.registration import fresh, lines_and_planes, moved, rotation

EXAMPLES = CHECKOUT / "examples" / "registration"
TABLE, QUERY = str(EXAMPLES / "table.json"), str(EXAMPLES / "table_query.json")
PATIENCE = 60.0  # seconds for a process on a busy machine


@pytest.mark.slow
def test_a_result_is_told_and_written(tmp_path, capsys):
    output, picture = tmp_path / "result.json", tmp_path / "result.png"
    assert main.run(["register", QUERY, TABLE, "-o", str(output), "--picture", str(picture), "--seed", "3"]) == 0
    out, err = capsys.readouterr()
    for line in ("pose:        turn by ", "matches:     22 of 22 lines", "converged:   yes", "ambiguous:   "):
        assert f"\n{line}" in f"\n{out}"
    assert err == f"wrote {output}\nwrote {picture}\n"
    found = registration.load_registration(output)
    models = [registration.Model.load(path) for path in (QUERY, TABLE)]
    assert found.motor.values.tobytes() == registration.register(*models, seed=3).motor.values.tobytes()
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

    real = registration.register
    monkeypatch.setattr(registration, "register", register)
    options = (
        "--samples 9 --sample-size 3 --iterations 5 --seed 4 --threads 1 --backend c --oriented --length 2 "
        "--loss huber --quiet"
    )
    assert main.run(["register", QUERY, TABLE, *options.split()]) == 0
    progress = seen.pop("progress")
    assert not progress
    assert seen == {
        "samples": 9, "sample_size": 3, "iterations": 5, "seed": 4, "threads": 1, "backend": "c", "align": False,
        "length": 2.0, "similarity": False, "start": "global", "loss": "huber",
    }  # fmt: skip
    assert capsys.readouterr().err == ""


def test_a_result_can_be_gone_on_from(tmp_path, monkeypatch, capsys):
    output = tmp_path / "result.json"
    assert main.run(["register", QUERY, TABLE, "-o", str(output), "--quiet"]) == 0
    wanted, seen = registration.load_registration(output).motor, []
    real = registration.register

    def register(*models, start, **settings):
        seen.append(start)
        return real(*models, **settings)

    monkeypatch.setattr(registration, "register", register)
    assert main.run(["register", QUERY, TABLE, "--start", str(output), "--quiet"]) == 0
    assert seen[0].values.tobytes() == wanted.values.tobytes()
    assert main.run(["register", QUERY, TABLE, "--start", TABLE]) == 2
    assert f'{TABLE}: is not a registration: it has no "format"' in capsys.readouterr().err


def rounds(tmp_path, factor):
    """Files of circles and spheres, and of the same ones in another place and factor times as large; their matrix."""
    random = np.random.default_rng(6)
    turn, shift = rotation((1, -2, 0.5), 2.2), np.array([0.4, -1.0, 2.0])
    small = {"circles": fresh("circles", 12, random), "spheres": fresh("spheres", 8, random)}
    large = {kind: moved(kind, x, turn, shift / factor) for kind, x in small.items()}
    for kind, x in large.items():  # centres and radii; normals stay
        x[:, :3] *= factor
        x[:, -1] *= factor
        large[kind] = x[random.permutation(len(x))[2:]]
    for name, parts in (("small", small), ("large", large)):
        registration.Model(**parts, name=name).save(tmp_path / f"{name}.json")
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = factor * turn, shift
    return str(tmp_path / "small.json"), str(tmp_path / "large.json"), matrix


@pytest.mark.parametrize("factor", [2.5, 0.3])
def test_a_similarity_of_rounds_is_told_written_and_drawn(factor, tmp_path, capsys, monkeypatch):
    query, reference, wanted = rounds(tmp_path, factor)
    output, place, drawn = tmp_path / "r.json", tmp_path / "r.png", []
    picture = import_module("bladesmith.registration.plotting.picture")
    real = picture.picture
    monkeypatch.setattr(picture, "picture", lambda *given, **rest: drawn.append(real(*given, **rest)))
    options = ["--similarity", "--quiet", "-o", str(output), "--picture", str(place)]
    assert main.run(["register", query, reference, *options]) == 0
    out = capsys.readouterr().out
    assert f"pose:        scale by {factor:g}, turn by 126.051 degrees about " in out
    assert ", then move by (0.4, -1, 2)" in out
    data = json.loads(output.read_text())
    assert data["settings"]["similarity"] is True
    assert data["scale"] == pytest.approx(factor, rel=1e-12)
    np.testing.assert_allclose(data["motor"]["matrix"], wanted, atol=1e-9)
    found, models = (
        registration.load_registration(output),
        [registration.Model.load(path) for path in (query, reference)],
    )
    assert found.scale == data["scale"]
    assert sum(found.inliers) == 16
    figure = drawn[0]
    assert f"16 of 20 objects matched, scale {factor:g}, converged" in [t.get_text() for t in figure.texts]
    before, after = figure.axes
    circles = models[0].parameters["circle"]
    for ax, color, matrix, size in ((before, picture.RED, np.eye(4), 1), (after, picture.BLUE, wanted, factor)):
        centers = circles[:, :3] @ matrix[:3, :3].T + matrix[:3, 3]
        shown = curves(ax, color)
        for center, radius in zip(centers, size * circles[:, 6], strict=True):
            assert min(np.abs(np.linalg.norm(x - center, axis=1) - radius).max() for x in shown) < 1e-9 * size


def curves(ax, color):
    """Positions (n, 3) of the strokes of a colour, whatever their opacity."""
    from matplotlib.colors import to_rgb
    from mpl_toolkits.mplot3d.art3d import Line3DCollection

    found = []
    for artist in ax.collections:
        if isinstance(artist, Line3DCollection):
            rows = np.resize(artist.get_colors(), (len(artist._segments3d), 4))
            found += [
                np.asarray(x)
                for x, c in zip(artist._segments3d, rows, strict=True)
                if np.allclose(c[:3], to_rgb(color), atol=1e-3)
            ]
    return found


def test_a_scaled_result_is_gone_on_from_only_with_a_scale(tmp_path, capsys):
    query, reference, _ = rounds(tmp_path, 2.5)
    output = str(tmp_path / "r.json")
    assert main.run(["register", query, reference, "--similarity", "--quiet", "-o", output]) == 0
    assert main.run(["register", query, reference, "--start", output, "--quiet"]) == 2
    assert "r.json: is a similarity of scale 2.5, and its motor alone" in capsys.readouterr().err
    assert main.run(["register", query, reference, "--start", output, "--similarity", "--quiet"]) == 0
    assert "scale by 2.5, " in capsys.readouterr().out


def test_planes_tell_no_scale_and_that_is_said(tmp_path, capsys):
    path = str(tmp_path / "planes.json")
    registration.Model(planes=fresh("planes", 9, np.random.default_rng(3))).save(path)
    assert main.run(["register", path, path, "--similarity"]) == 1
    assert "the objects that the models have in common do not determine a scale" in capsys.readouterr().err


def test_a_pose_that_is_not_to_be_relied_on_is_a_failure(tmp_path, capsys):
    random = np.random.default_rng(0)
    paths = [str(tmp_path / name) for name in ("a.json", "b.json")]
    for path in paths:
        registration.Model(points=random.uniform(-1, 1, (10, 3))).save(path)
    assert main.run(["register", *paths, "-o", str(tmp_path / "r.json"), "--quiet"]) == 1
    assert "converged:   no: " in capsys.readouterr().out
    assert not registration.load_registration(tmp_path / "r.json").converged


def test_motions_that_are_left_free_are_a_failure_in_words(tmp_path, capsys):
    path = str(tmp_path / "a.json")
    registration.Model(lines=[[(0, 0, z), (1, 0, 0)] for z in range(3)]).save(path)
    assert main.run(["register", path, path]) == 1
    assert "translation along (1, 0, 0)" in "".join(capsys.readouterr())


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ([], "Missing argument"),
        (["no.json", TABLE], "InputError: no.json: cannot be read: No such file"),
        (["broken.json", TABLE], "broken.json, line 1: lines[0].direction is [0.0, 0.0, 0.0]; a direction is not zero"),
        (["misspelt.json", TABLE], "line 1: lines[0].directon is not a known key; did you mean 'direction'?"),
        (["empty.json", TABLE], "InputError: the query is empty; a pose needs objects."),
        (["points.json", TABLE], "InputError: the models have no kind of object in common: points and lines."),
        ([QUERY, TABLE, "--samples", "0"], "InputError: samples is 0; a whole number from 1 to"),
        ([QUERY, TABLE, "--samples", "many"], "Invalid value for '--samples'"),
        ([QUERY, TABLE, "--seed", "-1"], "InputError: seed is -1; a whole number of at least 0"),
        ([QUERY, TABLE, "--length", "0"], "InputError: length is 0.0; "),
        ([QUERY, TABLE, "--threads", "0"], "Invalid value for '--threads'"),
        ([QUERY, TABLE, "--backend", "fortran"], "Invalid value for '--backend'"),
        ([QUERY, TABLE, "--start", "nearby"], "InputError: start is 'nearby'; one of global, proximity is needed"),
        ([QUERY, TABLE, "--start", "none.json"], "InputError: none.json: cannot be read"),
        ([QUERY, TABLE, "-o", "no/r.json"], "InputError: no/r.json: there is no folder no."),
        ([QUERY, TABLE, "-o", "r.txt"], "InputError: r.txt: registrations are written as .json or .tum, not .txt"),
        ([QUERY, TABLE, "-o", "."], "InputError: .: it is a folder."),
        ([QUERY, "empty.json", "-o", "empty.json"], "empty.json: the result would take the place of a model."),
        ([QUERY, TABLE, "--picture", "p.xyz"], "InputError: p.xyz: 'xyz' is not a format of pictures. Use one of"),
        ([QUERY, TABLE, "--picture", "p.png", "-o", "p.png"], "InputError: p.png: two results have this name."),
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

    target = {"text": "tempfile.mkstemp", "picture": "matplotlib.figure.Figure.savefig"}[when]
    monkeypatch.setattr(target, fail)
    places = {name: tmp_path / name for name in ("r.json", "p.png")}
    status = main.run(["register", QUERY, TABLE, "-o", str(places["r.json"]), "--picture", str(places["p.png"])])
    assert status == (2 if isinstance(what, OSError) else main.INTERRUPTED)
    err = capsys.readouterr().err.splitlines()[-1]
    name = places["r.json" if when == "text" else "p.png"]
    full = f"InputError: {name}: cannot be written: No space left on device."
    assert err == (full if isinstance(what, OSError) else "interrupted")
    left = [p.name for p in tmp_path.iterdir()]
    assert left == ([] if when == "text" else ["r.json"])  # which is whole
    if left:
        assert registration.load_registration(places["r.json"]).converged


CODE = """
import sys, time
from bladesmith.cli.main import main
from bladesmith.registration.search import problem as job, global_search as search
search.GlobalSearch._has_converged = lambda self, state, sets: False
tell = job.RegistrationProblem.report
def slowly(self, found):
    tell(self, found)
    print(int(found.hits[0]) if len(found.hits) else 0, flush=True)
    time.sleep(0.02)
job.RegistrationProblem.report = slowly
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
    found = registration.load_registration(tmp_path / "result.partial.json")
    assert (found.converged, found.message, found.inliers.sum()) == (False, "interrupted", 22)


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="a device of Linux")
def test_a_full_device_is_told_and_stays(tmp_path, capsys):
    link = tmp_path / "result.json"  # should it be replaced after all, then it is this link
    link.symlink_to("/dev/full")
    with pytest.raises(InputError, match="cannot be written: No space left"):
        lines_and_planes().save(link)
    lines_and_planes().save(tmp_path / "m.json")
    files = [str(tmp_path / "m.json")] * 2
    assert main.run(["register", *files, "-o", str(link)]) == 2
    assert "No space left on device" in capsys.readouterr().err
    assert link.is_symlink() and stat.S_ISCHR(os.stat("/dev/full").st_mode)


def test_an_empty_start_is_no_file(tmp_path, capsys):
    lines_and_planes().save(tmp_path / "m.json")
    assert main.run(["register", *[str(tmp_path / "m.json")] * 2, "--start", ""]) == 2
    assert "start is ''; one of global, proximity is needed" in capsys.readouterr().err


def test_drawings_are_registered_and_poses_written_as_a_trajectory(tmp_path, capsys):
    """The scan of a room in PLY, its drawing in OBJ; the pose is that of the JSON file."""
    query, reference = str(EXAMPLES / "room_scan.ply"), str(EXAMPLES / "room.obj")
    for name in ("result.json", "result.tum"):
        assert main.run(["register", query, reference, "-o", str(tmp_path / name), "--loss", "cauchy"]) == 0
    out, _ = capsys.readouterr()
    assert "of 192 segments" in out and "converged:   yes" in out
    found = registration.load_registration(tmp_path / "result.json")
    times, x = poses.load_tum(tmp_path / "result.tum")
    assert times.tolist() == list(range(1 + len(found.ambiguous)))
    np.testing.assert_allclose(x[0].to_matrix(), found.motor.to_matrix(), atol=1e-12)
    assert json.loads((tmp_path / "result.json").read_text())["settings"]["loss"] == "cauchy"
