"""Pictures: what is where, antialiasing and precision, files and the command."""

from __future__ import annotations

import copy
import pickle
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from bladesmith import tracer
from bladesmith.cli.main import run
from bladesmith.errors import InputError, SceneError
from bladesmith.tracer.output import image as image_module

from ...support.checkout import CHECKOUT
from ...support.tracer.scenes import CAMERA, dark

EXAMPLES = CHECKOUT / "examples" / "scenes"
DEMO = Path(tracer.__file__).parent / "io" / "data" / "demo.toml"
MATT = {"specular": 0.0, "ambient": 0.0, "diffuse": 1.0}


def middle_of(mask):
    rows, columns = np.nonzero(mask)
    return rows.mean(), columns.mean()


def test_row_0_is_the_top_and_x_runs_to_the_right():
    def ball(center, color):
        return tracer.Sphere(center, 0.4, material={"color": color, "ambient": 1.0, "diffuse": 0.0, "specular": 0.0})

    scene = dark(CAMERA, [], [ball((2, 0, 1), (1, 0, 0)), ball((0, 0, 2.5), (0, 0, 1)), ball((-2, 0, 1), (0, 1, 0))])
    image = scene.render(80, 60)
    assert image.shape == (60, 80, 3) and image.dtype == np.float64
    red, blue, green = (middle_of(image[..., c] > 0.5) for c in (0, 2, 1))
    assert red[1] > 50 and green[1] < 30 and abs(blue[1] - 39.5) < 0.6
    assert blue[0] < 20 and abs(red[0] - 29.5) < 2 and abs(green[0] - 29.5) < 2


def test_pictures_agree_with_rays():
    """The fused driver and `Camera.rays` with `Scene.intersect` see the same surfaces."""
    scene = tracer.Scene.load(DEMO)
    glowing = tracer.Material(color=(1, 1, 1), ambient=1.0, diffuse=0.0, specular=0.0)
    flat = dark(scene.camera, [], [surface.with_material(glowing) for surface in scene.surfaces])
    seen = flat.render(60, 40)[..., 0] > 0.5
    hits = flat.intersect(*scene.camera.rays(60, 40))
    np.testing.assert_array_equal(seen, hits.hit)
    assert set(np.unique(hits.surface)) == {-1, *range(len(scene.surfaces))}


@pytest.mark.compiles
@pytest.mark.parametrize("far", [(1e6, 0, 0), (1e6, -2e6, 3e6)])
def test_pictures_do_not_care_where_the_scene_lies(far):
    def picture(shift):
        surfaces = [
            tracer.Plane((0, 0, 1), shift[2], material={"reflectivity": 0.1}),
            tracer.Sphere(shift + (1.3, -0.9, 0.6), 0.6, material={"reflectivity": 0.7}),
            tracer.Disc(shift + (1.6, 2.2, 1.7), (-0.35, -1, 0.05), 1.2, material={"reflectivity": 0.8}),
            tracer.EvolvedCircles(
                [(shift + (-0.7, 0.3, 0.02), (0, 0, 1), 1.2), (shift + (-0.5, 0.3, 2.05), (0.15, -1, 0.2), 1.2)]
            ),
        ]
        camera = tracer.Camera.look_at(shift + (1.6, -8.6, 3.4), shift + (0, 0.2, 1.0))
        lights = [tracer.Light(shift + (-6, -7, 9), (0.9, 0.8, 0.7)), tracer.Light(shift + (7, -4, 6), (0.3, 0.4, 0.5))]
        scene = tracer.Scene(camera, lights, surfaces)
        return scene, scene.layers(120, 90, ["color", "depth", "normal"])

    _, here = picture(np.zeros(3))
    scene, there = picture(np.array(far, float))
    different = np.abs(there["color"] - here["color"]).max(axis=-1)
    assert np.median(different) < 1e-5 and (different > 1 / 255).sum() <= 4  # pixels on an edge
    hits = scene.intersect(*scene.camera.rays(120, 90))
    both = hits.hit & np.isfinite(there["depth"])
    assert (hits.hit != np.isfinite(there["depth"])).sum() <= 2
    away = np.abs(there["depth"] - hits.t)[both] / hits.t[both]
    assert np.percentile(away, 99) < 1e-7
    assert np.percentile(np.abs(there["normal"] - hits.normal)[both], 99) < 1e-7


