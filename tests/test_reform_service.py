"""Registration as a service: results in files and pictures, work shared over executors, progress and interrupts."""

from __future__ import annotations

import json
import math
import multiprocessing
import os
import signal
import subprocess
import sys
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import reform
from bladesmith.errors import BladesmithError, InputError
from bladesmith.reform import distributed, summary, unfinished, worker
from bladesmith.reform.sketch import Sketch

CGA = bs.cga3d
EXAMPLES = Path(__file__).resolve().parent.parent / "examples" / "chapter5"
PATIENCE = 60.0  # seconds for a process on a busy machine
POSE = CGA.translator((1, 2, -0.5)) * CGA.rotor((1, 2, 3), 2.0)


def lines(n, random):
    return np.stack([random.uniform(-1, 1, (n, 3)), random.normal(size=(n, 3))], 1)


def noisy_lines(n=40, noise=0.01, wrong=0.3, seed=0):
    """A query that POSE takes to a reference, about; the first part of it does not belong there."""
    random = np.random.default_rng(seed)
    reference = lines(n, random)
    moved = reference.copy()
    moved += noise * random.normal(size=moved.shape)
    moved[: int(wrong * n)] = lines(int(wrong * n), random)
    return reform.Model(lines=moved).transformed(~POSE), reform.Model(lines=reference)


def mixed(n, seed=0):
    random = np.random.default_rng(seed)
    places, ways, sizes = (
        random.uniform(-1, 1, (5, n, 3)),
        random.normal(size=(3, n, 3)),
        random.uniform(0.1, 0.4, (2, n, 1)),
    )
    return reform.Model(
        points=places[0], point_pairs=random.uniform(-1, 1, (n, 2, 3)), lines=np.stack([places[1], ways[0]], 1),
        circles=np.hstack([places[2], ways[1], sizes[0]]), planes=np.hstack([ways[2], random.uniform(-1, 1, (n, 1))]),
        spheres=np.hstack([places[3], sizes[1]]), unit="m",
    )  # fmt: skip


def tables():
    return (reform.Model.load(EXAMPLES / name) for name in ("table_query.json", "table.json"))


def same(a, b):
    """Every bit of two results."""
    assert a.motor.values.tobytes() == b.motor.values.tobytes()
    assert [repr(s) for s in a.history] == [repr(s) for s in b.history]
    assert np.asarray(a.matches).tobytes() == np.asarray(b.matches).tobytes()
    assert np.asarray(a.inliers).tobytes() == np.asarray(b.inliers).tobytes()
    assert a.covariance.tobytes() == b.covariance.tobytes()
    assert [m.values.tobytes() for m in a.ambiguous] == [m.values.tobytes() for m in b.ambiguous]
    assert a.undetermined.values.tobytes() == b.undetermined.values.tobytes()
    for name in ("cost", "converged", "scale", "doubt", "threshold", "unit", "message"):
        assert getattr(a, name) == getattr(b, name), name
    assert a.center.tobytes() == b.center.tobytes()


# -- files ----------------------------------------------------------------------------------------------------


def unrelated():
    random = np.random.default_rng(5)
    return tuple(reform.Model(points=random.uniform(-1, 1, (12, 3)), lines=lines(3, random)) for _ in range(2))


@pytest.mark.parametrize("models", [tables, noisy_lines, unrelated, lambda: (mixed(3).transformed(~POSE), mixed(3))])
def test_results_come_back_the_same_to_the_last_bit(models, tmp_path):
    query, reference = models()
    result = reform.register(query, reference)
    place = tmp_path / "result.json"
    reform.save_registration(place, result, query, reference, seed=0, backend="c")
    same(reform.load_registration(place), result)
    data = json.loads(place.read_text(), parse_constant=pytest.fail)  # no NaN, no Infinity
    assert data["settings"] == {"seed": 0, "backend": "c"} and data["query"]["lines"] == query.counts["line"]
    assert data["made_by"]["bladesmith"] == bs.__version__


