"""The page of a report chooses the cheapest method for an error, in a real browser."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from bladesmith.benchmarks import Case, Study, write_report
from bladesmith.benchmarks.harness.runner import Measurement

from ..support.browser import Chromium, browser

pytestmark = [pytest.mark.browser, pytest.mark.skipif(browser() is None, reason="no Chromium")]


def row(method: str, case: str, error: float, time: float, lost: int = 0) -> Measurement:
    return Measurement(method, "n", "", case, "ordinary", 10, error, "", lost, "", time, "")


def studies() -> list[tuple[Study, list[Measurement]]]:
    cases = (Case("near", lambda rng, n: None), Case("far </script>", lambda rng, n: None))
    plain: Any = Study("first", "First & <best>", (), cases, lambda x: x, lambda a, b, c: a, "radians")
    rows = [
        row("exact", "near", 1e-15, 2e3), row("exact", "far </script>", 1e-14, 3e3),
        row("quick", "near", 1e-7, 10.0), row("quick", "far </script>", 1e-3, 20.0),
        row("lossy", "near", 1e-15, 1.0, lost=1), row("lossy", "far </script>", 1e-15, 1.0),
        row("partial", "near", 1e-15, 5.0),
    ]  # fmt: skip
    other = replace(plain, name="second", title="Second")
    return [(plain, rows), (other, [row("wrong", "near", float("nan"), 1.0, lost=10), row("right", "near", 0.5, 4e6)])]


def test_the_cheapest_method_that_is_exact_enough(tmp_path: Path) -> None:
    page = write_report(studies(), tmp_path)
    with Chromium() as chromium:
        chromium.open(page)

        def found(error: str, case: str = "", study: str = "first") -> list[str]:
            chromium.value(
                f"study.value = {study!r}; study.dispatchEvent(new Event('change')); which.value = {case!r};"
                f"error.value = {error!r}; error.dispatchEvent(new Event('input'))"
            )
            text: Any = chromium.value("document.getElementById('found').innerText")
            return [" ".join(line.split()) for line in text.splitlines() if line.strip()]

        assert found("1e-9")[1:] == ["exact 1.0e-14 3.00 us"]
        assert found("1e-2")[1:] == ["quick 1.0e-3 20.0 ns", "exact 1.0e-14 3.00 us"]
        assert [line.split()[0] for line in found("1e-2", "near")[1:]] == ["partial", "quick", "exact"]
        drawn = "[...document.querySelectorAll('#drawing circle')].map((c) => [c.textContent, c.getAttribute('fill')])"
        marks: Any = chromium.value(drawn)
        assert [text.split(":")[0].strip() for text, _ in marks] == ["exact", "quick", "lossy", "partial"]
        assert [fill == "none" for _, fill in marks] == [False, False, True, False]
        assert found("1e-30") == ["No method that was measured is so exact without losing an answer."]
        assert found("often") == ["Write the error as a number, such as 1e-9."]
        assert found("1", "", "second")[1:] == ["right 5.0e-1 4.00 ms"]
        assert chromium.value("document.getElementById('unit').textContent") == "radians"
        assert chromium.complaints() == [] and all(x.startswith("file:") for x in chromium.requests())
