"""Rendering as a service: layers, formats, executors, interrupts, full disks, sizes that are mistakes."""

from __future__ import annotations

import errno
import multiprocessing
import os
import re
import signal
import subprocess
import sys
import time
import warnings
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image

from bladesmith import tracer
from bladesmith.cli.main import run
from bladesmith.errors import BladesmithError, InputError, SceneError
from bladesmith.tracer import bands, memory, options, pictures
from bladesmith.tracer import image as image_module
from bladesmith.tracer.layers import LAYERS, shown
from bladesmith.tracer.pictures import RenderError, RenderInterrupted

ALL = tuple(LAYERS)
SIZE = (60, 40)
PATIENCE = 60.0  # seconds for a process on a busy machine
SCENE = """
[camera]
position = [0.0, -8.0, 2.0]
look_at = [0.0, 0.0, 0.5]

[[lights]]
position = [4.0, -6.0, 8.0]

[[surfaces]]
kind = "sphere"
center = [1.5, 0.0, 0.5]
radius = 0.5

[[surfaces]]
kind = "plane"
normal = [0, 0, 1]
reflectivity = 0.2

[[surfaces]]
kind = "evolved_circles"
controls = [
    { center = [-1, 0, 0], normal = [0, 0, 1], radius = 1.0 },
    { center = [-1, 1, 2], normal = [0, 0.5, 1], radius = 0.6 },
]
"""


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    place = tmp_path_factory.mktemp("scene") / "scene.toml"
    place.write_text(SCENE)
    return place


@pytest.fixture(scope="module")
def scene(path):
    return tracer.Scene.load(path)


@pytest.fixture(scope="module")
def expected(scene):
    return scene.layers(*SIZE, ALL)


def same(found, wanted):
    assert found.keys() == wanted.keys()
    for name, values in wanted.items():
        np.testing.assert_array_equal(found[name], values, err_msg=name)
        assert found[name].dtype == values.dtype


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
    assert "#define BS_SCENE_LAYERS 0" in scene.program.source and not scene.needs.layers
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
        assert (np.diff(light(shown("depth", depth).pixels)[0, :4]) < 0).all()
        assert (shown("depth", depth).pixels[0, 4:] == 0).all()
        cost = np.array([[0, 1, 5, 9, -1]], np.int32)
        assert (np.diff(light(shown("cost", cost).pixels)[0, :4]) > 0).all()
        assert (shown("cost", cost).pixels[0, 4] == 0).all() and "from 0 (dark) to 9" in shown("cost", cost).legend
        assert "none" in shown("alpha", np.full((2, 3), np.nan)).legend
        for one in (np.full((2, 3), 7.0), np.array([[0.0, 0.0, np.inf]]), np.array([[0.0, 2.0, np.inf]])):
            assert np.isfinite(light(shown("depth", one).pixels)).all()
        shown("normal", np.full((2, 3, 3), np.nan))


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
    np.testing.assert_array_equal(image_module._encoded(picture), image_module.encode(picture))


# -- executors -----------------------------------------------------------------------------------------------


def test_bands_cover_the_rows_once():
    for width, height, grid, payload in (
        (640, 480, 1, 1000),
        (1, 1, 1, 10),
        (9, 50000, 3, 10),
        (4000, 3000, 4, 1 << 27),
    ):
        pieces = bands.bands(width, height, grid, payload)
        assert [a for a, _ in pieces] == [0, *(b for _, b in pieces[:-1])] and pieces[-1][1] == height
        assert all(a < b for a, b in pieces) and len(pieces) <= bands.MOST
    assert len(bands.bands(4000, 3000, 4, 1 << 27)) == bands.FEWEST


@pytest.fixture
def small_bands(monkeypatch):
    monkeypatch.setattr(bands, "RAYS_PER_BAND", 200)


def test_threads_of_an_executor_render_the_same(scene, expected, small_bands):
    told = []
    with ThreadPoolExecutor(2) as pool:
        found = scene.layers(*SIZE, ALL, executor=pool, progress=lambda done, total: told.append((done, total)))
        np.testing.assert_array_equal(scene.render(*SIZE, executor=pool, threads=2), expected["color"])
        single = scene.layers(*SIZE, ALL, executor=pool, dtype=np.float32, antialias=2)
        same(single, scene.layers(*SIZE, ALL, dtype=np.float32, antialias=2))
    same(found, expected)
    assert told[-1] == (2400, 2400) and len(told) > 5


