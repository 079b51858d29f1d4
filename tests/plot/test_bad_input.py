"""Input of pictures at the limits of numbers, and what is refused."""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import cga3d as cga
from bladesmith import curves, errors, plot
from bladesmith import pga3d as pga

from ..support.plot.artists import marks, rng, strokes

SPIN, CIRCLE = cga.line([0, 0, 0], [0, 0, 1]).dual(), cga.circle([0, 0, 0], [0, 0, 1], 1.0)


def test_what_is_too_far_is_counted_and_draws_nothing() -> None:
    far = np.array([[1e300, 0, 0], [-1.7e308, 0, 0], [np.inf, 0, 0], [1.0, 2, 3]])
    ax = plot.draw(far, cga.sphere([0, 0, 0], 1e100), np.empty((0, 3)))
    assert plot.count_skipped(ax) == {"too far": 3, "not finite": 1}
    assert np.allclose(marks(ax)[0], [1, 2, 3])
    assert plot.count_skipped(plot.paths(np.array([[0, 0, 0], [1e200, 0, 0], [1, 1, 1]]))) == {}
    assert not list(plot.paths(np.empty((4, 0, 3))).collections)


def test_numbers_of_any_size_are_parameters_of_colours() -> None:
    rows = plot.palette.ramp([1.7e308, -1.7e308, 0.0])
    assert np.allclose(rows, plot.palette.ramp([1.0, -1.0, 0.0]))


def test_fields_of_any_strength_look_alike() -> None:
    points = np.append(rng().normal(size=(5, 3)), [[np.nan, 0, 0]], axis=0)
    expected = strokes(plot.twist_field(SPIN, points[:5]))[0]
    for strength in (1e-200, 1.0, 1e200):
        assert np.allclose(strokes(plot.twist_field(strength * SPIN, points))[0], expected)


def test_straight_orbits_are_as_fine_however_long() -> None:
    assert plot.orbit_paths(cga.direction([0, 0, 1.0]), [1, 0, 0], turns=1e9).shape == (1, 129, 3)
    assert plot.orbit_paths(SPIN, [1, 0, 0], turns=3).shape == (1, 385, 3)


def test_a_tuple_of_labels_is_a_list() -> None:
    legend = plot.draw(CIRCLE, SPIN.undual(), label=("a", "b")).get_legend()
    assert [text.get_text() for text in legend.get_texts()] == ["a", "b"]