def test_a_file_has_all_that_another_program_needs(tmp_path):
    """Its matrix lays the query on what it says was matched; numbers of JSON and NumPy alone."""
    reference = mixed(4)
    query = reference.transformed(~POSE).subset(np.random.default_rng(1).permutation(len(reference)))
    reform.save_registration(tmp_path / "r.json", reform.register(query, reference))
    data = json.loads((tmp_path / "r.json").read_text())
    matrix = np.array(data["motor"]["matrix"])
    for key, kind in (("points", "point"), ("spheres", "sphere"), ("circles", "circle")):
        places, wanted = query.parameters[kind][:, :3], reference.parameters[kind][data["matches"][key]][:, :3]
        np.testing.assert_allclose(places @ matrix[:3, :3].T + matrix[:3, 3], wanted, atol=1e-12)
    assert dict(zip(data["motor"]["blades"], data["motor"]["coefficients"], strict=True)) == pytest.approx(
        {
            b: s * POSE[b]
            for s in [np.sign(POSE["1"] * data["motor"]["coefficients"][0])]
            for b in data["motor"]["blades"]
        }
    )
    assert data["covariance"]["blades"] == ["e12", "e13", "e1ni", "e23", "e2ni", "e3ni"]


def test_similarities_in_files(tmp_path):
    """The matrix holds the scale, of the pose and of others that serve; the motor comes back."""
    query, reference = tables()
    query = query.in_frame((0, 0, 0), 2.0)
    result = reform.register(query, reference, similarity=True)
    assert result.ambiguous and result.scale == pytest.approx(2, rel=1e-12)
    reform.save_registration(tmp_path / "r.json", result, query, reference)
    same(reform.load_registration(tmp_path / "r.json"), result)
    data = json.loads((tmp_path / "r.json").read_text())
    for motor, found in zip([result.motor, *result.ambiguous], [data["motor"], *data["ambiguous"]], strict=True):
        here = (motor >> CGA.point((2, 4, 6))).parameters().xyz
        np.testing.assert_allclose((np.array(found["matrix"]) @ (1, 2, 3, 1))[:3], here, rtol=1e-12)
    assert "\npose:        scale by 2, turn by " in "\n" + summary.summary(result, query, reference)
    assert summary.pose_text(CGA.dilator(2.0) * POSE).startswith("scale by 2, turn by 114.592 degrees")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda d: d.pop("motor"), r"r.json: motor is missing"),
        (lambda d: d.update(format="bladesmith-model"), r'r.json: is no registration: it has no "format"'),
        (lambda d: d.update(version=2), r"r.json: version is 2; this release reads version 1"),
        (lambda d: d["motor"]["coefficients"].pop(), r"r.json: motor.coefficients has 7 numbers; they are 8"),
        (lambda d: d["motor"].update(blades=["e1"] * 8), r"r.json: motor.blades are those of no motor"),
        (lambda d: d["covariance"]["rows"].pop(), r"r.json: covariance has 5 rows; they are 6"),
        (lambda d: d["covariance"]["rows"][0].pop(), r"r.json: covariance.rows has a row that has not 6 numbers"),
        (lambda d: d["matches"]["lines"].append(1.5), r"r.json: matches.lines\[22\] is 1.5; "),
        (lambda d: d["history"][0].update(hits="x"), r"r.json: history\[0\].hits is \"x\"; "),
        (lambda d: d.update(center=[0, 0.5]), r"r.json: center has 2 numbers; they are 3"),
        (lambda d: d.update(costs=1), r"r.json: costs is not a known key; did you mean 'cost'"),
    ],
)  # fmt: skip
def test_hostile_files_are_told_with_path_and_key(change, message, tmp_path):
    place = tmp_path / "r.json"
    reform.save_registration(place, reform.register(*tables()))
    data = json.loads(place.read_text())
    change(data)
    place.write_text(json.dumps(data))
    with pytest.raises(InputError, match=message):
        reform.load_registration(place)