def test_processes_render_the_same_and_their_death_is_told(scene, expected, small_bands):
    with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("spawn")) as pool:
        same(scene.layers(*SIZE, ALL, executor=pool), expected)
        with pytest.raises(RenderError, match=r"rows \d+ to \d+ were not rendered: BrokenProcessPool") as caught:
            scene.layers(*SIZE, ALL, executor=Deadly(pool))
    partial = caught.value.partial
    assert partial.share < 1 and np.isnan(partial.image[~partial.done]).all()
    np.testing.assert_array_equal(partial.image[partial.done], expected["color"][partial.done])


class Deadly(Executor):
    """Sends work on, and once a call that ends the worker."""

    def __init__(self, pool):
        self.pool, self.calls = pool, 0

    def submit(self, function, /, *arguments, **named):
        self.calls += 1
        return self.pool.submit(os._exit, 3) if self.calls == 4 else self.pool.submit(function, *arguments)


def test_a_cluster_renders_the_same(scene, expected, small_bands, tmp_path, monkeypatch):
    distributed = pytest.importorskip("dask.distributed")
    monkeypatch.chdir(tmp_path)
    options = {"processes": True, "n_workers": 2, "threads_per_worker": 1, "dashboard_address": None}
    with distributed.Client(**options) as client:
        same(scene.layers(*SIZE, ALL, executor=client.get_executor()), expected)
        workers = client.run(os.getpid)
        assert len(set(workers.values())) == 2 and os.getpid() not in workers.values()


def test_what_is_no_executor_is_refused(scene):
    with pytest.raises(InputError, match="takes no work"):
        scene.render(*SIZE, executor=object())
    pool = ThreadPoolExecutor(1)
    pool.shutdown()
    with pytest.raises(InputError, match="takes no work.*shutdown"):
        scene.render(*SIZE, executor=pool)


def test_workers_of_another_version_say_so(scene, small_bands, monkeypatch):
    monkeypatch.setattr(bands, "_unpacked", bands._unpacked.__wrapped__)
    how = options.picture_view({}, *SIZE, ("color",), "isolate", 64, 1, np.float64)
    sent = scene._sent(how).packed()
    monkeypatch.setattr(bands, "__version__", "0.0.1")
    with pytest.raises(BladesmithError, match="a worker has bladesmith 0.0.1, the scene comes from"):
        bands.render_band(sent, SIZE, (0, 4), 1)
    monkeypatch.undo()
    monkeypatch.setattr(bands, "_unpacked", bands._unpacked.__wrapped__)
    monkeypatch.setattr(bands, "_digest", lambda *_: "of other sources")
    with pytest.raises(BladesmithError, match="a worker has another bladesmith"):
        bands.render_band(sent, SIZE, (0, 4), 1)


# -- interrupts ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("how", ["serial", "threads", "executor"])
def test_an_interrupt_hands_on_what_is_done(scene, expected, how, monkeypatch, small_bands):
    monkeypatch.setattr(pictures, "RAYS_PER_CHUNK", 100)

    def stop(done, total):
        if done > total / 3:
            raise KeyboardInterrupt

    with ThreadPoolExecutor(1) as pool, pytest.raises(KeyboardInterrupt) as caught:
        scene.layers(
            *SIZE, ALL, threads=1 if how == "serial" else 2, progress=stop, executor=pool if how == "executor" else None
        )
    assert isinstance(caught.value, RenderInterrupted)
    partial = caught.value.partial
    assert 0.3 < partial.share < 1 and partial.share == partial.done.mean()
    for name, values in partial.layers.items():
        np.testing.assert_array_equal(values[partial.done], expected[name][partial.done])
        missing = values[~partial.done]
        assert (missing == -1).all() if name == "cost" else np.isnan(missing).all()


def test_partial_pictures_are_transparent_where_nothing_is_done(tmp_path):
    picture, done = np.full((4, 6, 3), np.nan), np.zeros((4, 6), bool)
    done[:2] = True
    picture[done] = 0.5
    for name in ("a.png", "a.webp", "a.tiff"):
        tracer.save_image(tmp_path / name, picture, done)
        with Image.open(tmp_path / name) as file:
            np.testing.assert_array_equal(np.asarray(file)[..., 3] == 255, done)
    tracer.save_image(tmp_path / "a.jpg", picture, done)
    with Image.open(tmp_path / "a.jpg") as file:
        assert np.asarray(file)[3].max() < 10 < np.asarray(file)[0].min()


