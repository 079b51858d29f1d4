"""Comparing commits: what is a loss and what is noise; and that all cases run."""

from __future__ import annotations

import subprocess
import sys
from typing import Any

import numpy as np
import pytest

from ..support.checkout import CHECKOUT

sys.path.insert(0, str(CHECKOUT / "benchmarks"))
import compare  # noqa: E402
from cases import CASES  # noqa: E402


class Stand:
    """A worker whose times are known, with the noise of a busy machine."""

    def __init__(self, seconds: float, seed: int, noise: float = 0.2) -> None:
        self.seconds, self.noise, self.random = seconds, noise, np.random.default_rng(seed)

    def ask(self, request: Any) -> float | None:
        return self.seconds * (1 + self.noise * self.random.exponential()) if request["case"] != "delta" else None


@pytest.mark.parametrize(("now", "is_lost"), [(1.0, False), (1.05, False), (1.4, True), (0.5, False)])
def test_a_loss_is_told_from_noise(now: float, is_lost: bool, capsys: pytest.CaptureFixture[str]) -> None:
    workers: list[Any] = [Stand(1e-6, 1), Stand(now * 1e-6, 2)]
    lost = compare.compare(workers[0], workers[1], ["arm_pose", "delta"], turns=21, limit=1.1)
    assert lost == (["arm_pose"] if is_lost else [])
    said = capsys.readouterr().out
    assert "not compared" in said and ("gain" in said) == (now < 0.9) and ("LOSS" in said) == is_lost


def test_the_interval_holds_the_median_of_noise() -> None:
    random = np.random.default_rng(0)
    held = 0
    for _ in range(200):
        _, low, high = compare.interval(np.exp(random.normal(scale=0.1, size=21)))
        held += low <= 1 <= high
    assert held >= 170  # 95 % of 200, and some for small samples


def test_times_are_read_with_their_unit() -> None:
    assert [compare.readable(x) for x in (2.0, 3e-3, 4.5e-6, 7e-9)] == ["2 s", "3 ms", "4.5 us", "7 ns"]


def test_bad_calls_are_told() -> None:
    for words in ([], ["a", "--figures", "b"], ["a", "--only", "nothing"]):
        command = [sys.executable, str(CHECKOUT / "benchmarks" / "compare.py"), *words]
        done = subprocess.run(command, capture_output=True)
        assert done.returncode == 2 and b"usage" in done.stderr


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_cases_run(name: str) -> None:
    result = CASES[name].prepare(np.random.default_rng(1))()
    assert result is not None