def test_what_cannot_be_saved_leaves_the_old_file(tmp_path, monkeypatch):
    result, place = reform.register(*tables()), tmp_path / "r.json"
    place.write_text("old")
    for wrong, message in [
        ({"seed": np.arange(3)}, "the setting seed is a ndarray"),
        ({"seed": object()}, "is a object"),
    ]:
        with pytest.raises(InputError, match=message):
            reform.save_registration(place, result, **wrong)
    with pytest.raises(InputError, match="a dict is no registration"):
        reform.save_registration(place, {})
    with pytest.raises(InputError, match="cannot be written: No such file"):
        reform.save_registration(tmp_path / "no" / "r.json", result)
    monkeypatch.setattr(Path, "write_bytes", full_disk)
    with pytest.raises(InputError, match="cannot be written: No space left"):
        reform.save_registration(place, result)
    assert [p.name for p in tmp_path.iterdir()] == ["r.json"] and place.read_text() == "old"


def full_disk(*_, **__):
    raise OSError(28, "No space left on device")


# -- words ----------------------------------------------------------------------------------------------------


def test_poses_in_words():
    random = np.random.default_rng(2)
    for _ in range(20):
        axis, angle, shift = random.normal(size=3), random.uniform(-7, 7), random.normal(size=3)
        motor = CGA.translator(shift) * CGA.rotor(axis, angle)
        found, turn = summary.axis_angle(motor)
        assert 0 <= turn <= math.pi
        rotation = motor.to_matrix()[:3, :3]
        np.testing.assert_allclose(rotation @ found, found, atol=1e-12)
        assert np.trace(rotation) == pytest.approx(1 + 2 * math.cos(turn), abs=1e-12)
    assert (
        summary.pose_text(CGA.translator((1, 0, 1e-17)).as_kind("motor"), " m") == "no turn, then move by (1, 0, 0) m"
    )


def test_deviations_are_those_of_poses_drawn_from_the_covariance():
    query, reference = noisy_lines()
    result = reform.register(query, reference)
    random = np.random.default_rng(3)
    twists = random.multivariate_normal(np.zeros(6), result.covariance, 4000)
    matrices = CGA.wrap(CGA.kind("twist"), twists).exp().to_matrix()
    turn = np.stack([matrices[:, 2, 1], matrices[:, 0, 2], matrices[:, 1, 0]], 1)  # small: as vectors
    there = matrices[:, :3, :3] @ result.center + matrices[:, :3, 3]
    wanted = [np.sqrt(np.linalg.eigvalsh(np.cov(x.T))[-1]) for x in (turn, there)]
    np.testing.assert_allclose(summary.deviations(result), wanted, rtol=0.1)


def test_summary_says_what_is_to_be_relied_on():
    query, reference = tables()
    text = summary.summary(reform.register(query, reference), query, reference)
    for part in ("22 of 22 lines", "converged:   yes", "10^-", "other pose", " m\n", "degrees and"):
        assert part in text
    query, reference = unrelated()
    text = summary.summary(reform.register(query, reference), query, reference)
    assert "converged:   no: " in text and "of 12 points" in text


# -- pictures -------------------------------------------------------------------------------------------------


def artists(ax):
    """Segments, and marks, by colour."""
    from matplotlib.colors import to_hex
    from mpl_toolkits.mplot3d.art3d import Line3DCollection, Path3DCollection

    found = {}
    for artist in ax.collections:
        if isinstance(artist, Line3DCollection):
            for segment, color in zip(
                artist._segments3d, np.resize(artist.get_colors(), (len(artist._segments3d), 4)), strict=True
            ):
                found.setdefault(to_hex(color), []).append(np.asarray(segment))
        elif isinstance(artist, Path3DCollection):
            found.setdefault(to_hex(artist.get_facecolors()[0]), []).append(np.stack(artist._offsets3d, 1))
    return found


def on_line(segment, line):
    away = segment - line[:3]
    return np.linalg.norm(away - (away @ line[3:])[:, None] * line[3:], axis=1).max()