SLOW = ("--width", "240", "--height", "160", "--antialias", "60")  # a minute's work


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
@pytest.mark.parametrize("suffix", [".png", ".exr"])
def test_an_interrupted_command_leaves_a_partial_picture(path, tmp_path, suffix, scene):
    target = tmp_path / f"image{suffix}"
    target.write_bytes(b"old")
    scene.layers(4, 3, ["color", "depth"])  # compiled
    arguments = ["render", str(path), "-o", str(target), *SLOW, "--aov", "depth", "--progress", "--threads", "2"]
    process = subprocess.Popen(
        [sys.executable, "-m", "bladesmith", *arguments], stderr=subprocess.PIPE, start_new_session=True
    )
    try:
        shown = b""
        while not re.search(rb"\b[1-9]\d?%", shown):  # some of the picture is done
            piece = os.read(process.stderr.fileno(), 4096)
            assert piece, shown
            shown += piece
        assert b"<" in shown  # the remaining time
        sent = time.perf_counter()
        process.send_signal(signal.SIGINT)
        rest = process.stderr.read()
        assert process.wait(PATIENCE) == 1 and time.perf_counter() - sent < 20
    finally:
        process.kill()
        process.wait()
        process.stderr.close()
    line = rest.decode().splitlines()[-1]
    share = float(re.match(r"interrupted with ([\d.]+) % of the picture done: ", line)[1]) / 100
    assert 0 < share < 1 and line.endswith(f"image.partial{suffix}" if suffix == ".exr" else "image.partial.depth.png")
    partial = tmp_path / f"image.partial{suffix}"
    others = {"image.partial.depth.png"} if suffix == ".png" else set()
    assert {p.name for p in tmp_path.iterdir()} == {target.name, partial.name, *others}
    assert target.read_bytes() == b"old"
    if suffix == ".png":
        with Image.open(partial) as picture:
            assert picture.size == (240, 160)
            seen = np.asarray(picture)[..., 3] == 255
        assert abs(seen.mean() - share) < 0.01


