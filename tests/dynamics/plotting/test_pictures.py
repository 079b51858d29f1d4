"""Trajectories in curves, pictures, films and pages."""

from __future__ import annotations

import json
import re
import sys

import numpy as np
import pytest

from bladesmith import dynamics
from bladesmith.dynamics.plotting import animation, html
from bladesmith.errors import BladesmithError, InputError, MissingExtraError

from ...support.browser import Chromium, browser
from ...support.dynamics.documents import HOSTILE


@pytest.mark.slow
def test_curves_show_the_numbers(swing):
    setup, found = swing
    figure = found.plot(sketch=setup.sketch)
    axes = {ax.get_title(loc="left").partition(" [")[0].partition(",")[0]: ax for ax in figure.axes if ax.get_visible()}
    assert list(axes) == ["center of mass", "velocity", "angular velocity", "force of the constraints",
                          "their moment about the center", "energy", "violation of the constraints"]  # fmt: skip
    for line, column in zip(axes["center of mass"].lines, found.position.T, strict=True):
        assert np.array_equal(line.get_ydata(), column)
    moment = dynamics.wrench_parts(found.reaction).moment - np.cross(
        found.position, dynamics.wrench_parts(found.reaction).force
    )
    for line, column in zip(axes["their moment about the center"].lines, moment.T, strict=True):
        assert np.allclose(line.get_ydata(), column, atol=1e-12)
    free = dynamics.Simulation(dynamics.RigidBody(1.0, (1, 1, 1), velocity=(1, 0, 0))).run(0.1, step=0.05)
    assert len([ax for ax in free.plot().axes if ax.get_visible()]) == 4
    assert len(found.plot(show=["energy"]).axes) == 1
    for names in ("angular_velocity", ["angular velocity"]):  # as an attribute is called, or as the panel is
        (ax,) = found.plot(show=names).axes
        assert ax.get_title(loc="left").startswith("angular velocity")
    with pytest.raises(InputError, match=r"show is 'velocty' \(did you mean 'velocity'\?\); one of position, velocity"):
        found.plot(show=["velocty"])


def test_pictures_show_paths_bodies_and_what_holds_them(swing, tmp_path):
    setup, found = swing
    ax = found.picture(tmp_path / "a.png", sketch=setup.sketch, shown=[0, 0.25, 0.5])
    segments = [np.asarray(s) for c in ax.collections if type(c).__name__ == "Line3DCollection" for s in c._segments3d]
    tip = found.orientation @ [0, 0, 0.5] + found.position
    assert any(s.shape == tip.shape and np.allclose(s, tip) for s in segments)
    assert sum(type(c).__name__ == "Poly3DCollection" for c in ax.collections) == 3
    assert (tmp_path / "a.png").read_bytes()[1:4] == b"PNG" and [p.name for p in tmp_path.iterdir()] == ["a.png"]
    with pytest.raises(InputError, match="'xyz' is not a format of pictures"):
        found.picture(tmp_path / "a.xyz")
    with pytest.raises(InputError, match="cannot be written: No such file"):
        found.picture(tmp_path / "no" / "a.png")


def test_labels_are_text_and_no_formula(swing, tmp_path):
    _, found = swing
    sketch = dynamics.Sketch(traces=[dynamics.Trace((0, 0, 0), HOSTILE)], title=HOSTILE)
    found.picture(tmp_path / "a.png", sketch=sketch)
    found.plot(tmp_path / "b.png", sketch=sketch, show=["energy"])
    text = html.page_text(dynamics.as_record(found, sketch), 1.0, (20, 30))
    assert "<img" not in text and text.count("</script") == 3
    data = json.loads(re.search(r'<script type="application/json" id="data">(.*?)</script>', text, re.S).group(1))
    assert data["traces"][0]["label"] == HOSTILE


@pytest.mark.slow
def test_films_have_the_pictures_they_should(swing, tmp_path):
    from PIL import Image

    setup, found = swing
    told = []
    options = {"sketch": setup.sketch, "rate": 10, "speed": 0.5, "size": (161, 120)}
    found.animate(tmp_path / "a.gif", **options, progress=lambda p: told.append((p.done, p.total)))
    film = Image.open(tmp_path / "a.gif")
    assert film.n_frames == 11 and film.info["duration"] == 100 and film.size == (160, 120)
    assert told == [(i, 11) for i in range(1, 12)]
    read_frames = pytest.importorskip("imageio_ffmpeg").read_frames
    found.animate(tmp_path / "a.mp4", **options)
    reader = read_frames(str(tmp_path / "a.mp4"))
    assert next(reader)["source_size"] == (160, 120) and sum(1 for _ in reader) == 11
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.gif", "a.mp4"]