def test_pictures_show_every_line_where_it_is():
    query, reference = noisy_lines()
    result = reform.register(query, reference)
    figure = reform.picture(result, query, reference)
    before, after = figure.axes
    red, black, blue, green = (reform.picture.__globals__[n] for n in ("RED", "BLACK", "BLUE", "GREEN"))
    found = artists(before)
    for color, model in ((red, query), (black, reference)):
        assert max(map(on_line, found[color], model.parameters["line"])) < 1e-9
    found, rows = artists(after), reference.parameters["line"]
    matched = np.zeros(len(reference), bool)
    matched[result.matches["lines"][result.inliers["lines"]]] = True
    assert 0 < matched.sum() < len(matched)
    assert len(found[green]) == matched.sum() and len(found[black]) == (~matched).sum()
    assert max(map(on_line, found[green], rows[matched])) < 1e-9
    assert max(map(on_line, found[black], rows[~matched])) < 1e-9
    moved = query.transformed(result.motor).parameters["line"]
    assert max(map(on_line, found[blue], moved)) < 1e-9
    for segment, match in zip(
        found[blue], result.matches["lines"], strict=True
    ):  # matched lines are drawn side by side
        if match >= 0:
            other = Sketch(reference).segments[match]
            assert np.abs(np.linalg.norm(segment - other, axis=1)).max() < 0.2
    assert [t.get_text() for t in after.get_legend().get_texts()] == [
        "reference, without a match (12)", "reference, matched (28)", "query, moved (40, 12 without a match)"
    ]  # fmt: skip


def test_pictures_have_equal_axes_and_nothing_outside():
    query, reference = noisy_lines()
    for ax in reform.picture(reform.register(query, reference), query, reference).axes:
        limits = np.array([ax.get_xlim3d(), ax.get_ylim3d(), ax.get_zlim3d()])
        sides = np.diff(limits)[:, 0]
        np.testing.assert_allclose(ax._box_aspect / ax._box_aspect[0], sides / sides[0], rtol=1e-6)
        for segments in artists(ax).values():
            for segment in segments:
                assert (segment > limits[:, 0]).all() and (segment < limits[:, 1]).all()


def test_lines_end_where_others_pass_however_the_model_is_turned():
    """The table's legs are drawn from the rails to the top, and no further; so are those of the moved table."""
    query, table = tables()
    legs = np.abs(table.parameters["line"][:, 5]) > 0.9
    ends = np.sort(Sketch(table).segments[legs][:, :, 2], axis=1)
    assert (np.abs(ends - (0.15, 0.75)) < 0.1).all()
    lengths = [np.sort(np.linalg.norm(np.diff(Sketch(m).segments, axis=1), axis=2).ravel()) for m in (query, table)]
    np.testing.assert_allclose(*lengths, rtol=0.2)


@pytest.mark.parametrize("n", [2, 12])
def test_pictures_of_all_kinds(n, tmp_path):
    from PIL import Image

    reference = mixed(n)
    query = reference.transformed(~POSE)
    result = reform.register(query, reference)
    for suffix in ("png", "svg"):
        reform.picture(result, query, reference, tmp_path / f"p.{suffix}", show="after", title="Mixed")
    with Image.open(tmp_path / "p.png") as picture:
        assert picture.size == (800, 600)
        colors = np.asarray(picture.convert("RGB")).reshape(-1, 3)
        assert (np.ptp(colors, axis=1) > 60).mean() > 0.02  # something green and blue is there
    assert "Mixed" in (tmp_path / "p.svg").read_text() or "<path" in (tmp_path / "p.svg").read_text()
    assert sorted(p.name for p in tmp_path.iterdir()) == ["p.png", "p.svg"]


def test_a_query_far_away_is_drawn_nearer_and_that_is_told():
    query, reference = noisy_lines()
    far = query.transformed(CGA.translator((1e4, 0, 0)))
    ax = reform.picture(reform.register(far, reference), far, reference, show="before").axes[0]
    assert "away, drawn nearer" in ax.get_legend().get_texts()[1].get_text()
    assert np.ptp(ax.get_xlim3d()) < 100


