"""Pictures of studies: units of time, names of settings, and fractions against what is promised."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from bladesmith.benchmarks.harness import plot
from bladesmith.benchmarks.harness.runner import Measurement, time_text, time_unit
from bladesmith.benchmarks.harness.study import Case, Study, setting_text
from bladesmith.benchmarks.harness.write import plot as write_plot


def study(**options):
    return Study("s", "S", (), (Case("c", lambda rng, n: None),), lambda x: x, lambda a, b, c: a, "units", **options)


def row(time=1.0, error=1e-3, lost=0, case="c", method="m", count=200):
    return Measurement(method, "n", "", case, "ordinary", count, error, "", lost, "", time, "")


@pytest.mark.parametrize(
    ("times", "name", "size"),
    [
        ([3.0], "ns", 1.0), ([0.02], "ns", 1.0), ([0.2, 999.0, 5.0], "ns", 1.0), ([1e3], "us", 1e3),
        ([2.5e6, 3e6, 4.0], "ms", 1e6), ([1e6, 2e6, 9e9], "ms", 1e6), ([4e9], "s", 1e9), ([1e13], "s", 1e9),
    ],
)  # fmt: skip
def test_the_middle_time_chooses_the_unit(times, name, size):
    assert time_unit(times) == (name, size)


def test_times_are_told_with_their_unit():
    told = [time_text(t) for t in (12.34, 1234.0, 4.5678e6, 7.8e9)]
    assert told == ["12.3 ns", "1.23 us", "4.57 ms", "7.8 s"]


@pytest.mark.slow
@pytest.mark.parametrize(("scale", "name"), [(1.0, "ns"), (1e3, "us"), (1e6, "ms"), (1e9, "s")])
def test_all_panels_of_a_picture_have_one_unit(scale, name):
    rows = [row(2 * scale), row(30 * scale, case="d"), row(5 * scale, error=float("nan"), lost=200, case="d")]
    panels = plot.draw(study(), rows).axes
    assert [panel.get_xlabel() for panel in panels] == [f"{name} per item"] * 2
    drawn = [[x for line in panel.lines for x in line.get_xdata()] for panel in panels]
    assert drawn[0] == pytest.approx([2, 2]) and sorted(drawn[1]) == pytest.approx([5, 30, 30])
    for panel, xs in zip(panels, drawn, strict=True):
        low, high = panel.get_xlim()
        assert low < min(xs) and max(xs) < high


@pytest.mark.parametrize(
    ("knob", "setting", "text"),
    [
        ("iterations", 5, "5 iterations"), ("samples", 64, "64 samples"), ("step", 1e-3, "step 0.001"),
        ("tolerance", 1e-8, "tolerance 1e-08"), ("precision", "float32", "float32"), ("steps", None, ""),
    ],
)  # fmt: skip
def test_settings_have_their_name(knob, setting, text):
    assert setting_text(knob, setting) == text


def test_legends_name_the_settings():
    plain = row(method="plain")
    points = [replace(row(method="newton"), knob="iterations", setting=n) for n in ("5", "10")]
    figure = plot.draw(study(), [plain, *points])
    assert legend_of(figure) == ["plain", "newton (iterations)"]
    assert [label.get_text() for label in figure.axes[0].texts] == ["5", "10"]
    swept = [replace(r, sweep="distance", value=x) for r in (plain, *points) for x in (0.1, 1.0)]
    names = ["plain", "newton, 5 iterations", "newton, 10 iterations"]
    assert legend_of(plot.draw_sweeps(study(), swept)) == names


def legend_of(figure):
    return [text.get_text() for text in figure.legends[0].get_texts()]


@pytest.mark.slow
@pytest.mark.parametrize(("hits", "count"), [(190, 200), (200, 200), (0, 10), (1, 3), (9_500, 10_000)])
def test_intervals_of_fractions(hits, count):
    stats = pytest.importorskip("scipy.stats")
    wanted = stats.binomtest(hits, count).proportion_ci(0.95, "wilson")
    assert plot._interval(hits, count) == pytest.approx((hits / count, wanted.low, wanted.high), abs=1e-6)


def test_a_picture_of_fractions_tells_which_cases_keep_the_promise(tmp_path):
    rows = [row(lost=10, case="right"), row(lost=1, case="too wide"), row(lost=40, case="too narrow")]
    figure = plot.draw_fractions(study(promised=0.95), rows)
    (panel,) = figure.axes
    assert [t.get_text() for t in panel.get_yticklabels()] == ["right", "too wide", "too narrow"]
    points = [line for line in panel.lines if line.get_marker() == "o"]
    assert [float(line.get_xdata()[0]) for line in points] == pytest.approx([95, 99.5, 80])
    assert [line.get_color() for line in points] == ["C0", "C3", "C3"]
    spans = [line.get_xdata() for line in panel.lines if line.get_marker() != "o" and line.get_linestyle() == "-"]
    assert [low <= 95 <= high for low, high in spans] == [True, False, False]
    assert [t.get_text() for t in panel.texts] == ["95.0 % (190 of 200)", "99.5 % (199 of 200)", "80.0 % (160 of 200)"]
    write_plot(study(promised=0.95), rows, tmp_path / "p.png")  # is the picture of a study that promises
    figure.savefig(tmp_path / "q.png")
    assert (tmp_path / "p.png").read_bytes() == (tmp_path / "q.png").read_bytes()


def test_errors_without_a_height_are_drawn_at_the_top(tmp_path):
    """Infinite and NaN, though not counted as lost, and the largest numbers: a logarithmic axis has no such limits."""
    rows = [row(error=e, method=m) for m, e in zip("abcd", (math.inf, math.nan, 1.7e308, 1e-3), strict=True)]
    figure = plot.draw(study(), rows)
    figure.savefig(tmp_path / "all.png")
    crosses = [line for line in figure.axes[0].lines if line.get_marker() == "x"]
    assert len(crosses) == 2 and (tmp_path / "all.png").stat().st_size > 1000
    plot.draw(study(), rows[:1]).savefig(tmp_path / "one.png")