@pytest.mark.parametrize(
    ("call", "error", "text"),
    [
        (lambda: plot.draw(), errors.InputError, "nothing to draw"),
        (lambda: plot.draw("circle"), errors.InputError, "a str cannot be drawn"),
        (lambda: plot.draw(np.zeros((4, 2))), errors.InputError, "last axis of 3"),
        (lambda: plot.draw(cga.scalar(2.0)), errors.InputError, "scalar"),
        (lambda: plot.draw(bs.algebra(3, 0, 0).e1), errors.InputError, "no pictures"),
        (lambda: plot.draw(cga.point([0, 0, 0]), color="nocolor"), errors.InputError, "not a valid color"),
        (lambda: plot.draw(cga.point([0, 0, 0]), color=3), errors.InputError, "not a valid color"),
        (lambda: plot.draw(cga.point(np.zeros((3, 3))), color=[0, 1]), errors.InputError, "2 entries for 3 items"),
        (lambda: plot.draw(cga.point([0, 0, 0]), label=["a", "b"]), errors.InputError, "2 entries for 1 things"),
        (lambda: plot.draw(cga.point([0, 0, 0]), extent=0.0), errors.InputError, "extent"),
        (lambda: plot.draw(cga.point([0, 0, 0]), extent=(1, 1)), errors.InputError, "extent"),
        (lambda: plot.draw(cga.point([0, 0, 0]), extent="wide"), errors.InputError, "extent"),
        (lambda: plot.draw(cga.point([0, 0, 0]), extent=(1, 2, 3)), errors.InputError, "extent"),
        (lambda: plot.draw(cga.point([0, 0, 0]), size=-1.0), errors.InputError, "size"),
        (lambda: plot.draw(cga.point([0, 0, 0]), ax="here"), errors.InputError, "an Axes3D is needed"),
        (lambda: plot.paths(np.zeros((3, 2))), errors.InputError, r"\(n, m, 3\)"),
        (lambda: plot.paths(np.zeros((3, 2, 3)), size=0), errors.InputError, "size"),
        (lambda: plot.panels(0, 2), errors.InputError, "panels"),
        (lambda: plot.save("x.png", "picture"), errors.InputError, "one of axes or a figure is needed"),
        (lambda: plot.save("x.nosuch", plot.axes()), errors.InputError, "nosuch"),
        (lambda: plot.orbit(cga.point([0, 0, 0])), errors.GradeError, "a bivector is needed"),
        (lambda: plot.orbit(3.0), errors.InputError, "a bivector is needed"),
        (lambda: plot.orbit(cga.direction([[1, 0, 0], [0, 1, 0]])), errors.InputError, "one finite bivector"),
        (lambda: plot.orbit(cga.direction([1, 0, 0]), [1, 2]), errors.InputError, r"3\) is needed"),
        (lambda: plot.orbit(cga.direction([1, 0, 0]), turns=0), errors.InputError, "turns"),
        (lambda: plot.screw(cga.direction([1, 0, 0])), errors.InputError, "no rotation"),
        (lambda: plot.twist_field(cga.direction([1, 0, 0]), pga.point([0, 0, 0])), errors.InputError, "pga3d"),
        (lambda: plot.twist_field(cga.direction([1, 0, 0]), count=0), errors.InputError, "count is 0"),
        (lambda: plot.twist_field(SPIN, count=2.5), errors.InputError, "count is 2.5"),
        (lambda: plot.twist_field(SPIN, count=10**6), errors.InputError, "count"),
        (lambda: plot.twist_field(SPIN, half_side=np.inf), errors.InputError, "half_side is inf"),
        (lambda: plot.orbit(SPIN, "abc"), errors.InputError, "points is 'abc'; real numbers"),
        (lambda: plot.orbit(SPIN, turns="a"), errors.InputError, "turns is 'a'; a positive number"),
        (lambda: plot.orbit(SPIN, turns=1e12), errors.InputError, "positions"),
        (lambda: plot.orbit_paths(SPIN, samples=2.5), errors.InputError, "samples is 2.5"),
        (lambda: plot.draw(CIRCLE, size="a"), errors.InputError, "size is 'a'; a positive number"),
        (lambda: plot.draw(CIRCLE, size=[1, 2]), errors.InputError, "size has shape"),
        (lambda: plot.draw(CIRCLE, opacity=2), errors.InputError, "opacity is 2"),
        (lambda: plot.draw(CIRCLE, opacity=None), errors.InputError, "opacity"),
        (lambda: plot.draw(CIRCLE, samples=0), errors.InputError, "samples is 0"),
        (lambda: plot.draw(CIRCLE, view=5), errors.InputError, "view is 5"),
        (lambda: plot.draw(CIRCLE, view=("a", "b")), errors.InputError, "view holds"),
        (lambda: plot.draw(CIRCLE, extent=1e300), errors.InputError, "extent"),
        (lambda: plot.draw(CIRCLE, extent=1j), errors.InputError, "extent"),
        (lambda: plot.draw(CIRCLE, color=[[1, 0, 0], "red"]), errors.InputError, "2 entries for 1 items"),
        (lambda: plot.draw(curves.Bezier), errors.InputError, "cannot be drawn"),
        (lambda: plot.paths([[0, 0, 0], [0, 0]]), errors.InputError, "ragged"),
        (lambda: plot.paths(cga.point([[0, 0, 0]])), errors.InputError, "positions: a multivector is not an array"),
        (lambda: plot.panels(1.5, 1), errors.InputError, "rows of panels"),
        (lambda: plot.panels(1, 1, size=(np.nan, 1)), errors.InputError, "size"),
        (lambda: plot.axes(size=(0, 1)), errors.InputError, "size"),
        (lambda: plot.axes(view=5), errors.InputError, "view is 5"),
        (lambda: plot.save(None, plot.axes()), errors.InputError, "None names none"),
        (lambda: plot.save("x.png", plot.axes(), dpi=0), errors.InputError, "dpi is 0"),
    ],
)
def test_bad_input_is_refused(call: Any, error: type[Exception], text: str) -> None:
    with pytest.raises(error, match=text):
        call()


def test_without_matplotlib_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("mpl_toolkits.mplot3d.axes3d", "matplotlib.colors"):
        monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(errors.MissingExtraError, match=r"bladesmith\[plot\]"):
        plot.draw(cga.point([0, 0, 0]))
