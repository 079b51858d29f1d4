"""What a first user of registration stumbled over: results used as arrays, objects in plain lists, arguments of the
wrong type, interrupts between the scales of a similarity, devices in the place of files.
"""

import os
import pickle
import signal
import stat
import threading

import numpy as np
import pytest

from bladesmith import cga3d, reform
from bladesmith.cli import main
from bladesmith.errors import BladesmithError, InputError
from bladesmith.files import write_atomically

POSE = cga3d.translator((3, -2, 0.5)) * cga3d.rotor((1, 2, 3), 2.5)


def model(seed=0, lines=12, planes=6):
    random = np.random.default_rng(seed)
    return reform.Model(
        lines=np.stack([random.uniform(-1, 1, (lines, 3)), random.normal(size=(lines, 3))], axis=1),
        planes=np.hstack([random.normal(size=(planes, 3)), random.uniform(-1, 1, (planes, 1))]),
    )


def found(seed=0):
    reference = model(seed)
    return reform.register(reference.transformed(~POSE).subset(range(2, 18)), reference)


def far(motor, truth=POSE):
    return min(float(np.abs((motor - sign * truth).values).max()) for sign in (1, -1))


# -- results as arrays -------------------------------------------------------------------------------------


def test_matches_and_inliers_are_used_as_arrays_over_all_objects():
    result = found()
    right = np.r_[2:12, 0:6]
    matches, inliers = result.matches, result.inliers
    assert far(result.motor) < 1e-12
    assert np.array_equal(np.array(matches), right) and matches.tolist() == right.tolist()
    assert (matches == right).all() and not (matches != right).any() and (right == matches).all()
    assert (matches >= 0).sum() == inliers.sum() == np.sum(inliers) == len(matches) == matches.size == 16
    assert matches.shape == (16,) and matches.dtype == np.int64 and inliers.dtype == bool
    assert inliers.all() and inliers.mean() == 1.0 and not (~inliers).any() and (inliers & (matches > 0)).sum() == 15
    assert matches[0] == 2 and matches[-1] == 5 and matches[inliers].max() == matches.max() == 11
    assert np.where(matches < 0, 0, matches).dtype == np.int64 and (matches + 1).sum() == right.sum() + 16


def test_matches_are_read_by_kind_and_cannot_be_changed_by_accident():
    matches = found().matches
    assert matches["lines"].tolist() == matches["line"].tolist() == list(range(2, 12))
    assert "lines" in matches and "plane" in matches and "circles" not in matches
    assert 11 in matches and -1 not in matches
    assert [(kind, len(values)) for kind, values in matches.items()] == [("lines", 10), ("planes", 6)]
    assert dict(matches).keys() == dict(matches.items()).keys() == {"lines", "planes"}
    with pytest.raises(ValueError, match="read-only"):
        matches.sort()
    with pytest.raises(TypeError):
        matches += 1
    with pytest.raises(AttributeError, match="PerItem has no attribute 'rows'"):
        matches.rows  # noqa: B018
    again = pickle.loads(pickle.dumps(matches))
    assert (again == matches).all() and again.keys() == matches.keys()
    array = np.array(matches)
    array[0] = -1  # a copy
    assert matches[0] == 2


# -- what objects and arguments may be ---------------------------------------------------------------------


@pytest.mark.parametrize("method", ["direct", "optimize", "linear"])
def test_objects_of_several_kinds_in_one_list(method):
    reference = model()
    query = reference.transformed(~POSE)
    mixed = [[m.planes[0], m.lines[0], m.planes[1], m.lines[1], m.lines[2]] for m in (query, reference)]
    assert far(reform.estimate_rotor(*mixed, method=method)) < 1e-9
    batches = [[m.lines, m.planes] for m in (query, reference)]
    assert far(reform.estimate_rotor(*batches, method=method)) < 1e-9
    assert far(reform.estimate_rotor(list(query.lines), list(reference.lines), method=method)) < 1e-9


@pytest.mark.parametrize("method", ["direct", "optimize", "linear"])
@pytest.mark.parametrize("kind", ["lines", "circles", "point_pairs"])
def test_holes_of_a_plate_turn_about_the_axis_that_they_share(kind, method):
    places = [(0, 0, 0), (1, 0, 0), (0, 2, 0), (3, 1, 0), (-1, -1, 0)]
    rows = {
        "lines": [[place, (0, 0, 1)] for place in places],
        "circles": [(*place, 0, 0, 1, 0.5) for place in places],
        "point_pairs": [[place, (place[0], place[1], 1)] for place in places],
    }
    plate = reform.Model(**{kind: rows[kind]})
    found = reform.estimate_rotor(plate.transformed(~POSE), plate, method=method, details=True)
    assert found.cost < 1e-20 and len(found.undetermined) == (kind == "lines")
    assert kind == "lines" or far(found.motor) < 1e-9


