"""Layers of pictures besides their color, and the files that hold them."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from PIL import Image

from bladesmith import tracer
from bladesmith.cli.main import run
from bladesmith.errors import BladesmithError, InputError, SceneError
from bladesmith.tracer.output import image as image_module
from bladesmith.tracer.rendering.aov_layers import layer_picture

from ...support.tracer.rendering import ALL, SIZE, same
from ...support.tracer.scenes import PICTURE

# -- layers --------------------------------------------------------------------------------------------------


def test_layers_are_what_the_middle_of_each_pixel_meets(scene, expected):
    hits = scene.intersect(*scene.camera.rays(*SIZE))
    assert hits.hit.any() and not hits.hit.all()
    np.testing.assert_allclose(expected["normal"], hits.normal, atol=1e-10)
    np.testing.assert_allclose(expected["depth"], np.where(hits.hit, hits.t, np.inf), rtol=1e-9)
    np.testing.assert_allclose(expected["alpha"], hits.alpha, atol=1e-10)
    assert np.isnan(expected["normal"][~hits.hit]).all() and np.isfinite(expected["normal"][hits.hit]).all()
    assert expected["cost"].dtype == np.int32 and expected["cost"].min() >= 1
    facing = np.einsum("ijk,ijk->ij", expected["normal"], scene.camera.rays(*SIZE)[1])
    assert (facing[hits.hit] < 0).all()


def test_layers_come_in_one_pass_with_the_picture_and_without(scene, expected):
    np.testing.assert_array_equal(expected["color"], scene.render(*SIZE))
    same(scene.layers(*SIZE, ["depth", "normal"]), {name: expected[name] for name in ("normal", "depth")})
    fine = scene.layers(*SIZE, ("color", "depth"), antialias=2)
    np.testing.assert_array_equal(fine["depth"], expected["depth"])
    np.testing.assert_array_equal(fine["color"], scene.render(*SIZE, antialias=2))
    single = scene.layers(*SIZE, ALL, dtype=np.float32)
    assert single["depth"].dtype == np.float32 and single["cost"].dtype == np.int32
    near = np.isfinite(expected["depth"]) & (expected["depth"] < 20)
    assert np.mean(np.abs(single["depth"][near] - expected["depth"][near]) < 1e-3) > 0.99


def test_a_program_has_no_layers_unless_they_are_asked_for(path):
    scene = tracer.Scene.load(path)
    scene.render(4, 3)
    assert "store_layers" not in scene.program.source and not scene.needs.layers
    (how,) = scene._bound
    scene.layers(4, 3, ["cost"])
    last = list(scene._bound)[-1]
    assert not scene._bound[how].engine.needs.layers and scene._bound[last].engine.needs.layers


@pytest.mark.parametrize("names", [["depht"], [], 3, ["color", "z"]])
def test_unknown_layers_are_refused(scene, names):
    with pytest.raises(SceneError, match="layer"):
        scene.layers(4, 3, names)
    with pytest.raises(SceneError, match="did you mean 'depth'"):
        scene.layers(4, 3, ["depht"])


def test_scenes_keep_few_drivers(scene):
    for width in range(4, 14):
        scene.render(width, 3)
    assert len(scene._bound) <= 4


# -- files ---------------------------------------------------------------------------------------------------


@pytest.mark.peers
def test_exr_files_hold_the_numbers(tmp_path, expected):
    exr = pytest.importorskip("OpenEXR")
    target = tmp_path / "a.exr"
    assert list(image_module.save_layers(target, expected)) == [target]
    with exr.File(str(target), separate_channels=True) as file:
        channels = {name: channel.pixels for name, channel in file.channels().items()}
    wanted = {"R": 0, "G": 1, "B": 2, "N.X": 0, "N.Y": 1, "N.Z": 2}
    for name, i in wanted.items():
        whole = expected["color" if name in "RGB" else "normal"]
        np.testing.assert_array_equal(channels.pop(name), whole[..., i].astype(np.float32))
    for name, layer in (("Z", "depth"), ("alpha", "alpha"), ("cost", "cost")):
        np.testing.assert_array_equal(channels.pop(name), expected[layer].astype(np.float32))
    assert not channels and [p.name for p in tmp_path.iterdir()] == ["a.exr"]
    tracer.save_image(target, 5.0 * expected["color"])  # brighter than white: linear numbers stay
    with exr.File(str(target)) as file:
        np.testing.assert_array_equal(file.channels()["RGB"].pixels, (5 * expected["color"]).astype(np.float32))


def test_layers_are_shown_in_pictures_of_their_own(tmp_path, expected):
    written = image_module.save_layers(tmp_path / "a.png", expected)
    assert sorted(p.name for p in tmp_path.iterdir()) == sorted(p.name for p in written)
    assert {p.name for p in written} == {"a.png", *(f"a.{name}.png" for name in ALL if name != "color")}
    nothing = np.isinf(expected["depth"])
    for name in ALL[1:]:
        with Image.open(tmp_path / f"a.{name}.png") as picture:
            pixels, legend = np.asarray(picture), picture.text["Description"]
        assert legend == written[tmp_path / f"a.{name}.png"] and name in legend
        assert pixels.shape == (*nothing.shape, 3)
        if name != "cost":
            assert (pixels[nothing] == 0).all()
    with Image.open(tmp_path / "a.normal.png") as picture:
        back = np.asarray(picture)[~nothing] / 127.5 - 1
    np.testing.assert_allclose(back, expected["normal"][~nothing], atol=0.01)
    near = expected["depth"][~nothing].min()
    assert f"from {near:.4g} (light)" in written[tmp_path / "a.depth.png"]


def test_colors_of_layers_follow_the_numbers():
    def light(pixels):
        return pixels.astype(float) @ (0.2126, 0.7152, 0.0722)

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        depth = np.array([[1.0, 2.0, 4.0, 1000.0, np.inf, np.nan]])
        assert (np.diff(light(layer_picture("depth", depth).pixels)[0, :4]) < 0).all()
        assert (layer_picture("depth", depth).pixels[0, 4:] == 0).all()
        cost = np.array([[0, 1, 5, 9, -1]], np.int32)
        assert (np.diff(light(layer_picture("cost", cost).pixels)[0, :4]) > 0).all()
        assert (layer_picture("cost", cost).pixels[0, 4] == 0).all() and "from 0 (dark) to 9" in layer_picture(
            "cost", cost
        ).legend
        assert "none" in layer_picture("alpha", np.full((2, 3), np.nan)).legend
        for one in (np.full((2, 3), 7.0), np.array([[0.0, 0.0, np.inf]]), np.array([[0.0, 2.0, np.inf]])):
            assert np.isfinite(light(layer_picture("depth", one).pixels)).all()
        layer_picture("normal", np.full((2, 3, 3), np.nan))


def test_what_is_no_layer_is_not_saved(tmp_path):
    for layers in ({"depth": np.zeros((2, 2, 3))}, {"z": np.zeros((2, 2))}, {"color": np.zeros((0, 4, 3))}):
        with pytest.raises(InputError):
            image_module.save_layers(tmp_path / "a.png", layers)
    assert not list(tmp_path.iterdir())


def test_formats_that_are_too_small_are_told_before_the_render(tmp_path):
    with pytest.raises(InputError, match="JPEG files have at most 65500 pixels along a side, not 70000. Take PNG"):
        image_module.check_writable(tmp_path / "a.jpg", 70000, 10)
    image_module.check_writable(tmp_path / "a.png", 70000, 10)


def test_bands_of_a_large_picture_are_encoded_alike(monkeypatch):
    picture = np.random.default_rng(0).uniform(-0.1, 1.1, (13, 7, 3))
    monkeypatch.setattr(image_module, "BAND", 20)
    np.testing.assert_array_equal(image_module._encode_image(picture), image_module.encode(picture))


# -- the command ---------------------------------------------------------------------------------------------


@pytest.mark.peers
def test_the_command_writes_layers(path, tmp_path, capsys):
    size = ["--width", "12", "--height", "9", "--antialias", "2"]
    more = ["--aov", "normal", "--aov", "depth", "--aov", "depth", "--aov", "cost", "--aov", "alpha"]
    assert run(["render", str(path), "-o", str(tmp_path / "a.png"), *size, *more]) == 0
    told = capsys.readouterr().err
    assert {p.name for p in tmp_path.iterdir()} == {"a.png", *(f"a.{name}.png" for name in ALL[1:])}
    assert all(f"a.{name}.png: {name}: " in told for name in ALL[1:]) and "12 x 9 pixels" in told
    assert run(["render", str(path), "-o", str(tmp_path / "b.exr"), *size, *more, "--quiet"]) == 0
    assert run(["render", str(path), "--aov", "dept"]) == 2
    assert "depth" in capsys.readouterr().err
    assert run(["render", "--help"]) == 0
    assert "Example: bladesmith render scene.toml -o image.png" in capsys.readouterr().out


@pytest.mark.parametrize("done", [True, 1, [True], np.zeros((2, 2)), np.zeros((3, 2), bool), "done"])
def test_pixels_that_are_done_are_bools_of_the_picture(tmp_path, done):
    with pytest.raises(BladesmithError, match="done"):
        tracer.save_image(tmp_path / "a.png", PICTURE, done)
    assert not list(tmp_path.iterdir())


def test_layers_of_one_file_have_one_size(tmp_path):
    with pytest.raises(BladesmithError, match="depth has"):
        tracer.save_layers(tmp_path / "a.exr", {"color": PICTURE, "depth": np.zeros((3, 2))})
    for layers in ({}, PICTURE):
        with pytest.raises(BladesmithError, match="layers (is|are)"):
            tracer.save_layers(tmp_path / "a.png", layers)
