"""The kernel cache between processes and threads: races, kills, damaged entries, forks."""

import hashlib
import json
import logging
import os
import shutil
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from bladesmith.codegen.build import cache
from bladesmith.codegen.build import extension as build
from bladesmith.codegen.build.extension import load

from ...support.build.kernel_cache import (
    ADD,
    CHILD,
    PATIENCE,
    child,
    counting_compiler,
    needs_compiler,
    needs_posix,
    only_entry,
)


@needs_compiler
@needs_posix
def test_racing_processes_build_once(cache_dir, tmp_path):
    command, marker = counting_compiler(tmp_path, before="sleep 0.3")
    racers = [child({"CC": command}) for _ in range(4)]
    answers = [racer.communicate(timeout=PATIENCE) for racer in racers]
    assert answers == [("42\n", "")] * 4
    assert marker.read_text().splitlines() == ["compiled"]


@needs_compiler
def test_racing_threads_build_once(cache_dir, caplog):
    caplog.set_level(logging.INFO, "bladesmith")
    start = threading.Barrier(4)

    def race(_):
        start.wait()
        return load(ADD)

    with ThreadPoolExecutor(4) as pool:
        modules = set(map(id, pool.map(race, range(4))))
    assert len(modules) == 1
    assert len(caplog.records) == 1


@needs_compiler
@needs_posix
def test_killed_in_mid_compile_then_works(cache_dir, tmp_path):
    pause = tmp_path / "pause"
    pause.write_text("")
    pid_file = tmp_path / "pid"
    command, marker = counting_compiler(
        tmp_path, f'if [ -e "{pause}" ]; then echo $$ > "{pid_file}"; exec sleep 60; fi'
    )
    victim = child({"CC": command})
    deadline = time.monotonic() + PATIENCE
    while not (pid_file.exists() and pid_file.read_text().strip()):
        assert time.monotonic() < deadline and victim.poll() is None
        time.sleep(0.02)
    victim.send_signal(signal.SIGKILL)
    victim.communicate()
    assert list(cache_dir.glob(".bs_raced*"))
    pause.unlink()
    try:
        assert child({"CC": command}).communicate(timeout=PATIENCE) == ("42\n", "")
    finally:
        os.kill(int(pid_file.read_text()), signal.SIGKILL)
    assert marker.read_text().splitlines() == ["compiled"] * 2
    assert not list(cache_dir.glob(".bs_raced*")), "the folder of the killed process is swept"


def flip_a_byte(folder: Path) -> None:
    library = folder / (folder.name + cache.LIBRARY_SUFFIX)
    content = bytearray(library.read_bytes())
    content[len(content) // 2] ^= 0xFF
    library.unlink()  # never write into a library that this process has mapped
    library.write_bytes(content)


def truncate(folder: Path) -> None:
    library = folder / (folder.name + cache.LIBRARY_SUFFIX)
    content = library.read_bytes()
    library.unlink()
    library.write_bytes(content[:100])


def lie(folder: Path) -> None:
    """A file that is what its record says, and no library."""
    truncate(folder)
    content = (folder / (folder.name + cache.LIBRARY_SUFFIX)).read_bytes()
    record = {"size": len(content), "sha256": hashlib.sha256(content).hexdigest()}
    (folder / "entry.json").write_text(json.dumps(record))


@pytest.mark.compiles
@needs_compiler
@pytest.mark.parametrize(
    ("damage", "warned"),
    [
        (flip_a_byte, True),
        (truncate, True),
        (lambda folder: (folder / (folder.name + cache.LIBRARY_SUFFIX)).unlink(), True),
        (lambda folder: (folder / "entry.json").write_text("{"), True),
        (lambda folder: (folder / "entry.json").write_text("[]"), True),
        (lambda folder: (folder / "entry.json").unlink(), True),
        (lambda folder: shutil.rmtree(folder), False),
        (lie, False),
    ],
    ids=[
        "flipped",
        "truncated",
        "no library",
        "bad record",
        "odd record",
        "no record",
        "gone",
        "no code inside",
    ],
)
def test_damaged_entry_is_rebuilt(cache_dir, damage, warned):
    """In new processes: Python itself remembers the libraries of this one."""
    assert child().communicate(timeout=PATIENCE) == ("42\n", "")
    damage(only_entry(cache_dir))
    answer, errors = child().communicate(timeout=PATIENCE)
    assert answer == "42\n"
    assert ("is damaged; building it again" in errors) == warned
    assert len(errors.splitlines()) == int(warned)
    assert child().communicate(timeout=PATIENCE) == ("42\n", "")


@needs_compiler
def test_private_directory_goes_with_its_process(tmp_path):
    (tmp_path / "file").write_text("")
    text = CHILD + "\nfrom bladesmith.codegen.build import cache\nprint(cache._private[0])"
    done = subprocess.run(
        [sys.executable, "-c", text], capture_output=True, text=True, timeout=PATIENCE,
        env={**os.environ, cache.DIRECTORY_VARIABLE: str(tmp_path / "file" / "cache")},
    )  # fmt: skip
    answer, private = done.stdout.split()
    assert answer == "42" and not Path(private).exists()


@needs_compiler
@needs_posix
def test_forked_child_can_load(cache_dir):
    module = load(ADD)
    with build._loading._guard:  # as held by another thread at the moment of the fork
        pid = os.fork()
        if pid == 0:
            os._exit(0 if load(ADD) is module else 1)
    assert os.waitpid(pid, 0)[1] == 0