def test_an_interrupt_before_the_first_pixel_writes_nothing(path, tmp_path, monkeypatch, capsys):
    def stop(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(pictures, "parallel", SimpleNamespace(run=stop))
    assert run(["render", str(path), "-o", str(tmp_path / "a.png"), "--quiet"]) == 1
    assert capsys.readouterr().err == "interrupted before the first pixels were done; nothing was written\n"
    assert not list(tmp_path.iterdir())


# -- disks, folders, sizes ------------------------------------------------------------------------------------


@contextmanager
def small_disk(folder):
    folder.mkdir()
    try:
        done = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=64k", "tmpfs", str(folder)], capture_output=True)
    except OSError:
        pytest.skip("no mount on this machine: root may")
    if done.returncode:
        pytest.skip("only root may mount a small disk")
    try:
        yield
    finally:
        subprocess.run(["umount", str(folder)], check=True)


@pytest.mark.parametrize("suffix", [".png", ".jpg", ".tiff", ".exr"])
def test_a_full_disk_leaves_the_old_file(tmp_path, suffix, expected):
    noise = np.random.default_rng(0).uniform(size=(500, 500, 3))
    folder = tmp_path / "disk"
    with small_disk(folder):
        target = folder / f"a{suffix}"
        tracer.save_image(target, expected["color"][:8, :8])
        before = target.read_bytes()
        with pytest.raises(OSError, match="No space left") as caught:
            tracer.save_image(target, noise)
        assert target.read_bytes() == before and [p.name for p in folder.iterdir()] == [target.name]
        assert caught.value.filename == str(target)


@pytest.mark.parametrize("full", [1, 2])
def test_a_picture_that_does_not_fit_goes_where_there_is_room(path, tmp_path, monkeypatch, capsys, full):
    """A long render is not lost with the disk, nor is anything left where there is no room at all."""
    save, spare = Image.Image.save, tmp_path / "spare"
    spare.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(spare))
    calls = []

    def failing(self, file, *rest, **named):
        calls.append(file)
        file.write(b"half")
        if len(calls) <= full:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        file.seek(0)
        save(self, file, *rest, **named)

    monkeypatch.setattr(Image.Image, "save", failing)
    target = tmp_path / "a.png"
    assert run(["render", str(path), "-o", str(target), "--width", "8", "--height", "6", "--quiet"]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert f"{target}: No space left on device" in line and not target.exists()
    found = list(spare.rglob("*.png"))
    if full == 1:
        assert f"The picture is in {found[0]}." in line
        with Image.open(found[0]) as picture:
            assert picture.size == (8, 6)
    else:
        assert not list(spare.iterdir())


def test_folders_that_take_no_files_are_told_before_the_render(path, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(tracer.Scene, "layers", lambda *_, **__: pytest.fail("rendered"))
    (tmp_path / "folder.png").mkdir()
    targets = [tmp_path / "none" / "a.png", tmp_path / "folder.png", tmp_path / "a.gif", tmp_path / "a"]
    if os.path.isdir("/proc/self"):
        targets.append(Path("/proc/a.png"))  # nobody can make a file there, root neither
    for target in targets:
        assert run(["render", str(path), "-o", str(target)]) == 2
        (line,) = capsys.readouterr().err.splitlines()
        assert line.startswith(f"InputError: {target}: ")


@pytest.mark.parametrize(
    ("size", "message"),
    [
        ((0, 5), "width is 0; it is a whole number of at least 1"),
        ((5, -3), "height is -3; it is a whole number"),
        ((2.5, 3), "width is 2.5"),
        ((10**6, 2), "width is 1000000; it is a whole number from 1 to 65536"),
        ((2, 10**6), "height is 1000000; it is a whole number from 1 to 65536"),
        ((10**6, 10**6), r"a picture of 1000000 x 1000000 pixels takes 37 TB of memory; \d[\d.]* .?B are free"),
        ((10**30, 10**30), "width is 1000000000000000000000000000000; it is a whole number from 1 to 65536"),
        ((2, 10**400), r"height is 10+\.\.; it is a whole number from 1 to 65536"),
    ],
)
def test_sizes_that_are_mistakes_are_refused_before_anything_is_allocated(scene, size, message, monkeypatch):
    monkeypatch.setattr(tracer.Scene, "_ready", lambda *_: pytest.fail("compiled"))
    monkeypatch.setattr(np, "empty", lambda *_, **__: pytest.fail("allocated"))
    with pytest.raises(SceneError, match=message):
        scene.render(*size)


def test_memory_that_does_not_suffice_is_told_with_numbers(path, scene, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(memory, "available", lambda: 50_000)
    scene.render(30, 20)
    with pytest.raises(SceneError, match="a picture of 60 x 40 pixels takes 88.8 kB of memory; 50 kB are free"):
        scene.render(*SIZE)
    with pytest.raises(SceneError, match="takes 252 kB"):
        scene.layers(*SIZE, ALL)
    target = tmp_path / "a.png"
    assert run(["render", str(path), "-o", str(target), "--width", "1000000", "--height", "1000000"]) == 2
    assert capsys.readouterr().err.startswith("SceneError: a picture of 1000000 x 1000000 pixels takes 37 TB")
    monkeypatch.setattr(memory, "available", lambda: None)

    def empty(*_, **__):
        raise MemoryError

    monkeypatch.setattr(pictures.LAYERS["color"].__class__, "empty", empty)
    with pytest.raises(SceneError, match="takes 88.8 kB of memory$"):
        scene.render(*SIZE)


def test_memory_is_what_the_system_and_the_container_leave(tmp_path, monkeypatch):
    assert memory.available() is None or memory.available() > 1e6
    limit, info = tmp_path / "max", tmp_path / "meminfo"
    monkeypatch.setattr(memory, "_LIMITS", (limit, tmp_path / "missing"))
    monkeypatch.setattr(memory, "_MEMINFO", info)
    info.write_text("MemTotal: 9000 kB\nMemAvailable:    4000 kB\n")
    limit.write_text("max\n")
    assert memory.available() == 4_096_000
    limit.write_text("1000000\n")
    assert memory.available() == 1_000_000
    assert [memory.readable(x) for x in (999, 1000, 24e12)] == ["999 bytes", "1 kB", "24 TB"]


# -- the command ---------------------------------------------------------------------------------------------


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