def test_lines_and_circles_in_one_list_stay_what_they_are():
    line, circle = cga3d.line((0, 0, 0), (1, 0, 0)), cga3d.circle((1, 2, 3), (0, 1, 1), 0.5)
    matching = reform.match([circle, line, line], [line, circle])
    assert matching.indices["circles"].tolist() == [0] and matching.indices["lines"].tolist() == [0, 0]
    with pytest.raises(InputError, match="the query's objects.* is no multivector"):
        reform.match([line, circle, 3], [line])
    with pytest.raises(BladesmithError, match=r"the query's objects\[1\] are a motor"):
        reform.match([line, POSE], [line])


@pytest.mark.parametrize("backend", [["c"], {}, np.array([1, 2]), None, b"c", "C", 3])
def test_backends_that_are_none(backend):
    with pytest.raises(InputError, match="backend is .*; there are: c, numba, cuda"):
        reform.register(model(), model(), backend=backend)


@pytest.mark.parametrize("length", [np.inf, np.nan, 0, -1.0, True, np.True_, "1", b"1"])
def test_lengths_that_are_none(length):
    for run in (reform.register, reform.estimate_rotor, reform.iterate):
        with pytest.raises(InputError, match="length is .*; a positive number is needed"):
            run(model(), model(), length=length)


@pytest.mark.parametrize("seed", [-1, 1.5, "x", None, True, np.nan, {}])
def test_seeds_that_are_none(seed):
    for run in (reform.register, reform.estimate_rotor):
        with pytest.raises(InputError, match="seed is .*; a whole number of at least 0 is needed"):
            run(model(), model(), seed=seed)


def test_a_start_that_is_not_finite_is_refused():
    for run in (reform.register, reform.estimate_rotor, reform.iterate):
        with pytest.raises(InputError, match="start is not finite"):
            run(model(), model(), start=POSE * np.nan)


def test_an_empty_model_is_drawn_as_nothing():
    pytest.importorskip("matplotlib")
    ax = reform.draw_model(reform.Model())
    assert not ax.collections and not ax.lines
    with pytest.raises(InputError, match="the model is a NoneType"):
        reform.draw_model(None)


# -- interrupts and files ----------------------------------------------------------------------------------


def test_one_interrupt_ends_all_the_scales_of_a_similarity():
    interrupts = []

    def once(step):
        if not interrupts:
            interrupts.append(step)
            os.kill(os.getpid(), signal.SIGINT)

    query = model()
    result = reform.register(query, query.transformed(cga3d.dilator(3.0) * POSE), similarity=True, progress=once)
    assert interrupts and result.message == "interrupted" and not result.converged


def test_an_interrupt_of_the_first_round_returns_where_it_started(monkeypatch):
    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("bladesmith.reform.sampling._lots", interrupted)
    reference = model()
    result = reform.register(reference.transformed(~POSE), reference, start=POSE)
    assert result.message == "interrupted" and result.inliers.all() and far(result.motor) < 1e-12


def test_subsets_of_matches_are_drawn_in_blocks_and_are_the_same(monkeypatch):
    query, reference = model().transformed(cga3d.rotor((0, 0, 1), 0.1)), model()
    whole = reform.register(query, reference, start="proximity", samples=100)
    monkeypatch.setattr("bladesmith.reform.sampling.BLOCK", 60)  # three subsets of 18 matches
    parts = reform.register(query, reference, start="proximity", samples=100)
    assert np.array_equal(whole.motor.values, parts.motor.values) and whole.doubt == parts.doubt
    assert [step.candidates for step in whole.history] == [step.candidates for step in parts.history]


def test_what_is_no_file_is_written_to_and_not_replaced(tmp_path):
    pipe, read = tmp_path / "pipe", []
    os.mkfifo(pipe)
    reader = threading.Thread(target=lambda: read.append(pipe.read_bytes()), daemon=True)
    reader.start()
    write_atomically(pipe, b"whole" * 100_000)  # more than a pipe holds
    reader.join(10)
    assert read == [b"whole" * 100_000] and stat.S_ISFIFO(pipe.stat().st_mode)
    assert [p.name for p in tmp_path.iterdir()] == ["pipe"]


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="a device of Linux")
def test_a_full_device_is_told_and_stays(tmp_path, capsys):
    link = tmp_path / "result.json"  # should it be replaced after all, then it is this link
    link.symlink_to("/dev/full")
    with pytest.raises(InputError, match="cannot be written: No space left"):
        model().save(link)
    model().save(tmp_path / "m.json")
    files = [str(tmp_path / "m.json")] * 2
    assert main.run(["register", *files, "-o", str(link)]) == 1
    assert "No space left on device" in capsys.readouterr().err
    assert link.is_symlink() and stat.S_ISCHR(os.stat("/dev/full").st_mode)


def test_an_empty_start_is_no_file(tmp_path, capsys):
    model().save(tmp_path / "m.json")
    assert main.run(["register", *[str(tmp_path / "m.json")] * 2, "--start", ""]) == 2
    assert "start is ''; it is one of global, proximity" in capsys.readouterr().err
