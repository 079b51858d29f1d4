"""Processes that are killed at any moment, and that race: some in CI, a hundred of each with BLADESMITH_FULL_BARS=1."""

from __future__ import annotations

import random
import shutil
import time

import pytest

from ...support.build.kernel_cache import PATIENCE, child, counting_compiler, needs_compiler, needs_posix, only_entry
from ...support.effort import FULL

pytestmark = [pytest.mark.slow, pytest.mark.compiles, needs_compiler, needs_posix]
COUNT = 100 if FULL else 4


@pytest.fixture(scope="module")
def seconds(tmp_path_factory: pytest.TempPathFactory) -> float:
    """How long a process takes from its begin to its answer."""
    begin = time.perf_counter()
    empty = tmp_path_factory.mktemp("cache")
    assert child({"BLADESMITH_CACHE_DIR": str(empty)}).communicate(timeout=PATIENCE)[0] == "42\n"
    return time.perf_counter() - begin


def test_after_a_kill_at_any_moment_the_next_process_works(cache_dir, seconds):
    """Whatever was written until then: nothing, a lock, a folder, half of a library, all."""
    rng = random.Random(1)
    for _ in range(COUNT):
        victim = child()
        time.sleep(rng.uniform(0.3, 1.0) * seconds)
        victim.kill()
        victim.communicate()
        assert child().communicate(timeout=PATIENCE) == ("42\n", "")
        assert not [path for path in cache_dir.iterdir() if path.name.startswith(".bs_")]
        shutil.rmtree(only_entry(cache_dir))


def test_races_build_once(cache_dir, tmp_path):
    for turn in range(COUNT):
        folder = tmp_path / str(turn)
        folder.mkdir()
        command, marker = counting_compiler(folder)
        racers = [child({"CC": command}) for _ in range(4)]
        assert [racer.communicate(timeout=PATIENCE) for racer in racers] == [("42\n", "")] * 4
        assert marker.read_text().splitlines() == ["compiled"]
