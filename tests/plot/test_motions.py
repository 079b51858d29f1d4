"""Pictures of bivectors: orbits, parts of screws, fields of velocities."""

from __future__ import annotations

import numpy as np

from bladesmith import cga3d as cga
from bladesmith import pga3d as pga
from bladesmith import plot

from ..support.plot.artists import rng, strokes


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
