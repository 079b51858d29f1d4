"""Pictures of objects: each is drawn where geometry says, at any scale and in either precision."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import cga3d as cga
from bladesmith import pga3d as pga
from bladesmith import plot
from bladesmith.plot import tessellation
from bladesmith.plot.tessellation import Box

from ..support.plot.artists import faces, limits, marks, rng, strokes

CUBE = Box(np.full(3, -1.0), np.full(3, 1.0))


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
