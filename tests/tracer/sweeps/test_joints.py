"""Points on the joints of pieces of curves: each once, of the lower piece, whatever the order pieces are asked in."""

from __future__ import annotations

import numpy as np
import pytest

from bladesmith import tracer
from bladesmith.codegen.programs.tracer.scene import TREE_PAYS
from bladesmith.curves import KochanekBartels

PIECES = TREE_PAYS + 2


@pytest.mark.slow
@pytest.mark.parametrize("closed", [False, True])
def test_points_on_joints_count_once_in_a_tree(closed):
    """Rays through points of the controls, along the curve and against it: a tree asks the nearer piece first."""
    angle = 2 * np.pi * np.arange(PIECES) / PIECES
    center = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    axis = np.stack([-np.sin(angle), np.cos(angle), 0 * angle], axis=1)
    surface = tracer.EvolvedCircles(
        KochanekBartels([(tuple(5 * c), tuple(a), 1.0) for c, a in zip(center, axis, strict=True)], closed=closed)
    )
    assert len(surface.parameters) >= TREE_PAYS
    for place in range(1, PIECES - 1):
        for turn in np.linspace(0.3, 6, 7):
            aim = 5 * center[place] + np.cos(turn) * center[place] + np.sin(turn) * np.array([0, 0, 1.0])
            for way in (axis[place] + 0.7 * center[place] + (0, 0, 0.2), (0.5, 0.9, 0.4)):
                origins, directions = aim - 3 * np.stack([way, -np.array(way)]), np.stack([way, -np.array(way)])
                found = surface.intersect(origins, directions)
                assert (np.isfinite(found.t).sum(axis=-1) == found.count).all()
                assert found.count[0] == found.count[1]
                for i in range(2):
                    points, rows = found.point[i, : found.count[i]], found.row[i, : found.count[i]]
                    near = np.linalg.norm(points - aim, axis=1) < 1e-5
                    assert near.sum() == 1 and rows[near] == place - 1
                    np.testing.assert_allclose(found.alpha[i, : found.count[i]][near], place, atol=1e-5)


def _ring(count: int, lean: float, rng: np.random.Generator):
    """Circles around an arc, and for each its middle, two axes in its plane and the one across."""
    angle = 2 * np.pi * np.arange(count) / PIECES
    center = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1) * rng.uniform(2, 8)
    axis = np.stack([-np.sin(angle), np.cos(angle), 0 * angle], axis=1) + lean * rng.normal(size=(count, 3))
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    first = np.cross(axis, rng.normal(size=(count, 3)))
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    radius = rng.uniform(0.7, 1.2, count)
    return center, axis, first, np.cross(axis, first), radius


def _rays_through(place, center, axis, first, second, radius, rng):
    """Rays exactly through points of the circles of some places, from far across to nearly in their planes."""
    turn, way = rng.uniform(0, 2 * np.pi, (2, len(place), 1))
    slant = 10 ** rng.uniform(-4, 0.5, (len(place), 1)) * rng.choice([-1, 1], (len(place), 1))
    u, v, out = first[place], second[place], axis[place]
    aim = center[place] + radius[place, None] * (np.cos(turn) * u + np.sin(turn) * v)
    along = np.cos(way) * u + np.sin(way) * v + slant * out
    return aim - 3 * along, along, aim


@pytest.mark.parametrize("lean", [0.0, 0.05, 0.2])
def test_a_root_beside_a_joint_is_not_lost(lean):
    """At the end of a piece f is only rounding for these rays, and its sign chance: on it hung the root next to it."""
    rng = np.random.default_rng(7)
    for count in (3, 4, 6, 8, 11):
        ring = _ring(count, lean, rng)
        center, axis, _, _, radius = ring
        surface = tracer.EvolvedCircles(
            KochanekBartels([(tuple(c), tuple(a), r) for c, a, r in zip(center, axis, radius, strict=True)])
        )
        place = rng.integers(1, count - 1, 300)
        origins, along, aim = _rays_through(place, *ring, rng)
        forwards = surface.intersect(origins, along)
        backwards = surface.intersect(2 * aim - origins, -along)
        beside = surface.intersect(origins + 1e-9 * axis[place], along)
        there = (forwards.status == 0) & (backwards.status == 0) & (beside.status == 0)
        assert there.sum() > 290
        np.testing.assert_array_equal(forwards.count[there], backwards.count[there])
        np.testing.assert_array_equal(forwards.count[there], beside.count[there])


def test_the_root_of_the_first_circle_stands_beside_others():
    """Rays through the first circle that meet the surface elsewhere too: every root is kept, that of the end first."""
    rng = np.random.default_rng(3)
    several = 0
    for _ in range(8):
        ring = _ring(4, 0.6, rng)
        center, axis, _, _, radius = ring
        controls = [(tuple(c), tuple(a), r) for c, a, r in zip(center, axis, radius, strict=True)]
        surface = tracer.EvolvedCircles(controls, align=True)
        place = np.zeros(400, int)
        origins, along, _ = _rays_through(place, *ring, rng)
        found = surface.intersect(origins, along)
        beside = [surface.intersect(origins + move * axis[place], along).count for move in (1e-9, -1e-9)]
        np.testing.assert_array_equal(found.count, np.maximum(*beside))  # on one side the end's root is gone
        several += int((found.count > 2).sum())
    assert several > 20