def test_frames_are_the_stored_states_nearest_in_time(swing):
    record = dynamics.as_record(swing[1])
    numbers = animation.frame_numbers(record, 0.33, 25.0)
    times = np.arange(len(numbers)) * 0.33 / 25.0
    assert times[-1] <= 0.5 < times[-1] + 0.33 / 25
    assert np.abs(record.time[numbers] - times).max() <= 0.005 + 1e-12
    with pytest.raises(InputError, match="Raise the speed"):
        animation.frame_numbers(record, 1e-9, 25.0)


@pytest.mark.peers
def test_an_interrupted_film_leaves_nothing(swing, tmp_path):
    def interrupt(progress):
        raise KeyboardInterrupt

    for name in ("a.gif", "a.mp4"):
        with pytest.raises(KeyboardInterrupt):
            swing[1].animate(tmp_path / name, rate=5, size=(64, 64), progress=interrupt)
    assert not list(tmp_path.iterdir())


def test_what_is_missing_is_named(swing, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(MissingExtraError, match=r"pip install 'bladesmith\[video\]'"):
        swing[1].animate(tmp_path / "a.mp4")
    for name, says in (("a.avi", "films and pages are written as .gif, .mp4 or .html"), ("a\0.gif", "null character")):
        with pytest.raises(InputError, match=re.escape(says)):
            swing[1].animate(tmp_path / name)
    with pytest.raises(InputError, match="speed is 0; a positive number"):
        swing[1].animate(tmp_path / "a.html", speed=0)


@pytest.mark.browser
@pytest.mark.skipif(browser() is None, reason="no Chromium")
def test_a_page_plays_without_a_network(swing, tmp_path):
    setup, found = swing
    found.animate(tmp_path / "a.html", sketch=setup.sketch)
    with Chromium(500, 400) as seen:
        seen.open(tmp_path / "a.html")
        assert seen.value("document.body.dataset.state") == "ready"
        assert seen.value("window.bladesmith.states") == len(found)
        seen.value("window.bladesmith.show(0.25)")
        assert seen.value("document.getElementById('clock').textContent").startswith("t = 0.25")
        first = seen.picture()
        seen.value("window.bladesmith.show(0.5)")
        assert seen.picture() != first
        seen.click("#home")
        seen.click("#play")
        seen.wait("document.getElementById('play').textContent == 'Play'")
        assert not seen.complaints() and seen.requests() == [(tmp_path / "a.html").as_uri()]


def test_a_mesh_with_many_triangles_is_drawn_with_fewer():
    angles = np.linspace(0, 2 * np.pi, 200, endpoint=False)
    places = np.array(
        [[np.cos(a) * (3 + np.cos(b)), np.sin(a) * (3 + np.cos(b)), np.sin(b)] for a in angles for b in angles]
    )
    here = np.arange(len(places)).reshape(200, 200)
    right, up, both = np.roll(here, -1, 0), np.roll(here, -1, 1), np.roll(here, (-1, -1), (0, 1))
    faces = np.concatenate([np.stack([here, right, up], -1), np.stack([right, both, up], -1)]).reshape(-1, 3)
    shape = dynamics.Shape(places, faces, 1.0, np.eye(3), np.zeros((0, 2), int))
    vertices, fewer, _ = html._drawable(shape)
    assert 500 < len(fewer) <= html.MAX_FACES < len(faces)
    assert fewer.max() < len(vertices) and np.allclose(np.ptp(vertices, axis=0), np.ptp(places, axis=0), rtol=0.05)


def test_bad_sketches_are_refused():
    for make, says in (
        (lambda: dynamics.Trace((0, 0)), "3) is needed"),
        (lambda: dynamics.Trace((0, 0, 0), color="blau"), "is not a color (did you mean 'blue'?)"),
        (lambda: dynamics.Sketch(shapes=3), "shapes is 3"),
        (lambda: dynamics.Sketch({"body": 3}), "the shape of body is 3"),
        (lambda: dynamics.cone(0, 1), "the radius is 0"),
        (lambda: dynamics.cylinder(1, 1, (0, 0, 0)), "the axis is zero"),
    ):
        with pytest.raises(BladesmithError) as error:
            make()
        assert says in str(error.value)
