"""Rendering as a service: interrupts, full disks, folders that take no files, sizes that are mistakes."""

from __future__ import annotations

import errno
import os
import re
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image

from bladesmith import tracer
from bladesmith.cli.main import run
from bladesmith.common import memory
from bladesmith.errors import InputError, SceneError
from bladesmith.tracer.rendering import canvas, engines, render_jobs
from bladesmith.tracer.rendering.canvas import RenderInterrupted

from ...support.tracer.rendering import ALL, SIZE

PATIENCE = 60.0  # seconds for a process on a busy machine


# -- interrupts ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("how", ["serial", "threads", "executor"])
def test_an_interrupt_hands_on_what_is_done(scene, expected, how, monkeypatch, small_bands):
    monkeypatch.setattr(engines.Engine, "chunk", 100)

    def stop(progress):
        if progress.done > progress.total / 3:
            raise KeyboardInterrupt

    with ThreadPoolExecutor(1) as pool, pytest.raises(KeyboardInterrupt) as caught:
        scene.layers(
            *SIZE, ALL, threads=1 if how == "serial" else 2, progress=stop, executor=pool if how == "executor" else None
        )
    assert isinstance(caught.value, RenderInterrupted)
    partial = caught.value.partial
    assert 0.3 < partial.fraction_done < 1 and partial.fraction_done == partial.done.mean()
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
@pytest.mark.parametrize("suffix", [".png", pytest.param(".exr", marks=pytest.mark.peers)])
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
        return
    with pytest.importorskip("OpenEXR").File(str(partial), separate_channels=True) as file:
        channels = {name: channel.pixels for name, channel in file.channels().items()}
    assert set(channels) == {"A", "B", "G", "R", "Z"} and channels["R"].shape == (160, 240)
    seen = channels["A"] == 1
    assert abs(seen.mean() - share) < 0.01 and np.isin(channels["A"], (0, 1)).all()
    assert all(np.isfinite(channels[name]).all() for name in "RGB") and (channels["R"][~seen] == 0).all()
    whole = scene.layers(240, 160, ["depth"])["depth"].astype(np.float32)
    np.testing.assert_array_equal(channels["Z"][seen], whole[seen])


def test_an_interrupt_before_the_first_pixel_writes_nothing(path, tmp_path, monkeypatch, capsys):
    def stop(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(render_jobs, "parallel", SimpleNamespace(run=stop))
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


@pytest.mark.parametrize("suffix", [".png", ".jpg", ".tiff", pytest.param(".exr", marks=pytest.mark.peers)])
def test_a_full_disk_leaves_the_old_file(tmp_path, suffix, expected):
    noise = np.random.default_rng(0).uniform(size=(500, 500, 3))
    folder = tmp_path / "disk"
    with small_disk(folder):
        target = folder / f"a{suffix}"
        tracer.save_image(target, expected["color"][:8, :8])
        before = target.read_bytes()
        with pytest.raises(InputError, match="cannot be written: No space left") as caught:
            tracer.save_image(target, noise)
        assert target.read_bytes() == before and [p.name for p in folder.iterdir()] == [target.name]
        assert caught.value.where == str(target)


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
    assert run(["render", str(path), "-o", str(target), "--width", "8", "--height", "6", "--quiet"]) == full
    (line,) = capsys.readouterr().err.splitlines()
    assert f"{target}: cannot be written: No space left on device" in line and not target.exists()
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
        ((0, 5), "width is 0; a positive whole number is needed"),
        ((5, -3), "height is -3; a positive whole number"),
        ((2.5, 3), "width is 2.5"),
        ((10**6, 2), "width is 1000000; a whole number from 1 to 65536 is needed"),
        ((2, 10**6), "height is 1000000; a whole number from 1 to 65536 is needed"),
        ((10**6, 10**6), r"a picture of 1000000 x 1000000 pixels takes 37 TB of memory; \d[\d.]* .?B are free"),
        ((10**30, 10**30), "width is 1000000000000000000000000000000; a whole number from 1 to 65536 is needed"),
        ((2, 10**400), r"height is 10+\.\.\.0+; a whole number from 1 to 65536 is needed"),
    ],
)
def test_sizes_that_are_mistakes_are_refused_before_anything_is_allocated(scene, size, message, monkeypatch):
    monkeypatch.setattr(tracer.Scene, "_bound_scene", lambda *_: pytest.fail("compiled"))
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

    monkeypatch.setattr(canvas.LAYERS["color"].__class__, "empty", empty)
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