def test_what_has_no_picture_is_told(tmp_path, monkeypatch):
    query, reference = tables()
    result = reform.register(query, reference)
    other = reform.Model(lines=[[(0, 0, 0), (1, 0, 0)]])
    for arguments, message in [
        ((result, query, reference, None, "later"), "show is 'later'"),
        ((result, other, reference), "lines of the models are not those that were registered"),
        ((result, query, other), "lines of the models are not those that were registered"),
        ((None, query, reference), "the result is a NoneType"),
        ((result, query, {}), "the reference is a dict"),
        ((result, query, reference, tmp_path / "p.xyz"), "'xyz' is no format of pictures.*png"),
        ((result, query, reference, tmp_path / "p"), "its suffix.*none"),
    ]:
        with pytest.raises(InputError, match=message):
            reform.picture(*arguments[:4], **({"show": arguments[4]} if len(arguments) > 4 else {}))
    monkeypatch.setattr("matplotlib.figure.Figure.savefig", full_disk)
    with pytest.raises(OSError, match="No space left"):
        reform.picture(result, query, reference, tmp_path / "p.png")
    assert not list(tmp_path.iterdir())


def test_models_alone_are_drawn_with_colours_of_their_own():
    _, table = tables()
    colors = ["#2f9461"] * 11 + ["#22303c"] * 11
    ax = reform.draw_model(
        table, color={"lines": colors}, label="table", motor=CGA.translator((5, 0, 0)).as_kind("motor")
    )
    found = artists(ax)
    assert {c: len(s) for c, s in found.items()} == {"#2f9461": 11, "#22303c": 11}
    assert min(s[:, 0].min() for s in found["#2f9461"]) > 4


# -- executors ------------------------------------------------------------------------------------------------


@pytest.fixture
def small_pieces(monkeypatch):
    """Also few samples are shared, and models are asked for before they are sent."""
    for name, value in (("SAMPLES", 2), ("OBJECTS", 400), ("CARRIED", 0)):
        monkeypatch.setattr(distributed, name, value)


@pytest.fixture(scope="module")
def models():
    return noisy_lines()


@pytest.fixture(scope="module")
def expected(models):
    return reform.register(*models, seed=7)


class Counting(Executor):
    """Counts what is sent on; may end the worker that gets a certain call."""

    def __init__(self, pool, deadly=None):
        self.pool, self.deadly, self.sent, self.payloads = pool, deadly, 0, []

    def submit(self, function, /, *arguments):
        self.sent += 1
        self.payloads.append(arguments[1])
        return self.pool.submit(os._exit, 3) if self.sent == self.deadly else self.pool.submit(function, *arguments)


@pytest.mark.parametrize("start", ["global", "proximity"])
def test_threads_of_an_executor_give_the_same(start, models, small_pieces):
    expected = reform.register(*models, seed=7, start=start)
    with ThreadPoolExecutor(2) as pool:
        counting = Counting(pool)
        same(reform.register(*models, seed=7, start=start, executor=counting), expected)
    assert counting.sent > 20


def test_little_work_is_not_shared(models, expected):
    counting = Counting(None)
    same(reform.register(*models, seed=7, executor=counting), expected)
    assert counting.sent == 0


def test_processes_give_the_same_are_sent_models_once_and_their_death_is_told(models, expected, small_pieces):
    with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("spawn")) as pool:
        counting = Counting(pool)
        same(reform.register(*models, seed=7, executor=counting), expected)
        carried = [p for p in counting.payloads if p is not None]
        assert counting.sent > 20 and len(carried) < counting.sent / 2 and len(set(carried)) <= 2
        with pytest.raises(distributed.WorkerError, match="workers failed: BrokenProcessPool: .*without executor="):
            reform.register(*models, seed=7, executor=Counting(pool, 15))
        with pytest.raises(distributed.WorkerError, match="workers failed: BrokenProcessPool"):
            reform.register(*models, seed=7, executor=pool)


def test_a_cluster_gives_the_same_also_when_a_worker_dies(models, expected, small_pieces, tmp_path):
    dask = pytest.importorskip("dask.distributed")
    from dask import config

    with (
        config.set({"temporary-directory": str(tmp_path), "distributed.scheduler.allowed-failures": 3}),
        dask.Client(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=":0") as client,
    ):
        executor, living = client.get_executor(), list(client.run(os.getpid).values())
        assert len(set(living)) == 2 and os.getpid() not in living
        same(reform.register(*models, seed=7, executor=executor), expected)

        def kill_one(step):
            while len(living) > 1:
                os.kill(living.pop(), signal.SIGTERM if os.name == "nt" else signal.SIGKILL)

        same(reform.register(*models, seed=7, executor=executor, progress=kill_one), expected)


