"""Arguments of the tracer: one sentence tells what was given instead of what is needed, and nothing is drawn."""

from __future__ import annotations

import numpy as np
import pytest

from bladesmith import tracer
from bladesmith.common import memory
from bladesmith.common.validation import short_repr
from bladesmith.errors import BladesmithError, SceneError

from ...support.tracer.scenes import BALL, CAMERA, PICTURE, SCENE, TUBE

#: What no argument of these takes.
ODD = [
    1j,
    object(),
    {"center": 1},
    {1, 2, 3},
    (i for i in range(3)),
    np.array([1, 2, 3], object),
    np.array(["a", "b", "c"]),
    np.ma.masked_array([1.0, 2.0, 3.0], [False, True, False]),
    [1.0, np.nan, 3.0],
    [None, None, None],
    [True, False, True],
    np.zeros((2, 3)),
    10**400,
    np.datetime64("2020-01-01"),
    len,
]
NUMBERS = {
    "center": lambda x: tracer.Sphere(x, 1.0),
    "radius": lambda x: tracer.Sphere((0, 0, 0), x),
    "normal": lambda x: tracer.Plane(x, 0.0),
    "offset": lambda x: tracer.Plane((0, 0, 1), x),
    "camera": lambda x: tracer.Camera.look_at(x, (0, 0, 1)),
    "motor": lambda x: tracer.Camera(x, 1.0, 1.0, 1.0),
    "angle": lambda x: tracer.Camera.look_at((0, -8, 2), (0, 0, 1), field_of_view=x),
    "light": tracer.Light,
    "horizon": lambda x: tracer.Scene(CAMERA, horizon=x),
    "reflections": lambda x: tracer.Scene(CAMERA, reflections=x),
    "color": lambda x: tracer.Material(color=x),
    "share": lambda x: tracer.Material(diffuse=x),
    "material": lambda x: tracer.Sphere((0, 0, 0), 1.0, material=x),
    "align": lambda x: tracer.EvolvedCircles(TUBE, align=x),
    "gaps": lambda x: tracer.EvolvedCircles(TUBE, gaps=x),
    "caps": lambda x: tracer.EvolvedCircles(TUBE).mesh(4, 4, caps=x),
    "rings": lambda x: BALL.mesh(x, 4),
    "shift": lambda x: BALL.mesh(4, 4).transformed(1.0, x),
    "rays": lambda x: CAMERA.rays(4, x),
    "width": lambda x: SCENE.render(x, 4),
    "settings": lambda x: tracer.Scene(CAMERA, settings=x),
    "samples": lambda x: SCENE.render(4, 4, samples=x),
    "method": lambda x: SCENE.intersect((0, 0, 0), (0, 0, 1), method=x),
    "layers": lambda x: SCENE.layers(4, 4, [x]),
    "file": lambda x: tracer.save_image(x, PICTURE),
    "pixels": lambda x: tracer.save_image("a.png", x),
    "saved": lambda x: tracer.save_layers("a.png", x),
    "page": lambda x: tracer.view(SCENE, x),
    "names": lambda x: tracer.view(SCENE, names=x),
    "scene file": tracer.Scene.load,
}


@pytest.mark.parametrize("name", NUMBERS)
def test_what_is_no_argument_is_told_in_one_line(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for value in ODD:
        if name == "names" and isinstance(value, list):
            continue  # whatever three names are: there is one surface
        with pytest.raises(BladesmithError) as caught:
            NUMBERS[name](value)
        text = str(caught.value)
        assert "\n" not in text and len(text) < 300, text
    assert not list(tmp_path.iterdir())


def test_wrong_values_are_repeated_shortly():
    class Rude:
        def __repr__(self):
            raise RuntimeError

    assert short_repr(Rude()) == "a Rude"
    assert short_repr(np.zeros((2, 3))).count("\n") == 0
    assert len(short_repr("x" * 1000)) < 70
    assert memory.readable(10**400).endswith("PB") and memory.readable(1500) == "1.5 kB"


def test_light_and_colors_have_a_limit():
    for make in (
        lambda: tracer.Material(color=(0, 0, 1e10)),
        lambda: tracer.Material(specular=1e10),
        lambda: tracer.Light((0, 0, 0), (1e10, 0, 0)),
        lambda: tracer.Scene(CAMERA, zenith=(1e300, 0, 0)),
    ):
        with pytest.raises(SceneError, match=r"1e\+09"):
            make()
    bright = {"color": (1e9,) * 3, "ambient": 1e9, "diffuse": 1e9, "specular": 1e9, "shininess": 1e300}
    scene = tracer.Scene(CAMERA, [tracer.Light((4, -6, 8), (1e9,) * 3)], [BALL.with_material(bright)])
    for dtype in (np.float64, np.float32):
        assert np.isfinite(scene.render(24, 18, dtype=dtype)).all()


def test_a_surface_without_a_shape_is_refused():
    with pytest.raises(SceneError, match="no shape"):
        tracer.Surface(None)


def test_threads_are_checked_for_few_rays_too():
    scene = tracer.Scene(CAMERA, [], [BALL])
    for threads in (0, -1, "two"):
        with pytest.raises(BladesmithError, match="threads is"):
            scene.intersect((0, -5, 0), (0, 1, 0), threads=threads)
