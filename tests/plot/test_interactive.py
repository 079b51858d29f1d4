"""Interactive figures: what Python answers; in a real browser a control is dragged, and the surface follows."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bladesmith import cga3d as cga
from bladesmith import curves, errors, plot, tracer
from bladesmith.plot import packing, palette, tessellation

from ..support.browser import Chromium, browser

pytestmark = pytest.mark.peers


@pytest.fixture(scope="module", autouse=True)
def widgets() -> None:
    """Where they are missing, tests are skipped as they run: a skipped module would count where none is selected."""
    pytest.importorskip("anywidget")


def funnel(alpha: float, middle: Any) -> list[Any]:
    rings = cga.circle([(0, 0, 0), middle, (0, 0, 3)], (0, 0, 1), [0.5, 0.3 + alpha, 1.0])
    surface = tracer.EvolvedCircles(curves.KochanekBartels(rings))
    return [rings, surface.mesh(rings=16, segments=20)]


def ten(alpha: float, a: Any) -> list[Any]:
    line, sphere, plane = cga.line(a, (1, alpha, 0)), cga.sphere(a, 1.0), cga.plane((0, 0, 1), alpha)
    others = [cga.circle(a, (1, 0, 0), alpha + 0.1), cga.point(a), cga.sphere(-a, 0.5), cga.line_through(a, -a)]
    return [line, sphere, plane, line & sphere, sphere & plane, *others, cga.point_pair(a, (0, 0, alpha))]


def make_funnel() -> Any:
    return plot.show(funnel, sliders={"alpha": (0, 1)}, points={"middle": (0.3, 0, 1.5)})


def parts(widget: Any) -> list[dict[str, Any]]:
    return [part for i in range(widget.frame["objects"]) for part in getattr(widget, f"object{i}")]


def positions(widget: Any, kind: str) -> np.ndarray:
    (part,) = (p for p in parts(widget) if p["kind"] == kind)
    flat = np.frombuffer(part["positions"], "<f4").reshape(part["count"], part["corners"], 3)
    return flat + np.array(widget.setup["center"])


def ask(widget: Any, number: int, **changes: Any) -> dict[str, Any]:
    inputs = {key: {**widget.inputs[key], **changes.get(key, {})} for key in ("sliders", "points")}
    widget.set_state({"inputs": {"number": number, **inputs}})
    answer: dict[str, Any] = widget.frame
    return answer


def test_answers_are_the_objects_of_the_function() -> None:
    widget = make_funnel()
    assert widget.inputs == {"number": 0, "sliders": {"alpha": 0.5}, "points": {"middle": [0.3, 0.0, 1.5]}}
    answer = ask(widget, 7, points={"middle": [0.5, -0.25, 1.25]})
    assert answer["number"] == 7 and answer["error"] == ""
    middle = positions(widget, "strokes")[1]
    assert np.allclose(np.linalg.norm(middle - [0.5, -0.25, 1.25], axis=-1), 0.8, atol=1e-6)
    mesh = funnel(0.5, [0.5, -0.25, 1.25])[1]
    assert np.allclose(positions(widget, "faces"), mesh.vertices[mesh.faces], atol=1e-6)
    assert ask(widget, 8, sliders={"alpha": 5.0})["error"] == ""  # as far as the slider goes
    assert np.allclose(np.linalg.norm(positions(widget, "strokes")[1] - [0.5, -0.25, 1.25], axis=-1), 1.3, atol=1e-6)


def test_an_error_of_the_function_is_shown_and_forgotten() -> None:
    def fragile(a: float) -> Any:
        if a > 0.5:
            raise ValueError("too large")
        return cga.circle((0, 0, 0), (0, 0, 1), 1 + a)

    widget = plot.show(fragile, sliders={"a": (0, 1, 0.2)})
    answer = ask(widget, 1, sliders={"a": 0.9})
    before = parts(widget)
    assert answer["error"] == "ValueError: too large" and len(before) == 1
    assert "finite" in ask(widget, 2, sliders={"a": float("nan")})["error"] and parts(widget) == before
    assert ask(widget, 3, sliders={"a": 0.1})["error"] == "" and parts(widget) != before


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: plot.show(), "nothing to draw"),
        (lambda: plot.show(cga.point((1, 2, 3)), sliders={"a": (0, 1)}), "for a function"),
        (lambda: plot.show(ten, sliders={"alpha": (1, 0)}, points={"a": (0, 0, 1)}), "slider alpha"),
        (lambda: plot.show(ten, sliders={"alpha": (0, np.inf)}, points={"a": (0, 0, 1)}), "finite"),
        (lambda: plot.show(ten, sliders={"alpha": 3}, points={"a": (0, 0, 1)}), "slider alpha"),
        (lambda: plot.show(ten, sliders={"alpha": (0, 1)}, points={"a": (0, 1)}), "shape"),
        (lambda: plot.show(ten, sliders={"a b": (0, 1)}), "name of an argument"),
        (lambda: plot.show(ten, sliders={"a": (0, 1)}, points={"a": (0, 1, 2)}), "the same name"),
        (lambda: plot.show(cga.point((1, 2, 3)), height=3), "height"),
        (lambda: plot.show(lambda: cga.multivector({"no": 1.0, "ni": 1.0})), "no object is real"),
    ],
)
def test_bad_input(call: Any, message: str) -> None:
    with pytest.raises(errors.InputError, match=message):
        call()


def test_objects_alone_and_curves_are_shown() -> None:
    circles = cga.circle([(0, 0, 0), (0, 0, 2)], (0, 0, 1), [1.0, 2.0])
    widget = plot.show(curves.Bezier(circles), np.eye(3), extent=4.0)
    assert {part["kind"] for part in parts(widget)} == {"strokes", "marks"}
    assert widget.setup["half"] == [4.0, 4.0, 4.0] and widget.setup["sliders"] == []


def test_only_what_changed_is_made_and_sent_again(monkeypatch: pytest.MonkeyPatch) -> None:
    """An object that is as it was is neither read nor sent; one that is gone, goes; what is undone is sent again."""
    still = cga.sphere((0, 0, 0), 1.0)

    def scene(a: Any, n: float) -> list[Any]:
        return [cga.circle(a, (0, 0, 1), 1.0), still, cga.circle((0, 0, 0), (0, 0, 1), 2.0), cga.point(a)][: int(n)]

    widget = plot.show(scene, sliders={"n": (1, 4, 4)}, points={"a": (1, 0, 0)}, extent=5)
    sent: list[set[str]] = []
    monkeypatch.setattr(widget, "_send", lambda message, buffers=(): sent.append(set(message["state"]) - {"frame"}))
    first = [getattr(widget, f"object{i}") for i in range(4)]
    sizes: list[int] = []
    read = packing.group_items
    monkeypatch.setattr(packing, "group_items", lambda x, samples: sizes.append(x.size) or read(x, samples))
    assert ask(widget, 1, points={"a": [0, 1, 0]})["objects"] == 4
    assert {"object0", "object3"} in sent and not any("object1" in names or "object2" in names for names in sent)
    assert sorted(sizes) == [1, 1] and widget.object1 is first[1]
    sent.clear()
    ask(widget, 2, points={"a": [1, 0, 0]})  # undone
    assert {"object0", "object3"} in sent and [getattr(widget, f"object{i}") for i in range(4)] == first
    assert ask(widget, 3, sliders={"n": 1.5})["objects"] == 1 and len(parts(widget)) == 1
    assert widget.object1 == widget.object2 == widget.object3 == []
    assert ask(widget, 4, sliders={"n": 4.0})["objects"] == 4
    assert [getattr(widget, f"object{i}") for i in range(4)] == first


def test_objects_of_one_type_are_drawn_as_each_alone() -> None:
    """Single objects are read and outlined together; what each becomes is what it is by itself, of its own color."""
    rng = np.random.default_rng(5)
    centers = rng.uniform(-1, 1, (70, 3))
    several = [
        f(c) for c in centers for f in (lambda c: cga.sphere(c, 1.5), lambda c: cga.circle(c, c, 0.5), cga.point)
    ]
    box = tessellation.Box(-2 * np.ones(3), 2 * np.ones(3))
    together = packing.PackedObjects(box)
    together.update(several)
    for i in (0, 1, 2, 100, 101, 208):
        alone = packing.PackedObjects(box)
        alone.update([several[0]] * (i % len(palette.SERIES)) + [several[i]])
        assert len(alone.parts[-1]) == len(together.parts[i]) > 0
        for a, b in zip(alone.parts[-1], together.parts[i], strict=True):
            assert {**a, "colors": 0} == {**b, "colors": 0} and (a["kind"] == "strokes") == (b["kind"] == "strokes")
            shades = [np.frombuffer(p["colors"], np.uint8).reshape(-1, 4) for p in (a, b)]
            assert (np.broadcast_to(shades[0], shades[1].shape) == shades[1]).all()


@pytest.mark.slow
def test_ten_objects_are_computed_in_less_than_ten_milliseconds() -> None:
    widget = plot.show(ten, sliders={"alpha": (0, 1)}, points={"a": (0.5, 0, 0.2)})
    assert widget.frame["error"] == ""
    times = []
    for i in range(1, 40):
        begin = time.process_time()
        ask(widget, i, points={"a": [0.5 + 0.01 * i, 0, 0.2]})
        times.append(time.process_time() - begin)
    assert min(times) < 0.010


@pytest.mark.browser
@pytest.mark.skipif(browser() is None, reason="no Chromium")
def test_a_control_is_dragged_and_the_surface_follows(tmp_path: Path) -> None:
    from ..support.plot.widgets import WidgetPage

    widget = make_funnel()
    with Chromium(700, 520) as chromium:
        page = WidgetPage(chromium, widget, tmp_path)
        page.settle()
        before, first = chromium.picture(), positions(widget, "faces")
        x, y, _ = page.value("widget.placed('middle')")
        page.mouse("mousePressed", x, y)
        drawn, times = page.value("widget.drawn()"), []
        for step in range(1, 61):
            page.mouse("mouseMoved", x + step, y + 10 * np.sin(step / 6))
            page.attend()
            times.append(widget.frame["milliseconds"])
        assert page.value("widget.drawn()") - drawn > 40  # what is answered is drawn, not the last of it alone
        page.mouse("mouseReleased", x + 60, y)
        page.settle()
        now = page.value("widget.placed('middle')")
        moved = np.array(widget.inputs["points"]["middle"]) - [0.3, 0, 1.5]
        assert abs(now[0] - x - 60) < 1.5 and np.linalg.norm(moved) > 0.3
        ring, faces = positions(widget, "strokes")[1], positions(widget, "faces")
        ring = ring[np.isfinite(ring).all(-1)]  # the part in the box
        away = np.linalg.norm(ring - widget.inputs["points"]["middle"], axis=-1)
        assert len(ring) > 40 and np.allclose(away, 0.8, atol=1e-5)
        assert np.abs(faces - first).max() > 0.2 and chromium.picture() != before
        clock = "(() => { const start = performance.now(); widget.draw(); return performance.now() - start; })()"
        assert min(times) + min(page.value(clock) for _ in range(20)) < 1000 / 30  # the bar: 30 frames a second

        azimuth = page.value("widget.view.azimuth")
        page.mouse("mousePressed", 20, 20)  # not on a point: the view turns
        page.mouse("mouseMoved", 60, 20)
        page.mouse("mouseReleased", 60, 20)
        assert page.value("widget.view.azimuth") == pytest.approx(azimuth - 16)
        asked = page.answers
        chromium.value("(s => { s.value = 1; s.dispatchEvent(new Event('input')); })(document.querySelector('input'))")
        page.settle()
        assert page.answers > asked and widget.inputs["sliders"]["alpha"] == 1.0
        assert not chromium.complaints()
        chromium.value("stop()")