def test_what_is_no_executor_is_refused(models, small_pieces):
    for wrong, message in (
        (object(), "it is a object"),
        (ThreadPoolExecutor, "it is ThreadPoolExecutor"),
        (3, "a int"),
    ):
        with pytest.raises(InputError, match=f"the executor takes no work: .*{message}"):
            reform.register(*models, executor=wrong)
    pool = ThreadPoolExecutor(1)
    pool.shutdown()
    with pytest.raises(InputError, match="takes no work: RuntimeError.*shutdown"):
        reform.register(*models, executor=pool)


def test_workers_of_another_version_say_so(models, small_pieces, monkeypatch):
    with ThreadPoolExecutor(1) as pool:
        for name, value, message in (
            ("__version__", "0.0.1", "a worker has bladesmith 0.0.1, the models come from"),
            ("_program_digest", lambda kinds: "other", "a worker has another bladesmith"),
        ):
            packed = worker.Sent.packed

            def swapped(self, packed=packed, name=name, value=value):
                found = packed(self)
                monkeypatch.setattr(worker, name, value)
                return found

            monkeypatch.setattr(worker.Sent, "packed", swapped)
            with pytest.raises(BladesmithError, match=message):
                reform.register(*models, executor=pool)
            monkeypatch.undo()
            for part, small in (("SAMPLES", 2), ("OBJECTS", 400), ("CARRIED", 0)):
                monkeypatch.setattr(distributed, part, small)


def test_a_failing_piece_is_tried_twice(models, expected, small_pieces):
    class Failing(Counting):
        """The second piece of every stage fails, so often."""

        def submit(self, function, /, *arguments):
            _, place, tries, _ = arguments[-1].split()
            if place == "1" and int(tries) < self.deadly:
                self.sent += 1
                return self.pool.submit(divmod, 1, 0)
            return self.pool.submit(function, *arguments)

    with ThreadPoolExecutor(2) as pool:
        failing = Failing(pool, 1)
        same(reform.register(*models, seed=7, executor=failing), expected)
        assert failing.sent > 2
        with pytest.raises(distributed.WorkerError, match="workers failed: ZeroDivisionError") as caught:
            reform.register(*models, seed=7, executor=Failing(pool, 2))
    assert isinstance(caught.value.__cause__, ZeroDivisionError)


# -- progress and interrupts ----------------------------------------------------------------------------------


def test_progress_is_told_in_steps(models, capsys):
    steps = []
    result = reform.register(*models, progress=steps.append)
    assert steps and all(isinstance(s, reform.Step) for s in steps)
    assert [s.candidates for s in steps] == sorted(s.candidates for s in steps)
    assert max(s.tolerance for s in steps) == result.history[-2].tolerance
    with pytest.raises(InputError, match="progress is a int"):
        reform.register(*models, progress=3)
    assert capsys.readouterr().err == ""


def test_a_bar_is_shown_where_it_is_asked_for(models, capsys, monkeypatch):
    monkeypatch.setattr("bladesmith.reform.progress.PATIENCE", 0)
    reform.register(*models, progress=True)
    assert "motors" in capsys.readouterr().err


def test_an_interrupt_returns_the_best_so_far(models, small_pieces):
    query, reference = tables()

    def stop(step):
        if step.hits > 10:
            raise KeyboardInterrupt

    found = reform.register(query, reference, progress=stop)
    assert (found.converged, found.message, found.ambiguous) == (False, unfinished.INTERRUPTED, [])
    assert found.inliers.sum() == 22
    moved = (found.motor >> query.lines) * ~reference.lines[np.asarray(found.matches)]  # 1 or -1
    assert np.abs(np.abs(moved.values) - (np.arange(moved.values.shape[-1]) == 0)).max() < 1e-9
    with ThreadPoolExecutor(1) as pool:  # which is left alone from then on
        assert reform.register(*models, progress=stop, executor=pool).message == unfinished.INTERRUPTED


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