def test_threads_antialiasing_and_precision():
    scene = tracer.Scene.load(DEMO)
    one = scene.render(64, 48, threads=1, antialias=1)
    np.testing.assert_array_equal(scene.render(64, 48, threads=3, antialias=1), one)
    fine = scene.render(32, 24, antialias=4)
    coarse = one.reshape(24, 2, 32, 2, 3).mean(axis=(1, 3))
    assert np.abs(fine - coarse).mean() < 0.03
    single = scene.render(64, 48, antialias=1, dtype=np.float32)
    assert single.dtype == np.float32
    assert np.mean(np.abs(single - one).max(axis=-1) > 0.02) < 0.02


def test_the_file_says_the_size(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(GOOD + "[render]\nwidth = 12\nheight = 9\nantialias = 2\nreflections = 1\n")
    scene = tracer.Scene.load(path)
    assert scene.render().shape == (9, 12, 3) and scene.render(height=5).shape == (5, 12, 3)
    np.testing.assert_array_equal(scene.render(), scene.render(antialias=2))
    assert scene.reflections == 1


def test_progress_is_told():
    told = []
    tracer.Scene.load(EXAMPLES / "orientation.toml").render(100, 90, progress=lambda p: told.append((p.done, p.total)))
    assert told[-1] == (9000, 9000) and all(a[0] < b[0] for a, b in zip(told, told[1:], strict=False))


# -- files ---------------------------------------------------------------------------------------------------


def test_the_bundled_scene_is_the_example():
    assert DEMO.read_text() == (EXAMPLES / "demo.toml").read_text()


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.toml")), ids=lambda p: p.stem)
def test_examples_render(path):
    image = tracer.Scene.load(path).render(32, 24)
    assert np.isfinite(image).all() and image.std() > 0.02


def test_pictures_are_srgb(tmp_path):
    levels = np.array([0.0, 0.001, 0.18, 0.5, 1.0, 7.0, -1.0, np.inf])
    tracer.save_image(tmp_path / "a.png", np.repeat(levels[None, :, None], 3, axis=2))
    with Image.open(tmp_path / "a.png") as picture:
        assert np.asarray(picture)[0, :, 0].tolist() == [0, 3, 118, 188, 255, 255, 0, 255]
    assert [p.name for p in tmp_path.iterdir()] == ["a.png"]


@pytest.mark.parametrize(
    ("image", "message"),
    [
        (np.array([[[0.0, 0.0, 0.0], [0.0, np.nan, 0.0]]]), "NaN in 1 pixels .* row 0, column 1"),
        (np.zeros((2, 2, 3), complex), "real numbers"),
        (np.zeros((2, 2)), "shape"),
    ],
)
def test_what_is_no_picture_is_not_saved(image, message, tmp_path):
    with pytest.raises(InputError, match=message):
        tracer.save_image(tmp_path / "a.png", image)
    assert not list(tmp_path.iterdir())


def test_a_file_that_cannot_be_made_is_told_by_the_name_that_was_given(tmp_path, monkeypatch):
    def refused(*_, **__):
        raise FileNotFoundError(2, "No such file or directory", "/hidden/.a.png.x1")

    monkeypatch.setattr("tempfile.mkstemp", refused)
    with pytest.raises(InputError, match="No such file") as caught:
        tracer.save_image(tmp_path / "a.png", np.zeros((2, 2, 3)))
    assert caught.value.where == str(tmp_path / "a.png") and "hidden" not in str(caught.value)


def test_scenes_and_surfaces_can_be_pickled_after_use():
    scene = tracer.Scene(
        tracer.Camera.look_at((0, -8, 0), (0, 0, 0)), [tracer.Light((0, -8, 8))], [tracer.Sphere((0, 0, 0), 1.0)]
    )
    image = scene.render(8, 6)
    scene.surfaces[0].intersect((0, -8, 0), (0, 1, 0))
    again = pickle.loads(pickle.dumps(scene))
    np.testing.assert_array_equal(again.render(8, 6), image)
    assert copy.deepcopy(scene).surfaces[0].intersect((0, -8, 0), (0, 1, 0)).count == 2


@pytest.mark.parametrize(
    ("table", "expected"),
    [
        ("[render]\nreflections = 2000", "render.reflections is 2000; it is at most 1000."),
        (
            '[[surfaces]]\nkind = "sphere"\ncenter = [0, 0, 0]\nradius = 1\nchecker = [0, 0, 0]',
            "line 8: surfaces[0].checker is not a key of 'sphere'; it is for 'plane'",
        ),
    ],
)
def test_messages_of_scene_files_are_sentences(table, expected, tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text("[camera]\nposition = [0, -8, 0]\nlook_at = [0, 0, 0]\n" + table)
    with pytest.raises(SceneError) as caught:
        tracer.Scene.load(path)
    assert expected in str(caught.value) and str(caught.value).endswith(".")


def test_an_interrupted_save_leaves_the_old_picture(tmp_path, monkeypatch):
    target = tmp_path / "a.png"
    target.write_bytes(b"old")

    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(Image.Image, "save", interrupted)
    with pytest.raises(KeyboardInterrupt):
        tracer.save_image(target, np.zeros((2, 2, 3)))
    assert target.read_bytes() == b"old" and [p.name for p in tmp_path.iterdir()] == ["a.png"]


@pytest.mark.parametrize(("name", "message"), [("a.xyz", "format"), ("none/a.png", "no folder"), ("a", "format")])
def test_pictures_that_cannot_be_saved_are_refused_early(name, message, tmp_path):
    with pytest.raises(InputError, match=message):
        image_module.check_writable(tmp_path / name)


GOOD = """
[camera]
position = [0.0, -8.0, 2.0]
look_at = [0.0, 0.0, 0.0]

[[lights]]
position = [4.0, -6.0, 8.0]

[[surfaces]]
kind = "sphere"
center = [1.5, 0.0, 0.5]
radius = 0.5
"""
EVOLVED = """
[[surfaces]]
kind = "evolved_circles"
controls = [
  {center = [0, 0, 0], normal = [0, 0, 1], radius = 1},
  {center = [0, 1, 2], normal = [0, 0.5, 1], radius = 1},
]
"""


@pytest.mark.parametrize(
    ("old", "new", "line", "words"),
    [
        ("radius = 0.5", "radios = 0.5", 12, ["surfaces[0].radios", "did you mean 'radius'"]),
        ("radius = 0.5", "radius = -0.4", 12, ["surfaces[0].radius", "-0.4"]),
        ("radius = 0.5", "radius = nan", 12, ["surfaces[0].radius", "finite"]),
        ("position = [0.0, -8.0, 2.0]", "position = [0.0, inf, 2.0]", 3, ["camera.position", "finite"]),
        ('kind = "sphere"', 'kind = "spehre"', 10, ["did you mean 'sphere'"]),
        ("look_at = [0.0, 0.0, 0.0]", "look_at = [0.0, -8.0, 2.0]", 4, ["camera.look_at", "own position"]),
        ("look_at = [0.0, 0.0, 0.0]", "look_at = [0.0, 0.0]", 4, ["camera.look_at"]),
        ("center = [1.5, 0.0, 0.5]", 'center = ["a", 0.0, 0.5]', 11, ["surfaces[0].center"]),
        ("radius = 0.5", "radius = 0.5\nreflectivity = 2", 13, ["reflectivity"]),
        ("normal = [0, 0.5, 1]", "normal = [0, 0, 0]", 18, ["controls[1].normal", "zero"]),
        ("[[lights]]", "[[lights]", 6, []),
    ],
)
def test_scene_files_are_checked(old, new, line, words, tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text((GOOD + EVOLVED).replace(old, new))
    with pytest.raises(SceneError) as caught:
        tracer.Scene.load(path)
    text = str(caught.value)
    assert "scene.toml" in text and f"line {line}" in text, text
    assert all(word in text for word in words), text


def test_the_command_renders(tmp_path, capsys):
    scene, target = tmp_path / "scene.toml", tmp_path / "out.png"
    scene.write_text(GOOD + EVOLVED)
    size = ["--width", "40", "--height", "30"]
    assert run(["render", str(scene), "-o", str(target), *size, "--quiet"]) == 0
    with Image.open(target) as picture:
        assert picture.size == (40, 30)
    assert capsys.readouterr().err == ""
    assert run(["render", str(scene), "-o", str(target), *size, "--progress", "--method", "sampled"]) == 0
    assert "40 x 30" in capsys.readouterr().err
    scene.write_text(GOOD.replace("radius", "radios"))
    assert run(["render", str(scene), "-o", str(target)]) == 2
    assert "did you mean 'radius'" in capsys.readouterr().err
    assert run(["render", str(tmp_path / "missing.toml"), "-o", str(target)]) == 2
    assert run(["render", str(scene), "-o", str(tmp_path / "no" / "out.png")]) == 2
    assert run(["render", str(scene), "--method", "guess"]) == 2


def test_an_interrupted_render_leaves_no_file(tmp_path, monkeypatch):
    scene, target = tmp_path / "scene.toml", tmp_path / "out.png"
    scene.write_text(GOOD)

    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(tracer.Scene, "layers", interrupted)
    assert run(["render", str(scene), "-o", str(target), "--quiet"]) == 1
    assert [p.name for p in tmp_path.iterdir()] == ["scene.toml"]
