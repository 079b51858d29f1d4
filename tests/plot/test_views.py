"""Pictures of sets and curves, colours, legends, and the view that holds them."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import cga3d as cga
from bladesmith import plot
from bladesmith.plot import palette, tessellation

from ..support.plot.artists import faces, limits, rng, strokes

# -- sets, curves, colours -------------------------------------------------------------------------------------


def test_a_large_set_of_lines_is_one_collection() -> None:
    lines = cga.line(rng().normal(size=(100_000, 3)), rng(1).normal(size=(100_000, 3)))
    ax = plot.draw(lines, size=0.1)
    assert len(ax.collections) == 1 and len(strokes(ax)[0]) == 100_000


def test_a_list_of_mixed_kinds_is_one_set_with_its_colours() -> None:
    objects = [cga.line([0, 0, 0], [1, 0, 0]), cga.circle([0, 0, 0], [0, 0, 1], [1.0, 2.0]), cga.point([1, 1, 1])]
    ax = plot.draw(objects, color=[0, 1, 1, 2])
    table = palette.classes([0, 1, 2])
    circles = next(c for c in ax.collections if len(np.asarray(c._segments3d)) == 2)
    assert np.allclose(circles.get_colors(), table[1]) and len(ax.collections) == 3
    assert np.allclose(ax.collections[-1].get_facecolor(), table[2])


def test_a_parameter_goes_from_green_to_red() -> None:
    rows = palette.per_item(np.array([0.0, 0.5, 1.0, np.nan]), 4, "k")
    assert np.allclose(rows, [palette._to_rgba(c) for c in (*palette.RAMP, palette.GREY)])
    assert np.allclose(palette.per_item("#ff0000", 5, "k"), [[1, 0, 0, 1]])
    assert np.allclose(palette.per_item((0.1, 0.2, 0.3), 3, "k"), [[0.1, 0.2, 0.3, 1]])
    assert np.allclose(palette.per_item(["k", "w"], 2, "k")[:, 0], [0, 1])
    assert palette.per_item(np.array([-1]), 1, "k")[0, 0] == palette._to_rgba(palette.GREY)[0]


def test_curves_are_families_with_a_ramp_and_point_curves_polylines() -> None:
    curve = bs.curves.Bezier(cga.circle([[0, 0, 0], [0, 0, 1], [1, 0, 2]], [0, 0, 1], [1.0, 0.5, 1.0]))
    ax = plot.draw(curve, samples=20)
    (rings,) = strokes(ax)
    assert len(rings) == 21
    shown = ax.collections[0].get_colors()
    assert np.allclose(shown[0], palette.per_item(palette.GREEN, 1, "")[0])
    assert np.allclose(shown[-1], palette.per_item(palette.RED, 1, "")[0])

    class Path:
        domain = (2.0, 4.0)

        def __call__(self, t: Any) -> bs.Multivector:
            return cga.point(np.stack([t, t * t, 0 * t], -1))

    (path,) = strokes(plot.draw(Path(), samples=10))
    assert path.shape == (1, 11, 3)
    assert np.allclose(path[0, :, 1], path[0, :, 0] ** 2) and np.allclose(path[0, [0, -1], 0], [2, 4])


def test_polylines_are_one_collection() -> None:
    corners = rng().normal(size=(1000, 2, 3))
    ax = plot.paths(corners, color=np.arange(1000.0))
    assert len(ax.collections) == 1 and np.allclose(strokes(ax)[0], corners)
    assert len(ax.collections[0].get_colors()) == 1000
    plot.paths(np.stack([np.arange(5), np.arange(5), np.arange(5)], -1), ax=ax)
    plot.paths(np.empty((0, 2, 3)), ax=ax)
    plot.paths(np.full((3, 2, 3), np.nan), ax=ax)
    assert not plot.paths(np.full((2, 3), np.nan)).collections
    assert len(ax.collections) == 2 and (limits(ax)[:, 1] >= 4).all()


def test_legend_has_an_entry_for_each_label() -> None:
    ax = plot.draw(cga.point([0, 0, 0]), cga.sphere([0, 0, 0], 1.0), label=["centre", "sphere"])
    plot.draw(cga.line([0, 0, 0], [1, 0, 0]), ax=ax, label="axis")
    assert [t.get_text() for t in ax.get_legend().get_texts()] == ["centre", "sphere", "axis"]


# -- views -----------------------------------------------------------------------------------------------------


def test_the_view_holds_everything_finite_with_equal_units() -> None:
    ax = plot.draw(cga.sphere([5, 0, 0], 1.0), cga.circle([0, 0, 0], [0, 0, 1], 2.0), cga.line([0, 9, 0], [1, 0, 0]))
    box = limits(ax)
    assert (box[:, 0] <= [-2, -2, -1]).all() and (box[:, 1] >= [6, 9, 1]).all()
    sides = box[:, 1] - box[:, 0]
    aspect = np.asarray(ax._box_aspect)
    assert np.allclose(aspect / aspect[0], sides / sides[0])


def test_lines_and_planes_follow_a_view_that_grows() -> None:
    ax = plot.draw(cga.line([0, 0, 0], [1, 0, 0]), cga.plane([0, 0, 1], 0.0))
    before = np.ptp(strokes(ax)[0])
    plot.draw(cga.sphere([0, 0, 0], 20.0), ax=ax)
    assert np.ptp(strokes(ax)[0][0, :, 0]) >= 40 > before
    assert len(strokes(ax)) == 3 and len(faces(ax)) == 2  # redrawn, not added


def test_lines_alone_are_seen_where_they_pass_each_other() -> None:
    center = np.array([100.0, 50.0, 0.0])
    direction = rng().normal(size=(30, 3))
    ax = plot.draw(cga.line(center + rng(1).uniform(-1, 1, (30, 3)), direction))
    box = limits(ax)
    assert (box[:, 0] < center).all() and (center < box[:, 1]).all() and np.ptp(box, axis=1).max() < 6
    parallel = limits(plot.draw(cga.line([[0, 0, 0], [0, 3, 0]], [1, 0, 0])))
    assert parallel[1, 0] <= 0 and parallel[1, 1] >= 3


@pytest.mark.parametrize("extent", [2.0, (-2.0, 2.0), ([-2, -2, -2], [2, 2, 2])])
def test_a_given_view_stays(extent: Any) -> None:
    ax = plot.draw(cga.line([5, 0, 0], [0, 0, 1]), cga.line([0, 0, 0], [0, 0, 1]), extent=extent)
    plot.draw(cga.sphere([9, 9, 9], 1.0), ax=ax)
    assert np.allclose(limits(ax), [[-2, 2]] * 3)
    assert [len(s) for s in strokes(ax)] == [1]  # the other line and the sphere are not in it
    assert not faces(ax)


def test_the_box_fills_the_page() -> None:
    from mpl_toolkits.mplot3d import proj3d

    for view in ((20, -60), (5, 10), (80, 45)):
        ax = plot.draw(cga.sphere([0, 0, 0], [1.0, 0.2]), view=view)
        ax.figure.draw_without_rendering()
        box = limits(ax)
        x, y, _ = proj3d.proj_transform(*(box[:, 0] + tessellation.CORNERS * np.ptp(box, axis=1)).T, ax.get_proj())
        place = ax.transData.transform(np.stack([x, y], -1)) / [ax.figure.bbox.width, ax.figure.bbox.height]
        assert (place > 0).all() and (place < 1).all()
        assert 0.7 < np.ptp(place, axis=0).max() <= 1


def test_users_go_on_with_axes_of_their_own(tmp_path: Path) -> None:
    from matplotlib.figure import Figure

    figure = Figure()
    left, right = (figure.add_subplot(1, 2, i, projection="3d") for i in (1, 2))
    assert plot.draw(cga.sphere([0, 0, 0], 1.0), ax=left) is left
    plot.draw(cga.circle([0, 0, 0], [0, 0, 1], 1.0), ax=right, view=(90, 0))
    right.set_title("from above")
    plot.save(tmp_path / "two.png", figure)
    assert (tmp_path / "two.png").stat().st_size > 5000
    assert left.get_position().x1 < right.get_position().x0


@pytest.mark.slow
def test_no_window_and_no_global_state() -> None:
    code = (
        "import sys, json; from bladesmith import plot, cga3d as cga\n"
        "early = 'matplotlib' in sys.modules\n"
        "plot.save('/dev/null', plot.draw(cga.sphere([0, 0, 0], 1.0)).figure) if False else None\n"
        "import io; plot.draw(cga.sphere([0, 0, 0], 1.0)).figure.savefig(io.BytesIO())\n"
        "print(json.dumps([early, 'matplotlib.pyplot' in sys.modules]))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert json.loads(done.stdout) == [False, False]
