"""Pictures: what artists are made of, views, statuses, motions and fields; no window, no global state."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import cga3d as cga
from bladesmith import curves, errors, plot
from bladesmith import pga3d as pga
from bladesmith.plot import palette, tessellation
from bladesmith.plot.tessellation import Box

from ..support.checkout import CHECKOUT

art3d = pytest.importorskip("mpl_toolkits.mplot3d.art3d")
CUBE = Box(np.full(3, -1.0), np.full(3, 1.0))
#: Pictures stay small enough for a page of many.
MOST_BYTES = 120 * 1024


def rng(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


def strokes(ax: Any) -> list[np.ndarray]:
    """Polylines of each collection of lines."""
    return [np.asarray(c._segments3d) for c in ax.collections if isinstance(c, art3d.Line3DCollection)]


def faces(ax: Any) -> list[Any]:
    return [c for c in ax.collections if isinstance(c, art3d.Poly3DCollection)]


def marks(ax: Any) -> list[np.ndarray]:
    dots = [c for c in ax.collections if isinstance(c, art3d.Path3DCollection)]
    return [np.stack([np.asarray(x) for x in c._offsets3d], -1) for c in dots]


def limits(ax: Any) -> np.ndarray:
    return np.array([ax.get_xlim3d(), ax.get_ylim3d(), ax.get_zlim3d()])


# -- objects ---------------------------------------------------------------------------------------------------


def test_sampled_circles_are_on_their_circles() -> None:
    center, normal = rng().normal(size=(2, 7, 3))
    radius = rng(1).uniform(0.1, 3, size=7)
    (rings,) = strokes(plot.draw(cga.circle(center, normal, radius)))
    unit = normal / np.linalg.norm(normal, axis=-1, keepdims=True)
    away = rings - center[:, None]
    assert len(rings) == 7 and rings.shape[1] > 64
    assert np.abs(np.linalg.norm(away, axis=-1) - radius[:, None]).max() < 1e-12
    assert np.abs((away * unit[:, None]).sum(-1)).max() < 1e-12
    turn = np.cross(away[:, :-1], away[:, 1:])  # counter-clockwise about the normal, once around
    assert ((turn * unit[:, None]).sum(-1) > 0).all()
    assert np.allclose(rings[:, 0], rings[:, -1], atol=1e-12)


def test_of_large_circles_the_arc_in_view_is_sampled() -> None:
    radius = 1000.0
    ax = plot.draw(cga.circle([radius, 0.3, 0], [0, 0, 1], radius), extent=1.0)
    (arc,) = strokes(ax)
    seen = arc[0][np.isfinite(arc[0]).all(-1)]
    assert np.abs(np.linalg.norm(seen - [radius, 0.3, 0], axis=-1) - radius).max() < 1e-9
    assert len(seen) > 40 and np.ptp(seen[:, 1]) > 1.9 and (np.diff(seen[:, 1]) < 0).all()  # counter-clockwise


def test_points_and_flat_points_are_marks_at_their_places() -> None:
    xyz = rng().normal(size=(2, 3, 3))
    ax = plot.draw(cga.point(xyz[0]), cga.flat_point(xyz[1]), pga.point(xyz[0]), xyz[0])
    for found, expected in zip(marks(ax), xyz[[0, 1, 0, 0]], strict=True):
        assert np.allclose(found, expected, atol=1e-12)


def test_point_pairs_are_segments_with_ends() -> None:
    a, b = rng().normal(size=(2, 5, 3))
    ax = plot.draw(cga.point_pair(a, b))
    (segments,), (ends,) = strokes(ax), marks(ax)
    assert np.allclose(segments, np.stack([a, b], 1), atol=1e-12)
    assert np.allclose(ends, segments.reshape(-1, 3)) and len(ends) == 10


@pytest.mark.parametrize("algebra", [cga, pga], ids=["cga3d", "pga3d"])
def test_lines_are_cut_by_the_view(algebra: Any) -> None:
    point, direction = rng().uniform(-1, 1, size=(2, 50, 3))
    ax = plot.draw(algebra.line(point, direction), extent=1.0)
    (segments,) = strokes(ax)
    assert len(segments) == 50 and np.allclose(np.abs(segments).max(-1), 1.0)
    off = np.cross(segments - point[:, None], direction[:, None])
    assert np.abs(off).max() < 1e-12
    forward = ((segments[:, 1] - segments[:, 0]) * direction).sum(-1)
    assert (forward > 0).all()


@pytest.mark.parametrize("algebra", [cga, pga], ids=["cga3d", "pga3d"])
def test_planes_are_the_cuts_of_the_view(algebra: Any) -> None:
    normal, offset = rng().normal(size=(40, 3)), rng(1).uniform(-0.5, 0.5, 40)
    unit = normal / np.linalg.norm(normal, axis=-1, keepdims=True)
    ax = plot.draw(algebra.plane(unit, offset), extent=1.0)
    (outlines,) = strokes(ax)
    assert len(outlines) == 40 and len(faces(ax)) == 1
    assert np.abs((outlines * unit[:, None]).sum(-1) - offset[:, None]).max() < 1e-12
    assert np.allclose(np.abs(outlines).max(-1), 1.0)
    # the polygon's area is what a fine sum over the plane counts inside the cube
    u, v = tessellation.across(unit)
    grid = (np.arange(400) + 0.5) / 400 * 4 - 2
    x, y = np.meshgrid(grid, grid)
    for i in range(4):
        places = unit[i] * offset[i] + x[..., None] * u[i] + y[..., None] * v[i]
        counted = (np.abs(places) <= 1).all(-1).sum() * (4 / 400) ** 2
        ring = outlines[i]
        area = np.linalg.norm(np.cross(ring[:-1] - ring[0], ring[1:] - ring[0]).sum(0)) / 2
        assert abs(area - counted) < 0.05


def test_spheres_are_surfaces_or_wires() -> None:
    center, radius = rng().normal(size=(3, 3)), np.array([0.5, 1.0, 2.0])
    spheres = cga.sphere(center, radius)
    ax = plot.draw(spheres)
    (mesh,) = faces(ax)
    corners = np.asarray(mesh._faces).reshape(3, -1, 3)
    assert np.abs(np.linalg.norm(corners - center[:, None], axis=-1) - radius[:, None]).max() < 1e-12
    assert np.ptp(mesh.get_facecolor()[:, :3], axis=0).max() > 0.1  # shaded
    wires = plot.draw(spheres, surface=False)
    assert not faces(wires) and len(strokes(wires)[0]) == 9
    many = plot.draw(cga.sphere(rng().normal(size=(100, 3)), 0.1))
    assert not faces(many) and len(strokes(many)[0]) == 300


def test_duals_of_planes_and_spheres_are_drawn() -> None:
    ax = plot.draw(cga.sphere([1, 2, 3], 2.0).dual(), cga.plane([0, 0, 1], 2.0).dual())
    assert len(faces(ax)) == 2
    assert np.allclose(limits(ax).mean(1), [1, 2, 3], atol=0.1)


def test_motors_are_frames() -> None:
    motor = cga.translator([1, 2, 3]) * cga.rotor([0, 0, 1], np.pi / 2)
    moved = pga.translator([1, 2, 3]) * pga.rotor([0, 0, 1], np.pi / 2)
    for x in (motor, moved):
        (axes,) = strokes(plot.draw(x))
        assert np.allclose(axes[:, 0], [1, 2, 3])
        step = axes[:, 1] - axes[:, 0]
        assert np.allclose(step / np.linalg.norm(step[0]), [[0, 1, 0], [-1, 0, 0], [0, 0, 1]], atol=1e-12)
    (scaled,) = strokes(plot.draw(cga.dilator([1.0, 2.0])))
    lengths = np.linalg.norm(scaled[:, 1] - scaled[:, 0], axis=-1)
    assert np.allclose(lengths[3:], 2 * lengths[:3])


def test_directions_are_arrows_from_the_middle() -> None:
    ax = plot.draw(cga.direction([[1, 0, 0], [0, 2, 0]]), extent=3.0)
    (arrows,) = strokes(ax)
    assert np.allclose(arrows[:, 0], 0) and np.allclose(arrows[:, 1], [[1, 0, 0], [0, 2, 0]])


@pytest.mark.parametrize(
    "x",
    [
        cga.circle([0, 0, 0], [0, 0, 1], 1.0), cga.line([0, 0, 0], [0, 0, 1]), cga.plane([0, 0, 1], 0.0),
        cga.sphere([0, 0, 0], 1.0), cga.point_pair([0, 0, 0], [1, 1, 1]),
    ],
    ids=lambda x: x.kind.name,
)  # fmt: skip
def test_orientation_turns_with_the_object(x: bs.Multivector) -> None:
    plain, ahead, back = (plot.draw(y, orientation=o) for y, o in ((x, False), (x, True), (-x, True)))
    assert len(strokes(ahead)) > len(strokes(plain)) and len(strokes(back)) == len(strokes(ahead))
    tips = [strokes(ax)[-1][0, 1] - strokes(ax)[-1][0, 0] for ax in (ahead, back)]
    assert tips[0] @ tips[1] < 0


def test_sums_of_unknown_kind_are_sorted_out_item_by_item() -> None:
    circle, line = cga.circle([0, 0, 1], [0, 0, 1], 2.0), cga.line([0, 0, 0], [1, 0, 0])
    mixed = cga.multivector(np.stack([circle.values, line.as_kind("circle").values, np.ones(10)]), grades=[3])
    ax = plot.draw(3.0 * mixed)
    assert sorted(len(s[0]) for s in strokes(ax)) == [2, 129]
    assert plot.count_skipped(ax) == {"not a blade": 1}


@pytest.mark.compiles
def test_scale_and_precision_do_not_matter() -> None:
    circle = cga.circle([1, 0, 0], [0, 0, 1], 2.0)
    single = cga.circle(np.float32([1, 0, 0]), np.float32([0, 0, 1]), np.float32(2))
    assert single.dtype == np.float32
    ax = plot.draw(1e-200 * circle, -1e200 * circle, single)
    for rings in strokes(ax):
        assert np.abs(np.linalg.norm(rings - [1, 0, 0], axis=-1) - 2).max() < 1e-6
    assert len(strokes(ax)) == 3


def test_items_without_a_picture_are_counted() -> None:
    spheres = cga.sphere(np.zeros((4, 3)), [1.0, -1.0, np.nan, 2.0])
    imaginary = (cga.line([0, 0, 2], [1, 0, 0]) & cga.sphere([0, 0, 0], 1.0)).normalized()
    ax = plot.draw(spheres, imaginary, np.array([[0.0, 0, 0], [np.nan, 0, 0]]))
    assert len(np.asarray(faces(ax)[0]._faces)) == 2 * 24 * 48
    assert sum(plot.count_skipped(ax).values()) == 4 and plot.count_skipped(ax)["INVALID"] == 2
    assert np.isfinite(limits(ax)).all()


def test_nothing_but_items_without_a_picture(tmp_path: Path) -> None:
    ax = plot.draw(cga.sphere([0, 0, 0], [-1.0, -2.0]), cga.point(np.empty((0, 3))))
    assert not ax.collections and plot.count_skipped(ax) == {"INVALID": 2}
    plot.save(tmp_path / "empty.png", ax)


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


# -- motions ---------------------------------------------------------------------------------------------------


def test_orbits_of_a_dual_line_are_circles_about_it() -> None:
    line = cga.line([1, 0, 0], [0, 0, 1])
    paths = plot.orbit_paths(line.dual(), [[0, 0, 0], [3, 0, 1]])
    away = paths - [1, 0, 0]
    assert np.allclose(np.hypot(away[..., 0], away[..., 1]), [[1], [2]], atol=1e-12)
    assert np.allclose(paths[..., 2], [[0], [1]], atol=1e-12)
    assert np.allclose(paths[:, 0], paths[:, -1], atol=1e-12) and np.ptp(paths[0, :, 0]) > 1.99
    half = plot.orbit_paths(line.dual(), [0, 0, 0], turns=0.5)
    assert np.allclose(half[0, -1], [2, 0, 0], atol=1e-12)
    ax = plot.orbit(line.dual(), [[0, 0, 0], [3, 0, 1]])
    assert np.allclose(strokes(ax)[0], paths)


def test_orbits_of_pga_are_those_of_cga() -> None:
    there = plot.orbit_paths(pga.line([1, 0, 0], [0, 1, 1]), [0, 0, 0])
    here = plot.orbit_paths(cga.line([1, 0, 0], [0, 1, 1]).dual(), [0, 0, 0])
    assert np.allclose(there, here, atol=1e-12) and np.ptp(there) > 1


def test_orbits_of_a_dual_circle_link_it_and_of_a_pair_join_its_ends() -> None:
    circle = cga.circle([0, 0, 0], [0, 0, 1], 1.0)
    (ring,) = plot.orbit_paths(circle.dual(), [0.5, 0, 0])
    middle = (ring.max(0) + ring.min(0)) / 2
    assert np.allclose(np.linalg.norm(ring - middle, axis=-1), 0.75, atol=1e-3)
    assert np.allclose(ring[:, 1], 0, atol=1e-12)
    (arc,) = plot.orbit_paths(cga.point_pair([-1, 0, 0], [1, 0, 0]), [0, 0.5, 0])
    assert {round(float(arc[0, 0])), round(float(arc[-1, 0]))} == {-1, 1}


def test_orbits_of_a_direction_are_straight() -> None:
    (path,) = plot.orbit_paths(cga.direction([0.5, 0, 0]), [0, 0, 0], turns=2.0)  # exp(t n_inf) translates by -2 t
    assert np.allclose(path[-1], [-2, 0, 0]) and np.allclose(path[:, 1:], 0)


def test_the_parts_of_a_screw_commute_and_add_up() -> None:
    one, two = cga.line([1, 0, 0], [0, 0.3, 1]), cga.line([0, 1, 0], [0.5, 0, 1])
    total = one.dual() + two.dual()
    rotation, translation = plot.screw_parts(total)
    assert np.abs(rotation.values).max() > 0.5 and np.abs(translation.values).max() > 0.05
    assert (rotation + translation).isclose(total)
    assert np.abs((rotation * translation - translation * rotation).values).max() < 1e-14
    axis = rotation.undual().normalized("line")
    assert cga.classify(axis) == "line" and np.abs((translation * translation).values).max() < 1e-14
    moved = (0.7 * total).exp() >> axis
    assert moved.isclose(axis)
    ax = plot.screw(total, [0, 0, 0], turns=2.0)
    assert len(ax.collections) == 4
    there = pga.line([1, 0, 0], [0, 0.3, 1]) + pga.line([0, 1, 0], [0.5, 0, 1])
    for found, expected in zip(strokes(plot.screw(there)), strokes(ax), strict=True):
        assert np.allclose(found, expected, atol=1e-12)
    motion = plot.orbit_paths(total, [0, 0, 0], turns=2.0)[0]
    assert np.allclose(motion[-1], strokes(ax)[2][0, -1])  # after whole turns only the translation is left


def test_velocities_are_those_of_a_rigid_body() -> None:
    spin, rise, xyz = np.array([0.3, -0.2, 0.9]), np.array([0.1, 0.5, -0.4]), rng().normal(size=(20, 3))
    expected = rise + np.cross(spin, xyz)
    e1, e2, e3 = (cga.multivector({f"e{i}": 1.0}) for i in (1, 2, 3))
    i3 = e1 * e2 * e3
    vector = [v[0] * e1 + v[1] * e2 + v[2] * e3 for v in (spin, rise)]
    twist = (vector[0] * i3 + vector[1] * cga.ni).grade(2)
    assert np.allclose(plot.velocities(twist, xyz), expected, atol=1e-13)
    p1, p2, p3 = (pga.multivector({f"e{i}": 1.0}) for i in (1, 2, 3))
    there = [v[0] * p1 + v[1] * p2 + v[2] * p3 for v in (spin, rise)]
    same = (there[0] * p1 * p2 * p3 + there[1] * pga.multivector({"e0": 1.0})).grade(2)
    assert np.allclose(plot.velocities(same, xyz), expected, atol=1e-13)
    # the orbits of a field's picture follow it
    path = plot.orbit_paths(-0.5 * twist, xyz[0], samples=4096)[0]
    step = path[1] - path[0]
    assert np.linalg.norm(np.cross(step, expected[0])) < 1e-3 * np.linalg.norm(step) * np.linalg.norm(expected[0])
    assert step @ expected[0] > 0


def test_fields_are_one_collection_of_arrows() -> None:
    ax = plot.twist_field(cga.direction([0, 0, 1.0]), count=4)
    (arrows,) = strokes(ax)
    assert arrows.shape[:2] == (64, 9)
    assert np.allclose(arrows[:, 1] - arrows[:, 0], (arrows[:, 1] - arrows[:, 0])[0])  # uniform
    ax = plot.twist_field(cga.line([0, 0, 0], [0, 0, 1]).dual(), [[1, 0, 0]], orbits=True)
    orbits, arrows = strokes(ax)
    middle = (arrows[:, 0] + arrows[:, 1]) / 2
    assert len(orbits) == 1 and len(arrows) >= 12 and np.allclose(np.linalg.norm(middle, axis=-1), 1, atol=1e-9)


# -- what is refused -------------------------------------------------------------------------------------------


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


# -- the gallery -----------------------------------------------------------------------------------------------


def test_the_gallery_shows_what_its_examples_save() -> None:
    text = (CHECKOUT / "docs" / "gallery.md").read_text(encoding="utf-8")
    shown = re.findall(r"!\[[^\]]+\]\(images/gallery/(\w+\.png)\)", text)
    saved = re.findall(r'^plot\.save\("(\w+\.png)"', text, re.MULTILINE)
    kept = sorted(path.name for path in (CHECKOUT / "docs" / "images" / "gallery").iterdir())
    assert shown == saved and sorted(shown) == kept


@pytest.mark.parametrize("path", sorted((CHECKOUT / "docs" / "images" / "gallery").glob("*.png")), ids=lambda p: p.stem)
def test_pictures_of_the_gallery_are_small_and_not_empty(path: Path) -> None:
    image = pytest.importorskip("PIL.Image").open(path)
    assert path.stat().st_size <= MOST_BYTES and 800 <= image.width <= 960
    ink = (np.asarray(image.convert("L")) < 200).mean()
    assert 0.005 < ink < 0.7
    assert not (np.asarray(image.convert("L"))[[0, -1]] < 200).any()  # nothing is cut off above or below
    assert not (np.asarray(image.convert("L"))[:, [0, -1]] < 200).any()
